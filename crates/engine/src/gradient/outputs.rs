//! Slopes of results with respect to the state at their instant.

use crate::gradient::integrand::Mean;
use crate::gradient::step::{ONWARD, time_step_s};
use crate::gradient::tape::{Ending, Mark, Step};
use crate::gradient::variation::{Causes, Variation};
use crate::gradient::{Gradient, GradientError, RunResult, add};
use crate::math::difference::SIXTH_ORDER;
use crate::solve::point::Point;
use crate::system::{OutputSet, System};

/// Difference step of outputs by coordinates: rotation in rad, or displacement over the machine's length.
const STEP: f64 = 2e-3;

/// The part of a step behind which a result is known.
#[derive(Debug, Clone, Copy)]
pub(super) enum Part<'a> {
    /// None of it: the result is that of its start.
    Start,
    /// The jump of the rates at its start: the result is the impulse on this coordinate.
    Jump(usize),
    /// The step from its start to a requested time.
    Branch(&'a Step),
    /// All of it.
    Whole,
}

impl<'a> Part<'a> {
    pub fn of(branch: &'a Option<Step>) -> Self {
        branch.as_ref().map_or(Self::Start, Self::Branch)
    }
}

/// A result's slopes behind a part of a step.
#[derive(Debug, Clone)]
pub(super) struct Seed<'a> {
    pub step: usize,
    pub part: Part<'a>,
    pub state: Variation,
    pub by_shift: f64,
    /// By the loads of the air; empty without them.
    pub by_loads: Vec<f64>,
    pub by_parameters: Vec<f64>,
}

impl<'a> Gradient<'a> {
    /// The step that ends where the latch of a joint closes first.
    pub(super) fn latch_step(&self, joint: usize) -> Result<usize, GradientError> {
        let steps = &self.tape.steps;
        let closes = |index: &usize| {
            let closed = |index: usize| steps[index].joints.get(joint).is_some_and(|memory| memory.latch.closed);
            !closed(index - 1) && closed(*index)
        };
        (1..steps.len())
            .find(closes)
            .map(|index| index - 1)
            .filter(|index| matches!(steps[*index].ending, Ending::Crossing(indicator) if indicator.joint == joint))
            .ok_or_else(|| {
                let name = self.system.joint_name(joint);
                GradientError::Absent { what: format!("closing of the latch of joint {name}") }
            })
    }

    /// The step at whose start the rigid latch of a joint closes first, by an impulse.
    pub(super) fn impulse_step(&self, joint: usize) -> Result<usize, GradientError> {
        let behind = self.latch_step(joint)? + 1;
        let forces = &self.system.equations.forces.joints()[joint];
        let held = |step: &Step| forces.is_held_in(&step.joints[joint]);
        let steps = &self.tape.steps;
        match steps.get(behind).is_some_and(held) && !held(&steps[behind - 1]) {
            true => Ok(behind),
            false => {
                let name = self.system.joint_name(joint);
                Err(GradientError::Absent { what: format!("impulse of a rigid latch of joint {name}") })
            }
        }
    }

