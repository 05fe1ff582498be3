//! Functions of Model Exchange that pass one vector, the same in both versions except for names.

/// `$direction` is `get` or `set`; `$body` is the method of the instance.
macro_rules! vectors {
    ($($(#[$doc:meta])* $direction:ident $function:ident($handle:ty, $real:ty) $call:expr, $argument:literal, $body:ident;)*) => { $(
        vectors! { @$direction $(#[$doc])* $function($handle, $real) $call, $argument, $body }
    )* };
    (@get $(#[$doc:meta])* $function:ident($handle:ty, $real:ty) $call:expr, $argument:literal, $body:ident) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// The handle is null or came from an instantiation and has not been freed; `values` has room for `n` entries.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(handle: $handle, values: *mut $real, n: usize) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe { $crate::enter(handle, $call, |instance| instance.$body($crate::slice_mut(values, n, $argument)?)) }
        }
    };
    (@set $(#[$doc:meta])* $function:ident($handle:ty, $real:ty) $call:expr, $argument:literal, $body:ident) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// The handle is null or came from an instantiation and has not been freed; `values` holds `n` entries.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(handle: $handle, values: *const $real, n: usize) -> std::ffi::c_uint {
            // SAFETY: forwarded from the caller.
            unsafe { $crate::enter(handle, $call, |instance| instance.$body($crate::slice(values, n, $argument)?)) }
        }
    };
}
pub(crate) use vectors;
