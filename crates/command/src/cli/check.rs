//! `foldwing check`: summary of a model.

use crate::cli::air_summary::AirSummary;
use crate::cli::assessment::Assessment;
use crate::cli::beam_sections;
use crate::cli::constraint_summary::{LoopSummary, NoSlipSummary};
use crate::cli::joint_size::JointSize;
use crate::cli::notes::notes;
use crate::cli::outlets::{Force, Mark, Outlets, Quiet};
use crate::cli::progress::Progress;
use crate::cli::{Failure, read_model};
use crate::packaging::drawing;
use crate::packaging::sketch::sketch;
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{
    Body, ElementKind, LatchKind, OneFreedom, Parent, Spatial, SpatialFreedom, Travel, UNLIMITED,
};
use foldwing_engine::plant::Plant;
use foldwing_file::{BodySections, section_properties};
use foldwing_fmi::interface::{Causality, Interface, Value};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::CHECK)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    /// List every variable of the FMU
    #[arg(long = "list-variables")]
    variables: bool,
    /// List the unknowns of each joint: variables and Lagrange multipliers, compared with the conventional formulation with 12
    /// nodal coordinates (position and three frame vectors) and Lagrange multipliers (Otsuka et al., Table 2)
    #[arg(long)]
    unknowns: bool,
    /// Also write a drawing of the model, deployed and at its start angles
    #[arg(long, value_name = "FILE.svg")]
    draw: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
}

/// Prints the summary and the drawing of the model.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, text) = read_model(&arguments.model)?;
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    if let Some(path) = &arguments.draw {
        outlets.place(path, Mark::SVG)?.fill(drawing::file(&machine).as_bytes())?;
    }
    let progress = Progress::phase("assessment of the model");
    let summary = Summary::new(&machine, &text);
    drop(progress);
    summary.assessment.warnings.iter().for_each(|warning| arguments.quiet.warning(warning));
    let text = match arguments.json {
        true => summary.json(),
        false => summary.shown(&machine, arguments.variables, arguments.unknowns),
    };
    arguments.quiet.print(&text, &outlets)
}

/// Returns the summary of a machine and the text of its model file as JSON.
pub(super) fn json(machine: &Machine, file_text: &str) -> String {
    Summary::new(machine, file_text).json()
}

/// Returns the summary with a drawing of text characters, optionally with a list of the variables.
pub(super) fn text(machine: &Machine, file_text: &str, list_variables: bool) -> String {
    Summary::new(machine, file_text).shown(machine, list_variables, false)
}

/// Data of a model.
#[derive(Serialize)]
struct Summary {
    name: String,
    description: String,
    mass_kg: f64,
    degrees_of_freedom: usize,
    stations: usize,
    assessment: Assessment,
    bodies: Vec<BodySummary>,
    sections: Vec<BodySections>,
    joints: Vec<JointSummary>,
    loops: Vec<LoopSummary>,
    skates_and_wheels: Vec<NoSlipSummary>,
    air: Option<AirSummary>,
    gauges: Vec<String>,
    notes: Vec<String>,
    variables: Vec<VariableSummary>,
}

#[derive(Serialize)]
struct BodySummary {
    name: String,
    length_m: f64,
    mass_kg: f64,
    attached_mass_kg: f64,
    elements: usize,
    element_kind: &'static str,
    degrees_of_freedom: usize,
    stations_m: Vec<f64>,
}

#[derive(Serialize)]
struct JointSummary {
    name: String,
    body: String,
    parent: String,
    kind: String,
    #[serde(flatten)]
    figures: Figures,
    size: JointSize,
}

/// A start value, in JSON a number or a Boolean.
#[derive(Serialize)]
#[serde(untagged)]
enum Start {
    Real(f64),
    Integer(i32),
    Boolean(bool),
}

impl Start {
    fn text(&self) -> String {
        match self {
            Self::Real(value) => format!("{value:?}"),
            Self::Integer(value) => value.to_string(),
            Self::Boolean(value) => value.to_string(),
        }
    }
}

