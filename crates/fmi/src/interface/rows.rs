//! All rows of a model except those of joints and aerodynamics: names, types, descriptions, dependencies.

use crate::interface::cause::{Cause, Depends, Reach};
use crate::interface::dependencies::loop_reach;
use crate::interface::known::{BodyParameter, Input, JointInput, Parameter};
use crate::interface::table::{
    FACTOR, NON_NEGATIVE, POSITIVE, ParameterRow, Shape, TOLERANCE, Table, Text, Type, place, wrench, wrench_texts,
};
use crate::interface::topology::Topology;
use crate::interface::{Variability, air, counters, joints, no_slips};
use foldwing_engine::load::{LoadFrame, RootMotion, Wrench};
use foldwing_engine::machine::{Machine, SectionSide};
use foldwing_engine::plant::{
    BodyParameters, EnergyOutputs, FailureOutputs, JointInputs, LoopOutputs, OutputSet, PointOutputs, SolverParameters,
};
use std::mem::offset_of;

/// Integrator of the model, which decides on rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Integrator {
    /// The model, in steps.
    Own,
    /// The importer, in Model Exchange.
    Importer {
        /// It integrates the energy accounts too.
        accounts: bool,
    },
}

/// The table of a model, rows in the order of their value references.
pub(super) fn build(machine: &Machine, integrator: Integrator) -> Table {
    let topology = Topology::new(machine);
    let mut table = Table::new(machine);
    inputs(&mut table, &topology);
    outputs(&mut table, &topology, integrator);
    parameters(&mut table, &topology);
    if let Integrator::Importer { .. } = integrator {
        frequency_limit(&mut table);
    }
    counters::locals(&mut table, machine);
    table
}

fn inputs(table: &mut Table, topology: &Topology) {
    let layout = *table.inputs.layout();
    for joint in (0..topology.revolutes.len()).filter(|&joint| topology.is_free(joint)) {
        let (name, travel) = (topology.joint_name(joint), topology.travel(joint));
        let mut add = |known, offset, key: &str, of, meaning: &str| {
            let text =
                Text::new(format!("{name}.{}", travel.words(key)), format!("joint {name}: {}", travel.words(meaning)));
            table.input(Input::Joint(joint, known), layout.joints.place(joint, offset), Shape::Scalar, of, text);
        };
        let real = |declared| Type::Real(travel.declared(declared));
        let command = offset_of!(JointInputs, command_rad);
        add(JointInput::Command, command, "angle_command", real("Angle"), "commanded neutral angle of the motor");
        let torque = offset_of!(JointInputs, torque_n_m);
        let meaning = "external torque on the outer body about the hinge axis";
        add(JointInput::Torque, torque, "external_torque", real("Moment"), meaning);
        let release = offset_of!(JointInputs, release);
        add(
            JointInput::Release,
            release,
            "release",
            Type::Boolean,
            "joint may turn (false locks it in its current position)",
        );
        if topology.revolute(joint).latch.is_some() {
            let enable = offset_of!(JointInputs, latch_enable);
            add(JointInput::LatchEnable, enable, "latch_enable", Type::Boolean, "latch may close (false opens it)");
        }
        if topology.revolute(joint).generator.is_some() {
            let on = offset_of!(JointInputs, generator_on);
            add(JointInput::GeneratorOn, on, "generator_on", Type::Boolean, "generator is connected");
        }
        joints::voltage_input(table, topology, joint);
    }
    for (station, &(body, number)) in topology.stations.iter().enumerate() {
        let body = &topology.machine.bodies[body];
        let frame = match body.load_frame {
            LoadFrame::Root => "root frame",
            LoadFrame::Section => "section frame",
        };
        let mut vector = |offset, key: &str, declared| {
            let name = format!("load.{}[{number}].{key}", body.name);
            let text = Text::new(name, format!("{key} on station {number} of body {}, {{}}, {frame}", body.name));
            let of_all = format!("{key} on the stations of body {}, {{}}, {frame}", body.name);
            let text = text.in_array(format!("load.{}.{key}", body.name), of_all);
            let place = layout.stations.place(station, offset);
            table.input(Input::Load(station), place, Shape::Vector, Type::Real(declared), text);
        };
        vector(offset_of!(Wrench, force_n), "force", "Force");
        vector(offset_of!(Wrench, moment_n_m), "moment", "Moment");
    }
    let mut root = |known, offset, name: &str, declared, meaning: &str| {
        let text = Text::new(name, format!("{meaning}, {{}}, root frame"));
        table.input(known, layout.root.place(0, offset), Shape::Vector, Type::Real(declared), text);
    };
    root(Input::Gravity, offset_of!(RootMotion, gravity_m_s2), "gravity", "Acceleration", "acceleration of gravity");
    let acceleration = "inertial acceleration of the root's origin, without gravity";
    let at = offset_of!(RootMotion, acceleration_m_s2);
    root(Input::RootAcceleration, at, "root.acceleration", "Acceleration", acceleration);
    let at = offset_of!(RootMotion, angular_velocity_rad_s);
    let spin = "angular velocity of the root frame";
    root(Input::RootAngularVelocity, at, "root.angular_velocity", "AngularVelocity", spin);
    let at = offset_of!(RootMotion, angular_acceleration_rad_s2);
    let spin_up = "angular acceleration of the root frame";
    root(Input::RootAngularAcceleration, at, "root.angular_acceleration", "AngularAcceleration", spin_up);
    air::inputs(table, topology);
    for (index, failure) in topology.machine.failures.iter().enumerate() {
        let name = &failure.name;
        let meaning = format!("failure {name}: true triggers it; resetting to false has no effect");
        let (text, at) = (Text::new(format!("failure.{name}.trigger"), meaning), layout.failures.place(index, 0));
        table.input(Input::Failure(index), at, Shape::Scalar, Type::Boolean, text);
    }
    air::flap_inputs(table, topology);
}

