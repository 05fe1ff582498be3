//! One instance for both versions of the standard: the life cycle around a plant and its variable table.
//!
//! The crate `foldwing-fmu` translates C calls into calls of [`Instance`]; this crate is safe Rust and is tested without C. The differences
//! between the versions (names, the table of functions) are in the modules `fmi2` and `fmi3`.

mod error;
mod exchange;
mod log;
mod phase;
mod resource;
mod state;
mod status;
mod step;
mod values;

pub use error::{CallError, InstantiationError};
pub use exchange::EventInfo;
pub use log::{LOG_CATEGORIES, Log, LogCategory, Sink};
pub use phase::{InterfaceKind, Phase, Rule, Version};
pub use resource::{MODEL_FILE, ResourceError, resource_path};
pub use state::StateError;
pub use status::Status;

pub use foldwing_engine::plant::Reached;

use crate::instance::state::{Experiment, Registry, SavedState};
use crate::interface::{Interface, Value, guid};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{OutputSet, Plant};
use foldwing_file as config;
use std::sync::Arc;

/// One FMU instance.
pub struct Instance {
    machine: Arc<Machine>,
    guid: String,
    interface: Interface,
    plant: Plant,
    version: Version,
    kind: InterfaceKind,
    manner: Manner,
    phase: Phase,
    experiment: Experiment,
    /// Start values changed since the last evaluation.
    stale: bool,
    step_failed: bool,
    /// Processor time of the current step in s, if steps are timed.
    spent_s: f64,
    /// Outputs read by the importer since the last step, and between the last two steps.
    read: OutputSet,
    read_before: OutputSet,
    states: Registry,
    log: Log,
}

/// Capabilities that an importer of FMI 3.0 co-simulation has declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Manner {
    /// The importer handles events in Event Mode.
    pub event_mode: bool,
    /// Steps may return before the requested time.
    pub early_return: bool,
    /// The importer requests intermediate updates.
    pub intermediate_update: bool,
}

/// Arguments of an instantiation.
pub struct Request<'a> {
    /// Version of the standard.
    pub version: Version,
    /// Name of the instance.
    pub name: Option<&'a str>,
    /// Interface type: 0 is Model Exchange, 1 co-simulation.
    pub fmu_type: u32,
    /// GUID or instantiation token of the model description.
    pub guid: Option<&'a str>,
    /// Resource folder.
    pub resource_location: Option<&'a str>,
    /// Capabilities of the importer.
    pub manner: Manner,
}

impl Request<'_> {
    /// The interface type; fails if there is none of this number, or no name of the instance.
    fn kind(&self) -> Result<InterfaceKind, InstantiationError> {
        let kind = match self.fmu_type {
            0 => InterfaceKind::ModelExchange,
            1 => InterfaceKind::CoSimulation,
            other => return Err(InstantiationError::WrongType(other)),
        };
        if self.name.is_none_or(str::is_empty) {
            return Err(InstantiationError::NoName);
        }
        Ok(kind)
    }
}

/// Times and tolerance given by the importer before the initialisation, in s.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// Tolerance, if defined.
    pub tolerance: Option<f64>,
    /// Start time.
    pub start_s: f64,
    /// Stop time, if defined.
    pub stop_s: Option<f64>,
}

impl Instance {
    /// Instantiates the model in the resource folder, with a silent log.
    pub fn new(request: &Request) -> Result<Self, InstantiationError> {
        request.kind()?;
        let (text, path) = resource::read_model(request.resource_location)?;
        Self::of_text(request, &text, &path.to_string_lossy())
    }

    /// Instantiates a model from the text of its file, with a silent log. `file` is the name of the file in messages; the resource
    /// location of the request is not used.
    ///
    /// # Errors
    /// The request or the text is invalid, or the GUID or token does not belong to the text.
    pub fn of_text(request: &Request, text: &str, file: &str) -> Result<Self, InstantiationError> {
        let kind = request.kind()?;
        let Model { machine, plant, interface, guid } = Model::of(request, text, file)?;
        if kind == InterfaceKind::ModelExchange && !interface.has_states() {
            return Err(InstantiationError::NoModelExchange);
        }
        Ok(Self {
            plant,
            version: request.version,
            kind,
            manner: request.manner,
            experiment: default_experiment(&machine),
            machine,
            guid,
            interface,
            phase: Phase::Instantiated,
            stale: true,
            step_failed: false,
            spent_s: 0.0,
            read: OutputSet::NONE,
            read_before: OutputSet::NONE,
            states: Registry::new(),
            log: Log::new(None, false),
        })
    }

