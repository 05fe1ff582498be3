//! Discrete state of the forces on one joint from step to step, and their inputs.

use crate::force::drive::Slew;
use crate::force::end_stops::Contact;
use crate::force::latch::LatchState;
use serde::{Deserialize, Serialize};

/// State of the forces on a joint with one freedom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointMemory {
    /// The lock is released; otherwise it holds the joint at its position.
    pub released: bool,
    /// Latch, if the joint has one.
    pub latch: LatchState,
    /// Indicators that the integrator's present step crosses at its end, one bit each.
    pub crossed: u32,
    /// Bounds of failures that have been passed, one bit each.
    pub tripped: u32,
    /// Contact with end stops, if the joint has some.
    pub contact: Contact,
    /// Neutral angle of the motor.
    pub slew: Slew,
}

/// Inputs and parameters of the forces on a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// Present time in s.
    pub time_s: f64,
    /// The present step ends now.
    pub at_end: bool,
    /// Release of the lock.
    pub release: bool,
    /// The latch may close.
    pub latch_enable: bool,
    /// Neutral angle commanded in rad.
    pub command_rad: f64,
    /// Its rate in rad/s.
    pub command_rate_rad_s: f64,
    /// Largest rate of the neutral angle in rad/s.
    pub rate_limit_rad_s: f64,
}
