//! Instants that follow from parameters, at which steps end, eq. (X35): the end of a slew or of the ramp of a brake, and failures.

use crate::force::drive::SlewPiece;
use crate::machine::Effect;
use crate::system::System;

/// An instant that follows from parameters and from earlier instants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Timer {
    /// The neutral angle of the motor of a joint reaches its command.
    Slew {
        /// Index of the joint among those with one freedom.
        joint: usize,
        /// Piece of the slew that ends.
        piece: SlewPiece,
    },
    /// The torque of a brake is fully on.
    Ramp {
        /// Index of the failure.
        failure: usize,
    },
    /// The trigger of a failure, or the failure itself.
    Failure {
        /// Index of the failure.
        failure: usize,
    },
}

impl Timer {
    /// The timers that end a step at a time.
    pub fn due(system: &System, time_s: f64) -> Vec<Self> {
        let mut due = Vec::new();
        for (joint, forces) in system.equations.forces.joints().iter().enumerate() {
            if let Some(motor) = forces.motor().filter(|motor| motor.kink_at(time_s)) {
                due.push(Self::Slew { joint, piece: motor.slew.piece(f64::NEG_INFINITY) });
            }
            let ends = forces.slipping_brakes().filter(|brake| brake.brake.ramp_s > 0.0 && brake.end_s() == time_s);
            due.extend(ends.map(|brake| Self::Ramp { failure: brake.failure }));
        }
        for failure in 0..system.state.failures.len() {
            if failure_time_s(system, failure) == time_s {
                due.push(Self::Failure { failure });
            }
        }
        due
    }

    /// Its time in s in a machine whose slews and failures are in the state of the step that it ends.
    pub fn time_s(self, system: &System) -> f64 {
        match self {
            Self::Slew { joint, piece } => {
                let motor = system.equations.forces.joints()[joint].motor();
                motor.map_or(f64::NAN, |motor| motor.slew.end_on_s(piece))
            }
            Self::Ramp { failure } => match system.machine.failures[failure].effect {
                Effect::BrakeApplied { brake, .. } => {
                    system.state.failures[failure].failed_s.map_or(f64::NAN, |from_s| from_s + brake.ramp_s)
                }
                Effect::MotorLoss { .. }
                | Effect::MotorJam { .. }
                | Effect::MotorRunaway { .. }
                | Effect::LatchBreak { .. }
                | Effect::LatchNoCapture { .. }
                | Effect::LockRelease { .. }
                | Effect::SpringBreak { .. }
                | Effect::LoopBreak { .. }
                | Effect::StiffnessLoss { .. } => f64::NAN,
            },
            Self::Failure { failure } => failure_time_s(system, failure),
        }
    }

    /// Its name, for messages.
    pub fn name(self, system: &System) -> String {
        match self {
            Self::Slew { joint, .. } => format!("the command of joint {}", system.joint_name(joint)),
            Self::Ramp { failure } | Self::Failure { failure } => {
                format!("failure {}", system.machine.failures[failure].name)
            }
        }
    }
}

/// Time in s of the trigger of a failure that has not been triggered, otherwise of the failure; infinite if it has failed, or is not known in
/// advance.
fn failure_time_s(system: &System, failure: usize) -> f64 {
    let (described, memory) = (&system.machine.failures[failure], system.state.failures[failure]);
    match (memory.failed_s, memory.brought_s, described.at_time_s) {
        (Some(_), _, _) | (None, None, None) => f64::INFINITY,
        (None, Some(brought_s), _) => brought_s + described.delay_s,
        (None, None, Some(at_s)) => at_s,
    }
}
