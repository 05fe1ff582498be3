//! Induced velocity of annuli with one lag behind the load, eq. (B24): a simple model of dynamic inflow.
//!
//! Momentum theory for the current load, with Glauert's linear relation for heavily loaded annuli, and one time constant; without tip and
//! hub losses and without swirl.

use crate::aero::pieces::Pieces;
use crate::aero::polar::Polar;
use crate::aero::rotor::dynamic_inflow::InflowState;
use crate::aero::rotor::induction::{Approach, SectionState};
use crate::aero::rotor::lag::lag;
use std::f64::consts::FRAC_1_SQRT_2;

/// Thrust coefficient and induction factor at the start of Glauert's straight line.
const LINE: [f64; 2] = [0.96, 0.4];
/// Slope of the line: increment of the induction factor divided by that of the thrust coefficient.
const SLOPE: f64 = 0.5;
/// Thrust coefficient at the end of the line.
const LINE_END: f64 = 2.0;
/// Number of iterations between load and lag within a step: each multiplies the error by `h/2τ` times the derivative of the momentum
/// relation.
const PASSES: usize = 4;
/// Relaxation factor, overshoot at which it is halved, and maximum number of iterations for the steady state.
const RELAXATION: f64 = 0.3;
const OVERSHOOT: f64 = 0.5;
const SETTLING_PASSES: usize = 500;

/// Velocity reduction in m/s of an annulus along the shaft, for a wind along the shaft and a load `B F'/(πρr)` in m²/s², where `F'` is the
/// force of a blade per span along the shaft; eq. (B24). Wind from behind is the mirror image.
///
/// Up to a thrust coefficient of 0.96 it follows momentum theory, then a straight line; beyond 2 it is linear in the wind, down to the
/// value of hover.
pub fn momentum_m_s(wind_m_s: f64, load_m2_s2: f64) -> f64 {
    momentum_on_m_s(wind_m_s, load_m2_s2, &mut Pieces::Free)
}

/// The same on pieces of its functions.
pub fn momentum_on_m_s(wind_m_s: f64, load_m2_s2: f64, pieces: &mut Pieces) -> f64 {
    match pieces.holds(wind_m_s < 0.0) {
        true => -with_the_wind_m_s(-wind_m_s, -load_m2_s2, pieces),
        false => with_the_wind_m_s(wind_m_s, load_m2_s2, pieces),
    }
}

/// The same for wind from the front.
fn with_the_wind_m_s(wind_m_s: f64, load_m2_s2: f64, pieces: &mut Pieces) -> f64 {
    let pressure_m2_s2 = wind_m_s * wind_m_s;
    if pieces.holds(load_m2_s2 <= LINE[0] * pressure_m2_s2) {
        // ½ (V − √(V² − K)), without cancellation
        let root_m_s = (pressure_m2_s2 - load_m2_s2).sqrt();
        return if load_m2_s2 == 0.0 { 0.0 } else { 0.5 * load_m2_s2 / (wind_m_s + root_m_s) };
    }
    if pieces.holds(load_m2_s2 <= LINE_END * pressure_m2_s2) {
        return LINE[1] * wind_m_s + SLOPE * (load_m2_s2 / wind_m_s - LINE[0] * wind_m_s);
    }
    let end = LINE[1] + SLOPE * (LINE_END - LINE[0]);
    0.5 * load_m2_s2.sqrt() + (end - FRAC_1_SQRT_2) * wind_m_s
}

/// Inflow of a section without the induced velocity.
pub struct Meeting<'a> {
    /// Inflow of the section.
    pub approach: Approach,
    /// Polar of the section.
    pub polar: &'a Polar,
    /// Chord in m.
    pub chord_m: f64,
    /// Pitch rate about the span, nose up, in rad/s, eq. (B25).
    pub pitch_rate_rad_s: f64,
}

impl Meeting<'_> {
    /// Evaluates the section with an axial and a tangential induced velocity in m/s.
    pub fn state(&self, induced_m_s: [f64; 2], pieces: &mut Pieces) -> SectionState {
        let Approach { axial_m_s, tangential_m_s, chord_angle_rad } = self.approach;
        let met_m_s = [axial_m_s - induced_m_s[0], tangential_m_s + induced_m_s[1]];
        let state = SectionState::on(met_m_s, chord_angle_rad, self.polar, pieces);
        // on pieces also without a pitch rate, beside which there is one
        if self.pitch_rate_rad_s == 0.0 && matches!(pieces, Pieces::Free) {
            return state;
        }
        state.turning(self.pitch_rate_rad_s * self.chord_m, self.polar, pieces)
    }
}