fn outputs(table: &mut Table, topology: &Topology, integrator: Integrator) {
    let layout = table.outputs;
    for joint in 0..topology.revolutes.len() {
        joints::revolute_outputs(table, topology, joint);
    }
    for joint in 0..topology.spatials.len() {
        joints::spatial_outputs(table, topology, joint);
    }
    joints::clamped_outputs(table, topology);
    joints::modal_outputs(table, topology);
    let names: Vec<&str> = topology.machine.gauges.iter().map(|gauge| gauge.name.as_str()).collect();
    let gauges = format!("strain of the gauges {}", names.join(", "));
    for (index, gauge) in topology.machine.gauges.iter().enumerate() {
        let body = &topology.machine.bodies[gauge.body].name;
        let [x, y, z] = gauge.direction.into();
        let what = match (y, z) {
            (0.0, 0.0) => "axial strain".to_owned(),
            _ => format!("strain along ({x:.4}, {y:.4}, {z:.4}) of the section frame"),
        };
        let (at, [y, z]) = (gauge.position_m, [gauge.y_m, gauge.z_m]);
        let meaning = format!("{what} on body {body} at {at} m, y = {y} m, z = {z} m");
        let mut depends = Depends::on_group(topology, gauge.body);
        depends.initial.push(Cause::Stiffness(gauge.body));
        let text = Text::new(format!("gauge.{}.strain", gauge.name), meaning).in_array("gauge.strain", &*gauges);
        table.output((layout.gauges.place(index, 0), OutputSet::GAUGES), Shape::Scalar, "Strain", depends, text);
    }
    for (index, place) in topology.machine.internal_loads.iter().enumerate() {
        let body = &topology.machine.bodies[place.body].name;
        let at = place.position_m;
        let side = match place.side {
            SectionSide::Inboard => "",
            SectionSide::Outboard => ", outboard of attachments there",
        };
        let of =
            format!("of the outboard part of body {body} on the inboard part at {at} m{side}, {{}}, section frame");
        let depends = Depends::on_group(topology, place.body);
        let (name, first) = (format!("internal_load.{}", place.name), layout.internal_loads.place(index, 0));
        let texts = wrench_texts(&name, [&format!("force {of}"), &format!("moment {of}")]);
        wrench(table, (first, OutputSet::SECTION_LOADS), &depends, texts);
    }
    for (index, closure) in topology.machine.closures.iter().enumerate() {
        loop_outputs(table, topology, index, &closure.name);
    }
    topology.machine.no_slips.iter().enumerate().for_each(|no_slip| no_slips::outputs(table, topology, no_slip));
    let [force, moment] = [
        "force of the wing on the aircraft, {}, root frame",
        "moment of the wing on the aircraft at the origin, {}, root frame",
    ];
    let root = (layout.root.place(0, 0), OutputSet::ROOT);
    wrench(table, root, &Depends::on_push(Reach::Root), wrench_texts("root", [force, moment]));
    for (tip, &body) in topology.tips.iter().enumerate() {
        let name = &topology.machine.bodies[body].name;
        let group = if topology.tips.len() == 1 { "tip".to_owned() } else { format!("tip.{name}") };
        let of = format!("of the free end of body {name}");
        let fields =
            [POSITION, VELOCITY, ACCELERATION, ANGULAR_VELOCITY, ANGULAR_ACCELERATION, ROTATION, SPECIFIC_FORCE];
        for field in fields {
            let needs = match field.motion {
                Motion::Place | Motion::Attitude => OutputSet::TIP_PLACES,
                Motion::Velocity
                | Motion::AngularVelocity
                | Motion::Acceleration
                | Motion::AngularAcceleration
                | Motion::SpecificForce => OutputSet::TIP_MOTIONS,
            };
            let at = (layout.tips.place(tip, field.offset), needs);
            field.add(table, topology, (at, body), [&group, &of], None);
        }
    }
    for (station, &(body, number)) in topology.stations.iter().enumerate() {
        let name = &topology.machine.bodies[body].name;
        let (group, of) = (format!("station.{name}[{number}]"), format!("of station {number} of body {name}"));
        let (groups, of_all) = (format!("station.{name}"), format!("of the stations of body {name}"));
        let fields =
            [POSITION, VELOCITY, ANGULAR_VELOCITY, ACCELERATION, ANGULAR_ACCELERATION, ROTATION, SPECIFIC_FORCE];
        for field in fields {
            let needs = match field.motion {
                Motion::Place | Motion::Attitude => OutputSet::STATION_PLACES,
                Motion::Acceleration | Motion::AngularAcceleration | Motion::SpecificForce => {
                    OutputSet::STATION_ACCELERATIONS
                }
                Motion::Velocity | Motion::AngularVelocity => OutputSet::STATION_MOTIONS,
            };
            let at = (layout.stations.place(station, field.offset), needs);
            field.add(table, topology, (at, body), [&group, &of], Some([&groups, &of_all]));
        }
    }
    energies(table, topology, integrator != Integrator::Importer { accounts: false });
    air::outputs(table, topology);
    for (index, failure) in topology.machine.failures.iter().enumerate() {
        failure_outputs(table, index, &failure.name);
    }
}

