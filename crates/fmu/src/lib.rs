//! The library in every FMU: thin exported C functions of FMI 2.0 and 3.0 behind one gate. It contains the only `unsafe` code of
//! Foldwing.
//!
//! The gate checks the handle and the life cycle and stops panics; the functions are implemented in `foldwing-fmi`.
//!
//! Pointers are trusted to be valid as the standard requires; null is always checked, and legal with `n = 0`.

#![allow(unsafe_code, reason = "the C interface")]
#![allow(non_snake_case, reason = "names of the standard")]

mod instantiation;
mod saved;
mod vectors;

pub mod derivatives;
pub mod exchange;
pub mod fmi3;
pub mod functions;
#[cfg(feature = "import")]
pub mod official;
pub mod states;
pub mod status;
pub mod types;

use foldwing_fmi::instance::{CallError, Instance, Rule, Sink, Status};
use foldwing_fmi::interface::{Kind, Scalar, Value};
use std::cell::UnsafeCell;
use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use types::{fmi2Boolean, fmi2CallbackFunctions, fmi2Discard, fmi2Error, fmi2Fatal, fmi2OK, fmi2Status, fmi2Warning};

/// Target of a handle.
struct Held {
    /// A call is in progress: another call, from the importer's logger or a second thread, is rejected.
    taken: AtomicBool,
    /// A step of FMI 3.0 is in progress, and may call the importer's callback.
    stepping: AtomicBool,
    /// The importer's callback within such a step.
    asked: Option<fmi3::Asked>,
    instance: UnsafeCell<Instance>,
}

impl Held {
    /// Returns the handle for C.
    fn handle(instance: Instance, asked: Option<fmi3::Asked>) -> *mut c_void {
        let (taken, stepping) = (AtomicBool::new(false), AtomicBool::new(false));
        Box::into_raw(Box::new(Self { taken, stepping, asked, instance: UnsafeCell::new(instance) })).cast()
    }

    /// Returns whether a step of FMI 3.0 is in progress.
    fn is_stepping(&self) -> bool {
        self.stepping.load(Ordering::Acquire)
    }

    /// Returns whether the importer allows early return from steps.
    fn returns_early(&self) -> bool {
        // SAFETY: the instance is read, and only while it is taken.
        self.take().is_some_and(|_taken| unsafe { &*self.instance.get() }.manner().early_return)
    }

    /// Reserves the instance for a call, unless another call has it.
    fn take(&self) -> Option<Taken<'_>> {
        (!self.taken.swap(true, Ordering::Acquire)).then(|| Taken(self))
    }
}

/// Exclusive access to an instance for a call, until this is dropped.
struct Taken<'a>(&'a Held);

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        self.0.taken.store(false, Ordering::Release);
    }
}

/// The only place where a C call becomes a Rust call: null check, life-cycle table, panic barrier, `Result` → status. A panic poisons the
/// instance; only freeing it is legal afterwards. The statuses of both versions have the same numbers.
///
/// A call during another one on the same instance, for example from the importer's logger, fails without a message: a message would call
/// the logger from within itself.
///
/// # Safety
/// `handle` is null or came from an instantiation and has not been freed.
unsafe fn enter(
    handle: *mut c_void,
    call: impl Into<Rule>,
    body: impl FnOnce(&mut Instance) -> Result<(), CallError>,
) -> fmi2Status {
    let call = call.into();
    // SAFETY: null, or made by `Held::handle` and alive.
    let Some(held) = (unsafe { handle.cast::<Held>().as_ref() }) else {
        return fmi2Error;
    };
    let Some(_taken) = held.take() else {
        return fmi2Error;
    };
    // SAFETY: access is exclusive until `_taken` is dropped.
    let instance = unsafe { &mut *held.instance.get() };
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        instance.permit(call)?;
        body(instance)
    }));
    status_code(match outcome {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(error)) => instance.report(call, &error),
        Err(panic) => instance.poison(call, &panic_text(&*panic)),
    })
}

/// Text of a panic.
fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("panic").to_owned()
}

/// The status in C.
fn status_code(status: Status) -> fmi2Status {
    match status {
        Status::Ok => fmi2OK,
        Status::Warning => fmi2Warning,
        Status::Discard => fmi2Discard,
        Status::Error => fmi2Error,
        Status::Fatal => fmi2Fatal,
    }
}

/// Returns a C array for reading.
///
/// # Safety
/// `pointer` is null or points to `n` values that live and do not change for `'a`.
unsafe fn slice<'a, T>(pointer: *const T, n: usize, argument: &'static str) -> Result<&'a [T], CallError> {
    if n == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(CallError::NullPointer { argument });
    }
    // SAFETY: not null, and the caller promises `n` values.
    Ok(unsafe { std::slice::from_raw_parts(pointer, n) })
}

/// Returns a C array for writing.
///
/// # Safety
/// `pointer` is null or points to `n` values that nobody else uses for `'a`.
unsafe fn slice_mut<'a, T>(pointer: *mut T, n: usize, argument: &'static str) -> Result<&'a mut [T], CallError> {
    if n == 0 {
        return Ok(&mut []);
    }
    if pointer.is_null() {
        return Err(CallError::NullPointer { argument });
    }
    // SAFETY: not null, and the caller promises `n` values.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, n) })
}

/// Returns a pointer to one value for writing.
///
/// # Safety
/// `pointer` is null or points to a value that nobody else uses for `'a`.
unsafe fn place<'a, T>(pointer: *mut T, argument: &'static str) -> Result<&'a mut T, CallError> {
    // SAFETY: forwarded from the caller.
    unsafe { pointer.as_mut() }.ok_or(CallError::NullPointer { argument })
}

/// Returns a text; `None` for null.
///
/// # Safety
/// `pointer` is null or points to zero-terminated text that lives for `'a`.
unsafe fn text<'a>(pointer: *const c_char, argument: &'static str) -> Result<Option<&'a str>, CallError> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: not null, and the caller promises a terminating zero.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map(Some).map_err(|_| CallError::NotText { argument })
}

/// The importer's log function as a [`Sink`]; `None` if there is no function.
///
/// # Safety
/// `callbacks` is null or points to functions that stay callable as long as the sink lives.
unsafe fn sink(callbacks: *const fmi2CallbackFunctions, instance_name: &CStr) -> Option<Sink> {
    // SAFETY: forwarded from the caller. The structure is copied: some importers do not keep it.
    let callbacks = *unsafe { callbacks.as_ref() }?;
    let logger = callbacks.logger?;
    let name = instance_name.to_owned();
    Some(Box::new(move |status, category, text| {
        let category = c_text(category.name());
        // The text is the format itself: there are no arguments, so each `%` is doubled.
        let format = c_text(&text.replace('%', "%%"));
        // SAFETY: the importer's function, with zero-terminated texts that outlive the call.
        unsafe {
            logger(
                callbacks.componentEnvironment,
                name.as_ptr(),
                status_code(status),
                category.as_ptr(),
                format.as_ptr(),
            );
        }
    }))
}

/// Zero-terminated; a zero inside becomes a space.
fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// A Boolean from C: any value but 0 is true.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
struct Flag(fmi2Boolean);

impl Scalar for Flag {
    const KIND: Kind = Kind::Boolean;

    fn into_value(self) -> Value {
        Value::Boolean(self.0 != types::fmi2False)
    }

    fn from_value(value: Value) -> Option<Self> {
        bool::from_value(value).map(|value| Self(fmi2Boolean::from(value)))
    }
}

#[cfg(test)]
mod tests;
