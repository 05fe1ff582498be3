//! Events in both interface types, and Model Exchange: the importer integrates, the instance computes derivatives.

use crate::instance::Instance;
use crate::instance::error::CallError;
use crate::instance::log::LogCategory;
use crate::instance::phase::{InterfaceKind, Phase};
use crate::instance::step::CLOCK_TOLERANCE;
use crate::interface::{Kind, Selection};
use foldwing_engine::plant::{JointStatus, PlantError};

/// Result of an event update: one update completes every event, and no event ends the simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventInfo {
    /// The continuous states have changed.
    pub states_changed: bool,
    /// Time of the next time event in s.
    pub next_event_s: Option<f64>,
}

impl Instance {
    /// Enters Event Mode.
    pub fn enter_event(&mut self) -> Result<(), CallError> {
        match self.kind {
            InterfaceKind::ModelExchange => {
                self.found(|instance| instance.plant.system_mut().enter_exchange_event())?;
            }
            InterfaceKind::CoSimulation if !self.manner.event_mode => return Err(CallError::NoEventMode),
            InterfaceKind::CoSimulation => {}
        }
        self.phase = Phase::Event;
        Ok(())
    }

    /// Executes all transitions of the event: crossed indicators, changed inputs and parameters.
    pub fn new_discrete_states(&mut self) -> Result<EventInfo, CallError> {
        let before: Option<Vec<JointStatus>> =
            self.log.wants(LogCategory::Events).then(|| self.plant.joint_statuses().collect());
        let (states_changed, time_s, next_s) = match self.kind {
            InterfaceKind::ModelExchange => {
                let changed = self.plant.system_mut().make_exchange_event()?;
                let next_s = self.plant.system_mut().next_exchange_event_s();
                (changed, self.plant.exchange_time_s(), next_s)
            }
            // kinks of input time histories lie within steps and change no discrete state
            InterfaceKind::CoSimulation => {
                self.plant.make_event()?;
                (false, self.plant.time_s(), f64::INFINITY)
            }
        };
        if let Some(before) = before {
            self.tell_events(self.version.event_call(), time_s, &before);
        }
        Ok(EventInfo { states_changed, next_event_s: next_s.is_finite().then_some(next_s) })
    }

    /// Enters Step Mode, for the next step.
    pub fn enter_step_mode(&mut self) {
        self.phase = Phase::StepComplete;
    }

    /// Number of continuous states.
    pub fn state_count(&self) -> usize {
        self.plant.exchange_state_count()
    }

    /// Number of event indicators.
    pub fn indicator_count(&self) -> usize {
        self.plant.exchange_indicator_count()
    }

    /// Enters Continuous-Time Mode.
    pub fn enter_continuous_time(&mut self) {
        self.plant.system_mut().leave_exchange_event();
        self.phase = Phase::ContinuousTime;
    }

    /// Completes a step of the importer's integrator; returns true if the importer must enter Event Mode.
    pub fn completed_integrator_step(&mut self) -> Result<bool, CallError> {
        self.found(|instance| instance.plant.system_mut().complete_exchange_step())
    }

    /// Sets the time in s.
    pub fn set_time(&mut self, time_s: f64) -> Result<(), CallError> {
        if !time_s.is_finite() {
            return Err(CallError::Argument { argument: "time", value: time_s, allowed: "finite" });
        }
        let event_s = self.plant.system_mut().exchange_event_s();
        if time_s < event_s - CLOCK_TOLERANCE * event_s.abs().max(1.0) {
            return Err(CallError::BeforeEvent { version: self.version, time_s, event_s });
        }
        self.plant.system_mut().set_exchange_time(time_s);
        Ok(())
    }

    /// Sets all continuous states.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), CallError> {
        self.check_states(states.len())?;
        if let Some(state) = states.iter().position(|state| !state.is_finite()) {
            let name = self.interface.state_name(state).to_owned();
            return Err(CallError::StateNotFinite { name, value: states[state] });
        }
        self.plant.system_mut().set_exchange_states(states);
        Ok(())
    }

    /// Copies all continuous states.
    pub fn continuous_states(&mut self, states: &mut [f64]) -> Result<(), CallError> {
        self.check_states(states.len())?;
        self.evaluate()?;
        states.copy_from_slice(self.plant.exchange_states());
        Ok(())
    }

    /// Copies the nominal magnitudes of all continuous states.
    pub fn nominals(&self, nominals: &mut [f64]) -> Result<(), CallError> {
        self.check_states(nominals.len())?;
        nominals.copy_from_slice(self.interface.nominals());
        Ok(())
    }

    /// Computes the time derivatives of all continuous states.
    pub fn derivatives(&mut self, derivatives: &mut [f64]) -> Result<(), CallError> {
        self.check_states(derivatives.len())?;
        self.evaluate()?;
        self.found(|instance| instance.plant.system_mut().update_exchange())?;
        derivatives.copy_from_slice(self.plant.exchange_derivatives());
        Ok(())
    }

    /// Computes all event indicators.
    pub fn event_indicators(&mut self, indicators: &mut [f64]) -> Result<(), CallError> {
        let own = self.plant.exchange_indicator_count();
        if indicators.len() != own {
            return Err(CallError::Count {
                argument: self.version.indicators_argument(),
                given: indicators.len(),
                own,
            });
        }
        self.evaluate()?;
        self.found(|instance| instance.plant.system_mut().update_exchange())?;
        indicators.copy_from_slice(self.plant.exchange_indicators());
        Ok(())
    }

    fn check_states(&self, given: usize) -> Result<(), CallError> {
        let own = self.plant.exchange_state_count();
        if given == own {
            Ok(())
        } else {
            Err(CallError::Count { argument: self.version.states_argument(), given, own })
        }
    }

    /// Updates the model to the values set by the importer if any of the selected rows, `count` values of one type, is
    /// computed from them.
    pub(super) fn update(&mut self, selection: impl Selection, kind: Kind, count: usize) -> Result<(), CallError> {
        let moves = || selection.heads(&self.interface).any(|reference| self.interface.moves(reference));
        if self.kind == InterfaceKind::ModelExchange && !self.stale && moves() {
            // errors of the call have priority over errors of the states
            selection.check(&self.interface, kind, count)?;
            self.found(|instance| instance.plant.system_mut().update_exchange())?;
        }
        Ok(())
    }

    /// Runs a computation at a trial point of the importer's integrator. Returns `Discard` if there is no solution there; the
    /// integrator may try another point.
    pub(super) fn found<T>(&mut self, find: impl FnOnce(&mut Self) -> Result<T, PlantError>) -> Result<T, CallError> {
        find(self).map_err(|cause| {
            let states = self.plant.exchange_states();
            let over = |state: &usize| states[*state].abs() / self.interface.nominals()[*state];
            let farthest = (0..states.len()).max_by(|a, b| over(a).total_cmp(&over(b))).unwrap_or(0);
            let state = self.interface.state_name(farthest).to_owned();
            CallError::NoDerivatives { cause, state, value: states.get(farthest).copied().unwrap_or(0.0) }
        })
    }
}
