//! Creating and freeing instances, in both versions.

use crate::{Held, fmi3, panic_text, text};
use foldwing_fmi::instance::{Instance, InstantiationError, Log, Manner, Request, Status, Version};
use std::ffi::{c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

/// Texts of an instantiation with the names of their arguments.
pub(crate) struct Texts {
    pub name: (*const c_char, &'static str),
    pub token: (*const c_char, &'static str),
    pub resources: (*const c_char, &'static str),
}

/// Requested instance.
pub(crate) struct Wanted {
    pub version: Version,
    /// Interface type with the numbers of FMI 2.0: 0 is Model Exchange, 1 co-simulation.
    pub fmu_type: u32,
    pub manner: Manner,
    pub asked: Option<fmi3::Asked>,
}

/// Returns a new instance, or null after a message with the cause. `call` is the name of the calling function.
///
/// # Safety
/// The texts are null or zero-terminated.
pub(crate) unsafe fn instantiate(call: &str, texts: &Texts, wanted: Wanted, mut log: Log) -> *mut c_void {
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: forwarded from the caller.
        let read = |(pointer, argument)| unsafe { text(pointer, argument) }.map_err(|error| error.to_string());
        let request = Request {
            version: wanted.version,
            name: read(texts.name)?,
            fmu_type: wanted.fmu_type,
            guid: read(texts.token)?,
            resource_location: read(texts.resources)?,
            manner: wanted.manner,
        };
        Instance::new(&request).map_err(|error: InstantiationError| error.to_string())
    }));
    match outcome {
        Ok(Ok(mut instance)) => {
            std::mem::swap(instance.log_mut(), &mut log);
            Held::handle(instance, wanted.asked)
        }
        Ok(Err(error)) => {
            log.refuse(Status::Error, &format!("{call}: {error}"));
            ptr::null_mut()
        }
        Err(panic) => {
            log.refuse(Status::Fatal, &format!("{call}: internal error: {}", panic_text(&*panic)));
            ptr::null_mut()
        }
    }
}

/// Frees an instance with its saved states; null is ignored, and so is a call from the instance's own logger or from within
/// its own step.
///
/// # Safety
/// `handle` is null or came from an instantiation and has not been freed.
pub(crate) unsafe fn free(handle: *mut c_void) {
    // SAFETY: null, or made by `Held::handle` and alive.
    let Some(held) = (unsafe { handle.cast::<Held>().as_ref() }) else { return };
    if !held.is_stepping() && held.take().is_some() {
        // SAFETY: made by `Held::handle`, freed once; no call is running.
        let instance = unsafe { Box::from_raw(handle.cast::<Held>()) };
        // No message is possible any more; a panic must not reach the importer.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(instance)));
    }
}

/// Sets the log categories by name.
///
/// # Safety
/// `categories` is null or holds `n` texts, each null or zero-terminated.
pub(crate) unsafe fn set_log_categories(
    instance: &mut Instance,
    on: bool,
    n: usize,
    categories: *const *const c_char,
) -> Result<(), foldwing_fmi::instance::CallError> {
    use foldwing_fmi::instance::CallError;
    // SAFETY: forwarded from the caller.
    let names = unsafe { crate::slice(categories, n, "categories")? }
        .iter()
        // SAFETY: forwarded from the caller.
        .map(|&name| unsafe { text(name, "categories")? }.ok_or(CallError::NullPointer { argument: "categories" }))
        .collect::<Result<Vec<_>, _>>()?;
    instance.log_mut().set_categories(on, names.into_iter())
}
