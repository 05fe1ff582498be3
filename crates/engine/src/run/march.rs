//! Time integration: variable steps that run ahead of the caller, with crossings of force indicators located within them.

use crate::force::joint::JointForces;
use crate::force::latch::CROSSING_S;
use crate::force::set::Indicator;
use crate::run::{Pauses, Plant, Reached};
use crate::solve::continuation::Taken;
use crate::solve::control;
use crate::solve::newton::{Accuracy, Effort, NewtonError};
use crate::system::PlantError;
use crate::system::place::Failure;
use crate::system::state::State;

/// Displacement error allowed after Newton's iteration, as a fraction of the step's tolerance.
const NEWTON_SHARE: f64 = 1e-2;
/// Largest displacement error allowed after Newton's iteration at any tolerance.
const NEWTON_CEILING: f64 = 1e-6;
/// Largest displacement error allowed after Newton's iteration in steps of given length, without an error estimate: those that end at a
/// crossing (located to 1e-9 s, at about 10 rad/s) and fixed ones.
const NEWTON_CEILING_EXACT: f64 = 1e-8;
/// Factor by which the step is cut after Newton's iteration has failed.
const FAILURE_CUT: f64 = 0.25;
/// Maximum number of internal steps in a communication step if each has the maximum length.
const MAXIMUM_STEPS: u32 = 1_000_000;
/// Newton iterations allowed in a communication step of any length: five times the number in the trial marches of one aerodynamic step of
/// the supplied tunnel model at a tolerance of 1e-8, and some seconds of processor time.
const MAXIMUM_ITERATIONS: u64 = 200_000;
/// Additional Newton iterations allowed per second of the communication step.
const MAXIMUM_ITERATIONS_1_S: f64 = 5e7;
/// Maximum number of aerodynamic steps in one communication step: each contains many internal ones.
const MAXIMUM_AIR_STEPS: u32 = 100_000;
/// Maximum number of steps for locating one crossing.
const MAX_LOCATING_STEPS: usize = 40;
/// Maximum number of steps for locating one crossing in real time: after the tangent at the end of the first trial, the distance of the
/// latch from the crossing, as a fraction of the step, decreases with the square of the step.
const MAX_LOCATING_STEPS_REAL_TIME: usize = 2;
/// Repetitions of a step that ends at a crossing in comparisons of runs, and the end of the last one after the crossing, as a share of
/// [`CROSSING_S`], within the range in which a latch must capture.
const SHARPENINGS: usize = 2;
const SHARPENED: f64 = 0.25;
/// Last correction, as a rotation in rad or a displacement divided by the model's length, above which a stage in real-time mode counts as
/// unsolved: the next correction could move any part arbitrarily far.
const LOST_REST: f64 = 1.0;
/// Largest rotation of a joint in a step of real-time mode, in rad: beyond half a revolution the direction is ambiguous.
const LOST_TURN_RAD: f64 = std::f64::consts::PI;

/// Choice of the step size.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Length {
    /// Chosen by the error estimate, which also bounds the remaining error of Newton's iteration.
    Chosen,
    /// Given by the position of a crossing or by the caller.
    Given,
}

/// A step of given length that failed. `ahead` is undefined, `start` is unchanged.
pub(super) struct Untaken {
    step_s: f64,
    failure: Failure,
}

impl Plant {
    /// Advances to `end_s` with the current inputs and their rates; the outputs are then those at `end_s`.
    ///
    /// After an error the plant is at the last valid time, [`crate::system::System::time_s`], with its outputs; if no internal step has
    /// succeeded, they are bit-identical to those before the call. Allocates nothing.
    pub fn step(&mut self, end_s: f64) -> Result<(), PlantError> {
        self.step_with_pauses(end_s, Pauses::default()).map(|_| ())
    }

