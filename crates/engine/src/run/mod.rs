//! A run of a model: its system advanced in time.
//!
//! The integrator takes internal steps and runs ahead of the caller while the inputs are unchanged; values in between are interpolated from
//! the stages of its steps. A changed input cuts the step at the current time. The result therefore does not depend on the communication
//! step, and small communication steps cost little (`docs/decisions/0002-running-ahead.md`).

mod agreement;
mod arrival;
mod latency;
mod march;
mod pauses;
pub mod periodic;

pub use latency::Latency;
pub use pauses::{Pauses, Reached};
pub use periodic::{Floquet, FloquetMode, Harmonic, NearbyMotion, PeriodicMotion, SAMPLES, Seen, Settled, Turn};

use crate::force::set::Indicator;
use crate::machine::{Machine, Method, StartState};
use crate::signal::{Inputs, Parameters, SolverParameters};
use crate::solve::stepper::{self, Stepper};
use crate::solve::tableau::Tableau;
use crate::study::{Holding, Study};
use crate::system::{Hybrid, NotHybrid, OutputSet, PlantError, Snapshot, SurfaceGap, System};
use agreement::Trial;
use std::ops::Deref;
use std::sync::Arc;

/// A model advanced in time: its [`System`], to which it dereferences, and the integrator.
pub struct Plant {
    pub(crate) system: System,
    stepper: Stepper,
    /// Maximum number of Newton iterations of the current communication step, and the remaining number.
    most_work: u64,
    work_left: u64,
    /// Smallest step required by the error estimate since the start of the current trial march, in s.
    smallest_step_s: f64,
    /// Remaining error of the iterations in the last real-time step, in the kinematic norm.
    rest: f64,
    trial: Trial,
    latency: Latency,
}

impl Deref for Plant {
    type Target = System;

    fn deref(&self) -> &System {
        &self.system
    }
}

impl Plant {
    /// Creates a plant of a validated model, with the inputs and parameters of the model; not yet initialised.
    pub fn new(machine: Arc<Machine>) -> Self {
        let method = match machine.solver.method {
            Method::GeneralizedAlpha => stepper::Method::GeneralizedAlpha { rho_infinity: machine.solver.rho_infinity },
            Method::TrBdf2 => stepper::Method::TrBdf2,
            Method::Esdirk3 => stepper::Method::Esdirk3,
            Method::Sdirk2 => stepper::Method::Sdirk2,
            Method::Esdirk4 => stepper::Method::Esdirk4,
            Method::Rk4 => stepper::Method::Rk4,
        };
        let system = System::new(machine, method.continuation());
        Self {
            stepper: Stepper::new(method, system.coordinates()),
            trial: Trial::new(&system),
            system,
            most_work: 0,
            work_left: 0,
            smallest_step_s: f64::INFINITY,
            rest: 0.0,
            latency: Latency::default(),
        }
    }

    /// Stages of the integrator; `None` for methods without implicit stages.
    pub(crate) fn tableau(&self) -> Option<&'static Tableau<'static>> {
        self.stepper.tableau()
    }

    /// Takes one step of given length to a time, or to the first crossing within it, for comparisons of runs with identical steps; a crossing
    /// that is expected is located to round-off.
    pub(crate) fn take_fixed_step(
        &mut self,
        (step_s, end_s): (f64, f64),
        expected: Option<Indicator>,
    ) -> Result<(), PlantError> {
        let sharpened = |plant: &mut Self| expected.map_or(Ok(()), |indicator| plant.sharpen_crossing(indicator));
        self.take_fixed(step_s, end_s)
            .and_then(|()| sharpened(self))
            .map_err(|_| PlantError::Clock { time_s: end_s, step_s })
    }

    /// Analyses of the current state: equilibria, modes, linear models, derivatives.
    pub fn study(&mut self) -> Study<'_> {
        Study::new(&mut self.system)
    }

    /// Builds the equations, sets the start state, and computes the accelerations and the outputs at `time_s`.
    ///
    /// May be called again (an FMU re-evaluates in Initialization Mode). After an error the state is unchanged.
    pub fn initialize(&mut self, time_s: f64) -> Result<(), PlantError> {
        self.latency.clear();
        let before = self.system.state.clone();
        let outcome = self.find_start(time_s);
        if outcome.is_err() {
            self.system.state = before;
            if self.system.state.initialized {
                self.system.configure();
                self.system.evaluate();
            }
        }
        outcome
    }

    fn find_start(&mut self, time_s: f64) -> Result<(), PlantError> {
        let SolverParameters { min_step_s, max_step_s, .. } = *self.parameters().solver();
        if min_step_s > max_step_s {
            return Err(PlantError::Steps { min_step_s, max_step_s });
        }
        self.system.start(time_s);
        if self.machine().experiment.start == StartState::Equilibrium {
            self.study().settle_in_air(time_s, Holding::Stopped)?;
            self.system.equations.rest_currents(&mut self.system.state.now.v);
        }
        self.system.conclude_start(time_s)
    }

    /// See [`System::inputs_mut`].
    pub fn inputs_mut(&mut self) -> &mut Inputs {
        self.system.inputs_mut()
    }

    /// See [`System::input_rates_mut`].
    pub fn input_rates_mut(&mut self) -> &mut Inputs {
        self.system.input_rates_mut()
    }

    /// See [`System::parameters_mut`].
    pub fn parameters_mut(&mut self) -> &mut Parameters {
        self.system.parameters_mut()
    }

    /// See [`System::watch`].
    pub fn watch(&mut self, wanted: OutputSet) {
        self.system.watch(wanted);
    }

    /// See [`System::provide`].
    pub fn provide(&mut self, wanted: OutputSet) {
        self.system.provide(wanted);
    }

    /// See [`System::restore`].
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), PlantError> {
        self.system.restore(snapshot)
    }

    /// See [`System::hybrid`].
    pub fn hybrid(&mut self) -> Result<Hybrid<'_>, NotHybrid> {
        self.system.hybrid()
    }

    /// The system itself, for external integrators.
    pub fn system_mut(&mut self) -> &mut System {
        &mut self.system
    }

    /// See [`System::surface_gaps`].
    pub fn surface_gaps(&mut self) -> Vec<SurfaceGap> {
        self.system.surface_gaps()
    }

    /// Durations of the communication steps since initialisation, if the caller records them. Saved states do not contain them.
    pub fn latency(&self) -> &Latency {
        &self.latency
    }

    /// Mutable access to the durations, for recording.
    pub fn latency_mut(&mut self) -> &mut Latency {
        &mut self.latency
    }
}
