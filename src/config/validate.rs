//! Third pass: what several keys say together, and the [`Machine`] made of them.

use crate::config::document::{Document, key_text};
use crate::config::error::{Fault, Problem, nearest};
use crate::config::file::{BodyFile, ModelFile};
use crate::config::machine::{AttachedMass, Body, Experiment, Joint, Machine, Solver};
use crate::config::schema::{quoted, shortest};
use crate::config::{attachments, joints, sections, tree};
use crate::load::Wrench;
use indexmap::IndexMap;
use nalgebra::Vector3;
use sections::NamedSection;
use std::f64::consts::PI;

/// Load stations of a body that says nothing about them.
const DEFAULT_STATIONS: usize = 4;

/// Collects problems and knows where keys stand.
pub(super) struct Checker<'d, 'a> {
    document: &'d Document<'a>,
    problems: Vec<Problem>,
}

impl Checker<'_, '_> {
    /// Refuses the value at `path`, or says that it is missing.
    pub fn refuse(&mut self, path: &[&str], allowed: impl Into<String>) {
        self.problems.push(self.document.refusal(path, allowed.into()));
    }

    /// Refuses what `value` describes, at `path`.
    pub fn refuse_as(&mut self, path: &[&str], value: impl Into<String>, allowed: impl Into<String>) {
        let fault = Fault::NotAllowed { value: value.into(), allowed: allowed.into() };
        self.problems.push(Problem { line: self.document.line_of(path), key: key_text(path), fault });
    }

    /// True where the file states the key.
    pub fn states(&self, path: &[&str]) -> bool {
        self.document.find(path).is_some()
    }

    /// Refuses a name that refers to nothing; `known` are the names it may be.
    pub fn unknown_name<'k>(&mut self, path: &[&str], name: &str, what: &str, known: impl Iterator<Item = &'k str>) {
        let known: Vec<&str> = known.collect();
        let hint =
            nearest(name, known.iter().copied()).map_or(String::new(), |near| format!(" (did you mean {near:?}?)"));
        self.refuse(path, format!("{what}: {}{hint}", quoted(&known)));
    }

    /// Refuses a distance beyond a body's length.
    pub fn on_body(&mut self, path: &[&str], position_m: f64, body: &BodyFile) {
        if !(0.0..=body.length_m).contains(&position_m) {
            self.refuse(path, format!("a length from 0 to {} m, the length of the body", shortest(body.length_m)));
        }
    }
}

/// Validates a file that fits the schema.
///
/// # Errors
/// All problems, in the order of the file.
pub(super) fn machine(file: &ModelFile, document: &Document) -> Result<Machine, Vec<Problem>> {
    let mut checker = Checker { document, problems: Vec::new() };
    let machine = build(file, &mut checker);
    let mut problems = checker.problems;
    problems.sort_by_key(|problem| problem.line);
    match machine {
        Some(machine) if problems.is_empty() => Ok(machine),
        _ => Err(problems),
    }
}

fn build(file: &ModelFile, checker: &mut Checker) -> Option<Machine> {
    let sections: IndexMap<&str, Option<NamedSection>> =
        file.section.iter().map(|(name, section)| (name.as_str(), sections::build(name, section, checker))).collect();
    let tree = tree::build(file, checker);
    let joints: Vec<Option<Joint>> =
        file.joint.iter().map(|(name, joint)| joints::build(name, joint, file, tree.as_ref(), checker)).collect();
    let mut masses = attachments::masses(file, checker);
    let mut loads = attachments::loads(file, checker);
    let mut bodies: Vec<Option<Body>> = Vec::with_capacity(file.body.len());
    for (index, (name, body)) in file.body.iter().enumerate() {
        let joint = tree.as_ref().and_then(|tree| joints[tree.joint_of[index]].clone());
        let mut body = build_body(name, body, &sections, std::mem::take(&mut masses[index]), joint, checker);
        if let Some(body) = &mut body {
            attachments::place_loads(std::mem::take(&mut loads[index]), body, checker);
        }
        bodies.push(body);
    }
    let gauges = attachments::gauges(file, &sections, tree.as_ref(), checker);
    let (solver, experiment) = (build_solver(file, checker), build_experiment(file, checker));
    let order = tree?.order;
    Some(Machine {
        name: file.name.clone(),
        description: file.description.clone(),
        bodies: order.iter().map(|index| bodies[*index].take()).collect::<Option<_>>()?,
        closures: Vec::new(),
        gauges: gauges?,
        gravity_m_s2: Vector3::from(file.gravity_m_s2),
        solver,
        experiment,
    })
}

