//! Attitude of a section rotated by several small angles simultaneously, and its rates.

use nalgebra::{Matrix3, Vector3};

/// Rotation of a section by several small angles `t` simultaneously: the rotation nearest to `I + [t]×`, by `atan |t|` about `t`, eq. (M3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SmallTurn {
    angles_rad: Vector3<f64>,
    /// Norm `n = √(1 + t²)`.
    norm: f64,
    /// Coefficient `1/(n(n + 1))`.
    spread: f64,
    /// Whether the angular velocity is just the rate of the angles.
    rates_of_angles: bool,
}

impl SmallTurn {
    /// Rotation by small angles; with `rates_of_angles` its angular velocity is their rate.
    pub fn new(angles_rad: Vector3<f64>, rates_of_angles: bool) -> Self {
        let norm = (1.0 + angles_rad.norm_squared()).sqrt();
        Self { angles_rad, norm, spread: 1.0 / (norm * (norm + 1.0)), rates_of_angles }
    }

    /// Rotation matrix, inner end ← section.
    pub fn rotation(&self) -> Matrix3<f64> {
        let (t, n) = (&self.angles_rad, self.norm);
        // (1 − 1/n)/t² without cancellation
        t.cross_matrix() / n + Matrix3::from_diagonal_element(1.0 / n) + t * t.transpose() * self.spread
    }

    /// Coefficients of `I`, `[t]×` and `ttᵀ` in `T(t)`, which gives the angular velocity in the frame of the inner end for a rate of `t`,
    /// eq. (M4).
    fn factors(&self) -> [f64; 3] {
        // rotation about t by atan|t|: the factor along t is 1/n²; normal to it they are sin θ/|t| = 1/n and (1 − cos θ)/t² = 1/(n(n + 1));
        // hence ttᵀ has (1/n² − 1/n)/t² = −1/(n²(n + 1))
        if self.rates_of_angles { [1.0, 0.0, 0.0] } else { [1.0 / self.norm, self.spread, -self.spread / self.norm] }
    }

    /// Derivatives of [`Self::factors`] with respect to `t` in the direction `u`.
    fn factors_along(&self, u: &Vector3<f64>) -> [f64; 3] {
        if self.rates_of_angles {
            return [0.0; 3];
        }
        let (n, spread) = (self.norm, self.spread);
        let by_n = [-1.0 / (n * n), -(2.0 * n + 1.0) * spread * spread, (3.0 * n + 2.0) * spread * spread / n];
        // dn = t·u/n
        let change = self.angles_rad.dot(u) / n;
        by_n.map(|slope| slope * change)
    }

    /// Angular velocity `T(t) u` for rates `u` of the angles.
    #[inline]
    pub fn spin(&self, u: &Vector3<f64>) -> Vector3<f64> {
        self.sum(self.factors(), u)
    }

    /// Generalised moments `T(t)ᵀ m` on the angles due to a moment `m`.
    #[inline]
    pub fn moments(&self, m: &Vector3<f64>) -> Vector3<f64> {
        let [sine, versine, along] = self.factors();
        self.sum([sine, -versine, along], m)
    }

    /// Derivative of [`Self::spin`] for rates `v` with respect to `t` in the direction `u`.
    pub fn spin_along(&self, v: &Vector3<f64>, u: &Vector3<f64>) -> Vector3<f64> {
        let ([_, versine, along], t) = (self.factors(), &self.angles_rad);
        self.sum(self.factors_along(u), v) + u.cross(v) * versine + (u * t.dot(v) + t * u.dot(v)) * along
    }

