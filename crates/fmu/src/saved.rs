//! Functions that save and restore states, the same in both versions except for names.

use foldwing_fmi::instance::CallError;
use std::ffi::c_void;
use std::ptr;

/// `$argument` is the name of a state in the standard.
macro_rules! saved_states {
    (
        $handle:ty, $state:ty, $byte:ty, $argument:literal;
        $save:ident $save_call:expr;
        $restore:ident $restore_call:expr;
        $free:ident $free_call:expr;
        $size:ident $size_call:expr;
        $write:ident $write_call:expr;
        $read:ident $read_call:expr;
    ) => {
        /// Saves the current state. A handle that is not null on entry is overwritten.
        ///
        /// # Safety
        /// The handle of the instance is null or came from an instantiation and has not been freed; `state` is null or points to null or a handle.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $save(handle: $handle, state: *mut $state) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe {
                $crate::enter(handle, $save_call, |instance| {
                    let state = $crate::place(state, $argument)?;
                    *state = $crate::saved::handle(instance.save_state(state.addr())?);
                    Ok(())
                })
            }
        }

        /// Restores a saved state.
        ///
        /// # Safety
        /// The handle of the instance is null or came from an instantiation and has not been freed; any `state` is checked.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $restore(handle: $handle, state: $state) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe {
                $crate::enter(handle, $restore_call, |instance| {
                    instance.restore_state($crate::saved::number(state, $argument)?)
                })
            }
        }

        /// Frees a saved state and sets its handle to null; null is ignored.
        ///
        /// # Safety
        /// The handle of the instance is null or came from an instantiation and has not been freed; `state` is null or points to null or a handle.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free(handle: $handle, state: *mut $state) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe {
                $crate::enter(handle, $free_call, |instance| {
                    if let Some(state) = state.as_mut().filter(|state| !state.is_null()) {
                        instance.free_state(state.addr())?;
                        *state = std::ptr::null_mut();
                    }
                    Ok(())
                })
            }
        }

        /// Size of a saved state in bytes.
        ///
        /// # Safety
        /// The handle of the instance is null or came from an instantiation and has not been freed; `size` is null or can be written to.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $size(handle: $handle, state: $state, size: *mut usize) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe {
                $crate::enter(handle, $size_call, |instance| {
                    let state = $crate::saved::number(state, $argument);
                    *$crate::place(size, "size")? = instance.serialize_state(state?)?.len();
                    Ok(())
                })
            }
        }

        /// Serialises a saved state.
        ///
        /// # Safety
        /// The handle of the instance is null or came from an instantiation and has not been freed; `bytes` is null or has room for `size` bytes.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $write(
            handle: $handle,
            state: $state,
            bytes: *mut $byte,
            size: usize,
        ) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe {
                $crate::enter(handle, $write_call, |instance| {
                    let written = instance.serialize_state($crate::saved::number(state, $argument)?)?;
                    let buffer = $crate::slice_mut(bytes.cast::<u8>(), size, "serializedState")?;
                    let room = buffer.get_mut(..written.len());
                    let needed = written.len();
                    room.ok_or(foldwing_fmi::instance::StateError::Buffer { given: size, needed })?
                        .copy_from_slice(&written);
                    Ok(())
                })
            }
        }

        /// Creates a saved state from bytes, under a new handle.
        ///
        /// # Safety
        /// The handle of the instance is null or came from an instantiation and has not been freed; `bytes` is null or holds `size`
        /// bytes; `state` is null or can be written to.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $read(
            handle: $handle,
            bytes: *const $byte,
            size: usize,
            state: *mut $state,
        ) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe {
                $crate::enter(handle, $read_call, |instance| {
                    let state = $crate::place(state, $argument)?;
                    let bytes = $crate::slice(bytes.cast::<u8>(), size, "serializedState")?;
                    *state = $crate::saved::handle(instance.deserialize_state(bytes)?);
                    Ok(())
                })
            }
        }
    };
}
pub(crate) use saved_states;

/// Handle for C: an address that is never dereferenced.
pub(crate) fn handle(number: usize) -> *mut c_void {
    ptr::without_provenance_mut::<c_void>(number)
}

/// Number of a handle.
pub(crate) fn number(state: *mut c_void, argument: &'static str) -> Result<usize, CallError> {
    if state.is_null() { Err(CallError::NullPointer { argument }) } else { Ok(state.addr()) }
}
