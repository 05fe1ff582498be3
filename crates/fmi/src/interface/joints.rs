//! Rows of the joints: parameters and outputs.

use crate::interface::DependencyKind;
use crate::interface::Variability;
use crate::interface::cause::{Cause, Depends};
use crate::interface::hinge_dependencies::starts_closed;
use crate::interface::known::{Input, JointInput, JointParameter, Parameter, SpatialParameter};
use crate::interface::table::{NON_NEGATIVE, ParameterRow, Shape, TURN, Table, Text, Type, place, wrench};
use crate::interface::topology::Topology;
use foldwing_engine::load::Wrench;
use foldwing_engine::machine::Travel;
use foldwing_engine::plant::{
    DcMotorInputs, DcMotorOutputs, GeneratorOutputs, JointOutputs, JointParameters, LatchOutputs, ModalOutputs,
    OutputSet, SpatialOutputs, SpatialParameters,
};
use std::mem::offset_of;

const JOINT_PARAMETERS: &[ParameterRow<JointParameter>] = {
    use JointParameter as P;
    use Variability::{Fixed, Tunable};
    &[
        (
            "start_angle",
            P::StartAngle,
            offset_of!(JointParameters, start_angle_rad),
            Fixed,
            "Angle",
            TURN,
            "fold angle at the start, by the right-hand rule about the hinge axis",
        ),
        (
            "motor_stiffness",
            P::Stiffness,
            offset_of!(JointParameters, stiffness_n_m_rad),
            Tunable,
            "RotationalStiffness",
            NON_NEGATIVE,
            "motor stiffness k",
        ),
        (
            "motor_damping",
            P::Damping,
            offset_of!(JointParameters, damping_n_m_s_rad),
            Tunable,
            "RotationalDamping",
            NON_NEGATIVE,
            "motor damping c",
        ),
        (
            "motor_constant_torque",
            P::ConstantTorque,
            offset_of!(JointParameters, constant_torque_n_m),
            Tunable,
            "Moment",
            None,
            "constant motor torque T, towards smaller angles",
        ),
        (
            "motor_torque_limit",
            P::TorqueLimit,
            offset_of!(JointParameters, torque_limit_n_m),
            Tunable,
            "Moment",
            NON_NEGATIVE,
            "maximum magnitude of the motor torque, excluding external torque and spring; 1e30 means no limit",
        ),
        (
            "motor_rate_limit",
            P::RateLimit,
            offset_of!(JointParameters, rate_limit_rad_s),
            Tunable,
            "AngularVelocity",
            NON_NEGATIVE,
            "maximum slew rate of the neutral angle; 1e30 means no limit",
        ),
        (
            "spring_stiffness",
            P::SpringStiffness,
            offset_of!(JointParameters, spring_stiffness_n_m_rad),
            Tunable,
            "RotationalStiffness",
            NON_NEGATIVE,
            "stiffness of the passive joint spring",
        ),
        (
            "spring_damping",
            P::SpringDamping,
            offset_of!(JointParameters, spring_damping_n_m_s_rad),
            Tunable,
            "RotationalDamping",
            NON_NEGATIVE,
            "damping parallel to the passive joint spring",
        ),
        (
            "rest_angle",
            P::RestAngle,
            offset_of!(JointParameters, rest_angle_rad),
            Tunable,
            "Angle",
            None,
            "angle of zero torque of the passive joint spring",
        ),
        (
            "latch_stiffness",
            P::LatchStiffness,
            offset_of!(JointParameters, latch_stiffness_n_m_rad),
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
        (
            "stiffness",
            P::Stiffness,
            offset_of!(SpatialParameters, stiffness_n_m_rad),
            Tunable,
            "RotationalStiffness",
            NON_NEGATIVE,
            stiffness,
        ),
        (
            "damping",
            P::Damping,
            offset_of!(SpatialParameters, damping_n_m_s_rad),
            Tunable,
            "RotationalDamping",
            NON_NEGATIVE,
            "damping",
        ),
    ]
};

/// Tunable and fixed parameters of all joints.
pub(super) fn parameters(table: &mut Table, topology: &Topology) {
    let layout = *table.parameters.layout();
    for joint in 0..topology.revolutes.len() {
        let (name, travel) = (topology.joint_name(joint), topology.travel(joint));
        for &(key, field, offset, variability, declared, range, meaning) in JOINT_PARAMETERS {
            let acts = match field {
                JointParameter::StartAngle => !topology.is_prescribed(joint),
                JointParameter::LatchStiffness => topology.is_free(joint) && topology.has_elastic_latch(joint),
                JointParameter::SpringStiffness | JointParameter::SpringDamping | JointParameter::RestAngle => {
                    topology.is_free(joint) && topology.revolute(joint).spring.is_some()
                }
                JointParameter::Stiffness
                | JointParameter::Damping
                | JointParameter::ConstantTorque
                | JointParameter::TorqueLimit
                | JointParameter::RateLimit => topology.is_free(joint),
            };
            if acts {
                // a prismatic joint may start anywhere
                let range = range.filter(|_| travel == Travel::Rotation || field != JointParameter::StartAngle);
                let (key, meaning) = (travel.words(key), travel.words(meaning));
                let text = Text::new(format!("{name}.{key}"), format!("joint {name}: {meaning}"));
                let (known, at) = (Parameter::Joint(joint, field), layout.joints.place(joint, offset));
                table.parameter(known, at, variability, travel.declared(declared), range, text);
            }
        }
    }
    for joint in (0..topology.spatials.len()).filter(|&joint| !topology.is_unbound(joint)) {
        let name = &topology.machine.bodies[topology.spatials[joint]].joint.name;
        for &(key, field, offset, variability, declared, range, meaning) in SPATIAL_PARAMETERS {
            let text = Text::new(format!("{name}.{key}"), format!("joint {name}: {meaning}"));
            let (known, at) = (Parameter::Spatial(joint, field), layout.spatial.place(joint, offset));
            table.parameter(known, at, variability, declared, range, text);
        }
    }
}

/// Outputs of a revolute or prismatic joint.
pub(super) fn revolute_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let (travel, now) = (topology.travel(joint), OutputSet::JOINTS);
    let mut add = JointRows { table, topology, joint };
    // locks hold the angles of joints that are not latched
    let settles = topology.has_elastic_latch(joint) && starts_closed(topology, joint);
    let depends = Depends::new([Cause::Prescribed(joint)], [Cause::Start(joint)]).settling(settles);
    let depends = Depends { factor: DependencyKind::Constant, ..depends };
    let meaning = "fold angle, by the right-hand rule about the hinge axis";
    add.real("angle", (offset_of!(JointOutputs, angle_rad), now), "Angle", depends, meaning);
    let rate_key = if travel == Travel::Rotation { "angular_velocity" } else { "velocity" };
    let depends = Depends::new([Cause::Prescribed(joint)], [Cause::StartRate(joint)]).settling(false);
    add.real(rate_key, (offset_of!(JointOutputs, rate_rad_s), now), "AngularVelocity", depends, "fold rate");
    // non-zero if the joint is held
    let depends = Depends::on_group(topology, topology.revolutes[joint]);
    let holding = "torque exerted on the outer body by the lock or the prescribed motion of the joint";
    let at = (offset_of!(JointOutputs, holding_torque_n_m), OutputSet::HOLDING);
    add.real("holding_torque", at, "Moment", depends, holding);
    if topology.is_free(joint) {
        torque_outputs(&mut add);
    }
    generator_outputs(table, topology, joint);
    dc_motor_outputs(table, topology, joint);
    reaction_outputs(table, topology, topology.revolutes[joint]);
}

