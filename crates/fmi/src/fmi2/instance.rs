//! One instance: the life cycle around a plant and its variable table.

use crate::fmi2::error::{CallError, InstantiationError, Status};
use crate::fmi2::life_cycle::{Call, InterfaceKind, Phase};
use crate::fmi2::log::{Log, LogCategory};
use crate::fmi2::resource::read_model;
use crate::fmi2::state::{Experiment, Registry, SavedState, StateError};
use crate::interface::{DerivativeError, Interface, Kind, Scalar, Stage, Value, guid};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{JointStatus, OutputSet, Plant};
use foldwing_file as config;
use std::sync::Arc;
use std::time::Instant;

/// Relative round-off of the importer's clock that is accepted.
const CLOCK_TOLERANCE: f64 = 1e-9;

/// One FMU instance.
pub struct Instance {
    machine: Arc<Machine>,
    guid: String,
    pub(super) interface: Interface,
    pub(super) plant: Plant,
    pub(super) kind: InterfaceKind,
    pub(super) phase: Phase,
    experiment: Experiment,
    /// Start values changed since the last evaluation.
    pub(super) stale: bool,
    step_failed: bool,
    /// Outputs that the importer has read since the last step, and between the two steps before.
    read: OutputSet,
    read_before: OutputSet,
    states: Registry,
    pub(super) log: Log,
}

/// Arguments of `fmi2Instantiate`.
pub struct Request<'a> {
    /// Name of the instance.
    pub name: Option<&'a str>,
    /// Kind of simulation: 0 is Model Exchange, 1 co-simulation.
    pub fmu_type: u32,
    /// GUID of the model description.
    pub guid: Option<&'a str>,
    /// Resource folder.
    pub resource_location: Option<&'a str>,
}

/// Arguments of `fmi2SetupExperiment`, times in s.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// Tolerance, where defined.
    pub tolerance: Option<f64>,
    /// Start time.
    pub start_s: f64,
    /// Stop time, where defined.
    pub stop_s: Option<f64>,
}

impl Instance {
    /// An instance of the model in the resource folder, with a silent log.
    pub fn new(request: &Request) -> Result<Self, InstantiationError> {
        let kind = match request.fmu_type {
            0 => InterfaceKind::ModelExchange,
            1 => InterfaceKind::CoSimulation,
            other => return Err(InstantiationError::WrongType(other)),
        };
        let Model { machine, plant, interface, guid } = Model::of(request)?;
        if kind == InterfaceKind::ModelExchange && !interface.has_states() {
            return Err(InstantiationError::NoModelExchange);
        }
        Ok(Self {
            plant,
            kind,
            experiment: default_experiment(&machine),
            machine,
            guid,
            interface,
            phase: Phase::Instantiated,
            stale: true,
            step_failed: false,
            read: OutputSet::NONE,
            read_before: OutputSet::NONE,
            states: Registry::new(),
            log: Log::new(None, false),
        })
    }

    /// Whether a call is legal now.
    pub fn permit(&self, call: Call) -> Result<(), CallError> {
        let kind = self.kind;
        match self.phase {
            Phase::Fatal => Err(CallError::Poisoned),
            phase if call.is_legal(phase) && call.kind().is_none_or(|of| of == kind) => Ok(()),
            phase => Err(CallError::OutOfOrder { call, kind, phase }),
        }
    }

    /// Tells the importer why a call was refused or failed.
    pub fn report(&self, call: Call, error: &CallError) -> Status {
        let status = error.status();
        self.log.refuse(status, &format!("{}: {error}", call.name()));
        status
    }

    /// After a panic nothing can be trusted any more.
    pub fn poison(&mut self, call: Call, cause: &str) -> Status {
        self.phase = Phase::Fatal;
        self.log.refuse(Status::Fatal, &format!("{}: internal error: {cause}", call.name()));
        Status::Fatal
    }

    /// The log.
    pub fn log_mut(&mut self) -> &mut Log {
        &mut self.log
    }

