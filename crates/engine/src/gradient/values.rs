//! Results of a run: their values, and their slopes with respect to the state at their instant.

use crate::gradient::account::Account;
use crate::gradient::outputs::{Part, Seed};
use crate::gradient::{Gradient, GradientError, RunResult};

impl<'a> Gradient<'a> {
    /// The step at which a result is known; an error for results without a derivative.
    pub(super) fn step_of(&self, result: RunResult) -> Result<usize, GradientError> {
        match result {
            RunResult::Output { index, time } => {
                self.check_output(index, time)?;
                Ok(self.tape.marks[time].step)
            }
            RunResult::LatchTime { joint } => self.latch_step(joint),
            RunResult::Impulse { joint } => self.impulse_step(joint),
            RunResult::Mean { index, time, .. } => {
                self.check_mean(index, time)?;
                Ok(self.tape.marks[time].step)
            }
        }
    }

    /// The values of results.
    ///
    /// # Errors
    /// Results that the run does not have, or that have no derivative.
    pub fn values(&mut self, results: &[RunResult]) -> Result<Vec<f64>, GradientError> {
        let value = |result: &RunResult| {
            let step = self.step_of(*result)?;
            match *result {
                RunResult::Output { index, time } => self.output_at(index, time),
                RunResult::LatchTime { .. } => Ok(self.tape.steps[step].end.time_s),
                RunResult::Impulse { joint } => Ok(self.tape.steps[step].joints[joint].latch.impulse_n_m_s),
                RunResult::Mean { .. } => Ok(self.mean_value(*result)),
            }
        };
        results.iter().map(value).collect()
    }

    /// The slopes of a result with respect to the state at its instant and to the parameters.
    pub(super) fn seed(&mut self, result: RunResult) -> Result<Seed<'a>, GradientError> {
        let step = self.step_of(result)?;
        match result {
            RunResult::Output { index, time } if Account::of(self.system, index).is_some() => {
                Ok(self.no_seed(step, Part::of(&self.tape.marks[time].branch)))
            }
            RunResult::Output { index, time } => self.output_seed(index, time),
            RunResult::LatchTime { .. } => Ok(Seed { by_shift: 1.0, ..self.no_seed(step, Part::Whole) }),
            RunResult::Impulse { joint } => {
                let coordinate = self.system.equations.forces.joints()[joint].coordinate;
                Ok(self.no_seed(step, Part::Jump(coordinate)))
            }
            RunResult::Mean { time, .. } => Ok(self.no_seed(step, Part::of(&self.tape.marks[time].branch))),
        }
    }
}