impl From<Value> for Start {
    fn from(value: Value) -> Self {
        match value {
            Value::Real(value) => Self::Real(value),
            Value::Integer(value) => Self::Integer(value),
            Value::Boolean(value) => Self::Boolean(value),
        }
    }
}

#[derive(Serialize)]
struct VariableSummary {
    name: String,
    causality: &'static str,
    r#type: &'static str,
    unit: &'static str,
    start: Option<Start>,
    description: String,
}

impl Summary {
    fn new(machine: &Machine, file_text: &str) -> Self {
        let bodies: Vec<BodySummary> = machine.bodies.iter().map(BodySummary::new).collect();
        let interface = Interface::new(machine);
        let mut plant = Plant::new(Arc::new(machine.clone()));
        let gaps = plant.surface_gaps();
        let joint = |(index, body): (usize, &Body)| JointSummary::new(body, machine, plant.joint_size(index));
        Self {
            name: machine.name.clone(),
            description: machine.description.clone(),
            mass_kg: bodies.iter().map(|body| body.mass_kg + body.attached_mass_kg).sum(),
            degrees_of_freedom: bodies.iter().map(|body| body.degrees_of_freedom).sum::<usize>()
                + machine.bodies.iter().map(|body| body.joint.kind.freedoms()).sum::<usize>(),
            stations: bodies.iter().map(|body| body.stations_m.len()).sum(),
            assessment: Assessment::new(machine),
            bodies,
            sections: section_properties(file_text),
            joints: machine.bodies.iter().enumerate().map(joint).collect(),
            loops: machine.closures.iter().map(|closure| LoopSummary::new(closure, machine)).collect(),
            skates_and_wheels: machine.no_slips.iter().map(|no_slip| NoSlipSummary::new(no_slip, machine)).collect(),
            air: AirSummary::new(machine, &gaps),
            gauges: machine.gauges.iter().map(|gauge| gauge.name.clone()).collect(),
            notes: notes(machine, machine.experiment.stop_time_s),
            variables: interface.variables().iter().map(VariableSummary::new).collect(),
        }
    }

    fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("names and finite numbers always serialise")
    }

    /// Returns the summary as text, with a drawing of text characters.
    fn shown(&self, machine: &Machine, list_variables: bool, list_unknowns: bool) -> String {
        format!("{}\n{}", self.text(list_variables, list_unknowns), sketch(machine))
    }

    fn text(&self, list_variables: bool, list_unknowns: bool) -> String {
        let mut text = format!(
            "{}: {}\n{:.6} kg, {} degrees of freedom, {} load stations\n",
            self.name, self.description, self.mass_kg, self.degrees_of_freedom, self.stations
        );
        text += &self.assessment.text();
        text.push_str("\nbodies\n");
        for body in &self.bodies {
            let _ = writeln!(
                text,
                "  {}: {} m, {:.6} kg{}, {}, {} stations",
                body.name,
                body.length_m,
                body.mass_kg,
                match body.attached_mass_kg {
                    0.0 => String::new(),
                    mass_kg => format!(" and {mass_kg:.6} kg attached"),
                },
                body.structure(),
                body.stations_m.len()
            );
        }
        text.push_str(&beam_sections::text(&self.sections));
        text.push_str("\njoints\n");
        self.joints.iter().for_each(|joint| text.push_str(&joint.text()));
        if list_unknowns {
            text.push_str(JointSize::TITLE);
            self.joints.iter().for_each(|joint| text.push_str(&joint.size.text(&joint.name, &joint.kind)));
        }
        if !self.loops.is_empty() {
            text.push_str("\nclosed loops\n");
            self.loops.iter().for_each(|closure| text.push_str(&closure.text()));
        }
        if !self.skates_and_wheels.is_empty() {
            text.push_str("\nskates and wheels\n");
            self.skates_and_wheels.iter().for_each(|own| text.push_str(&own.text()));
        }
        if let Some(air) = &self.air {
            text.push_str(&air.text());
        }
        if !self.notes.is_empty() {
            let _ = writeln!(text, "\nnotes\n  {}", self.notes.join("\n  "));
        }
        let gauges = if self.gauges.is_empty() { "none".to_owned() } else { self.gauges.join(", ") };
        let count = |causality: &str| self.variables.iter().filter(|v| v.causality == causality).count();
        let _ = writeln!(
            text,
            "\ngauges: {gauges}\n{} inputs, {} outputs, {} parameters",
            count("input"),
            count("output"),
            count("parameter")
        );
        if list_variables {
            for variable in &self.variables {
                let start = variable.start.as_ref().map(|start| format!(" = {}", start.text())).unwrap_or_default();
                let unit = if variable.unit.is_empty() { String::new() } else { format!(" [{}]", variable.unit) };
                let _ =
                    writeln!(text, "  {} {}{start}{unit}: {}", variable.causality, variable.name, variable.description);
            }
        } else {
            text.push_str("(--list-variables lists them)\n");
        }
        text
    }
}