    /// Like [`Self::step`], but ends earlier as specified by `pauses`: the current time and the outputs are then those of the pause.
    pub fn step_with_pauses(&mut self, end_s: f64, pauses: Pauses) -> Result<Reached, PlantError> {
        let changed = self.system.inputs_changed();
        self.system.inputs_may_differ = false;
        let marches = changed || self.system.state.ahead.time_s <= end_s;
        // values reached by running ahead were checked when the step was taken, unless they were too large
        let guarded = marches || !self.system.stays_moderate() || self.system.is_constrained();
        if guarded {
            self.system.begin.copy_from(&self.system.state);
        }
        self.allow_work((end_s - self.system.state.now.time_s).max(0.0));
        let applied = if changed { self.system.apply_inputs().and_then(|()| self.renew_air()) } else { Ok(()) };
        let outcome = applied.and_then(|()| self.march(end_s, changed, pauses)).and_then(|reached| {
            if reached == Reached::End {
                self.arrive_at(end_s)?;
            }
            Ok(reached)
        });
        let State { before, start, ahead, now, .. } = &mut self.system.state;
        match &outcome {
            Ok(Reached::End) => {}
            Ok(Reached::Event | Reached::Step) => now.copy_from(ahead),
            Err(_) if start.time_s <= now.time_s => self.system.go_back_to_begin(),
            Err(_) => {
                // the attempt has overwritten the stages of the step that ends here
                [before, ahead, now].into_iter().for_each(|point| point.copy_from(start));
            }
        }
        self.system.state.arrive();
        self.system.remember_far_turns();
        self.system.forget_outputs();
        if guarded && outcome.is_ok() {
            self.refuse_infinite(end_s)?;
        }
        self.system.provide(self.system.watched);
        outcome
    }

    /// Rolls back the current step if an output is not finite.
    pub(crate) fn refuse_infinite(&mut self, time_s: f64) -> Result<(), PlantError> {
        if self.system.is_moderate() {
            return Ok(());
        }
        self.system.evaluate();
        if self.system.outputs.are_finite() {
            return Ok(());
        }
        let cause = self.system.largest_input();
        self.system.go_back_to_begin();
        self.system.state.arrive();
        self.system.evaluate();
        Err(PlantError::NotFinite { time_s, cause })
    }

    /// Resets the iteration budget for a communication step of length `span_s`.
    pub(crate) fn allow_work(&mut self, span_s: f64) {
        self.most_work = MAXIMUM_ITERATIONS.saturating_add((MAXIMUM_ITERATIONS_1_S * span_s).round() as u64);
        self.work_left = self.most_work;
    }

    /// Longest communication step in s within the limits on the numbers of internal and aerodynamic steps.
    pub fn longest_step_s(&self) -> f64 {
        let structure_s =
            self.system.machine.solver.fixed_step_s.unwrap_or(self.system.state.parameters.solver().max_step_s)
                * f64::from(MAXIMUM_STEPS);
        self.system
            .machine
            .air
            .as_ref()
            .map_or(structure_s, |air| structure_s.min(air.step_s * f64::from(MAXIMUM_AIR_STEPS)))
    }

    /// Takes steps until one reaches `end_s`. Runs ahead of `end_s` only while the inputs are unchanged. Fixed steps divide the caller's
    /// step and never run ahead; with aerodynamics they divide the aerodynamic step, for any step of the caller: the loads are iterated for
    /// these steps.
    fn march(&mut self, end_s: f64, changed: bool, pauses: Pauses) -> Result<Reached, PlantError> {
        let fixed = self
            .system
            .machine
            .solver
            .fixed_step_s
            .map(|step_s| even_step(end_s - self.system.state.now.time_s, step_s));
        let runs_ahead = !changed && (fixed.is_none() || self.system.state.air.is_some());
        let limit_s = if runs_ahead { f64::INFINITY } else { end_s };
        while self.system.state.ahead.time_s <= end_s {
            if let Some(reached) = self.pause(pauses, end_s) {
                return Ok(reached);
            }
            let State { before, start, ahead, .. } = &mut self.system.state;
            if ahead.time_s > start.time_s {
                before.copy_from(start);
            }
            start.copy_from(ahead);
            self.system.apply_events()?;
            if self.system.state.start.time_s >= end_s || self.adopt_end_of_air_step(end_s) {
                break;
            }
            self.begin_air_step()?;
            match self.structure_step_s().or(fixed) {
                Some(step_s) => self.advance_fixed(step_s, limit_s)?,
                None => self.advance(limit_s)?,
            }
            self.loosen_bound_after_jump();
            self.system.remember_attitudes();
        }
        Ok(Reached::End)
    }

