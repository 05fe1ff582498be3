//! The model as a hybrid system: a state, equations that give its derivatives, events that change both, and outputs.
//!
//! Runs (module `run`) advance it in time; studies evaluate it at a single state.

pub(crate) mod air;
pub(crate) mod brake;
pub(crate) mod course;
pub(crate) mod crossing;
pub(crate) mod equations;
mod error;
pub(crate) mod events;
mod exchange;
mod failed_steps;
pub(crate) mod failure_memory;
pub(crate) mod failures;
mod fastest;
pub(crate) mod freedoms;
mod hybrid;
mod independent;
mod joint_forces;
pub(crate) mod magnitude;
mod model_magnitude;
mod no_heading;
mod nominal;
mod not_finite;
pub(crate) mod outputs;
mod outside;
pub(crate) mod place;
mod rest;
pub(crate) mod shape;
pub(crate) mod spatial;
pub(crate) mod start;
pub(crate) mod state;
mod statistics;
mod strains;
mod unsupported;
mod wake_rows;

pub use crate::aero::RotorLoads;
pub use air::{CLOSED_PANELS, SurfaceGap, SurfaceLattice};
pub use error::PlantError;
pub use exchange::{CoordinateName, CoordinateQuantity};
pub use fastest::FastestMotion;
pub use freedoms::Freedom;
pub use hybrid::{AccountRates, Hybrid, Jump, NotHybrid};
pub use outputs::{
    DcMotorOutputs, EnergyOutputs, FailureOutputs, FlapOutputs, GeneratorOutputs, JointOutputs, LatchOutputs,
    LoopOutputs, ModalOutputs, NoSlipOutputs, OutputLayout, OutputSet, Outputs, PointOutputs, SpatialOutputs,
};
pub(crate) use shape::ENERGY_SHARES;
pub use shape::{
    FlightMode, ModeShape, NodeMotion, SHEAR_SHARE, SectionChange, SectionPlace, SectionShape, SectionState,
    WhirlShare, energy_share_names,
};
pub use state::Snapshot;
pub use statistics::{JointStatus, Statistics};
pub use strains::SectionStrain;

use crate::beam::element::ElementKind;
use crate::machine::{Gauge, Machine};
use crate::multibody::gauge::GaugePoint;
use crate::signal::{Inputs, Parameters};
use crate::solve::continuation::Continuation;
use air::AirCoupling;
use equations::Equations;
use state::State;
use std::sync::Arc;

/// A model with its state at one time.
pub struct System {
    pub(crate) machine: Arc<Machine>,
    revolute_joints: Vec<usize>,
    spatial_joints: Vec<usize>,
    pub(crate) tip_bodies: Vec<usize>,
    /// Indices of the coordinates that are Model Exchange states.
    moving: Vec<usize>,
    /// Quantities that follow from the states set by an external integrator.
    told: outside::Told,
    /// Options of an external integrator.
    exchange: outside::Manner,
    gauges: Vec<GaugePoint>,
    pub(crate) state: State,
    /// State to roll back to if the current step or transition fails.
    pub(crate) begin: State,
    pub(crate) equations: Equations,
    /// Fixed parameters that `equations` was built with.
    built_with: Parameters,
    /// Interpolation of states within the integrator's step, from its stages.
    pub(crate) continuation: Continuation,
    pub(crate) air: Option<Box<AirCoupling>>,
    pub(crate) scratch: [Vec<f64>; 2],
    pub(crate) outputs: Outputs,
    /// Outputs that each step evaluates.
    pub(crate) watched: OutputSet,
    /// Outputs that are up to date at the current time.
    found: OutputSet,
    /// Whether inputs may have been set since the last step, so that they differ from those of the current step.
    pub(crate) inputs_may_differ: bool,
    /// Whether some gauge reads a strain that is recovered from forces.
    gauges_need_forces: bool,
    /// Whether the parameters of the model are so moderate that outputs overflow only for extreme states or inputs.
    model_is_moderate: bool,
}

