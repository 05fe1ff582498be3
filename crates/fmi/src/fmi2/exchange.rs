//! Model Exchange: the importer integrates, the instance gives derivatives and makes events.

use crate::fmi2::error::CallError;
use crate::fmi2::instance::Instance;
use crate::fmi2::life_cycle::{Call, InterfaceKind, Phase};
use crate::fmi2::log::LogCategory;
use foldwing_engine::plant::{JointStatus, PlantError};

/// What an event has led to, `fmi2EventInfo`: one update settles every event, and nothing here ever ends a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventInfo {
    /// The continuous states are others now.
    pub states_changed: bool,
    /// Time of the next event that is known before, in s.
    pub next_event_s: Option<f64>,
}

impl Instance {
    /// `fmi2EnterEventMode`.
    pub fn enter_event(&mut self) -> Result<(), CallError> {
        self.found(|instance| instance.plant.system_mut().enter_exchange_event())?;
        self.phase = Phase::Event;
        Ok(())
    }

    /// `fmi2NewDiscreteStates`: makes all transitions of the event.
    pub fn new_discrete_states(&mut self) -> Result<EventInfo, CallError> {
        let before: Option<Vec<JointStatus>> =
            self.log.wants(LogCategory::Events).then(|| self.plant.joint_statuses().collect());
        let states_changed = self.plant.system_mut().make_exchange_event()?;
        if let Some(before) = before {
            self.tell_events(Call::NewDiscreteStates, self.plant.exchange_time_s(), &before);
        }
        let next_s = self.plant.system_mut().next_exchange_event_s();
        Ok(EventInfo { states_changed, next_event_s: next_s.is_finite().then_some(next_s) })
    }

    /// `fmi2EnterContinuousTimeMode`.
    pub fn enter_continuous_time(&mut self) {
        self.plant.system_mut().leave_exchange_event();
        self.phase = Phase::ContinuousTime;
    }

    /// `fmi2CompletedIntegratorStep`: true where the importer must enter Event Mode.
    pub fn completed_integrator_step(&mut self) -> Result<bool, CallError> {
        self.found(|instance| instance.plant.system_mut().complete_exchange_step())
    }

    /// `fmi2SetTime`, s.
    pub fn set_time(&mut self, time_s: f64) -> Result<(), CallError> {
        if !time_s.is_finite() {
            return Err(CallError::Argument { argument: "time", value: time_s, allowed: "finite" });
        }
        self.plant.system_mut().set_exchange_time(time_s);
        Ok(())
    }

    /// `fmi2SetContinuousStates`.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), CallError> {
        self.check_states(states.len())?;
        if let Some(state) = states.iter().position(|state| !state.is_finite()) {
            let name = self.interface.state_name(state).to_owned();
            return Err(CallError::StateNotFinite { name, value: states[state] });
        }
        self.plant.system_mut().set_exchange_states(states);
        Ok(())
    }

    /// `fmi2GetContinuousStates`.
    pub fn continuous_states(&mut self, states: &mut [f64]) -> Result<(), CallError> {
        self.check_states(states.len())?;
        self.evaluate()?;
        states.copy_from_slice(self.plant.exchange_states());
        Ok(())
    }

    /// `fmi2GetNominalsOfContinuousStates`.
    pub fn nominals(&self, nominals: &mut [f64]) -> Result<(), CallError> {
        self.check_states(nominals.len())?;
        nominals.copy_from_slice(self.interface.nominals());
        Ok(())
    }

    /// `fmi2GetDerivatives`.
    pub fn derivatives(&mut self, derivatives: &mut [f64]) -> Result<(), CallError> {
        self.check_states(derivatives.len())?;
        self.evaluate()?;
        self.found(|instance| instance.plant.system_mut().update_exchange())?;
        derivatives.copy_from_slice(self.plant.exchange_derivatives());
        Ok(())
    }

    /// `fmi2GetEventIndicators`.
    pub fn event_indicators(&mut self, indicators: &mut [f64]) -> Result<(), CallError> {
        let own = self.plant.exchange_indicator_count();
        if indicators.len() != own {
            return Err(CallError::Count { argument: "ni", given: indicators.len(), own });
        }
        self.evaluate()?;
        self.found(|instance| instance.plant.system_mut().update_exchange())?;
        indicators.copy_from_slice(self.plant.exchange_indicators());
        Ok(())
    }

    fn check_states(&self, given: usize) -> Result<(), CallError> {
        let own = self.plant.exchange_state_count();
        if given == own { Ok(()) } else { Err(CallError::Count { argument: "nx", given, own }) }
    }

    /// Brings the present to what the importer has set, where one of these rows is computed from it.
    pub(super) fn update(&mut self, references: &[u32]) -> Result<(), CallError> {
        let moves = || references.iter().any(|&reference| self.interface.moves(reference));
        if self.kind == InterfaceKind::ModelExchange && !self.stale && moves() {
            self.found(|instance| instance.plant.system_mut().update_exchange())?;
        }
        Ok(())
    }

    /// Refuses what cannot change while the importer integrates.
    pub(super) fn refuse_discrete(&self, references: &[u32]) -> Result<(), CallError> {
        let discrete = |reference: &&u32| !self.interface.is_continuous_input(**reference);
        match references.iter().find(discrete).filter(|_| self.phase == Phase::ContinuousTime) {
            None => Ok(()),
            Some(&reference) => {
                let row = self.interface.variables().get(reference as usize);
                let name = row.map_or_else(|| format!("of value reference {reference}"), |row| row.name.clone());
                Err(CallError::OnlyContinuousInputs { name })
            }
        }
    }

    /// A trial of the importer's integrator that has no solution is refused, and another one may follow.
    fn found<T>(&mut self, find: impl FnOnce(&mut Self) -> Result<T, PlantError>) -> Result<T, CallError> {
        find(self).map_err(CallError::NoDerivatives)
    }
}