fn failure_outputs(table: &mut Table, index: usize, name: &str) {
    let layout = table.outputs;
    // a failure depends on its input, or on the input of the failure that triggers it
    let depends = || Depends::new([], [Cause::AnyFailure]).settling(false);
    let at = place!(layout.failures, index, FailureOutputs, failed);
    let text = Text::new(format!("failure.{name}.failed"), format!("failure {name}: has occurred"));
    table.event_output(at, Type::Boolean, depends(), text);
    let at = place!(layout.failures, index, FailureOutputs, time_s);
    let meaning = format!("failure {name}: time of occurrence, -1 before");
    let text = Text::new(format!("failure.{name}.time"), meaning);
    table.event_output(at, Type::Real("Time"), depends(), text);
}

fn loop_outputs(table: &mut Table, topology: &Topology, closure: usize, name: &str) {
    let layout = table.outputs;
    let [first, second] =
        topology.ends(closure).map(|body| body.map_or("the root", |body| topology.machine.bodies[body].name.as_str()));
    let text = Text::new(
        format!("loop.{name}.gap"),
        format!("gap of loop {name}: vector from its point on {first} to its point on {second}, {{}}, root frame"),
    );
    let gap =
        Depends::new([Cause::LoopTravel(closure)], topology.joined(closure).map(Cause::Folds).collect::<Vec<_>>());
    let at = place!(layout.loops, closure, LoopOutputs, gap_m);
    table.output((at, OutputSet::LOOPS), Shape::Vector, "Position", gap, text);
    let on = if first == "the root" { first.to_owned() } else { format!("body {first}") };
    let text = Text::new(
        format!("loop.{name}.force"),
        format!("force of loop {name} on {on}; the opposite force acts on {second}, {{}}, root frame"),
    );
    // without inertia a penalty force follows from the state alone
    let running = match !topology.machine.closures[closure].resists_acceleration() {
        true => vec![Cause::LoopTravel(closure)],
        false => vec![Cause::Push(loop_reach(topology, closure)), Cause::Air],
    };
    let force = Depends::new(running, [Cause::LoopPull(closure)]);
    let at = place!(layout.loops, closure, LoopOutputs, force_n);
    table.output((at, OutputSet::LOOPS), Shape::Vector, "Force", force, text);
}

