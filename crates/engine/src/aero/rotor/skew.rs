//! Skewed wake: in oblique wind the induction is larger on the side towards which the wake is inclined.
//!
//! Sources: Pitt and Peters, *Theoretical prediction of dynamic-inflow derivatives*, Vertica 5 (1981), for the gradient over the disc;
//! Coleman, Feingold and Stempin, NACA ARR L5E10 (1945), for the skew angle of the wake, for which Burton et al. give an approximation at
//! small angles.

use crate::aero::pieces::Pieces;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Radial gradient of the induction for a wake at 90° to the shaft.
const GRADIENT: f64 = 15.0 * PI / 32.0;
/// Maximum number of iterations for the skew angle; bisection alone would need 52.
const MAXIMUM_STEPS: usize = 60;
/// Width of the bracket, for the tangent of half the angle, at which the iteration stops.
const TOLERANCE: f64 = 1e-15;

/// Mean wind through a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skew {
    /// Wind along the shaft in m/s.
    pub axial_m_s: f64,
    /// Wind normal to the shaft in m/s, at least 0.
    pub across_m_s: f64,
    /// Unit vector in the disc towards which the wake is inclined; zero without inclination.
    pub lean: Vector3<f64>,
}

impl Skew {
    /// Skew of a mean wind through a disc whose unit normal points downwind.
    pub fn of(wind_m_s: &Vector3<f64>, normal: &Vector3<f64>) -> Self {
        let axial_m_s = wind_m_s.dot(normal);
        let across = wind_m_s - normal * axial_m_s;
        let across_m_s = across.norm();
        // a component of the size of round-off does not incline the wake
        match across_m_s > 1e-12 * wind_m_s.norm() {
            true => Self { axial_m_s, across_m_s, lean: across / across_m_s },
            false => Self { axial_m_s, across_m_s: 0.0, lean: Vector3::zeros() },
        }
    }

    /// Factor on the axial induction of a node at `arm` (vector from the shaft divided by the disc radius; only the component in the disc
    /// matters), eq. (B15). `loss_m_s` is the axial induced velocity without skew, opposite to the wind.
    pub fn factor(&self, arm: &Vector3<f64>, loss_m_s: f64, pieces: &mut Pieces) -> f64 {
        1.0 + GRADIENT * self.half_tangent(loss_m_s, pieces) * arm.dot(&self.lean)
    }

