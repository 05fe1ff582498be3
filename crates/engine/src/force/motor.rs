//! Motor of a joint: its torque law, the slew of its neutral angle, and the active piece of its limits.

use crate::force::dc_motor::Armature;
use crate::force::drive::{Drive, DriveTorque, Piece, Pieces, Slew, SlewPart, SlewPiece};
use crate::force::memory::{JointMemory, Told};
use crate::force::{Here, Outcome, Push};
use crate::solve::Powers;

/// Value for "no limit" in limits that must be finite numbers (FMI forbids infinity in the description).
pub const UNLIMITED: f64 = 1e30;

/// A motor with its current state of operation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motor {
    /// Stiffness, damping, constant torque, limit.
    pub drive: Drive,
    /// Motion of the neutral angle.
    pub slew: Slew,
    /// Tangent of the motor, used for linearised models and derivatives with respect to inputs.
    pub tangent: Option<MotorTangent>,
    /// Selected piece of the limits, eq. (T12); `None` if it follows from the state.
    pub piece: Option<Piece>,
    /// Smooth pieces for derivatives with respect to parameters and time, eq. (X34); `None` if they follow from the state.
    pub held: Option<HeldMotor>,
    /// Whether the motor ignores commands (runaway failure).
    pub deaf: bool,
    /// Armature of a DC motor on the same joint, eqs. (A12)–(A14). Limits, slew and failures do not act on it.
    pub armature: Option<Armature>,
}

/// Tangent of a motor about a state: the active piece of the limits is fixed, and the potential is linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorTangent {
    /// Piece of the limits; the inner piece if the torque is exactly at a limit.
    piece: Piece,
    angle_rad: f64,
    neutral_rad: f64,
    /// Potential in J, and its derivatives with respect to the angle and the neutral angle in N·m.
    potential_j: f64,
    slopes_n_m: [f64; 2],
}

/// Smooth pieces of a motor: of its clamped torques and of its slew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldMotor {
    /// Pieces of the torques.
    pieces: Pieces,
    /// Piece of the slew.
    slew: SlewPiece,
}

impl HeldMotor {
    /// Pieces of the torques and part of the slew.
    pub fn pieces(self) -> (Pieces, SlewPart) {
        (self.pieces, self.slew.part)
    }
}

impl Motor {
    /// Keeps the pieces at a state, with the slew on the branch of the second time.
    pub fn hold(&mut self, [time_s, branch_s]: [f64; 2], angle_rad: f64, rate_rad_s: f64) {
        let slew = self.slew.piece(branch_s);
        let pieces = self.drive.pieces(angle_rad, rate_rad_s, self.slew.on(time_s, slew).0);
        self.held = Some(HeldMotor { pieces, slew });
    }

    /// The held pieces of the torques, or those at a state.
    fn pieces(&self, angle_rad: f64, rate_rad_s: f64, neutral_rad: f64) -> Pieces {
        self.held.map_or_else(|| self.drive.pieces(angle_rad, rate_rad_s, neutral_rad), |held| held.pieces)
    }

    /// Whether the torque is at its limit to within a share of it.
    pub fn is_at_limit(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64, share: f64) -> bool {
        let drive = &self.drive;
        drive.torque_limit_n_m < UNLIMITED && drive.is_at_limit(angle_rad, rate_rad_s, self.neutral(time_s).0, share)
    }

    /// Neutral angle in rad and its rate in rad/s.
    pub fn neutral(&self, time_s: f64) -> (f64, f64) {
        self.neutral_on(time_s, time_s)
    }

    /// The same on the branch of the slew selected by `branch_s`.
    fn neutral_on(&self, time_s: f64, branch_s: f64) -> (f64, f64) {
        match self.held {
            Some(held) => self.slew.on(time_s, held.slew),
            None => self.slew.at_on(time_s, branch_s),
        }
    }

    /// Whether the neutral angle moves at a time.
    pub fn slews_at(&self, branch_s: f64) -> bool {
        self.slew.at(branch_s).1 != 0.0
    }

