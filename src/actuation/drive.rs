//! Drive of a fold joint: spring to a commanded neutral angle, damper, constant torque, limits.

use serde::{Deserialize, Serialize};

/// Parameters of a drive, NOTATION eq. (A1).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// Spring stiffness `k` in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping `c` in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Constant torque `T` in N·m.
    pub constant_torque_n_m: f64,
    /// Largest magnitude of the torque in N·m.
    pub torque_limit_n_m: f64,
}

/// Torque of a drive and what it means for the Newton matrix and the energy accounts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveTorque {
    /// On the outer body about `+θ`, limited, in N·m.
    pub applied_n_m: f64,
    /// What the limit took away, in N·m.
    pub clipped_n_m: f64,
    /// Limit active: the torque does not depend on the angle.
    pub saturated: bool,
}

impl Drive {
    /// `clamp(−(k (θ − θ_cmd) + c θ̇ + T) + τ_ext, ±limit)`.
    pub fn torque(&self, angle_rad: f64, rate_rad_s: f64, neutral_rad: f64, external_n_m: f64) -> DriveTorque {
        let wanted = -(self.stiffness_n_m_rad * (angle_rad - neutral_rad)
            + self.damping_n_m_s_rad * rate_rad_s
            + self.constant_torque_n_m)
            + external_n_m;
        // not `clamp`, which panics on a limit that is negative or NaN
        let applied = wanted.max(-self.torque_limit_n_m).min(self.torque_limit_n_m);
        DriveTorque { applied_n_m: applied, clipped_n_m: applied - wanted, saturated: applied != wanted }
    }

    /// Potential of spring and constant torque in J: `½ k (θ − θ_cmd)² + T θ`.
    pub fn potential_j(&self, angle_rad: f64, neutral_rad: f64) -> f64 {
        let stretch = angle_rad - neutral_rad;
        0.5 * self.stiffness_n_m_rad * stretch * stretch + self.constant_torque_n_m * angle_rad
    }
}

/// Neutral angle on its way to the command at the rate limit, in closed form, NOTATION eq. (A2).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Slew {
    /// Angle at `start_s` in rad.
    pub from_rad: f64,
    /// Angle commanded in rad.
    pub target_rad: f64,
    /// Time at which the slew begins in s.
    pub start_s: f64,
    /// Largest rate in rad/s.
    pub rate_limit_rad_s: f64,
}

impl Slew {
    /// Neutral angle in rad and its rate in rad/s at `time_s`; after the end if the end itself.
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        self.at_on(time_s, time_s)
    }

    /// The same on the branch, before or after the end, on which `branch_s` lies.
    ///
    /// A step that ends at the kink must see the rate before it even where round-off puts its last stage beyond.
    pub fn at_on(&self, time_s: f64, branch_s: f64) -> (f64, f64) {
        let gap = self.target_rad - self.from_rad;
        if branch_s >= self.end_s() {
            return (self.target_rad, 0.0);
        }
        let rate = self.rate_limit_rad_s.copysign(gap);
        (self.from_rad + rate * (time_s - self.start_s), rate)
    }

    /// Time at which the command is reached in s.
    pub fn end_s(&self) -> f64 {
        let gap = (self.target_rad - self.from_rad).abs();
        if gap == 0.0 || gap <= 1e-12 * self.rate_limit_rad_s {
            self.start_s
        } else {
            self.start_s + gap / self.rate_limit_rad_s
        }
    }

    /// Turns towards a new command or limit at `time_s`.
    pub fn redirect(&mut self, time_s: f64, target_rad: f64, rate_limit_rad_s: f64) {
        *self = Self { from_rad: self.at(time_s).0, target_rad, start_s: time_s, rate_limit_rad_s };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slew_arrives_on_time_and_stays() {
        let mut slew = Slew { from_rad: 0.0, target_rad: 0.0, start_s: 0.0, rate_limit_rad_s: 2.0 };
        slew.redirect(1.0, -3.0, 2.0);
        assert_eq!(slew.at(1.5), (-1.0, -2.0));
        assert_eq!(slew.end_s(), 2.5);
        assert_eq!(slew.at(9.0), (-3.0, 0.0));
        slew.redirect(2.0, 5.0, 4.0);
        assert_eq!(slew.at(2.25), (-1.0, 4.0));
    }

    #[test]
    fn limit_clips_either_way() {
        let drive = Drive { stiffness_n_m_rad: 1.0, torque_limit_n_m: 0.5, ..Drive::default() };
        let low = drive.torque(2.0, 0.0, 0.0, 0.0);
        assert_eq!((low.applied_n_m, low.clipped_n_m, low.saturated), (-0.5, 1.5, true));
        let free = drive.torque(0.25, 0.0, 0.0, 0.0);
        assert_eq!((free.applied_n_m, free.saturated), (-0.25, false));
    }
}
