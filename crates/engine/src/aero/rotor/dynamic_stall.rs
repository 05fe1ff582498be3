//! Dynamic stall: the incompressible Beddoes-Leishman model with four states.
//!
//! Source: Hansen, Gaunaa and Madsen, *A Beddoes–Leishman type dynamic stall model in state-space and indicial formulations*, Risø-R-1354
//! (2004); `UA_Mod` 4 in AeroDyn. The model has no leading-edge vortex.

use crate::aero::pieces::Pieces;
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::rotor::lag::lag;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Amplitudes of the two exponential terms of the wake's effect (Jones).
const AMPLITUDES: [f64; 2] = [0.3, 0.7];
/// Rates of the two terms per semi-chord travelled.
const RATES: [f64; 2] = [0.14, 0.53];
/// Time constant of the pressure lag in semi-chords travelled.
const PRESSURE_LAG: f64 = 1.7;
/// Time constant of the boundary-layer lag in semi-chords travelled.
const SEPARATION_LAG: f64 = 3.0;
/// Angle of attack in rad about which the model fades out (AeroDyn's `UACutout`, 45°), and half the width of the
/// transition.
const CUTOUT_RAD: [f64; 2] = [45.0 * PI / 180.0, 5.0 * PI / 180.0];
/// Smallest speed in m/s used in the time constants.
const MINIMUM_SPEED_M_S: f64 = 0.01;

/// Degree of attachment below which linearised models treat a section as separated.
pub const SEPARATED: f64 = 1e-6;

/// Static polar split into attached and separated flow, eq. (B12).
#[derive(Debug, Clone, PartialEq)]
pub struct SplitPolar {
    /// Static coefficients.
    pub polar: Polar,
    /// Zero-lift angle in rad.
    pub zero_lift_rad: f64,
    /// Lift-curve slope of attached flow in 1/rad: the steepest line from the zero-lift angle to a row with positive lift.
    pub slope_1_rad: f64,
    /// Drag coefficient at the zero-lift angle.
    zero_lift_drag: f64,
}

/// Static flow at an angle of attack.
struct StaticFlow {
    row: PolarRow,
    /// Square root of the degree of attachment.
    attached_root: f64,
    /// Lift of fully attached flow minus that of fully separated flow, the factor of the degree of attachment.
    gain: f64,
}

impl SplitPolar {
    /// Splits a static polar; `None` if its lift never rises through zero, as for a cylinder: such a section uses its static coefficients.
    pub fn new(polar: Polar) -> Option<Self> {
        let zero_lift_rad = polar.zero_lift_angle_rad()?;
        let above = polar.rows.partition_point(|row| row.angle_rad <= zero_lift_rad);
        // the first of these rows has positive lift, because the polar rises through zero just before it
        let lifting = polar.rows[above..]
            .iter()
            .take_while(|row| row.lift > 0.0 && row.angle_rad < zero_lift_rad + CUTOUT_RAD[0]);
        let steepest = lifting.map(|row| row.lift / (row.angle_rad - zero_lift_rad)).fold(0.0, f64::max);
        let zero_lift_drag = polar.at(zero_lift_rad).drag;
        (steepest > 0.0).then_some(Self { polar, zero_lift_rad, slope_1_rad: steepest, zero_lift_drag })
    }

    /// Angle of attack in rad at which attached flow has a given lift.
    fn angle_rad(&self, lift: f64) -> f64 {
        lift / self.slope_1_rad + self.zero_lift_rad
    }

    /// Static flow at a constant angle of attack in rad, from the inverse of Kirchhoff's relation. Flow with a lift above the line of
    /// attached flow is fully attached, with a lift below a quarter of it fully separated. The separated lift of Hansen, Gaunaa and Madsen
    /// is written in a form without the quotient 0/0.
    fn static_flow(&self, angle_rad: f64, pieces: &mut Pieces) -> StaticFlow {
        let row = pieces.row(&self.polar, angle_rad);
        let attached = self.slope_1_rad * (angle_rad - self.zero_lift_rad);
        let ratio = if attached == 0.0 { 1.0 } else { row.lift / attached };
        let (attached_root, gain) = if pieces.reaches(ratio, 1.0) {
            (1.0, 0.5 * row.lift)
        } else if pieces.holds(ratio > 0.25) {
            let root = 2.0 * ratio.sqrt() - 1.0;
            (root, attached * (3.0 + root) / (4.0 * (1.0 + root)))
        } else {
            (0.0, attached - row.lift)
        };
        StaticFlow { row, attached_root, gain }
    }

