//! Errors of calls.

use crate::instance::phase::{InterfaceKind, Phase, Rule, Version};
use crate::instance::resource::ResourceError;
use crate::instance::state::StateError;
use crate::instance::status::Status;
use crate::interface::AccessError;
use foldwing_engine::plant::{NotHybrid, PlantError};
use foldwing_file::ConfigError;

/// Error of a call.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// The call is illegal in this phase.
    #[error("{}", call.refusal(*kind, *phase))]
    OutOfOrder {
        /// The call.
        call: Rule,
        /// Interface type of the instance.
        kind: InterfaceKind,
        /// Phase of the instance.
        phase: Phase,
    },
    /// Any call after a panic.
    #[error("an internal error occurred in this instance earlier; only {version}FreeInstance is legal")]
    Poisoned {
        /// Version of the standard.
        version: Version,
    },
    /// A pointer that must not be null.
    #[error("argument {argument} is null; this is allowed only for a length of 0")]
    NullPointer {
        /// Name of the argument in the standard.
        argument: &'static str,
    },
    /// Text that is not UTF-8.
    #[error("argument {argument} is not UTF-8 text")]
    NotText {
        /// Name of the argument in the standard.
        argument: &'static str,
    },
    /// A variable cannot be read or written by this function.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// The derivatives would not include the aerodynamics.
    #[error(
        "no directional derivatives with aerodynamics: the aerodynamic loads would be held constant, and the derivatives \
         wrong; use differences of steps from one saved state"
    )]
    DerivativesInAir,
    /// The variable may not change during the integration.
    #[error(
        "variable {name} cannot be set {}: only continuous inputs can; set it in Event Mode, after {version}EnterEventMode", phase.phrase(*version)
    )]
    OnlyContinuousInputs {
        /// Version of the standard.
        version: Version,
        /// Phase of the instance.
        phase: Phase,
        /// Name of the variable.
        name: String,
    },
    /// Event Mode of co-simulation was not requested at instantiation.
    #[error("this instance was created without Event Mode: pass eventModeUsed = true to fmi3InstantiateCoSimulation")]
    NoEventMode,
    /// The integrator sets a time before an event.
    #[error(
        "time {time_s} s lies before the last event or the start, at {event_s} s: latches and other states of events would be those of \
         the future; restore a state of the FMU saved before the event with {}", version.restoring_call()
    )]
    BeforeEvent {
        /// Version of the standard.
        version: Version,
        /// The rejected time in s.
        time_s: f64,
        /// Time of the event in s.
        event_s: f64,
    },
    /// The value of a state is not finite.
    #[error("continuous state {name} cannot be {value}: the value must be finite")]
    StateNotFinite {
        /// Name of the state.
        name: String,
        /// The rejected value.
        value: f64,
    },
    /// The number of states or indicators differs from the model description.
    #[error("argument {argument} is {given}: this model has {own}")]
    Count {
        /// Name of the argument in the standard.
        argument: &'static str,
        /// The rejected number.
        given: usize,
        /// The correct number.
        own: usize,
    },
    /// There are no derivatives at the states set by the integrator.
    #[error(
        "no derivatives at these states, of which {state} = {value:e} is farthest from its nominal magnitude: {}; let the integrator take a \
         shorter step from the last states, or integrate with an implicit method", cause.at_set_states()
    )]
    NoDerivatives {
        /// The cause.
        cause: PlantError,
        /// Name of the state with the largest ratio to its nominal magnitude.
        state: String,
        /// Its value.
        value: f64,
    },
    /// There are no derivatives at all.
    #[error("no Model Exchange: {0}")]
    NotHybrid(#[from] NotHybrid),
    /// An argument has an invalid value.
    #[error("argument {argument} is {value}: it must be {allowed}")]
    Argument {
        /// Name of the argument in the standard.
        argument: &'static str,
        /// The rejected value.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The step size is zero, negative or not finite.
    #[error("the step from t = {time_s} s has the size {step_s} s: it must be positive, finite and advance the time")]
    StepSize {
        /// Communication point of the caller in s.
        time_s: f64,
        /// The rejected step size in s.
        step_s: f64,
    },
    /// The step is longer than the limit.
    #[error(
        "the step from t = {time_s} s has the size {step_s:e} s: the maximum is {longest_s:e} s; take shorter steps"
    )]
    StepTooLong {
        /// Communication point of the caller in s.
        time_s: f64,
        /// The rejected step size in s.
        step_s: f64,
        /// Longest step in s allowed by the limit on internal steps.
        longest_s: f64,
    },
    /// The communication point differs from the time of the instance.
    #[error(
        "the step starts at t = {time_s} s but the instance is at t = {own_s} s; step from there, or set an earlier state"
    )]
    TimeMismatch {
        /// Communication point of the caller in s.
        time_s: f64,
        /// Time of the instance in s.
        own_s: f64,
    },
    /// The step ends after the stop time.
    #[error(
        "the step ends at t = {end_s} s, beyond the stop time {stop_s} s given to {}; shorten it, or reset and give a later stop time", version.experiment_call()
    )]
    BeyondStop {
        /// Version of the standard.
        version: Version,
        /// End of the rejected step in s.
        end_s: f64,
        /// Stop time in s.
        stop_s: f64,
    },
    /// The simulation of the model failed.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A saved state is invalid.
    #[error(transparent)]
    State(#[from] StateError),
    /// The function does not report this status kind.
    #[error("status kind {kind} is not reported by this function; it reports {reported}")]
    StatusKind {
        /// The requested kind.
        kind: u32,
        /// The reported kinds.
        reported: &'static str,
    },
    /// The log category does not exist.
    #[error("unknown log category {name:?}; allowed are {known}")]
    LogCategory {
        /// The unknown name.
        name: String,
        /// All names.
        known: String,
    },
}