    /// Takes one accepted step of variable length from `start` to `ahead`, at most to `limit_s`.
    pub(crate) fn advance(&mut self, limit_s: f64) -> Result<(), PlantError> {
        let tolerance = self.system.state.applied_parameters.solver().tolerance;
        let (min_step_s, max_step_s) = (
            self.system.state.applied_parameters.solver().min_step_s,
            self.system.state.applied_parameters.solver().max_step_s,
        );
        let time_s = self.system.state.start.time_s;
        let stop_s = limit_s.min(self.system.equations.next_kink_s(time_s));
        let order = self.stepper.error_order();
        loop {
            let wanted_s = self.system.state.step_s.min(max_step_s);
            let (step_s, end_s) = fit_step(time_s, wanted_s, stop_s);
            self.count_step(step_s, end_s)?;
            match self.attempt(step_s, Length::Chosen) {
                Ok(error) if error <= tolerance => {
                    self.system.state.ahead.time_s = end_s;
                    if let Err(Untaken { step_s, failure }) = self.locate_crossing() {
                        // first a normal step over part of the distance to the crossing, then the remainder
                        self.give_up(step_s * FAILURE_CUT, failure)?;
                        continue;
                    }
                    let factor = control::factor(error / tolerance, order);
                    let grown_s = step_s * factor;
                    // a step limited by the largest growth was shorter than the error requires; steps bounded after a jump are short in all
                    // marches
                    let is_asked_for = factor < control::MAX_GROWTH || grown_s >= max_step_s;
                    if is_asked_for && self.after_jump_s().is_none_or(|bound_s| wanted_s < bound_s) {
                        self.smallest_step_s = self.smallest_step_s.min(wanted_s);
                    }
                    // a step cut short by `stop_s` does not reduce the next step size
                    self.system.state.step_s =
                        if step_s < wanted_s { grown_s.max(wanted_s) } else { grown_s }.min(max_step_s);
                    break;
                }
                Ok(error) => {
                    self.system.state.statistics.rejections += 1;
                    self.system.state.step_s = step_s * control::factor(error / tolerance, order).min(0.9);
                    self.refuse_small_step(min_step_s, Failure::Estimate { error, tolerance })?;
                }
                Err(error) => self.give_up(step_s * FAILURE_CUT, Failure::Newton(error))?,
            }
        }
        self.system.state.statistics.steps += 1;
        Ok(())
    }

    /// Continues with a shorter step after a failure of Newton's iteration; returns an error if that is below the shortest allowed step.
    fn give_up(&mut self, shorter_s: f64, failure: Failure) -> Result<(), PlantError> {
        self.system.state.statistics.failures += 1;
        self.system.state.step_s = shorter_s;
        self.refuse_small_step(self.system.state.applied_parameters.solver().min_step_s, failure)
    }

    fn refuse_small_step(&mut self, min_step_s: f64, failure: Failure) -> Result<(), PlantError> {
        if self.system.state.step_s >= min_step_s {
            Ok(())
        } else {
            Err(self.system.no_convergence(self.system.state.step_s, failure, self.stepper.remainder()))
        }
    }

