//! Exported functions for derivatives.

use super::types::{fmi2Component, fmi2Integer, fmi2Real, fmi2Status, fmi2ValueReference};
use super::{enter, slice, slice_mut};
use foldwing_fmi::fmi2::Call;

/// `dv_unknown = ∂v_unknown/∂v_known · dv_known` with the state held constant, at the communication point or in Initialization Mode.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `unknowns` and `unknown_changes` hold `n_unknowns` entries,
/// `knowns` and `known_changes` `n_knowns`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    component: fmi2Component,
    unknowns: *const fmi2ValueReference,
    n_unknowns: usize,
    knowns: *const fmi2ValueReference,
    n_knowns: usize,
    known_changes: *const fmi2Real,
    unknown_changes: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetDirectionalDerivative, |instance| {
            instance.directional_derivative(
                (slice(unknowns, n_unknowns, "vUnknown_ref")?, slice_mut(unknown_changes, n_unknowns, "dvUnknown")?),
                (slice(knowns, n_knowns, "vKnown_ref")?, slice(known_changes, n_knowns, "dvKnown")?),
            )
        })
    }
}

/// Time derivatives of Real inputs, of order 1, for the next step only.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; the three arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    orders: *const fmi2Integer,
    values: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::SetRealInputDerivatives, |instance| {
            let references = slice(references, n, "vr")?;
            instance.set_input_derivatives(references, slice(orders, n, "order")?, slice(values, n, "value")?)
        })
    }
}

/// Time derivatives of Real outputs, of order 1; higher ones are zero.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; the three arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    orders: *const fmi2Integer,
    values: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetRealOutputDerivatives, |instance| {
            let references = slice(references, n, "vr")?;
            instance.output_derivatives(references, slice(orders, n, "order")?, slice_mut(values, n, "value")?)
        })
    }
}