    /// [`Self::spin`] for constant rates `v` with its first and second time derivatives, while `t` has the rates `u` and accelerations `w`.
    pub fn spin_with_rates(&self, v: &Vector3<f64>, u: &Vector3<f64>, w: &Vector3<f64>) -> [Vector3<f64>; 3] {
        let (t, n) = (&self.angles_rad, self.norm);
        let [_, versine, along] = self.factors();
        let [sine1, versine1, along1] = self.factors_along(u);
        let [sine2, versine2, along2] = if self.rates_of_angles {
            [0.0; 3]
        } else {
            let n1 = t.dot(u) / n;
            let n2 = (u.dot(u) + t.dot(w) - n1 * n1) / n;
            // of 1/n, 1/(n² + n) and −1/(n³ + n²) by n
            let [square, cube] = [n * n + n, n * n * n + n * n];
            let [by_square, by_cube] = [2.0 * n + 1.0, 3.0 * n * n + 2.0 * n];
            let first = [-1.0 / (n * n), -by_square / square.powi(2), by_cube / cube.powi(2)];
            let second = [
                2.0 / n.powi(3),
                (2.0 * by_square * by_square - 2.0 * square) / square.powi(3),
                ((6.0 * n + 2.0) * cube - 2.0 * by_cube * by_cube) / cube.powi(3),
            ];
            std::array::from_fn(|i| second[i] * n1 * n1 + first[i] * n2)
        };
        let (tv, uv, wv) = (t.dot(v), u.dot(v), w.dot(v));
        let (tt, ut) = (t * tv, u * tv + t * uv);
        [
            self.spin(v),
            v * sine1 + t.cross(v) * versine1 + u.cross(v) * versine + tt * along1 + ut * along,
            v * sine2
                + t.cross(v) * versine2
                + u.cross(v) * (2.0 * versine1)
                + w.cross(v) * versine
                + tt * along2
                + ut * (2.0 * along1)
                + (w * tv + u * (2.0 * uv) + t * wv) * along,
        ]
    }

    /// Applies the three coefficients to a vector.
    #[inline]
    fn sum(&self, [sine, versine, along]: [f64; 3], v: &Vector3<f64>) -> Vector3<f64> {
        let t = &self.angles_rad;
        v * sine + t.cross(v) * versine + t * (along * t.dot(v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `T` gives the rate of the attitude: compared with differences of the rotation for small angles; the moments use its transpose, and
    /// the derivative of `T` agrees with differences. Steps of 1e-5 leave the square of that, and round-off divided by the step.
    #[test]
    fn small_turns_have_the_rates_of_their_attitudes() {
        let (t, u) = (Vector3::new(0.2, -0.5, 0.3), Vector3::new(-0.7, 0.4, 1.1));
        let (turn, step) = (SmallTurn::new(t, false), 1e-5);
        let [above, below] = [step, -step].map(|step| SmallTurn::new(t + u * step, false));
        let rate = (above.rotation() - below.rotation()) / (2.0 * step) * turn.rotation().transpose();
        let spin = Vector3::new(rate[(2, 1)], rate[(0, 2)], rate[(1, 0)]);
        assert!((spin - turn.spin(&u)).norm() < 1e-9, "{spin} {}", turn.spin(&u));
        let v = Vector3::new(0.3, 0.9, -0.2);
        assert!((v.dot(&turn.spin(&u)) - u.dot(&turn.moments(&v))).abs() < 1e-15);
        let change = (above.spin(&v) - below.spin(&v)) / (2.0 * step);
        assert!((change - turn.spin_along(&v, &u)).norm() < 1e-9, "{change} {}", turn.spin_along(&v, &u));
        // along t + uτ + wτ²/2; the second differences have 4e-11 of round-off, and a truncation of the square of their step
        let (w, step) = (Vector3::new(0.6, -0.2, 0.9), 1e-3);
        let [below, here, above] =
            [-step, 0.0, step].map(|time| SmallTurn::new(t + u * time + w * (0.5 * time * time), false).spin(&v));
        let [value, first, second] = turn.spin_with_rates(&v, &u, &w);
        assert_eq!(value, here);
        assert!((first - turn.spin_along(&v, &u)).norm() < 1e-14, "{first}");
        assert!((second - (above - here * 2.0 + below) / (step * step)).norm() < 1e-5, "{second}");
    }
}