    /// The variable table.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// `fmi2SetupExperiment`.
    pub fn setup_experiment(&mut self, setup: Setup) -> Result<(), CallError> {
        if !setup.start_s.is_finite() {
            return Err(CallError::Argument { argument: "startTime", value: setup.start_s, allowed: "finite" });
        }
        if let Some(value) = setup.stop_s.filter(|&stop_s| !(stop_s.is_finite() && stop_s >= setup.start_s)) {
            let allowed = "finite and not before startTime";
            return Err(CallError::Argument { argument: "stopTime", value, allowed });
        }
        if let (Some(tolerance), Some(row)) = (setup.tolerance, self.interface.find("solver.tolerance")) {
            self.interface.set(&mut self.plant, row.value_reference, Value::Real(tolerance))?;
        }
        self.experiment = Experiment { start_s: setup.start_s, stop_s: setup.stop_s };
        self.stale = true;
        Ok(())
    }

    /// `fmi2EnterInitializationMode`.
    pub fn enter_initialization(&mut self) {
        self.phase = Phase::Initialization;
        self.stale = true;
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        self.evaluate()?;
        self.phase = match self.kind {
            InterfaceKind::CoSimulation => Phase::StepComplete,
            InterfaceKind::ModelExchange => Phase::Event,
        };
        Ok(())
    }

    /// `fmi2Terminate`.
    pub fn terminate(&mut self) {
        self.phase = Phase::Terminated;
    }

    /// `fmi2Reset`: as freshly instantiated; saved states and the log's switches stay.
    pub fn reset(&mut self) {
        self.plant = unwatched(&self.machine);
        self.experiment = default_experiment(&self.machine);
        self.phase = Phase::Instantiated;
        self.stale = true;
        self.step_failed = false;
    }

    /// Reads variables of one type; in Initialization Mode computed ones are evaluated first.
    pub fn get<T: Scalar>(&mut self, references: &[u32], values: &mut [T]) -> Result<(), CallError> {
        if self.stale && references.iter().any(|&reference| self.interface.is_computed(reference)) {
            // a refused call changes nothing
            self.interface.check_kind(references, T::KIND)?;
            self.evaluate()?;
        }
        self.update(references)?;
        let needs = self.interface.needs(references);
        self.read = self.read | needs;
        // importers read the same variables after every step: one evaluation serves all their calls
        if !self.plant.provides(needs) {
            self.plant.provide(self.read | self.read_before);
        }
        Ok(self.interface.get_all(&self.plant, references, values)?)
    }

    /// Sets inputs and parameters of one type: all of them or, on a refusal, none.
    pub fn set<T: Scalar>(&mut self, references: &[u32], values: &[T]) -> Result<(), CallError> {
        let stage = self.stage();
        self.refuse_discrete(references)?;
        self.interface.set_all(&mut self.plant, references, values, stage)?;
        self.plant.system_mut().exchange_inputs_set();
        self.stale |= stage == Stage::Starting && !references.is_empty();
        Ok(())
    }

    /// Where setting and differentiating stand.
    fn stage(&self) -> Stage {
        match self.phase {
            Phase::Instantiated | Phase::Initialization => Stage::Starting,
            _ => Stage::Running,
        }
    }

