//! Ends of steps at times that depend on parameters, eq. (X35).

use crate::gradient::tape::{Ending, Step};
use crate::gradient::{Gradient, GradientError};

/// Difference between the slopes of two timers, relative to the larger one, that is round-off.
const SAME_SLOPE: f64 = 1e-9;

impl Gradient<'_> {
    /// Slopes of the time of a step's end with respect to the parameters: zero for a given time, otherwise those of its timer.
    ///
    /// # Errors
    /// Timers and given times that coincide but do not move together.
    pub(super) fn end_slopes(&mut self, step: &Step) -> Result<Vec<f64>, GradientError> {
        let mut known = match step.ending {
            Ending::Given => Some((vec![0.0; self.entries.len()], "a given time".to_owned())),
            Ending::Timed | Ending::Chosen | Ending::Crossing(_) => None,
        };
        for timer in &step.timers {
            let own_s = timer.time_s(self.system);
            // relative to the own time, so that machines with this time have no round-off
            let by_neighbours: Vec<f64> =
                self.neighbours.iter_mut().map(|beside| beside.slope(|system| timer.time_s(system) - own_s)).collect();
            let slopes = self.by_parameters(step.end.time_s, &by_neighbours);
            let name = timer.name(self.system);
            let Some((others, other)) = &known else {
                known = Some((slopes, name));
                continue;
            };
            let apart = |(a, b): (&f64, &f64)| (a - b).abs() > SAME_SLOPE * a.abs().max(b.abs());
            if slopes.iter().zip(others).any(apart) {
                let (first, second, time_s) = (name, other.clone(), step.end.time_s);
                return Err(GradientError::Simultaneous { first, second, time_s });
            }
        }
        Ok(known.map_or_else(|| vec![0.0; self.entries.len()], |(slopes, _)| slopes))
    }
}