    /// Checks that a call is legal now.
    pub fn permit(&self, call: Rule) -> Result<(), CallError> {
        let kind = self.kind;
        let phase = self.phase;
        if phase == Phase::Fatal {
            Err(CallError::Poisoned { version: self.version })
        } else if call.is_legal(phase) && call.kind.is_none_or(|of| of == kind) {
            Ok(())
        } else {
            Err(CallError::OutOfOrder { call, kind, phase })
        }
    }

    /// Reports the error of a call to the importer; returns its status.
    pub fn report(&self, call: Rule, error: &CallError) -> Status {
        let status = error.status();
        self.log.refuse(status, &format!("{}: {error}", call.name));
        status
    }

    /// Makes the instance unusable after a panic.
    pub fn poison(&mut self, call: Rule, cause: &str) -> Status {
        self.phase = Phase::Fatal;
        self.log.refuse(Status::Fatal, &format!("{}: internal error: {cause}", call.name));
        Status::Fatal
    }

    /// Capabilities of the importer.
    pub fn manner(&self) -> Manner {
        self.manner
    }

    /// The log.
    pub fn log_mut(&mut self) -> &mut Log {
        &mut self.log
    }

    /// The variable table.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Sets times and tolerance of the experiment.
    pub fn setup_experiment(&mut self, setup: Setup) -> Result<(), CallError> {
        if !setup.start_s.is_finite() {
            return Err(CallError::Argument { argument: "startTime", value: setup.start_s, allowed: "finite" });
        }
        if let Some(value) = setup.stop_s.filter(|&stop_s| !(stop_s.is_finite() && stop_s >= setup.start_s)) {
            let allowed = "finite and not before startTime";
            return Err(CallError::Argument { argument: "stopTime", value, allowed });
        }
        // a tolerance set as a parameter has priority over that of the experiment, which importers always pass, some after the parameters
        let own = self.plant.parameters().solver().tolerance;
        let is_set = own != self.machine.solver.tolerance;
        if let (Some(tolerance), Some(row), false) = (setup.tolerance, self.interface.find("solver.tolerance"), is_set)
        {
            self.interface.set(&mut self.plant, row.value_reference, Value::Real(tolerance))?;
        }
        self.experiment = Experiment { start_s: setup.start_s, stop_s: setup.stop_s };
        self.stale = true;
        Ok(())
    }

    /// Enters Initialization Mode.
    pub fn enter_initialization(&mut self) {
        self.phase = Phase::Initialization;
        self.stale = true;
    }

