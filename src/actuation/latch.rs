//! Latch of a fold joint.

use serde::{Deserialize, Serialize};

/// Parameters of a latch, NOTATION eq. (A3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Latch {
    /// Angle at which it closes in rad.
    pub angle_rad: f64,
    /// Stiffness when closed in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Half-width of the window in which enabling closes it at once, rad.
    pub capture_rad: f64,
    /// `+1` or `−1`: the folded side is where `side·(θ − angle)` is positive.
    pub side: f64,
}

impl Latch {
    /// Side of a joint that starts at `start_rad`: positive if it starts at the latch angle itself.
    pub fn side_of(start_rad: f64, angle_rad: f64) -> f64 {
        if start_rad < angle_rad { -1.0 } else { 1.0 }
    }

    /// Distance to the latch angle in rad, positive on the folded side.
    pub fn gap_rad(&self, angle_rad: f64) -> f64 {
        self.side * (angle_rad - self.angle_rad)
    }

    /// Torque on the outer body about `+θ` in N·m when closed.
    pub fn torque_n_m(&self, angle_rad: f64) -> f64 {
        -self.stiffness_n_m_rad * (angle_rad - self.angle_rad)
    }

    /// Energy stored when closed in J.
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
}
