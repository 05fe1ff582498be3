//! Exported functions of Model Exchange.

use super::types::{fmi2Boolean, fmi2Component, fmi2EventInfo, fmi2False, fmi2Real, fmi2Status};
use super::vectors::vectors;
use super::{enter, place};
use foldwing_fmi::fmi2::Call;

/// Enters Event Mode.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(component: fmi2Component) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::EnterEventMode, |instance| instance.enter_event()) }
}

/// Executes the transitions of the event: a latch closes, a lock engages, changed inputs act.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; `info` is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(component: fmi2Component, info: *mut fmi2EventInfo) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::NewDiscreteStates, |instance| {
            let info = place(info, "eventInfo")?;
            let event = instance.new_discrete_states()?;
            *info = fmi2EventInfo {
                newDiscreteStatesNeeded: fmi2False,
                terminateSimulation: fmi2False,
                nominalsOfContinuousStatesChanged: fmi2False,
                valuesOfContinuousStatesChanged: fmi2Boolean::from(event.states_changed),
                nextEventTimeDefined: fmi2Boolean::from(event.next_event_s.is_some()),
                nextEventTime: event.next_event_s.unwrap_or(0.0),
            };
            Ok(())
        })
    }
}

/// Enters Continuous-Time Mode.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(component: fmi2Component) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::EnterContinuousTimeMode, |instance| {
            instance.enter_continuous_time();
            Ok(())
        })
    }
}

/// Completes a step of the importer's integrator; returns whether it must enter Event Mode.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed; the two results are null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    component: fmi2Component,
    _no_set_fmu_state_prior_to_current_point: fmi2Boolean,
    enter_event_mode: *mut fmi2Boolean,
    terminate_simulation: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(component, Call::CompletedIntegratorStep, |instance| {
            let (event, end) =
                (place(enter_event_mode, "enterEventMode")?, place(terminate_simulation, "terminateSimulation")?);
            *event = fmi2Boolean::from(instance.completed_integrator_step()?);
            *end = fmi2False;
            Ok(())
        })
    }
}

/// Sets the time in s.
///
/// # Safety
/// `component` is null or came from `fmi2Instantiate` and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(component: fmi2Component, time: fmi2Real) -> fmi2Status {
    // SAFETY: forwarded from the caller.
    unsafe { enter(component, Call::SetTime, |instance| instance.set_time(time)) }
}

vectors! {
    /// Sets all continuous states.
    set fmi2SetContinuousStates(fmi2Component, fmi2Real) Call::SetContinuousStates, "x", set_continuous_states;
    /// Time derivatives of all continuous states.
    get fmi2GetDerivatives(fmi2Component, fmi2Real) Call::GetDerivatives, "derivatives", derivatives;
    /// All event indicators.
    get fmi2GetEventIndicators(fmi2Component, fmi2Real) Call::GetEventIndicators, "eventIndicators", event_indicators;
    /// All continuous states.
    get fmi2GetContinuousStates(fmi2Component, fmi2Real) Call::GetContinuousStates, "x", continuous_states;
    /// Nominal magnitudes of all continuous states.
    get fmi2GetNominalsOfContinuousStates(fmi2Component, fmi2Real) Call::GetNominalsOfContinuousStates, "x_nominal", nominals;
}
