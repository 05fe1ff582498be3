//! Dynamic stall: Beddoes and Leishman's model in the incompressible form with four states.
//!
//! Source: Hansen, Gaunaa and Madsen, *A Beddoes–Leishman type dynamic stall model in state-space and indicial
//! formulations*, Risø-R-1354 (2004); it is `UA_Mod` 4 in AeroDyn. It does not model the leading-edge vortex.

use crate::aero::polar::{Polar, PolarRow};
use crate::aero::rotor::lag::lag;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Amplitudes of the two terms of the wake's memory (Jones).
const AMPLITUDES: [f64; 2] = [0.3, 0.7];
/// Their rates per semi-chord travelled.
const RATES: [f64; 2] = [0.14, 0.53];
/// Lag of the pressure in semi-chords travelled.
const PRESSURE_LAG: f64 = 1.7;
/// Lag of the boundary layer in semi-chords travelled.
const SEPARATION_LAG: f64 = 3.0;
/// Angle of attack in rad about which the model fades out (AeroDyn's `UACutout`, 45°), and half the width of the
/// transition.
const CUTOUT_RAD: [f64; 2] = [45.0 * PI / 180.0, 5.0 * PI / 180.0];
/// Smallest speed in m/s used in the time constants.
const MINIMUM_SPEED_M_S: f64 = 0.01;

/// Degree of attachment below which linear models treat a section as separated.
pub const SEPARATED: f64 = 1e-6;

/// Static polar split into attached and separated flow, eq. (B12).
#[derive(Debug, Clone, PartialEq)]
pub struct SplitPolar {
    /// Static coefficients.
    pub polar: Polar,
    /// Angle of zero lift in rad.
    pub zero_lift_rad: f64,
    /// Slope of the lift of attached flow in 1/rad: the steepest line from the angle of zero lift to a row with lift above it.
    pub slope_1_rad: f64,
    /// Drag coefficient at the angle of zero lift.
    zero_lift_drag: f64,
}

/// Static flow at an angle of attack.
struct StaticFlow {
    row: PolarRow,
    /// Square root of the degree of attachment.
    attached_root: f64,
    /// Lift of attached flow less that of separated flow: difference between degrees of attachment of 1 and 0.
    gain: f64,
}

impl SplitPolar {
    /// Splits a static polar; `None` if its lift never rises through zero, as for a cylinder: such a section uses its static coefficients.
    pub fn new(polar: Polar) -> Option<Self> {
        let zero_lift_rad = polar.zero_lift_angle_rad()?;
        let above = polar.rows.partition_point(|row| row.angle_rad <= zero_lift_rad);
        // the first row has lift, as the polar rises through zero just before it
        let lifting = polar.rows[above..]
            .iter()
            .take_while(|row| row.lift > 0.0 && row.angle_rad < zero_lift_rad + CUTOUT_RAD[0]);
        let steepest = lifting.map(|row| row.lift / (row.angle_rad - zero_lift_rad)).fold(0.0, f64::max);
        let zero_lift_drag = polar.at(zero_lift_rad).drag;
        (steepest > 0.0).then_some(Self { polar, zero_lift_rad, slope_1_rad: steepest, zero_lift_drag })
    }

    /// Angle in rad at which attached flow has a lift.
    fn angle_rad(&self, lift: f64) -> f64 {
        lift / self.slope_1_rad + self.zero_lift_rad
    }

    /// Flow at a constant angle of attack in rad: Kirchhoff's relation inverted. Static lift above the line of attached flow is attached,
    /// lift below a quarter of it is separated, and the separated lift of Hansen, Gaunaa and Madsen is written without its quotient 0/0.
    fn static_flow(&self, angle_rad: f64) -> StaticFlow {
        let row = self.polar.at(angle_rad);
        let attached = self.slope_1_rad * (angle_rad - self.zero_lift_rad);
        let ratio = if attached == 0.0 { 1.0 } else { row.lift / attached };
        let (attached_root, gain) = if ratio >= 1.0 {
            (1.0, 0.5 * row.lift)
        } else if ratio > 0.25 {
            let root = 2.0 * ratio.sqrt() - 1.0;
            (root, attached * (3.0 + root) / (4.0 * (1.0 + root)))
        } else {
            (0.0, attached - row.lift)
        };
        StaticFlow { row, attached_root, gain }
    }

    /// Degree of attachment of static flow at an angle in rad.
    fn attached_at(&self, angle_rad: f64) -> f64 {
        self.static_flow(angle_rad).attached_root.powi(2)
    }
}

/// Inflow of a section at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StallInflow {
    /// Relative speed at the quarter chord in m/s.
    pub speed_m_s: f64,
    /// Angle of attack at the quarter chord in rad.
    pub attack_rad: f64,
    /// Rate at which the section pitches, nose up positive, in rad/s.
    pub pitch_rate_rad_s: f64,
    /// Chord in m.
    pub chord_m: f64,
}

/// Memory of a section.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StallState {
    /// Two lagged terms of the wake's downwash, in rad.
    pub wake_rad: [f64; 2],
    /// Lift of attached flow after the lag of the pressure.
    pub lagged_lift: f64,
    /// Degree of attachment after the lag of the boundary layer.
    pub attached: f64,
    /// Inflow at this time.
    pub met: StallInflow,
}

/// Lift, drag and moment coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Lift: across the relative velocity at the quarter chord.
    pub lift: f64,
    /// Drag: along it.
    pub drag: f64,
    /// Moment about the quarter chord, nose up positive.
    pub moment: f64,
}