impl BodySummary {
    /// Describes the structure of the body.
    fn structure(&self) -> String {
        match self.element_kind {
            "rigid" => "rigid".to_owned(),
            "modal" => format!("{} shapes", self.degrees_of_freedom),
            kind => format!("{} {kind} elements", self.elements),
        }
    }

    fn new(body: &Body) -> Self {
        let element_kind = match body.element {
            _ if body.is_rigid() => "rigid",
            _ if body.is_modal() => "modal",
            ElementKind::Constant => "constant",
            ElementKind::Linear => "linear",
        };
        Self {
            name: body.name.clone(),
            length_m: body.length_m,
            mass_kg: body.section.mass_kg(body.length_m),
            attached_mass_kg: body.masses.iter().fold(0.0, |sum, mass| sum + mass.mass_kg),
            elements: if body.is_beam() { body.elements } else { 0 },
            element_kind,
            degrees_of_freedom: body.elastic_freedoms(),
            stations_m: body.station_positions_m.clone(),
        }
    }
}

impl JointSummary {
    fn new(body: &Body, machine: &Machine, (variables, multipliers): (usize, usize)) -> Self {
        let parent = match body.joint.parent {
            Parent::Root { .. } => "root".to_owned(),
            Parent::Body { index, .. } if body.joint.kind.rides() => machine.bodies[index].name.clone(),
            Parent::Body { index, position_m } => format!("{} at {position_m} m", machine.bodies[index].name),
        };
        let figures = match (body.joint.kind.one_freedom(), body.joint.kind.spatial()) {
            (Some((travel, joint)), _) => Figures::of_one_freedom(travel, joint),
            (_, Some(joint)) => Figures::of_spatial(joint),
            (None, None) => Figures::none(),
        };
        let kind = body.joint.kind.described();
        let size = JointSize::new(&body.joint.kind, variables, multipliers);
        Self { name: body.joint.name.clone(), body: body.name.clone(), parent, kind, figures, size }
    }

    fn text(&self) -> String {
        let mut text = format!("  {}: {} on {}, {}", self.name, self.body, self.parent, self.kind);
        for (_, name, value, unit) in &self.figures.numbers {
            if let Some(value) = value {
                let name = if self.figures.latch_kind == Some("rigid") && *name == "latch at" {
                    "rigid latch at".to_owned()
                } else {
                    self.figures.travel.words(name)
                };
                let _ = write!(text, ", {name} {} {}", (value * 1e9).round() / 1e9, self.figures.unit(unit));
            }
        }
        text + "\n"
    }
}