/// Quantity of a point's motion.
#[derive(Clone, Copy, PartialEq)]
enum Motion {
    Place,
    Velocity,
    AngularVelocity,
    Acceleration,
    AngularAcceleration,
    Attitude,
    SpecificForce,
}

/// A row of a point.
#[derive(Clone, Copy)]
struct PointRow {
    key: &'static str,
    offset: usize,
    shape: Shape,
    declared: &'static str,
    meaning: &'static str,
    frame: &'static str,
    motion: Motion,
}

macro_rules! point_rows {
    ($($name:ident: $shape:ident $key:literal $field:ident $declared:literal $motion:ident $meaning:literal, $frame:literal;)*) => {
        $(const $name: PointRow = PointRow {
            key: $key,
            offset: offset_of!(PointOutputs, $field),
            shape: Shape::$shape,
            declared: $declared,
            meaning: $meaning,
            frame: $frame,
            motion: Motion::$motion,
        };)*
    };
}

point_rows! {
    POSITION: Vector "position" position_m "Position" Place "position", "root frame";
    VELOCITY: Vector "velocity" velocity_m_s "Velocity" Velocity "velocity relative to the root frame", "root frame";
    ANGULAR_VELOCITY: Vector "angular_velocity" angular_velocity_rad_s "AngularVelocity" AngularVelocity
        "angular velocity relative to the root frame", "root frame";
    ACCELERATION: Vector "acceleration" acceleration_m_s2 "Acceleration" Acceleration
        "inertial acceleration, without gravity,", "root frame";
    ANGULAR_ACCELERATION: Vector "angular_acceleration" angular_acceleration_rad_s2 "AngularAcceleration" AngularAcceleration
        "inertial angular acceleration", "root frame";
    ROTATION: Quaternion "rotation" rotation "Ratio" Attitude
        "quaternion from section to root frame, with continuous sign,", "root frame";
    SPECIFIC_FORCE: Vector "specific_force" specific_force_m_s2 "Acceleration" SpecificForce
        "specific force, the reading of an accelerometer (inertial acceleration minus gravity),", "section frame";
}

