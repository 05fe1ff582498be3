//! Variations of a run along its parameters, eqs. (X6)–(X9).

use crate::force::Moving;
use crate::force::set::Indicator;
use crate::gradient::step::Variation;
use crate::gradient::tape::{Ending, Step};
use crate::gradient::{Gradient, GradientError, RunResult, dot};

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
        let seeds = results.iter().map(|result| self.seed(*result)).collect::<Result<Vec<_>, _>>()?;
        let parameters = self.neighbours.len();
        let mut table = vec![vec![0.0; parameters]; results.len()];
        let mut variations: Vec<Variation> = self
            .neighbours
            .iter()
            .map(|beside| Variation { q: beside.start[0].clone(), v: beside.start[1].clone(), a: Vec::new() })
            .collect();
        variations.iter_mut().for_each(|variation| variation.a.resize(variation.q.len(), 0.0));
        let mut shifts_s = vec![0.0; parameters];
        let tape = self.tape;
        for (index, step) in tape.steps.iter().enumerate() {
            self.adopt(step);
            if step.renewed {
                // (X8)
                self.prepare(&step.start, Some(0.0))?;
                let forcings = self.forcings(&step.start);
                for (variation, forcing) in variations.iter_mut().zip(&forcings) {
                    self.solve(&step.start, 0.0, Some(forcing), variation)?;
                }
            }
            let mut ends = self.through(step, &variations, true)?;
            let column = match step.ending {
                Ending::Chosen => Variation::zeros(0),
                Ending::Given | Ending::Crossing(_) => ends.pop().unwrap_or_else(|| Variation::zeros(0)),
            };
            match step.ending {
                Ending::Chosen => {}
                Ending::Given => {
                    for (end, shift_s) in ends.iter_mut().zip(&mut shifts_s) {
                        end.add(-*shift_s, &column);
                        *shift_s = 0.0;
                    }
                }
                Ending::Crossing(indicator) => {
                    let z = self.crossing_slopes(step, indicator);
                    let c = z.coordinate;
                    let along = z.by_angle * column.q[c] + z.by_rate * column.v[c];
                    for ((end, shift_s), by_parameter) in ends.iter_mut().zip(&mut shifts_s).zip(&z.by_parameters) {
                        let change = -(z.by_angle * end.q[c] + z.by_rate * end.v[c] + by_parameter) / along;
                        end.add(change, &column);
                        *shift_s += change;
                    }
                }
            }
            variations = ends;
            for (row, seed) in table.iter_mut().zip(&seeds).filter(|(_, seed)| seed.step == index) {
                for ((entry, variation), (shift_s, own)) in
                    row.iter_mut().zip(&variations).zip(shifts_s.iter().zip(&seed.by_parameters))
                {
                    *entry = dot(&seed.state.q, &variation.q)
                        + dot(&seed.state.v, &variation.v)
                        + dot(&seed.state.a, &variation.a)
                        + seed.by_shift * shift_s
                        + own;
                }
            }
        }
        Ok(table)
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
        let by_parameters =
            self.neighbours.iter_mut().map(|beside| beside.slope(|system| distance(system, at(0.0, 0.0)))).collect();
        CrossingSlopes { coordinate, by_angle, by_rate, by_parameters }
    }
}