/// Outputs of a joint's generator, if it has one.
fn generator_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let Some(index) = topology.machine.generators().position(|(place, _)| place == joint) else { return };
    let name = topology.joint_name(joint);
    let mut add = |key: &str, offset, declared, depends, meaning: &str| {
        let place = (table.outputs.generators.place(index, offset), OutputSet::JOINTS);
        let text = Text::new(format!("{name}.generator_{key}"), format!("joint {name}: {meaning}"));
        table.output(place, Shape::Scalar, declared, depends, text);
    };
    let turns = Depends::new([Cause::Prescribed(joint)], [Cause::StartRate(joint)]).settling(false);
    let speed = "speed of the generator shaft (high-speed shaft)";
    add("speed", offset_of!(GeneratorOutputs, speed_rad_s), "AngularVelocity", turns, speed);
    let gives =
        || Depends::new([Cause::Generator(joint)], [Cause::Generator(joint), Cause::StartRate(joint)]).settling(false);
    let torque = "generator torque on its shaft, positive against the motion";
    add("torque", offset_of!(GeneratorOutputs, torque_n_m), "Moment", gives(), torque);
    add("power", offset_of!(GeneratorOutputs, power_w), "Power", gives(), "electrical power of the generator");
}

/// Index of a joint's DC motor among those of the machine, if it has one.
fn dc_motor_of(topology: &Topology, joint: usize) -> Option<usize> {
    topology.machine.dc_motors().position(|(place, _)| place == joint)
}

