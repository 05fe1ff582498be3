//! Motor of a fold joint: spring about a commanded neutral angle, damper, constant torque, limits.

use serde::{Deserialize, Serialize};

/// Parameters of a motor, NOTATION eq. (A1).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// Spring stiffness `k` in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping `c` in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Constant torque `T` in N·m.
    pub constant_torque_n_m: f64,
    /// Largest magnitude of the motor torque in N·m.
    pub torque_limit_n_m: f64,
}

/// Torque of a motor and whether it is limited, for the Newton matrix.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveTorque {
    /// Limited torque on the outer body about `+θ` in N·m.
    pub applied_n_m: f64,
    /// Whether the limit is active: the torque then does not depend on the angle.
    pub saturated: bool,
}

/// Piece of the clamp function of a limited torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece {
    /// Between the limits.
    Between,
    /// At the upper limit.
    Upper,
    /// At the lower limit.
    Lower,
}

/// Smooth pieces on which the clamped torques of a motor lie at a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pieces {
    /// Of the torque.
    pub moving: Piece,
    /// Of the torque at zero rate.
    pub still: Piece,
    /// Of the torque at zero rate and at the neutral angle.
    pub neutral: Piece,
}

impl Drive {
    /// Torque in N·m before limiting: `−(k_m (θ − θ_cmd) + c_m θ̇ + T)`.
    pub fn wanted_n_m(&self, angle_rad: f64, rate_rad_s: f64, neutral_rad: f64) -> f64 {
        -(self.stiffness_n_m_rad * (angle_rad - neutral_rad)
            + self.damping_n_m_s_rad * rate_rad_s
            + self.constant_torque_n_m)
    }

    /// Limited torque `clamp(−(k_m (θ − θ_cmd) + c_m θ̇ + T), ±limit)`.
    pub fn torque(&self, angle_rad: f64, rate_rad_s: f64, neutral_rad: f64) -> DriveTorque {
        let wanted = self.wanted_n_m(angle_rad, rate_rad_s, neutral_rad);
        // `clamp` would panic for a limit that is negative or NaN
        let applied = wanted.max(-self.torque_limit_n_m).min(self.torque_limit_n_m);
        DriveTorque { applied_n_m: applied, saturated: applied != wanted }
    }

    /// Piece of the clamp for a state, at most one piece away from `last`: a change from one limit to the other passes through the range
    /// between them.
    pub fn piece(&self, wanted_n_m: f64, last: Option<Piece>) -> Piece {
        let piece = if wanted_n_m > self.torque_limit_n_m {
            Piece::Upper
        } else if wanted_n_m < -self.torque_limit_n_m {
            Piece::Lower
        } else {
            Piece::Between
        };
        match (last, piece) {
            (Some(Piece::Upper), Piece::Lower) | (Some(Piece::Lower), Piece::Upper) => Piece::Between,
            _ => piece,
        }
    }

    /// Pieces of the torques at a state.
    pub fn pieces(&self, angle_rad: f64, rate_rad_s: f64, neutral_rad: f64) -> Pieces {
        let [moving, still, neutral] =
            self.wanted_by_piece_n_m(angle_rad, rate_rad_s, neutral_rad).map(|wanted_n_m| self.piece(wanted_n_m, None));
        Pieces { moving, still, neutral }
    }

    /// Whether one of these torques is at a limit to within a share of it.
    pub fn is_at_limit(&self, angle_rad: f64, rate_rad_s: f64, neutral_rad: f64, share: f64) -> bool {
        let limit_n_m = self.torque_limit_n_m;
        let wanted = self.wanted_by_piece_n_m(angle_rad, rate_rad_s, neutral_rad);
        wanted.iter().any(|wanted_n_m| (wanted_n_m.abs() - limit_n_m).abs() <= share * limit_n_m)
    }

    /// Torques in N·m before limiting: at a state, at zero rate, and there at the neutral angle.
    fn wanted_by_piece_n_m(&self, angle_rad: f64, rate_rad_s: f64, neutral_rad: f64) -> [f64; 3] {
        [
            self.wanted_n_m(angle_rad, rate_rad_s, neutral_rad),
            self.wanted_n_m(angle_rad, 0.0, neutral_rad),
            self.wanted_n_m(neutral_rad, 0.0, neutral_rad),
        ]
    }

