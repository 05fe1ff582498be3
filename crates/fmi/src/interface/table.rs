//! The rows of the table, built from one machine.

use crate::interface::air;
use crate::interface::binding::{
    Binding, BodyParameter, EnergyOutput, Input, JointInput, JointOutput, Output, Parameter, PointOutput,
    SolverParameter,
};
use crate::interface::counters;
use crate::interface::joints;
use crate::interface::topology::Topology;
use crate::interface::{Causality, Initial, Value, Variability, Variable};
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{SectionSide, UNLIMITED};
use foldwing_engine::plant::{FACTOR_RANGE, Inputs, Parameters};

/// Components of a vector.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];
/// Components of a quaternion.
pub(super) const QUATERNION: [&str; 4] = ["w", "x", "y", "z"];

pub(super) const NON_NEGATIVE: Option<(f64, f64)> = Some((0.0, UNLIMITED));
const FACTOR: Option<(f64, f64)> = Some(FACTOR_RANGE);
/// A fold joint starts within one turn either way.
pub(super) const TURN: Option<(f64, f64)> = Some((-360_f64.to_radians(), 360_f64.to_radians()));
const TOLERANCE: Option<(f64, f64)> = Some((1e-12, 1e-1));
/// Steps are positive; the bounds only keep zero and nonsense out.
const STEP: Option<(f64, f64)> = Some((1e-30, UNLIMITED));

/// Positive numbers.
pub(super) const POSITIVE: Range = STEP;