/// Voltage of a joint's DC motor, if it has one.
pub(super) fn voltage_input(table: &mut Table, topology: &Topology, joint: usize) {
    let Some(index) = dc_motor_of(topology, joint) else { return };
    let name = topology.joint_name(joint);
    let text = Text::new(format!("{name}.voltage"), format!("joint {name}: voltage of the DC motor"));
    let place = table.inputs.layout().dc_motors.place(index, offset_of!(DcMotorInputs, voltage_v));
    table.input(Input::Joint(joint, JointInput::Voltage), place, Shape::Scalar, Type::Real("Voltage"), text);
}

/// Outputs of a joint's DC motor, if it has one. The current is a state; in equilibrium it follows from the voltage.
fn dc_motor_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let Some(index) = dc_motor_of(topology, joint) else { return };
    let (name, travel) = (topology.joint_name(joint), topology.travel(joint));
    let mut add = |key: &str, offset, declared, depends, meaning: &str| {
        let place = (table.outputs.dc_motors.place(index, offset), OutputSet::JOINTS);
        let text =
            Text::new(format!("{name}.{}", travel.words(key)), format!("joint {name}: {}", travel.words(meaning)));
        table.output(place, Shape::Scalar, declared, depends, text);
    };
    let of_state = || Depends::new([], []);
    let current = "armature current of the DC motor";
    add("current", offset_of!(DcMotorOutputs, current_a), "Current", of_state(), current);
    let torque = "torque of the DC motor on the outer body about the hinge axis";
    let declared = travel.declared("Moment");
    add("dc_motor_torque", offset_of!(DcMotorOutputs, torque_n_m), declared, of_state(), torque);
    let depends = Depends::new([Cause::Voltage(joint)], [Cause::Voltage(joint)]);
    let power = "electrical power at the terminals of the DC motor";
    add("electrical_power", offset_of!(DcMotorOutputs, power_w), "Power", depends, power);
}