    /// Torque on one piece of the clamp, extrapolated beyond its ends.
    pub fn torque_on(&self, piece: Piece, wanted_n_m: f64) -> DriveTorque {
        match piece {
            Piece::Between => DriveTorque { applied_n_m: wanted_n_m, saturated: false },
            Piece::Upper => DriveTorque { applied_n_m: self.torque_limit_n_m, saturated: true },
            Piece::Lower => DriveTorque { applied_n_m: -self.torque_limit_n_m, saturated: true },
        }
    }

    /// Power dissipated by a moving motor in W: that of the difference between its torque and its torque at zero rate; never negative, and
    /// `c_m θ̇²` within the limits, NOTATION eq. (A5).
    pub fn dissipation_w(
        &self,
        pieces: Pieces,
        torque: DriveTorque,
        [angle_rad, rate_rad_s]: [f64; 2],
        neutral_rad: f64,
    ) -> f64 {
        let still = self.torque_on(pieces.still, self.wanted_n_m(angle_rad, 0.0, neutral_rad));
        if torque.saturated || still.saturated {
            (still.applied_n_m - torque.applied_n_m) * rate_rad_s
        } else {
            self.damping_n_m_s_rad * rate_rad_s * rate_rad_s
        }
    }

    /// Potential in J of the torque at zero rate, `clamp(−(k_m (θ − θ_cmd) + T), ±limit)`: within the limits `½ k_m (θ − θ_cmd)² + T θ`,
    /// beyond them linear in the angle, NOTATION eq. (A5).
    pub fn potential_j(&self, angle_rad: f64, neutral_rad: f64) -> f64 {
        self.potential_on_j(self.pieces(angle_rad, 0.0, neutral_rad), angle_rad, neutral_rad)
    }

    /// The same potential with the torques at zero rate on given pieces, continued beyond their ends.
    pub fn potential_on_j(&self, pieces: Pieces, angle_rad: f64, neutral_rad: f64) -> f64 {
        let Self { stiffness_n_m_rad: k, constant_torque_n_m: t, torque_limit_n_m: limit, .. } = *self;
        let stretch = angle_rad - neutral_rad;
        let Pieces { still, neutral, .. } = pieces;
        match (still, neutral) {
            (Piece::Between, Piece::Between) => 0.5 * k * stretch * stretch + t * angle_rad,
            (Piece::Upper, Piece::Upper) => -limit * angle_rad,
            (Piece::Lower, Piece::Lower) => limit * angle_rad,
            (Piece::Between | Piece::Upper | Piece::Lower, Piece::Between | Piece::Upper | Piece::Lower) => {
                // integral of the torque at zero rate, with the opposite sign, from the neutral angle on one piece
                let integral = |piece: Piece, x: f64| {
                    let inside = |x: f64| x * (0.5 * k * x + t);
                    let end = |torque: f64| (torque - t) / k;
                    match piece {
                        Piece::Between => inside(x),
                        Piece::Upper => inside(end(-limit)) + limit * (end(-limit) - x),
                        Piece::Lower => inside(end(limit)) + limit * (x - end(limit)),
                    }
                };
                let constant = -self.torque_on(neutral, -t).applied_n_m;
                integral(still, stretch) - integral(neutral, 0.0) + constant * neutral_rad
            }
        }
    }

    /// Rate of change of the potential in W due to the motion of the neutral angle alone.
    pub fn slew_power_w(&self, angle_rad: f64, neutral_rad: f64, slew_rate_rad_s: f64) -> f64 {
        self.slew_power_on_w(self.pieces(angle_rad, 0.0, neutral_rad), angle_rad, neutral_rad, slew_rate_rad_s)
    }

    /// The same with the torques at zero rate on given pieces.
    pub fn slew_power_on_w(&self, pieces: Pieces, angle_rad: f64, neutral_rad: f64, slew_rate_rad_s: f64) -> f64 {
        let Pieces { still, neutral, .. } = pieces;
        if (still, neutral) == (Piece::Between, Piece::Between) {
            return -self.stiffness_n_m_rad * (angle_rad - neutral_rad) * slew_rate_rad_s;
        }
        let on =
            |piece: Piece, at_rad: f64| self.torque_on(piece, self.wanted_n_m(at_rad, 0.0, neutral_rad)).applied_n_m;
        (on(still, angle_rad) - on(neutral, neutral_rad)) * slew_rate_rad_s
    }
}

