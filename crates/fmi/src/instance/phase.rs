//! Where an instance stands, and what the life cycle says of a call.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Version of the standard that an instance speaks. Displayed, it is what the names of the standard's functions begin with.
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
    /// The call that brings a saved state back.
    pub(crate) fn restoring_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2SetFMUstate",
            Self::Fmi3 => "fmi3SetFMUState",
        }
    }

    /// Argument that counts continuous states.
    pub(crate) fn states_argument(self) -> &'static str {
        match self {
            Self::Fmi2 => "nx",
            Self::Fmi3 => "nContinuousStates",
        }
    }

    /// Argument that counts event indicators.
    pub(crate) fn indicators_argument(self) -> &'static str {
        match self {
            Self::Fmi2 => "ni",
            Self::Fmi3 => "nEventIndicators",
        }
    }

    /// The call that takes a step.
    pub(crate) fn step_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2DoStep",
            Self::Fmi3 => "fmi3DoStep",
        }
    }

    /// The call that makes the transitions of an event.
    pub(crate) fn event_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2NewDiscreteStates",
            Self::Fmi3 => "fmi3UpdateDiscreteStates",
        }
    }

    /// The call that gives the times of the experiment.
    pub(crate) fn experiment_call(self) -> &'static str {
        match self {
            Self::Fmi2 => "fmi2SetupExperiment",
            Self::Fmi3 => "fmi3EnterInitializationMode",
        }
    }
}

/// Where an instance stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Fresh or reset.
    Instantiated,
    /// Initialization Mode.
    Initialization,
    /// Between steps: Step Mode of FMI 3.0.
    StepComplete,
    /// A step failed: values can be read, an earlier state restored.
    StepFailed,
    /// After the end of the simulation.
    Terminated,
    /// After a panic.
    Fatal,
    /// Event Mode: an event, or the first of them after Initialization Mode.
    Event,
    /// Model Exchange: the importer integrates.
    ContinuousTime,
    /// FMI 3.0 co-simulation: the importer is told of a time within a step.
    IntermediateUpdate,
}

impl Phase {
    /// Its place in the masks of a [`Rule`].
    pub const fn bit(self) -> u16 {
        1 << self as u16
    }

    /// Whether instances of a kind ever stand here.
    pub fn belongs_to(self, kind: InterfaceKind, version: Version) -> bool {
        match self {
            Self::StepComplete | Self::StepFailed => kind == InterfaceKind::CoSimulation,
            Self::ContinuousTime => kind == InterfaceKind::ModelExchange,
            Self::Event => kind == InterfaceKind::ModelExchange || version == Version::Fmi3,
            Self::IntermediateUpdate => kind == InterfaceKind::CoSimulation && version == Version::Fmi3,
            Self::Instantiated | Self::Initialization | Self::Terminated | Self::Fatal => true,
        }
    }

    /// As messages name it.
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

/// Who integrates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum InterfaceKind {
    /// The instance.
    CoSimulation,
    /// The importer.
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

/// A call as the life cycle sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rule {
    /// Name in the standard.
    pub name: &'static str,
    /// Version of the standard.
    pub version: Version,
    /// The kind of instance that the call is for, where it is not for either.
    pub kind: Option<InterfaceKind>,
    /// Phases in which it is legal, by [`Phase::bit`].
    pub phases: u16,
    /// Why a call that is legal nowhere is so.
    pub never: &'static str,
}

impl Rule {
    /// Whether the call is legal in a phase.
    pub const fn is_legal(self, phase: Phase) -> bool {
        self.phases & phase.bit() != 0
    }

    /// Phases in which the call is legal for an instance of a kind, in the order in which they are passed.
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

    /// What to say of the call in a phase in which it is not legal.
    pub(super) fn refusal(self, kind: InterfaceKind, phase: Phase) -> String {
        let here = format!("not legal {}", phase.phrase(self.version));
        if let Some(other) = self.kind.filter(|&other| other != kind) {
            return format!("{here}; it belongs to {other}, and the instance was made for {kind}");
        }
        let legal: Vec<String> = self.legal_phases(kind).map(|phase| phase.phrase(self.version)).collect();
        if legal.is_empty() {
            return format!("{here}: {}", self.never);
        }
        let back = match phase {
            Phase::StepFailed | Phase::Terminated => {
                format!("; {} with an earlier state or {}Reset leads back", self.version.restoring_call(), self.version)
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
