//! Phases of an instance, and the rules of the life cycle.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Version of the standard of an instance. Its `Display` form is the prefix of the standard's functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fmi2 => "fmi2",
            Self::Fmi3 => "fmi3",
        })
    }
}

impl Version {
    /// Function that restores a saved state.
    pub(crate) fn restoring_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2SetFMUstate",
            Self::Fmi3 => "fmi3SetFMUState",
        }
    }

    /// Name of the argument with the number of continuous states.
    pub(crate) fn states_argument(self) -> &'static str {
        match self {
            Self::Fmi2 => "nx",
            Self::Fmi3 => "nContinuousStates",
        }
    }

    /// Name of the argument with the number of event indicators.
    pub(crate) fn indicators_argument(self) -> &'static str {
        match self {
            Self::Fmi2 => "ni",
            Self::Fmi3 => "nEventIndicators",
        }
    }

    /// Function that executes a step.
    pub(crate) fn step_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2DoStep",
            Self::Fmi3 => "fmi3DoStep",
        }
    }

    /// Name of the function that executes the transitions of an event.
    pub(crate) fn event_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2NewDiscreteStates",
            Self::Fmi3 => "fmi3UpdateDiscreteStates",
        }
    }

    /// Name of the function that sets the times of the experiment.
    pub(crate) fn experiment_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2SetupExperiment",
            Self::Fmi3 => "fmi3EnterInitializationMode",
        }
    }
}

/// Phase of the life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// After instantiation or reset.
    Instantiated,
    /// Initialization Mode.
    Initialization,
    /// Between steps: Step Mode of FMI 3.0.
    StepComplete,
    /// A step failed: values can be read, an earlier state can be restored.
    StepFailed,
    /// After the end of the simulation.
    Terminated,
    /// After a panic.
    Fatal,
    /// Event Mode: at an event, or directly after Initialization Mode.
    Event,
    /// Continuous-Time Mode of Model Exchange: the importer integrates.
    ContinuousTime,
    /// FMI 3.0 co-simulation: intermediate update within a step.
    IntermediateUpdate,
}

impl Phase {
    /// Bit in the masks of a [`Rule`].
    pub const fn bit(self) -> u16 {
        1 << self as u16
    }

    /// Returns whether instances of an interface type have this phase.
    pub fn belongs_to(self, kind: InterfaceKind, version: Version) -> bool {
        match self {
            Self::StepComplete | Self::StepFailed => kind == InterfaceKind::CoSimulation,
            Self::ContinuousTime => kind == InterfaceKind::ModelExchange,
            Self::Event => kind == InterfaceKind::ModelExchange || version == Version::Fmi3,
            Self::IntermediateUpdate => kind == InterfaceKind::CoSimulation && version == Version::Fmi3,
            Self::Instantiated | Self::Initialization | Self::Terminated | Self::Fatal => true,
        }
    }

    /// Phrase for messages.
    pub fn phrase(self, version: Version) -> String {
        match (self, version) {
            (Self::Instantiated, _) => format!("before {version}EnterInitializationMode"),
            (Self::Initialization, _) => "in Initialization Mode".to_owned(),
            (Self::StepComplete, Version::Fmi2) => "after fmi2ExitInitializationMode".to_owned(),
            (Self::StepComplete, Version::Fmi3) => "in Step Mode".to_owned(),
            (Self::StepFailed, _) => "after a failed step".to_owned(),
            (Self::Terminated, _) => format!("after {version}Terminate"),
            (Self::Fatal, _) => "after a breakdown".to_owned(),
            (Self::Event, _) => "in Event Mode".to_owned(),
            (Self::ContinuousTime, _) => "in Continuous-Time Mode".to_owned(),
            (Self::IntermediateUpdate, _) => "in Intermediate Update Mode".to_owned(),
        }
    }
}

/// Interface type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum InterfaceKind {
    /// Co-simulation: the instance integrates.
    CoSimulation,
    /// Model Exchange: the importer integrates.
    ModelExchange,
}

impl fmt::Display for InterfaceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CoSimulation => "co-simulation",
            Self::ModelExchange => "Model Exchange",
        })
    }
}

/// Rule of the life cycle for one function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rule {
    /// Name in the standard.
    pub name: &'static str,
    /// Version of the standard.
    pub version: Version,
    /// Interface type of the function; `None` if it belongs to both.
    pub kind: Option<InterfaceKind>,
    /// Phases in which it is legal, by [`Phase::bit`].
    pub phases: u16,
    /// Reason why a function is legal in no phase.
    pub never: &'static str,
}

impl Rule {
    /// Returns whether the function is legal in a phase.
    pub const fn is_legal(self, phase: Phase) -> bool {
        self.phases & phase.bit() != 0
    }

    /// Phases in which the function is legal for an interface type, in the order of the life cycle.
    pub fn legal_phases(self, kind: InterfaceKind) -> impl Iterator<Item = Phase> {
        use Phase::{
            ContinuousTime, Event, Initialization, Instantiated, IntermediateUpdate, StepComplete, StepFailed,
            Terminated,
        };
        let all = [
            Instantiated,
            Initialization,
            Event,
            ContinuousTime,
            StepComplete,
            IntermediateUpdate,
            StepFailed,
            Terminated,
        ];
        all.into_iter().filter(move |&phase| phase.belongs_to(kind, self.version) && self.is_legal(phase))
    }

    /// Error text for a call in a phase in which the function is not legal.
    pub(super) fn refusal(self, kind: InterfaceKind, phase: Phase) -> String {
        let here = format!("not legal {}", phase.phrase(self.version));
        if let Some(other) = self.kind.filter(|&other| other != kind) {
            return format!("{here}; it belongs to {other}, and this instance is for {kind}");
        }
        let legal: Vec<String> = self.legal_phases(kind).map(|phase| phase.phrase(self.version)).collect();
        if legal.is_empty() {
            return format!("{here}: {}", self.never);
        }
        let back = match phase {
            Phase::StepFailed | Phase::Terminated => {
                format!("; {} with an earlier state or {}Reset leads back", self.version.restoring_call(), self.version)
            }
            // a function of the first phase alone names itself as the end of it
            Phase::Initialization | Phase::StepComplete | Phase::Event | Phase::ContinuousTime
                if self.legal_phases(kind).eq([Phase::Instantiated]) =>
            {
                format!("; {}Reset leads back", self.version)
            }
            Phase::Instantiated
            | Phase::Initialization
            | Phase::StepComplete
            | Phase::Fatal
            | Phase::Event
            | Phase::ContinuousTime
            | Phase::IntermediateUpdate => String::new(),
        };
        format!("{here}; it is legal {}{back}", legal.join(", "))
    }
}