    /// Counts an internal step to `end_s`; returns an error if it does not advance the time, or if the iteration budget of the
    /// communication step is used up.
    fn count_step(&mut self, step_s: f64, end_s: f64) -> Result<(), PlantError> {
        let time_s = self.system.state.start.time_s;
        if end_s.partial_cmp(&time_s) != Some(std::cmp::Ordering::Greater) {
            return Err(PlantError::Clock { time_s, step_s });
        }
        if self.work_left == 0 {
            let (most, cause) = (self.most_work, self.system.largest_input());
            return Err(PlantError::TooMuchWork { time_s, most, step_s, cause });
        }
        Ok(())
    }

    /// Takes one step of given length; it is halved if Newton's iteration fails.
    pub(crate) fn advance_fixed(&mut self, step_s: f64, end_s: f64) -> Result<(), PlantError> {
        let time_s = self.system.state.start.time_s;
        let stop_s = end_s.min(self.system.equations.next_kink_s(time_s));
        let (mut step_s, mut target_s) = fit_step(time_s, step_s, stop_s);
        self.count_step(step_s, target_s)?;
        while let Err(Untaken { step_s: failed_s, failure }) = self.take_fixed(step_s, target_s) {
            if self.system.machine.solver.most_iterations.is_some() {
                // no repetition in real time: a failure here is a state that is not finite, singular or diverged
                self.system.state.statistics.failures += 1;
                return Err(self.system.no_convergence(failed_s, failure, self.stepper.remainder()));
            }
            step_s = 0.5 * failed_s;
            target_s = time_s + step_s;
            self.give_up(step_s, failure)?;
            self.count_step(step_s, target_s)?;
        }
        self.system.state.statistics.steps += 1;
        if self.system.machine.solver.most_iterations.is_some() {
            // the bound after the last jump ends after this step
            self.system.state.step_s = self.system.state.applied_parameters.solver().max_step_s;
        }
        Ok(())
    }

    /// Takes one step of given length, or to the first crossing within it.
    pub(super) fn take_fixed(&mut self, step_s: f64, end_s: f64) -> Result<(), Untaken> {
        self.attempt_given(step_s)?;
        self.system.state.ahead.time_s = end_s;
        self.locate_crossing()
    }

    /// Takes one step of given length; in real time returns an error if the iteration diverges.
    fn attempt_given(&mut self, step_s: f64) -> Result<(), Untaken> {
        self.attempt(step_s, Length::Given).map_err(|error| Untaken { step_s, failure: Failure::Newton(error) })?;
        if self.system.machine.solver.most_iterations.is_none() {
            return Ok(());
        }
        if self.rest > LOST_REST {
            return Err(Untaken { step_s, failure: Failure::Unsolved { rest: self.rest } });
        }
        let State { start, ahead, .. } = &self.system.state;
        let turn_rad = |coordinate: usize| (ahead.q[coordinate] - start.q[coordinate]).abs();
        let turns = |body: usize| self.system.equations.model.bodies[body].joint.kind.translations() == 0;
        let far = |joint: &&JointForces| {
            joint.law().is_none() && turns(joint.body) && turn_rad(joint.coordinate) > LOST_TURN_RAD
        };
        match self.system.equations.forces.joints().iter().find(far) {
            Some(joint) => {
                let (coordinate, turn_rad) = (joint.coordinate, turn_rad(joint.coordinate));
                Err(Untaken { step_s, failure: Failure::Turned { coordinate, turn_rad } })
            }
            None => Ok(()),
        }
    }

    /// Takes one step from `start` to `ahead`; returns the error estimate.
    fn attempt(&mut self, step_s: f64, length: Length) -> Result<f64, NewtonError> {
        let accuracy = self.accuracy(step_s, length);
        let mut effort = Effort::default();
        let State { start, stages, ahead, statistics, .. } = &mut self.system.state;
        self.system.equations.branch_s = start.time_s + 0.5 * step_s;
        let outcome =
            self.stepper.step(&mut self.system.equations, start, step_s, (ahead, stages), accuracy, &mut effort);
        self.work_left = self.work_left.saturating_sub(effort.iterations.max(1));
        statistics.iterations += effort.iterations;
        statistics.factorizations += effort.factorizations;
        statistics.unconverged += effort.unconverged;
        self.rest = effort.rest;
        statistics.largest_iterations = statistics.largest_iterations.max(effort.largest);
        outcome
    }

