//! Checks of a whole machine: names, tree, numbers and their combinations.

pub(crate) mod air;
mod air_parts;
mod attached;
mod basics;
pub(crate) mod body;
mod damped_modes;
mod dc_motor;
mod failure;
pub mod joint;
mod modal;
mod no_slip;
pub(crate) mod profile;
pub mod section;
pub(crate) mod slender;
mod sliding;

pub use basics::{IDENTIFIER_ALLOWED, is_identifier};
pub(super) use basics::{MAXIMUM_STATIONS_OF_BODY, names, unit_vector};

use crate::machine::fault::{Checker, Fault, Range, array_text};
use crate::machine::units::shortest;
use crate::machine::{Air, Body, Coupling, Experiment, Machine, Method, Parent, Solver};

/// Maximum number of load stations of a machine: its model description then has about ten megabytes.
const MAXIMUM_STATIONS: usize = 2_000;
/// Maximum number of elements of a machine: a step then takes a tenth of a second.
const MAXIMUM_ELEMENTS: usize = 20_000;

impl Machine {
    /// Returns all errors of the machine; empty if it is valid. Plants and interfaces require valid machines.
    ///
    /// A machine from [`Machine::builder`] or from a model file has already been validated. A machine whose fields were set directly should
    /// be validated before use: an invalid index would cause a panic, an invalid number a run that does not converge.
    ///
    /// ```
    /// use foldwing_engine::beam::section::{Material, Solid};
    /// use foldwing_engine::machine::{Body, Joint, Machine};
    ///
    /// let plate = Solid::rectangle(0.05, 0.002, Material::isotropic(70e9, 0.33, 2700.0));
    /// let mut machine =
    ///     Machine::builder("wing").body(Body::beam("wing", 1.0, plate).elements(4), Joint::clamped("mount")).build().unwrap();
    /// machine.bodies[0].mass_damping_1_s = -1.0;
    /// let faults: Vec<String> = machine.validate().iter().map(|fault| fault.to_string()).collect();
    /// assert_eq!(faults, ["body \"wing\", mass_damping_1_s: -1 is not allowed; allowed: a finite damping >= 0 (1/s)"]);
    /// ```
    pub fn validate(&self) -> Vec<Fault> {
        let mut checker = Checker::default();
        structure(self, &mut checker);
        surroundings(self, &mut checker);
        checker.faults
    }
}

/// Checks bodies, joints and their attachments.
pub(super) fn structure(machine: &Machine, checker: &mut Checker) {
    if !is_identifier(&machine.name) {
        checker.refuse(&["name"], format!("{:?}", machine.name), IDENTIFIER_ALLOWED);
    }
    checker.array(&["gravity_m_s2"], machine.gravity_m_s2.as_slice());
    if machine.bodies.is_empty() {
        checker.refuse_state(&["body"], "a model without bodies", "at least one body");
    }
    names("body", machine.bodies.iter().map(|body| body.name.as_str()), checker);
    names("joint", machine.bodies.iter().map(|body| body.joint.name.as_str()), checker);
    names("mass", machine.bodies.iter().flat_map(|body| &body.masses).map(|mass| mass.name.as_str()), checker);
    names("loop", machine.closures.iter().map(|closure| closure.name.as_str()), checker);
    names("gauge", machine.gauges.iter().map(|gauge| gauge.name.as_str()), checker);
    names("internal_load", machine.internal_loads.iter().map(|place| place.name.as_str()), checker);
    let tree_holds = tree(&machine.bodies, checker);
    for body in &machine.bodies {
        joint::check(&body.joint, checker);
        body::check(body, checker);
    }
    if tree_holds {
        inertia(&machine.bodies, checker);
    }
    sizes(&machine.bodies, checker);
    for gauge in &machine.gauges {
        attached::gauge(gauge, &machine.bodies, checker);
    }
    for internal_load in &machine.internal_loads {
        attached::internal_load(internal_load, &machine.bodies, checker);
    }
    sliding::check(machine, checker);
    modal::placed(machine, checker);
    failure::check(machine, checker);
    let mut closures_hold = true;
    for closure in &machine.closures {
        closures_hold &= attached::closure(closure, &machine.bodies, checker);
    }
    let no_slips_hold = no_slip::check(machine, checker);
    if tree_holds && no_slips_hold && stand(checker) {
        no_slip::starts(machine, checker);
    }
    if stand(checker) {
        damped_modes::check(machine, checker);
        if tree_holds && closures_hold {
            attached::gaps(machine, checker);
        }
    }
}

