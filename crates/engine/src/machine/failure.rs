//! Failures: effects and triggers.

pub use crate::force::friction::FrictionBrake;
pub use crate::force::watch::{Bound, BoundSide, Quantity};

/// A failure of a machine. It occurs once and is permanent.
///
/// Its input is always a trigger; a time, another failure or a bound on the motion of a joint can be further ones. The first trigger
/// counts, and the failure occurs [`Failure::delay_s`] later.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Identifier.
    pub name: String,
    /// Effect of the failure.
    pub effect: Effect,
    /// Time of its trigger in s, if known in advance.
    pub at_time_s: Option<f64>,
    /// Index of another failure that triggers it, in [`Machine::failures`](crate::machine::Machine::failures).
    pub after: Option<usize>,
    /// Motion of a joint that triggers it.
    pub when: Option<Bound>,
    /// Delay after the trigger in s.
    pub delay_s: f64,
}

/// Effect of a failure. Bodies of joints are indices into [`Machine::bodies`](crate::machine::Machine::bodies): the body whose inner end is
/// attached by the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    /// Motor and generator of a joint lose their torque; their inertia remains.
    MotorLoss {
        /// Body of the joint.
        body: usize,
    },
    /// The joint is held at its position, as by a lock.
    MotorJam {
        /// Body of the joint.
        body: usize,
    },
    /// The neutral angle of the motor moves to a given angle, independent of its command.
    MotorRunaway {
        /// Body of the joint.
        body: usize,
        /// Final neutral angle in rad, or position in m.
        to_rad: f64,
        /// Rate of the neutral angle in rad/s or m/s.
        rate_rad_s: f64,
    },
    /// The latch opens, and does not close again.
    LatchBreak {
        /// Body of the joint.
        body: usize,
    },
    /// An open latch stays open; a closed one stays closed until it is opened.
    LatchNoCapture {
        /// Body of the joint.
        body: usize,
    },
    /// The lock of a joint opens permanently, because the link that held it fails.
    LockRelease {
        /// Body of the joint.
        body: usize,
    },
    /// Spring and damper of a joint are reduced to a fraction.
    SpringBreak {
        /// Body of the joint.
        body: usize,
        /// Remaining fraction, from 0 to 1.
        remaining: f64,
    },
    /// The penalty that closes a loop is reduced to a fraction.
    LoopBreak {
        /// Index into [`Machine::closures`](crate::machine::Machine::closures).
        closure: usize,
        /// Remaining fraction, from 0 to 1; at 0 the loop is open.
        remaining: f64,
    },
    /// All stiffness of a beam is reduced to a fraction.
    StiffnessLoss {
        /// Index of the beam.
        body: usize,
        /// Remaining fraction, above 0 and up to 1.
        remaining: f64,
    },
    /// A brake is applied.
    BrakeApplied {
        /// Body of the joint.
        body: usize,
        /// The friction brake.
        brake: FrictionBrake,
    },
}

impl Failure {
    /// Whether the motion of a joint triggers the failure, directly or through others.
    fn follows_a_bound(&self, all: &[Self]) -> bool {
        // chains are at most as long as the list
        let mut failure = Some(self);
        for _ in 0..=all.len() {
            let Some(own) = failure else { return false };
            if own.when.is_some() {
                return true;
            }
            failure = own.after.map(|other| &all[other]);
        }
        false
    }

    /// Whether the failure remembers an instant that depends on the motion: it follows a bound of a joint's motion, with a delay, a ramp or
    /// a runaway.
    pub(crate) fn lasts_after_a_bound(&self, all: &[Self]) -> bool {
        let lasts = match self.effect {
            Effect::MotorRunaway { .. } => true,
            Effect::BrakeApplied { brake, .. } => brake.ramp_s > 0.0,
            Effect::MotorLoss { .. }
            | Effect::MotorJam { .. }
            | Effect::LatchBreak { .. }
            | Effect::LatchNoCapture { .. }
            | Effect::LockRelease { .. }
            | Effect::SpringBreak { .. }
            | Effect::LoopBreak { .. }
            | Effect::StiffnessLoss { .. } => false,
        };
        (lasts || self.delay_s > 0.0) && self.follows_a_bound(all)
    }
}

impl Effect {
    /// Body of the joint whose forces the failure changes, if any.
    pub fn joint_of(&self) -> Option<usize> {
        match *self {
            Self::MotorLoss { body }
            | Self::MotorJam { body }
            | Self::MotorRunaway { body, .. }
            | Self::LatchBreak { body }
            | Self::LatchNoCapture { body }
            | Self::LockRelease { body }
            | Self::SpringBreak { body, .. }
            | Self::BrakeApplied { body, .. } => Some(body),
            Self::LoopBreak { .. } | Self::StiffnessLoss { .. } => None,
        }
    }
}
