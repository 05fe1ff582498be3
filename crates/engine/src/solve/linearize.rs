//! Linear models `ẋ = Ax + Bu`, `y = Cx + Du` from the matrices of second-order equations, NOTATION eq. (L12).

use crate::solve::lagged::Lagged;
use nalgebra::DMatrix;

/// `M δq̈ + C δq̇ + K δq = −∂r/∂u δu` about a state, over the degrees of freedom.
#[derive(Debug, Clone, PartialEq)]
pub struct SecondOrder {
    /// Mass matrix `M`.
    pub mass: DMatrix<f64>,
    /// `C`: damping, gyroscopic terms.
    pub damping: DMatrix<f64>,
    /// `K`: exact tangent.
    pub stiffness: DMatrix<f64>,
}

/// Derivatives of the outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputSlopes {
    /// With respect to the coordinates.
    pub position: DMatrix<f64>,
    /// With respect to their rates.
    pub rate: DMatrix<f64>,
    /// With respect to the inputs, at given accelerations.
    pub input: DMatrix<f64>,
}

/// A linear model; states are the coordinates, their rates and the lag states.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    /// `A`, states by states.
    pub a: DMatrix<f64>,
    /// `B`, states by inputs.
    pub b: DMatrix<f64>,
    /// `C`, outputs by states.
    pub c: DMatrix<f64>,
    /// `D`, outputs by inputs.
    pub d: DMatrix<f64>,
}

/// Derivatives of equations with lag states with respect to the inputs, one column per input.
#[derive(Debug, Clone, PartialEq)]
pub struct LaggedInputs {
    /// `F`: derivative of the residual.
    pub force: DMatrix<f64>,
    /// `I`: derivative of the residual with respect to the rate of the input.
    pub impulse: DMatrix<f64>,
    /// `E`: derivative of the lag states' rates.
    pub follow: DMatrix<f64>,
}

/// Inertia of a model whose mass matrix has small eigenvalues, and the effect of accelerations on outputs: products with the matrix and
/// its inverse lose digits by cancellation, which sweeps along the tree avoid.
pub trait Accelerations {
    /// Inertia forces `M x`, column by column.
    fn inertia(&mut self, accelerations: &DMatrix<f64>) -> DMatrix<f64>;
    /// Changes of the outputs due to accelerations.
    fn shown(&mut self, accelerations: &DMatrix<f64>) -> DMatrix<f64>;
}

/// Number of refinements of accelerations: each adds as many digits as the condition of the mass matrix allows, 6 or more of 16.
const REFINEMENTS: usize = 2;

/// Linear model of equations with lag states, NOTATION eq. (L23); `by_lag` holds the derivatives of the outputs with respect to the lag
/// states. States are the coordinates, their rates without the immediate effect of an input jump (`−M⁻¹I u`), and the lag states. `None` if
/// the mass matrix has no inverse.
pub fn lagged_state_space(
    system: &Lagged,
    inputs: &LaggedInputs,
    outputs: &OutputSlopes,
    by_lag: &DMatrix<f64>,
    accelerations: &mut dyn Accelerations,
) -> Option<StateSpace> {
    let SecondOrder { mass, damping, stiffness } = &system.second;
    let (n, m, k) = (mass.nrows(), system.lag.nrows(), inputs.force.ncols());
    let inverse = mass.clone().cholesky()?;
    let mut pull = |forces: &DMatrix<f64>| {
        let mut found = -inverse.solve(forces);
        for _ in 0..REFINEMENTS {
            let left = forces + accelerations.inertia(&found);
            found -= inverse.solve(&left);
        }
        found
    };
    let jump = pull(&inputs.impulse);
    let by_position = pull(stiffness);
    let by_rate = pull(damping);
    let by_follower = pull(&system.force);
    let by_input = &by_rate * &jump + pull(&inputs.force);
    let mut a = DMatrix::zeros(2 * n + m, 2 * n + m);
    a.view_mut((0, n), (n, n)).fill_with_identity();
    a.view_mut((n, 0), (n, n)).copy_from(&by_position);
    a.view_mut((n, n), (n, n)).copy_from(&by_rate);
    a.view_mut((n, 2 * n), (n, m)).copy_from(&by_follower);
    a.view_mut((2 * n, 0), (m, n)).copy_from(&system.position);
    a.view_mut((2 * n, n), (m, n)).copy_from(&system.rate);
    a.view_mut((2 * n, 2 * n), (m, m)).copy_from(&system.lag);
    let mut b = DMatrix::zeros(2 * n + m, k);
    b.rows_mut(0, n).copy_from(&jump);
    b.rows_mut(n, n).copy_from(&by_input);
    b.rows_mut(2 * n, m).copy_from(&(&system.rate * &jump + &inputs.follow));
    let mut c = DMatrix::zeros(outputs.position.nrows(), 2 * n + m);
    c.columns_mut(0, n).copy_from(&(&outputs.position + accelerations.shown(&by_position)));
    c.columns_mut(n, n).copy_from(&(&outputs.rate + accelerations.shown(&by_rate)));
    c.columns_mut(2 * n, m).copy_from(&(by_lag + accelerations.shown(&by_follower)));
    let d = &outputs.input + &outputs.rate * &jump + accelerations.shown(&by_input);
    Some(StateSpace { a, b, c, d })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Explicit mass matrix, without sweeps along a tree.
    struct Plain(DMatrix<f64>);

    impl Accelerations for Plain {
        fn inertia(&mut self, accelerations: &DMatrix<f64>) -> DMatrix<f64> {
            &self.0 * accelerations
        }

        fn shown(&mut self, accelerations: &DMatrix<f64>) -> DMatrix<f64> {
            accelerations.clone()
        }
    }

    /// A mass on a spring and damper whose acceleration is an output: `ẍ = (u − cẋ − kx)/m`.
    #[test]
    fn oscillator() {
        let one = |value: f64| DMatrix::from_element(1, 1, value);
        let system = Lagged::without(SecondOrder { mass: one(2.0), damping: one(0.6), stiffness: one(8.0) });
        let zero = one(0.0);
        let outputs = OutputSlopes { position: zero.clone(), rate: zero.clone(), input: zero.clone() };
        let inputs = LaggedInputs { force: one(-1.0), impulse: zero, follow: DMatrix::zeros(0, 1) };
        let none = DMatrix::zeros(1, 0);
        let model = lagged_state_space(&system, &inputs, &outputs, &none, &mut Plain(one(2.0))).unwrap();
        let near = |matrix: &DMatrix<f64>, rows: usize, expected: &[f64]| {
            let expected = DMatrix::from_row_slice(rows, expected.len() / rows, expected);
            assert!((matrix - &expected).amax() < 1e-15, "{matrix} against {expected}");
        };
        near(&model.a, 2, &[0.0, 1.0, -4.0, -0.3]);
        near(&model.b, 2, &[0.0, 0.5]);
        near(&model.c, 1, &[-4.0, -0.3]);
        near(&model.d, 1, &[0.5]);
    }
}