impl StallInflow {
    /// Time in s in which the air travels a semi-chord.
    fn passing_s(&self) -> f64 {
        0.5 * self.chord_m / self.speed_m_s.max(MINIMUM_SPEED_M_S)
    }

    /// Angle of attack at three quarters of the chord in rad.
    fn rear_rad(&self) -> f64 {
        let (sine, cosine) = self.attack_rad.sin_cos();
        (self.speed_m_s * sine + 0.5 * self.chord_m * self.pitch_rate_rad_s).atan2(self.speed_m_s * cosine)
    }
}

impl StallState {
    /// Steady state in a constant inflow.
    pub fn steady(met: StallInflow, split: &SplitPolar) -> Self {
        let rear_rad = met.rear_rad();
        let mut state = Self { met, wake_rad: AMPLITUDES.map(|amplitude| amplitude * rear_rad), ..Self::default() };
        state.lagged_lift = state.attached_lift(split);
        state.attached = split.attached_at(split.angle_rad(state.lagged_lift));
        state
    }

    /// Effective angle of attack in rad.
    fn effective_rad(&self) -> f64 {
        self.met.rear_rad() * (1.0 - AMPLITUDES.iter().sum::<f64>()) + self.wake_rad.iter().sum::<f64>()
    }

    /// Lift of attached flow, eq. (B13).
    fn attached_lift(&self, split: &SplitPolar) -> f64 {
        split.slope_1_rad * (self.effective_rad() - split.zero_lift_rad)
            + PI * self.met.passing_s() * self.met.pitch_rate_rad_s
    }

    /// State a step later, eq. (B13): each lag exact for an input that changes linearly, at the mean speed.
    pub fn after(&self, met: StallInflow, step_s: f64, split: &SplitPolar) -> Self {
        let ways = 2.0 * step_s / (self.met.passing_s() + met.passing_s());
        let rear_rad = [self.met.rear_rad(), met.rear_rad()];
        let mut next = Self { met, ..*self };
        for ((wake, amplitude), rate) in next.wake_rad.iter_mut().zip(AMPLITUDES).zip(RATES) {
            *wake = lag(*wake, amplitude * rear_rad[0], amplitude * rear_rad[1], rate * ways);
        }
        let (from, to) = (self.attached_lift(split), next.attached_lift(split));
        next.lagged_lift = lag(self.lagged_lift, from, to, ways / PRESSURE_LAG);
        let share = |lift: f64| split.attached_at(split.angle_rad(lift));
        next.attached =
            lag(self.attached, share(self.lagged_lift), share(next.lagged_lift), ways / SEPARATION_LAG).clamp(0.0, 1.0);
        next
    }

    /// Rates of the four states in 1/s at an instant, eq. (B13). The angle at three quarters of the chord is unwrapped to the turn nearest
    /// to that of the wake: it jumps at 180°.
    pub fn rates_1_s(&self, split: &SplitPolar) -> [f64; 4] {
        let remembered_rad = self.wake_rad.iter().sum::<f64>() / AMPLITUDES.iter().sum::<f64>();
        let rear_rad = self.met.rear_rad();
        let rear_rad = rear_rad + TAU * ((remembered_rad - rear_rad) / TAU).round();
        let passing_s = self.met.passing_s();
        let effective_rad = split.angle_rad(self.lagged_lift);
        let [wake, second] =
            [0, 1].map(|term| RATES[term] * (AMPLITUDES[term] * rear_rad - self.wake_rad[term]) / passing_s);
        [
            wake,
            second,
            (self.attached_lift(split) - self.lagged_lift) / (PRESSURE_LAG * passing_s),
            (split.attached_at(effective_rad) - self.attached) / (SEPARATION_LAG * passing_s),
        ]
    }

    /// Coefficients, eq. (B14); blended with the static ones between 40° and 50° of angle of attack, static beyond.
    pub fn coefficients(&self, split: &SplitPolar) -> Coefficients {
        self.coefficients_by(split, self.attached.sqrt())
    }

    /// The same beside a state, for derivatives: below [`SEPARATED`] the square root of the attachment, whose slope is infinite at 0, is 0.
    pub fn coefficients_beside(&self, split: &SplitPolar) -> Coefficients {
        let root = if self.attached < 0.9 * SEPARATED { 0.0 } else { self.attached.sqrt() };
        self.coefficients_by(split, root)
    }

    fn coefficients_by(&self, split: &SplitPolar, attached_root: f64) -> Coefficients {
        let plain = split.polar.at(self.met.attack_rad);
        let static_row = Coefficients { lift: plain.lift, drag: plain.drag, moment: plain.moment };
        let [cutout_rad, half_rad] = CUTOUT_RAD;
        let x = ((self.met.attack_rad.abs() - cutout_rad + half_rad) / (2.0 * half_rad)).clamp(0.0, 1.0);
        let weight = 0.5 * (1.0 + (PI * x).cos());
        if weight == 0.0 {
            return static_row;
        }
        let effective_rad = self.effective_rad();
        let passing = self.met.passing_s() * self.met.pitch_rate_rad_s;
        let StaticFlow { row, attached_root: static_root, gain } = split.static_flow(effective_rad);
        let share = static_root * static_root;
        // from the static lift, which is that of the steady state for any split
        let circulatory = row.lift + (self.attached - share) * gain;
        let lost = 0.5 * (static_root - attached_root) - 0.25 * (share - self.attached);
        let dynamic = Coefficients {
            lift: circulatory + PI * passing,
            drag: row.drag
                + (self.met.rear_rad() - effective_rad + passing) * circulatory
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
