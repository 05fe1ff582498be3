//! Steps with pauses for the caller, and events on request.

use crate::run::Plant;
use crate::system::PlantError;
use crate::system::state::State;

/// Conditions for a pause before the end of a communication step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Pauses {
    /// At crossings of force indicators, before the transitions, which [`Plant::make_event`] or otherwise the next step performs.
    pub at_events: bool,
    /// At the end of each integrator step.
    pub at_steps: bool,
}

/// Point at which a communication step has stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// The end of the communication step, or an event there that was performed.
    End,
    /// A pending event, which may be at the end of the communication step.
    Event,
    /// The end of an integrator step within the communication step.
    Step,
}

impl Plant {
    /// Returns the pause at the end of the integrator's step, if that is after the current time and within the communication step to
    /// `end_s`.
    pub(crate) fn pause(&self, pauses: Pauses, end_s: f64) -> Option<Reached> {
        let State { now, ahead, .. } = &self.system.state;
        if ahead.time_s <= now.time_s || ahead.time_s > end_s {
            None
        } else if pauses.at_events && self.event_waits() {
            Some(Reached::Event)
        } else if pauses.at_steps && ahead.time_s < end_s {
            Some(Reached::Step)
        } else {
            None
        }
    }

    /// Whether an indicator is crossed at the end of the integrator's step, or a failure occurs there.
    fn event_waits(&self) -> bool {
        let State { joints, ahead, .. } = &self.system.state;
        joints.iter().any(|joint| joint.crossed != 0) || self.system.equations.failure_s <= ahead.time_s
    }

    /// Performs an event at the current time: first the transitions of the forces whose indicators were crossed here in the last step, then
    /// changes of inputs and parameters. Has no effect if neither is due. The outputs are those after the event. After an error the state
    /// is unchanged. Allocates nothing.
    pub fn make_event(&mut self) -> Result<(), PlantError> {
        let State { now, ahead, .. } = &self.system.state;
        let crossed = ahead.time_s <= now.time_s && self.event_waits();
        let changed = self.system.inputs_changed();
        if !(crossed || changed) {
            return Ok(());
        }
        self.system.begin.copy_from(&self.system.state);
        self.allow_work(0.0);
        let outcome = self.cross(crossed).and_then(|()| self.follow(changed));
        match outcome {
            Ok(()) => {
                let State { start, now, .. } = &mut self.system.state;
                now.copy_from(start);
                self.system.inputs_may_differ = false;
            }
            Err(_) => self.system.go_back_to_begin(),
        }
        self.system.state.arrive();
        self.system.forget_outputs();
        if outcome.is_ok() {
            self.refuse_infinite(self.system.time_s())?;
        }
        self.system.provide(self.system.watched);
        outcome
    }

    /// Performs the transitions of the crossed indicators.
    fn cross(&mut self, crossed: bool) -> Result<(), PlantError> {
        if !crossed {
            return Ok(());
        }
        let State { before, start, ahead, now, .. } = &mut self.system.state;
        if ahead.time_s > start.time_s {
            before.copy_from(start);
        }
        start.copy_from(ahead);
        now.copy_from(ahead);
        self.system.apply_events()?;
        let State { start, now, .. } = &mut self.system.state;
        now.copy_from(start);
        Ok(())
    }

    /// Applies inputs and parameters if they have changed.
    fn follow(&mut self, changed: bool) -> Result<(), PlantError> {
        if changed { self.system.apply_inputs().and_then(|()| self.renew_air()) } else { Ok(()) }
    }
}
