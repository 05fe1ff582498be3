//! Exported functions of the steps of co-simulation.

use super::types::{fmi3Boolean, fmi3Float64, fmi3Instance, fmi3Status};
use crate::types::fmi2OK;
use crate::{Held, enter, place};
use foldwing_fmi::fmi3::Call;
use foldwing_fmi::instance::{Phase, Reached, Rule};
use std::sync::atomic::Ordering;

/// Rule of the call that continues a step after a callback to the importer.
const GOING_ON: Rule =
    Rule { phases: Phase::StepComplete.bit() | Phase::IntermediateUpdate.bit(), ..Call::DoStep.rule() };

/// Enters Step Mode.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: fmi3Instance) -> fmi3Status {
    // SAFETY: forwarded from the caller.
    unsafe {
        enter(instance, Call::EnterStepMode, |instance| {
            instance.enter_step_mode();
            Ok(())
        })
    }
}

/// Executes one communication step. It ends early if the importer uses Event Mode and allows it, at an event that the importer handles, and
/// at the end of an internal step if the importer requests it.
///
/// # Safety
/// `instance` is null or came from an instantiation and has not been freed; the results are null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: fmi3Instance,
    current_communication_point: fmi3Float64,
    communication_step_size: fmi3Float64,
    _no_set_fmu_state_prior_to_current_point: fmi3Boolean,
    event_handling_needed: *mut fmi3Boolean,
    terminate_simulation: *mut fmi3Boolean,
    early_return: *mut fmi3Boolean,
    last_successful_time: *mut fmi3Float64,
) -> fmi3Status {
    let mut wanted_s = current_communication_point;
    // SAFETY: forwarded from the caller.
    let begun = unsafe {
        enter(instance, Call::DoStep, |instance| {
            let event = place(event_handling_needed, "eventHandlingNeeded")?;
            let end = place(terminate_simulation, "terminateSimulation")?;
            let early = place(early_return, "earlyReturn")?;
            let last_s = place(last_successful_time, "lastSuccessfulTime")?;
            (*event, *end, *early) = (false, false, false);
            *last_s = instance.last_successful_time_s();
            wanted_s = instance.begin_step(current_communication_point, communication_step_size)?;
            Ok(())
        })
    };
    if begun != fmi2OK {
        return begun;
    }
    // SAFETY: the call above has verified that it is alive, and it is not freed during a step.
    let held = unsafe { &*instance.cast::<Held>() };
    held.stepping.store(true, Ordering::Release);
    let mut end_s = wanted_s;
    let status = loop {
        let mut reached = Reached::End;
        // SAFETY: as above; the results have been verified not to be null.
        let status = unsafe {
            enter(instance, GOING_ON, |instance| {
                let outcome = instance.go_on(end_s);
                *last_successful_time = instance.last_successful_time_s();
                reached = outcome?;
                *event_handling_needed = reached == Reached::Event;
                *early_return = *last_successful_time < wanted_s;
                Ok(())
            })
        };
        if status != fmi2OK || reached != Reached::Step {
            break status;
        }
        // SAFETY: as above.
        let now_s = unsafe { *last_successful_time };
        end_s = held.asked.map_or(end_s, |asked| asked.until(now_s, end_s, held.returns_early()));
        if end_s <= now_s {
            // SAFETY: as above.
            break unsafe {
                enter(instance, GOING_ON, |instance| {
                    instance.give_up_step();
                    Ok(())
                })
            };
        }
    };
    held.stepping.store(false, Ordering::Release);
    status
}
