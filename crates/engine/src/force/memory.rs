//! Discrete state of the forces on one joint between steps, and their inputs.

use crate::force::drive::Slew;
use serde::{Deserialize, Serialize};

/// Discrete state of the forces on a joint with one degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointMemory {
    /// Whether the lock is released; otherwise it holds the joint at its position.
    pub released: bool,
    /// State of the latch, if the joint has one.
    pub latch: LatchState,
    /// Indicators that the current step of the integrator crosses at its end, one bit each.
    pub crossed: u32,
    /// Failure bounds that have been passed, one bit each.
    pub tripped: u32,
    /// Element, or pair, of the beam along which a sliding joint moves, from its inner end; 0 for other joints.
    pub element: usize,
    /// Contact state of the end stops, if the joint has any.
    pub contact: Contact,
    /// Motion of the motor's neutral angle.
    pub slew: Slew,
}

/// Inputs and parameters of the forces on a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// Current time in s.
    pub time_s: f64,
    /// Whether the current step ends now.
    pub at_end: bool,
    /// Whether the lock is released.
    pub release: bool,
    /// Whether the latch may close.
    pub latch_enable: bool,
    /// Commanded neutral angle in rad.
    pub command_rad: f64,
    /// Rate of the command in rad/s.
    pub command_rate_rad_s: f64,
    /// Largest rate of the neutral angle in rad/s.
    pub rate_limit_rad_s: f64,
}

/// State of a latch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LatchState {
    /// Whether the latch is closed.
    pub closed: bool,
    /// Whether the latch may close.
    pub enabled: bool,
    /// Time of the last closing in s; −1 before the first.
    pub time_s: f64,
    /// Number of closings.
    pub count: i32,
    /// Impulse in N·m·s of the last closing of a rigid latch on the outer body about `+θ`; 0 before the first.
    pub impulse_n_m_s: f64,
}

/// Side of an end stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// End stop at the smallest angle.
    Lower,
    /// End stop at the largest angle.
    Upper,
}

/// Contact state of a joint with its end stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Contact {
    /// Between the end stops, without contact.
    #[default]
    Apart,
    /// In contact with one, which exerts a torque.
    Pressed(Side),
    /// Beyond one, but receding faster than the stop's spring and damper can follow: no torque acts.
    Leaving(Side),
}