    /// Required accuracy of Newton's iteration in a step.
    pub(super) fn accuracy(&self, step_s: f64, length: Length) -> Accuracy {
        let ceiling = if length == Length::Given { NEWTON_CEILING_EXACT } else { NEWTON_CEILING };
        let unnoticed = self.system.state.air.as_ref().map_or(f64::INFINITY, |history| history.motion_tolerance);
        Accuracy {
            tolerance: (NEWTON_SHARE * self.system.state.applied_parameters.solver().tolerance)
                .min(ceiling)
                .min(unnoticed),
            most_iterations: self.system.machine.solver.most_iterations,
            persistent: length == Length::Given,
            jumped: self.system.machine.solver.most_iterations.is_some() && self.system.state.step_s < step_s,
            cautious: self.system.state.air.is_some(),
        }
    }

    /// If indicators of forces are crossed inside the step, repeats the step so that it ends at the first crossing.
    ///
    /// Several may be crossed at the same instant (mirrored wings): all those within the accuracy of the location are.
    fn locate_crossing(&mut self) -> Result<(), Untaken> {
        let Some((mut crossed, mut fraction)) = self.first_crossing() else { return Ok(()) };
        let most = self.system.state.joints.len().max(self.system.equations.forces.indicators().count());
        for _ in 0..most {
            self.end_step_at_crossing(crossed, fraction)?;
            // the estimates may select the wrong one of two close crossings
            match self.first_crossing() {
                Some((other, at)) if other != crossed && !self.has_arrived(other, true) => {
                    (crossed, fraction) = (other, at)
                }
                _ => break,
            }
        }
        self.system.state.joints.iter_mut().for_each(|joint| joint.crossed = 0);
        let State { start, ahead, joints, .. } = &mut self.system.state;
        for indicator in self.system.equations.forces.indicators() {
            let forces = &self.system.equations.forces;
            let arrived = || {
                forces.is_armed(indicator, start, joints) && {
                    let (distance, closing) = forces.distance(indicator, start, ahead, joints);
                    distance <= CROSSING_S * closing
                }
            };
            if indicator == crossed || arrived() {
                joints[indicator.joint].crossed |= 1 << indicator.number;
            }
        }
        Ok(())
    }

    /// The armed indicator that is crossed first within the step, and an estimate of the fraction of the step at which it is crossed.
    fn first_crossing(&self) -> Option<(Indicator, f64)> {
        let State { start, stages, ahead, joints, .. } = &self.system.state;
        let taken = Taken { start, stages, end: ahead, continuation: &self.system.continuation };
        self.system.equations.forces.first_crossing(&taken, joints)
    }

    /// Signed distance of an indicator at `ahead` in rad and the rate at which it falls there in rad/s.
    fn distance(&self, indicator: Indicator) -> (f64, f64) {
        let State { start, ahead, joints, .. } = &self.system.state;
        self.system.equations.forces.distance(indicator, start, ahead, joints)
    }

    /// Whether an indicator is zero at `ahead` to the accuracy of the location; `only_just`: and not beyond.
    fn has_arrived(&self, indicator: Indicator, only_just: bool) -> bool {
        let (distance_rad, closing_rad_s) = self.distance(indicator);
        distance_rad <= CROSSING_S * closing_rad_s && (!only_just || distance_rad >= -CROSSING_S * closing_rad_s)
    }

