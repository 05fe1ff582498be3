//! Variations of a run along its parameters, eqs. (X6)–(X9) and (X11).

use crate::force::Moving;
use crate::force::set::Indicator;
use crate::gradient::account::Account;
use crate::gradient::air::LoadVariations;
use crate::gradient::impulse::Impulses;
use crate::gradient::integrand::Mean;
use crate::gradient::mean::MeanRows;
use crate::gradient::tape::{Ending, Step};
use crate::gradient::variation::{Causes, Front, Variation};
use crate::gradient::{Entry, Gradient, GradientError, RunResult, add};
use std::ops::Range;

/// Slopes of an indicator at its crossing.
pub(super) struct CrossingSlopes {
    /// Coordinate of the joint.
    pub coordinate: usize,
    pub by_angle: f64,
    pub by_rate: f64,
    pub by_parameters: Vec<f64>,
}

/// The energy accounts among integrals that end in a step or after it.
fn accounts_from(means: &[(usize, Mean)], step: usize) -> Vec<(usize, Account)> {
    let on = means.iter().filter(|(_, mean)| mean.step >= step);
    on.filter_map(|(row, mean)| Some((*row, mean.account()?))).collect()
}

impl Gradient<'_> {
    /// Derivatives of results (rows) by the parameters (columns), all parameters at once through the run.
    pub fn forward(&mut self, results: &[RunResult]) -> Result<Vec<Vec<f64>>, GradientError> {
        let steps = results.iter().map(|result| self.step_of(*result)).collect::<Result<Vec<_>, _>>()?;
        let last = steps.iter().copied().max().unwrap_or(0);
        // the start has the inputs of the first step
        if let Some(first) = self.tape.steps.first() {
            self.adopt(first);
        }
        let parameters = self.entries.len();
        let mut table = vec![vec![0.0; parameters]; results.len()];
        let mut front = Front { variations: self.start_variations(), shifts_s: vec![0.0; parameters] };
        let mut memories = self.start_memories();
        let tape = self.tape;
        let means = self.means(results);
        // loads of rotors follow from both ends of their aerodynamic step
        let to_end = results.iter().any(|result| self.is_of_rotor(result));
        let ends_at = |index: usize| {
            let known = |(at, result): (&usize, &RunResult)| *at < last || !result.is_latch_time();
            !to_end && index == last && steps.iter().zip(results).all(known)
        };
        for (place, span) in tape.spans().into_iter().enumerate() {
            let air = self.air_step(place, &span)?;
            let LoadVariations { loads, memories: behind } = match &air {
                Some(air) => self.loads_forward((&span, air), &front, &memories)?,
                None => LoadVariations::default(),
            };
            for index in span.clone() {
                let step = &tape.steps[index];
                let causes = Causes { parameters: true, loads: &loads };
                let accounts = accounts_from(&means, index);
                self.account_before(index, (&front.variations, &front.shifts_s), &accounts, &mut table)?;
                let impulses = self.renew(index, &mut front, causes)?;
                self.account_behind(index, (&front.variations, &front.shifts_s), &accounts, &mut table);
                self.write_impulses(results, (index, impulses), &mut table);
                self.write_outputs(results, (index, &front, &loads), &mut table)?;
                if ends_at(index) {
                    return Ok(table);
                }
                let before: Vec<(usize, Mean)> = means.iter().copied().filter(|(_, mean)| mean.step > index).collect();
                self.pass(step, &mut front, causes, Some((&before[..], &mut table[..])))?;
                for ((row, result), at) in table.iter_mut().zip(results).zip(&steps) {
                    if *at == index && result.is_latch_time() {
                        row.clone_from(&front.shifts_s);
                    }
                }
                if !to_end && index == last {
                    return Ok(table);
                }
            }
            let Some(air) = air else { continue };
            let behind = behind.unwrap_or_else(|| self.air_forward(&air, &front.variations, Some(&memories)));
            let before = std::mem::replace(&mut memories, behind);
            memories.iter_mut().for_each(|memory| memory.truncate(air.memory_entries()));
            for (row, result) in table.iter_mut().zip(results) {
                if let Some(shares) = self.memory_shares(result, (&span, &air)) {
                    shares.add_to(row, [&before, &memories]);
                }
            }
            if span.contains(&last) {
                return Ok(table);
            }
        }
        Ok(table)
    }

    /// Carries variations over some steps.
    pub(super) fn march(
        &mut self,
        span: &Range<usize>,
        front: &mut Front,
        causes: Causes,
    ) -> Result<(), GradientError> {
        let steps = self.steps;
        for index in span.clone() {
            self.renew(index, front, causes)?;
            self.pass(&steps[index], front, causes, None)?;
        }
        Ok(())
    }

    /// Variations behind an event at the start of a step: of the rates, if they jump, eq. (X17), and of the accelerations, which follow from
    /// the equations there, eq. (X8). Returns the variations of the impulses of a jump.
    fn renew(&mut self, index: usize, front: &mut Front, causes: Causes) -> Result<Option<Impulses>, GradientError> {
        let step = &self.steps[index];
        self.adopt(step);
        if !step.renewed {
            return Ok(None);
        }
        let impulses = match self.jump(index)? {
            Some(jump) => Some(self.jump_forward(&jump, front, causes)?),
            None => None,
        };
        let time_s = step.start.time_s;
        let laws = self.laws(time_s, time_s);
        let shares = self.shares(time_s);
        for (direction, variation) in front.variations.iter_mut().enumerate() {
            let number = self.number_of(direction, &shares, causes);
            laws.iter().for_each(|law| law.set(number, front.shifts_s[direction], 0.0, variation));
        }
        let by_time = self.time_slope(&step.start, step.length_s());
        self.linearize(&step.start);
        self.factorize(&step.start, 0.0)?;
        let forcings = self.forcings(&step.start, &front.shifts_s, by_time.as_deref(), causes);
        for (variation, forcing) in front.variations.iter_mut().zip(&forcings) {
            self.solve(&step.start, 0.0, Some(forcing), variation)?;
        }
        Ok(impulses)
    }

    /// Writes the rows of the impulses at the start of a step.
    fn write_impulses(
        &self,
        results: &[RunResult],
        (index, impulses): (usize, Option<Impulses>),
        table: &mut [Vec<f64>],
    ) {
        let Some(Impulses { stopped, variations }) = impulses else { return };
        for (row, result) in table.iter_mut().zip(results) {
            let RunResult::Impulse { joint } = *result else { continue };
            let coordinate = self.system.equations.forces.joints()[joint].coordinate;
            let place = stopped.iter().position(|stopped| *stopped == coordinate);
            if let Some(place) = place.filter(|_| self.impulse_step(joint).is_ok_and(|step| step == index)) {
                *row = variations.iter().map(|variation| variation[place]).collect();
            }
        }
    }

    /// Variations of the end of a step and of its time, and those of means over the run.
    fn pass(
        &mut self,
        step: &Step,
        front: &mut Front,
        causes: Causes,
        means: Option<MeanRows<'_>>,
    ) -> Result<(), GradientError> {
        self.adopt(step);
        let mut stages = self.stages_through(step, &front.variations, &front.shifts_s, causes)?;
        let columns = match step.ending {
            Ending::Chosen => Vec::new(),
            Ending::Given | Ending::Timed | Ending::Crossing(_) => stages.pop().unwrap_or_default(),
        };
        let changes_s: Vec<f64> = match step.ending {
            Ending::Chosen => vec![0.0; stages.len()],
            Ending::Given | Ending::Timed => {
                let times = self.end_slopes(step)?;
                let time = |direction: usize| if causes.parameters { times[direction] } else { 0.0 };
                front.shifts_s.iter().enumerate().map(|(direction, shift_s)| time(direction) - shift_s).collect()
            }
            Ending::Crossing(indicator) => {
                let z = self.crossing_slopes(step, indicator);
                let c = z.coordinate;
                let slope = |end: &Variation| z.by_angle * end.q[c] + z.by_rate * end.v[c];
                let along = columns.last().map_or(f64::NAN, slope);
                let change = |(direction, stages): (usize, &Vec<Variation>)| {
                    let by_parameter = if causes.parameters { z.by_parameters[direction] } else { 0.0 };
                    -(stages.last().map_or(f64::NAN, slope) + by_parameter) / along
                };
                stages.iter().enumerate().map(change).collect()
            }
        };
        for (stages, change_s) in stages.iter_mut().zip(&changes_s) {
            stages.iter_mut().zip(&columns).for_each(|(stage, column)| stage.add(*change_s, column));
        }
        if let Some((means, table)) = means {
            self.add_means(step, (&stages, causes.loads), [&front.shifts_s, &changes_s], (means, table));
        }
        front.shifts_s.iter_mut().zip(&changes_s).for_each(|(shift_s, change_s)| *shift_s += change_s);
        front.variations = stages.into_iter().filter_map(|mut stages| stages.pop()).collect();
        let projection = self.projection(step);
        for (direction, end) in front.variations.iter_mut().enumerate() {
            projection.apply(end, causes.parameters.then_some(direction));
        }
        Ok(())
    }

    /// Derivatives of the initial state with respect to each parameter.
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

    /// Writes the rows of the outputs at the requested times within a step, whose start varies by a front and whose loads of the air by
    /// `loads`.
    fn write_outputs(
        &mut self,
        results: &[RunResult],
        (index, Front { variations, shifts_s }, loads): (usize, &Front, &[Vec<f64>]),
        table: &mut [Vec<f64>],
    ) -> Result<(), GradientError> {
        let tape = self.tape;
        let accounts = self.system.outputs.layout().accounts();
        let is_account = |index: usize| accounts.contains(&index);
        for (time, mark) in tape.marks.iter().enumerate().filter(|(_, mark)| mark.step == index) {
            let of_time = |(row, result): (usize, &RunResult)| match *result {
                RunResult::Output { index, time: other } if other == time && !is_account(index) => Some((row, index)),
                RunResult::Output { .. }
                | RunResult::Mean { .. }
                | RunResult::Impulse { .. }
                | RunResult::LatchTime { .. } => None,
            };
            let (rows, indices): (Vec<usize>, Vec<usize>) = results.iter().enumerate().filter_map(of_time).unzip();
            let means: Vec<(usize, Mean)> =
                self.means(results).into_iter().filter(|(_, mean)| mean.time == time).collect();
            if let (Some(branch), false) = (&mark.branch, means.is_empty()) {
                let mut front = Front { variations: variations.clone(), shifts_s: shifts_s.clone() };
                self.pass(branch, &mut front, Causes { parameters: true, loads }, Some((&means[..], &mut *table)))?;
            }
            if indices.is_empty() {
                continue;
            }
            let slopes = match &mark.branch {
                None => self.output_slopes(&indices, time, variations, loads)?,
                Some(branch) => {
                    self.adopt(branch);
                    let causes = Causes { parameters: true, loads };
                    let mut ends = self.through(branch, variations, shifts_s, causes)?;
                    let column = ends.pop().unwrap_or_else(|| Variation::zeros(0));
                    ends.iter_mut().zip(shifts_s).for_each(|(end, shift_s)| end.add(-*shift_s, &column));
                    self.output_slopes(&indices, time, &ends, loads)?
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
            // a bound of the rate at rest
            false => (distance(own, at(0.0, turn)) - distance(own, at(0.0, -turn))) / (2.0 * turn),
        };
        let by_neighbours: Vec<f64> =
            self.neighbours.iter_mut().map(|beside| beside.slope(|system| distance(system, at(0.0, 0.0)))).collect();
        let by_parameters = self.by_parameters(end.time_s, &by_neighbours);
        CrossingSlopes { coordinate, by_angle, by_rate, by_parameters }
    }
}