/// JSON key, name, value and unit of a joint parameter; the unit is for a revolute joint.
type Number = (&'static str, &'static str, Option<f64>, &'static str);

/// Parameters of a joint; the JSON also has the type of its latch.
struct Figures {
    travel: Travel,
    numbers: [Number; 10],
    latch_kind: Option<&'static str>,
}

impl Figures {
    fn none() -> Self {
        Self {
            travel: Travel::Rotation,
            numbers: [
                ("start_angle_deg", "start", None, "deg"),
                ("stiffness_n_m_rad", "k", None, "N.m/rad"),
                ("damping_n_m_s_rad", "c", None, "N.m.s/rad"),
                ("constant_torque_n_m", "T", None, "N.m"),
                ("torque_limit_n_m", "motor torque limit", None, "N.m"),
                ("spring_stiffness_n_m_rad", "spring", None, "N.m/rad"),
                ("spring_damping_n_m_s_rad", "spring damping", None, "N.m.s/rad"),
                ("rest_angle_deg", "spring slack at", None, "deg"),
                ("latch_angle_deg", "latch at", None, "deg"),
                ("latch_stiffness_n_m_rad", "latch stiffness", None, "N.m/rad"),
            ],
            latch_kind: None,
        }
    }

    fn of_spatial(joint: &Spatial) -> Self {
        let mut figures = Self::none();
        if joint.freedom != SpatialFreedom::Free {
            figures.numbers[1].2 = Some(joint.stiffness_n_m_rad);
            figures.numbers[2].2 = Some(joint.damping_n_m_s_rad);
        }
        figures
    }

    fn of_one_freedom(travel: Travel, joint: &OneFreedom) -> Self {
        let (drive, spring, latch) = (&joint.motor, joint.spring.as_ref(), joint.latch.as_ref());
        let values = [
            Some(travel.shown(joint.start_angle_rad)),
            Some(drive.stiffness_n_m_rad),
            Some(drive.damping_n_m_s_rad),
            Some(drive.constant_torque_n_m),
            Some(drive.torque_limit_n_m).filter(|limit| *limit < UNLIMITED),
            spring.map(|spring| spring.stiffness_n_m_rad),
            spring.map(|spring| spring.damping_n_m_s_rad),
            spring.map(|spring| travel.shown(spring.rest_angle_rad)),
            latch.map(|latch| travel.shown(latch.angle_rad)),
            latch.filter(|latch| latch.kind == LatchKind::Elastic).map(|latch| latch.stiffness_n_m_rad),
        ];
        let mut figures = Self { travel, ..Self::none() };
        figures.numbers.iter_mut().zip(values).for_each(|(number, value)| number.2 = value);
        figures.latch_kind = latch.map(|latch| match latch.kind {
            LatchKind::Elastic => "elastic",
            LatchKind::Rigid => "rigid",
        });
        figures
    }

    fn unit(&self, of_rotation: &str) -> String {
        match of_rotation {
            "deg" => self.travel.shown_unit().to_owned(),
            unit => self.travel.words(unit),
        }
    }
}

impl Serialize for Figures {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (key, _, value, _) in &self.numbers {
            if *key == "latch_angle_deg" {
                map.serialize_entry("latch_kind", &self.latch_kind)?;
            }
            map.serialize_entry(&self.travel.words(key), value)?;
        }
        map.end()
    }
}

impl VariableSummary {
    fn new(variable: &foldwing_fmi::interface::Variable) -> Self {
        let causality = match variable.causality {
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Parameter => "parameter",
            Causality::Local => "local",
            Causality::Independent => "independent",
        };
        let r#type = match variable.value {
            Value::Real(_) => "Real",
            Value::Integer(_) => "Integer",
            Value::Boolean(_) => "Boolean",
        };
        let has_start = matches!(variable.causality, Causality::Input | Causality::Parameter);
        Self {
            name: variable.name.clone(),
            causality,
            r#type,
            unit: variable.unit(),
            start: has_start.then(|| Start::from(variable.value)),
            description: variable.description.clone(),
        }
    }
}

#[cfg(test)]
#[path = "check_tests.rs"]
mod tests;
