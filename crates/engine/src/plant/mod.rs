//! The whole machine: a model, its inputs and parameters, and a state that can be stepped, saved and restored.
//!
//! The integrator takes its own steps and runs ahead of the caller as long as the inputs stay as they are; values
//! in between come from the stages of its steps. A changed input cuts the step at the present time. So the
//! answer does not depend on the communication step, and small communication steps cost little
//! (`docs/decisions/0002-running-ahead.md`).

mod air;
mod brake;
mod course;
mod derivatives;
mod equations;
mod events;
mod face;
mod failed_steps;
mod hybrid;
mod joint_forces;
mod latency;
mod linear;
mod magnitude;
mod march;
mod outputs;
mod place;
mod rest;
mod shape;
mod spatial;
mod stability;
mod state;
mod state_space;
mod statics;
mod strains;
mod wake_rows;

pub use crate::signal::{
    BodyParameters, Count, FACTOR_RANGE, InputLayout, Inputs, JointInputs, JointParameters, ParameterLayout,
    Parameters, SolverParameters, SpatialParameters, Switch,
};
pub use crate::solve::arc_length::PathPoint;
pub use crate::solve::equilibrium::Effort as StaticEffort;
pub use crate::solve::linearize::{SecondOrder, StateSpace};
pub use air::{CLOSED_PANELS, SurfaceGap, SurfaceLattice};
pub use face::{JointStatus, PlantError, Statistics};
pub use hybrid::{AccountRates, Hybrid, Jump, NotHybrid};
pub use latency::Latency;
pub use linear::{Argument, Freedom};
pub use outputs::{
    EnergyOutputs, JointOutputs, LatchOutputs, LoopOutputs, OutputLayout, OutputSet, Outputs, PointOutputs,
    SpatialOutputs,
};
pub use shape::{ModeShape, NodeMotion, SectionShape, SectionState};
pub use stability::{Coarseness, Growth, Stability};
pub use state::Snapshot;
pub use state_space::InputSlope;
pub use statics::{Branch, Departure, Holding, LoadPath, Rest, Search};
pub use strains::SectionStrain;

use crate::beam::element::ElementKind;
use crate::machine::Machine;
use crate::machine::{Gauge, Method};
use crate::multibody::gauge::GaugePoint;
use crate::solve::stepper::{self, Stepper};
use air::AirCoupling;
use equations::Equations;
use state::State;
use std::sync::Arc;

/// The machine in time.
pub struct Plant {
    machine: Arc<Machine>,
    revolute_joints: Vec<usize>,
    spatial_joints: Vec<usize>,
    tip_bodies: Vec<usize>,
    gauges: Vec<GaugePoint>,
    state: State,
    /// The state at the start of the communication step, to go back to.
    begin: State,
    /// Newton iterations that the present communication step may cost, and those of them that are left.
    most_work: u64,
    work_left: u64,
    equations: Equations,
    /// Fixed parameters that `equations` was built with.
    built_with: Parameters,
    stepper: Stepper,
    air: Option<Box<AirCoupling>>,
    /// Smallest step that the error estimate has asked for since the present trial march began, in s.
    smallest_step_s: f64,
    /// What the iterations of the last step in real time left, in the kinematic norm.
    rest: f64,
    scratch: [Vec<f64>; 2],
    latency: Latency,
    outputs: Outputs,
    /// Outputs that a step is to find.
    watched: OutputSet,
    /// Outputs found at the present time.
    found: OutputSet,
    /// Inputs may have been set since the last step, so that they differ from those of the present.
    inputs_may_differ: bool,
    /// The search for a state of rest that is under way.
    quest: statics::Quest,
    /// Some gauge reads a strain that is recovered from forces.
    gauges_need_forces: bool,
    /// The model's own numbers are so moderate that outputs overflow only where states or inputs are not.
    model_is_moderate: bool,
}

impl Plant {
    /// A plant of a validated model, with the inputs and parameters that the model states; not yet initialised.
    pub fn new(machine: Arc<Machine>) -> Self {
        let revolute_joints: Vec<usize> = machine.one_freedoms().map(|(body, _)| body).collect();
        let spatial_joints: Vec<usize> = machine.spatials().map(|(body, _)| body).collect();
        let tip_bodies: Vec<usize> = machine.tip_bodies().collect();
        let state = State::of_model(&machine);
        let equations = Equations::new(&machine, &state.parameters);
        let coordinates = equations.model.coordinates;
        let method = match machine.solver.method {
            Method::GeneralizedAlpha => stepper::Method::GeneralizedAlpha { rho_infinity: machine.solver.rho_infinity },
            Method::TrBdf2 => stepper::Method::TrBdf2,
            Method::Esdirk3 => stepper::Method::Esdirk3,
            Method::Sdirk2 => stepper::Method::Sdirk2,
            Method::Esdirk4 => stepper::Method::Esdirk4,
            Method::Rk4 => stepper::Method::Rk4,
        };
        let air = AirCoupling::new(&machine, coordinates).map(Box::new);
        let outputs = Outputs::blank(&machine);
        let recovered = |gauge: &Gauge| machine.bodies[gauge.body].element == ElementKind::Linear;
        let gauges = outputs::gauge_points(&machine);
        Self {
            gauges_need_forces: machine.gauges.iter().any(recovered),
            model_is_moderate: magnitude::model_is_moderate(&equations.model, &gauges),
            watched: OutputSet::ALL,
            found: OutputSet::NONE,
            inputs_may_differ: false,
            gauges,
            revolute_joints,
            spatial_joints,
            tip_bodies,
            built_with: state.parameters.clone(),
            stepper: Stepper::new(method, coordinates),
            air,
            smallest_step_s: f64::INFINITY,
            rest: 0.0,
            scratch: [vec![0.0; coordinates], vec![0.0; coordinates]],
            quest: statics::Quest::default(),
            latency: Latency::default(),
            begin: state.clone(),
            most_work: 0,
            work_left: 0,
            state,
            equations,
            outputs,
            machine,
        }
    }

