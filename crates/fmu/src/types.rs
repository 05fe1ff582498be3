//! Types of the official headers `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`, under their own names.

#![allow(non_camel_case_types, reason = "names of the standard")]

use std::ffi::{c_char, c_double, c_int, c_uint, c_void};

/// Handle of an instance.
pub type fmi2Component = *mut c_void;
/// Passed back to the importer's functions unchanged.
pub type fmi2ComponentEnvironment = *mut c_void;
/// Handle of a saved state.
pub type fmi2FMUstate = *mut c_void;
/// Handle of a variable.
pub type fmi2ValueReference = c_uint;
/// Real.
pub type fmi2Real = c_double;
/// Integer.
pub type fmi2Integer = c_int;
/// Boolean: [`fmi2False`] or [`fmi2True`].
pub type fmi2Boolean = c_int;
/// Character.
pub type fmi2Char = c_char;
/// Zero-terminated UTF-8 text.
pub type fmi2String = *const fmi2Char;
/// Byte.
pub type fmi2Byte = c_char;

/// True.
#[allow(non_upper_case_globals, reason = "name of the standard")]
pub const fmi2True: fmi2Boolean = 1;
/// False.
#[allow(non_upper_case_globals, reason = "name of the standard")]
pub const fmi2False: fmi2Boolean = 0;

/// Outcome of a call: one of [`fmi2OK`] to [`fmi2Pending`]. C enumerations are plain integers here, since a
/// caller may pass any value.
pub type fmi2Status = c_uint;
/// Interface type: 0 Model Exchange, 1 co-simulation.
pub type fmi2Type = c_uint;
/// Status kind: one of [`fmi2DoStepStatus`] to [`fmi2Terminated`].
pub type fmi2StatusKind = c_uint;

macro_rules! enumerators {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $value:literal;)*) => {
        $($(#[$doc])* #[allow(non_upper_case_globals, reason = "name of the standard")] pub const $name: $type = $value;)*
    };
}

enumerators! {
    /// The call succeeded.
    fmi2OK: fmi2Status = 0;
    /// The call succeeded, with a warning.
    fmi2Warning: fmi2Status = 1;
    /// A value was rejected; nothing changed.
    fmi2Discard: fmi2Status = 2;
    /// The call is illegal or failed.
    fmi2Error: fmi2Status = 3;
    /// The instance can no longer be used.
    fmi2Fatal: fmi2Status = 4;
    /// Asynchronous; never used here.
    fmi2Pending: fmi2Status = 5;
    /// Model Exchange.
    fmi2ModelExchange: fmi2Type = 0;
    /// Co-simulation.
    fmi2CoSimulation: fmi2Type = 1;
    /// Status of the last step.
    fmi2DoStepStatus: fmi2StatusKind = 0;
    /// Status of a pending step.
    fmi2PendingStatus: fmi2StatusKind = 1;
    /// End of the last successful step.
    fmi2LastSuccessfulTime: fmi2StatusKind = 2;
    /// Whether the slave requests termination.
    fmi2Terminated: fmi2StatusKind = 3;
}

/// Log function of the importer: environment, instance name, status, category, format and its arguments.
pub type fmi2CallbackLogger =
    Option<unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...)>;
/// Memory function of the importer; never used here.
pub type fmi2CallbackAllocateMemory = Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>;
/// Memory function of the importer; never used here.
pub type fmi2CallbackFreeMemory = Option<unsafe extern "C" fn(*mut c_void)>;
/// End of an asynchronous step; never used here.
pub type fmi2StepFinished = Option<unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2Status)>;

/// Result of an event update.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct fmi2EventInfo {
    /// The event needs a further update.
    pub newDiscreteStatesNeeded: fmi2Boolean,
    /// The simulation must end.
    pub terminateSimulation: fmi2Boolean,
    /// Nominal values of states have changed.
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    /// Values of states have changed.
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    /// The time of the next event is defined.
    pub nextEventTimeDefined: fmi2Boolean,
    /// That time in s.
    pub nextEventTime: fmi2Real,
}

/// Functions of the importer.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fmi2CallbackFunctions {
    /// Receives messages; may be null.
    pub logger: fmi2CallbackLogger,
    /// Not used.
    pub allocateMemory: fmi2CallbackAllocateMemory,
    /// Not used.
    pub freeMemory: fmi2CallbackFreeMemory,
    /// Not used.
    pub stepFinished: fmi2StepFinished,
    /// First argument of [`Self::logger`].
    pub componentEnvironment: fmi2ComponentEnvironment,
}
