//! The life cycle as a table: which call is legal where (FMI 2.0.4, section 4.2.4).

use serde::{Deserialize, Serialize};
use std::fmt;

/// Where an instance stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Fresh or reset.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// Between steps.
    StepComplete,
    /// A step failed: values can be read, an earlier state restored.
    StepFailed,
    /// After `fmi2Terminate`.
    Terminated,
    /// After a panic.
    Fatal,
}

impl Phase {
    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "before fmi2EnterInitializationMode",
            Self::Initialization => "in Initialization Mode",
            Self::StepComplete => "after fmi2ExitInitializationMode",
            Self::StepFailed => "after a failed step",
            Self::Terminated => "after fmi2Terminate",
            Self::Fatal => "after a breakdown",
        })
    }
}

const INSTANTIATED: u8 = Phase::Instantiated.bit();
const INITIALIZATION: u8 = Phase::Initialization.bit();
const COMPLETE: u8 = Phase::StepComplete.bit();
const FAILED: u8 = Phase::StepFailed.bit();
const TERMINATED: u8 = Phase::Terminated.bit();
const ANY: u8 = INSTANTIATED | INITIALIZATION | COMPLETE | FAILED | TERMINATED;
const GET: u8 = INITIALIZATION | COMPLETE | FAILED | TERMINATED;
const SET: u8 = INSTANTIATED | INITIALIZATION | COMPLETE;
const NEVER: u8 = 0;

/// A call on an instance; creating and freeing one are outside the life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is the function of the standard of that name")]
pub enum Call {
    SetDebugLogging,
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    GetReal,
    GetInteger,
    GetBoolean,
    GetString,
    SetReal,
    SetInteger,
    SetBoolean,
    SetString,
    GetFmuState,
    SetFmuState,
    FreeFmuState,
    SerializedFmuStateSize,
    SerializeFmuState,
    DeSerializeFmuState,
    GetDirectionalDerivative,
    SetRealInputDerivatives,
    GetRealOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
    GetRealStatus,
    GetIntegerStatus,
    GetBooleanStatus,
    GetStringStatus,
}

impl Call {
    /// The table: name in the standard and phases in which the call is legal.
    const fn row(self) -> (&'static str, u8) {
        match self {
            Self::SetDebugLogging => ("fmi2SetDebugLogging", ANY),
            Self::SetupExperiment => ("fmi2SetupExperiment", INSTANTIATED),
            Self::EnterInitializationMode => ("fmi2EnterInitializationMode", INSTANTIATED),
            Self::ExitInitializationMode => ("fmi2ExitInitializationMode", INITIALIZATION),
            Self::Terminate => ("fmi2Terminate", COMPLETE),
            Self::Reset => ("fmi2Reset", ANY),
            Self::GetReal => ("fmi2GetReal", GET),
            Self::GetInteger => ("fmi2GetInteger", GET),
            Self::GetBoolean => ("fmi2GetBoolean", GET),
            Self::GetString => ("fmi2GetString", GET),
            Self::SetReal => ("fmi2SetReal", SET),
            Self::SetInteger => ("fmi2SetInteger", SET),
            Self::SetBoolean => ("fmi2SetBoolean", SET),
            Self::SetString => ("fmi2SetString", SET),
            Self::GetFmuState => ("fmi2GetFMUstate", ANY),
            Self::SetFmuState => ("fmi2SetFMUstate", ANY),
            Self::FreeFmuState => ("fmi2FreeFMUstate", ANY),
            Self::SerializedFmuStateSize => ("fmi2SerializedFMUstateSize", ANY),
            Self::SerializeFmuState => ("fmi2SerializeFMUstate", ANY),
            Self::DeSerializeFmuState => ("fmi2DeSerializeFMUstate", ANY),
            Self::GetDirectionalDerivative => ("fmi2GetDirectionalDerivative", GET),
            Self::SetRealInputDerivatives => ("fmi2SetRealInputDerivatives", SET),
            Self::GetRealOutputDerivatives => ("fmi2GetRealOutputDerivatives", COMPLETE | FAILED | TERMINATED),
            Self::DoStep => ("fmi2DoStep", COMPLETE),
            // Steps are never asynchronous, so there is never one to cancel.
            Self::CancelStep => ("fmi2CancelStep", NEVER),
            Self::GetStatus => ("fmi2GetStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetRealStatus => ("fmi2GetRealStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetIntegerStatus => ("fmi2GetIntegerStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetBooleanStatus => ("fmi2GetBooleanStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetStringStatus => ("fmi2GetStringStatus", COMPLETE | FAILED | TERMINATED),
        }
    }

    /// Name in the standard.
    pub const fn name(self) -> &'static str {
        self.row().0
    }

    /// Phases in which the call is legal, in the order in which they are passed.
    pub fn phases(self) -> impl Iterator<Item = Phase> {
        use Phase::{Initialization, Instantiated, StepComplete, StepFailed, Terminated};
        let all = [Instantiated, Initialization, StepComplete, StepFailed, Terminated];
        all.into_iter().filter(move |&phase| self.is_legal(phase))
    }

    /// Whether the call is legal in a phase.
    pub const fn is_legal(self, phase: Phase) -> bool {
        self.row().1 & phase.bit() != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_step_leaves_only_reading_restoring_and_resetting() {
        use Call as C;
        for call in [C::GetReal, C::GetRealStatus, C::SetFmuState, C::FreeFmuState, C::Reset] {
            assert!(call.is_legal(Phase::StepFailed), "{} must be legal after a failed step", call.name());
        }
        for call in [C::DoStep, C::SetReal, C::Terminate, C::SetupExperiment, C::EnterInitializationMode] {
            assert!(!call.is_legal(Phase::StepFailed), "{} must be refused after a failed step", call.name());
        }
    }

    #[test]
    fn nothing_is_legal_after_a_breakdown_and_no_step_can_be_cancelled() {
        assert!(!Call::Reset.is_legal(Phase::Fatal));
        assert!(!Call::GetReal.is_legal(Phase::Fatal));
        for phase in [Phase::Instantiated, Phase::Initialization, Phase::StepComplete, Phase::StepFailed] {
            assert!(!Call::CancelStep.is_legal(phase));
        }
    }
}
