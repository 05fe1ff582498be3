//! Compile-time proof that the exported functions have the types of the official headers of FMI 3.0, using the bindings that bindgen
//! generates from them (crate `fmi`). A difference in any argument or result does not compile.

use super::types::{
    fmi3Binary, fmi3Boolean, fmi3Byte, fmi3Char, fmi3Clock, fmi3ClockUpdateCallback, fmi3DependencyKind, fmi3FMUState,
    fmi3Float32, fmi3Float64, fmi3Instance, fmi3InstanceEnvironment, fmi3Int8, fmi3Int16, fmi3Int32, fmi3Int64,
    fmi3IntermediateUpdateCallback, fmi3IntervalQualifier, fmi3LockPreemptionCallback, fmi3LogMessageCallback,
    fmi3Status, fmi3String, fmi3UInt8, fmi3UInt16, fmi3UInt32, fmi3UInt64, fmi3UnlockPreemptionCallback,
    fmi3ValueReference,
};
use super::{clocks, derivatives, exchange, functions, states, steps, values};
use crate::official::{have_the_official_type, same_types, same_values};
use crate::types;
use fmi::fmi3::binding;

have_the_official_type! {
    functions::fmi3EnterInitializationMode: fmi3EnterInitializationModeTYPE;
    functions::fmi3ExitInitializationMode: fmi3ExitInitializationModeTYPE;
    functions::fmi3FreeInstance: fmi3FreeInstanceTYPE;
    functions::fmi3GetVersion: fmi3GetVersionTYPE;
    functions::fmi3InstantiateCoSimulation: fmi3InstantiateCoSimulationTYPE;
    functions::fmi3InstantiateModelExchange: fmi3InstantiateModelExchangeTYPE;
    functions::fmi3InstantiateScheduledExecution: fmi3InstantiateScheduledExecutionTYPE;
    functions::fmi3Reset: fmi3ResetTYPE;
    functions::fmi3SetDebugLogging: fmi3SetDebugLoggingTYPE;
    functions::fmi3Terminate: fmi3TerminateTYPE;
    states::fmi3DeserializeFMUState: fmi3DeserializeFMUStateTYPE;
    states::fmi3FreeFMUState: fmi3FreeFMUStateTYPE;
    states::fmi3GetFMUState: fmi3GetFMUStateTYPE;
    states::fmi3SerializeFMUState: fmi3SerializeFMUStateTYPE;
    states::fmi3SerializedFMUStateSize: fmi3SerializedFMUStateSizeTYPE;
    states::fmi3SetFMUState: fmi3SetFMUStateTYPE;
    derivatives::fmi3GetAdjointDerivative: fmi3GetAdjointDerivativeTYPE;
    derivatives::fmi3GetDirectionalDerivative: fmi3GetDirectionalDerivativeTYPE;
    derivatives::fmi3GetOutputDerivatives: fmi3GetOutputDerivativesTYPE;
    exchange::fmi3CompletedIntegratorStep: fmi3CompletedIntegratorStepTYPE;
    exchange::fmi3EnterContinuousTimeMode: fmi3EnterContinuousTimeModeTYPE;
    exchange::fmi3EnterEventMode: fmi3EnterEventModeTYPE;
    exchange::fmi3GetContinuousStateDerivatives: fmi3GetContinuousStateDerivativesTYPE;
    exchange::fmi3GetContinuousStates: fmi3GetContinuousStatesTYPE;
    exchange::fmi3GetEventIndicators: fmi3GetEventIndicatorsTYPE;
    exchange::fmi3GetNominalsOfContinuousStates: fmi3GetNominalsOfContinuousStatesTYPE;
    exchange::fmi3GetNumberOfContinuousStates: fmi3GetNumberOfContinuousStatesTYPE;
    exchange::fmi3GetNumberOfEventIndicators: fmi3GetNumberOfEventIndicatorsTYPE;
    exchange::fmi3SetContinuousStates: fmi3SetContinuousStatesTYPE;
    exchange::fmi3SetTime: fmi3SetTimeTYPE;
    exchange::fmi3UpdateDiscreteStates: fmi3UpdateDiscreteStatesTYPE;
    steps::fmi3DoStep: fmi3DoStepTYPE;
    steps::fmi3EnterStepMode: fmi3EnterStepModeTYPE;
    values::fmi3GetBinary: fmi3GetBinaryTYPE;
    values::fmi3GetBoolean: fmi3GetBooleanTYPE;
    values::fmi3GetClock: fmi3GetClockTYPE;
    values::fmi3GetFloat32: fmi3GetFloat32TYPE;
    values::fmi3GetFloat64: fmi3GetFloat64TYPE;
    values::fmi3GetInt16: fmi3GetInt16TYPE;
    values::fmi3GetInt32: fmi3GetInt32TYPE;
    values::fmi3GetInt64: fmi3GetInt64TYPE;
    values::fmi3GetInt8: fmi3GetInt8TYPE;
    values::fmi3GetString: fmi3GetStringTYPE;
    values::fmi3GetUInt16: fmi3GetUInt16TYPE;
    values::fmi3GetUInt32: fmi3GetUInt32TYPE;
    values::fmi3GetUInt64: fmi3GetUInt64TYPE;
    values::fmi3GetUInt8: fmi3GetUInt8TYPE;
    values::fmi3SetBinary: fmi3SetBinaryTYPE;
    values::fmi3SetBoolean: fmi3SetBooleanTYPE;
    values::fmi3SetClock: fmi3SetClockTYPE;
    values::fmi3SetFloat32: fmi3SetFloat32TYPE;
    values::fmi3SetFloat64: fmi3SetFloat64TYPE;
    values::fmi3SetInt16: fmi3SetInt16TYPE;
    values::fmi3SetInt32: fmi3SetInt32TYPE;
    values::fmi3SetInt64: fmi3SetInt64TYPE;
    values::fmi3SetInt8: fmi3SetInt8TYPE;
    values::fmi3SetString: fmi3SetStringTYPE;
    values::fmi3SetUInt16: fmi3SetUInt16TYPE;
    values::fmi3SetUInt32: fmi3SetUInt32TYPE;
    values::fmi3SetUInt64: fmi3SetUInt64TYPE;
    values::fmi3SetUInt8: fmi3SetUInt8TYPE;
    clocks::fmi3ActivateModelPartition: fmi3ActivateModelPartitionTYPE;
    clocks::fmi3EnterConfigurationMode: fmi3EnterConfigurationModeTYPE;
    clocks::fmi3EvaluateDiscreteStates: fmi3EvaluateDiscreteStatesTYPE;
    clocks::fmi3ExitConfigurationMode: fmi3ExitConfigurationModeTYPE;
    clocks::fmi3GetIntervalDecimal: fmi3GetIntervalDecimalTYPE;
    clocks::fmi3GetIntervalFraction: fmi3GetIntervalFractionTYPE;
    clocks::fmi3GetNumberOfVariableDependencies: fmi3GetNumberOfVariableDependenciesTYPE;
    clocks::fmi3GetShiftDecimal: fmi3GetShiftDecimalTYPE;
    clocks::fmi3GetShiftFraction: fmi3GetShiftFractionTYPE;
    clocks::fmi3GetVariableDependencies: fmi3GetVariableDependenciesTYPE;
    clocks::fmi3SetIntervalDecimal: fmi3SetIntervalDecimalTYPE;
    clocks::fmi3SetIntervalFraction: fmi3SetIntervalFractionTYPE;
    clocks::fmi3SetShiftDecimal: fmi3SetShiftDecimalTYPE;
    clocks::fmi3SetShiftFraction: fmi3SetShiftFractionTYPE;
}

