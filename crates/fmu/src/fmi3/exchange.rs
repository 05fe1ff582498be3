//! Exported functions of events and Model Exchange.

use super::types::{fmi3Boolean, fmi3Float64, fmi3Instance, fmi3Status};
use crate::vectors::vectors;
use crate::{enter, place};
use foldwing_fmi::fmi3::Call;

/// Enters Event Mode.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(instance, Call::EnterEventMode, |instance| instance.enter_event()) }
}

/// Executes the transitions of the event: a latch closes, a lock engages, changed inputs act.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; the results are null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: fmi3Instance,
    discrete_states_need_update: *mut fmi3Boolean,
    terminate_simulation: *mut fmi3Boolean,
    nominals_changed: *mut fmi3Boolean,
    values_changed: *mut fmi3Boolean,
    next_event_time_defined: *mut fmi3Boolean,
    next_event_time: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::UpdateDiscreteStates, |instance| {
            let again = place(discrete_states_need_update, "discreteStatesNeedUpdate")?;
            let end = place(terminate_simulation, "terminateSimulation")?;
            let nominals = place(nominals_changed, "nominalsOfContinuousStatesChanged")?;
            let values = place(values_changed, "valuesOfContinuousStatesChanged")?;
            let defined = place(next_event_time_defined, "nextEventTimeDefined")?;
            let next = place(next_event_time, "nextEventTime")?;
            let event = instance.new_discrete_states()?;
            (*again, *end, *nominals) = (false, false, false);
            *values = event.states_changed;
            (*defined, *next) = (event.next_event_s.is_some(), event.next_event_s.unwrap_or(0.0));
            Ok(())
        })
    }
}

/// Enters Continuous-Time Mode.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::EnterContinuousTimeMode, |instance| {
            instance.enter_continuous_time();
            Ok(())
        })
    }
}

/// Completes a step of the importer's integrator; returns whether it must enter Event Mode.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; the two results are null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    instance: fmi3Instance,
    _no_set_fmu_state_prior_to_current_point: fmi3Boolean,
    enter_event_mode: *mut fmi3Boolean,
    terminate_simulation: *mut fmi3Boolean,
) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::CompletedIntegratorStep, |instance| {
            let event = place(enter_event_mode, "enterEventMode")?;
            let end = place(terminate_simulation, "terminateSimulation")?;
            (*event, *end) = (instance.completed_integrator_step()?, false);
            Ok(())
        })
    }
}

/// Sets the time in s.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(instance: fmi3Instance, time: fmi3Float64) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(instance, Call::SetTime, |instance| instance.set_time(time)) }
}

vectors! {
    /// Sets all continuous states.
    set fmi3SetContinuousStates(fmi3Instance, fmi3Float64)
        Call::SetContinuousStates, "continuousStates", set_continuous_states;
    /// Time derivatives of all continuous states.
    get fmi3GetContinuousStateDerivatives(fmi3Instance, fmi3Float64)
        Call::GetContinuousStateDerivatives, "derivatives", derivatives;
    /// All event indicators.
    get fmi3GetEventIndicators(fmi3Instance, fmi3Float64)
        Call::GetEventIndicators, "eventIndicators", event_indicators;
    /// All continuous states.
    get fmi3GetContinuousStates(fmi3Instance, fmi3Float64)
        Call::GetContinuousStates, "continuousStates", continuous_states;
    /// Nominal magnitudes of all continuous states.
    get fmi3GetNominalsOfContinuousStates(fmi3Instance, fmi3Float64)
        Call::GetNominalsOfContinuousStates, "nominals", nominals;
}

/// Number of event indicators.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; `n` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(instance: fmi3Instance, n: *mut usize) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::GetNumberOfEventIndicators, |instance| {
            *place(n, "nEventIndicators")? = instance.indicator_count();
            Ok(())
        })
    }
}

/// Number of continuous states.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; `n` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(instance: fmi3Instance, n: *mut usize) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::GetNumberOfContinuousStates, |instance| {
            *place(n, "nContinuousStates")? = instance.state_count();
            Ok(())
        })
    }
}
