//! Types of the official headers `fmi3PlatformTypes.h` and `fmi3FunctionTypes.h`, under their own names.

#![allow(non_camel_case_types, reason = "names of the standard")]

use std::ffi::{c_char, c_uint, c_void};

/// Handle of an instance.
pub type fmi3Instance = *mut c_void;
/// Passed back to the importer's functions unchanged.
pub type fmi3InstanceEnvironment = *mut c_void;
/// Handle of a saved state.
pub type fmi3FMUState = *mut c_void;
/// Handle of a variable.
pub type fmi3ValueReference = u32;
/// 32-bit real.
pub type fmi3Float32 = f32;
/// 64-bit real.
pub type fmi3Float64 = f64;
/// 8-bit integer.
pub type fmi3Int8 = i8;
/// 8-bit unsigned integer.
pub type fmi3UInt8 = u8;
/// 16-bit integer.
pub type fmi3Int16 = i16;
/// 16-bit unsigned integer.
pub type fmi3UInt16 = u16;
/// 32-bit integer.
pub type fmi3Int32 = i32;
/// 32-bit unsigned integer.
pub type fmi3UInt32 = u32;
/// 64-bit integer.
pub type fmi3Int64 = i64;
/// 64-bit unsigned integer.
pub type fmi3UInt64 = u64;
/// Boolean.
pub type fmi3Boolean = bool;
/// Character.
pub type fmi3Char = c_char;
/// Zero-terminated UTF-8 text.
pub type fmi3String = *const fmi3Char;
/// Byte.
pub type fmi3Byte = u8;
/// Bytes.
pub type fmi3Binary = *const fmi3Byte;
/// State of a clock.
pub type fmi3Clock = bool;
/// Outcome of a call, with the numbers of [`fmi2Status`](crate::types::fmi2Status) except the asynchronous one. C enumerations are plain
/// integers here, since a caller may pass any value.
pub type fmi3Status = c_uint;
/// Kind of dependence of a variable on another.
pub type fmi3DependencyKind = c_uint;
/// Kind of information on a clock's interval.
pub type fmi3IntervalQualifier = c_uint;

/// Log function of the importer: environment, status, category, message.
pub type fmi3LogMessageCallback =
    Option<unsafe extern "C" fn(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String)>;
/// Callback for an intermediate update within a step: environment, time, whether inputs are requested, whether values can be read, whether
/// it is the end of an internal step, whether the step may end here; results: whether the importer requests the end, and its time.
pub type fmi3IntermediateUpdateCallback = Option<
    unsafe extern "C" fn(
        fmi3InstanceEnvironment,
        fmi3Float64,
        fmi3Boolean,
        fmi3Boolean,
        fmi3Boolean,
        fmi3Boolean,
        *mut fmi3Boolean,
        *mut fmi3Float64,
    ),
>;
/// Function of Scheduled Execution; never used here.
pub type fmi3ClockUpdateCallback = Option<unsafe extern "C" fn(fmi3InstanceEnvironment)>;
/// Function of Scheduled Execution; never used here.
pub type fmi3LockPreemptionCallback = Option<unsafe extern "C" fn()>;
/// Function of Scheduled Execution; never used here.
pub type fmi3UnlockPreemptionCallback = Option<unsafe extern "C" fn()>;
