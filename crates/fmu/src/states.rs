//! The exported functions that save and restore states.

use super::types::{fmi2Byte, fmi2Component, fmi2FMUstate, fmi2Status};
use super::{enter, place, slice, slice_mut};
use foldwing_fmi::fmi2::Call;
use foldwing_fmi::fmi2::CallError;
use foldwing_fmi::fmi2::StateError;
use std::ffi::c_void;
use std::ptr;

/// Saves the present state. A handle that is not null on entry is overwritten.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `state` is null or points to null or a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(component: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetFmuState, |instance| {
            let state = place(state, "FMUstate")?;
            *state = handle(instance.save_state(state.addr())?);
            Ok(())
        })
    }
}

/// Goes back to a saved state.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; any `state` is checked.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(component: fmi2Component, state: fmi2FMUstate) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::SetFmuState, |instance| instance.restore_state(number(state)?)) }
}

/// Forgets a saved state and sets its handle to null; null is ignored.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `state` is null or points to null or a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(component: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::FreeFmuState, |instance| {
            if let Some(state) = state.as_mut().filter(|state| !state.is_null()) {
                instance.free_state(state.addr())?;
                *state = ptr::null_mut();
            }
            Ok(())
        })
    }
}

/// Size of a saved state in bytes.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `size` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    component: fmi2Component,
    state: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::SerializedFmuStateSize, |instance| {
            *place(size, "size")? = instance.serialize_state(number(state)?)?.len();
            Ok(())
        })
    }
}

/// Writes a saved state as bytes.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `bytes` is null or has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    component: fmi2Component,
    state: fmi2FMUstate,
    bytes: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::SerializeFmuState, |instance| {
            let written = instance.serialize_state(number(state)?)?;
            let buffer = slice_mut(bytes.cast::<u8>(), size, "serializedState")?;
            let room = buffer.get_mut(..written.len());
            room.ok_or(StateError::Buffer { given: size, needed: written.len() })?.copy_from_slice(&written);
            Ok(())
        })
    }
}

/// A saved state from bytes, under a new handle.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `bytes` is null or holds `size` bytes; `state` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    component: fmi2Component,
    bytes: *const fmi2Byte,
    size: usize,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::DeSerializeFmuState, |instance| {
            let state = place(state, "FMUstate")?;
            *state = handle(instance.deserialize_state(slice(bytes.cast::<u8>(), size, "serializedState")?)?);
            Ok(())
        })
    }
}

/// A handle as C sees it: an address that is never followed.
fn handle(number: usize) -> fmi2FMUstate {
    ptr::without_provenance_mut::<c_void>(number)
}

/// The number behind a handle.
fn number(state: fmi2FMUstate) -> Result<usize, CallError> {
    if state.is_null() { Err(CallError::NullPointer { argument: "FMUstate" }) } else { Ok(state.addr()) }
}
