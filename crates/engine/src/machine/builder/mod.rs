//! A machine in code: the contents of a model file, with the same defaults and the same errors.

mod air;
mod air_build;
mod air_parts;
mod body;
mod failure;
mod flap;
mod gust;
mod joint;
mod latch;
mod no_slip;
pub(super) mod place;
mod rotor;
mod slender;
mod surfaces;
mod tree;

pub use air::AirBuilder;
pub use body::{BodyBuilder, ClosureBuilder, GaugeBuilder, InternalLoadBuilder};
pub use failure::FailureBuilder;
pub use flap::FlapBuilder;
pub use gust::GustBuilder;
pub use joint::freedom::{CYLINDRICAL, Freedom, carriage};
pub use joint::{Attitude, JointBuilder};
pub use latch::LatchBuilder;
pub use no_slip::NoSlipBuilder;
pub use rotor::RotorSettings;
pub use slender::SlenderBodySettings;
pub use surfaces::SurfaceBuilder;

use crate::load::Wrench;
use crate::machine::fault::{Checker, Refused};
use crate::machine::validate::{self, names};
use crate::machine::{AttachedMass, Body, Experiment, Machine, Solver, StartState};
use nalgebra::Vector3;

/// A machine under construction, see [`Machine::builder`]. Parts refer to one another by name, in any order.
#[derive(Debug, Clone)]
pub struct MachineBuilder {
    name: String,
    description: String,
    gravity_m_s2: Vector3<f64>,
    bodies: Vec<(BodyBuilder, JointBuilder)>,
    masses: Vec<(String, AttachedMass)>,
    loads: Vec<Load>,
    gauges: Vec<GaugeBuilder>,
    internal_loads: Vec<InternalLoadBuilder>,
    closures: Vec<ClosureBuilder>,
    no_slips: Vec<NoSlipBuilder>,
    failures: Vec<FailureBuilder>,
    air: Option<AirBuilder>,
    surfaces: Vec<SurfaceBuilder>,
    gusts: Vec<GustBuilder>,
    flaps: Vec<FlapBuilder>,
    solver: Solver,
    experiment: Experiment,
    step_s: Option<f64>,
}

/// A load at a station.
#[derive(Debug, Clone)]
struct Load {
    name: String,
    body: String,
    station: usize,
    wrench: Wrench,
}

impl Machine {
    /// Starts a machine with a name, which must be an identifier, and the defaults of the model file.
    pub fn builder(name: impl Into<String>) -> MachineBuilder {
        MachineBuilder {
            name: name.into(),
            description: String::new(),
            gravity_m_s2: Vector3::zeros(),
            bodies: Vec::new(),
            masses: Vec::new(),
            loads: Vec::new(),
            gauges: Vec::new(),
            internal_loads: Vec::new(),
            closures: Vec::new(),
            no_slips: Vec::new(),
            failures: Vec::new(),
            air: None,
            surfaces: Vec::new(),
            gusts: Vec::new(),
            flaps: Vec::new(),
            solver: Solver::default(),
            experiment: Experiment::default(),
            step_s: None,
        }
    }
}

impl MachineBuilder {
    /// One-line description.
    pub fn description(self, description: impl Into<String>) -> Self {
        Self { description: description.into(), ..self }
    }

    /// Gravity in the root frame in m/s². Default 0.
    pub fn gravity_m_s2(self, gravity_m_s2: impl Into<Vector3<f64>>) -> Self {
        Self { gravity_m_s2: gravity_m_s2.into(), ..self }
    }

    /// Adds a body with the joint that attaches its inner end.
    pub fn body(mut self, body: BodyBuilder, joint: JointBuilder) -> Self {
        self.bodies.push((body, joint));
        self
    }

    /// Attaches a mass to the named body.
    pub fn mass(mut self, body: impl Into<String>, mass: AttachedMass) -> Self {
        self.masses.push((body.into(), mass));
        self
    }

    /// Adds a force and moment, in the body's load frame, at a load station counted from 1 at the inner end.
    pub fn load(mut self, name: impl Into<String>, body: impl Into<String>, station: usize, wrench: Wrench) -> Self {
        self.loads.push(Load { name: name.into(), body: body.into(), station, wrench });
        self
    }

    /// Adds a strain gauge.
    pub fn gauge(mut self, gauge: GaugeBuilder) -> Self {
        self.gauges.push(gauge);
        self
    }

    /// Adds the internal loads at a section to the outputs.
    pub fn internal_load(mut self, internal_load: InternalLoadBuilder) -> Self {
        self.internal_loads.push(internal_load);
        self
    }

    /// Closes a loop.
    pub fn closure(mut self, closure: ClosureBuilder) -> Self {
        self.closures.push(closure);
        self
    }

    /// Adds a skate or a wheel.
    pub fn no_slip(mut self, no_slip: NoSlipBuilder) -> Self {
        self.no_slips.push(no_slip);
        self
    }

    /// Adds a failure.
    pub fn failure(mut self, failure: FailureBuilder) -> Self {
        self.failures.push(failure);
        self
    }

    /// Adds the aerodynamics of the machine.
    pub fn air(self, air: AirBuilder) -> Self {
        Self { air: Some(air), ..self }
    }

    /// Adds a lifting surface.
    pub fn surface(mut self, surface: SurfaceBuilder) -> Self {
        self.surfaces.push(surface);
        self
    }

    /// Adds a gust.
    pub fn gust(mut self, gust: GustBuilder) -> Self {
        self.gusts.push(gust);
        self
    }

