//! Exported functions for derivatives.

use super::types::{fmi3Float64, fmi3Instance, fmi3Int32, fmi3Status, fmi3ValueReference};
use crate::{enter, slice, slice_mut};
use foldwing_fmi::fmi3::Call;

/// `sensitivity = ∂unknowns/∂knowns · seed` with the state held constant, at the communication point or in Initialization Mode.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; the arrays hold as many entries as given by the counts after
/// them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    instance: fmi3Instance,
    unknowns: *const fmi3ValueReference,
    n_unknowns: usize,
    knowns: *const fmi3ValueReference,
    n_knowns: usize,
    seed: *const fmi3Float64,
    n_seed: usize,
    sensitivity: *mut fmi3Float64,
    n_sensitivity: usize,
) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::GetDirectionalDerivative, |instance| {
            let unknowns = slice(unknowns, n_unknowns, "unknowns")?;
            let knowns = slice(knowns, n_knowns, "knowns")?;
            instance.array_directional_derivative(
                (unknowns, slice_mut(sensitivity, n_sensitivity, "sensitivity")?),
                (knowns, slice(seed, n_seed, "seed")?),
            )
        })
    }
}

/// `sensitivity = seedᵀ · ∂unknowns/∂knowns`: the transpose of [`fmi3GetDirectionalDerivative`].
///
/// # Safety
/// As [`fmi3GetDirectionalDerivative`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    instance: fmi3Instance,
    unknowns: *const fmi3ValueReference,
    n_unknowns: usize,
    knowns: *const fmi3ValueReference,
    n_knowns: usize,
    seed: *const fmi3Float64,
    n_seed: usize,
    sensitivity: *mut fmi3Float64,
    n_sensitivity: usize,
) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::GetAdjointDerivative, |instance| {
            let unknowns = slice(unknowns, n_unknowns, "unknowns")?;
            let knowns = slice(knowns, n_knowns, "knowns")?;
            instance.array_adjoint_derivative(
                (unknowns, slice(seed, n_seed, "seed")?),
                (knowns, slice_mut(sensitivity, n_sensitivity, "sensitivity")?),
            )
        })
    }
}

/// Time derivatives of Float64 outputs, of order 1; higher ones are zero.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; `references` and `orders` hold `n_references`
/// entries, `values` has room for `n_values`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    instance: fmi3Instance,
    references: *const fmi3ValueReference,
    n_references: usize,
    orders: *const fmi3Int32,
    values: *mut fmi3Float64,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::GetOutputDerivatives, |instance| {
            let references = slice(references, n_references, "valueReferences")?;
            let orders = slice(orders, n_references, "orders")?;
            instance.array_output_derivatives(references, orders, slice_mut(values, n_values, "values")?)
        })
    }
}