    /// `fmi2SetRealInputDerivatives`: for the next step only.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), CallError> {
        Ok(self.interface.set_input_rates(&mut self.plant, references, orders, values)?)
    }

    /// `fmi2GetRealOutputDerivatives`.
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), CallError> {
        Ok(self.interface.output_rates(&mut self.plant, references, orders, values)?)
    }

    /// `fmi2GetDirectionalDerivative`.
    pub fn directional_derivative(
        &mut self,
        unknowns: (&[u32], &mut [f64]),
        knowns: (&[u32], &[f64]),
    ) -> Result<(), CallError> {
        if self.machine.air.is_some() {
            return Err(CallError::DerivativesInAir);
        }
        let when = (self.stage(), self.experiment.start_s);
        // a refused call changes nothing: the evaluation is undone with it
        let before = self.stale.then(|| self.plant.snapshot());
        let outcome = self.evaluate().and_then(|()| {
            let found = self.interface.directional_derivative(&mut self.plant, when, unknowns, knowns);
            found.map_err(|error| match error {
                DerivativeError::Access(error) => error.into(),
                DerivativeError::Plant(error) => error.into(),
            })
        });
        if let (Err(_), Some(before)) = (&outcome, before) {
            self.plant.restore(&before)?;
            self.stale = true;
        }
        outcome
    }

    /// There are no strings: every reference is refused.
    pub fn no_strings(&self, references: &[u32]) -> Result<(), CallError> {
        Ok(self.interface.check_kind(references, Kind::String)?)
    }

    /// `fmi2DoStep` from `time_s` over `step_s`. Allocates nothing of its own unless it fails or logs.
    pub fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), CallError> {
        let end_s = time_s + step_s;
        if !(step_s > 0.0 && end_s.is_finite() && end_s > time_s) {
            return Err(CallError::StepSize { time_s, step_s });
        }
        let tolerance_s = CLOCK_TOLERANCE * step_s.max(time_s.abs()).max(1.0);
        let own_s = self.plant.time_s();
        if (time_s - own_s).abs() > tolerance_s {
            return Err(CallError::TimeMismatch { time_s, own_s });
        }
        if let Some(stop_s) = self.experiment.stop_s.filter(|stop_s| end_s > stop_s + tolerance_s) {
            return Err(CallError::BeyondStop { end_s, stop_s });
        }
        let longest_s = self.plant.longest_step_s();
        if step_s > longest_s {
            return Err(CallError::StepTooLong { time_s, step_s, longest_s });
        }
        if time_s != own_s {
            self.plant.adopt_time(time_s);
        }
        let before: Option<Vec<JointStatus>> =
            self.log.wants(LogCategory::Events).then(|| self.plant.joint_statuses().collect());
        let started = self.machine.solver.most_iterations.map(|_| Instant::now());
        self.read_before = std::mem::take(&mut self.read);
        let advised = self.advice_on_rows().is_some();
        let failing = self.plant.statistics().newton_decides();
        let outcome = self.plant.step(end_s);
        if let Some(started) = started {
            self.plant.latency_mut().record(started.elapsed().as_secs_f64());
        }
        if let Some(before) = before {
            self.tell_events(Call::DoStep, time_s, &before);
        }
        if let Some(advice) = self.advice_on_rows().filter(|_| !advised) {
            self.log.write(Status::Warning, LogCategory::Warning, &format!("fmi2DoStep: {advice}"));
        }
        if !failing && let Some(advice) = self.plant.statistics().advice_on_failures() {
            self.log.write(Status::Warning, LogCategory::Warning, &format!("fmi2DoStep: {advice}"));
        }
        if let Err(error) = outcome {
            self.step_failed = true;
            self.phase = Phase::StepFailed;
            return Err(error.into());
        }
        Ok(())
    }

    /// Status of the last step.
    pub fn step_status(&self) -> Status {
        SavedState::step_status(self.step_failed)
    }

    /// End of the last successful internal step in s.
    pub fn last_successful_time_s(&self) -> f64 {
        self.plant.time_s()
    }

    /// `fmi2GetFMUstate`: saves the present state under the handle, or a new one for handle 0.
    pub fn save_state(&mut self, handle: usize) -> Result<usize, CallError> {
        let state = SavedState {
            kind: self.kind,
            phase: self.phase,
            experiment: self.experiment,
            stale: self.stale,
            step_failed: self.step_failed,
            plant: self.plant.snapshot(),
        };
        if handle == 0 {
            return Ok(self.states.insert(state));
        }
        self.states.replace(handle, state)?;
        Ok(handle)
    }

    /// `fmi2SetFMUstate`.
    pub fn restore_state(&mut self, handle: usize) -> Result<(), CallError> {
        let state = self.states.get(handle)?;
        if state.kind != self.kind {
            return Err(StateError::OtherKind { found: state.kind, expected: self.kind }.into());
        }
        let outside = state.plant.is_outside();
        if outside && self.kind == InterfaceKind::CoSimulation
            || !outside && !state.stale && self.kind == InterfaceKind::ModelExchange
        {
            return Err(StateError::Content(format!("its machine is not one of {}", self.kind)).into());
        }
        self.plant.restore(&state.plant)?;
        self.phase = state.phase;
        self.experiment = state.experiment;
        self.stale = state.stale;
        self.step_failed = state.step_failed;
        Ok(())
    }

    /// `fmi2FreeFMUstate`.
    pub fn free_state(&mut self, handle: usize) -> Result<(), CallError> {
        Ok(self.states.remove(handle)?)
    }

    /// Bytes of a saved state.
    pub fn serialize_state(&self, handle: usize) -> Result<Vec<u8>, CallError> {
        Ok(self.states.get(handle)?.to_bytes(&self.guid)?)
    }

    /// A saved state from bytes; returns its handle.
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<usize, CallError> {
        let state = SavedState::from_bytes(bytes, &self.guid)?;
        Ok(self.states.insert(state))
    }

    /// Evaluates the start values if they changed.
    pub(super) fn evaluate(&mut self) -> Result<(), CallError> {
        if self.stale {
            self.plant.initialize(self.experiment.start_s)?;
            if self.kind == InterfaceKind::ModelExchange {
                self.plant.system_mut().begin_exchange()?;
            }
            self.stale = false;
        }
        Ok(())
    }

    /// What to say of rows in the wake that are too long, where anybody listens.
    fn advice_on_rows(&self) -> Option<String> {
        let air = self.machine.air.as_ref().filter(|_| self.log.wants(LogCategory::Warning))?;
        self.plant.statistics().advice_on_rows(air.step_s)
    }

    /// One message per release, hold, closing and opening of a step that began at `start_s`. Releases, holds and openings follow
    /// from inputs, which act at the beginning.
    pub(super) fn tell_events(&self, call: Call, start_s: f64, before: &[JointStatus]) {
        for ((body, before), now) in self.plant.revolute_joints().iter().zip(before).zip(self.plant.joint_statuses()) {
            let name = &self.machine.bodies[*body].joint.name;
            let tell = |event: &str, time_s: f64| {
                let text = format!("{}: joint {name}: {event} at t = {time_s:.9} s", call.name());
                self.log.write(Status::Ok, LogCategory::Events, &text);
            };
            if now.released && !before.released {
                tell("released", start_s);
            }
            if before.released && !now.released {
                tell("held", start_s);
            }
            if before.latched && (!now.latched || now.latch_count > before.latch_count) {
                tell("latch opened", start_s);
            }
            if now.latch_count > before.latch_count {
                tell("latch closed", now.latch_time_s);
            }
        }
    }
}

