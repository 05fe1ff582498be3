//! Linear models `ẋ = Ax + Bu`, `y = Cx + Du` from the matrices of second-order equations, NOTATION eq. (L12).

use nalgebra::DMatrix;

/// `M δq̈ + C δq̇ + K δq = −∂r/∂u δu` about a state, over the free coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct SecondOrder {
    /// `M`.
    pub mass: DMatrix<f64>,
    /// `C`: damping, gyroscopic terms.
    pub damping: DMatrix<f64>,
    /// `K`: exact tangent.
    pub stiffness: DMatrix<f64>,
}

/// Derivatives of the outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputSlopes {
    /// With the coordinates.
    pub position: DMatrix<f64>,
    /// With their rates.
    pub rate: DMatrix<f64>,
    /// With their accelerations.
    pub acceleration: DMatrix<f64>,
    /// With the inputs, at given accelerations.
    pub input: DMatrix<f64>,
}

/// A linear model; states are the coordinates and then their rates.
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

/// The linear model; `input_forces` is `∂r/∂u`, the change of the residual with the inputs. `None` where the mass
/// matrix has no inverse.
pub fn state_space(system: &SecondOrder, input_forces: &DMatrix<f64>, outputs: &OutputSlopes) -> Option<StateSpace> {
    let n = system.mass.nrows();
    let inverse = system.mass.clone().cholesky()?;
    let by_position = -inverse.solve(&system.stiffness);
    let by_rate = -inverse.solve(&system.damping);
    let by_input = -inverse.solve(input_forces);
    let mut a = DMatrix::zeros(2 * n, 2 * n);
    a.view_mut((0, n), (n, n)).fill_with_identity();
    a.view_mut((n, 0), (n, n)).copy_from(&by_position);
    a.view_mut((n, n), (n, n)).copy_from(&by_rate);
    let mut b = DMatrix::zeros(2 * n, by_input.ncols());
    b.rows_mut(n, n).copy_from(&by_input);
    let mut c = DMatrix::zeros(outputs.position.nrows(), 2 * n);
    c.columns_mut(0, n).copy_from(&(&outputs.position + &outputs.acceleration * by_position));
    c.columns_mut(n, n).copy_from(&(&outputs.rate + &outputs.acceleration * by_rate));
    let d = &outputs.input + &outputs.acceleration * by_input;
    Some(StateSpace { a, b, c, d })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass on a spring and damper whose acceleration is an output: `ẍ = (u − cẋ − kx)/m`.
    #[test]
    fn oscillator() {
        let one = |value: f64| DMatrix::from_element(1, 1, value);
        let system = SecondOrder { mass: one(2.0), damping: one(0.6), stiffness: one(8.0) };
        let zero = one(0.0);
        let outputs = OutputSlopes { position: zero.clone(), rate: zero.clone(), acceleration: one(1.0), input: zero };
        let model = state_space(&system, &one(-1.0), &outputs).unwrap();
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
