//! Slopes of results by the state at their instant.

use crate::gradient::parameter::Neighbours;
use crate::gradient::step::Variation;
use crate::gradient::tape::{Ending, Step};
use crate::gradient::{Gradient, GradientError};
use crate::math::difference::SIXTH_ORDER;
use crate::solve::EquationsOfMotion;
use crate::system::{EnergyOutputs, System};
use std::mem::offset_of;

/// Difference step of outputs by coordinates: rotation in rad, or displacement over the machine's length.
const STEP: f64 = 2e-3;

/// A result's slopes at the end of a step.
#[derive(Debug, Clone)]
pub(super) struct Seed {
    pub step: usize,
    pub state: Variation,
    pub by_shift: f64,
    pub by_parameters: Vec<f64>,
}

impl Gradient<'_> {
    pub(super) fn latch_seed(&mut self, joint: usize) -> Result<Seed, GradientError> {
        let n = self.system.coordinates();
        let steps = &self.tape.steps;
        let closes = |index: &usize| {
            let closed = |index: usize| steps[index].joints.get(joint).is_some_and(|memory| memory.latch.closed);
            !closed(index - 1) && closed(*index)
        };
        let step = (1..steps.len())
            .find(closes)
            .map(|index| index - 1)
            .filter(|index| matches!(steps[*index].ending, Ending::Crossing(indicator) if indicator.joint == joint))
            .ok_or_else(|| GradientError::Absent { what: format!("closing of the latch of joint {joint}") })?;
        let by_parameters = vec![0.0; self.neighbours.len()];
        Ok(Seed { step, state: Variation::zeros(n), by_shift: 1.0, by_parameters })
    }

    /// Slopes of an output by differences of sixth order in the coordinates; outputs are of second degree in rates and of first in
    /// accelerations, for which central differences are exact.
    pub(super) fn output_seed(&mut self, index: usize, time: usize) -> Result<Seed, GradientError> {
        let tape = self.tape;
        let step =
            *tape.marks.get(time).ok_or_else(|| GradientError::Absent { what: format!("requested time {time}") })?;
        if index >= self.system.outputs.values().len() {
            return Err(GradientError::Absent { what: format!("output {index}") });
        }
        let layout = self.system.outputs.layout();
        let account = |offset: usize| layout.energy.place(0, offset);
        if [account(offset_of!(EnergyOutputs, work)), account(offset_of!(EnergyOutputs, dissipated))].contains(&index) {
            return Err(GradientError::NotCovered { part: "energy accounts", place: "work and dissipation".into() });
        }
        if layout.changes_at_events(index) {
            return Err(GradientError::NotCovered {
                part: "outputs that change at events only, such as latch times",
                place: "ask for the latch time itself".into(),
            });
        }
        let at = &tape.steps[step];
        self.adopt(at);
        let own = &mut *self.system;
        for system in std::iter::once(own).chain(self.neighbours.iter_mut().flat_map(Neighbours::systems)) {
            let [tips, stations] = &tape.attitudes[time];
            system.state.tip_rotations.clone_from(tips);
            system.state.station_rotations.clone_from(stations);
        }
        let n = self.system.coordinates();
        let mut state = Variation::zeros(n);
        self.prepare(&at.end, None)?;
        let sizes: Vec<f64> = (0..n)
            .map(|i| {
                let mut unit = vec![0.0; n];
                unit[i] = 1.0;
                self.system.equations.norm(&unit)
            })
            .collect();
        let system = &mut *self.system;
        for (i, size) in sizes.into_iter().enumerate().filter(|(_, size)| *size > 0.0) {
            let step = STEP / size;
            for (k, weight) in (1..).zip(SIXTH_ORDER) {
                for sign in [1.0, -1.0] {
                    let shift = sign * f64::from(k) * step;
                    state.q[i] += sign * weight / (60.0 * step) * read(system, at, index, |q, _, _| q[i] += shift);
                }
            }
            let step = 1.0 / size;
            for sign in [0.5, -0.5] {
                state.v[i] += sign / step * read(system, at, index, |_, v, _| v[i] += 2.0 * sign * step);
                state.a[i] += sign / step * read(system, at, index, |_, _, a| a[i] += 2.0 * sign * step);
            }
        }
        for held in system.equations.held() {
            (state.v[held], state.a[held]) = (0.0, 0.0);
        }
        let by_parameters = self
            .neighbours
            .iter_mut()
            .map(|beside| beside.slope(|system| read(system, at, index, |_, _, _| {})))
            .collect();
        Ok(Seed { step, state, by_shift: 0.0, by_parameters })
    }
}

/// An output at the end of a step, after a change of its state.
fn read(system: &mut System, at: &Step, index: usize, change: impl FnOnce(&mut [f64], &mut [f64], &mut [f64])) -> f64 {
    let now = &mut system.state.now;
    now.copy_from(&at.end);
    change(&mut now.q, &mut now.v, &mut now.a);
    system.evaluate();
    system.outputs.values()[index]
}