    /// Adds a control surface to the surface of a body.
    pub fn flap(mut self, flap: FlapBuilder) -> Self {
        self.flaps.push(flap);
        self
    }

    /// Time integration. Default [`Solver::default`].
    pub fn solver(self, solver: Solver) -> Self {
        Self { solver, ..self }
    }

    /// Start of the simulation in s. Default 0.
    pub fn start_time_s(mut self, start_time_s: f64) -> Self {
        self.experiment.start_time_s = start_time_s;
        self
    }

    /// End of the simulation in s. Default 0.4.
    pub fn stop_time_s(mut self, stop_time_s: f64) -> Self {
        self.experiment.stop_time_s = stop_time_s;
        self
    }

    /// Communication step of the simulation in s. Default 5e-4, or the whole duration if that is shorter.
    pub fn step_s(self, step_s: f64) -> Self {
        Self { step_s: Some(step_s), ..self }
    }

    /// State at the start. Default [`StartState::Unstrained`].
    pub fn start(mut self, start: StartState) -> Self {
        self.experiment.start = start;
        self
    }

    /// Builds and validates the machine.
    ///
    /// # Errors
    /// All errors of the machine: names, references, the tree of bodies, numbers, and their combinations.
    pub fn build(&self) -> Result<Machine, Refused> {
        let mut checker = Checker::default();
        let machine = self.assemble(&mut checker);
        if checker.faults.is_empty() { Ok(machine) } else { Err(Refused { faults: checker.faults }) }
    }

    fn assemble(&self, checker: &mut Checker) -> Machine {
        let start_time_s = self.experiment.start_time_s;
        let described = joint::carriage::with_carriages(&self.bodies, checker);
        let tree = tree::resolve(&described, checker);
        let mut bodies: Vec<Body> = Vec::with_capacity(described.len());
        for index in &tree.order {
            let (body, joint) = &described[*index];
            let joint = joint.build(tree.parents[*index].clone(), start_time_s, checker);
            bodies.push(body.build(joint, checker));
        }
        self.attach(&mut bodies, checker);
        let closures = self.closures.iter().filter_map(|closure| closure.build(&bodies, checker)).collect();
        let no_slips = self.no_slips.iter().filter_map(|no_slip| no_slip.build(&bodies, checker)).collect();
        names("load", self.loads.iter().map(|load| load.name.as_str()), checker);
        let mut machine = Machine {
            name: self.name.clone(),
            description: self.description.clone(),
            bodies,
            closures,
            no_slips,
            gauges: Vec::new(),
            internal_loads: Vec::new(),
            air: None,
            failures: Vec::new(),
            gravity_m_s2: self.gravity_m_s2,
            solver: self.solver.clone(),
            experiment: self.experiment(),
        };
        for gauge in &self.gauges {
            let index = self.index_of(&["gauge", &gauge.name, "body"], &gauge.body, &machine.bodies, checker);
            machine.gauges.extend(index.and_then(|index| gauge.build(index, &machine.bodies[index].section, checker)));
        }
        for internal_load in &self.internal_loads {
            let place = ["internal_load", internal_load.name.as_str(), "body"];
            let index = self.index_of(&place, &internal_load.body, &machine.bodies, checker);
            machine.internal_loads.extend(index.map(|index| internal_load.build(index)));
        }
        let failures = &self.failures;
        machine.failures = failures
            .iter()
            .filter_map(|failure| failure.build(&machine.bodies, &machine.closures, failures, checker))
            .collect();
        validate::structure(&machine, checker);
        // surfaces and gusts are only placed on valid bodies
        let stand = tree.holds && validate::stand(checker);
        names("control_surface", self.flaps.iter().map(|flap| flap.name.as_str()), checker);
        let on_wing = (self.surfaces.as_slice(), self.flaps.as_slice());
        let air = self.air.as_ref();
        machine.air = air_build::build(air, on_wing, &self.gusts, &machine.bodies, stand, start_time_s, checker);
        validate::surroundings(&machine, checker);
        machine
    }

    /// Adds masses and loads to bodies.
    fn attach(&self, bodies: &mut [Body], checker: &mut Checker) {
        for (body, mass) in &self.masses {
            if let Some(index) = self.index_of(&["mass", &mass.name, "body"], body, bodies, checker) {
                bodies[index].masses.push(mass.clone());
            }
        }
        for Load { name, body, station, wrench } in &self.loads {
            if let Some(index) = self.index_of(&["load", name, "body"], body, bodies, checker) {
                body::add_load(name, *station, wrench, &mut bodies[index], checker);
            }
        }
    }

    /// Index of the named body; an error if it does not exist.
    fn index_of(&self, place: &[&str], name: &str, bodies: &[Body], checker: &mut Checker) -> Option<usize> {
        let found = bodies.iter().position(|body| body.name == name);
        if found.is_none() {
            // in the order in which they were added
            let known = self.bodies.iter().map(|(body, _)| body.name.as_str());
            checker.unknown_name(place, name, "a body", known);
        }
        found
    }

    fn experiment(&self) -> Experiment {
        let default_s = Experiment::default().step_s;
        let duration_s = self.experiment.stop_time_s - self.experiment.start_time_s;
        let step_s = match self.step_s {
            Some(step_s) => step_s,
            None if duration_s > 0.0 => default_s.min(duration_s),
            None => default_s,
        };
        Experiment { step_s, ..self.experiment.clone() }
    }
}
