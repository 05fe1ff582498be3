//! Dependencies of the torques about a hinge: motor, spring, external torque, latch, start angle and rate.

use crate::interface::known::{Input, JointInput, JointParameter, Known, Parameter};
use crate::interface::topology::Topology;

/// Command of one joint.
pub(super) fn commands_joint(joint: usize, known: Known) -> bool {
    known == Known::Input(Input::Joint(joint, JointInput::Command))
}

/// External torque of one joint.
pub(super) fn turns_joint(joint: usize, known: Known) -> bool {
    known == Known::Input(Input::Joint(joint, JointInput::Torque))
}

/// Initial torque of a motor.
pub(super) fn motor_pulls_initially(topology: &Topology, joint: usize, known: Known) -> bool {
    let parameters = match known {
        Known::Parameter(Parameter::Joint(other, field)) => {
            other == joint
                && match field {
                    JointParameter::StartAngle
                    | JointParameter::Stiffness
                    | JointParameter::ConstantTorque
                    | JointParameter::TorqueLimit => true,
                    JointParameter::Damping => topology.turns_at_start(joint),
                    JointParameter::RateLimit
                    | JointParameter::SpringStiffness
                    | JointParameter::SpringDamping
                    | JointParameter::RestAngle
                    | JointParameter::LatchStiffness => false,
                }
        }
        Known::Time | Known::Input(_) | Known::Parameter(_) => false,
    };
    parameters || commands_joint(joint, known) || start_rate(topology, joint, known)
}

/// Initial potential energy of all motors.
pub(super) fn motor_stores(topology: &Topology, known: Known) -> bool {
    use JointParameter::{ConstantTorque, StartAngle, Stiffness, TorqueLimit};
    match known {
        Known::Input(Input::Joint(_, JointInput::Command)) => true,
        Known::Parameter(Parameter::Joint(joint, StartAngle | Stiffness | ConstantTorque | TorqueLimit)) => {
            topology.is_free(joint)
        }
        Known::Time | Known::Input(_) | Known::Parameter(_) => false,
    }
}

/// Initial energy of the spring of a joint.
pub(super) fn spring_stores_initially(topology: &Topology, joint: usize, known: Known) -> bool {
    use JointParameter::{RestAngle, SpringStiffness, StartAngle};
    topology.revolute(joint).spring.is_some()
        && matches!(known, Known::Parameter(Parameter::Joint(other, StartAngle | SpringStiffness | RestAngle)) if other == joint)
}

/// Initial torque of the spring and damper of a joint.
pub(super) fn spring_pulls_initially(topology: &Topology, joint: usize, known: Known) -> bool {
    if topology.revolute(joint).spring.is_none() {
        return false;
    }
    let parameters = match known {
        Known::Parameter(Parameter::Joint(other, field)) => {
            other == joint
                && match field {
                    JointParameter::StartAngle | JointParameter::SpringStiffness | JointParameter::RestAngle => true,
                    JointParameter::SpringDamping => topology.turns_at_start(joint),
                    JointParameter::Stiffness
                    | JointParameter::Damping
                    | JointParameter::ConstantTorque
                    | JointParameter::TorqueLimit
                    | JointParameter::RateLimit
                    | JointParameter::LatchStiffness => false,
                }
        }
        Known::Time | Known::Input(_) | Known::Parameter(_) => false,
    };
    parameters || start_rate(topology, joint, known)
}

/// Start angle of a joint, or time if the angle is prescribed.
pub(super) fn starts(topology: &Topology, joint: usize, known: Known) -> bool {
    if topology.is_prescribed(joint) {
        return known == Known::Time;
    }
    known == Known::Parameter(Parameter::Joint(joint, JointParameter::StartAngle))
}

/// Knowns that change the start rate of a joint: it is that of the model, unless the lock or a rigid latch holds the
/// joint.
pub(super) fn start_rate(topology: &Topology, joint: usize, known: Known) -> bool {
    if topology.is_prescribed(joint) {
        return known == Known::Time;
    }
    topology.turns_at_start(joint)
        && (known == Known::Input(Input::Joint(joint, JointInput::Release))
            || topology.has_rigid_latch(joint) && catches_at_start(joint, known))
}

/// Knowns that determine whether an enabled rigid latch closes at the start, for any start angle of the model.
fn catches_at_start(joint: usize, known: Known) -> bool {
    known == Known::Input(Input::Joint(joint, JointInput::LatchEnable))
        || known == Known::Parameter(Parameter::Joint(joint, JointParameter::StartAngle))
}

/// Knowns that determine whether a latch is closed at the start: only for a latch that is closed there in the model.
pub(super) fn latches(topology: &Topology, joint: usize, known: Known) -> bool {
    starts_closed(topology, joint)
        && (known == Known::Input(Input::Joint(joint, JointInput::LatchEnable))
            || starts_caught(topology, joint) && starts(topology, joint, known))
}

/// Knowns that determine the torque of an elastic latch at the start.
pub(super) fn latch_pulls(topology: &Topology, joint: usize, known: Known) -> bool {
    let stiffness = Known::Parameter(Parameter::Joint(joint, JointParameter::LatchStiffness));
    topology.has_elastic_latch(joint)
        && starts_closed(topology, joint)
        && (latches(topology, joint, known) || starts(topology, joint, known) || known == stiffness)
}

pub(super) fn starts_closed(topology: &Topology, joint: usize) -> bool {
    topology.revolute(joint).latch.as_ref().is_some_and(|latch| latch.initially_closed)
        || starts_caught(topology, joint)
}

/// Returns whether the model's start angle lies in the capture range of a latch that is not closed in any case.
pub(super) fn starts_caught(topology: &Topology, joint: usize) -> bool {
    let revolute = topology.revolute(joint);
    revolute.latch.as_ref().is_some_and(|latch| {
        !latch.initially_closed && (revolute.start_angle_rad - latch.angle_rad).abs() <= latch.capture_rad
    })
}
