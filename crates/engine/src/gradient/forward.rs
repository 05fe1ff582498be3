//! Variations of a run along its parameters, eqs. (X6)–(X9) and (X11).

use crate::force::Moving;
use crate::force::set::Indicator;
use crate::gradient::step::Variation;
use crate::gradient::tape::{Ending, Step};
use crate::gradient::{Entry, Gradient, GradientError, RunResult, add};

/// Slopes of an indicator at its crossing.
pub(super) struct CrossingSlopes {
    /// Coordinate of the joint.
    pub coordinate: usize,
    pub by_angle: f64,
    pub by_rate: f64,
    pub by_parameters: Vec<f64>,
}

impl Gradient<'_> {
    /// Derivatives of results (rows) by the parameters (columns), all parameters at once through the run.
    pub fn forward(&mut self, results: &[RunResult]) -> Result<Vec<Vec<f64>>, GradientError> {
        let steps = results.iter().map(|result| self.step_of(*result)).collect::<Result<Vec<_>, _>>()?;
        let last = steps.iter().copied().max().unwrap_or(0);
        let parameters = self.entries.len();
        let mut table = vec![vec![0.0; parameters]; results.len()];
        let mut variations = self.start_variations();
        let mut shifts_s = vec![0.0; parameters];
        let tape = self.tape;
        for (index, step) in tape.steps.iter().enumerate().take(last + 1) {
            self.adopt(step);
            if step.renewed {
                // (X8)
                let by_time = self.time_slope(&step.start, step.length_s());
                self.linearize(&step.start);
                self.factorize(&step.start, 0.0)?;
                let forcings = self.forcings(&step.start, &shifts_s, by_time.as_deref());
                for (variation, forcing) in variations.iter_mut().zip(&forcings) {
                    self.solve(&step.start, 0.0, Some(forcing), variation)?;
                }
            }
            self.write_outputs(results, (index, &variations, &shifts_s), &mut table)?;
            if index == last && steps.iter().zip(results).all(|(at, result)| *at < last || !result.is_latch_time()) {
                break;
            }
            self.adopt(step);
            let mut ends = self.through(step, &variations, &shifts_s)?;
            let column = match step.ending {
                Ending::Chosen => Variation::zeros(0),
                Ending::Given | Ending::Crossing(_) => ends.pop().unwrap_or_else(|| Variation::zeros(0)),
            };
            if step.ending == Ending::Given {
                ends.iter_mut().zip(&shifts_s).for_each(|(end, shift_s)| end.add(-*shift_s, &column));
                shifts_s.fill(0.0);
            }
            if let Ending::Crossing(indicator) = step.ending {
                let z = self.crossing_slopes(step, indicator);
                let c = z.coordinate;
                let along = z.by_angle * column.q[c] + z.by_rate * column.v[c];
                for ((end, shift_s), by_parameter) in ends.iter_mut().zip(&mut shifts_s).zip(&z.by_parameters) {
                    let change = -(z.by_angle * end.q[c] + z.by_rate * end.v[c] + by_parameter) / along;
                    end.add(change, &column);
                    *shift_s += change;
                }
            }
            variations = ends;
            for ((row, result), at) in table.iter_mut().zip(results).zip(&steps) {
                if *at == index && result.is_latch_time() {
                    row.clone_from(&shifts_s);
                }
            }
        }
        Ok(table)
    }

    /// Variations of the start.
    fn start_variations(&self) -> Vec<Variation> {
        let time_s = self.tape.steps.first().map_or(0.0, |step| step.start.time_s);
        let of = |(entry, share): (&Entry, f64)| {
            let [q, v] = &self.neighbours[entry.beside].start;
            let mut start = Variation::zeros(q.len());
            add(&mut start.q, share, q);
            add(&mut start.v, share, v);
            start
        };
        self.entries.iter().zip(self.shares(time_s)).map(of).collect()
    }

    /// Writes the rows of the outputs at the requested times within a step, whose start varies by `variations` and moves by `shifts_s`.
    fn write_outputs(
        &mut self,
        results: &[RunResult],
        (index, variations, shifts_s): (usize, &[Variation], &[f64]),
        table: &mut [Vec<f64>],
    ) -> Result<(), GradientError> {
        let tape = self.tape;
        for (time, mark) in tape.marks.iter().enumerate().filter(|(_, mark)| mark.step == index) {
            let of_time = |(row, result): (usize, &RunResult)| match *result {
                RunResult::Output { index, time: other } if other == time => Some((row, index)),
                RunResult::Output { .. } | RunResult::LatchTime { .. } => None,
            };
            let (rows, indices): (Vec<usize>, Vec<usize>) = results.iter().enumerate().filter_map(of_time).unzip();
            if indices.is_empty() {
                continue;
            }
            let slopes = match &mark.branch {
                None => self.output_slopes(&indices, time, variations)?,
                Some(branch) => {
                    self.adopt(branch);
                    let mut ends = self.through(branch, variations, shifts_s)?;
                    let column = ends.pop().unwrap_or_else(|| Variation::zeros(0));
                    ends.iter_mut().zip(shifts_s).for_each(|(end, shift_s)| end.add(-*shift_s, &column));
                    self.output_slopes(&indices, time, &ends)?
                }
            };
            rows.into_iter().zip(slopes).for_each(|(row, slopes)| table[row] = slopes);
        }
        Ok(())
    }

    /// Slopes of an indicator at the end of a step. Indicators are linear in angle and rate, so that central differences are exact.
    pub(super) fn crossing_slopes(&mut self, step: &Step, indicator: Indicator) -> CrossingSlopes {
        let coordinate = self.system.equations.forces.joints()[indicator.joint].coordinate;
        let (end, start_rad) = (&step.end, step.start.q[coordinate]);
        let memory = step.joints[indicator.joint];
        let at = |angle: f64, rate: f64| Moving {
            angle_rad: end.q[coordinate] + angle,
            rate_rad_s: end.v[coordinate] + rate,
            acceleration_rad_s2: end.a[coordinate],
        };
        let distance = |system: &crate::system::System, at: Moving| {
            system.equations.forces.joints()[indicator.joint].distance_rad(indicator.number, start_rad, &at, &memory)
        };
        // steps far above round-off, and within the piece of a stop's indicator
        let (turn, speed) = (1e-4, 1e-4 * end.v[coordinate].abs());
        let own = &*self.system;
        let by_angle = (distance(own, at(turn, 0.0)) - distance(own, at(-turn, 0.0))) / (2.0 * turn);
        let by_rate = match speed > 0.0 {
            true => (distance(own, at(0.0, speed)) - distance(own, at(0.0, -speed))) / (2.0 * speed),
            false => 0.0,
        };
        let by_neighbours: Vec<f64> =
            self.neighbours.iter_mut().map(|beside| beside.slope(|system| distance(system, at(0.0, 0.0)))).collect();
        let by_parameters = self.by_parameters(end.time_s, &by_neighbours);
        CrossingSlopes { coordinate, by_angle, by_rate, by_parameters }
    }
}