    /// Sets the tangent at a state.
    pub fn linearize(&mut self, time_s: f64, angle_rad: f64, rate_rad_s: f64) {
        let neutral_rad = self.slew.at(time_s).0;
        self.tangent = Some(MotorTangent {
            piece: self.drive.piece(self.wanted_n_m(time_s, angle_rad, rate_rad_s), None),
            angle_rad,
            neutral_rad,
            potential_j: self.drive.potential_j(angle_rad, neutral_rad),
            slopes_n_m: [
                -self.drive.torque(angle_rad, 0.0, neutral_rad).applied_n_m,
                self.drive.slew_power_w(angle_rad, neutral_rad, 1.0),
            ],
        });
    }

    /// Torque at a state, on the selected piece of the limits if there is one.
    pub fn torque(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> DriveTorque {
        let held = self.held.map(|held| held.pieces.moving);
        match self.piece.or(held).or(self.tangent.as_ref().map(|tangent| tangent.piece)) {
            Some(piece) => self.drive.torque_on(piece, self.wanted_n_m(time_s, angle_rad, rate_rad_s)),
            None => self.drive.torque(angle_rad, rate_rad_s, self.neutral(time_s).0),
        }
    }

    /// Torque in N·m before limiting.
    fn wanted_n_m(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> f64 {
        self.drive.wanted_n_m(angle_rad, rate_rad_s, self.neutral(time_s).0)
    }

    /// Adds the torque and its tangent.
    pub fn push(&self, here: &Here, sum: &mut Push) {
        let Here { time_s, angle_rad, rate_rad_s, .. } = *here;
        let torque = self.torque(time_s, angle_rad, rate_rad_s);
        sum.torque_n_m += torque.applied_n_m;
        if !torque.saturated {
            sum.tangent.stiffness += self.drive.stiffness_n_m_rad;
            sum.tangent.damping += self.drive.damping_n_m_s_rad;
        }
        if let Some(armature) = &self.armature {
            sum.torque_n_m += armature.circuit.torque_n_m(here.v);
        }
    }

    /// Adds work and dissipation, NOTATION eq. (A5).
    pub fn add_powers(&self, here: &Here, powers: &mut Powers) {
        let Here { time_s, branch_s, angle_rad, rate_rad_s, .. } = *here;
        let (neutral_rad, slew_rate_rad_s) = self.neutral_on(time_s, branch_s);
        let torque = self.torque(time_s, angle_rad, rate_rad_s);
        let pieces = self.pieces(angle_rad, rate_rad_s, neutral_rad);
        powers.work += self.drive.slew_power_on_w(pieces, angle_rad, neutral_rad, slew_rate_rad_s);
        powers.dissipated += self.drive.dissipation_w(pieces, torque, [angle_rad, rate_rad_s], neutral_rad);
        if let Some(armature) = &self.armature {
            armature.add_powers(here, powers);
        }
    }

    /// Power of the work per rate of the neutral angle, in N·m.
    pub fn work_per_slew_rate_n_m(&self, here: &Here) -> f64 {
        let (neutral_rad, _) = self.neutral_on(here.time_s, here.branch_s);
        let pieces = self.pieces(here.angle_rad, here.rate_rad_s, neutral_rad);
        self.drive.slew_power_on_w(pieces, here.angle_rad, neutral_rad, 1.0)
    }

    /// Distances to both torque limits in N·m, negative beyond them; 1 without limits.
    pub fn limit_distances_n_m(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> [f64; 2] {
        let limit_n_m = self.drive.torque_limit_n_m;
        if limit_n_m >= UNLIMITED {
            return [1.0; 2];
        }
        let wanted_n_m = self.wanted_n_m(time_s, angle_rad, rate_rad_s);
        [limit_n_m - wanted_n_m, limit_n_m + wanted_n_m]
    }

    /// Stored energy in J.
    pub fn potential_j(&self, here: &Here) -> f64 {
        let neutral_rad = self.neutral(here.time_s).0;
        match &self.tangent {
            None => {
                let pieces = self.pieces(here.angle_rad, here.rate_rad_s, neutral_rad);
                self.drive.potential_on_j(pieces, here.angle_rad, neutral_rad)
            }
            Some(tangent) => {
                let [by_angle_n_m, by_neutral_n_m] = tangent.slopes_n_m;
                tangent.potential_j
                    + by_angle_n_m * (here.angle_rad - tangent.angle_rad)
                    + by_neutral_n_m * (neutral_rad - tangent.neutral_rad)
            }
        }
    }

    /// Selects the piece of the limits for a state; returns whether the piece has changed.
    pub fn move_piece(&mut self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> bool {
        if self.tangent.is_some() || self.drive.torque_limit_n_m >= UNLIMITED {
            return false;
        }
        let piece = self.drive.piece(self.wanted_n_m(time_s, angle_rad, rate_rad_s), self.piece);
        self.piece.replace(piece) != Some(piece)
    }

    /// Moves the neutral angle to `neutral_rad`, and scales constant torque and voltage to a fraction of those of `whole`.
    pub(super) fn scale(&mut self, whole: &Self, neutral_rad: f64, factor: f64) {
        (self.slew.from_rad, self.slew.target_rad) = (neutral_rad, neutral_rad);
        self.drive.constant_torque_n_m = factor * whole.drive.constant_torque_n_m;
        if let (Some(armature), Some(whole)) = (&mut self.armature, &whole.armature) {
            armature.voltage_v = factor * whole.voltage_v;
        }
    }

    /// Restores the slew of the neutral angle from the memory.
    pub fn recall(&mut self, memory: &JointMemory) {
        self.slew = memory.slew;
    }

    /// Redirects the slew of the neutral angle to the current command.
    pub fn take_inputs(told: &Told, memory: &mut JointMemory) -> Outcome {
        memory.slew.redirect(told.time_s, told.command_rad, told.command_rate_rad_s, told.rate_limit_rad_s);
        Outcome::default()
    }

    /// End of the slew in s if it is after `time_s`.
    pub fn next_kink_s(&self, time_s: f64) -> f64 {
        let end_s = self.slew.end_s();
        if end_s > time_s { end_s } else { f64::INFINITY }
    }

    /// Whether a slew ends at `time_s`.
    pub fn kink_at(&self, time_s: f64) -> bool {
        self.slew.from_rad != self.slew.target_rad && self.slew.end_s() == time_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each limit has a distance that is positive within the limit, falls through zero at it, and is negative beyond; a motor without
    /// limits never reaches zero.
    #[test]
    fn distances_from_both_limits_change_sign_where_the_motor_meets_them() {
        let drive =
            Drive { stiffness_n_m_rad: 2.0, damping_n_m_s_rad: 0.5, constant_torque_n_m: 0.25, torque_limit_n_m: 3.0 };
        let motor = Motor { drive, ..Motor::default() };
        let mut seen = [0; 3];
        for (angle, rate) in (-20..=20).flat_map(|angle| (-4..=4).map(move |rate| (angle, rate))) {
            let (angle_rad, rate_rad_s) = (0.15 * f64::from(angle) + 0.01, 0.7 * f64::from(rate));
            let [upper_n_m, lower_n_m] = motor.limit_distances_n_m(0.0, angle_rad, rate_rad_s);
            let piece = drive.piece(drive.wanted_n_m(angle_rad, rate_rad_s, 0.0), None);
            assert_eq!([upper_n_m < 0.0, lower_n_m < 0.0], [piece == Piece::Upper, piece == Piece::Lower]);
            // the torque has a kink there and no jump
            let applied_n_m = motor.torque(0.0, angle_rad, rate_rad_s).applied_n_m;
            let left_n_m = [upper_n_m, lower_n_m].map(|left_n_m: f64| left_n_m.clamp(0.0, 6.0));
            assert!((left_n_m[0] - (3.0 - applied_n_m)).abs() < 1e-12, "{angle_rad} rad: {left_n_m:?}");
            assert!((left_n_m[1] - (3.0 + applied_n_m)).abs() < 1e-12, "{angle_rad} rad: {left_n_m:?}");
            seen[piece as usize] += 1;
        }
        assert!(seen.iter().all(|count| *count > 20), "all pieces occur: {seen:?}");
        let unlimited = Motor { drive: Drive { torque_limit_n_m: UNLIMITED, ..drive }, ..motor };
        assert_eq!(unlimited.limit_distances_n_m(0.0, 100.0, 0.0), [1.0; 2]);
    }
}
