//! Rows of the joints: parameters and outputs.

use crate::interface::Variability;
use crate::interface::binding::{JointOutput, JointParameter, Output, Parameter, SpatialOutput, SpatialParameter};
use crate::interface::table::{AXES, NON_NEGATIVE, ParameterRow, QUATERNION, TURN, Table};
use crate::interface::topology::Topology;
use foldwing_engine::machine::{JointKind, Travel};

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
            "fold angle at the start, by the right-hand rule about the hinge axis",
        ),
        ("stiffness", P::Stiffness, Tunable, "RotationalStiffness", NON_NEGATIVE, "motor stiffness k"),
        ("damping", P::Damping, Tunable, "RotationalDamping", NON_NEGATIVE, "motor damping c"),
        (
            "constant_torque",
            P::ConstantTorque,
            Tunable,
            "Moment",
            None,
            "constant motor torque T, towards smaller angles",
        ),
        (
            "torque_limit",
            P::TorqueLimit,
            Tunable,
            "Moment",
            NON_NEGATIVE,
            "maximum magnitude of the motor torque, without external torque and spring; 1e30 means no limit",
        ),
        (
            "rate_limit",
            P::RateLimit,
            Tunable,
            "AngularVelocity",
            NON_NEGATIVE,
            "maximum slew rate of the neutral angle; 1e30 means no limit",
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
            "damping parallel to the joint's own spring",
        ),
        ("rest_angle", P::RestAngle, Tunable, "Angle", None, "angle at which the joint's own spring is slack"),
        (
            "latch_stiffness",
            P::LatchStiffness,
            Tunable,
            "RotationalStiffness",
            NON_NEGATIVE,
            "stiffness added by the closed latch",
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
        let (name, travel) = (topology.joint_name(joint), topology.travel(joint));
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
                // a slide may start anywhere
                let range = range.filter(|_| travel == Travel::Rotation || field != JointParameter::StartAngle);
                let (key, meaning) = (travel.words(key), travel.words(meaning));
                let declared = Some(travel.declared(declared));
                let text = (format!("{name}.{key}"), declared, range, format!("joint {name}: {meaning}"));
                table.parameter(Parameter::Joint(joint, field), variability, text);
            }
        }
    }
    for joint in (0..topology.spatials.len()).filter(|&joint| !topology.is_unbound(joint)) {
        let name = &topology.machine.bodies[topology.spatials[joint]].joint.name;
        for &(key, field, variability, declared, range, meaning) in SPATIAL_PARAMETERS {
            let text = (format!("{name}.{key}"), Some(declared), range, format!("joint {name}: {meaning}"));
            table.parameter(Parameter::Spatial(joint, field), variability, text);
        }
    }
}

/// Outputs of a revolute or prismatic joint.
pub(super) fn revolute_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let (name, travel) = (topology.joint_name(joint), topology.travel(joint));
    let mut add = |field, key: &str, declared: Option<&'static str>, meaning: &str| {
        table.output(
            Output::Joint(joint, field),
            format!("{name}.{}", travel.words(key)),
            declared.map(|declared| travel.declared(declared)),
            format!("joint {name}: {}", travel.words(meaning)),
        );
    };
    add(JointOutput::Angle, "angle", Some("Angle"), "fold angle, by the right-hand rule about the hinge axis");
    let rate_key = if travel == Travel::Rotation { "angular_velocity" } else { "velocity" };
    add(JointOutput::Rate, rate_key, Some("AngularVelocity"), "fold rate");
    let holding = "torque on the outer body of the stopper, lock or prescribed motion that holds the joint";
    add(JointOutput::HoldingTorque, "holding_torque", Some("Moment"), holding);
    if topology.is_free(joint) {
        torque_outputs(topology, joint, &mut add);
    }
    reaction_outputs(table, topology, topology.revolutes[joint]);
}

