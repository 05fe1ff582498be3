//! Spring and damper of a fold joint, in addition to its motor.

use crate::force::{Here, Push};

/// Parameters of a joint's spring and damper, NOTATION eq. (A1). No limit acts on them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spring {
    /// Stiffness `k` in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping `c` in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Angle `θ_0` in rad at which the spring is unloaded.
    pub rest_angle_rad: f64,
}

impl Spring {
    /// Torque on the outer body about `+θ` in N·m: `−(k (θ − θ_0) + c θ̇)`.
    pub fn torque_n_m(&self, angle_rad: f64, rate_rad_s: f64) -> f64 {
        -(self.stiffness_n_m_rad * (angle_rad - self.rest_angle_rad) + self.damping_n_m_s_rad * rate_rad_s)
    }

    /// Stored energy in J: `½ k (θ − θ_0)²`.
    pub fn energy_j(&self, angle_rad: f64) -> f64 {
        0.5 * self.stiffness_n_m_rad * (angle_rad - self.rest_angle_rad).powi(2)
    }
    /// Adds the torque and its tangent.
    pub fn push(&self, here: &Here, sum: &mut Push) {
        sum.torque_n_m += self.torque_n_m(here.angle_rad, here.rate_rad_s);
        sum.tangent.stiffness += self.stiffness_n_m_rad;
        sum.tangent.damping += self.damping_n_m_s_rad;
    }

    /// Power dissipated by the damper in W.
    pub fn dissipation_w(&self, rate_rad_s: f64) -> f64 {
        self.damping_n_m_s_rad * rate_rad_s * rate_rad_s
    }
}