    /// Degree of attachment of static flow at an angle in rad.
    fn attached_at(&self, angle_rad: f64, pieces: &mut Pieces) -> f64 {
        self.static_flow(angle_rad, pieces).attached_root.powi(2)
    }
}

/// Inflow of a section at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StallInflow {
    /// Relative speed at the quarter chord in m/s.
    pub speed_m_s: f64,
    /// Angle of attack at the quarter chord in rad.
    pub attack_rad: f64,
    /// Pitch rate of the section, nose up positive, in rad/s.
    pub pitch_rate_rad_s: f64,
    /// Chord in m.
    pub chord_m: f64,
}

/// Dynamic-stall state of a section.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StallState {
    /// Two lagged terms of the downwash due to the wake, in rad.
    pub wake_rad: [f64; 2],
    /// Lift coefficient of attached flow after the pressure lag.
    pub lagged_lift: f64,
    /// Degree of attachment after the boundary-layer lag.
    pub attached: f64,
    /// Inflow at the time of this state.
    pub met: StallInflow,
}

/// Lift, drag and moment coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Lift coefficient, normal to the relative velocity at the quarter chord.
    pub lift: f64,
    /// Drag coefficient, along that velocity.
    pub drag: f64,
    /// Moment coefficient about the quarter chord, nose up positive.
    pub moment: f64,
}

impl StallInflow {
    /// Time in s in which the flow travels a semi-chord.
    fn passing_s(&self) -> f64 {
        0.5 * self.chord_m / self.speed_m_s.max(MINIMUM_SPEED_M_S)
    }

    /// Angle of attack at three quarters of the chord in rad, between −π and π.
    fn rear_rad(&self) -> f64 {
        let (sine, cosine) = self.attack_rad.sin_cos();
        (self.speed_m_s * sine + 0.5 * self.chord_m * self.pitch_rate_rad_s).atan2(self.speed_m_s * cosine)
    }
}

impl StallState {
    /// Steady state of a constant inflow.
    pub fn steady(met: StallInflow, split: &SplitPolar) -> Self {
        Self::steady_on(met, split, &mut Pieces::Free)
    }

    /// The same on pieces of its functions.
    pub fn steady_on(met: StallInflow, split: &SplitPolar, pieces: &mut Pieces) -> Self {
        let rear_rad = pieces.near(met.rear_rad());
        let mut state = Self { met, wake_rad: AMPLITUDES.map(|amplitude| amplitude * rear_rad), ..Self::default() };
        state.lagged_lift = state.attached_lift(split);
        state.attached = split.attached_at(split.angle_rad(state.lagged_lift), pieces);
        state
    }

    /// Effective angle of attack in rad.
    fn effective_rad(&self) -> f64 {
        self.met.rear_rad() * (1.0 - AMPLITUDES.iter().sum::<f64>()) + self.wake_rad.iter().sum::<f64>()
    }

    /// Lift coefficient of attached flow, eq. (B13).
    fn attached_lift(&self, split: &SplitPolar) -> f64 {
        split.slope_1_rad * (self.effective_rad() - split.zero_lift_rad)
            + PI * self.met.passing_s() * self.met.pitch_rate_rad_s
    }

    /// State one step later, eq. (B13): each lag is exact for an input that changes linearly, at the mean speed.
    pub fn after(&self, met: StallInflow, step_s: f64, split: &SplitPolar) -> Self {
        self.after_on(met, step_s, split, &mut Pieces::Free)
    }