    /// Slopes of a result that depends on neither the state nor the parameters behind a part of a step.
    pub(super) fn no_seed(&self, step: usize, part: Part<'a>) -> Seed<'a> {
        let state = Variation::zeros(self.system.coordinates());
        let by_parameters = vec![0.0; self.entries.len()];
        Seed { step, part, state, by_shift: 0.0, by_loads: Vec::new(), by_parameters }
    }

    /// An output at a requested time whose slope is defined; otherwise the reason why not.
    pub(super) fn check_output(&self, index: usize, time: usize) -> Result<(), GradientError> {
        if time >= self.tape.marks.len() {
            return Err(GradientError::Absent { what: format!("requested time {time}") });
        }
        if index >= self.system.outputs.values().len() {
            return Err(GradientError::Absent { what: format!("output {index}") });
        }
        let layout = self.system.outputs.layout();
        if layout.circulation_m2_s.range().contains(&index) || layout.flaps.range().contains(&index) {
            let remedy = "choose loads or motions, or use finite differences".into();
            return Err(GradientError::OtherChoice { part: "circulations and control surfaces as results", remedy });
        }
        if self.sections.is_some() && self.tape.marks[time].branch.is_none() {
            let remedy = "choose a later time".into();
            return Err(GradientError::OtherChoice { part: "results at the start of a run with aerodynamics", remedy });
        }
        if layout.changes_at_events(index) {
            return Err(GradientError::OtherChoice {
                part: "outputs that change at events only, such as latch times",
                remedy: "choose the latch time of the joint as the result".into(),
            });
        }
        self.check_determined(index, time)
    }

    /// Puts all machines into the states of the joints at a requested time, and returns the point there.
    fn adopt_mark(&mut self, time: usize) -> Result<Point, GradientError> {
        let tape = self.tape;
        let mark = &tape.marks[time];
        self.adopt(&tape.steps[mark.step]);
        let at = tape.point(time);
        // poses for the size of a change
        self.place(at);
        Ok(at.clone())
    }

    /// An output at a requested time.
    pub(super) fn output_at(&mut self, index: usize, time: usize) -> Result<f64, GradientError> {
        let at = self.adopt_mark(time)?;
        Ok(values(self.system, &at)[index])
    }

    /// Rate of an output in time at a requested time after the start, along the length of the step that ends there, (X7), in its unit per s.
    ///
    /// # Errors
    /// Outputs and times that do not exist, outputs without a derivative, and the start of the run.
    pub fn rate(&mut self, index: usize, time: usize) -> Result<f64, GradientError> {
        self.check_output(index, time)?;
        let account = Mean::of(RunResult::Output { index, time }, self.tape, self.system);
        if let (Some(account), Some(branch)) = (account, &self.tape.marks[time].branch) {
            return self.account_rate(branch, &account);
        }
        let column = match &self.tape.marks[time].branch {
            Some(branch) => {
                self.adopt(branch);
                self.through(branch, &[], &[], Causes::NONE)?.pop()
            }
            None => None,
        };
        let Variation { q, v, a } =
            column.ok_or_else(|| GradientError::Absent { what: "rate at the start of the run".to_owned() })?;
        let at = self.adopt_mark(time)?;
        let mut rate = [0.0];
        for along in [(Kind::Coordinates, &q), (Kind::Rates, &v), (Kind::Accelerations, &a)] {
            add_slopes_along(self.system, &at, (along.0, along.1), &[index], &mut rate);
        }
        if self.inputs_move() || self.rotor_of(index).is_some() {
            let length_s = self.tape.marks[time].branch.as_ref().map_or(1.0, Step::length_s);
            rate[0] += self.slope_by_time(index, &at, length_s);
        }
        Ok(rate[0])
    }

    /// Slope of an output with respect to time, for inputs that vary and for loads of rotors, at a state in a step of given length.
    pub(super) fn slope_by_time(&mut self, index: usize, at: &Point, length_s: f64) -> f64 {
        self.hold(at);
        let step_s = time_step_s(length_s);
        let mut there = |time_s: f64| values(self.system, &Point { time_s, ..at.clone() })[index];
        let slope = ONWARD.iter().map(|(steps, weight)| weight / step_s * there(at.time_s + steps * step_s)).sum();
        self.let_go();
        slope
    }

    /// Slopes of an output with respect to the state at a requested time and to the parameters.
    pub(super) fn output_seed(&mut self, index: usize, time: usize) -> Result<Seed<'a>, GradientError> {
        let at = self.adopt_mark(time)?;
        let state = self.output_gradient(index, &at);
        let by_loads = self.output_by_loads(index, &at);
        let by_parameters = self.output_by_parameters(index, &at);
        let Mark { step, branch, .. } = &self.tape.marks[time];
        Ok(Seed { step: *step, part: Part::of(branch), state, by_shift: 0.0, by_loads, by_parameters })
    }

    /// Derivatives of an output with respect to the state at a prepared point.
    pub(super) fn output_gradient(&mut self, index: usize, at: &Point) -> Variation {
        let n = self.system.coordinates();
        let mut state = Variation::zeros(n);
        let mut unit = vec![0.0; n];
        for i in 0..n {
            unit[i] = 1.0;
            let mut slope = |kind| {
                let mut slope = [0.0];
                add_slopes_along(self.system, at, (kind, &unit), &[index], &mut slope);
                slope[0]
            };
            (state.q[i], state.v[i], state.a[i]) =
                (slope(Kind::Coordinates), slope(Kind::Rates), slope(Kind::Accelerations));
            unit[i] = 0.0;
        }
        for resting in self.system.equations.resting() {
            (state.v[resting], state.a[resting]) = (0.0, 0.0);
        }
        state
    }

    /// Derivatives of an output at a prepared point with respect to the loads of the air.
    pub(super) fn output_by_loads(&mut self, index: usize, at: &Point) -> Vec<f64> {
        self.by_each_load(|system, unit| {
            let mut slope = [0.0];
            add_slopes_by_loads(system, at, unit, &[index], &mut slope);
            slope[0]
        })
    }

    /// Derivatives of an output at a state with respect to the parameters.
    pub(super) fn output_by_parameters(&mut self, index: usize, at: &Point) -> Vec<f64> {
        self.hold(at);
        let by_neighbours = self.neighbours.iter_mut().map(|beside| beside.slope(|system| values(system, at)[index]));
        let by_neighbours: Vec<f64> = by_neighbours.collect();
        self.let_go();
        self.by_parameters(at.time_s, &by_neighbours)
    }