pub(super) type Range = Option<(f64, f64)>;
pub(super) type ParameterRow<Field> = (&'static str, Field, Variability, &'static str, Range, &'static str);
type Fields<Field> = [(&'static str, Field, &'static str, &'static str)];

const BODY_PARAMETERS: &[ParameterRow<BodyParameter>] = {
    use BodyParameter as P;
    use Variability::{Fixed, Tunable};
    &[
        (
            "mass_factor",
            P::MassFactor,
            Fixed,
            "Ratio",
            FACTOR,
            "factor on the beam's inertia, attached masses excepted",
        ),
        ("stiffness_factor", P::StiffnessFactor, Fixed, "Ratio", FACTOR, "factor on the section stiffness"),
        ("mass_damping", P::MassDamping, Tunable, "DampingRate", NON_NEGATIVE, "mass-proportional damping alpha"),
        (
            "stiffness_damping",
            P::StiffnessDamping,
            Tunable,
            "Time",
            NON_NEGATIVE,
            "stiffness-proportional damping beta",
        ),
    ]
};

const SOLVER_PARAMETERS: &[ParameterRow<SolverParameter>] = {
    use SolverParameter as P;
    use Variability::Fixed;
    &[
        (
            "tolerance",
            P::Tolerance,
            Fixed,
            "Ratio",
            TOLERANCE,
            "error per step: displacement over wing length, rotation in rad",
        ),
        ("max_step", P::MaxStep, Fixed, "Time", STEP, "largest internal step"),
        ("min_step", P::MinStep, Fixed, "Time", STEP, "smallest internal step; below it non-convergence is an error"),
    ]
};

const ENERGIES: &Fields<EnergyOutput> = &[
    ("kinetic", EnergyOutput::Kinetic, "Energy", "kinetic energy relative to the root frame"),
    ("elastic", EnergyOutput::Elastic, "Energy", "strain energy of beams, springs of fold joints and closed latches"),
    ("gravity", EnergyOutput::Gravity, "Energy", "potential of gravity minus root acceleration, zero at the origin"),
    (
        "drive",
        EnergyOutput::Drive,
        "Energy",
        "potential of the motors' stiffness and constant torques within their limits",
    ),
    ("work", EnergyOutput::Work, "Energy", "work done by the inputs since the start"),
    (
        "dissipated",
        EnergyOutput::Dissipated,
        "Energy",
        "energy dissipated by damping, opening latches and stopping joints since the start",
    ),
    (
        "total",
        EnergyOutput::Total,
        "Energy",
        "kinetic + elastic + gravity + drive; total - work + dissipated is constant",
    ),
];

/// Rows and bindings of a machine, in the order of their value references.
pub(super) fn build(machine: &Machine) -> (Vec<Variable>, Vec<Binding>) {
    let topology = Topology::new(machine);
    let mut table = Table {
        inputs: Inputs::of(machine),
        parameters: Parameters::of(machine),
        variables: Vec::new(),
        bindings: Vec::new(),
    };
    let time = ("time".to_owned(), Some("Time"), None, "simulation time".to_owned());
    table.push(Binding::Time, Causality::Independent, Variability::Continuous, Value::Real(0.0), time);
    inputs(&mut table, &topology);
    outputs(&mut table, &topology);
    parameters(&mut table, &topology);
    counters::locals(&mut table, machine);
    (table.variables, table.bindings)
}

fn inputs(table: &mut Table, topology: &Topology) {
    for joint in (0..topology.revolutes.len()).filter(|&joint| topology.is_free(joint)) {
        let (name, travel) = (topology.joint_name(joint), topology.travel(joint));
        let mut add = |field, key: &str, declared: Option<&'static str>, meaning: &str| {
            table.input(
                Input::Joint(joint, field),
                format!("{name}.{}", travel.words(key)),
                declared.map(|declared| travel.declared(declared)),
                format!("joint {name}: {}", travel.words(meaning)),
            );
        };
        add(JointInput::Command, "command", Some("Angle"), "commanded neutral angle of the motor");
        add(JointInput::Torque, "torque", Some("Moment"), "external torque on the outer body about the hinge axis");
        add(JointInput::Release, "release", None, "joint may turn (false holds it where it is)");
        if topology.revolute(joint).latch.is_some() {
            add(JointInput::LatchEnable, "latch_enable", None, "latch may close (false opens it)");
        }
    }
    for (station, &(body, number)) in topology.stations.iter().enumerate() {
        let body = &topology.machine.bodies[body];
        let group = format!("load.{}[{number}]", body.name);
        let frame = match body.load_frame {
            foldwing_engine::load::LoadFrame::Root => "root frame",
            foldwing_engine::load::LoadFrame::Section => "section frame",
        };
        let mut vector = |bind: fn(usize, usize) -> Input, key: &str, declared| {
            for (i, axis) in AXES.iter().enumerate() {
                let meaning = format!("{key} on station {number} of body {}, {axis}, {frame}", body.name);
                table.input(bind(station, i), format!("{group}.{key}.{axis}"), Some(declared), meaning);
            }
        };
        vector(Input::StationForce, "force", "Force");
        vector(Input::StationMoment, "moment", "Moment");
    }
    let mut root = |bind: fn(usize) -> Input, group: &str, declared, meaning: &str| {
        for (i, axis) in AXES.iter().enumerate() {
            table.input(bind(i), format!("{group}.{axis}"), Some(declared), format!("{meaning}, {axis}, root frame"));
        }
    };
    root(Input::Gravity, "gravity", "Acceleration", "gravity");
    let acceleration = "inertial acceleration of the root's origin, without gravity";
    root(Input::RootAcceleration, "root.acceleration", "Acceleration", acceleration);
    root(Input::RootAngularVelocity, "root.angular_velocity", "AngularVelocity", "angular velocity of the root frame");
    let spin_up = "angular acceleration of the root frame";
    root(Input::RootAngularAcceleration, "root.angular_acceleration", "AngularAcceleration", spin_up);
    air::inputs(table, topology);
}

fn outputs(table: &mut Table, topology: &Topology) {
    for joint in 0..topology.revolutes.len() {
        joints::revolute_outputs(table, topology, joint);
    }
    for joint in 0..topology.spatials.len() {
        joints::spatial_outputs(table, topology, joint);
    }
    joints::clamped_outputs(table, topology);
    for (index, gauge) in topology.machine.gauges.iter().enumerate() {
        let body = &topology.machine.bodies[gauge.body].name;
        let [x, y, z] = gauge.direction.into();
        let what = match (y, z) {
            (0.0, 0.0) => "axial strain".to_owned(),
            _ => format!("strain along ({x:.4}, {y:.4}, {z:.4}) of the section frame"),
        };
        let (at, [y, z]) = (gauge.position_m, [gauge.y_m, gauge.z_m]);
        let meaning = format!("{what} on body {body} at {at} m, y = {y} m, z = {z} m");
        table.output(Output::Gauge(index), format!("gauge.{}.strain", gauge.name), Some("Strain"), meaning);
    }
    for (index, place) in topology.machine.section_loads.iter().enumerate() {
        let body = &topology.machine.bodies[place.body].name;
        let (at, side) = (
            place.position_m,
            match place.side {
                SectionSide::Inboard => "",
                SectionSide::Outboard => ", outboard of what is attached there",
            },
        );
        let of = format!("of the outboard part of body {body} on the inboard part at {at} m{side}");
        for (i, axis) in AXES.iter().enumerate() {
            let (name, meaning) = (format!("section_load.{}.force.{axis}", place.name), format!("force {of}"));
            let output = Output::SectionForce(index, i);
            table.output(output, name, Some("Force"), format!("{meaning}, {axis}, section frame"));
        }
        for (i, axis) in AXES.iter().enumerate() {
            let (name, meaning) = (format!("section_load.{}.moment.{axis}", place.name), format!("moment {of}"));
            let output = Output::SectionMoment(index, i);
            table.output(output, name, Some("Moment"), format!("{meaning}, {axis}, section frame"));
        }
    }
    for (index, closure) in topology.machine.closures.iter().enumerate() {
        loop_outputs(table, topology, index, &closure.name);
    }
    for (i, axis) in AXES.iter().enumerate() {
        let meaning = format!("force of the wing on the aircraft, {axis}, root frame");
        table.output(Output::RootForce(i), format!("root.force.{axis}"), Some("Force"), meaning);
    }
    for (i, axis) in AXES.iter().enumerate() {
        let meaning = format!("moment of the wing on the aircraft at the origin, {axis}, root frame");
        table.output(Output::RootMoment(i), format!("root.moment.{axis}"), Some("Moment"), meaning);
    }
    for (tip, &body) in topology.tips.iter().enumerate() {
        let body = &topology.machine.bodies[body].name;
        let group = if topology.tips.len() == 1 { "tip".to_owned() } else { format!("tip_{body}") };
        let of = format!("of the free end of body {body}");
        let fields: &[PointRows] =
            &[POSITION, VELOCITY, ACCELERATION, ANGULAR_VELOCITY, ANGULAR_ACCELERATION, ROTATION];
        point(table, |field| Output::Tip(tip, field), &group, &of, fields);
    }
    for (station, &(body, number)) in topology.stations.iter().enumerate() {
        let body = &topology.machine.bodies[body].name;
        let group = format!("station.{body}[{number}]");
        let of = format!("of station {number} of body {body}");
        let fields: &[PointRows] =
            &[POSITION, VELOCITY, ANGULAR_VELOCITY, ACCELERATION, ANGULAR_ACCELERATION, ROTATION];
        point(table, |field| Output::Station(station, field), &group, &of, fields);
    }
    for &(name, field, declared, meaning) in ENERGIES {
        table.output(Output::Energy(field), format!("energy.{name}"), Some(declared), meaning.to_owned());
    }
    air::outputs(table, topology);
}

fn loop_outputs(table: &mut Table, topology: &Topology, closure: usize, name: &str) {
    let [first, second] = topology.joined(closure).map(|body| topology.machine.bodies[body].name.as_str());
    for (i, axis) in AXES.iter().enumerate() {
        let meaning =
            format!("gap of loop {name}, from its point on {first} to its point on {second}, {axis}, root frame");
        table.output(Output::LoopGap(closure, i), format!("loop.{name}.gap.{axis}"), Some("Position"), meaning);
    }
    for (i, axis) in AXES.iter().enumerate() {
        let meaning =
            format!("force of loop {name} on body {first}; the opposite force acts on {second}, {axis}, root frame");
        table.output(Output::LoopForce(closure, i), format!("loop.{name}.force.{axis}"), Some("Force"), meaning);
    }
}

/// Key, binding per component, component names, declared type, meaning.
type PointRows = (&'static str, fn(usize) -> PointOutput, &'static [&'static str], &'static str, &'static str);

const POSITION: PointRows = ("position", PointOutput::Position, &AXES, "Position", "position");
const VELOCITY: PointRows =
    ("velocity", PointOutput::Velocity, &AXES, "Velocity", "velocity relative to the root frame");
const ANGULAR_VELOCITY: PointRows = (
    "angular_velocity",
    PointOutput::AngularVelocity,
    &AXES,
    "AngularVelocity",
    "angular velocity relative to the root frame",
);
const ACCELERATION: PointRows =
    ("acceleration", PointOutput::Acceleration, &AXES, "Acceleration", "inertial acceleration, without gravity,");
const ANGULAR_ACCELERATION: PointRows = (
    "angular_acceleration",
    PointOutput::AngularAcceleration,
    &AXES,
    "AngularAcceleration",
    "inertial angular acceleration",
);
const ROTATION: PointRows =
    ("rotation", PointOutput::Rotation, &QUATERNION, "Ratio", "quaternion from section to root, with continuous sign,");

fn point(table: &mut Table, bind: impl Fn(PointOutput) -> Output, group: &str, of: &str, rows: &[PointRows]) {
    for &(key, field, components, declared, meaning) in rows {
        for (i, component) in components.iter().enumerate() {
            let meaning = format!("{meaning} {of}, {component}, root frame");
            table.output(bind(field(i)), format!("{group}.{key}.{component}"), Some(declared), meaning);
        }
    }
}

fn parameters(table: &mut Table, topology: &Topology) {
    joints::parameters(table, topology);
    let beams = topology.machine.bodies.iter().enumerate().filter(|(_, body)| !body.is_rigid());
    for (index, body) in beams {
        for &(key, field, variability, declared, range, meaning) in BODY_PARAMETERS {
            let name = &body.name;
            let text = (format!("body.{name}.{key}"), Some(declared), range, format!("{meaning}, body {name}"));
            table.parameter(Parameter::Body(index, field), variability, text);
        }
    }
    air::parameters(table, topology);
    for &(key, field, variability, declared, range, meaning) in SOLVER_PARAMETERS {
        let text = (format!("solver.{key}"), Some(declared), range, meaning.to_owned());
        table.parameter(Parameter::Solver(field), variability, text);
    }
}

/// Name, declared type, range, description of a row.
pub(super) type Text = (String, Option<&'static str>, Range, String);

/// The table while it grows.
pub(super) struct Table {
    inputs: Inputs,
    parameters: Parameters,
    variables: Vec<Variable>,
    bindings: Vec<Binding>,
}

impl Table {
    pub(super) fn input(
        &mut self,
        input: Input,
        name: String,
        declared_type: Option<&'static str>,
        description: String,
    ) {
        let start = input.read(&self.inputs);
        let variability = match start {
            Value::Real(_) => Variability::Continuous,
            Value::Integer(_) | Value::Boolean(_) => Variability::Discrete,
        };
        self.push(
            Binding::Input(input),
            Causality::Input,
            variability,
            start,
            (name, declared_type, None, description),
        );
    }

    pub(super) fn output(
        &mut self,
        output: Output,
        name: String,
        declared_type: Option<&'static str>,
        description: String,
    ) {
        // The time of an event and flags change at events only; everything else moves with time.
        let variability = match output {
            Output::Joint(
                _,
                JointOutput::Latched | JointOutput::LatchTime | JointOutput::LatchCount | JointOutput::LatchImpulse,
            ) => Variability::Discrete,
            _ => Variability::Continuous,
        };
        let text = (name, declared_type, None, description);
        self.push(Binding::Output(output), Causality::Output, variability, output.zero(), text);
    }

    pub(super) fn parameter(&mut self, parameter: Parameter, variability: Variability, text: Text) {
        let start = Value::Real(parameter.read(&self.parameters));
        self.push(Binding::Parameter(parameter), Causality::Parameter, variability, start, text);
    }

    pub(super) fn push(
        &mut self,
        binding: Binding,
        causality: Causality,
        variability: Variability,
        value: Value,
        text: Text,
    ) {
        let (name, declared_type, range, description) = text;
        let value_reference = u32::try_from(self.variables.len()).expect("fewer than 2^32 variables");
        self.bindings.push(binding);
        self.variables.push(Variable {
            name,
            value_reference,
            causality,
            variability,
            initial: match causality {
                Causality::Input | Causality::Independent => None,
                Causality::Parameter => Some(Initial::Exact),
                Causality::Output | Causality::Local => Some(Initial::Calculated),
            },
            value,
            declared_type,
            range,
            description,
        });
    }
}