    /// Leaves Initialization Mode: to Event Mode if the importer handles events.
    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        self.evaluate()?;
        self.phase = match self.kind {
            InterfaceKind::CoSimulation if !self.manner.event_mode => Phase::StepComplete,
            InterfaceKind::CoSimulation | InterfaceKind::ModelExchange => Phase::Event,
        };
        Ok(())
    }

    /// Ends the simulation.
    pub fn terminate(&mut self) {
        self.phase = Phase::Terminated;
    }

    /// Resets the instance to its state after instantiation; saved states and log categories are kept.
    pub fn reset(&mut self) {
        let accounts = self.plant.keeps_exchange_accounts();
        self.plant = unwatched(&self.machine);
        self.plant.system_mut().keep_exchange_accounts(accounts);
        self.experiment = default_experiment(&self.machine);
        self.phase = Phase::Instantiated;
        self.stale = true;
        self.step_failed = false;
    }

    /// Saves the current state under a handle, which is a new one if 0 is passed.
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

    /// Restores a saved state.
    pub fn restore_state(&mut self, handle: usize) -> Result<(), CallError> {
        let state = self.states.get(handle)?;
        if state.kind != self.kind {
            return Err(StateError::OtherKind { found: state.kind, expected: self.kind }.into());
        }
        let outside = state.plant.is_outside();
        if outside && self.kind == InterfaceKind::CoSimulation
            || !outside && !state.stale && self.kind == InterfaceKind::ModelExchange
        {
            return Err(StateError::Content(format!("it was not saved in {}", self.kind)).into());
        }
        if !self.can_stand(state.phase) {
            let here = state.phase.phrase(self.version);
            return Err(
                StateError::Content(format!("it was saved {here}, a state that this instance never enters")).into()
            );
        }
        self.plant.restore(&state.plant)?;
        self.phase = state.phase;
        self.experiment = state.experiment;
        self.stale = state.stale;
        self.step_failed = state.step_failed;
        Ok(())
    }

    /// Frees a saved state.
    pub fn free_state(&mut self, handle: usize) -> Result<(), CallError> {
        Ok(self.states.remove(handle)?)
    }

    /// Serialises a saved state.
    pub fn serialize_state(&self, handle: usize) -> Result<Vec<u8>, CallError> {
        Ok(self.states.get(handle)?.to_bytes(&self.guid)?)
    }

    /// Creates a saved state from bytes; returns its handle.
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<usize, CallError> {
        let state = SavedState::from_bytes(bytes, &self.guid)?;
        Ok(self.states.insert(state))
    }

    /// Returns whether an instance can have been saved in this phase.
    fn can_stand(&self, phase: Phase) -> bool {
        let of_mode = phase != Phase::Event || self.kind == InterfaceKind::ModelExchange || self.manner.event_mode;
        phase.belongs_to(self.kind, self.version)
            && of_mode
            && !matches!(phase, Phase::IntermediateUpdate | Phase::Fatal)
    }

    /// Evaluates the start values if they changed.
    fn evaluate(&mut self) -> Result<(), CallError> {
        if self.stale {
            self.plant.initialize(self.experiment.start_s)?;
            if self.kind == InterfaceKind::ModelExchange {
                self.plant.system_mut().begin_exchange()?;
            }
            self.stale = false;
        }
        Ok(())
    }
}

/// Model of an instance.
struct Model {
    machine: Arc<Machine>,
    plant: Plant,
    interface: Interface,
    guid: String,
}

impl Model {
    /// Reads the model with the variable table to which the GUID or token belongs: with or without continuous states, in arrays or scalars.
    fn of(request: &Request, text: &str, file: &str) -> Result<Self, InstantiationError> {
        let machine = Arc::new(config::parse(text, file)?);
        let mut plant = unwatched(&machine);
        let token = |interface: &Interface| match request.version {
            Version::Fmi2 => guid(text, interface.variables()),
            Version::Fmi3 => interface.instantiation_token(text),
        };
        let given = request.guid.unwrap_or("(null)");
        let plain = || Interface::new(&machine);
        let exchanged = |plant: &mut Plant, accounts: bool| {
            plant.system_mut().keep_exchange_accounts(accounts);
            match request.version {
                Version::Fmi2 => Interface::with_states(&machine, plant),
                Version::Fmi3 => Interface::with_states_and_indicators(&machine, plant),
            }
        };
        let scalars: &[bool] = match request.version {
            Version::Fmi2 => &[false],
            Version::Fmi3 => &[false, true],
        };
        let mut found = None;
        'tables: for accounts in [None, Some(false), Some(true)] {
            for &scalars in scalars {
                let arrays = accounts.map_or_else(plain, |accounts| exchanged(&mut plant, accounts));
                let interface = if scalars { arrays.in_scalars() } else { arrays };
                let guid = token(&interface);
                if given == guid {
                    found = Some((interface, guid));
                    break 'tables;
                }
            }
        }
        match found {
            Some((interface, guid)) => Ok(Self { machine, plant, interface, guid }),
            None => Err(InstantiationError::Guid { given: given.to_owned(), own: token(&plain()) }),
        }
    }
}

/// Creates a plant that computes outputs only when they are read.
fn unwatched(machine: &Arc<Machine>) -> Plant {
    let mut plant = Plant::new(Arc::clone(machine));
    plant.watch(OutputSet::NONE);
    plant
}

/// Experiment if the importer gives none.
fn default_experiment(machine: &Machine) -> Experiment {
    Experiment { start_s: machine.experiment.start_time_s, stop_s: None }
}

#[cfg(test)]
mod tests;
