//! Means of outputs over the run, eq. (X20): integrals by the stages of its steps, whose weights are those of the method.

use crate::gradient::adjoint::product;
use crate::gradient::air::Sums;
use crate::gradient::outputs::values;
use crate::gradient::step::Variation;
use crate::gradient::tape::Step;
use crate::gradient::{Gradient, GradientError, RunResult, Tape, add};
use crate::solve::point::Point;
use crate::solve::tableau::Tableau;
use crate::system::System;

/// A mean of an output, or of its square, from the start of the run to a requested time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mean {
    index: usize,
    square: bool,
    /// Index of the time among those requested, and the step in which it lies.
    pub time: usize,
    pub step: usize,
    /// Length of the run up to there in s.
    span_s: f64,
}

impl Mean {
    /// The mean that a result is; `None` for other results.
    pub fn of(result: RunResult, tape: &Tape) -> Option<Self> {
        let RunResult::Mean { index, time, square } = result else { return None };
        let mark = tape.marks.get(time)?;
        let span_s = tape.point(time).time_s - tape.steps.first()?.start.time_s;
        Some(Self { index, square, time, step: mark.step, span_s })
    }

    /// The quantity whose integral it is, and its slope by the output.
    fn integrand(&self, value: f64) -> [f64; 2] {
        if self.square { [value * value, 2.0 * value] } else { [value, 1.0] }
    }

    /// Weight of a stage per length of its step.
    fn share(&self, tableau: &Tableau, stage: usize) -> f64 {
        let last = tableau.rows[tableau.stages() - 2];
        last.get(stage).copied().unwrap_or(tableau.gamma) / self.span_s
    }
}

/// Slopes of a mean by the stages of a step.
#[derive(Debug, Default)]
pub(super) struct Seeds {
    /// By the state at each stage; empty without a mean.
    on: Vec<Variation>,
    /// By the time of each stage, with the share of the step at which it is.
    by_time: Vec<[f64; 2]>,
    /// By the length of the step through its weights alone.
    by_length: f64,
}

impl Seeds {
    /// Slope along the length of the step, whose stages vary with it by `columns`.
    pub fn along(&self, columns: &[Variation]) -> f64 {
        let of_states: f64 = self.on.iter().zip(columns).map(|(on, column)| product(on, column)).sum();
        of_states + self.by_time.iter().map(|[slope, share]| slope * share).sum::<f64>() + self.by_length
    }

    /// Slope by a shift of the step in time.
    pub fn by_shift(&self) -> f64 {
        self.by_time.iter().map(|[slope, _]| slope).sum()
    }

    /// Adds the multipliers of the stages.
    pub fn add_to(self, on: &mut [Variation]) {
        on.iter_mut().zip(&self.on).for_each(|(on, own)| on.add(1.0, own));
    }
}

/// The steps that a mean covers, the last one up to its time.
fn covered(tape: &Tape, mean: Mean) -> impl Iterator<Item = &Step> {
    tape.steps[..mean.step].iter().chain(&tape.marks[mean.time].branch)
}

/// The points of a step, from its start to its end, as outputs need them: stages have no auxiliary accelerations.
fn points(step: &Step) -> impl Iterator<Item = Point> {
    let whole = |point: &Point| Point { auxiliary: step.start.auxiliary.clone(), ..point.clone() };
    std::iter::once(step.start.clone()).chain(step.later().map(whole))
}

