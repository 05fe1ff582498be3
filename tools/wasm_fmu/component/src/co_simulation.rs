//! The interface `co-simulation`.

use crate::Fmu;
use crate::bindings::exports::fmi::fmi3::co_simulation::{
    CoSimulationInstance, DiscreteStatesInfo, DoStepResult, Guest, GuestCoSimulationInstance, IntervalFraction, IntervalQualifier,
    Status, VariableDependency,
};
use crate::bindings::fmi::fmi3::intermediate_update_callbacks::intermediate_update;
use crate::common::{Held, outcome};
use foldwing_fmi::fmi3::Call;
use foldwing_fmi::instance::{InterfaceKind, Manner, Phase, Reached, Rule};

/// Rule of the call that continues a step after a callback to the importer.
const GOING_ON: Rule = Rule { phases: Phase::StepComplete.bit() | Phase::IntermediateUpdate.bit(), ..Call::DoStep.rule() };

impl Guest for Fmu {
    type CoSimulationInstance = Held;
}

/// Instantiation without the arguments that differ between the drafts. A component cannot be called from within its own step, so that
/// intermediate updates serve early return alone.
fn open(name: String, token: &str, logging_on: bool, event_mode: bool, early_return: bool) -> Option<CoSimulationInstance> {
    let manner = Manner { event_mode, early_return, intermediate_update: early_return };
    Held::open(InterfaceKind::CoSimulation, name, token, logging_on, manner).map(CoSimulationInstance::new)
}

impl GuestCoSimulationInstance for Held {
    #[cfg(not(feature = "resource-path"))]
    fn instantiate_co_simulation(
        name: String,
        token: String,
        _visible: bool,
        logging_on: bool,
        event_mode: bool,
        early_return: bool,
        _required: Vec<u32>,
    ) -> Option<CoSimulationInstance> {
        open(name, &token, logging_on, event_mode, early_return)
    }

    #[cfg(feature = "resource-path")]
    fn instantiate_co_simulation(
        name: String,
        token: String,
        _resource_path: String,
        _visible: bool,
        logging_on: bool,
        event_mode: bool,
        early_return: bool,
        _required: Vec<u32>,
    ) -> Option<CoSimulationInstance> {
        open(name, &token, logging_on, event_mode, early_return)
    }

    methods!();

    fn set_input_derivatives(&self, _: Vec<(u32, u32)>, _: Vec<f64>) -> Status {
        self.unknown("set-input-derivatives")
    }

    fn do_step(&self, time_s: f64, step_s: f64, _: bool) -> Result<DoStepResult, Status> {
        let wanted_s = self.call(Call::DoStep, |instance| instance.begin_step(time_s, step_s))?;
        let mut end_s = wanted_s;
        loop {
            let (reached, now_s, may_return) = self.call(GOING_ON, |instance| {
                let reached = instance.go_on(end_s)?;
                Ok((reached, instance.last_successful_time_s(), instance.manner().early_return))
            })?;
            if reached == Reached::Step {
                let (returns, at_s) = intermediate_update(now_s, false, true, true, may_return);
                if returns && may_return {
                    end_s = if at_s.is_nan() { now_s } else { at_s.clamp(now_s, end_s) };
                }
                if end_s > now_s {
                    continue;
                }
                self.call(GOING_ON, |instance| {
                    instance.give_up_step();
                    Ok(())
                })?;
            }
            return Ok(DoStepResult {
                last_successful_time: now_s,
                event_handling_needed: reached == Reached::Event,
                terminate_simulation: false,
                early_return: now_s < wanted_s,
            });
        }
    }

    fn enter_step_mode(&self) -> Status {
        outcome(self.call(Call::EnterStepMode, |instance| {
            instance.enter_step_mode();
            Ok(())
        }))
    }
}
