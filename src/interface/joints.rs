//! Rows of the joints: parameters and outputs.

use crate::interface::Variability;
use crate::interface::binding::{JointOutput, JointParameter, Output, Parameter, SpatialOutput, SpatialParameter};
use crate::interface::table::{AXES, NON_NEGATIVE, ParameterRow, QUATERNION, TURN, Table};
use crate::interface::topology::Topology;

const JOINT_PARAMETERS: &[ParameterRow<JointParameter>] = {
    use JointParameter as P;
    use Variability::{Fixed, Tunable};
    &[
        (
            "start_angle",
            P::StartAngle,
            Fixed,
            "Angle",
            TURN,
            "fold angle at the start, right hand about the hinge axis",
        ),
        ("stiffness", P::Stiffness, Tunable, "RotationalStiffness", NON_NEGATIVE, "stiffness k of the motor"),
        ("damping", P::Damping, Tunable, "RotationalDamping", NON_NEGATIVE, "damping c of the motor"),
        (
            "constant_torque",
            P::ConstantTorque,
            Tunable,
            "Moment",
            None,
            "constant torque T of the motor, towards smaller angles",
        ),
        (
            "torque_limit",
            P::TorqueLimit,
            Tunable,
            "Moment",
            NON_NEGATIVE,
            "largest magnitude of the motor's torque, external torque and spring excepted; 1e30 means none",
        ),
        (
            "rate_limit",
            P::RateLimit,
            Tunable,
            "AngularVelocity",
            NON_NEGATIVE,
            "largest slew of the neutral angle; 1e30 means none",
        ),
        (
            "spring_stiffness",
            P::SpringStiffness,
            Tunable,
            "RotationalStiffness",
            NON_NEGATIVE,
            "stiffness of the joint's own spring",
        ),
        (
            "spring_damping",
            P::SpringDamping,
            Tunable,
            "RotationalDamping",
            NON_NEGATIVE,
            "damping beside the joint's own spring",
        ),
        ("rest_angle", P::RestAngle, Tunable, "Angle", None, "angle at which the joint's own spring is slack"),
        (
            "latch_stiffness",
            P::LatchStiffness,
            Tunable,
            "RotationalStiffness",
            NON_NEGATIVE,
            "stiffness that the closed latch adds",
        ),
    ]
};

const SPATIAL_PARAMETERS: &[ParameterRow<SpatialParameter>] = {
    use SpatialParameter as P;
    use Variability::Tunable;
    let stiffness = "stiffness of the spring towards the start attitude";
    &[
        ("stiffness", P::Stiffness, Tunable, "RotationalStiffness", NON_NEGATIVE, stiffness),
        ("damping", P::Damping, Tunable, "RotationalDamping", NON_NEGATIVE, "damping"),
    ]
};

/// Tunable and fixed parameters of all joints.
pub(super) fn parameters(table: &mut Table, topology: &Topology) {
    for joint in 0..topology.revolutes.len() {
        let name = topology.joint_name(joint);
        for &(key, field, variability, declared, range, meaning) in JOINT_PARAMETERS {
            let acts = match field {
                JointParameter::StartAngle => !topology.is_prescribed(joint),
                JointParameter::LatchStiffness => topology.is_free(joint) && topology.has_elastic_latch(joint),
                JointParameter::SpringStiffness | JointParameter::SpringDamping | JointParameter::RestAngle => {
                    topology.is_free(joint) && topology.revolute(joint).spring.is_some()
                }
                _ => topology.is_free(joint),
            };
            if acts {
                let text = (format!("{name}.{key}"), Some(declared), range, format!("{meaning}, joint {name}"));
                table.parameter(Parameter::Joint(joint, field), variability, text);
            }
        }
    }
    for joint in (0..topology.spatials.len()).filter(|&joint| !topology.is_unbound(joint)) {
        let name = &topology.machine.bodies[topology.spatials[joint]].joint.name;
        for &(key, field, variability, declared, range, meaning) in SPATIAL_PARAMETERS {
            let text = (format!("{name}.{key}"), Some(declared), range, format!("{meaning}, joint {name}"));
            table.parameter(Parameter::Spatial(joint, field), variability, text);
        }
    }
}