impl Gradient<'_> {
    /// A mean whose slope is defined; otherwise the reason why not.
    pub(super) fn check_mean(&self, index: usize, time: usize) -> Result<(), GradientError> {
        self.check_output(index, time)?;
        if self.sections.is_some() {
            let place = "ask for values at times".into();
            return Err(GradientError::NotCovered { part: "means over a run with aerodynamics", place });
        }
        if self.tape.marks[time].branch.is_none() {
            return Err(GradientError::Absent { what: "mean up to its start".to_owned() });
        }
        Ok(())
    }

    /// The means among results, with their rows.
    pub(super) fn means(&self, results: &[RunResult]) -> Vec<(usize, Mean)> {
        let of = |(row, result): (usize, &RunResult)| Some((row, Mean::of(*result, self.tape)?));
        results.iter().enumerate().filter_map(of).collect()
    }

    /// Value of a mean; NaN for other results.
    pub(super) fn mean_value(&mut self, result: RunResult) -> f64 {
        let Some(mean) = Mean::of(result, self.tape) else { return f64::NAN };
        let tape = self.tape;
        let mut sum = 0.0;
        for step in covered(tape, mean) {
            self.adopt(step);
            sum += mean_in(self.system, self.tableau, step, mean);
        }
        sum
    }

    /// Adds the variations of means over a step, whose stages vary by `stages`, its start's time by `shifts_s` and its length by `changes_s`, to
    /// their rows.
    pub(super) fn add_means(
        &mut self,
        step: &Step,
        (stages, shifts_s, changes_s): (&[Vec<Variation>], &[f64], &[f64]),
        means: &[(usize, Mean)],
        table: &mut [Vec<f64>],
    ) {
        if means.is_empty() {
            return;
        }
        let h = step.length_s();
        let indices: Vec<usize> = means.iter().map(|(_, mean)| mean.index).collect();
        for (stage, at) in points(step).enumerate() {
            let at = &at;
            self.place(at);
            let variations: Vec<Variation> = stages.iter().map(|stages| stages[stage].clone()).collect();
            let slopes = self.output_slopes_at(at, &indices, &variations, &[]);
            let part = (at.time_s - step.start.time_s) / h;
            for ((row, mean), slopes) in means.iter().zip(slopes) {
                let [value, slope] = mean.integrand(values(self.system, at)[mean.index]);
                let by_time = if self.inputs_move() { self.slope_by_time(mean.index, at, h) } else { 0.0 };
                let share = mean.share(self.tableau, stage);
                for (direction, sum) in table[*row].iter_mut().enumerate() {
                    let moved_s = shifts_s[direction] + part * changes_s[direction];
                    let along = slope * (slopes[direction] + by_time * moved_s);
                    *sum += share * (h * along + changes_s[direction] * value);
                }
            }
        }
    }

    /// Slopes of the mean that is the result by the stages of a step whose joints are adopted; those by the parameters are added to the sums.
    pub(super) fn mean_seeds(&mut self, step: &Step, sums: &mut Sums) -> Seeds {
        let mut seeds = Seeds::default();
        let Some(mean) = sums.mean else { return seeds };
        let h = step.length_s();
        for (stage, at) in points(step).enumerate() {
            let at = &at;
            self.place(at);
            let [value, slope] = mean.integrand(values(self.system, at)[mean.index]);
            let share = mean.share(self.tableau, stage);
            let mut on = Variation::zeros(self.system.coordinates());
            on.add(share * h * slope, &self.output_gradient(mean.index, at));
            seeds.on.push(on);
            seeds.by_length += share * value;
            if self.inputs_move() {
                let by_time = share * h * slope * self.slope_by_time(mean.index, at, h);
                seeds.by_time.push([by_time, (at.time_s - step.start.time_s) / h]);
            }
            if let Some(gradient) = &mut sums.gradient {
                let by_parameters = self.output_by_parameters(mean.index, at);
                add(gradient, share * h * slope, &by_parameters);
            }
        }
        seeds
    }
}

/// Value of the mean of a run on a tape, for comparisons.
#[cfg(test)]
pub(super) fn of_run(plant: &mut crate::run::Plant, tape: &Tape, result: RunResult) -> f64 {
    let Some((mean, tableau)) = Mean::of(result, tape).zip(plant.tableau()) else { return f64::NAN };
    let system = plant.system_mut();
    let mut sum = 0.0;
    for step in covered(tape, mean) {
        super::parameter::adopt(system, step, &tape.inputs, None);
        sum += mean_in(system, tableau, step, mean);
    }
    sum
}

/// Share of a step, whose joints are adopted, in a mean.
fn mean_in(system: &mut System, tableau: &Tableau, step: &Step, mean: Mean) -> f64 {
    let mut sum = 0.0;
    for (stage, at) in points(step).enumerate() {
        let [value, _] = mean.integrand(values(system, &at)[mean.index]);
        sum += mean.share(tableau, stage) * step.length_s() * value;
    }
    sum
}
