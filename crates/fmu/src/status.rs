//! Exported status functions.

use super::types::{
    fmi2Boolean, fmi2Component, fmi2DoStepStatus, fmi2False, fmi2Integer, fmi2LastSuccessfulTime, fmi2PendingStatus,
    fmi2Real, fmi2Status, fmi2StatusKind, fmi2String, fmi2Terminated,
};
use super::{enter, place, status_code};
use foldwing_fmi::fmi2::Call;
use foldwing_fmi::instance::CallError;

/// Status of the last step.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `value` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(
    component: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Status,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetStatus, |instance| {
            reported(kind, fmi2DoStepStatus, "fmi2DoStepStatus")?;
            *place(value, "value")? = status_code(instance.step_status());
            Ok(())
        })
    }
}

/// End of the last successful step in s, also within a failed one.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `value` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    component: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetRealStatus, |instance| {
            reported(kind, fmi2LastSuccessfulTime, "fmi2LastSuccessfulTime")?;
            *place(value, "value")? = instance.last_successful_time_s();
            Ok(())
        })
    }
}

/// Whether the slave requests termination: never.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `value` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    component: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetBooleanStatus, |_| {
            reported(kind, fmi2Terminated, "fmi2Terminated")?;
            *place(value, "value")? = fmi2False;
            Ok(())
        })
    }
}

/// Status of a pending step: there never is one.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `value` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    component: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetStringStatus, |_| {
            reported(kind, fmi2PendingStatus, "fmi2PendingStatus")?;
            *place(value, "value")? = c"no step is pending".as_ptr();
            Ok(())
        })
    }
}

/// Always an error: the standard defines no Integer status.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    component: fmi2Component,
    kind: fmi2StatusKind,
    _value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::GetIntegerStatus, |_| Err(CallError::StatusKind { kind, reported: "nothing" })) }
}

/// Fails for every status kind except `expected`.
fn reported(kind: fmi2StatusKind, expected: fmi2StatusKind, reported: &'static str) -> Result<(), CallError> {
    if kind == expected { Ok(()) } else { Err(CallError::StatusKind { kind, reported }) }
}