    /// Repeats the step such that it ends at the zero of a falling indicator.
    ///
    /// False-position method (Illinois) for the step's length: each trial is a full step, so the state at the crossing is as accurate as at
    /// the end of any step.
    fn end_step_at_crossing(&mut self, indicator: Indicator, fraction: f64) -> Result<(), Untaken> {
        let State { start, ahead, joints, .. } = &self.system.state;
        let step_s = ahead.time_s - start.time_s;
        let (mut low, mut low_gap) = (0.0, self.system.equations.forces.distance(indicator, start, start, joints).0);
        let (mut high, mut high_gap) = (step_s, self.distance(indicator).0);
        let mut trial_s = fraction * step_s;
        if high_gap > 0.0 {
            // crossing and return within the step: the trial point inside brackets the crossing
            high = trial_s;
            high_gap = -f64::MIN_POSITIVE;
        }
        let real_time = self.system.machine.solver.most_iterations.is_some();
        // a force that holds the joint at its capture must capture it within its range
        let share = if self.system.equations.forces.lands_beyond(indicator) { 0.5 } else { 1.0 };
        for _ in 0..if real_time { MAX_LOCATING_STEPS_REAL_TIME } else { MAX_LOCATING_STEPS } {
            self.attempt_given(trial_s)?;
            let (distance, closing) = self.distance(indicator);
            let here = distance + (1.0 - share) * CROSSING_S * closing;
            if here.abs() <= share * CROSSING_S * closing || high - low <= CROSSING_S {
                break;
            }
            if here > 0.0 {
                (low, low_gap, high_gap) = (trial_s, here, 0.5 * high_gap);
            } else {
                (high, high_gap, low_gap) = (trial_s, here, 0.5 * low_gap);
            }
            // the tangent is most accurate near the crossing; the secant keeps the bracket
            let newton_s = trial_s + here / closing;
            let inside = newton_s > low && newton_s < high;
            trial_s = if inside { newton_s } else { low + (high - low) * low_gap / (low_gap - high_gap) };
        }
        Ok(())
    }

    /// Repeats a step that ends at a crossing, so that it ends there to round-off: a fixed share of [`CROSSING_S`] after it.
    pub(super) fn sharpen_crossing(&mut self, indicator: Indicator) -> Result<(), Untaken> {
        for _ in 0..SHARPENINGS {
            let State { start, ahead, joints, .. } = &self.system.state;
            if joints[indicator.joint].crossed & (1 << indicator.number) == 0 {
                break;
            }
            let step_s = ahead.time_s - start.time_s;
            let (distance, closing) = self.distance(indicator);
            self.attempt_given(step_s + distance / closing + SHARPENED * CROSSING_S)?;
        }
        Ok(())
    }

    /// Sets the current time to `time_s`, for callers whose clock has round-off.
    ///
    /// The shift is limited by the caller's check; the state itself is unchanged.
    pub fn adopt_time(&mut self, time_s: f64) {
        let shift_s = time_s - self.system.state.now.time_s;
        if shift_s != 0.0 {
            let State { before, start, stages, ahead, now, .. } = &mut self.system.state;
            for point in [before, start, ahead, now].into_iter().chain(stages) {
                point.time_s += shift_s;
            }
            self.system.state.now.time_s = time_s;
            self.system.state.applied_from_s += shift_s;
            if let Some(air) = &mut self.system.state.air {
                air.shift(shift_s);
            }
            self.system.configure();
            self.system.outputs.time_s = time_s;
        }
    }
}

/// Longest step of at most `step_s` that divides `span_s` evenly.
pub(crate) fn even_step(span_s: f64, step_s: f64) -> f64 {
    span_s / (span_s / step_s * (1.0 - 1e-9)).ceil().max(1.0)
}

/// Length of the next step and its end: `wanted_s`, but never beyond `stop_s`, and adjusted so that no very short step remains.
fn fit_step(time_s: f64, wanted_s: f64, stop_s: f64) -> (f64, f64) {
    let room_s = stop_s - time_s;
    if wanted_s >= room_s * (1.0 - 1e-9) {
        (room_s, stop_s)
    } else if 2.0 * wanted_s > room_s {
        (0.5 * room_s, time_s + 0.5 * room_s)
    } else {
        (wanted_s, time_s + wanted_s)
    }
}

#[cfg(test)]
#[path = "march_tests.rs"]
mod tests;
