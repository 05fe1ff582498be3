//! Compile-time proof that the exported functions have the types of the official headers, using the bindings that bindgen generates from
//! them (crate `fmi`). A difference in any argument, result or field does not compile.

use super::types::{
    fmi2Boolean, fmi2Byte, fmi2CallbackAllocateMemory, fmi2CallbackFreeMemory, fmi2CallbackFunctions,
    fmi2CallbackLogger, fmi2Component, fmi2FMUstate, fmi2Integer, fmi2Real, fmi2Status, fmi2StatusKind,
    fmi2StepFinished, fmi2String, fmi2Type, fmi2ValueReference,
};
use super::{derivatives, exchange, functions, states, status, types};
use fmi::fmi2::binding;
use std::mem::{align_of, offset_of, size_of};

/// One line per function: the exported function is coerced to the header's function-pointer type, which succeeds for equal types only (a
/// safe function may replace an unsafe one).
macro_rules! have_the_official_type {
    ($($module:ident::$function:ident: $official:ident;)*) => {
        $(const _: binding::$official = Some($module::$function);)*

        /// Functions whose type is checked against the header, except those that use structures.
        pub const CHECKED: &[&str] = &[$(stringify!($function)),*];
    };
}
pub(crate) use have_the_official_type;

have_the_official_type! {
    functions::fmi2GetTypesPlatform: fmi2GetTypesPlatformTYPE;
    functions::fmi2GetVersion: fmi2GetVersionTYPE;
    functions::fmi2SetDebugLogging: fmi2SetDebugLoggingTYPE;
    functions::fmi2FreeInstance: fmi2FreeInstanceTYPE;
    functions::fmi2SetupExperiment: fmi2SetupExperimentTYPE;
    functions::fmi2EnterInitializationMode: fmi2EnterInitializationModeTYPE;
    functions::fmi2ExitInitializationMode: fmi2ExitInitializationModeTYPE;
    functions::fmi2Terminate: fmi2TerminateTYPE;
    functions::fmi2Reset: fmi2ResetTYPE;
    functions::fmi2GetReal: fmi2GetRealTYPE;
    functions::fmi2GetInteger: fmi2GetIntegerTYPE;
    functions::fmi2GetBoolean: fmi2GetBooleanTYPE;
    functions::fmi2GetString: fmi2GetStringTYPE;
    functions::fmi2SetReal: fmi2SetRealTYPE;
    functions::fmi2SetInteger: fmi2SetIntegerTYPE;
    functions::fmi2SetBoolean: fmi2SetBooleanTYPE;
    functions::fmi2SetString: fmi2SetStringTYPE;
    functions::fmi2DoStep: fmi2DoStepTYPE;
    functions::fmi2CancelStep: fmi2CancelStepTYPE;
    states::fmi2GetFMUstate: fmi2GetFMUstateTYPE;
    states::fmi2SetFMUstate: fmi2SetFMUstateTYPE;
    states::fmi2FreeFMUstate: fmi2FreeFMUstateTYPE;
    states::fmi2SerializedFMUstateSize: fmi2SerializedFMUstateSizeTYPE;
    states::fmi2SerializeFMUstate: fmi2SerializeFMUstateTYPE;
    states::fmi2DeSerializeFMUstate: fmi2DeSerializeFMUstateTYPE;
    derivatives::fmi2GetDirectionalDerivative: fmi2GetDirectionalDerivativeTYPE;
    derivatives::fmi2SetRealInputDerivatives: fmi2SetRealInputDerivativesTYPE;
    derivatives::fmi2GetRealOutputDerivatives: fmi2GetRealOutputDerivativesTYPE;
    status::fmi2GetStatus: fmi2GetStatusTYPE;
    status::fmi2GetRealStatus: fmi2GetRealStatusTYPE;
    status::fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE;
    status::fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE;
    status::fmi2GetStringStatus: fmi2GetStringStatusTYPE;
    exchange::fmi2EnterEventMode: fmi2EnterEventModeTYPE;
    exchange::fmi2EnterContinuousTimeMode: fmi2EnterContinuousTimeModeTYPE;
    exchange::fmi2CompletedIntegratorStep: fmi2CompletedIntegratorStepTYPE;
    exchange::fmi2SetTime: fmi2SetTimeTYPE;
    exchange::fmi2SetContinuousStates: fmi2SetContinuousStatesTYPE;
    exchange::fmi2GetDerivatives: fmi2GetDerivativesTYPE;
    exchange::fmi2GetEventIndicators: fmi2GetEventIndicatorsTYPE;
    exchange::fmi2GetContinuousStates: fmi2GetContinuousStatesTYPE;
    exchange::fmi2GetNominalsOfContinuousStates: fmi2GetNominalsOfContinuousStatesTYPE;
}