/// An annulus whose induced velocity lags.
pub struct Lagging<'a> {
    /// The section whose load determines the induced velocity.
    pub meeting: Meeting<'a>,
    /// Wind along the shaft relative to the hub, in m/s.
    pub wind_m_s: f64,
    /// Cosine of the angle between the shaft and the normal of the annulus.
    pub lean: f64,
    /// `B/(πr)` in 1/m, with the radius `r` of the straight blade.
    pub share_1_m: f64,
    /// Time constant in s.
    pub time_s: f64,
}

impl Lagging<'_> {
    /// Velocity in m/s along the shaft given by momentum theory for the load at an induced velocity.
    pub fn balanced_m_s(&self, induced_m_s: f64, pieces: &mut Pieces) -> f64 {
        let state = self.meeting.state([self.lean * induced_m_s, 0.0], pieces);
        let [along_m3_s2, _] = state.force_m3_s2(self.meeting.chord_m);
        momentum_on_m_s(self.wind_m_s, self.share_1_m * self.lean * along_m3_s2, pieces)
    }

    /// Steady state.
    pub fn settled(&self, pieces: &mut Pieces) -> InflowState {
        let mut induced_m_s = match pieces {
            Pieces::Free | Pieces::Record(_) => 0.0,
            // the square root of momentum theory does not continue to the load without induced velocity
            Pieces::Keep { .. } => self.settled(&mut Pieces::Free).acting_m_s[0],
        };
        let (mut relaxation, mut before_m_s) = (RELAXATION, 0.0);
        for _ in 0..SETTLING_PASSES {
            let balanced_m_s = self.balanced_m_s(induced_m_s, &mut pieces.of_round());
            let change_m_s: f64 = relaxation * (balanced_m_s - induced_m_s);
            // heavily loaded annuli overshoot
            if change_m_s * before_m_s < 0.0 && change_m_s.abs() > OVERSHOOT * f64::abs(before_m_s) {
                relaxation *= 0.5;
            }
            before_m_s = change_m_s;
            induced_m_s += change_m_s;
            if change_m_s.abs() <= 1e-15 * self.wind_m_s.abs() {
                break;
            }
        }
        if !matches!(pieces, Pieces::Free) {
            self.balanced_m_s(induced_m_s, pieces);
        }
        InflowState::established([induced_m_s, 0.0])
    }

    /// State at an instant with a given induced velocity.
    pub fn given(&self, induced_m_s: f64) -> InflowState {
        let balanced_m_s = [self.balanced_m_s(induced_m_s, &mut Pieces::Free), 0.0];
        InflowState { acting_m_s: [induced_m_s, 0.0], ..InflowState::established(balanced_m_s) }
    }

    /// State of a flow that starts now: no induced velocity yet.
    pub fn still(&self, pieces: &mut Pieces) -> InflowState {
        InflowState { balanced_m_s: [self.balanced_m_s(0.0, pieces), 0.0], ..InflowState::default() }
    }

    /// State one step later, eq. (B11): exact if the velocity of momentum theory changes linearly over the step.
    pub fn after(&self, from: &InflowState, step_s: f64, pieces: &mut Pieces) -> InflowState {
        let (acting_m_s, balanced_m_s) = (from.acting_m_s[0], from.balanced_m_s[0]);
        let ratio = step_s / self.time_s;
        let mut next = lag(acting_m_s, balanced_m_s, balanced_m_s, ratio);
        let mut to_m_s = balanced_m_s;
        for _ in 0..PASSES {
            to_m_s = self.balanced_m_s(next, pieces);
            next = lag(acting_m_s, balanced_m_s, to_m_s, ratio);
        }
        InflowState { acting_m_s: [next, 0.0], ..InflowState::established([to_m_s, 0.0]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::pieces::PieceList;
    use crate::aero::polar::PolarRow;

    /// Momentum theory `4a(1 − a)` up to 0.96, the line through (0.96, 0.4) and (2, 0.92), hover in still air; continuous, and mirrored.
    #[test]
    fn momentum_theory_goes_from_propeller_to_hover() {
        for a in [-0.5, -0.1, 0.0, 0.2, 0.4f64] {
            approx::assert_relative_eq!(momentum_m_s(3.0, 9.0 * 4.0 * a * (1.0 - a)), 3.0 * a, epsilon = 1e-14);
        }
        approx::assert_relative_eq!(momentum_m_s(3.0, 9.0 * 1.48), 3.0 * 0.66, max_relative = 1e-14);
        // hover: dT = 4πρ r v² dr
        approx::assert_relative_eq!(momentum_m_s(0.0, 4.0 * 1.7f64.powi(2)), 1.7, max_relative = 1e-14);
        for (wind_m_s, load_m2_s2) in [(3.0f64, 9.0 * 0.96), (3.0, 9.0 * 2.0), (0.0, 5.0), (0.0, -5.0), (3.0, 0.0)] {
            let ends = [-1e-12, 1e-12].map(|shift| momentum_m_s(wind_m_s + shift, load_m2_s2 * (1.0 + shift)));
            assert!((ends[1] - ends[0]).abs() < 1e-10, "{wind_m_s} {load_m2_s2}: {ends:?}");
            let back = momentum_m_s(-wind_m_s, -load_m2_s2);
            approx::assert_relative_eq!(back, -momentum_m_s(wind_m_s, load_m2_s2), epsilon = 1e-14);
        }
        assert_eq!(momentum_m_s(0.0, 0.0), 0.0);
    }

    fn plate() -> Polar {
        let rows = (-180..=180).map(|degree| {
            let angle_rad = f64::from(degree).to_radians();
            let lift = std::f64::consts::TAU * angle_rad.sin() * angle_rad.cos();
            PolarRow { angle_rad, lift, drag: 0.01 + 1.5 * angle_rad.sin().powi(2), moment: 0.0 }
        });
        Polar { rows: rows.collect() }
    }

    /// Compares with a Runge-Kutta solution of the lag equation with 4000 steps, from zero to the steady state: second order in the step.
    #[test]
    fn the_lag_follows_its_equation_at_second_order() {
        let polar = plate();
        let annulus = Lagging {
            meeting: Meeting {
                approach: Approach { axial_m_s: 11.0, tangential_m_s: 55.0, chord_angle_rad: 0.05 },
                polar: &polar,
                chord_m: 1.4,
                pitch_rate_rad_s: 0.0,
            },
            wind_m_s: 11.0,
            lean: 0.99,
            share_1_m: 2.0 / (std::f64::consts::PI * 12.0),
            time_s: 0.8,
        };
        let rate = |v: f64| (annulus.balanced_m_s(v, &mut Pieces::Free) - v) / annulus.time_s;
        let (mut v, h) = (0.0, 0.5 / 4000.0);
        for _ in 0..4000 {
            let k1 = rate(v);
            let k2 = rate(v + 0.5 * h * k1);
            let k3 = rate(v + 0.5 * h * k2);
            v += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(v + h * k3));
        }
        let error = |steps: u32| {
            let step_s = 0.5 / f64::from(steps);
            let end = (0..steps)
                .fold(annulus.still(&mut Pieces::Free), |state, _| annulus.after(&state, step_s, &mut Pieces::Free));
            (end.acting_m_s[0] - v).abs()
        };
        let (coarse, fine) = (error(10), error(20));
        assert!(coarse < 1e-2 && (3.4..4.6).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
        let steady = annulus.settled(&mut Pieces::Free);
        approx::assert_relative_eq!(
            annulus.balanced_m_s(steady.acting_m_s[0], &mut Pieces::Free),
            steady.acting_m_s[0],
            max_relative = 1e-12
        );
        assert!(steady.acting_m_s[0] > 1.0, "{steady:?}");
        // steps as long as the time constant, the longest allowed in a model
        let far =
            (0..40).fold(annulus.still(&mut Pieces::Free), |state, _| annulus.after(&state, 0.8, &mut Pieces::Free));
        approx::assert_relative_eq!(far.acting_m_s[0], steady.acting_m_s[0], max_relative = 1e-6);
    }

    /// The steady state is also found on its own pieces, from lightly loaded annuli to such whose load without induced velocity exceeds the
    /// wind's pressure, where momentum theory of the steady piece has no value.
    #[test]
    fn the_steady_state_is_found_on_its_pieces() {
        let polar = plate();
        let mut beyond = 0;
        for tangential_m_s in [10.0, 30.0, 55.0, 90.0, 150.0] {
            for chord_m in [0.2, 0.7, 1.2, 4.0] {
                let approach = Approach { axial_m_s: 11.0, tangential_m_s, chord_angle_rad: 0.0 };
                let meeting = Meeting { approach, polar: &polar, chord_m, pitch_rate_rad_s: 0.0 };
                let share_1_m = 3.0 / (std::f64::consts::PI * 12.0);
                let annulus = Lagging { meeting, wind_m_s: 11.0, lean: 1.0, share_1_m, time_s: 0.8 };
                let mut list = PieceList::default();
                let steady = annulus.settled(&mut Pieces::Record(&mut list)).acting_m_s[0];
                let kept = annulus.settled(&mut Pieces::keep(&list)).acting_m_s[0];
                approx::assert_relative_eq!(
                    annulus.balanced_m_s(steady, &mut Pieces::Free),
                    steady,
                    max_relative = 1e-12
                );
                approx::assert_relative_eq!(kept, steady, max_relative = 1e-12);
                let load_m2_s2 = share_1_m * annulus.meeting.state([0.0; 2], &mut Pieces::Free).force_m3_s2(chord_m)[0];
                beyond += usize::from(steady < LINE[1] * 11.0 && load_m2_s2 > 11.0 * 11.0);
            }
        }
        assert!(beyond >= 2, "{beyond}");
    }
}