same_types! {
    fmi3Instance;
    fmi3InstanceEnvironment;
    fmi3FMUState;
    fmi3ValueReference;
    fmi3Float32;
    fmi3Float64;
    fmi3Int8;
    fmi3UInt8;
    fmi3Int16;
    fmi3UInt16;
    fmi3Int32;
    fmi3UInt32;
    fmi3Int64;
    fmi3UInt64;
    fmi3Boolean;
    fmi3Char;
    fmi3String;
    fmi3Byte;
    fmi3Binary;
    fmi3Clock;
    fmi3Status;
    fmi3DependencyKind;
    fmi3IntervalQualifier;
    fmi3LogMessageCallback;
    fmi3IntermediateUpdateCallback;
    fmi3ClockUpdateCallback;
    fmi3LockPreemptionCallback;
    fmi3UnlockPreemptionCallback;
}

// both versions return the statuses of one gate
same_values! {
    fmi2OK = fmi3Status_fmi3OK;
    fmi2Warning = fmi3Status_fmi3Warning;
    fmi2Discard = fmi3Status_fmi3Discard;
    fmi2Error = fmi3Status_fmi3Error;
    fmi2Fatal = fmi3Status_fmi3Fatal;
}

#[cfg(test)]
mod tests {
    use super::CHECKED;
    use foldwing_fmi::fmi3::FUNCTIONS;
    use std::collections::BTreeSet;

    /// The list above has every function of the standard.
    #[test]
    fn every_function_is_checked() {
        assert_eq!(CHECKED.len(), 75, "functions of FMI 3.0");
        assert_eq!(CHECKED.iter().collect::<BTreeSet<_>>(), FUNCTIONS.iter().collect::<BTreeSet<_>>());
    }
}