/// Outputs of modal bodies and of beams with a curved axis: deflection of the outer end and load at the inner end, in the frame of the
/// inner end.
pub(super) fn modal_outputs(table: &mut Table, topology: &Topology) {
    let layout = table.outputs;
    for (index, body) in topology.machine.framed_bodies().enumerate() {
        let name = &topology.machine.bodies[body].name;
        let of = "in the frame of the inner end: x along the body";
        let text = Text::new(
            format!("body.{name}.deflection"),
            format!("displacement of the outer end of body {name} from its undeformed position, {{}}, {of}"),
        );
        let at = (layout.modal.place(index, offset_of!(ModalOutputs, deflection_m)), OutputSet::TIP_PLACES);
        table.output(at, Shape::Vector, "Position", Depends::new([], []).settling(false), text);
        let [force, moment] = ["force", "moment"].map(|what| {
            Text::new(
                format!("body.{name}.root_{what}"),
                format!("{what} exerted by the joint on the inner end of body {name}, {{}}, {of}"),
            )
        });
        let at = (layout.modal.place(index, offset_of!(ModalOutputs, root)), OutputSet::REACTIONS);
        wrench(table, at, &Depends::on_group(topology, body), [force, moment]);
    }
}

/// Rows of one revolute or prismatic joint.
struct JointRows<'t, 'a> {
    table: &'t mut Table,
    topology: &'t Topology<'a>,
    joint: usize,
}

impl JointRows<'_, '_> {
    fn text(&self, key: &str, meaning: &str) -> Text {
        let (name, travel) = (self.topology.joint_name(self.joint), self.topology.travel(self.joint));
        Text::new(format!("{name}.{}", travel.words(key)), format!("joint {name}: {}", travel.words(meaning)))
    }

    /// Adds a row for a field of [`JointOutputs`].
    fn real(
        &mut self,
        key: &str,
        (offset, needs): (usize, OutputSet),
        declared: &'static str,
        depends: Depends,
        meaning: &str,
    ) {
        let (text, declared) = (self.text(key, meaning), self.topology.travel(self.joint).declared(declared));
        let place = self.table.outputs.joints.place(self.joint, offset);
        self.table.output((place, needs), Shape::Scalar, declared, depends, text);
    }

    /// Adds a row for a field of [`LatchOutputs`].
    fn event(&mut self, key: &str, offset: usize, of: Type, depends: Depends, meaning: &str) {
        let (text, place) = (self.text(key, meaning), self.table.outputs.latches.place(self.joint, offset));
        self.table.event_output(place, of, depends.settling(false), text);
    }
}

/// Adds the torques about the hinge of a joint that may rotate, and its latch.
fn torque_outputs(add: &mut JointRows) {
    let (topology, joint, now) = (add.topology, add.joint, OutputSet::JOINTS);
    let (command, torque) = (Cause::Command(joint), Cause::Torque(joint));
    let (motor_start, spring_start) = (Cause::MotorStart(joint), Cause::SpringStart(joint));
    let applied = "sum of motor, spring and external torque on the outer body about the hinge axis";
    let depends = Depends::new([command, torque], [motor_start, spring_start, torque]);
    add.real("total_torque", (offset_of!(JointOutputs, torque_applied_n_m), now), "Moment", depends, applied);
    let neutral = "neutral angle of the motor after the rate limit";
    let depends = Depends::new([command], [command]).settling(false);
    add.real("neutral_angle", (offset_of!(JointOutputs, neutral_angle_rad), now), "Angle", depends, neutral);
    let motor = "motor torque after the torque limit, on the outer body about the hinge axis";
    let depends = Depends::new([command], [motor_start]);
    add.real("motor_torque", (offset_of!(JointOutputs, motor_torque_n_m), now), "Moment", depends, motor);
    if topology.revolute(joint).spring.is_some() {
        let spring = "torque of the passive joint spring and damper, on the outer body about the hinge axis";
        let depends = Depends::new([], [spring_start]);
        add.real("spring_torque", (offset_of!(JointOutputs, spring_torque_n_m), now), "Moment", depends, spring);
    }
    if topology.revolute(joint).latch.is_some() {
        let rigid = topology.has_rigid_latch(joint);
        let (depends, needs) = match rigid {
            true => (Depends::on_group(topology, topology.revolutes[joint]), OutputSet::HOLDING),
            false => (Depends::new([], [Cause::LatchPull(joint)]), now),
        };
        let meaning = "latch torque on the outer body about the hinge axis";
        add.real("latch_torque", (offset_of!(JointOutputs, latch_torque_n_m), needs), "Moment", depends, meaning);
        // A latch that is closed at the start has no closing yet: the first closing is the first event.
        let never = || Depends::new([], []);
        let depends = Depends::new([], [Cause::LatchStart(joint)]);
        add.event("latched", offset_of!(LatchOutputs, closed), Type::Boolean, depends, "latch is closed");
        let time = "time at which the latch last closed, -1 before the first closing";
        add.event("latch_time", offset_of!(LatchOutputs, time_s), Type::Real("Time"), never(), time);
        let count = "number of times the latch has closed";
        add.event("latch_count", offset_of!(LatchOutputs, count), Type::Integer, never(), count);
        if rigid {
            let declared = Type::Real(topology.travel(joint).declared("AngularImpulse"));
            let impulse = "latching impulse of the last closing on the outer body about the hinge axis";
            add.event("latch_impulse", offset_of!(LatchOutputs, impulse_n_m_s), declared, never(), impulse);
        }
    }
}