/// Outputs of a revolute joint.
pub(super) fn revolute_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let name = topology.joint_name(joint);
    let mut add = |field, key: &str, declared, meaning: &str| {
        table.output(Output::Joint(joint, field), format!("{name}.{key}"), declared, format!("{meaning} {name}"));
    };
    add(JointOutput::Angle, "angle", Some("Angle"), "fold angle, right hand about the hinge axis, joint");
    add(JointOutput::Rate, "rate", Some("AngularVelocity"), "fold rate, joint");
    let holding = "torque of the stopper, lock or prescribed motion that holds the joint, on the outer body, joint";
    add(JointOutput::HoldingTorque, "holding_torque", Some("Moment"), holding);
    if !topology.is_free(joint) {
        return;
    }
    let applied =
        "torque of motor, spring and external torque together, on the outer body about the hinge axis of joint";
    add(JointOutput::TorqueApplied, "torque_applied", Some("Moment"), applied);
    let motor = "torque of the motor within its limit, on the outer body about the hinge axis of joint";
    add(JointOutput::MotorTorque, "motor_torque", Some("Moment"), motor);
    if topology.revolute(joint).spring.is_some() {
        let spring = "torque of the joint's own spring and damper, on the outer body about the hinge axis of joint";
        add(JointOutput::SpringTorque, "spring_torque", Some("Moment"), spring);
    }
    let external = "external torque that acts on the outer body about the hinge axis of joint";
    add(JointOutput::ExternalTorque, "external_torque", Some("Moment"), external);
    if topology.revolute(joint).latch.is_some() {
        let torque = "latch torque on the outer body about the hinge axis of joint";
        let rigid = topology.has_rigid_latch(joint);
        let field = if rigid { JointOutput::LatchReaction } else { JointOutput::LatchTorque };
        add(field, "latch_torque", Some("Moment"), torque);
        add(JointOutput::Latched, "latched", None, "latch closed, joint");
        add(JointOutput::LatchTime, "latch_time", Some("Time"), "time of the last closing, -1 before the first, joint");
        add(JointOutput::LatchCount, "latch_count", None, "number of closings, joint");
        if rigid {
            let impulse = "impulse of the latch's last closing on the outer body about the hinge axis of joint";
            add(JointOutput::LatchImpulse, "latch_impulse", Some("AngularImpulse"), impulse);
        }
    }
}

/// Outputs of a universal, ball or free joint.
pub(super) fn spatial_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let body = topology.spatials[joint];
    let (body_name, name) = (&topology.machine.bodies[body].name, &topology.machine.bodies[body].joint.name);
    let mut add = |bind: &dyn Fn(usize) -> Output, key: &str, components: &[&str], declared, meaning: &str| {
        for (i, component) in components.iter().enumerate() {
            let meaning = format!("{meaning}, {component}, joint {name}");
            table.output(bind(i), format!("{name}.{key}.{component}"), Some(declared), meaning);
        }
    };
    let bind = |field: fn(usize) -> SpatialOutput| move |i| Output::Spatial(joint, field(i));
    let rotation = "quaternion parent from body, sign continuous";
    add(&bind(SpatialOutput::Rotation), "rotation", &QUATERNION, "Ratio", rotation);
    let rate = "angular velocity of the body relative to its parent, parent's frame";
    add(&bind(SpatialOutput::AngularVelocity), "angular_velocity", &AXES, "AngularVelocity", rate);
    if !topology.is_unbound(joint) {
        let force = format!("force of the joint on the inner end of body {body_name}, root frame");
        add(&|i| Output::JointForce(body, i), "force", &AXES, "Force", &force);
        let moment = format!("moment of the joint on the inner end of body {body_name}, at that end, root frame");
        add(&|i| Output::JointMoment(body, i), "moment", &AXES, "Moment", &moment);
    }
}
