//! Failures: what breaks, and when.

pub use crate::force::friction::FrictionBrake;
pub use crate::force::watch::{Bound, BoundSide, Quantity};

/// A failure of a machine. It happens once, and nothing repairs it.
///
/// Its input may always bring it about; time, another failure or a bound on the motion of a joint may too. Whichever comes first
/// counts, and the failure follows [`Failure::delay_s`] later.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Identifier.
    pub name: String,
    /// What fails.
    pub effect: Effect,
    /// Time at which it is brought about in s, if at one that is known.
    pub at_time_s: Option<f64>,
    /// Index of another failure that brings it about, in [`Machine::failures`](crate::machine::Machine::failures).
    pub after: Option<usize>,
    /// Motion of a joint that brings it about.
    pub when: Option<Bound>,
    /// Time from what brings it about until it happens, in s.
    pub delay_s: f64,
}

/// What fails. Bodies of joints are indices into [`Machine::bodies`](crate::machine::Machine::bodies): the body whose inner
/// end the joint holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    /// Motor and generator of a joint give no torque any more; their inertia stays.
    DriveDies {
        /// Body of the joint.
        body: usize,
    },
    /// The joint is held where it is, as by its stopper.
    DriveJams {
        /// Body of the joint.
        body: usize,
    },
    /// The neutral angle of the motor goes to an angle of its own, whatever is commanded.
    DriveRunsAway {
        /// Body of the joint.
        body: usize,
        /// Neutral angle at which it ends, in rad or m.
        to_rad: f64,
        /// Rate of the neutral angle in rad/s or m/s.
        rate_rad_s: f64,
    },
    /// The latch opens, and does not close again.
    LatchBreaks {
        /// Body of the joint.
        body: usize,
    },
    /// A latch that is open stays so; one that is closed stays closed until it is opened.
    LatchDoesNotCatch {
        /// Body of the joint.
        body: usize,
    },
    /// The stopper of a joint lets go, and does not hold it again: a link that held it opens.
    StopperOpens {
        /// Body of the joint.
        body: usize,
    },
    /// Spring and damper of a joint keep a share.
    SpringWeakens {
        /// Body of the joint.
        body: usize,
        /// Share that remains, from 0 to 1.
        remaining: f64,
    },
    /// The penalty that closes a loop keeps a share.
    LoopWeakens {
        /// Index into [`Machine::closures`](crate::machine::Machine::closures).
        closure: usize,
        /// Share that remains, from 0 to 1; at 0 the loop is open.
        remaining: f64,
    },
    /// All stiffness of a beam keeps a share.
    BodyWeakens {
        /// Index of the beam.
        body: usize,
        /// Share that remains, above 0 and up to 1.
        remaining: f64,
    },
    /// A brake comes on.
    BrakeComesOn {
        /// Body of the joint.
        body: usize,
        /// Its torque.
        brake: FrictionBrake,
    },
}

impl Effect {
    /// Body of the joint that it acts on, if it acts on the forces of one.
    pub fn joint_of(&self) -> Option<usize> {
        match *self {
            Self::DriveDies { body }
            | Self::DriveJams { body }
            | Self::DriveRunsAway { body, .. }
            | Self::LatchBreaks { body }
            | Self::LatchDoesNotCatch { body }
            | Self::StopperOpens { body }
            | Self::SpringWeakens { body, .. }
            | Self::BrakeComesOn { body, .. } => Some(body),
            Self::LoopWeakens { .. } | Self::BodyWeakens { .. } => None,
        }
    }
}