/// Whether no body or joint has an error, so that the unstrained machine has a shape.
pub(super) fn stand(checker: &Checker) -> bool {
    let fell = |fault: &Fault| fault.place.0.first().is_some_and(|kind| kind == "body" || kind == "joint");
    !checker.faults.iter().any(fell)
}

/// Checks aerodynamics, solver and simulation settings.
pub(super) fn surroundings(machine: &Machine, checker: &mut Checker) {
    if let Some(air) = &machine.air {
        air::check(air, &machine.bodies, checker);
        sliding::beside_rotors(machine, checker);
    }
    solver(&machine.solver, machine.air.as_ref(), checker);
    experiment(&machine.experiment, checker);
}

/// Checks that parents come before their children, with joints at positions on them.
fn tree(bodies: &[Body], checker: &mut Checker) -> bool {
    let mut holds = true;
    for (own, body) in bodies.iter().enumerate() {
        match body.joint.parent {
            Parent::Root { position_m } => {
                checker.array(&["joint", &body.joint.name, "root_position_m"], position_m.as_slice());
                if body.joint.offset_m != nalgebra::Vector3::zeros() {
                    let found = array_text(body.joint.offset_m.as_slice());
                    let allowed = "no offset from the root; add it to root_position_m";
                    checker.refuse(&["joint", &body.joint.name, "offset_m"], found, allowed);
                }
            }
            Parent::Body { index, position_m } if index < own => {
                checker.array(&["joint", &body.joint.name, "offset_m"], body.joint.offset_m.as_slice());
                let place = ["joint", &body.joint.name, "parent_position_m"];
                checker.on_body(&place, position_m, bodies[index].length_m);
            }
            Parent::Body { index, .. } => {
                let found = match bodies.get(index) {
                    Some(parent) => {
                        format!("{:?}, body {index} of the list, as the parent of body {own},", parent.name)
                    }
                    None => format!("body {index} of {}", bodies.len()),
                };
                let allowed = "the root or a body earlier in the list: parents must precede their children";
                checker.refuse_state(&["joint", &body.joint.name, "parent"], found, allowed);
                holds = false;
            }
        }
    }
    holds
}

/// Checks that a movable rigid body has mass, or carries a body that has mass.
fn inertia(bodies: &[Body], checker: &mut Checker) {
    let mut heavy: Vec<bool> = bodies
        .iter()
        .map(|body| body.length_m != 0.0 || !body.is_rigid() || body.masses.iter().any(|mass| mass.mass_kg > 0.0))
        .collect();
    for own in (0..bodies.len()).rev() {
        if let (Parent::Body { index, .. }, true) = (&bodies[own].joint.parent, heavy[own]) {
            heavy[*index] = true;
        }
    }
    for (body, _) in bodies.iter().zip(&heavy).filter(|(body, heavy)| !**heavy && !is_clamped(body)) {
        let allowed = "a mass on it or on a body that it carries, because its joint is movable";
        checker.refuse_state(&["body", &body.name], "a rigid body without mass", allowed);
    }
}

fn is_clamped(body: &Body) -> bool {
    body.joint.kind.is_clamped()
}

/// Checks that the model is within the limits on computing time and memory.
fn sizes(bodies: &[Body], checker: &mut Checker) {
    let sum = |count: fn(&Body) -> usize| bodies.iter().map(count).fold(0, usize::saturating_add);
    let stations = sum(|body| body.station_positions_m.len());
    if stations > MAXIMUM_STATIONS {
        let allowed = format!("at most {MAXIMUM_STATIONS} on all bodies together: each is 25 variables of the FMU");
        checker.refuse_state(&["body"], format!("{stations} load stations"), allowed);
    }
    let elements = sum(|body| body.elements);
    if elements > MAXIMUM_ELEMENTS {
        let allowed = format!("at most {MAXIMUM_ELEMENTS} on all bodies together");
        checker.refuse_state(&["body"], format!("{elements} elements"), allowed);
    }
}

