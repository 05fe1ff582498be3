//! Exported functions: life cycle, values and steps.

use super::instantiation::{Texts, Wanted, free, instantiate, set_log_categories};
use super::types::{
    fmi2Boolean, fmi2CallbackFunctions, fmi2Component, fmi2False, fmi2Integer, fmi2Real, fmi2Status, fmi2String,
    fmi2Type, fmi2ValueReference,
};
use super::{Flag, enter, sink, slice, slice_mut};
use foldwing_fmi::fmi2::Call;
use foldwing_fmi::instance::{Instance, Log, Manner, Setup, Version};
use std::ffi::{CStr, c_char};

/// Platform of the header: `default`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// Version of the standard: `2.0`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Switches log categories on or off; no category means all.
///
/// # Safety
/// As [`fmi2FreeInstance`]; `categories` points to `n_categories` texts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    component: fmi2Component,
    logging_on: fmi2Boolean,
    n_categories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::SetDebugLogging, |instance| {
            set_log_categories(instance, logging_on != fmi2False, n_categories, categories)
        })
    }
}

/// Returns a new instance, or null after a message with the cause.
///
/// # Safety
/// Texts are null or zero-terminated; `functions` is null or points to functions that stay callable until the
/// instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: fmi2String,
    fmu_type: fmi2Type,
    fmu_guid: fmi2String,
    fmu_resource_location: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    logging_on: fmi2Boolean,
) -> fmi2Component {
    // SAFETY: forwarded from the caller.
    let name = if instance_name.is_null() { c"" } else { unsafe { CStr::from_ptr(instance_name) } };
    // SAFETY: forwarded from the caller.
    let log = Log::new(unsafe { sink(functions, name) }, logging_on != fmi2False);
    let texts = Texts {
        name: (instance_name, "instanceName"),
        token: (fmu_guid, "fmuGUID"),
        resources: (fmu_resource_location, "fmuResourceLocation"),
    };
    let wanted = Wanted { version: Version::Fmi2, fmu_type, manner: Manner::default(), asked: None };
    // SAFETY: forwarded from the caller.
    unsafe { instantiate("fmi2Instantiate", &texts, wanted, log) }
}

/// Frees an instance with its saved states; null is ignored, and so is a call from the instance's own logger.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: fmi2Component) {
    // SAFETY: forwarded from the caller.
    unsafe { free(component) }
}

/// Sets times and tolerance of the experiment.
///
/// # Safety
/// As [`fmi2FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    component: fmi2Component,
    tolerance_defined: fmi2Boolean,
    tolerance: fmi2Real,
    start_time: fmi2Real,
    stop_time_defined: fmi2Boolean,
    stop_time: fmi2Real,
) -> fmi2Status {
    let setup = Setup {
        tolerance: (tolerance_defined != fmi2False).then_some(tolerance),
        start_s: start_time,
        stop_s: (stop_time_defined != fmi2False).then_some(stop_time),
    };
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::SetupExperiment, |instance| instance.setup_experiment(setup)) }
}

/// Enters Initialization Mode; start values set after this call are evaluated when they are read.
///
/// # Safety
/// As [`fmi2FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(component: fmi2Component) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::EnterInitializationMode, |instance| {
            instance.enter_initialization();
            Ok(())
        })
    }
}

/// Ends the initialisation.
///
/// # Safety
/// As [`fmi2FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(component: fmi2Component) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::ExitInitializationMode, Instance::exit_initialization) }
}

/// Ends the simulation; values can still be read.
///
/// # Safety
/// As [`fmi2FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(component: fmi2Component) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::Terminate, |instance| {
            instance.terminate();
            Ok(())
        })
    }
}

/// Resets the instance to its state after instantiation.
///
/// # Safety
/// As [`fmi2FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(component: fmi2Component) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::Reset, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

/// Reads Real variables.
///
/// # Safety
/// As [`fmi2FreeInstance`]; both arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    values: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetReal, |instance| {
            instance.get(slice(references, n, "vr")?, slice_mut(values, n, "value")?)
        })
    }
}

/// Reads Integer variables.
///
/// # Safety
/// As [`fmi2FreeInstance`]; both arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    values: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetInteger, |instance| {
            instance.get(slice(references, n, "vr")?, slice_mut(values, n, "value")?)
        })
    }
}

/// Reads Boolean variables.
///
/// # Safety
/// As [`fmi2FreeInstance`]; both arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    values: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::GetBoolean, |instance| {
            instance.get(slice(references, n, "vr")?, slice_mut(values.cast::<Flag>(), n, "value")?)
        })
    }
}

/// Fails unless `n` is 0: there are no String variables.
///
/// # Safety
/// As [`fmi2FreeInstance`]; `references` holds `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    _values: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::GetString, |instance| instance.no_strings(slice(references, n, "vr")?)) }
}

/// Sets Real inputs and parameters: all of them or, on an error, none.
///
/// # Safety
/// As [`fmi2FreeInstance`]; both arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    values: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::SetReal, |instance| {
            instance.set(slice(references, n, "vr")?, slice(values, n, "value")?)
        })
    }
}

/// Sets Integer inputs and parameters: all of them or, on an error, none.
///
/// # Safety
/// As [`fmi2FreeInstance`]; both arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    values: *const fmi2Integer,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::SetInteger, |instance| {
            instance.set(slice(references, n, "vr")?, slice(values, n, "value")?)
        })
    }
}

/// Sets Boolean inputs and parameters: all of them or, on an error, none.
///
/// # Safety
/// As [`fmi2FreeInstance`]; both arrays hold `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    values: *const fmi2Boolean,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::SetBoolean, |instance| {
            instance.set(slice(references, n, "vr")?, slice(values.cast::<Flag>(), n, "value")?)
        })
    }
}

/// Fails unless `n` is 0: there are no String variables.
///
/// # Safety
/// As [`fmi2FreeInstance`]; `references` holds `n` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    component: fmi2Component,
    references: *const fmi2ValueReference,
    n: usize,
    _values: *const fmi2String,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::SetString, |instance| instance.no_strings(slice(references, n, "vr")?)) }
}

/// Executes one communication step.
///
/// # Safety
/// As [`fmi2FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: fmi2Component,
    current_communication_point: fmi2Real,
    communication_step_size: fmi2Real,
    _no_set_fmu_state_prior_to_current_point: fmi2Boolean,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::DoStep, |instance| {
            instance.do_step(current_communication_point, communication_step_size)
        })
    }
}

/// Always an error: steps are never asynchronous.
///
/// # Safety
/// As [`fmi2FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(component: fmi2Component) -> fmi2Status {
    // SAFETY: forwarded from the caller. The life cycle rejects the call before its body runs.
    unsafe { enter(component, Call::CancelStep, |_| Ok(())) }
}
