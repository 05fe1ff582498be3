//! The state at a time within the integrator's step: interpolated, or by a separate step.

use crate::run::Plant;
use crate::run::march::Length;
use crate::solve::EquationsOfMotion;
use crate::solve::continuation::Taken;
use crate::solve::newton::{Effort, NewtonError};
use crate::solve::point::Point;
use crate::system::PlantError;
use crate::system::state::State;

impl Plant {
    /// Interpolates the current state at a time within the integrator's step.
    ///
    /// # Errors
    /// If rigid loops cannot be closed there.
    pub(super) fn arrive_at(&mut self, time_s: f64) -> Result<(), PlantError> {
        if self.stepper.lands() && self.land(time_s) {
            return Ok(());
        }
        let State { start, stages, ahead, now, .. } = &mut self.system.state;
        let taken = Taken { start, stages, end: ahead, continuation: &self.system.continuation };
        if taken.fill(now, time_s) {
            // interpolated states satisfy prescribed motions and constraints of joint parameters only to the interpolation error
            self.system.equations.branch_s = 0.5 * (start.time_s + ahead.time_s);
            self.system.equations.prescribe(time_s, &mut now.q, &mut now.v, &mut now.a);
            self.system.equations.project(&mut now.q, &mut now.v, &mut now.a);
            if let Err(error) = self.system.equations.close_point(now) {
                return Err(self.system.not_closed(&self.system.state.now, &error));
            }
        }
        Ok(())
    }

    /// Takes a separate step from the start of the integrator's step to a time within it, for methods without stages, whose interpolation
    /// between the ends exaggerates fast modes. Returns false at the ends, and if the step fails.
    fn land(&mut self, time_s: f64) -> bool {
        let step_s = time_s - self.system.state.start.time_s;
        if step_s <= 0.0 || time_s >= self.system.state.ahead.time_s {
            return false;
        }
        let State { start, now, .. } = &mut self.system.state;
        let (start, mut end) = (std::mem::take(start), std::mem::take(now));
        let landed = self.step_apart(&start, time_s, (&mut end, &mut []));
        (self.system.state.start, self.system.state.now) = (start, end);
        landed.is_ok()
    }

    /// Takes a step of given length from `start` into points other than those of the run, without events.
    pub(crate) fn step_apart(
        &mut self,
        start: &Point,
        time_s: f64,
        (end, stages): (&mut Point, &mut [Point]),
    ) -> Result<(), NewtonError> {
        let step_s = time_s - start.time_s;
        let accuracy = self.accuracy(step_s, Length::Given);
        let mut effort = Effort::default();
        self.system.equations.branch_s = start.time_s + 0.5 * step_s;
        let outcome =
            self.stepper.step(&mut self.system.equations, start, step_s, (end, stages), accuracy, &mut effort);
        let State { statistics, .. } = &mut self.system.state;
        statistics.iterations += effort.iterations;
        statistics.factorizations += effort.factorizations;
        end.time_s = time_s;
        outcome.map(|_| ())
    }
}
