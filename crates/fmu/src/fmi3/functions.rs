//! Exported functions of the life cycle.

use super::types::{
    fmi3Boolean, fmi3ClockUpdateCallback, fmi3Float64, fmi3Instance, fmi3InstanceEnvironment,
    fmi3IntermediateUpdateCallback, fmi3LockPreemptionCallback, fmi3LogMessageCallback, fmi3Status, fmi3String,
    fmi3UnlockPreemptionCallback, fmi3ValueReference,
};
use super::{Asked, sink};
use crate::enter;
use crate::instantiation::{Texts, Wanted, free, instantiate, set_log_categories};
use foldwing_fmi::fmi3::Call;
use foldwing_fmi::instance::{Instance, InstantiationError, Log, Manner, Setup, Status, Version};
use std::ffi::c_char;
use std::ptr;

/// Version of the standard: `3.0`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Switches log categories on or off; no category means all.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; `categories` holds `n_categories` texts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: fmi3Instance,
    logging_on: fmi3Boolean,
    n_categories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::SetDebugLogging, |instance| {
            set_log_categories(instance, logging_on, n_categories, categories)
        })
    }
}

/// Arguments of the texts, by their names in the standard.
fn texts(name: fmi3String, token: fmi3String, resources: fmi3String) -> Texts {
    Texts { name: (name, "instanceName"), token: (token, "instantiationToken"), resources: (resources, "resourcePath") }
}

/// Returns a new instance for Model Exchange, or null after a message with the cause.
///
/// # Safety
/// Texts are null or zero-terminated; `log_message` stays callable until the instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instance_name: fmi3String,
    instantiation_token: fmi3String,
    resource_path: fmi3String,
    _visible: fmi3Boolean,
    logging_on: fmi3Boolean,
    instance_environment: fmi3InstanceEnvironment,
    log_message: fmi3LogMessageCallback,
) -> fmi3Instance {
    // SAFETY: forwarded from the caller.
    let log = Log::new(unsafe { sink(log_message, instance_environment) }, logging_on);
    let wanted = Wanted { version: Version::Fmi3, fmu_type: 0, manner: Manner::default(), asked: None };
    let texts = texts(instance_name, instantiation_token, resource_path);
    // SAFETY: forwarded from the caller.
    unsafe { instantiate("fmi3InstantiateModelExchange", &texts, wanted, log) }
}

/// Returns a new instance for co-simulation, or null after a message with the cause. Within a step, all variables can be read.
///
/// # Safety
/// Texts are null or zero-terminated; `log_message` and `intermediate_update` stay callable until the instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instance_name: fmi3String,
    instantiation_token: fmi3String,
    resource_path: fmi3String,
    _visible: fmi3Boolean,
    logging_on: fmi3Boolean,
    event_mode_used: fmi3Boolean,
    early_return_allowed: fmi3Boolean,
    _required_intermediate_variables: *const fmi3ValueReference,
    _n_required_intermediate_variables: usize,
    instance_environment: fmi3InstanceEnvironment,
    log_message: fmi3LogMessageCallback,
    intermediate_update: fmi3IntermediateUpdateCallback,
) -> fmi3Instance {
    // SAFETY: forwarded from the caller.
    let log = Log::new(unsafe { sink(log_message, instance_environment) }, logging_on);
    let asked = intermediate_update.map(|update| Asked { update, environment: instance_environment });
    let manner = Manner {
        event_mode: event_mode_used,
        early_return: early_return_allowed,
        intermediate_update: asked.is_some(),
    };
    let wanted = Wanted { version: Version::Fmi3, fmu_type: 1, manner, asked };
    let texts = texts(instance_name, instantiation_token, resource_path);
    // SAFETY: forwarded from the caller.
    unsafe { instantiate("fmi3InstantiateCoSimulation", &texts, wanted, log) }
}

/// Always null after a message: there is no Scheduled Execution.
///
/// # Safety
/// `log_message` is null or callable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instance_name: fmi3String,
    _instantiation_token: fmi3String,
    _resource_path: fmi3String,
    _visible: fmi3Boolean,
    logging_on: fmi3Boolean,
    instance_environment: fmi3InstanceEnvironment,
    log_message: fmi3LogMessageCallback,
    _clock_update: fmi3ClockUpdateCallback,
    _lock_preemption: fmi3LockPreemptionCallback,
    _unlock_preemption: fmi3UnlockPreemptionCallback,
) -> fmi3Instance {
    // SAFETY: forwarded from the caller.
    let log = Log::new(unsafe { sink(log_message, instance_environment) }, logging_on);
    let error = InstantiationError::NoScheduledExecution;
    log.refuse(Status::Error, &format!("fmi3InstantiateScheduledExecution: {error}"));
    ptr::null_mut()
}

/// Frees an instance with its saved states; null is ignored, and so is a call from the instance's own callbacks.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    // SAFETY: forwarded from the caller.
    unsafe { free(instance) }
}

/// Sets times and tolerance of the experiment; start values set after this call are evaluated when they are read.
///
/// # Safety
/// As [`fmi3FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: fmi3Instance,
    tolerance_defined: fmi3Boolean,
    tolerance: fmi3Float64,
    start_time: fmi3Float64,
    stop_time_defined: fmi3Boolean,
    stop_time: fmi3Float64,
) -> fmi3Status {
    let setup = Setup {
        tolerance: tolerance_defined.then_some(tolerance),
        start_s: start_time,
        stop_s: stop_time_defined.then_some(stop_time),
    };
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::EnterInitializationMode, |instance| {
            instance.setup_experiment(setup)?;
            instance.enter_initialization();
            Ok(())
        })
    }
}

/// Ends the initialisation: in Step Mode, or in Event Mode if the importer uses it.
///
/// # Safety
/// As [`fmi3FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(instance, Call::ExitInitializationMode, Instance::exit_initialization) }
}

/// Ends the simulation; values can still be read.
///
/// # Safety
/// As [`fmi3FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::Terminate, |instance| {
            instance.terminate();
            Ok(())
        })
    }
}

/// Resets the instance to its state after instantiation.
///
/// # Safety
/// As [`fmi3FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::Reset, |instance| {
            instance.reset();
            Ok(())
        })
    }
}
