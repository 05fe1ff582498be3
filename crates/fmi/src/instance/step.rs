//! Steps of co-simulation, as a whole or with pauses at events and intermediate times.

use crate::instance::error::CallError;
use crate::instance::{Instance, LogCategory, Phase, SavedState, Status};
use foldwing_engine::plant::{JointStatus, Pauses, Reached};
use std::time::Instant;

/// Accepted relative round-off of the importer's clock.
pub(super) const CLOCK_TOLERANCE: f64 = 1e-9;

impl Instance {
    /// Executes one step of `step_s` from `time_s`. Allocates nothing itself unless it fails or logs.
    pub fn do_step(&mut self, time_s: f64, step_s: f64) -> Result<(), CallError> {
        let end_s = self.begin_step(time_s, step_s)?;
        self.march(end_s, Pauses::default()).map(|_| ())
    }

    /// Starts a step that [`Instance::go_on`] executes; returns its end in s.
    pub fn begin_step(&mut self, time_s: f64, step_s: f64) -> Result<f64, CallError> {
        let end_s = time_s + step_s;
        if !(step_s > 0.0 && end_s.is_finite() && end_s > time_s) {
            return Err(CallError::StepSize { time_s, step_s });
        }
        let tolerance_s = CLOCK_TOLERANCE * step_s.max(time_s.abs()).max(1.0);
        let own_s = self.plant.time_s();
        if (time_s - own_s).abs() > tolerance_s {
            return Err(CallError::TimeMismatch { time_s, own_s });
        }
        if let Some(stop_s) = self.experiment.stop_s.filter(|stop_s| end_s > stop_s + tolerance_s) {
            return Err(CallError::BeyondStop { version: self.version, end_s, stop_s });
        }
        let longest_s = self.plant.longest_step_s();
        if step_s > longest_s {
            return Err(CallError::StepTooLong { time_s, step_s, longest_s });
        }
        if time_s != own_s {
            self.plant.adopt_time(time_s);
        }
        self.read_before = std::mem::take(&mut self.read);
        self.spent_s = 0.0;
        Ok(end_s)
    }

    /// Continues a step to its end or to the next pause agreed with the importer. After [`Reached::Step`] the instance is in Intermediate
    /// Update Mode, until this function is called again or the step is [ended early](Instance::give_up_step).
    pub fn go_on(&mut self, end_s: f64) -> Result<Reached, CallError> {
        self.phase = Phase::StepComplete;
        let pauses = Pauses {
            at_events: self.manner.event_mode && self.manner.early_return,
            at_steps: self.manner.intermediate_update,
        };
        let reached = self.march(end_s, pauses)?;
        if reached == Reached::Step {
            self.phase = Phase::IntermediateUpdate;
        }
        Ok(reached)
    }

    /// Ends a step early, at its pause.
    pub fn give_up_step(&mut self) {
        self.phase = Phase::StepComplete;
    }

    fn march(&mut self, end_s: f64, pauses: Pauses) -> Result<Reached, CallError> {
        let call = self.version.step_call();
        let before: Option<Vec<JointStatus>> =
            self.log.wants(LogCategory::Events).then(|| self.plant.joint_statuses().collect());
        let (begin_s, advised) = (self.plant.time_s(), self.advice_on_rows().is_some());
        let failing = self.plant.statistics().newton_decides();
        let stalled = self.plant.statistics().stalled_steps > 0;
        let started = self.machine.solver.most_iterations.map(|_| Instant::now());
        let outcome = self.plant.step_with_pauses(end_s, pauses);
        if let Some(started) = started {
            self.spent_s += started.elapsed().as_secs_f64();
            if !matches!(outcome, Ok(Reached::Step)) {
                self.plant.latency_mut().record(self.spent_s);
            }
        }
        if let Some(before) = before {
            self.tell_events(call, begin_s, &before);
        }
        if let Some(advice) = self.advice_on_rows().filter(|_| !advised) {
            self.log.write(Status::Warning, LogCategory::Warning, &format!("{call}: {advice}"));
        }
        // only after the first such step, since the count in the text increases
        if !stalled && let Some(advice) = self.plant.statistics().advice_on_stall() {
            self.log.write(Status::Warning, LogCategory::Warning, &format!("{call}: {advice}"));
        }
        if !failing && let Some(advice) = self.plant.statistics().advice_on_failures() {
            self.log.write(Status::Warning, LogCategory::Warning, &format!("{call}: {advice}"));
        }
        outcome.map_err(|error| {
            self.step_failed = true;
            self.phase = Phase::StepFailed;
            error.into()
        })
    }

    /// Status of the last step.
    pub fn step_status(&self) -> Status {
        SavedState::step_status(self.step_failed)
    }

    /// End of the last successful internal step in s.
    pub fn last_successful_time_s(&self) -> f64 {
        self.plant.time_s()
    }

    /// Advice on wake rows that are too long, if warnings are logged.
    fn advice_on_rows(&self) -> Option<String> {
        let air = self.machine.air.as_ref().filter(|_| self.log.wants(LogCategory::Warning))?;
        self.plant.statistics().advice_on_rows(air.step_s)
    }

    /// Logs one message per release, lock, latch closing and opening of a step that started at `start_s`. Releases, locks and openings
    /// follow from inputs, which act at the start of the step.
    pub(super) fn tell_events(&self, call: &str, start_s: f64, before: &[JointStatus]) {
        for ((body, before), now) in self.plant.revolute_joints().iter().zip(before).zip(self.plant.joint_statuses()) {
            let name = &self.machine.bodies[*body].joint.name;
            let tell = |event: &str, time_s: f64| {
                let text = format!("{}: joint {name}: {event} at t = {time_s:.9} s", call);
                self.log.write(Status::Ok, LogCategory::Events, &text);
            };
            if now.released && !before.released {
                tell("released", start_s);
            }
            if before.released && !now.released {
                tell("held", start_s);
            }
            if before.latched && (!now.latched || now.latch_count > before.latch_count) {
                tell("latch opened", start_s);
            }
            if now.latch_count > before.latch_count {
                tell("latch closed", now.latch_time_s);
            }
        }
    }
}
