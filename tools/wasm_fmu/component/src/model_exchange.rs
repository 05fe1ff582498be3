//! The interface `model-exchange`.

use crate::Fmu;
use crate::bindings::exports::fmi::fmi3::model_exchange::{
    CompletedStepResult, DiscreteStatesInfo, Guest, GuestModelExchangeInstance, IntervalFraction, IntervalQualifier,
    ModelExchangeInstance, Status, VariableDependency,
};
use crate::common::{Held, outcome};
use foldwing_fmi::fmi3::Call;
use foldwing_fmi::instance::{CallError, Instance, InterfaceKind, Manner};

impl Guest for Fmu {
    type ModelExchangeInstance = Held;
}

fn open(name: String, token: &str, logging_on: bool) -> Option<ModelExchangeInstance> {
    Held::open(InterfaceKind::ModelExchange, name, token, logging_on, Manner::default()).map(ModelExchangeInstance::new)
}

impl Held {
    /// A vector of one number per state or event indicator.
    fn vector(
        &self,
        call: Call,
        count: impl FnOnce(&Instance) -> usize,
        fill: impl FnOnce(&mut Instance, &mut [f64]) -> Result<(), CallError>,
    ) -> Result<Vec<f64>, Status> {
        self.call(call, |instance| {
            let mut values = vec![0.0; count(instance)];
            fill(instance, &mut values)?;
            Ok(values)
        })
    }
}

impl GuestModelExchangeInstance for Held {
    #[cfg(not(feature = "resource-path"))]
    fn instantiate_model_exchange(name: String, token: String, _visible: bool, logging_on: bool) -> Option<ModelExchangeInstance> {
        open(name, &token, logging_on)
    }

    #[cfg(feature = "resource-path")]
    fn instantiate_model_exchange(
        name: String,
        token: String,
        _resource_path: String,
        _visible: bool,
        logging_on: bool,
    ) -> Option<ModelExchangeInstance> {
        open(name, &token, logging_on)
    }

    methods!();

    fn enter_continuous_time_mode(&self) -> Status {
        outcome(self.call(Call::EnterContinuousTimeMode, |instance| {
            instance.enter_continuous_time();
            Ok(())
        }))
    }

    fn enter_step_mode(&self) -> Status {
        // in the interface of Model Exchange too, where FMI 3.0 does not have it
        outcome(self.refuse(Call::EnterStepMode))
    }

    fn set_time(&self, time_s: f64) -> Status {
        outcome(self.call(Call::SetTime, |instance| instance.set_time(time_s)))
    }

    fn set_continuous_states(&self, states: Vec<f64>) -> Status {
        outcome(self.call(Call::SetContinuousStates, |instance| instance.set_continuous_states(&states)))
    }

    fn get_continuous_state_derivatives(&self) -> Result<Vec<f64>, Status> {
        self.vector(Call::GetContinuousStateDerivatives, Instance::state_count, Instance::derivatives)
    }

    fn get_event_indicators(&self) -> Result<Vec<f64>, Status> {
        self.vector(Call::GetEventIndicators, Instance::indicator_count, Instance::event_indicators)
    }

    fn get_continuous_states(&self) -> Result<Vec<f64>, Status> {
        self.vector(Call::GetContinuousStates, Instance::state_count, Instance::continuous_states)
    }

    fn get_nominals_of_continuous_states(&self) -> Result<Vec<f64>, Status> {
        self.vector(Call::GetNominalsOfContinuousStates, Instance::state_count, |instance, values| instance.nominals(values))
    }

    fn get_number_of_event_indicators(&self) -> Result<u64, Status> {
        self.call(Call::GetNumberOfEventIndicators, |instance| Ok(instance.indicator_count() as u64))
    }

    fn get_number_of_continuous_states(&self) -> Result<u64, Status> {
        self.call(Call::GetNumberOfContinuousStates, |instance| Ok(instance.state_count() as u64))
    }

    fn completed_integrator_step(&self, _: bool) -> Result<CompletedStepResult, Status> {
        self.call(Call::CompletedIntegratorStep, |instance| {
            Ok(CompletedStepResult { enter_event_mode: instance.completed_integrator_step()?, terminate_simulation: false })
        })
    }
}