    /// Slopes of outputs (rows) by the parameters (columns) at a requested time, whose state varies with them by `variations` and the
    /// loads of the air by `loads`.
    pub(super) fn output_slopes(
        &mut self,
        indices: &[usize],
        time: usize,
        variations: &[Variation],
        loads: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, GradientError> {
        let at = self.adopt_mark(time)?;
        Ok(self.output_slopes_at(&at, indices, variations, loads))
    }

    /// The same at a prepared point.
    pub(super) fn output_slopes_at(
        &mut self,
        at: &Point,
        indices: &[usize],
        variations: &[Variation],
        loads: &[Vec<f64>],
    ) -> Vec<Vec<f64>> {
        let mut columns = Vec::new();
        self.hold(at);
        let by_neighbours: Vec<Vec<f64>> = self
            .neighbours
            .iter_mut()
            .map(|beside| {
                let mut slopes = vec![0.0; indices.len()];
                beside.add_slopes(&mut slopes, |system, each| {
                    let values = values(system, at);
                    each.iter_mut().zip(indices).for_each(|(each, index)| *each = values[*index]);
                });
                slopes
            })
            .collect();
        self.let_go();
        let shares = self.shares(at.time_s);
        for (direction, ((variation, entry), share)) in variations.iter().zip(&self.entries).zip(shares).enumerate() {
            let mut slopes = vec![0.0; indices.len()];
            add(&mut slopes, share, &by_neighbours[entry.beside]);
            let Variation { q, v, a } = variation;
            for along in [(Kind::Coordinates, q), (Kind::Rates, v), (Kind::Accelerations, a)] {
                add_slopes_along(self.system, at, (along.0, along.1), indices, &mut slopes);
            }
            if let Some(loads) = loads.get(direction) {
                add_slopes_by_loads(self.system, at, loads, indices, &mut slopes);
            }
            columns.push(slopes);
        }
        if !loads.is_empty() {
            self.system.configure();
        }
        (0..indices.len()).map(|row| columns.iter().map(|slopes| slopes[row]).collect()).collect()
    }
}

/// A part of the state.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Coordinates,
    Rates,
    Accelerations,
}

/// Adds the slopes of outputs along a direction of a part of the state: differences of sixth order in the coordinates; outputs are of second
/// degree in rates and of first in accelerations, for which central differences are exact.
fn add_slopes_along(
    system: &mut System,
    at: &Point,
    (kind, direction): (Kind, &[f64]),
    indices: &[usize],
    sum: &mut [f64],
) {
    let layout = system.outputs.layout();
    let wanted = indices.iter().fold(OutputSet::NONE, |wanted, index| wanted | layout.group(*index));
    let size = system.equations.size_of(direction);
    if size.is_nan() || size <= 0.0 {
        return;
    }
    let (step, weights): (f64, &[f64]) = match kind {
        Kind::Coordinates => (STEP / size, &SIXTH_ORDER.map(|weight| weight / 60.0)),
        Kind::Rates | Kind::Accelerations => (1.0 / size, &[0.5]),
    };
    // a step may lead past a kink of a force, and torques may be of any degree in the rates: they continue on their tangents at the point
    system.equations.forces.linearize(at.time_s, &at.q, &at.v);
    for (steps, weight) in (1..).zip(weights) {
        for sign in [1.0, -1.0] {
            let now = &mut system.state.now;
            now.copy_from(at);
            let part = match kind {
                Kind::Coordinates => &mut now.q,
                Kind::Rates => &mut now.v,
                Kind::Accelerations => &mut now.a,
            };
            add(part, sign * f64::from(steps) * step, direction);
            system.evaluate_only(wanted);
            let values = system.outputs.values();
            sum.iter_mut().zip(indices).for_each(|(sum, index)| *sum += sign * weight / step * values[*index]);
        }
    }
    system.equations.forces.drop_tangents();
}

/// Adds the slopes of outputs along a change of the loads of the air, of which they are linear. These are set back but for round-off.
fn add_slopes_by_loads(system: &mut System, at: &Point, direction: &[f64], indices: &[usize], sum: &mut [f64]) {
    let layout = system.outputs.layout();
    let wanted = indices.iter().fold(OutputSet::NONE, |wanted, index| wanted | layout.group(*index));
    let size = direction.iter().fold(0.0f64, |size, entry| size.max(entry.abs()));
    if size <= 0.0 {
        return;
    }
    let step = system.air_scale_n().max(f64::MIN_POSITIVE) / size;
    for sign in [1.0, -1.0] {
        system.state.now.copy_from(at);
        system.equations.add_air_loads(direction, sign * step);
        system.evaluate_only(wanted);
        system.equations.add_air_loads(direction, -sign * step);
        let values = system.outputs.values();
        sum.iter_mut().zip(indices).for_each(|(sum, index)| *sum += sign * 0.5 / step * values[*index]);
    }
}

/// All outputs at a point.
pub(super) fn values<'a>(system: &'a mut System, at: &Point) -> &'a [f64] {
    system.state.now.copy_from(at);
    system.evaluate();
    system.outputs.values()
}
