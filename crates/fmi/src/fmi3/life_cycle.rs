//! Table of the life cycle: phases in which each function is legal (FMI 3.0.2, sections 2.3, 3.2 and 4.2).

use crate::instance::InterfaceKind::{self, CoSimulation, ModelExchange};
use crate::instance::{Phase, Rule, Version};

const INSTANTIATED: u16 = Phase::Instantiated.bit();
const INITIALIZATION: u16 = Phase::Initialization.bit();
const STEP: u16 = Phase::StepComplete.bit();
const FAILED: u16 = Phase::StepFailed.bit();
const TERMINATED: u16 = Phase::Terminated.bit();
const EVENT: u16 = Phase::Event.bit();
const CONTINUOUS: u16 = Phase::ContinuousTime.bit();
const INTERMEDIATE: u16 = Phase::IntermediateUpdate.bit();
/// All phases outside a step.
const ANY: u16 = INSTANTIATED | INITIALIZATION | STEP | FAILED | TERMINATED | EVENT | CONTINUOUS;
const READ: u16 = INITIALIZATION | STEP | FAILED | TERMINATED | EVENT | CONTINUOUS;
const GET: u16 = READ | INTERMEDIATE;
const SET: u16 = INSTANTIATED | INITIALIZATION | STEP | EVENT | CONTINUOUS;
const STATES: u16 = INITIALIZATION | EVENT | CONTINUOUS | TERMINATED;
const NEVER: u16 = 0;

/// Reasons why some functions are legal in no phase.
const NO_ELEMENTS: &str = "dependencies are given in the model description for whole arrays, not for single elements";
const NO_STRUCTURE: &str = "there are no structural parameters, so there is nothing to configure";
const NO_CLOCKS: &str = "there are no clocks";
const NO_DISCRETE: &str = "discrete states change in fmi3UpdateDiscreteStates only";

macro_rules! calls {
    ($($call:ident $name:literal $kind:expr, $phases:expr, $never:expr;)*) => {
        /// A call on an instance; creating and freeing one are outside the life cycle.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(missing_docs, reason = "each is the function of the standard of that name")]
        pub enum Call {
            $($call,)*
        }

        impl Call {
            /// All functions.
            pub const ALL: &[Self] = &[$(Self::$call,)*];

            /// The table: name in the standard, interface type, phases in which the function is legal, reason if there are none.
            const fn row(self) -> (&'static str, Option<InterfaceKind>, u16, &'static str) {
                match self {
                    $(Self::$call => ($name, $kind, $phases, $never),)*
                }
            }
        }

        /// Functions that an FMU must export.
        pub const FUNCTIONS: &[&str] = &[
            "fmi3GetVersion",
            "fmi3InstantiateModelExchange",
            "fmi3InstantiateCoSimulation",
            "fmi3InstantiateScheduledExecution",
            "fmi3FreeInstance",
            $($name,)*
        ];
    };
}