impl CallError {
    /// Status returned to the importer: `Discard` for a bad value, else `Error`.
    pub fn status(&self) -> Status {
        match self {
            Self::Access(error) if error.is_bad_value() => Status::Discard,
            Self::Argument { .. }
            | Self::BeforeEvent { .. }
            | Self::StateNotFinite { .. }
            | Self::NoDerivatives { .. } => Status::Discard,
            Self::Poisoned { .. } => Status::Fatal,
            Self::OutOfOrder { .. }
            | Self::NullPointer { .. }
            | Self::NotText { .. }
            | Self::Access(_)
            | Self::DerivativesInAir
            | Self::OnlyContinuousInputs { .. }
            | Self::NoEventMode
            | Self::Count { .. }
            | Self::NotHybrid(_)
            | Self::StepSize { .. }
            | Self::StepTooLong { .. }
            | Self::TimeMismatch { .. }
            | Self::BeyondStop { .. }
            | Self::Plant(_)
            | Self::State(_)
            | Self::StatusKind { .. }
            | Self::LogCategory { .. } => Status::Error,
        }
    }
}

/// Error of an instantiation.
#[derive(Debug, thiserror::Error)]
pub enum InstantiationError {
    /// No instance name.
    #[error("the instance name is missing: it is null or empty")]
    NoName,
    /// Neither co-simulation nor Model Exchange.
    #[error("FMU type {0} is unknown; allowed are 0 (Model Exchange) and 1 (co-simulation)")]
    WrongType(u32),
    /// Scheduled Execution, which exists in FMI 3.0 only.
    #[error("no Scheduled Execution: this FMU has no clocks; instantiate it for co-simulation")]
    NoScheduledExecution,
    /// Packaged without Model Exchange.
    #[error("this FMU is for co-simulation only: Model Exchange was requested; package it with --interface cs,me")]
    NoModelExchange,
    /// The model description does not belong to the model file.
    #[error(
        "the GUID {given} of the model description differs from {own}, which this library computes for \
         resources/model.toml; package the model again"
    )]
    Guid {
        /// GUID passed by the importer.
        given: String,
        /// GUID computed from the model.
        own: String,
    },
    /// The resource folder cannot be used.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The model file is invalid.
    #[error("the model cannot be read: {0}")]
    Model(#[from] ConfigError),
}
