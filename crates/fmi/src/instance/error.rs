//! What a call can answer, and why it was refused.

use crate::instance::phase::{InterfaceKind, Phase, Rule, Version};
use crate::instance::resource::ResourceError;
use crate::instance::state::StateError;
use crate::interface::AccessError;
use foldwing_engine::plant::{NotHybrid, PlantError};
use foldwing_file::ConfigError;

/// Outcome of a call: the statuses that both versions of the standard know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// Done.
    Ok,
    /// Done, with something to tell.
    Warning,
    /// A value was refused; nothing changed.
    Discard,
    /// The call was refused or failed.
    Error,
    /// The instance is lost.
    Fatal,
}

/// Why a call was refused or failed.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// Out of order.
    #[error("{}", call.refusal(*kind, *phase))]
    OutOfOrder {
        /// The call.
        call: Rule,
        /// What the instance was made for.
        kind: InterfaceKind,
        /// Where the instance stands.
        phase: Phase,
    },
    /// Any call after a panic.
    #[error("the instance broke down earlier; only {version}FreeInstance is legal")]
    Poisoned {
        /// Version of the standard.
        version: Version,
    },
    /// A pointer that must not be null.
    #[error("argument {argument} is null; that is legal for a length of 0 only")]
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
    /// A variable cannot be read or written so.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// Derivatives that would leave the air out.
    #[error(
        "no directional derivatives with aerodynamics: the aerodynamic loads would be held constant, and the derivatives wrong; use differences of steps from one saved state"
    )]
    DerivativesInAir,
    /// What may not change while the importer integrates.
    #[error(
        "variable {name} cannot be set {}: only continuous inputs can; set it in Event Mode, after {version}EnterEventMode", phase.phrase(*version)
    )]
    OnlyContinuousInputs {
        /// Version of the standard.
        version: Version,
        /// Where the instance stands.
        phase: Phase,
        /// Name of the variable.
        name: String,
    },
    /// Event Mode of co-simulation, which the importer has not asked for.
    #[error("this instance was made without Event Mode: pass eventModeUsed = true to fmi3InstantiateCoSimulation")]
    NoEventMode,
    /// A state that is no number.
    #[error("continuous state {name} cannot be {value}: the value must be finite")]
    StateNotFinite {
        /// Name of the state.
        name: String,
        /// The refused value.
        value: f64,
    },
    /// Another number of states or indicators than the description says.
    #[error("argument {argument} is {given}: this model has {own}")]
    Count {
        /// Name of the argument in the standard.
        argument: &'static str,
        /// The refused number.
        given: usize,
        /// The right one.
        own: usize,
    },
    /// The integrator has led where there is no motion.
    #[error(
        "no derivatives at these states, of which {state} = {value:e} is farthest from its nominal magnitude: {}; let the integrator take a \
         shorter step from the last states, or integrate with an implicit method", cause.at_set_states()
    )]
    NoDerivatives {
        /// Why there are none.
        cause: PlantError,
        /// Name of the state that is largest over its nominal magnitude.
        state: String,
        /// Its value.
        value: f64,
    },
    /// No derivatives at all.
    #[error("no Model Exchange: {0}")]
    NotHybrid(#[from] NotHybrid),
    /// An argument that is not a variable.
    #[error("argument {argument} is {value}: it must be {allowed}")]
    Argument {
        /// Name of the argument in the standard.
        argument: &'static str,
        /// The refused value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Step of zero, negative or no size.
    #[error("the step from t = {time_s} s has the size {step_s} s: it must be positive, finite and advance the time")]
    StepSize {
        /// Communication point of the caller in s.
        time_s: f64,
        /// The refused step size in s.
        step_s: f64,
    },
    /// Too long to be marched through.
    #[error(
        "the step from t = {time_s} s has the size {step_s:e} s: the maximum is {longest_s:e} s; take shorter steps"
    )]
    StepTooLong {
        /// Communication point of the caller in s.
        time_s: f64,
        /// The refused step size in s.
        step_s: f64,
        /// Longest step in s that the bound on internal steps leaves possible.
        longest_s: f64,
    },
    /// The caller's clock and ours differ.
    #[error(
        "the step starts at t = {time_s} s but the instance is at t = {own_s} s; step from there, or set an earlier state"
    )]
    TimeMismatch {
        /// Communication point of the caller in s.
        time_s: f64,
        /// Our time in s.
        own_s: f64,
    },
    /// Beyond the stop time.
    #[error(
        "the step ends at t = {end_s} s, beyond the stop time {stop_s} s given to {}; shorten it, or reset and give a later stop time", version.experiment_call()
    )]
    BeyondStop {
        /// Version of the standard.
        version: Version,
        /// End of the refused step in s.
        end_s: f64,
        /// Stop time in s.
        stop_s: f64,
    },
    /// The model cannot go on.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A saved state was refused.
    #[error(transparent)]
    State(#[from] StateError),
    /// A status kind that the function does not report.
    #[error("status kind {kind} is not reported by this function; it reports {reported}")]
    StatusKind {
        /// The kind asked for.
        kind: u32,
        /// What can be asked.
        reported: &'static str,
    },
    /// A log category that does not exist.
    #[error("unknown log category {name:?}: there are {known}")]
    LogCategory {
        /// The refused name.
        name: String,
        /// All names.
        known: String,
    },
}

impl CallError {
    /// The status that the importer gets: a bad value is discarded, all else is an error.
    pub fn status(&self) -> Status {
        match self {
            Self::Access(error) if error.is_bad_value() => Status::Discard,
            Self::Argument { .. } | Self::StateNotFinite { .. } | Self::NoDerivatives { .. } => Status::Discard,
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

/// Why there is no instance.
#[derive(Debug, thiserror::Error)]
pub enum InstantiationError {
    /// No instance name.
    #[error("the instance name is missing: it is null or empty")]
    NoName,
    /// Neither co-simulation nor Model Exchange.
    #[error("FMU type {0} is unknown: there are 0, Model Exchange, and 1, co-simulation")]
    WrongType(u32),
    /// FMI 3.0 alone knows it.
    #[error("no Scheduled Execution: this FMU has no clocks; instantiate it for co-simulation")]
    NoScheduledExecution,
    /// Packaged without Model Exchange.
    #[error("this FMU is for co-simulation only: Model Exchange was requested; package it with --interface cs,me")]
    NoModelExchange,
    /// Description and model do not belong together.
    #[error(
        "the GUID {given} of the model description is not {own}, that of resources/model.toml in this library; package the model again"
    )]
    Guid {
        /// As passed by the importer.
        given: String,
        /// As computed from the model.
        own: String,
    },
    /// The resource folder cannot be used.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The model file is wrong.
    #[error("the model cannot be read: {0}")]
    Model(#[from] ConfigError),
}