impl System {
    /// Creates the system of a validated model, with the inputs and parameters of the model; not yet started.
    pub(crate) fn new(machine: Arc<Machine>, continuation: Continuation) -> Self {
        let state = State::of_model(&machine);
        let equations = Equations::new(&machine, &state.parameters);
        let coordinates = equations.model.coordinates;
        let recovered = |gauge: &Gauge| machine.bodies[gauge.body].element == ElementKind::Linear;
        let gauges = outputs::gauge_points(&machine);
        Self {
            revolute_joints: machine.one_freedoms().map(|(body, _)| body).collect(),
            spatial_joints: machine.spatials().map(|(body, _)| body).collect(),
            tip_bodies: machine.tip_bodies().collect(),
            gauges_need_forces: machine.gauges.iter().any(recovered),
            model_is_moderate: model_magnitude::model_is_moderate(&equations.model, &gauges),
            gauges,
            moving: Self::moving_coordinates(&equations),
            told: outside::Told::default(),
            exchange: outside::Manner::default(),
            begin: state.clone(),
            built_with: state.parameters.clone(),
            state,
            equations,
            continuation,
            air: AirCoupling::new(&machine).map(Box::new),
            scratch: [vec![0.0; coordinates], vec![0.0; coordinates]],
            outputs: Outputs::blank(&machine),
            watched: OutputSet::ALL,
            found: OutputSet::NONE,
            inputs_may_differ: false,
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

    /// Numbers of joint variables and Lagrange multipliers of a body's joint in this formulation: `N_J` and `N_L` of Otsuka et al., Table
    /// 2.
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

    /// Name of a joint with one degree of freedom, by its index among those.
    pub(crate) fn joint_name(&self, joint: usize) -> &str {
        &self.machine.bodies[self.equations.forces.joints()[joint].body].joint.name
    }

    /// Names of the free joints that are the only connection between the root and the bodies attached by them.
    pub fn flying_joints(&self) -> Vec<&str> {
        let flying = self.equations.spatial.iter().filter(|joint| joint.flies);
        flying.map(|joint| self.machine.bodies[joint.body].joint.name.as_str()).collect()
    }

    /// Inputs of the next step.
    pub fn inputs(&self) -> &Inputs {
        &self.state.inputs
    }

    /// Mutable access to the inputs of the next step. They affect the motion from the next `Plant::step` on; outputs with direct
    /// feedthrough are updated when [`System::provide`] evaluates them.
    pub fn inputs_mut(&mut self) -> &mut Inputs {
        self.found = OutputSet::NONE;
        self.inputs_may_differ = true;
        &mut self.state.inputs
    }

    /// Mutable access to the rates per second of the real inputs in the next step: the inputs then vary linearly from their current values,
    /// NOTATION eq. (A4), and keep their values at its end. The rates apply to one step only.
    pub fn input_rates_mut(&mut self) -> &mut Inputs {
        &mut self.state.rates
    }

    /// Parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.state.parameters
    }

    /// Mutable access to the parameters: fixed ones may be changed before `Plant::initialize`, tunable ones at any time.
    pub fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.state.parameters
    }

    /// Current time in s.
    pub fn time_s(&self) -> f64 {
        self.state.now.time_s
    }

    /// Outputs at the current time, with the inputs of the last step: all outputs, or those selected by [`System::watch`].
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Lock and latch of each revolute or prismatic joint, in the order of [`System::revolute_joints`]; empty before `Plant::initialize`.
    pub fn joint_statuses(&self) -> impl Iterator<Item = JointStatus> {
        let driven = self.equations.forces.joints().iter().map(|joint| joint.driven);
        self.state.joints.iter().zip(driven).map(|(joint, driven)| JointStatus {
            released: driven && joint.released,
            latched: joint.latch.closed,
            latch_time_s: joint.latch.time_s,
            latch_count: joint.latch.count,
        })
    }

    /// Counters since initialisation.
    pub fn statistics(&self) -> Statistics {
        self.state.statistics
    }

    /// Copies the state for rollback.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot::of(&self.state)
    }

    /// Restores a snapshot of the same model, including the outputs, with identical bits.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), PlantError> {
        let air = self.air.as_ref().map(|air| &air.blank);
        let stages = self.continuation.inner_stages();
        snapshot.check(
            &self.state,
            (self.coordinates(), self.exchange_state_count()),
            self.tip_bodies.len(),
            stages,
            air,
        )?;
        let own = std::mem::replace(&mut self.state, snapshot.state().clone());
        self.inputs_may_differ = true;
        self.told.forget();
        self.adopt_state();
        // a saved trial state of an external integrator is restored even if it is extreme; its evaluation then fails again
        if self.state.initialized && !snapshot.is_outside() && !self.is_moderate() {
            self.evaluate();
            if !self.outputs.are_finite() {
                self.state = own;
                self.adopt_state();
                return Err(PlantError::Snapshot("the outputs of the state are not finite".into()));
            }
        }
        self.show_set_inputs();
        Ok(())
    }

    /// Restores a state of this system, including its inputs, after a study.
    pub(crate) fn put_back(&mut self, state: State) {
        self.state = state;
        self.inputs_may_differ = true;
        self.told.forget();
        self.adopt_state();
        self.show_set_inputs();
    }

    /// Updates equations and outputs to a newly set state.
    fn adopt_state(&mut self) {
        self.rebuild();
        self.limit_frequencies();
        if self.state.initialized {
            self.configure();
            self.forget_outputs();
            self.provide(self.watched);
        }
    }

    /// Rebuilds the equations if a fixed parameter has changed.
    pub(crate) fn rebuild(&mut self) {
        if self.built_with != self.state.parameters {
            self.equations = Equations::new(&self.machine, &self.state.parameters);
            self.built_with.clone_from(&self.state.parameters);
        }
    }
}