/// Motion of the neutral angle to the command at the rate limit, in closed form, NOTATION eq. (A2). The command itself may change linearly
/// in time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Slew {
    /// Neutral angle at `start_s` in rad.
    pub from_rad: f64,
    /// Commanded angle at `start_s` in rad.
    pub target_rad: f64,
    /// Rate of the command in rad/s.
    pub target_rate_rad_s: f64,
    /// Start of the slew in s.
    pub start_s: f64,
    /// Largest rate of the neutral angle in rad/s.
    pub rate_limit_rad_s: f64,
}

/// Part of a slew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlewPart {
    /// The neutral angle approaches the command at the rate limit.
    Closing,
    /// With the command.
    With,
    /// Behind a command that moves faster than the rate limit.
    Behind,
}

/// Smooth piece of a slew: its part, and the directions in which the neutral angle moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlewPiece {
    /// Part.
    pub part: SlewPart,
    /// Direction from the neutral angle at the start to the command, 1 or −1.
    gap_sign: f64,
    /// Direction of the command, 1 or −1.
    target_sign: f64,
}

impl Slew {
    /// Neutral angle in rad and its rate in rad/s at `time_s`; at the end of the slew, the values after it.
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        self.at_on(time_s, time_s)
    }

    /// Angle and rate at `time_s` on the branch selected by `branch_s`, before or after the end of the slew.
    ///
    /// A step that ends at the kink must use the rate before it even if round-off puts its last stage after it.
    pub fn at_on(&self, time_s: f64, branch_s: f64) -> (f64, f64) {
        self.on(time_s, self.piece(branch_s))
    }

    /// Smooth piece at a time.
    pub fn piece(&self, branch_s: f64) -> SlewPiece {
        let part = if branch_s < self.end_s() {
            SlewPart::Closing
        } else if self.target_rate_rad_s.abs() <= self.rate_limit_rad_s {
            SlewPart::With
        } else {
            SlewPart::Behind
        };
        let gap_rad = self.target_rad - self.from_rad;
        SlewPiece { part, gap_sign: gap_rad.signum(), target_sign: self.target_rate_rad_s.signum() }
    }

    /// Angle and rate at `time_s` on a piece, continued beyond its ends.
    pub fn on(&self, time_s: f64, piece: SlewPiece) -> (f64, f64) {
        let target = |time_s: f64| self.target_rad + self.target_rate_rad_s * (time_s - self.start_s);
        match piece.part {
            SlewPart::Closing => {
                let rate = self.rate_limit_rad_s * piece.gap_sign;
                (self.from_rad + rate * (time_s - self.start_s), rate)
            }
            SlewPart::With => (target(time_s), self.target_rate_rad_s),
            SlewPart::Behind => {
                let (rate, end_s) = (self.rate_limit_rad_s * piece.target_sign, self.end_on_s(piece));
                (target(end_s) + rate * (time_s - end_s), rate)
            }
        }
    }

    /// Time in s at which the command is reached on a piece; the start, if it moves away too fast.
    pub fn end_on_s(&self, piece: SlewPiece) -> f64 {
        let closing_rad_s = self.rate_limit_rad_s - self.target_rate_rad_s * piece.gap_sign;
        let gap_rad = (self.target_rad - self.from_rad) * piece.gap_sign;
        if closing_rad_s > 0.0 { self.start_s + gap_rad / closing_rad_s } else { self.start_s }
    }

    /// Time in s at which the command is reached; infinite if it moves away too fast.
    pub fn end_s(&self) -> f64 {
        let gap = self.target_rad - self.from_rad;
        if gap.abs() <= 1e-12 * self.rate_limit_rad_s || gap == 0.0 {
            return self.start_s;
        }
        let closing_rad_s = self.rate_limit_rad_s - self.target_rate_rad_s * gap.signum();
        if closing_rad_s > 0.0 { self.start_s + gap.abs() / closing_rad_s } else { f64::INFINITY }
    }

    /// Starts a slew at `time_s` towards a new command, which is `target_rad` then and moves at `target_rate_rad_s`.
    pub fn redirect(&mut self, time_s: f64, target_rad: f64, target_rate_rad_s: f64, rate_limit_rad_s: f64) {
        let from_rad = self.at(time_s).0;
        *self = Self { from_rad, target_rad, target_rate_rad_s, start_s: time_s, rate_limit_rad_s };
    }

    /// Whether the neutral angle follows a small change of the command immediately, because no rate limit is active. A limit that allows a
    /// radian within the timing accuracy of slews is not active.
    pub fn follows_at_once(&self) -> bool {
        self.rate_limit_rad_s >= 1e12
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slew_arrives_on_time_and_stays() {
        let mut slew = Slew { rate_limit_rad_s: 2.0, ..Slew::default() };
        slew.redirect(1.0, -3.0, 0.0, 2.0);
        assert_eq!(slew.at(1.5), (-1.0, -2.0));
        assert_eq!(slew.end_s(), 2.5);
        assert_eq!(slew.at(9.0), (-3.0, 0.0));
        slew.redirect(2.0, 5.0, 0.0, 4.0);
        assert_eq!(slew.at(2.25), (-1.0, 4.0));
    }

    #[test]
    fn slew_catches_a_moving_command_and_stays_with_it_as_far_as_the_limit_allows() {
        let start = Slew { rate_limit_rad_s: 2.0, ..Slew::default() };
        let towards = |target_rad, rate_rad_s, limit_rad_s| {
            let mut slew = start;
            slew.redirect(1.0, target_rad, rate_rad_s, limit_rad_s);
            slew
        };
        let ahead = towards(1.0, 1.5, 2.0);
        assert_eq!((ahead.end_s(), ahead.at(2.0), ahead.at(4.0)), (3.0, (2.0, 2.0), (5.5, 1.5)));
        let coming = towards(1.0, -3.0, 2.0);
        assert_eq!((coming.end_s(), coming.at(1.1).1, coming.at(2.2).1), (1.2, 2.0, -2.0));
        assert!((coming.at(2.2).0 + 1.6).abs() < 1e-15, "round-off: met at 0.4 rad, back for 1 s at the limit");
        let away = towards(1.0, 2.5, 2.0);
        assert_eq!((away.end_s(), away.at(3.0)), (f64::INFINITY, (4.0, 2.0)));
        let unlimited = towards(1.0, 50.0, 1e30);
        assert_eq!((unlimited.end_s(), unlimited.at(1.5)), (1.0, (26.0, 50.0)));
    }

    #[test]
    fn limit_clips_either_way() {
        let drive = Drive { stiffness_n_m_rad: 1.0, torque_limit_n_m: 0.5, ..Drive::default() };
        let low = drive.torque(2.0, 0.0, 0.0);
        assert_eq!((low.applied_n_m, low.saturated), (-0.5, true));
        let free = drive.torque(0.25, 0.0, 0.0);
        assert_eq!((free.applied_n_m, free.saturated), (-0.25, false));
    }

    /// The derivatives of the potential are the torque at zero rate and the power of a slew, on all pieces of the clamp; motion dissipates
    /// energy.
    #[test]
    fn potential_belongs_to_the_clamped_torque() {
        let step = 1e-6;
        for (k, t) in [(1.0, 0.2), (1.0, -0.9), (0.0, 0.8), (20.0, 0.0), (1e-9, 0.7)] {
            let drive =
                Drive { stiffness_n_m_rad: k, damping_n_m_s_rad: 0.1, constant_torque_n_m: t, torque_limit_n_m: 0.5 };
            for angle in [-3.0, -0.45, 0.1, 0.62, 2.0] {
                let (neutral, rate) = (0.05, 1.7);
                let slope = (drive.potential_j(angle + step, neutral) - drive.potential_j(angle - step, neutral))
                    / (2.0 * step);
                let torque = drive.torque(angle, 0.0, neutral).applied_n_m;
                assert!((slope + torque).abs() < 1e-8, "k {k}, T {t}, {angle} rad: {slope} against {torque} N·m");
                let by_neutral = (drive.potential_j(angle, neutral + step) - drive.potential_j(angle, neutral - step))
                    / (2.0 * step);
                let power = drive.slew_power_w(angle, neutral, 1.0);
                assert!((by_neutral - power).abs() < 1e-8, "k {k}, T {t}, {angle} rad: {by_neutral} against {power} W");
                for rate in [rate, -rate] {
                    let turning = drive.torque(angle, rate, neutral);
                    let pieces = drive.pieces(angle, rate, neutral);
                    let dissipated = drive.dissipation_w(pieces, turning, [angle, rate], neutral);
                    // the power of the torque that the rate takes away, also where only one of the two torques is limited
                    let lost = (torque - turning.applied_n_m) * rate;
                    assert!((dissipated - lost).abs() < 1e-12, "k {k}, T {t}, {angle} rad: {dissipated} of {lost} W");
                    assert!(dissipated >= 0.0);
                }
            }
        }
    }
}