/// Outputs of a universal, ball or free joint. They are relative to the parent and do not change instantaneously.
pub(super) fn spatial_outputs(table: &mut Table, topology: &Topology, joint: usize) {
    let layout = table.outputs;
    let body = topology.spatials[joint];
    let name = &topology.machine.bodies[body].joint.name;
    let mut add = |key: &str, place, shape, declared, meaning: &str| {
        let text = Text::new(format!("{name}.{key}"), format!("joint {name}: {meaning}, {{}}"));
        table.output((place, OutputSet::SPATIAL), shape, declared, Depends::new([], []), text);
    };
    let rotation = "quaternion from the body frame to the parent frame, with continuous sign";
    let at = place!(layout.spatial, joint, SpatialOutputs, rotation);
    add("rotation", at, Shape::Quaternion, "Ratio", rotation);
    let rate = "angular velocity of the body relative to its parent, in the parent's frame";
    let at = place!(layout.spatial, joint, SpatialOutputs, angular_velocity_rad_s);
    add("angular_velocity", at, Shape::Vector, "AngularVelocity", rate);
    if !topology.is_unbound(joint) {
        reaction_outputs(table, topology, body);
    }
}

/// Outputs of all clamped joints.
pub(super) fn clamped_outputs(table: &mut Table, topology: &Topology) {
    let clamped = |body: &usize| topology.machine.bodies[*body].joint.kind.is_clamped();
    (0..topology.machine.bodies.len()).filter(clamped).for_each(|body| reaction_outputs(table, topology, body));
}

/// Force and moment of the joint at the inner end of a body.
fn reaction_outputs(table: &mut Table, topology: &Topology, body: usize) {
    let (body_name, name) = (&topology.machine.bodies[body].name, &topology.machine.bodies[body].joint.name);
    let force = format!("joint {name}: reaction force on the inner end of body {body_name}, root frame, {{}}");
    let moment =
        format!("joint {name}: reaction moment on the inner end of body {body_name}, about that end, root frame, {{}}");
    let depends = Depends::on_group(topology, body);
    let at = |offset| (table.outputs.joint_reactions.place(body, offset), OutputSet::REACTIONS);
    let (force_at, moment_at) = (at(offset_of!(Wrench, force_n)), at(offset_of!(Wrench, moment_n_m)));
    let text = Text::new(format!("{name}.reaction_force"), force);
    table.output(force_at, Shape::Vector, "Force", depends.clone(), text);
    // a ball joint transmits the moment of its spring and damper only
    let depends = match topology.is_ball(body) {
        true => Depends::new([Cause::Travel(body)], [Cause::BallStart(body)]),
        false => depends,
    };
    table.output(moment_at, Shape::Vector, "Moment", depends, Text::new(format!("{name}.reaction_moment"), moment));
}
