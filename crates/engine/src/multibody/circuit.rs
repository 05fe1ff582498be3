//! Armature circuits of motors: one first-order state each, the current, NOTATION eqs. (A12)–(A14).
//!
//! The current is the rate of a further coordinate, its charge, on which nothing depends: the vectors of coordinates, rates and
//! accelerations hold charge, current and the derivative of the current, behind the coordinates of the bodies and before the multipliers of
//! constraints. All methods of time integration then integrate it without code of their own. In Newton's matrix a circuit couples only with
//! the rate of its joint: it is eliminated before the tree and follows after it, and the rest of the matrix stays symmetric.

use crate::multibody::elimination::Weights;

/// Circuit of a motor on a joint with one degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circuit {
    /// Body that the joint connects to its parent.
    pub body: usize,
    /// Coordinate of the joint.
    pub joint: usize,
    /// Coordinate of the charge.
    pub coordinate: usize,
    /// Inductance `L` in H, positive.
    pub inductance_h: f64,
    /// Resistance `R` in Ω, positive.
    pub resistance_ohm: f64,
    /// Torque per current at the joint, `K N` in N·m/A, or force in N/A; also the voltage per joint rate.
    pub constant_n_m_a: f64,
    /// Length in m by which the displacement of the joint is divided in the kinematic norm; 1 for a rotation.
    pub scale_m: f64,
}

impl Circuit {
    /// Torque on the outer body about `+θ` in N·m, eq. (A13).
    #[inline]
    pub fn torque_n_m(&self, v: &[f64]) -> f64 {
        self.constant_n_m_a * v[self.coordinate]
    }

    /// Residual of the circuit in V under a voltage, eq. (A12).
    #[inline]
    pub fn residual_v(&self, v: &[f64], a: &[f64], voltage_v: f64) -> f64 {
        self.inductance_h * a[self.coordinate]
            + self.resistance_ohm * v[self.coordinate]
            + self.constant_n_m_a * v[self.joint]
            - voltage_v
    }

    /// Adds the changes of the residuals of joint and circuit by changes of rates and accelerations, eqs. (A12) and (A13).
    #[inline]
    pub fn add_along(&self, v: &[f64], a: &[f64], residual: &mut [f64]) {
        residual[self.joint] -= self.torque_n_m(v);
        residual[self.coordinate] += self.residual_v(v, a, 0.0);
    }

    /// The transpose of [`Self::add_along`]: adds multipliers of rates and accelerations, from those of the residuals.
    #[inline]
    pub fn add_transposed(&self, w: &[f64], by_v: &mut [f64], by_a: &mut [f64]) {
        by_v[self.joint] += self.constant_n_m_a * w[self.coordinate];
        by_v[self.coordinate] += self.resistance_ohm * w[self.coordinate] - self.constant_n_m_a * w[self.joint];
        by_a[self.coordinate] += self.inductance_h * w[self.coordinate];
    }

    /// The circuit whose rows are the columns of this one, in Newton's matrix.
    pub fn transposed(&self) -> Self {
        Self { constant_n_m_a: -self.constant_n_m_a, ..*self }
    }

    /// Displacement in m that counts as much as a unit of charge, for a machine of this size, as in [`Self::include`].
    pub fn displacement_m(&self, reach_m: f64) -> f64 {
        (self.resistance_ohm * reach_m / (self.constant_n_m_a * self.scale_m)).abs()
    }

    /// Magnetic energy in J.
    pub fn energy_j(&self, v: &[f64]) -> f64 {
        0.5 * self.inductance_h * v[self.coordinate].powi(2)
    }

    fn pivot(&self, weights: Weights) -> f64 {
        self.inductance_h * weights.mass + self.resistance_ohm * weights.damping
    }

    /// Damping in N·m·s/rad that the eliminated circuit adds to its joint, eq. (A14).
    #[inline]
    pub fn added_damping(&self, weights: Weights) -> f64 {
        self.constant_n_m_a * self.constant_n_m_a * weights.damping / self.pivot(weights)
    }

    /// Eliminates the circuit's row from the right-hand side `x` of its joint.
    #[inline]
    pub fn reduce(&self, weights: Weights, x: &mut [f64]) {
        x[self.joint] += self.constant_n_m_a * weights.damping * x[self.coordinate] / self.pivot(weights);
    }

    /// Replaces the right-hand side of the circuit by its solution; the joint's is in `x`.
    #[inline]
    pub fn expand(&self, weights: Weights, x: &mut [f64]) {
        let left = x[self.coordinate] - self.constant_n_m_a * weights.damping * x[self.joint];
        x[self.coordinate] = left / self.pivot(weights);
    }

    /// The larger of a kinematic norm and the rotation (or displacement divided by the model's length) that corresponds to a change of the
    /// charge: at constant voltage the slow rotation decreases by `R/(K N)` per unit of charge. NaN if the change is NaN.
    #[inline]
    pub fn include(&self, norm: f64, change: &[f64]) -> f64 {
        let own = (change[self.coordinate] * self.resistance_ohm / (self.constant_n_m_a * self.scale_m)).abs();
        if own > norm || own.is_nan() { own } else { norm }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elimination and back substitution solve the two rows of a circuit and its joint of pivot 0.7: weights of a stage of an implicit
    /// method, and those of a start, where the current does not depend on the rate.
    #[test]
    fn eliminated_circuit_solves_both_rows() {
        let circuit = Circuit {
            body: 0,
            joint: 0,
            coordinate: 1,
            inductance_h: 0.02,
            resistance_ohm: 1.5,
            constant_n_m_a: 0.4,
            scale_m: 1.0,
        };
        for damping in [0.0, 3e-3, 2.0] {
            let weights = Weights { mass: 1.0, damping, stiffness: damping * damping };
            let right = [0.3, -2.0];
            let mut x = right;
            circuit.reduce(weights, &mut x);
            x[0] /= 0.7 + damping * circuit.added_damping(weights);
            circuit.expand(weights, &mut x);
            let rows = [
                0.7 * x[0] - damping * 0.4 * x[1] - right[0],
                damping * 0.4 * x[0] + (0.02 + 1.5 * damping) * x[1] - right[1],
            ];
            assert!(rows.iter().all(|row| row.abs() < 1e-15), "{damping}: {rows:?}");
        }
        // the charge of 2 C is worth a rotation of 2 · 1.5/0.4 rad
        assert_eq!(circuit.include(1.0, &[0.0, -2.0]), 7.5);
        assert_eq!(circuit.include(8.0, &[0.0, -2.0]), 8.0);
        assert!(circuit.include(8.0, &[0.0, f64::NAN]).is_nan());
    }
}
