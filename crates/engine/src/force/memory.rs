//! What the forces on one joint remember from step to step, and what their inputs tell them.

use crate::force::drive::Slew;
use crate::force::end_stops::Contact;
use crate::force::latch::LatchState;
use serde::{Deserialize, Serialize};

/// State of the forces on a joint with one freedom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointMemory {
    /// The stopper has let go; otherwise it holds the joint where it is.
    pub released: bool,
    /// Latch, of joints that have one.
    pub latch: LatchState,
    /// Indicators that the integrator's present step crosses at its end, a bit each.
    pub crossed: u32,
    /// Bounds on the motion that failures wait for and that have been passed, a bit each.
    pub tripped: u32,
    /// Contact with stops, of joints that have some.
    pub contact: Contact,
    /// Neutral angle of the drive.
    pub slew: Slew,
}

/// What inputs and parameters tell the forces of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// Present time in s.
    pub time_s: f64,
    /// The present step ends now.
    pub at_end: bool,
    /// The stopper is to let go.
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