    /// The same on pieces of its functions.
    pub fn after_on(&self, met: StallInflow, step_s: f64, split: &SplitPolar, pieces: &mut Pieces) -> Self {
        let distance = 2.0 * step_s / (self.met.passing_s() + met.passing_s());
        let rear_rad = [self.met.rear_rad(), met.rear_rad()].map(|angle_rad| pieces.near(angle_rad));
        let mut next = Self { met, ..*self };
        for ((wake, amplitude), rate) in next.wake_rad.iter_mut().zip(AMPLITUDES).zip(RATES) {
            *wake = lag(*wake, amplitude * rear_rad[0], amplitude * rear_rad[1], rate * distance);
        }
        let (from, to) = (self.attached_lift(split), next.attached_lift(split));
        next.lagged_lift = lag(self.lagged_lift, from, to, distance / PRESSURE_LAG);
        let [from, to] =
            [self.lagged_lift, next.lagged_lift].map(|lift| split.attached_at(split.angle_rad(lift), pieces));
        let attached = lag(self.attached, from, to, distance / SEPARATION_LAG);
        next.attached = pieces.within(attached, [0.0, 1.0]);
        next
    }

    /// Rates of the four states in 1/s at an instant, eq. (B13), the limit of [`StallState::after`] for short steps. The angle at three
    /// quarters of the chord jumps at 180°; if `unwrapped`, as derivatives need it, it is unwrapped to the value nearest to the lagged angle
    /// of the wake.
    pub fn rates_1_s(&self, split: &SplitPolar, unwrapped: bool) -> [f64; 4] {
        let remembered_rad = self.wake_rad.iter().sum::<f64>() / AMPLITUDES.iter().sum::<f64>();
        let rear_rad = self.met.rear_rad();
        let turns = if unwrapped { ((remembered_rad - rear_rad) / TAU).round() } else { 0.0 };
        let rear_rad = rear_rad + TAU * turns;
        let passing_s = self.met.passing_s();
        let effective_rad = split.angle_rad(self.lagged_lift);
        let [wake, second] =
            [0, 1].map(|term| RATES[term] * (AMPLITUDES[term] * rear_rad - self.wake_rad[term]) / passing_s);
        [
            wake,
            second,
            (self.attached_lift(split) - self.lagged_lift) / (PRESSURE_LAG * passing_s),
            (split.attached_at(effective_rad, &mut Pieces::Free) - self.attached) / (SEPARATION_LAG * passing_s),
        ]
    }

    /// Coefficients, eq. (B14); blended with the static ones between 40° and 50° of angle of attack, static beyond. An external integrator
    /// may set a degree of attachment below 0, whose square root is 0.
    pub fn coefficients(&self, split: &SplitPolar) -> Coefficients {
        self.coefficients_on(split, &mut Pieces::Free)
    }

    /// The same on pieces of its functions.
    pub fn coefficients_on(&self, split: &SplitPolar, pieces: &mut Pieces) -> Coefficients {
        // the slope of the root is infinite at 0, where sections stay that are separated from the start
        let separated = pieces.holds(self.attached <= 0.0);
        let attached_root = if separated { 0.0 } else { self.attached.clamp(0.0, f64::INFINITY).sqrt() };
        let plain = pieces.row(&split.polar, self.met.attack_rad);
        let static_row = Coefficients { lift: plain.lift, drag: plain.drag, moment: plain.moment };
        let [cutout_rad, half_rad] = CUTOUT_RAD;
        let x = pieces.within((self.met.attack_rad.abs() - cutout_rad + half_rad) / (2.0 * half_rad), [0.0, 1.0]);
        let weight = 0.5 * (1.0 + (PI * x).cos());
        if pieces.holds(weight == 0.0) {
            return static_row;
        }
        let effective_rad = self.effective_rad();
        let passing = self.met.passing_s() * self.met.pitch_rate_rad_s;
        let StaticFlow { row, attached_root: static_root, gain } = split.static_flow(effective_rad, pieces);
        let share = static_root * static_root;
        // starts from the static lift, which any split reproduces in the steady state
        let circulatory = row.lift + (self.attached - share) * gain;
        let lost = 0.5 * (static_root - attached_root) - 0.25 * (share - self.attached);
        let dynamic = Coefficients {
            lift: circulatory + PI * passing,
            drag: row.drag
                + (pieces.near(self.met.rear_rad()) - effective_rad + passing) * circulatory
                + (row.drag - split.zero_lift_drag) * lost,
            moment: row.moment - FRAC_PI_2 * passing,
        };
        let blend = |dynamic: f64, plain: f64| plain + weight * (dynamic - plain);
        Coefficients {
            lift: blend(dynamic.lift, static_row.lift),
            drag: blend(dynamic.drag, static_row.drag),
            moment: blend(dynamic.moment, static_row.moment),
        }
    }
}
