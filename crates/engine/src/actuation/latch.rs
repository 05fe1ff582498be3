//! Latch of a fold joint.

use serde::{Deserialize, Serialize};

/// What a closed latch does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatchKind {
    /// A spring about its angle, NOTATION eq. (A3).
    Elastic,
    /// Holds the angle at which it has caught the joint, NOTATION eq. (A7).
    Rigid,
}

/// Parameters of a latch, NOTATION eqs. (A3) and (A7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Latch {
    /// What it does when closed.
    pub kind: LatchKind,
    /// Angle at which it closes in rad.
    pub angle_rad: f64,
    /// Stiffness when closed in N·m/rad; 0 of a rigid one, which holds by its reaction.
    pub stiffness_n_m_rad: f64,
    /// Half-width of the window that catches the joint, rad.
    pub capture_rad: f64,
}

impl Latch {
    /// Whether an angle lies in the window: there an enabled latch is closed.
    pub fn catches(&self, angle_rad: f64) -> bool {
        self.beyond_rad(angle_rad) <= 0.0
    }

    /// Distance of an angle from the window in rad; not positive inside.
    pub fn beyond_rad(&self, angle_rad: f64) -> f64 {
        (angle_rad - self.angle_rad).abs() - self.capture_rad
    }

    /// Way left to the window in rad for a joint that comes from `from_rad`, outside of it: falls through zero where the
    /// window is reached, whichever side that is, and goes on falling beyond.
    pub fn gap_rad(&self, from_rad: f64, angle_rad: f64) -> f64 {
        let side = if from_rad < self.angle_rad { -1.0 } else { 1.0 };
        side * (angle_rad - self.angle_rad) - self.capture_rad
    }

    /// Whether it holds the joint without a spring.
    pub fn is_rigid(&self) -> bool {
        self.kind == LatchKind::Rigid
    }

    /// Edge of the window in rad that a joint reaches from `from_rad`, outside of it.
    pub fn edge_rad(&self, from_rad: f64) -> f64 {
        self.angle_rad + if from_rad < self.angle_rad { -self.capture_rad } else { self.capture_rad }
    }

    /// Torque of the spring on the outer body about `+θ` in N·m when closed.
    pub fn torque_n_m(&self, angle_rad: f64) -> f64 {
        -self.stiffness_n_m_rad * (angle_rad - self.angle_rad)
    }

    /// Energy that the spring stores when closed in J.
    pub fn energy_j(&self, angle_rad: f64) -> f64 {
        0.5 * self.stiffness_n_m_rad * (angle_rad - self.angle_rad).powi(2)
    }
}

/// State of a latch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LatchState {
    /// Closed.
    pub closed: bool,
    /// May close.
    pub enabled: bool,
    /// Time of the last closing in s; −1 before the first.
    pub time_s: f64,
    /// Number of closings.
    pub count: i32,
    /// Impulse of the last closing on the outer body about `+θ` in N·m·s, of a rigid latch; 0 before the first.
    pub impulse_n_m_s: f64,
}