fn solver(solver: &Solver, air: Option<&Air>, checker: &mut Checker) {
    checker.number(&["solver", "tolerance"], solver.tolerance, Range::Within(1e-12, 1e-1));
    checker.number(&["solver", "rho_infinity"], solver.rho_infinity, Range::Within(0.0, 1.0));
    let positive = checker.number(&["solver", "max_step_s"], solver.max_step_s, Range::Above(0.0))
        & checker.number(&["solver", "min_step_s"], solver.min_step_s, Range::Above(0.0));
    if positive && solver.min_step_s >= solver.max_step_s {
        // the value that differs from the default is the erroneous one
        let least = solver.min_step_s != Solver::default().min_step_s;
        let (key, value, sign, other, bound) = match least {
            true => ("min_step_s", solver.min_step_s, '<', "max_step_s", solver.max_step_s),
            false => ("max_step_s", solver.max_step_s, '>', "min_step_s", solver.min_step_s),
        };
        let allowed = format!("a finite time {sign} {other} = {} s", shortest(bound));
        checker.refuse(&["solver", key], shortest(value), allowed);
    }
    match solver.fixed_step_s {
        Some(step_s) => {
            checker.number(&["solver", "fixed_step_s"], step_s, Range::Above(0.0));
        }
        None if solver.method == Method::Rk4 => {
            let allowed = "a finite time > 0 s: method = \"rk4\" has no error estimate for choosing steps";
            checker.refuse(&["solver", "fixed_step_s"], "none", allowed);
        }
        None if solver.most_iterations.is_some() => {
            let allowed = "a finite time > 0 s: steps in real-time mode have a fixed length";
            checker.refuse(&["solver", "fixed_step_s"], "none", allowed);
        }
        None => {}
    }
    let Some(most_iterations) = solver.most_iterations else { return };
    checker.count(&["solver", "most_iterations"], most_iterations, 1, 10);
    // with aerodynamic loads computed once per step, the computing time per step is constant
    if air.is_some_and(|air| air.coupling != Coupling::Staggered) {
        let allowed = "\"accurate\", or coupling = \"staggered\" in [aerodynamics]: otherwise the number of iterations \
                       between aerodynamics and structure has no limit";
        checker.refuse(&["solver", "mode"], "\"real_time\"", allowed);
    }
    if solver.method != Method::Sdirk2 {
        let allowed = "\"sdirk2\", or no method, with mode = \"real_time\": with fixed steps the other methods do not \
                       damp the vibration of stiff modes after a jump of the accelerations";
        checker.refuse(&["solver", "method"], format!("{:?}", solver.method), allowed);
    }
}

fn experiment(experiment: &Experiment, checker: &mut Checker) {
    let Experiment { start_time_s, stop_time_s, step_s, .. } = *experiment;
    if !checker.number(&["simulation", "start_time_s"], start_time_s, Range::Finite)
        | !checker.number(&["simulation", "stop_time_s"], stop_time_s, Range::Finite)
        | !checker.number(&["simulation", "step_s"], step_s, Range::Above(0.0))
    {
        return;
    }
    let duration_s = stop_time_s - start_time_s;
    if duration_s <= 0.0 {
        // the value that differs from the default is the erroneous one
        let stop = stop_time_s != Experiment::default().stop_time_s;
        let (key, value, sign, other, bound) = match stop {
            true => ("stop_time_s", stop_time_s, '>', "start_time_s", start_time_s),
            false => ("start_time_s", start_time_s, '<', "stop_time_s", stop_time_s),
        };
        let allowed = format!("a finite time {sign} {other} = {} s", shortest(bound));
        checker.refuse(&["simulation", key], shortest(value), allowed);
    } else if step_s > duration_s {
        let allowed = format!("a finite time > 0 s and <= {} s, the duration of the simulation", shortest(duration_s));
        checker.refuse(&["simulation", "step_s"], shortest(step_s), allowed);
    }
}