    /// The model.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Indices into [`Machine::bodies`] of the bodies whose joint is revolute or prismatic, in order.
    pub fn revolute_joints(&self) -> &[usize] {
        &self.revolute_joints
    }

    /// Indices into [`Machine::bodies`] of the bodies whose joint is universal, ball or free, in order.
    pub fn spatial_joints(&self) -> &[usize] {
        &self.spatial_joints
    }

    /// Indices into [`Machine::bodies`] of the bodies whose outer end is free, in order.
    pub fn tip_bodies(&self) -> &[usize] {
        &self.tip_bodies
    }

    /// Joint variables and Lagrange multipliers of a body's joint in our form: `N_J` and `N_L` of Otsuka et al., Table 2.
    pub fn joint_size(&self, body: usize) -> (usize, usize) {
        let kind = &self.equations.model.bodies[body].joint.kind;
        (kind.coordinates(), kind.constraints())
    }

    /// Number of coordinates: joint angles, joint parameters and strains.
    pub fn coordinates(&self) -> usize {
        self.equations.model.coordinates
    }

    /// Mass of the wing in kg, with the mass factors of the last initialisation.
    pub fn mass_kg(&self) -> f64 {
        crate::multibody::energy::mass_kg(&self.equations.model)
    }

    /// Inputs of the coming step.
    pub fn inputs(&self) -> &Inputs {
        &self.state.inputs
    }

    /// Inputs of the coming step, to be changed. The motion follows from the next [`Plant::step`] on; outputs that feel an
    /// input at once do so when [`Plant::provide`] finds them.
    pub fn inputs_mut(&mut self) -> &mut Inputs {
        self.found = OutputSet::NONE;
        self.inputs_may_differ = true;
        &mut self.state.inputs
    }

    /// Rates of the real inputs per second in the coming step, to be changed: the inputs then run linearly from their
    /// present values, NOTATION eq. (A4), and stay at its end where they have led. They hold for one step only.
    pub fn input_rates_mut(&mut self) -> &mut Inputs {
        &mut self.state.rates
    }

    /// Parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.state.parameters
    }

    /// Parameters, to be changed: fixed ones before [`Plant::initialize`], tunable ones at any time.
    pub fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.state.parameters
    }

    /// Present time in s.
    pub fn time_s(&self) -> f64 {
        self.state.now.time_s
    }

    /// Outputs at the present time, with the inputs of the step that led here: all, or those of [`Plant::watch`].
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Stopper and latch of each revolute or prismatic joint, in the order of [`Plant::revolute_joints`]; nothing before
    /// [`Plant::initialize`].
    pub fn joint_statuses(&self) -> impl Iterator<Item = JointStatus> {
        let driven = self.equations.forces.joints().iter().map(|joint| joint.driven);
        self.state.joints.iter().zip(driven).map(|(joint, driven)| JointStatus {
            released: driven && joint.released,
            latched: joint.latch.closed,
            latch_time_s: joint.latch.time_s,
            latch_count: joint.latch.count,
        })
    }

    /// Durations of the communication steps since initialisation, as far as the caller records them. Saved states do
    /// not contain them.
    pub fn latency(&self) -> &Latency {
        &self.latency
    }

    /// Durations, to be recorded.
    pub fn latency_mut(&mut self) -> &mut Latency {
        &mut self.latency
    }

    /// Counters since initialisation.
    pub fn statistics(&self) -> Statistics {
        self.state.statistics
    }

    /// Copies everything that a rollback needs.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot::of(&self.state)
    }

    /// Goes back to a snapshot of the same model; outputs included, bit for bit.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), PlantError> {
        let air = self.air.as_ref().map(|air| &air.blank);
        let stages = self.stepper.continuation().inner_stages();
        snapshot.check(&self.state, self.coordinates(), self.tip_bodies.len(), stages, air)?;
        let own = std::mem::replace(&mut self.state, snapshot.state().clone());
        self.inputs_may_differ = true;
        self.adopt_state();
        if self.state.initialized && !self.is_moderate() {
            self.evaluate();
            if !self.outputs.are_finite() {
                self.state = own;
                self.adopt_state();
                return Err(PlantError::Snapshot("its outputs are not finite".into()));
            }
        }
        self.show_set_inputs();
        Ok(())
    }

    /// Brings equations and outputs in line with a state that was set.
    fn adopt_state(&mut self) {
        self.rebuild();
        if self.state.initialized {
            self.configure();
            self.forget_outputs();
            self.provide(self.watched);
        }
    }

    /// Makes the equations anew where a fixed parameter has changed since they were made.
    fn rebuild(&mut self) {
        if self.built_with != self.state.parameters {
            self.equations = Equations::new(&self.machine, &self.state.parameters);
            self.built_with.clone_from(&self.state.parameters);
        }
    }
}