impl PointRow {
    /// `all`: name prefix and meaning of the array to which the point belongs, if any.
    fn add(
        &self,
        table: &mut Table,
        topology: &Topology,
        (at, body): ((usize, OutputSet), usize),
        [group, of]: [&str; 2],
        all: Option<[&str; 2]>,
    ) {
        let by_state = |initial| Depends::new([Cause::Travel(body)], [initial]);
        let depends = match self.motion {
            Motion::Place => by_state(Cause::Folds(body)),
            Motion::Velocity => by_state(Cause::VelocityStart(body)),
            Motion::AngularVelocity => by_state(Cause::AngularVelocityStart(body)),
            Motion::Attitude => by_state(Cause::AttitudeStart(body)),
            Motion::Acceleration if topology.floats(body) => Depends::on_push(Reach::Flight(topology.group[body])),
            Motion::Acceleration | Motion::AngularAcceleration => Depends::on_group(topology, body),
            // an accelerometer on a floating group does not measure gravity
            Motion::SpecificForce => {
                let mut depends = Depends::on_group(topology, body);
                depends.running.push(Cause::Travel(body));
                depends.initial.push(Cause::AttitudeStart(body));
                if !topology.floats(body) {
                    depends.running.push(Cause::Weight);
                    depends.initial.push(Cause::Weight);
                }
                depends
            }
        };
        let name = |group: &str| format!("{group}.{}", self.key);
        let meaning = |of: &str| format!("{} {of}, {{}}, {}", self.meaning, self.frame);
        let text = Text::new(name(group), meaning(of));
        let text = match all {
            Some([group, of]) => text.in_array(name(group), meaning(of)),
            None => text,
        };
        table.output(at, self.shape, self.declared, depends, text);
    }
}

fn energies(table: &mut Table, topology: &Topology, accounts: bool) {
    let layout = table.outputs;
    let joints = || 0..topology.revolutes.len();
    let closures = || 0..topology.machine.closures.len();
    let kinetic = Depends::new([Cause::AnyTravel], [Cause::KineticStart]);
    let springs = joints().filter(|&joint| topology.is_free(joint));
    let springs = springs.flat_map(|joint| [Cause::LatchPull(joint), Cause::SpringStore(joint)]);
    let stops = joints().filter(|&joint| topology.is_free(joint) && topology.revolute(joint).end_stops.is_some());
    let springs = springs.chain(stops.map(Cause::Start));
    let opened = closures().flat_map(|closure| topology.opens(closure)).map(Cause::Start);
    let elastic =
        Depends::new(closures().map(Cause::LoopTravel).collect::<Vec<_>>(), springs.chain(opened).collect::<Vec<_>>());
    let heights = [Cause::Weight, Cause::AnyMassFactor].into_iter().chain(joints().map(Cause::Start));
    let gravity = Depends::new([Cause::Weight, Cause::AnyTravel], heights.collect::<Vec<_>>());
    let drive = Depends::new([Cause::AnyCommand], [Cause::DriveStart]);
    let parts = [&kinetic, &elastic, &gravity, &drive];
    let total = Depends::new(
        parts.iter().flat_map(|part| part.running.clone()).collect::<Vec<_>>(),
        parts.iter().flat_map(|part| part.initial.clone()).collect::<Vec<_>>(),
    );
    // a jump of an input changes a potential instantaneously; the jump counts as its work
    let work = Depends::new([Cause::Weight, Cause::AnyCommand], []);
    let mut add = |name: &str, offset, needs, depends, meaning: &str| {
        let (at, text) = (layout.energy.place(0, offset), Text::new(format!("energy.{name}"), meaning));
        table.output((at, needs), Shape::Scalar, "Energy", depends, text);
    };
    let (now, booked) = (OutputSet::ENERGIES, OutputSet::ACCOUNTS);
    let meaning = "kinetic energy relative to the root frame";
    add("kinetic", offset_of!(EnergyOutputs, kinetic), now, kinetic, meaning);
    let meaning = "elastic energy of beams, joint springs, end stops and closed latches";
    add("elastic", offset_of!(EnergyOutputs, elastic), now, elastic, meaning);
    let meaning = "potential energy in gravity minus root acceleration, zero at the origin";
    add("gravity", offset_of!(EnergyOutputs, gravity), now, gravity, meaning);
    let meaning = "potential energy of the motors' stiffness and constant torques within their limits";
    add("motor", offset_of!(EnergyOutputs, motor), now, drive, meaning);
    if accounts {
        add("work", offset_of!(EnergyOutputs, work), booked, work, "work done by the inputs since the start");
        let meaning =
            "energy dissipated since the start by damping, opening of latches and impulsive stopping of joints";
        add("dissipated", offset_of!(EnergyOutputs, dissipated), booked, Depends::new([], []), meaning);
    }
    let meaning = match accounts {
        true => "kinetic + elastic + gravity + motor; total - work + dissipated is constant",
        false => "kinetic + elastic + gravity + motor",
    };
    add("total", offset_of!(EnergyOutputs, total), now, total, meaning);
}