fn build_body(
    name: &str,
    body: &BodyFile,
    sections: &IndexMap<&str, Option<NamedSection>>,
    masses: Vec<AttachedMass>,
    joint: Option<Joint>,
    checker: &mut Checker,
) -> Option<Body> {
    let path = ["body", name];
    if name == "root" {
        checker.refuse_as(&path, "the name \"root\"", "another name: \"root\" is what the wing is fixed to");
    }
    let section = sections.get(body.section.as_str());
    if section.is_none() {
        checker.unknown_name(&["body", name, "section"], &body.section, "a section", sections.keys().copied());
    }
    check_curvature(name, body, checker);
    let station_positions_m = stations(name, body, checker);
    let [twist, curvature_y, curvature_z] = body.natural_curvature_1_m;
    Some(Body {
        name: name.to_owned(),
        length_m: body.length_m,
        section: section?.as_ref()?.section.clone(),
        element: body.element.into(),
        elements: body.elements,
        natural_strain: [0.0, twist, curvature_y, curvature_z],
        mass_damping_1_s: body.mass_damping_1_s,
        stiffness_damping_s: body.stiffness_damping_s,
        station_loads: vec![Wrench::default(); station_positions_m.len()],
        station_positions_m,
        load_frame: body.load_frame.into(),
        masses,
        joint: joint?,
    })
}

/// An element's rotation must stay below π, where its rotation vector is unique.
fn check_curvature(name: &str, body: &BodyFile, checker: &mut Checker) {
    let largest = PI * body.elements as f64 / body.length_m;
    if Vector3::from(body.natural_curvature_1_m).norm() >= largest {
        let allowed = format!("curvatures of a magnitude < {largest:.4} 1/m: half a turn per element");
        checker.refuse(&["body", name, "natural_curvature_1_m"], allowed);
    }
}

/// Distances of the load stations from the inner end in m.
fn stations(name: &str, body: &BodyFile, checker: &mut Checker) -> Vec<f64> {
    let path = ["body", name, "load_station_positions_m"];
    match (&body.load_station_positions_m, body.load_stations) {
        (Some(positions), count) => {
            if count.is_some() {
                checker.refuse(&path, "either load_stations or load_station_positions_m, not both");
            }
            let ascending = positions.windows(2).all(|pair| pair[0] < pair[1]);
            let on_body = positions.iter().all(|position| (0.0..=body.length_m).contains(position));
            if !(ascending && on_body) {
                let length = shortest(body.length_m);
                checker.refuse(&path, format!("ascending lengths from 0 to {length} m, the length of the body"));
            }
            positions.clone()
        }
        (None, count) => {
            let count = count.unwrap_or(DEFAULT_STATIONS);
            (0..count).map(|i| body.length_m * (i as f64 + 0.5) / count as f64).collect()
        }
    }
}

fn build_solver(file: &ModelFile, checker: &mut Checker) -> Solver {
    let solver = &file.solver;
    if solver.min_step_s >= solver.max_step_s {
        let key = if checker.states(&["solver", "min_step_s"]) { "min_step_s" } else { "max_step_s" };
        let (sign, other, bound) = match key {
            "min_step_s" => ("<", "max_step_s", solver.max_step_s),
            _ => (">", "min_step_s", solver.min_step_s),
        };
        checker.refuse(&["solver", key], format!("a finite time {sign} {other} = {} s", shortest(bound)));
    }
    Solver {
        method: solver.method.into(),
        tolerance: solver.tolerance,
        max_step_s: solver.max_step_s,
        min_step_s: solver.min_step_s,
        fixed_step_s: solver.fixed_step_s,
        rho_infinity: solver.rho_infinity,
    }
}

fn build_experiment(file: &ModelFile, checker: &mut Checker) -> Experiment {
    let experiment = &file.experiment;
    let duration_s = experiment.stop_time_s - experiment.start_time_s;
    if duration_s <= 0.0 {
        let key = if checker.states(&["experiment", "stop_time_s"]) { "stop_time_s" } else { "start_time_s" };
        let (sign, other, bound) = match key {
            "stop_time_s" => (">", "start_time_s", experiment.start_time_s),
            _ => ("<", "stop_time_s", experiment.stop_time_s),
        };
        checker.refuse(&["experiment", key], format!("a finite time {sign} {other} = {} s", shortest(bound)));
    } else if experiment.step_s > duration_s && checker.states(&["experiment", "step_s"]) {
        let allowed = format!("a finite time > 0 s and <= {} s, the length of the experiment", shortest(duration_s));
        checker.refuse(&["experiment", "step_s"], allowed);
    }
    Experiment {
        start_time_s: experiment.start_time_s,
        stop_time_s: experiment.stop_time_s,
        step_s: experiment.step_s.min(if duration_s > 0.0 { duration_s } else { experiment.step_s }),
        start: experiment.start.into(),
    }
}
