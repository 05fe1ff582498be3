//! Integrals over the run, with the stages and weights of the integration method: means of outputs, eq. (X20), and energy accounts,
//! eq. (X22).

use crate::gradient::account::Account;
use crate::gradient::integrand::{Integrand, Mean};
use crate::gradient::outputs::values;
use crate::gradient::sums::Sums;
use crate::gradient::tape::Step;
use crate::gradient::variation::{Causes, Variation, product};
use crate::gradient::{Gradient, GradientError, RunResult, Tape, add};
use crate::solve::point::Point;
use crate::solve::tableau::Tableau;
use crate::system::System;

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
pub(super) fn points(step: &Step) -> impl Iterator<Item = Point> {
    let whole = |point: &Point| Point { auxiliary: step.start.auxiliary.clone(), ..point.clone() };
    std::iter::once(step.start.clone()).chain(step.later().map(whole))
}

/// The points at which the equations of motion are satisfied, of which powers are taken.
fn solved(step: &Step) -> impl Iterator<Item = &Point> {
    std::iter::once(&step.start).chain(step.solved())
}

/// Means over the run with their places among the results, and the rows of their variations.
pub(super) type MeanRows<'a> = (&'a [(usize, Mean)], &'a mut [Vec<f64>]);

impl Gradient<'_> {
    /// A mean whose slope is defined; otherwise the reason why not.
    pub(super) fn check_mean(&self, index: usize, time: usize) -> Result<(), GradientError> {
        self.check_output(index, time)?;
        if Account::of(self.system, index).is_some() {
            let remedy = "choose their values at times, or use finite differences".into();
            return Err(GradientError::OtherChoice { part: "means of energy accounts", remedy });
        }
        if self.tape.marks[time].branch.is_none() {
            return Err(GradientError::Absent { what: "mean up to its start".to_owned() });
        }
        Ok(())
    }

    /// The means and energy accounts among results, with their rows.
    pub(super) fn means(&self, results: &[RunResult]) -> Vec<(usize, Mean)> {
        let of = |(row, result): (usize, &RunResult)| Some((row, Mean::of(*result, self.tape, self.system)?));
        results.iter().enumerate().filter_map(of).collect()
    }

    /// Value of a mean; NaN for other results.
    pub(super) fn mean_value(&mut self, result: RunResult) -> f64 {
        let Some(mean) = Mean::of(result, self.tape, self.system) else { return f64::NAN };
        let tape = self.tape;
        let mut sum = 0.0;
        for step in covered(tape, mean) {
            self.adopt(step);
            sum += mean_in(self.system, self.tableau, step, mean);
        }
        sum
    }

    /// Adds the variations of means over a step to their rows. The stages vary by `stages`, the loads of the air by `loads`, the time of
    /// the start by `shifts_s` and the length by `changes_s`.
    pub(super) fn add_means(
        &mut self,
        step: &Step,
        (stages, loads): (&[Vec<Variation>], &[Vec<f64>]),
        [shifts_s, changes_s]: [&[f64]; 2],
        (means, table): MeanRows<'_>,
    ) {
        if means.is_empty() {
            return;
        }
        let h = step.length_s();
        let indices: Vec<usize> = means.iter().filter_map(|(_, mean)| mean.output()).collect();
        let accounts = means.iter().any(|(_, mean)| mean.account().is_some());
        for (stage, (at, power_at)) in points(step).zip(solved(step)).enumerate() {
            let at = &at;
            self.place(at);
            let mut variations: Vec<Variation> = stages.iter().map(|stages| stages[stage].clone()).collect();
            let of_powers = if accounts { self.power_slopes(step, power_at, &variations, loads) } else { Vec::new() };
            if stage + 1 == self.tableau.stages() {
                let projection = self.projection(step);
                for (direction, variation) in variations.iter_mut().enumerate() {
                    projection.apply(variation, Some(direction));
                }
            }
            self.place(at);
            let mut of_outputs = match indices.is_empty() {
                true => Vec::new(),
                false => self.output_slopes_at(at, &indices, &variations, loads),
            }
            .into_iter();
            let part = (at.time_s - step.start.time_s) / h;
            for (row, mean) in means {
                let slopes: Vec<f64> = match mean.account() {
                    Some(account) => of_powers.iter().map(|slopes| account.of_powers(*slopes)).collect(),
                    None => of_outputs.next().unwrap_or_default(),
                };
                let at = if mean.account().is_some() { power_at } else { at };
                let [value, slope] = mean.integrand(self.integrand_at(step, at, mean));
                let by_time = if self.varies(mean) { self.integrand_by_time(step, at, mean) } else { 0.0 };
                let share = mean.share(self.tableau, stage);
                for ((sum, slopes), (shift_s, change_s)) in
                    table[*row].iter_mut().zip(slopes).zip(shifts_s.iter().zip(changes_s))
                {
                    let along = slope * (slopes + by_time * (shift_s + part * change_s));
                    *sum += share * (h * along + change_s * value);
                }
            }
        }
    }

    /// Rate of an account along the length of a step, (X7).
    pub(super) fn account_rate(&mut self, step: &Step, mean: &Mean) -> Result<f64, GradientError> {
        self.adopt(step);
        let columns = self.stages_through(step, &[], &[], Causes::NONE)?.pop().unwrap_or_default();
        let h = step.length_s();
        let mut rate = 0.0;
        for ((stage, at), column) in solved(step).enumerate().zip(&columns) {
            let part = (at.time_s - step.start.time_s) / h;
            let by_time = if self.varies(mean) { self.integrand_by_time(step, at, mean) } else { 0.0 };
            let along = self.integrand_along(step, at, mean, column) + by_time * part;
            rate += mean.share(self.tableau, stage) * (h * along + self.integrand_at(step, at, mean));
        }
        Ok(rate)
    }

    /// Slope of the power that is integrated, along a variation of a point of a step.
    fn integrand_along(&mut self, step: &Step, at: &Point, mean: &Mean, along: &Variation) -> f64 {
        let Some(account) = mean.account() else { return f64::NAN };
        let mut slopes = [0.0; 2];
        super::account::add_slopes_along(self.system, (at, step.middle_s()), along, &mut slopes);
        account.of_powers(slopes)
    }

    /// The output or power that is integrated, at a point of a step.
    fn integrand_at(&mut self, step: &Step, at: &Point, mean: &Mean) -> f64 {
        match mean.integrand {
            Integrand::Output(index) | Integrand::Square(index) => values(self.system, at)[index],
            Integrand::Power(account) => account.of_powers(super::account::powers(self.system, at, step.middle_s())),
        }
    }

    /// Whether the integrated quantity depends on time itself: by inputs that vary, or as a load of a rotor.
    fn varies(&self, mean: &Mean) -> bool {
        self.inputs_move() || mean.output().is_some_and(|index| self.rotor_of(index).is_some())
    }

    /// Its slope with respect to time, where it depends on it.
    fn integrand_by_time(&mut self, step: &Step, at: &Point, mean: &Mean) -> f64 {
        match mean.integrand {
            Integrand::Output(index) | Integrand::Square(index) => self.slope_by_time(index, at, step.length_s()),
            Integrand::Power(account) => account.of_powers(self.powers_by_time(step, at)),
        }
    }

    /// Slopes of the mean that is the result by the stages of a step whose joints are adopted; those by the parameters and by the loads of the
    /// air are added to the sums.
    pub(super) fn mean_seeds(&mut self, step: &Step, sums: &mut Sums) -> Seeds {
        let mut seeds = Seeds::default();
        let Some(mean) = sums.mean else { return seeds };
        let h = step.length_s();
        for (stage, (at, power_at)) in points(step).zip(solved(step)).enumerate() {
            let at = if mean.account().is_some() { power_at } else { &at };
            self.place(at);
            let [value, slope] = mean.integrand(self.integrand_at(step, at, &mean));
            let share = mean.share(self.tableau, stage);
            let mut on = Variation::zeros(self.system.coordinates());
            let by_state = match mean.integrand {
                Integrand::Output(index) | Integrand::Square(index) => {
                    let mut by_state = self.output_gradient(index, at);
                    if stage + 1 == self.tableau.stages() {
                        let mut through_gaps = vec![0.0; self.entries.len()];
                        self.projection(step).pull(&mut by_state, Some(&mut through_gaps));
                        if let Some(gradient) = &mut sums.gradient {
                            add(gradient, share * h * slope, &through_gaps);
                        }
                    }
                    by_state
                }
                Integrand::Power(account) => self.power_gradient(account, step, at),
            };
            on.add(share * h * slope, &by_state);
            seeds.on.push(on);
            seeds.by_length += share * value;
            if self.varies(&mean) {
                let by_time = share * h * slope * self.integrand_by_time(step, at, &mean);
                seeds.by_time.push([by_time, (at.time_s - step.start.time_s) / h]);
            }
            let by_loads = match mean.integrand {
                Integrand::Output(index) | Integrand::Square(index) => self.output_by_loads(index, at),
                Integrand::Power(account) => self.power_by_loads(account, step, at),
            };
            add(&mut sums.loads, share * h * slope, &by_loads);
            if let Some(gradient) = &mut sums.gradient {
                let by_parameters = match mean.integrand {
                    Integrand::Output(index) | Integrand::Square(index) => self.output_by_parameters(index, at),
                    Integrand::Power(account) => self.power_by_parameters(account, step, at),
                };
                add(gradient, share * h * slope, &by_parameters);
            }
        }
        seeds
    }
}

/// Share of a step, whose joints are adopted, in a mean.
fn mean_in(system: &mut System, tableau: &Tableau, step: &Step, mean: Mean) -> f64 {
    let Some(index) = mean.output() else { return f64::NAN };
    let mut sum = 0.0;
    for (stage, at) in points(step).enumerate() {
        let [value, _] = mean.integrand(values(system, &at)[index]);
        sum += mean.share(tableau, stage) * step.length_s() * value;
    }
    sum
}