calls! {
    SetDebugLogging "fmi3SetDebugLogging" None, ANY, "";
    EnterInitializationMode "fmi3EnterInitializationMode" None, INSTANTIATED, "";
    ExitInitializationMode "fmi3ExitInitializationMode" None, INITIALIZATION, "";
    EnterEventMode "fmi3EnterEventMode" None, STEP | CONTINUOUS, "";
    Terminate "fmi3Terminate" None, STEP | EVENT | CONTINUOUS, "";
    Reset "fmi3Reset" None, ANY, "";
    GetFloat32 "fmi3GetFloat32" None, GET, "";
    GetFloat64 "fmi3GetFloat64" None, GET, "";
    GetInt8 "fmi3GetInt8" None, GET, "";
    GetUInt8 "fmi3GetUInt8" None, GET, "";
    GetInt16 "fmi3GetInt16" None, GET, "";
    GetUInt16 "fmi3GetUInt16" None, GET, "";
    GetInt32 "fmi3GetInt32" None, GET, "";
    GetUInt32 "fmi3GetUInt32" None, GET, "";
    GetInt64 "fmi3GetInt64" None, GET, "";
    GetUInt64 "fmi3GetUInt64" None, GET, "";
    GetBoolean "fmi3GetBoolean" None, GET, "";
    GetString "fmi3GetString" None, GET, "";
    GetBinary "fmi3GetBinary" None, GET, "";
    GetClock "fmi3GetClock" None, GET, "";
    SetFloat32 "fmi3SetFloat32" None, SET, "";
    SetFloat64 "fmi3SetFloat64" None, SET, "";
    SetInt8 "fmi3SetInt8" None, SET, "";
    SetUInt8 "fmi3SetUInt8" None, SET, "";
    SetInt16 "fmi3SetInt16" None, SET, "";
    SetUInt16 "fmi3SetUInt16" None, SET, "";
    SetInt32 "fmi3SetInt32" None, SET, "";
    SetUInt32 "fmi3SetUInt32" None, SET, "";
    SetInt64 "fmi3SetInt64" None, SET, "";
    SetUInt64 "fmi3SetUInt64" None, SET, "";
    SetBoolean "fmi3SetBoolean" None, SET, "";
    SetString "fmi3SetString" None, SET, "";
    SetBinary "fmi3SetBinary" None, SET, "";
    SetClock "fmi3SetClock" None, SET, "";
    GetNumberOfVariableDependencies "fmi3GetNumberOfVariableDependencies" None, NEVER, NO_ELEMENTS;
    GetVariableDependencies "fmi3GetVariableDependencies" None, NEVER, NO_ELEMENTS;
    GetFmuState "fmi3GetFMUState" None, ANY, "";
    SetFmuState "fmi3SetFMUState" None, ANY, "";
    FreeFmuState "fmi3FreeFMUState" None, ANY, "";
    SerializedFmuStateSize "fmi3SerializedFMUStateSize" None, ANY, "";
    SerializeFmuState "fmi3SerializeFMUState" None, ANY, "";
    DeserializeFmuState "fmi3DeserializeFMUState" None, ANY, "";
    GetDirectionalDerivative "fmi3GetDirectionalDerivative" None, READ, "";
    GetAdjointDerivative "fmi3GetAdjointDerivative" None, READ, "";
    EnterConfigurationMode "fmi3EnterConfigurationMode" None, NEVER, NO_STRUCTURE;
    ExitConfigurationMode "fmi3ExitConfigurationMode" None, NEVER, NO_STRUCTURE;
    GetIntervalDecimal "fmi3GetIntervalDecimal" None, NEVER, NO_CLOCKS;
    GetIntervalFraction "fmi3GetIntervalFraction" None, NEVER, NO_CLOCKS;
    GetShiftDecimal "fmi3GetShiftDecimal" None, NEVER, NO_CLOCKS;
    GetShiftFraction "fmi3GetShiftFraction" None, NEVER, NO_CLOCKS;
    SetIntervalDecimal "fmi3SetIntervalDecimal" None, NEVER, NO_CLOCKS;
    SetIntervalFraction "fmi3SetIntervalFraction" None, NEVER, NO_CLOCKS;
    SetShiftDecimal "fmi3SetShiftDecimal" None, NEVER, NO_CLOCKS;
    SetShiftFraction "fmi3SetShiftFraction" None, NEVER, NO_CLOCKS;
    EvaluateDiscreteStates "fmi3EvaluateDiscreteStates" None, NEVER, NO_DISCRETE;
    UpdateDiscreteStates "fmi3UpdateDiscreteStates" None, EVENT, "";
    EnterContinuousTimeMode "fmi3EnterContinuousTimeMode" Some(ModelExchange), EVENT, "";
    CompletedIntegratorStep "fmi3CompletedIntegratorStep" Some(ModelExchange), CONTINUOUS, "";
    SetTime "fmi3SetTime" Some(ModelExchange), EVENT | CONTINUOUS, "";
    SetContinuousStates "fmi3SetContinuousStates" Some(ModelExchange), CONTINUOUS, "";
    GetContinuousStateDerivatives "fmi3GetContinuousStateDerivatives" Some(ModelExchange), STATES, "";
    GetEventIndicators "fmi3GetEventIndicators" Some(ModelExchange), STATES, "";
    GetContinuousStates "fmi3GetContinuousStates" Some(ModelExchange), STATES, "";
    GetNominalsOfContinuousStates "fmi3GetNominalsOfContinuousStates" Some(ModelExchange), STATES, "";
    GetNumberOfEventIndicators "fmi3GetNumberOfEventIndicators" Some(ModelExchange), ANY, "";
    GetNumberOfContinuousStates "fmi3GetNumberOfContinuousStates" Some(ModelExchange), ANY, "";
    EnterStepMode "fmi3EnterStepMode" Some(CoSimulation), EVENT, "";
    GetOutputDerivatives "fmi3GetOutputDerivatives" Some(CoSimulation), STEP | FAILED | EVENT | TERMINATED | INTERMEDIATE, "";
    DoStep "fmi3DoStep" Some(CoSimulation), STEP, "";
    ActivateModelPartition "fmi3ActivateModelPartition" None, NEVER, NO_CLOCKS;
}

impl Call {
    /// Rule of the life cycle for the function.
    pub const fn rule(self) -> Rule {
        let (name, kind, phases, never) = self.row();
        Rule { name, version: Version::Fmi3, kind, phases, never }
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
    fn within_a_step_values_are_read_and_nothing_else_is_done() {
        let legal = |call: &&Call| call.rule().is_legal(Phase::IntermediateUpdate);
        for call in Call::ALL.iter().filter(legal) {
            assert!(call.rule().name.starts_with("fmi3Get"), "{call:?}");
        }
        assert_eq!(Call::ALL.iter().filter(legal).count(), 15, "14 types and output derivatives");
    }

    #[test]
    fn what_is_legal_nowhere_says_why() {
        for call in Call::ALL {
            let rule = call.rule();
            assert_eq!(rule.phases == NEVER, !rule.never.is_empty(), "{call:?}");
        }
        assert_eq!(FUNCTIONS.len(), Call::ALL.len() + 5);
    }
}