const BODY_PARAMETERS: &[ParameterRow<BodyParameter>] = {
    use BodyParameter as P;
    use Variability::{Fixed, Tunable};
    &[
        (
            "mass_factor",
            P::MassFactor,
            offset_of!(BodyParameters, mass_factor),
            Fixed,
            "Ratio",
            FACTOR,
            "factor on the beam's inertia, without attached masses",
        ),
        (
            "stiffness_factor",
            P::StiffnessFactor,
            offset_of!(BodyParameters, stiffness_factor),
            Fixed,
            "Ratio",
            FACTOR,
            "factor on the section stiffness",
        ),
        (
            "mass_damping",
            P::MassDamping,
            offset_of!(BodyParameters, mass_damping_1_s),
            Tunable,
            "DampingRate",
            NON_NEGATIVE,
            "mass-proportional damping alpha",
        ),
        (
            "stiffness_damping",
            P::StiffnessDamping,
            offset_of!(BodyParameters, stiffness_damping_s),
            Tunable,
            "Time",
            NON_NEGATIVE,
            "stiffness-proportional damping beta",
        ),
    ]
};

const SOLVER_PARAMETERS: &[ParameterRow<()>] = {
    use Variability::Fixed;
    &[
        (
            "tolerance",
            (),
            offset_of!(SolverParameters, tolerance),
            Fixed,
            "Ratio",
            TOLERANCE,
            "error tolerance per step: displacement divided by wing length, rotation in rad",
        ),
        ("max_step", (), offset_of!(SolverParameters, max_step_s), Fixed, "Time", POSITIVE, "maximum internal step"),
        (
            "min_step",
            (),
            offset_of!(SolverParameters, min_step_s),
            Fixed,
            "Time",
            POSITIVE,
            "minimum internal step; non-convergence at this step is an error",
        ),
    ]
};

/// The parameter of Model Exchange alone.
fn frequency_limit(table: &mut Table) {
    let at = table.parameters.layout().solver.place(0, offset_of!(SolverParameters, frequency_limit_rad_s));
    let meaning = "in Model Exchange, vibrations of beams at w take w/sqrt(1 + (w/limit)^2); 0: as they are";
    let text = Text::new("solver.frequency_limit", meaning);
    table.parameter(Parameter::Solver, at, Variability::Fixed, "AngularVelocity", NON_NEGATIVE, text);
}

fn parameters(table: &mut Table, topology: &Topology) {
    let layout = *table.parameters.layout();
    joints::parameters(table, topology);
    let beams = topology.machine.bodies.iter().enumerate().filter(|(_, body)| !body.is_rigid());
    for (index, body) in beams {
        // mode shapes have separate damping ratios
        let count = if body.is_modal() { 2 } else { BODY_PARAMETERS.len() };
        for &(key, field, offset, variability, declared, range, meaning) in &BODY_PARAMETERS[..count] {
            let name = &body.name;
            let text = Text::new(format!("body.{name}.{key}"), format!("{meaning}, body {name}"));
            let (known, at) = (Parameter::Body(index, field), layout.bodies.place(index, offset));
            table.parameter(known, at, variability, declared, range, text);
        }
    }
    air::parameters(table, topology);
    for &(key, (), offset, variability, declared, range, meaning) in SOLVER_PARAMETERS {
        let (at, text) = (layout.solver.place(0, offset), Text::new(format!("solver.{key}"), meaning));
        table.parameter(Parameter::Solver, at, variability, declared, range, text);
    }
}
