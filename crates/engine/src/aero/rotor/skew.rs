//! Skewed wake: in oblique wind the induction is larger on the side towards which the wake leans.
//!
//! Source: Pitt and Peters, *Theoretical prediction of dynamic-inflow derivatives*, Vertica 5 (1981), for the gradient
//! over the disc; Coleman, Feingold and Stempin, NACA ARR L5E10 (1945), and Burton et al. for the angle of the wake.

use nalgebra::Vector3;
use std::f64::consts::PI;

/// Gradient of the induction over the radius for a wake at 90° to the shaft.
const GRADIENT: f64 = 15.0 * PI / 32.0;

/// Wind through a disc, averaged over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skew {
    /// Angle from the shaft to the wind in rad, 0 to π.
    pub angle_rad: f64,
    /// Unit vector in the disc towards which the wake leans; zero if it does not lean.
    pub lean: Vector3<f64>,
}

impl Skew {
    /// Of a mean wind through a disc whose unit normal points downwind.
    pub fn of(wind_m_s: &Vector3<f64>, normal: &Vector3<f64>) -> Self {
        let axial_m_s = wind_m_s.dot(normal);
        let across_m_s = wind_m_s - normal * axial_m_s;
        let speed_m_s = across_m_s.norm();
        // a wind that leans by round-off does not lean
        let lean = if speed_m_s > 1e-12 * wind_m_s.norm() { across_m_s / speed_m_s } else { Vector3::zeros() };
        Self { angle_rad: speed_m_s.atan2(axial_m_s), lean }
    }

    /// Factor on the axial induction of a node at `arm` (from the shaft, over the radius of the disc, any direction in
    /// the disc), eq. (B15). `induction` is the factor without skew. A wake that would lean by more than 90° is treated
    /// as leaning by 90°.
    pub fn factor(&self, arm: &Vector3<f64>, induction: f64) -> f64 {
        let wake_rad = ((0.6 * induction + 1.0) * self.angle_rad).clamp(-0.5 * PI, 0.5 * PI);
        1.0 + GRADIENT * (0.5 * wake_rad).tan() * arm.dot(&self.lean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn induction_grows_where_the_wake_leans_to() {
        let normal = Vector3::x();
        let wind = Vector3::new(10.0, 0.0, 0.0) + Vector3::new(0.0, 10.0 * 0.3f64.tan(), 0.0);
        let skew = Skew::of(&wind, &normal);
        approx::assert_relative_eq!(skew.angle_rad, 0.3, max_relative = 1e-12);
        let chi = (0.6 * 0.25 + 1.0) * 0.3;
        let expected = 15.0 * PI / 32.0 * f64::tan(chi / 2.0) * 0.8;
        approx::assert_relative_eq!(skew.factor(&(Vector3::y() * 0.8), 0.25), 1.0 + expected, max_relative = 1e-12);
        approx::assert_relative_eq!(skew.factor(&(Vector3::y() * -0.8), 0.25), 1.0 - expected, max_relative = 1e-12);
        assert_eq!(skew.factor(&(Vector3::z() * 0.8), 0.25), 1.0);
    }

    #[test]
    fn straight_or_absent_wind_leaves_the_induction_alone() {
        for wind in [Vector3::zeros(), Vector3::x() * 8.0, Vector3::x() * -8.0] {
            assert_eq!(Skew::of(&wind, &Vector3::x()).factor(&Vector3::y(), 0.3), 1.0);
        }
        let edgewise = Skew::of(&Vector3::z(), &Vector3::x());
        approx::assert_relative_eq!(edgewise.factor(&Vector3::z(), 0.9), 1.0 + GRADIENT, max_relative = 1e-12);
    }
}
