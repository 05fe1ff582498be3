//! Runs whose steps are kept for their derivatives.

use crate::force::joint::JointForces;
use crate::force::motor::{Motor, UNLIMITED};
use crate::force::set::Indicator;
use crate::gradient::tape::{Ending, Step};
use crate::gradient::{GradientError, Tape};
use crate::run::Plant;
use crate::run::even_step;
use crate::solve::point::Point;
use crate::system::PlantError;
use crate::system::state::State;

/// Distance of a motor's torque from its limit, as a share of the limit, within which neighbouring machines could be on another piece.
const LIMIT_SHARE: f64 = 0.01;

impl Plant {
    /// Runs on from the present with constant inputs and keeps the steps. Each of `times_s`, increasing, is the end of a step, so that the
    /// steps may be others than those of a run that interpolates there.
    ///
    /// Errors for machines with parts whose derivatives are not known, crossings without speed, and two at one instant; see
    /// [`GradientError`].
    pub fn run_on_tape(&mut self, times_s: &[f64]) -> Result<Tape, GradientError> {
        self.system.refuse_gradient()?;
        if self.tableau().is_none() {
            return Err(GradientError::NotCovered { part: "methods without stages", place: "solver.method".into() });
        }
        let mut tape = Tape::default();
        for &time_s in times_s {
            let from_s = self.system.state.ahead.time_s;
            if time_s.partial_cmp(&from_s) != Some(std::cmp::Ordering::Greater) {
                return Err(GradientError::Times { from_s, time_s });
            }
            self.allow_work(time_s - from_s);
            let fixed = self.system.machine.solver.fixed_step_s.map(|step_s| even_step(time_s - from_s, step_s));
            while self.system.state.ahead.time_s < time_s {
                self.step_on_tape(&mut tape, |plant| match fixed {
                    Some(step_s) => plant.advance_fixed(step_s, time_s),
                    None => plant.advance(time_s),
                })?;
            }
            let last = tape.steps.len() - 1;
            match &mut tape.steps[last].ending {
                ending @ Ending::Chosen => *ending = Ending::Given,
                Ending::Given => {}
                Ending::Crossing(indicator) => {
                    let first = self.joint_name(indicator.joint).to_owned();
                    return Err(GradientError::Simultaneous { first, second: "requested time".into(), time_s });
                }
            }
            tape.marks.push(last);
            let State { tip_rotations, station_rotations, .. } = &self.system.state;
            tape.attitudes.push([tip_rotations.clone(), station_rotations.clone()]);
        }
        let State { ahead, now, .. } = &mut self.system.state;
        now.copy_from(ahead);
        self.system.forget_outputs();
        self.system.provide(self.system.watched);
        Ok(tape)
    }

    /// One step, with the events at its start, onto the tape.
    pub(crate) fn step_on_tape(
        &mut self,
        tape: &mut Tape,
        advance: impl FnOnce(&mut Self) -> Result<(), PlantError>,
    ) -> Result<(), GradientError> {
        let State { before, start, ahead, .. } = &mut self.system.state;
        if ahead.time_s > start.time_s {
            before.copy_from(start);
        }
        start.copy_from(ahead);
        let events = self.system.state.statistics.events;
        self.system.apply_events()?;
        let renewed = tape.steps.is_empty() || self.system.state.statistics.events != events;
        let joints = self.system.state.joints.clone();
        advance(self)?;
        self.system.remember_attitudes();
        let State { start, stages, ahead, joints: behind, .. } = &self.system.state;
        let forces = &self.system.equations.forces;
        let mut crossed =
            forces.indicators().filter(|Indicator { joint, number }| behind[*joint].crossed & (1 << number) != 0);
        let (first, second) = (crossed.next(), crossed.next());
        if let (Some(first), Some(second)) = (first, second) {
            let [first, second] = [first, second].map(|indicator| self.joint_name(indicator.joint).to_owned());
            return Err(GradientError::Simultaneous { first, second, time_s: ahead.time_s });
        }
        let reaches_limit = |joint: &&JointForces| {
            let c = joint.coordinate;
            let at_limit = |motor: &Motor, at: &Point| {
                let [upper, lower] = motor.limit_distances_n_m(at.time_s, at.q[c], at.v[c]);
                upper.min(lower) < LIMIT_SHARE * motor.drive.torque_limit_n_m
            };
            joint
                .motor()
                .filter(|motor| motor.drive.torque_limit_n_m < UNLIMITED)
                .is_some_and(|motor| [start, ahead].into_iter().chain(stages).any(|point| at_limit(motor, point)))
        };
        if let Some(joint) = forces.joints().iter().find(reaches_limit) {
            let place = self.machine().bodies[joint.body].joint.name.clone();
            return Err(GradientError::NotCovered { part: "motors that reach their torque limit", place });
        }
        let step = Step {
            start: start.clone(),
            stages: stages.clone(),
            end: ahead.clone(),
            ending: first.map_or(Ending::Chosen, Ending::Crossing),
            joints,
            renewed,
        };
        let closing = first.map_or(0.0, |indicator| forces.distance(indicator, start, ahead, &step.joints).1);
        let coordinates = forces.joints().iter().map(|joint| joint.coordinate);
        tape.push(step, coordinates, closing, |joint| self.joint_name(joint).to_owned())
    }
}
