//! Table of the life cycle: phases in which each function is legal (FMI 2.0.4, sections 3.2.3 and 4.2.4).

use crate::instance::{InterfaceKind, Phase, Rule, Version};

const INSTANTIATED: u16 = Phase::Instantiated.bit();
const INITIALIZATION: u16 = Phase::Initialization.bit();
const COMPLETE: u16 = Phase::StepComplete.bit();
const FAILED: u16 = Phase::StepFailed.bit();
const TERMINATED: u16 = Phase::Terminated.bit();
const EVENT: u16 = Phase::Event.bit();
const CONTINUOUS: u16 = Phase::ContinuousTime.bit();
const EXCHANGING: u16 = EVENT | CONTINUOUS;
const ANY: u16 = INSTANTIATED | INITIALIZATION | COMPLETE | FAILED | TERMINATED | EXCHANGING;
const GET: u16 = INITIALIZATION | COMPLETE | FAILED | TERMINATED | EXCHANGING;
const SET: u16 = INSTANTIATED | INITIALIZATION | COMPLETE | EXCHANGING;
const STATES: u16 = INITIALIZATION | EXCHANGING | TERMINATED;
const NEVER: u16 = 0;

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
    EnterEventMode,
    NewDiscreteStates,
    EnterContinuousTimeMode,
    CompletedIntegratorStep,
    SetTime,
    SetContinuousStates,
    GetDerivatives,
    GetEventIndicators,
    GetContinuousStates,
    GetNominalsOfContinuousStates,
}

impl Call {
    /// The table: name in the standard and phases in which the call is legal.
    const fn row(self) -> (&'static str, u16) {
        match self {
            Self::SetDebugLogging => ("fmi2SetDebugLogging", ANY),
            Self::SetupExperiment => ("fmi2SetupExperiment", INSTANTIATED),
            Self::EnterInitializationMode => ("fmi2EnterInitializationMode", INSTANTIATED),
            Self::ExitInitializationMode => ("fmi2ExitInitializationMode", INITIALIZATION),
            Self::Terminate => ("fmi2Terminate", COMPLETE | EXCHANGING),
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
            Self::SetRealInputDerivatives => ("fmi2SetRealInputDerivatives", INSTANTIATED | INITIALIZATION | COMPLETE),
            Self::GetRealOutputDerivatives => ("fmi2GetRealOutputDerivatives", COMPLETE | FAILED | TERMINATED),
            Self::DoStep => ("fmi2DoStep", COMPLETE),
            // Steps are never asynchronous, so no step can be cancelled.
            Self::CancelStep => ("fmi2CancelStep", NEVER),
            Self::GetStatus => ("fmi2GetStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetRealStatus => ("fmi2GetRealStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetIntegerStatus => ("fmi2GetIntegerStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetBooleanStatus => ("fmi2GetBooleanStatus", COMPLETE | FAILED | TERMINATED),
            Self::GetStringStatus => ("fmi2GetStringStatus", COMPLETE | FAILED | TERMINATED),
            Self::EnterEventMode => ("fmi2EnterEventMode", EXCHANGING),
            Self::NewDiscreteStates => ("fmi2NewDiscreteStates", EVENT),
            Self::EnterContinuousTimeMode => ("fmi2EnterContinuousTimeMode", EVENT),
            Self::CompletedIntegratorStep => ("fmi2CompletedIntegratorStep", CONTINUOUS),
            Self::SetTime => ("fmi2SetTime", EXCHANGING),
            Self::SetContinuousStates => ("fmi2SetContinuousStates", CONTINUOUS),
            Self::GetDerivatives => ("fmi2GetDerivatives", STATES),
            Self::GetEventIndicators => ("fmi2GetEventIndicators", STATES),
            Self::GetContinuousStates => ("fmi2GetContinuousStates", STATES),
            Self::GetNominalsOfContinuousStates => ("fmi2GetNominalsOfContinuousStates", ANY ^ INITIALIZATION),
        }
    }

    /// Name in the standard.
    pub const fn name(self) -> &'static str {
        self.row().0
    }

    /// Interface type of the function; `None` if it belongs to both.
    const fn kind(self) -> Option<InterfaceKind> {
        match self {
            Self::EnterEventMode
            | Self::NewDiscreteStates
            | Self::EnterContinuousTimeMode
            | Self::CompletedIntegratorStep
            | Self::SetTime
            | Self::SetContinuousStates
            | Self::GetDerivatives
            | Self::GetEventIndicators
            | Self::GetContinuousStates
            | Self::GetNominalsOfContinuousStates => Some(InterfaceKind::ModelExchange),
            Self::SetRealInputDerivatives
            | Self::GetRealOutputDerivatives
            | Self::DoStep
            | Self::CancelStep
            | Self::GetStatus
            | Self::GetRealStatus
            | Self::GetIntegerStatus
            | Self::GetBooleanStatus
            | Self::GetStringStatus => Some(InterfaceKind::CoSimulation),
            Self::SetDebugLogging
            | Self::SetupExperiment
            | Self::EnterInitializationMode
            | Self::ExitInitializationMode
            | Self::Terminate
            | Self::Reset
            | Self::GetReal
            | Self::GetInteger
            | Self::GetBoolean
            | Self::GetString
            | Self::SetReal
            | Self::SetInteger
            | Self::SetBoolean
            | Self::SetString
            | Self::GetFmuState
            | Self::SetFmuState
            | Self::FreeFmuState
            | Self::SerializedFmuStateSize
            | Self::SerializeFmuState
            | Self::DeSerializeFmuState
            | Self::GetDirectionalDerivative => None,
        }
    }

    /// Rule of the life cycle for the function.
    pub const fn rule(self) -> Rule {
        let (name, phases) = self.row();
        let never = "asynchronous steps are not supported, so no step can be cancelled";
        Rule { name, version: Version::Fmi2, kind: self.kind(), phases, never }
    }

    /// Returns whether the function is legal in a phase.
    pub const fn is_legal(self, phase: Phase) -> bool {
        self.row().1 & phase.bit() != 0
    }
}

impl From<Call> for Rule {
    fn from(call: Call) -> Self {
        call.rule()
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