/// Torques about the hinge of a joint that may turn, and its latch.
fn torque_outputs(
    topology: &Topology,
    joint: usize,
    add: &mut impl FnMut(JointOutput, &str, Option<&'static str>, &str),
) {
    let applied = "sum of motor, spring and external torque on the outer body about the hinge axis";
    add(JointOutput::TorqueApplied, "applied_torque", Some("Moment"), applied);
    let motor = "motor torque within its limit, on the outer body about the hinge axis";
    add(JointOutput::MotorTorque, "motor_torque", Some("Moment"), motor);
    if topology.revolute(joint).spring.is_some() {
        let spring = "torque of the joint's own spring and damper, on the outer body about the hinge axis";
        add(JointOutput::SpringTorque, "spring_torque", Some("Moment"), spring);
    }
    let external = "external torque that acts on the outer body about the hinge axis";
    add(JointOutput::ExternalTorque, "external_torque", Some("Moment"), external);
    if topology.revolute(joint).latch.is_some() {
        let torque = "latch torque on the outer body about the hinge axis";
        let rigid = topology.has_rigid_latch(joint);
        let field = if rigid { JointOutput::LatchReaction } else { JointOutput::LatchTorque };
        add(field, "latch_torque", Some("Moment"), torque);
        add(JointOutput::Latched, "latched", None, "latch is closed");
        let time = "time at which the latch last closed, -1 before the first closing";
        add(JointOutput::LatchTime, "latch_time", Some("Time"), time);
        add(JointOutput::LatchCount, "latch_count", None, "number of times the latch has closed");
        if rigid {
            let impulse = "impulse of the latch's last closing on the outer body about the hinge axis";
            add(JointOutput::LatchImpulse, "latch_impulse", Some("AngularImpulse"), impulse);
        }
    }
}

/// Outputs of a universal, ball or free joint.
pub(super) fn spatial_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let body = topology.spatials[joint];
    let name = &topology.machine.bodies[body].joint.name;
    let mut add = |bind: &dyn Fn(usize) -> Output, key: &str, components: &[&str], declared, meaning: &str| {
        for (i, component) in components.iter().enumerate() {
            let meaning = format!("joint {name}: {meaning}, {component}");
            table.output(bind(i), format!("{name}.{key}.{component}"), Some(declared), meaning);
        }
    };
    let bind = |field: fn(usize) -> SpatialOutput| move |i| Output::Spatial(joint, field(i));
    let rotation = "quaternion from the body to its parent, with continuous sign";
    add(&bind(SpatialOutput::Rotation), "rotation", &QUATERNION, "Ratio", rotation);
    let rate = "angular velocity of the body relative to its parent, in the parent's frame";
    add(&bind(SpatialOutput::AngularVelocity), "angular_velocity", &AXES, "AngularVelocity", rate);
    if !topology.is_unbound(joint) {
        reaction_outputs(table, topology, body);
    }
}

/// Outputs of all clamped joints.
pub(super) fn clamped_outputs(table: &mut Table, topology: &Topology) {
    let clamped = |body: &usize| topology.machine.bodies[*body].joint.kind == JointKind::Clamped;
    (0..topology.machine.bodies.len()).filter(clamped).for_each(|body| reaction_outputs(table, topology, body));
}

/// Force and moment of the joint that holds a body.
fn reaction_outputs(table: &mut Table, topology: &Topology, body: usize) {
    let (body_name, name) = (&topology.machine.bodies[body].name, &topology.machine.bodies[body].joint.name);
    for (i, axis) in AXES.iter().enumerate() {
        let force =
            format!("joint {name}: force of the joint on the inner end of body {body_name}, root frame, {axis}");
        table.output(Output::JointForce(body, i), format!("{name}.reaction_force.{axis}"), Some("Force"), force);
    }
    for (i, axis) in AXES.iter().enumerate() {
        let moment = format!(
            "joint {name}: moment of the joint on the inner end of body {body_name}, at that end, root frame, {axis}"
        );
        table.output(Output::JointMoment(body, i), format!("{name}.reaction_moment.{axis}"), Some("Moment"), moment);
    }
}