/// The model in the resource folder, as an instance holds it.
struct Model {
    machine: Arc<Machine>,
    plant: Plant,
    interface: Interface,
    guid: String,
}

impl Model {
    /// Reads it; the table is the one that the GUID names, with continuous states or without.
    fn of(request: &Request) -> Result<Self, InstantiationError> {
        if request.name.is_none_or(str::is_empty) {
            return Err(InstantiationError::NoName);
        }
        let (text, path) = read_model(request.resource_location)?;
        let machine = Arc::new(config::parse(&text, &path.to_string_lossy())?);
        let plant = unwatched(&machine);
        let plain = Interface::new(&machine);
        let own = guid(&text, plain.variables());
        let given = request.guid.unwrap_or("(null)");
        if given == own {
            return Ok(Self { machine, plant, interface: plain, guid: own });
        }
        let interface = Interface::with_states(&machine, &plant);
        let guid = guid(&text, interface.variables());
        match given == guid {
            true => Ok(Self { machine, plant, interface, guid }),
            false => Err(InstantiationError::Guid { given: given.to_owned(), own }),
        }
    }
}

/// A plant that finds outputs when they are read.
fn unwatched(machine: &Arc<Machine>) -> Plant {
    let mut plant = Plant::new(Arc::clone(machine));
    plant.watch(OutputSet::NONE);
    plant
}

/// Experiment of an importer that does not call `fmi2SetupExperiment`.
fn default_experiment(machine: &Machine) -> Experiment {
    Experiment { start_s: machine.experiment.start_time_s, stop_s: None }
}
