//! Third pass: what several keys say together, and the [`Machine`] made of them.

use crate::config::body::{self, BodyFile};
use crate::config::document::{Document, key_text};
use crate::config::error::{Fault, Problem};
use crate::config::file::ModelFile;
use crate::config::meant::did_you_mean;
use crate::config::run::{MethodFile, ModeFile};
use crate::config::schema::{quoted, shortest};
use crate::config::{air, attachments, joints, loops, sections, tree};
use crate::machine::{Body, Experiment, Joint, Machine, Method, Solver};
use nalgebra::Vector3;
use sections::Sections;

/// Most load stations of a machine: its model description then has some ten megabytes.
const MOST_STATIONS: usize = 2_000;
/// Most elements of a machine: a step then takes a tenth of a second.
const MOST_ELEMENTS: usize = 20_000;

/// Fixed step of real-time mode where the file names none, in s.
const REAL_TIME_STEP_S: f64 = 1e-3;

/// Collects problems and knows where keys stand.
pub(super) struct Checker<'d, 'a> {
    document: &'d Document<'a>,
    problems: Vec<Problem>,
}

impl<'d, 'a> Checker<'d, 'a> {
    /// Refuses the value at `path`, or says that it is missing.
    pub fn refuse(&mut self, path: &[&str], allowed: impl Into<String>) {
        self.problems.push(self.document.refusal(path, allowed.into()));
    }

    /// Refuses what `value` describes, at `path`.
    pub fn refuse_as(&mut self, path: &[&str], value: impl Into<String>, allowed: impl Into<String>) {
        let fault = Fault::NotAllowed { value: value.into(), allowed: allowed.into() };
        self.problems.push(Problem { line: self.document.line_of(path), key: key_text(path), fault });
    }

    /// A checker of the same file whose problems are not kept, for what is checked elsewhere.
    pub fn silent(&self) -> Checker<'d, 'a> {
        Checker { document: self.document, problems: Vec::new() }
    }

    /// True where the file states the key.
    pub fn states(&self, path: &[&str]) -> bool {
        self.document.find(path).is_some()
    }

    /// Refuses a name that refers to nothing; `known` are the names it may be.
    pub fn unknown_name<'k>(&mut self, path: &[&str], name: &str, what: &str, known: impl Iterator<Item = &'k str>) {
        let known: Vec<&str> = known.collect();
        let hint = did_you_mean(name, known.iter().copied());
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
    let sections: Sections =
        file.section.iter().map(|(name, section)| (name.as_str(), sections::build(name, section, checker))).collect();
    let tree = tree::build(file, checker);
    let joints: Vec<Option<Joint>> =
        file.joint.iter().map(|(name, joint)| joints::build(name, joint, file, tree.as_ref(), checker)).collect();
    let mut masses = attachments::masses(file, checker);
    let mut loads = attachments::loads(file, checker);
    let mut bodies: Vec<Option<Body>> = Vec::with_capacity(file.body.len());
    for (index, (name, file)) in file.body.iter().enumerate() {
        let joint = tree.as_ref().and_then(|tree| joints[tree.joint_of[index]].clone());
        let mut body = body::build(name, file, &sections, std::mem::take(&mut masses[index]), joint, checker);
        if let Some(body) = &mut body {
            attachments::place_loads(std::mem::take(&mut loads[index]), body, checker);
        }
        bodies.push(body);
    }
    let stations: usize = bodies.iter().flatten().map(|body| body.station_positions_m.len()).sum();
    if stations > MOST_STATIONS {
        let allowed = format!("at most {MOST_STATIONS} on all bodies together: each is 19 variables of the FMU");
        checker.refuse_as(&["body"], format!("{stations} load stations"), allowed);
    }
    let elements: usize = bodies.iter().flatten().map(|body| body.elements).sum();
    if elements > MOST_ELEMENTS {
        let allowed = format!("at most {MOST_ELEMENTS} on all bodies together");
        checker.refuse_as(&["body"], format!("{elements} elements"), allowed);
    }
    let gauges = attachments::gauges(file, &sections, tree.as_ref(), checker);
    let closures = loops::build(file, tree.as_ref(), checker);
    let (solver, experiment) = (build_solver(file, checker), build_experiment(file, checker));
    let order = tree.as_ref()?.order.clone();
    let bodies: Option<Vec<Body>> = order.iter().map(|index| bodies[*index].take()).collect();
    let air = air::build(file, &sections, tree.as_ref(), bodies.as_deref().unwrap_or_default(), checker);
    let machine = Machine {
        name: file.name.clone(),
        description: file.description.clone(),
        bodies: bodies?,
        closures: closures?,
        gauges: gauges?,
        air: air.ok()?,
        gravity_m_s2: Vector3::from(file.gravity_m_s2),
        solver,
        experiment,
    };
    loops::check_gaps(&machine, checker);
    Some(machine)
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
    if solver.method == MethodFile::Rk4 && solver.fixed_step_s.is_none() {
        let allowed = "a finite time > 0 s: method = \"rk4\" has no error estimate to choose its steps by";
        checker.refuse(&["solver", "fixed_step_s"], allowed);
    }
    let real_time = solver.mode == ModeFile::RealTime;
    if real_time && file.aerodynamics.is_some() {
        let allowed = "\"accurate\" for a machine in air: its iteration with the structure is not bounded";
        checker.refuse(&["solver", "mode"], allowed);
    }
    if real_time && checker.states(&["solver", "method"]) && solver.method != MethodFile::Sdirk2 {
        let allowed = "\"sdirk2\", or no method, with mode = \"real_time\": at steps of given length the others carry a jump of the \
                       accelerations on in stiff modes";
        checker.refuse(&["solver", "method"], allowed);
    }
    if !real_time && checker.states(&["solver", "max_iterations"]) {
        checker.refuse(&["solver", "max_iterations"], "this key only with mode = \"real_time\"");
    }
    Solver {
        method: if real_time { Method::Sdirk2 } else { solver.method.into() },
        tolerance: solver.tolerance,
        max_step_s: solver.max_step_s,
        min_step_s: solver.min_step_s,
        fixed_step_s: solver.fixed_step_s.or(real_time.then_some(REAL_TIME_STEP_S)),
        rho_infinity: solver.rho_infinity,
        most_iterations: real_time.then_some(solver.max_iterations as usize),
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