/// `fmi2NewDiscreteStates` with a generic structure of the event.
type NewDiscreteStates<Info> = Option<unsafe extern "C" fn(fmi2Component, *mut Info) -> fmi2Status>;
const _: NewDiscreteStates<types::fmi2EventInfo> = Some(exchange::fmi2NewDiscreteStates);
const _: fn(binding::fmi2NewDiscreteStatesTYPE) -> NewDiscreteStates<binding::fmi2EventInfo> = |official| official;

/// `fmi2Instantiate` with a generic structure of callbacks: two structures of the same layout are two types in Rust.
type Instantiate<Callbacks> = Option<
    unsafe extern "C" fn(
        fmi2String,
        fmi2Type,
        fmi2String,
        fmi2String,
        *const Callbacks,
        fmi2Boolean,
        fmi2Boolean,
    ) -> fmi2Component,
>;
const _: Instantiate<fmi2CallbackFunctions> = Some(functions::fmi2Instantiate);
const _: fn(binding::fmi2InstantiateTYPE) -> Instantiate<binding::fmi2CallbackFunctions> = |official| official;

/// Checks that both structures have the same fields, of the same types, at the same offsets, and the same size.
macro_rules! same_fields {
    ($structure:ident: $($field:ident: $kind:ty;)*) => {
        $(
            const _: fn(types::$structure) -> $kind = |ours| ours.$field;
            const _: fn(binding::$structure) -> $kind = |official| official.$field;
            const _: () = assert!(
                offset_of!(types::$structure, $field) == offset_of!(binding::$structure, $field)
            );
        )*
        const _: () = assert!(
            size_of::<types::$structure>() == size_of::<binding::$structure>()
                && align_of::<types::$structure>() == align_of::<binding::$structure>()
        );
    };
}

same_fields! {
    fmi2EventInfo:
    newDiscreteStatesNeeded: fmi2Boolean;
    terminateSimulation: fmi2Boolean;
    nominalsOfContinuousStatesChanged: fmi2Boolean;
    valuesOfContinuousStatesChanged: fmi2Boolean;
    nextEventTimeDefined: fmi2Boolean;
    nextEventTime: types::fmi2Real;
}

same_fields! {
    fmi2CallbackFunctions:
    logger: fmi2CallbackLogger;
    allocateMemory: fmi2CallbackAllocateMemory;
    freeMemory: fmi2CallbackFreeMemory;
    stepFinished: fmi2StepFinished;
    componentEnvironment: types::fmi2ComponentEnvironment;
}

/// Checks the scalar types with identity functions that compile for equal types only.
macro_rules! same_types {
    ($($name:ident;)*) => { $(const _: fn(binding::$name) -> $name = |official| official;)* };
}
pub(crate) use same_types;

same_types! {
    fmi2Component;
    fmi2FMUstate;
    fmi2ValueReference;
    fmi2Real;
    fmi2Integer;
    fmi2Boolean;
    fmi2String;
    fmi2Byte;
    fmi2Status;
    fmi2StatusKind;
    fmi2Type;
}

/// The enumerators have the header's values.
macro_rules! same_values {
    ($($ours:ident = $official:ident;)*) => { $(const _: () = assert!(types::$ours == binding::$official);)* };
}
pub(crate) use same_values;

same_values! {
    fmi2OK = fmi2Status_fmi2OK;
    fmi2Warning = fmi2Status_fmi2Warning;
    fmi2Discard = fmi2Status_fmi2Discard;
    fmi2Error = fmi2Status_fmi2Error;
    fmi2Fatal = fmi2Status_fmi2Fatal;
    fmi2Pending = fmi2Status_fmi2Pending;
    fmi2ModelExchange = fmi2Type_fmi2ModelExchange;
    fmi2CoSimulation = fmi2Type_fmi2CoSimulation;
    fmi2DoStepStatus = fmi2StatusKind_fmi2DoStepStatus;
    fmi2PendingStatus = fmi2StatusKind_fmi2PendingStatus;
    fmi2LastSuccessfulTime = fmi2StatusKind_fmi2LastSuccessfulTime;
    fmi2Terminated = fmi2StatusKind_fmi2Terminated;
}

#[cfg(test)]
mod tests {
    use super::CHECKED;
    use foldwing_fmi::fmi2::FUNCTIONS;
    use std::collections::BTreeSet;

    /// Every function of the standard is in the list above, or checked separately.
    #[test]
    fn every_function_is_checked() {
        let checked: BTreeSet<&str> =
            CHECKED.iter().copied().chain(["fmi2Instantiate", "fmi2NewDiscreteStates"]).collect();
        assert_eq!(checked.len(), 44, "functions of FMI 2.0 for co-simulation and Model Exchange");
        assert_eq!(checked, FUNCTIONS.iter().copied().collect());
    }
}