    /// Tangent of half the skew angle of the wake, between 0 and 1, from Coleman's `tan χ = (S − v' tan χ/2)/(A − v)`, eq. (B15). In reversed
    /// flow the angle is measured from the opposite shaft direction; for flow normal to the shaft, where `A = v`, both are 90°.
    ///
    /// `v'` is `v` up to half the wind, where momentum theory ends, and at most the flow `|A − v|` beyond: with the whole induced velocity any
    /// small lateral component would deflect the wake of a reversed flow by a finite angle, and the angle would jump at `A = v`.
    fn half_tangent(&self, loss_m_s: f64, pieces: &mut Pieces) -> f64 {
        if self.across_m_s == 0.0 {
            return 0.0;
        }
        let side = if pieces.holds(self.axial_m_s < loss_m_s) { -1.0 } else { 1.0 };
        let (axial, across, loss) = (side * self.axial_m_s, self.across_m_s, side * loss_m_s);
        let flow = axial - loss;
        let above = pieces.most(loss, -flow);
        let lateral = pieces.least(above, flow);
        // positive at 0, not positive at 1, with one zero between them: sum and product of its roots exclude three positive ones
        let value = |t: f64| ((lateral * t - across) * t - lateral - 2.0 * flow) * t + across;
        let slope = |t: f64| (3.0 * lateral * t - 2.0 * across) * t - lateral - 2.0 * flow;
        let (mut low, mut high) = (0.0, 1.0);
        // exact solution without induction
        let mut t = across / (axial.hypot(across) + axial.abs());
        for _ in 0..MAXIMUM_STEPS {
            let now = value(t);
            if now > 0.0 {
                low = t;
            } else {
                high = t;
            }
            let newton = t - now / slope(t);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let change = (next - t).abs();
            t = next;
            if change <= TOLERANCE || high - low <= TOLERANCE {
                break;
            }
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wake_rad(skew: &Skew, loss_m_s: f64) -> f64 {
        let arm = skew.lean * 0.8;
        2.0 * ((skew.factor(&arm, loss_m_s, &mut Pieces::Free) - 1.0) / (0.8 * GRADIENT)).atan()
    }

    #[test]
    fn induction_grows_where_the_wake_leans_to() {
        let wind = |angle_rad: f64| Vector3::new(10.0 * angle_rad.cos(), 10.0 * angle_rad.sin(), 0.0);
        let skew = Skew::of(&wind(0.3), &Vector3::x());
        // without induction the wake follows the wind; lateral wind normal to the arm has no effect
        approx::assert_relative_eq!(wake_rad(&skew, 0.0), 0.3, max_relative = 1e-12);
        let [one, other] = [0.8, -0.8].map(|arm| skew.factor(&(Vector3::y() * arm), 2.5, &mut Pieces::Free));
        approx::assert_relative_eq!(one - 1.0, 1.0 - other, max_relative = 1e-12);
        assert_eq!(skew.factor(&(Vector3::z() * 0.8), 2.5, &mut Pieces::Free), 1.0);
        // Burton's approximation (0.6 a + 1) γ: within 1° up to 45° and a = 1/3
        for degrees in [5.0f64, 15.0, 30.0, 45.0] {
            for a in [0.1, 0.2, 1.0 / 3.0] {
                let angle_rad = degrees.to_radians();
                let close_rad = (0.6 * a + 1.0) * angle_rad;
                let found_rad = wake_rad(&Skew::of(&wind(angle_rad), &Vector3::x()), 10.0 * a);
                assert!((found_rad - close_rad).abs() < 1f64.to_radians(), "{degrees} {a}: {found_rad} {close_rad}");
                let coleman = (angle_rad.sin() - a * (0.5 * found_rad).tan()) / (angle_rad.cos() - a);
                approx::assert_relative_eq!(found_rad.tan(), coleman, max_relative = 1e-10);
            }
        }
    }

    #[test]
    fn straight_or_absent_wind_leaves_the_induction_alone() {
        for wind in [Vector3::zeros(), Vector3::x() * 8.0, Vector3::x() * -8.0] {
            assert_eq!(Skew::of(&wind, &Vector3::x()).factor(&Vector3::y(), 0.3, &mut Pieces::Free), 1.0);
        }
        let edgewise = Skew::of(&Vector3::z(), &Vector3::x());
        approx::assert_relative_eq!(
            edgewise.factor(&Vector3::z(), 0.0, &mut Pieces::Free),
            1.0 + GRADIENT,
            max_relative = 1e-12
        );
    }

    /// From 0 to 180° of yaw the factor stays between its values for a wake in the plane of the disc and changes by no more than the angle
    /// does; a rotor in wind from behind is the mirror image.
    #[test]
    fn wake_turns_without_jumps_through_ninety_degrees() {
        let of = |step: u32, loss_m_s: f64| {
            let angle_rad = PI * f64::from(step) / 3600.0;
            let wind = Vector3::new(12.0 * angle_rad.cos(), 12.0 * angle_rad.sin(), 0.0);
            Skew::of(&wind, &Vector3::x()).half_tangent(loss_m_s, &mut Pieces::Free)
        };
        for loss_m_s in [-6.0, -3.0, -0.5, 0.0, 0.5, 3.0, 6.0] {
            for step in 0..3600 {
                let [at, next] = [of(step, loss_m_s), of(step + 1, loss_m_s)];
                assert!((0.0..=1.0).contains(&at), "{step} {loss_m_s}: {at}");
                // the wind turns by 8.7e-4 rad in a step; with induction the wake turns by up to a quarter more
                assert!((next - at).abs() < 1.2e-3, "{step} {loss_m_s}: {at} {next}");
                approx::assert_relative_eq!(of(3600 - step, -loss_m_s), at, epsilon = 1e-9);
            }
        }
    }

    /// Also where the induced velocity exceeds the wind, the wake is straight in the limit of no lateral wind, and its angle is continuous in
    /// the wind along the shaft: over 2e-6 of the induced velocity the tangent changes by less than 1e-3 (5.4e-5 in the steepest place).
    #[test]
    fn wake_is_straight_without_lateral_wind_against_any_induction() {
        let of = |axial_m_s: f64, across_m_s: f64| {
            Skew { axial_m_s, across_m_s, lean: Vector3::y() }.half_tangent(1.0, &mut Pieces::Free)
        };
        for step in -300..=300 {
            let axial_m_s = 0.01 * f64::from(step);
            if (axial_m_s - 1.0).abs() > 1e-3 {
                assert!(of(axial_m_s, 1e-9) < 1e-6, "{axial_m_s}: {}", of(axial_m_s, 1e-9));
            }
            for across_m_s in [0.01, 0.1, 1.0] {
                let [below, above] = [-1e-6, 1e-6].map(|shift| of(axial_m_s + shift, across_m_s));
                assert!((above - below).abs() < 1e-3, "{axial_m_s} {across_m_s}: {below} {above}");
            }
        }
        // hover in a lateral wind: tan χ = S/v + tan χ/2
        let t = of(0.0, 0.1);
        approx::assert_relative_eq!(2.0 * t / (1.0 - t * t), 0.1 + t, max_relative = 1e-12);
    }
}
