//! Runs whose steps are kept for their derivatives.

use crate::force::set::Indicator;
use crate::gradient::inputs::{InputColumn, InputRows, Piece};
use crate::gradient::tape::{AT_END, Ending, Mark, Step};
use crate::gradient::timer::Timer;
use crate::gradient::{GradientError, Tape, parameter};
use crate::load::RootMotion;
use crate::run::Plant;
use crate::solve::continuation::Taken;
use crate::solve::point::Point;
use crate::system::PlantError;
use crate::system::state::State;
use nalgebra::UnitQuaternion;
use std::mem::offset_of;
use std::sync::Arc;

impl Plant {
    /// Runs on from the present and keeps the steps, which are those of a simulation: the requested times, increasing, lie within them. The
    /// state at a requested time is that of a separate step from the start of the one in which it lies. The first requested time may be the
    /// present.
    ///
    /// Inputs are constant. Initialise the plant again before its next run. Errors for machines with parts whose derivatives are not known,
    /// crossings without speed, and two at one instant; see [`GradientError`].
    pub fn run_on_tape(&mut self, times_s: &[f64]) -> Result<Tape, GradientError> {
        self.run_on_tape_with(&InputRows::default(), times_s)
    }

    /// The same with inputs over time. Before the initialisation they were set to their values at the start, by [`InputRows::set`]. Steps end
    /// at the rows.
    pub fn run_on_tape_with(&mut self, inputs: &InputRows, times_s: &[f64]) -> Result<Tape, GradientError> {
        self.system.refuse_gradient()?;
        if self.tableau().is_none() {
            return Err(GradientError::NotCovered {
                part: "the methods generalized_alpha and rk4",
                place: "solver.method".into(),
            });
        }
        let start_s = self.system.state.ahead.time_s;
        let mut from_s = start_s;
        for (place, &time_s) in times_s.iter().enumerate() {
            if !(time_s > from_s || (place == 0 && time_s == from_s)) || !time_s.is_finite() {
                return Err(GradientError::Times { from_s, time_s });
            }
            from_s = time_s;
        }
        self.refuse_rows_in_air(inputs, [start_s, from_s])?;
        let mut piece = inputs.piece_at(start_s);
        inputs.write_next(piece, &mut self.system.state);
        if self.system.state.inputs != self.system.state.applied_inputs {
            let cause = "they jump at the start; set them to their first values before the initialisation".into();
            return Err(GradientError::Inputs { cause });
        }
        let mut next = self.begin_piece(inputs, piece)?;
        let mut tape = Tape::with_inputs(inputs.clone());
        let last_s = from_s;
        if last_s == start_s {
            return Err(GradientError::Times { from_s, time_s: last_s });
        }
        self.allow_work(last_s - start_s);
        let fixed = self.system.machine.solver.fixed_step_s;
        // in air the loads before the last time depend on the motion at the end of its aerodynamic step
        while !tape.steps.last().is_some_and(|step| step.has(last_s)) || !tape.is_whole() {
            let end_s = inputs.end_s(piece);
            self.step_on_tape(&mut tape, (piece, next), |plant| match plant.structure_step_s().or(fixed) {
                Some(step_s) => plant.advance_fixed(step_s, end_s),
                None => plant.advance(end_s),
            })?;
            let step = tape.steps.len() - 1;
            next = false;
            if tape.steps[step].ends_at(end_s) {
                self.end_piece(&mut tape, end_s)?;
                piece = inputs.piece_at(end_s);
                next = self.begin_piece(inputs, piece)?;
            }
        }
        let behind = self.system.state.clone();
        for time_s in times_s {
            self.request(&mut tape, *time_s)?;
        }
        self.system.state = behind;
        self.system.configure();
        self.system.state.now.copy_from(tape.point(tape.marks.len() - 1));
        self.system.forget_outputs();
        self.system.provide(self.system.watched);
        Ok(tape)
    }

    /// Adds a requested time within the run on a tape; returns its index among the requested times. In a run along another's steps it
    /// belongs to the same step as in the other, even if it has moved out of it.
    ///
    /// The plant is the one that ran; initialise it again before its next run. Errors for times that are not within the run, and at a
    /// crossing.
    pub fn request(&mut self, tape: &mut Tape, time_s: f64) -> Result<usize, GradientError> {
        let from_s = tape.steps.first().map_or(f64::NAN, |step| step.start.time_s);
        let step = tape.step_at(time_s);
        let branch = match time_s == from_s {
            true => None,
            false if time_s > from_s && step < tape.steps.len() => Some(self.branch(tape, step, time_s)?),
            false => return Err(GradientError::Times { from_s, time_s }),
        };
        tape.marks.push(Mark { step, branch });
        Ok(tape.marks.len() - 1)
    }

    /// Outputs at a time within the run on a tape, interpolated within its step as those of a simulation; all of
    /// [`Outputs::values`](crate::system::Outputs::values).
    ///
    /// The plant is the one that ran; initialise it again before its next run. An error for times that are not within the run.
    pub fn outputs_on_tape(&mut self, tape: &Tape, time_s: f64) -> Result<&[f64], GradientError> {
        let place = tape.steps.partition_point(|step| !step.has(time_s));
        let from_s = tape.steps.first().map_or(f64::NAN, |step| step.start.time_s);
        let Some(step) = tape.steps.get(place).filter(|_| time_s >= from_s) else {
            return Err(GradientError::Times { from_s, time_s });
        };
        parameter::adopt(&mut self.system, step, &tape.inputs);
        let now = &mut self.system.state.now;
        Taken { start: &step.start, stages: &step.stages, end: &step.end, continuation: &self.system.continuation }
            .fill(now, time_s);
        self.system.evaluate();
        Ok(self.system.outputs.values())
    }

    /// The step from the start of a step of the tape to a time within it.
    pub(crate) fn branch(&mut self, tape: &Tape, index: usize, time_s: f64) -> Result<Step, GradientError> {
        let step = &tape.steps[index];
        if let Ending::Crossing(indicator) = step.ending
            && step.ends_at(time_s)
        {
            let first = self.joint_name(indicator.joint).to_owned();
            return Err(GradientError::Simultaneous { first, second: "requested time".into(), time_s });
        }
        parameter::adopt(&mut self.system, step, &tape.inputs);
        let mut branch = Step { ending: Ending::Given, timers: Vec::new(), ..step.clone() };
        let taken =
            self.closed_by(step, |plant| plant.step_apart(&step.start, time_s, (&mut branch.end, &mut branch.stages)));
        taken.map_err(|_| GradientError::NotSolved { time_s, left: f64::INFINITY })?;
        self.keep_last_stage(&mut branch)?;
        Ok(branch)
    }

    /// Returns an error for rows of the inputs within an aerodynamic step of a run: its loads up to the row follow from a motion behind it
    /// under the earlier inputs, which the run does not take. And for a rotation of the root that varies, with joints with redundant
    /// parameters: for a wing on a ball joint derivatives are then up to 4.4e-3 off, for an unknown reason (GR-99).
    fn refuse_rows_in_air(&self, inputs: &InputRows, [start_s, last_s]: [f64; 2]) -> Result<(), GradientError> {
        let Some(air) = self.system.machine.air.as_ref().filter(|_| !inputs.columns().is_empty()) else {
            return Ok(());
        };
        let root = self.system.state.inputs.layout().root;
        let rotations =
            [offset_of!(RootMotion, angular_velocity_rad_s), offset_of!(RootMotion, angular_acceleration_rad_s2)];
        let turns = |column: &InputColumn| {
            let own =
                rotations.iter().any(|part| (root.place(0, *part)..root.place(0, *part) + 3).contains(&column.index));
            own && column.values.iter().any(|value| *value != column.values[0])
        };
        if !self.system.equations.spatial.is_empty() && inputs.columns().iter().any(turns) {
            return Err(GradientError::OtherChoice {
                part: "a root whose rotation varies, of machines with aerodynamics and universal, ball or free joints",
                remedy: "keep root.angular_velocity and root.angular_acceleration constant, or use finite differences"
                    .into(),
            });
        }
        let steps = |time_s: f64| (time_s - start_s) / air.step_s;
        // the last aerodynamic step is taken to its end
        let last = (steps(last_s) - AT_END).ceil();
        let is_within = |row_s: &&f64| {
            let at = steps(**row_s);
            at > 0.0 && at < last && (at - at.round()).abs() > AT_END
        };
        match inputs.times_s().iter().find(is_within) {
            Some(row_s) => Err(GradientError::OtherChoice {
                part: "rows of the inputs within aerodynamic steps",
                remedy: format!(
                    "move the row at {row_s} s to a multiple of aerodynamics.step_s = {} s after the start",
                    air.step_s
                ),
            }),
            None => Ok(()),
        }
    }

    /// Gives the last step the end at a row of the inputs.
    pub(crate) fn end_piece(&self, tape: &mut Tape, time_s: f64) -> Result<(), GradientError> {
        let Some(step) = tape.steps.last_mut() else { return Ok(()) };
        if let Ending::Crossing(indicator) = step.ending {
            let first = self.joint_name(indicator.joint).to_owned();
            return Err(GradientError::Simultaneous { first, second: "row of the inputs".into(), time_s });
        }
        step.ending = Ending::Given;
        Ok(())
    }

    /// Continues with the inputs of a stretch; returns whether the equations have changed.
    pub(crate) fn begin_piece(&mut self, inputs: &InputRows, piece: Piece) -> Result<bool, GradientError> {
        let system = &mut self.system;
        system.state.now.copy_from(&system.state.ahead);
        inputs.write_next(piece, &mut system.state);
        // inputs that do not change at a row change there in runs with other values of the row
        if !system.inputs_changed() && !inputs.varies_at(piece.from_s) {
            return Ok(false);
        }
        system.apply_inputs()?;
        system.state.rates.clear();
        Ok(true)
    }

    /// Starts the next aerodynamic step if the present one has ended; returns whether it does.
    fn begin_air_step_on_tape(&mut self, tape: &mut Tape, piece: Piece) -> Result<bool, GradientError> {
        let begun = |plant: &Self| plant.system.state.air.as_ref().map(|air| air.steps);
        let before = begun(self);
        let trial = self.trial_on_tape(tape, piece)?;
        self.begin_air_step()?;
        let begins = begun(self) != before;
        if begins {
            tape.trials.extend(trial);
            tape.air = self.system.state.air.clone().map(Arc::new);
        }
        Ok(begins)
    }

    /// Steps of the trial march from which the loads of the next aerodynamic step follow in the staggered coupling, eq. (X39); `None` with
    /// another coupling, and within an aerodynamic step. The state is restored.
    fn trial_on_tape(&mut self, tape: &Tape, piece: Piece) -> Result<Option<Vec<Step>>, GradientError> {
        if !self.is_before_trial() {
            return Ok(None);
        }
        let (state, loads) = (self.system.state.clone(), self.system.equations.air.clone());
        let Some(end_s) = self.enter_trial()? else { return Ok(None) };
        let mut trial = Tape { largest: tape.largest.clone(), ..Tape::default() };
        trial.air = self.system.state.air.clone().map(Arc::new);
        let booked = std::mem::replace(&mut self.system.equations.booked, false);
        let marched = self.march_trial_on_tape(&mut trial, piece, end_s);
        self.system.equations.booked = booked;
        self.system.state = state;
        self.system.configure();
        self.system.equations.air = loads;
        marched?;
        if let Some(step) = trial.steps.iter().find(|step| step.episode > 0) {
            return Err(GradientError::OtherChoice {
                part: "a slew or failure that begins or ends within an aerodynamic step of the staggered coupling",
                remedy: format!(
                    "write coupling = \"iterated\", or move the event at {} s to an end of an aerodynamic step",
                    step.start.time_s
                ),
            });
        }
        Ok(Some(trial.steps))
    }

    /// The trial march with its own steps, to the end of the aerodynamic step.
    fn march_trial_on_tape(&mut self, trial: &mut Tape, piece: Piece, end_s: f64) -> Result<(), GradientError> {
        let is_fixed = self.system.machine.solver.fixed_step_s.is_some();
        while trial.steps.is_empty() || !trial.is_whole() {
            self.step_on_tape(trial, (piece, false), |plant| match plant.structure_step_s().filter(|_| is_fixed) {
                Some(step_s) => plant.advance_fixed(step_s, end_s),
                None => plant.advance(end_s),
            })?;
        }
        Ok(())
    }

    /// Whether the step just taken ends an aerodynamic step.
    fn ends_air_step(&self, tape: &Tape) -> bool {
        let State { start, ahead, .. } = &self.system.state;
        let span_s = ahead.time_s - start.time_s;
        tape.air.as_ref().is_some_and(|air| (ahead.time_s - air.loads.end_s).abs() <= AT_END * span_s)
    }

    /// Rule for the end of the step just taken, if nothing has crossed: that of an aerodynamic step is given, behind a crossing within it.
    fn ending_in_air(&self, tape: &Tape, crossed: Option<Indicator>) -> Result<Ending, GradientError> {
        let Some(air) = tape.air.as_ref().filter(|_| self.ends_air_step(tape)) else { return Ok(Ending::Chosen) };
        let ahead = &self.system.state.ahead;
        if let Some(indicator) = crossed {
            let first = self.joint_name(indicator.joint).to_owned();
            let second = "end of an aerodynamic step".into();
            return Err(GradientError::Simultaneous { first, second, time_s: ahead.time_s });
        }
        let together = |step: &&Step| step.air.as_ref().is_some_and(|own| Arc::ptr_eq(own, air));
        let moved = |step: &Step| matches!(step.ending, Ending::Crossing(_) | Ending::Timed);
        let moves = tape.steps.iter().rev().take_while(together).any(moved);
        Ok(if moves { Ending::Given } else { Ending::Chosen })
    }

    fn attitudes(&self) -> [Vec<UnitQuaternion<f64>>; 3] {
        let State { spatial_rotations, tip_rotations, station_rotations, .. } = &self.system.state;
        [spatial_rotations.clone(), tip_rotations.clone(), station_rotations.clone()]
    }

    /// One step, with the events at its start, onto the tape; `starts`: its stretch of the inputs starts with it.
    pub(crate) fn step_on_tape(
        &mut self,
        tape: &mut Tape,
        (piece, starts): (Piece, bool),
        advance: impl FnOnce(&mut Self) -> Result<(), PlantError>,
    ) -> Result<(), GradientError> {
        let State { before, start, ahead, .. } = &mut self.system.state;
        if ahead.time_s > start.time_s {
            before.copy_from(start);
        }
        start.copy_from(ahead);
        let events = self.system.state.statistics.events;
        self.system.apply_events()?;
        let begins = self.begin_air_step_on_tape(tape, piece)?;
        let time_s = self.system.state.start.time_s;
        let knot = self.system.equations.forces.kink_at(time_s);
        let failures = self.system.state.failures.clone();
        let fails = tape.steps.last().is_some_and(|step| step.failures != failures);
        tape.knots_s.extend((knot || fails).then_some(time_s));
        let events = self.system.state.statistics.events != events;
        let renewed = starts || begins || knot || events || tape.steps.is_empty();
        let joints = self.system.state.joints.clone();
        let episode = tape.steps.last().map_or(0, |step| {
            let slews = joints.iter().zip(&step.joints).any(|(own, before)| own.slew != before.slew);
            step.episode + usize::from(slews || fails)
        });
        advance(self)?;
        let closing = self.last_closing();
        self.loosen_bound_after_jump();
        self.system.remember_attitudes();
        let State { start, stages, ahead, joints: behind, .. } = &self.system.state;
        let forces = &self.system.equations.forces;
        let mut crossed =
            forces.indicators().filter(|Indicator { joint, number }| behind[*joint].crossed & (1 << number) != 0);
        let (first, second) = (crossed.next(), crossed.next());
        drop(crossed);
        if let (Some(first), Some(second)) = (first, second) {
            let [first, second] = [first, second].map(|indicator| self.joint_name(indicator.joint).to_owned());
            return Err(GradientError::Simultaneous { first, second, time_s: ahead.time_s });
        }
        let of_point = |at: &Point| {
            let found = forces.joints().iter().find_map(|joint| Some((joint.body, joint.kink(at)?)));
            found.map(|(body, kink)| (body, kink, at.time_s))
        };
        if let Some((body, kink, time_s)) = [start, ahead].into_iter().chain(stages).find_map(of_point) {
            let joint = self.machine().bodies[body].joint.name.clone();
            return Err(GradientError::Kink { joint, kink, time_s });
        }
        let before = tape.steps.last().map(|step| &step.end);
        self.system.refuse_jumps(before.into_iter().chain([start, ahead]).chain(stages))?;
        let timers = Timer::due(&self.system, ahead.time_s);
        let mut ending = self.ending_in_air(tape, first)?;
        let time_s = self.system.state.ahead.time_s;
        let knot = self.system.equations.forces.knot_at(time_s);
        if knot || !timers.is_empty() {
            let given = knot || self.ends_air_step(tape);
            ending = if given { Ending::Given } else { Ending::Timed };
            if let Some(first) = first {
                let first = self.joint_name(first.joint).to_owned();
                let second = match timers.first() {
                    Some(timer) if !knot => timer.name(&self.system),
                    Some(_) | None => "knot of a prescribed motion".into(),
                };
                return Err(GradientError::Simultaneous { first, second, time_s });
            }
        }
        let State { start, stages, ahead, .. } = &self.system.state;
        let forces = &self.system.equations.forces;
        let mut step = Step {
            start: start.clone(),
            stages: stages.clone(),
            end: ahead.clone(),
            last: None,
            closing,
            ending: first.map_or(ending, Ending::Crossing),
            joints,
            failures,
            episode,
            timers,
            renewed,
            piece,
            attitudes: self.attitudes(),
            air: tape.air.clone(),
        };
        let closing = first.map_or(0.0, |indicator| forces.distance(indicator, start, ahead, &step.joints).1);
        self.keep_last_stage(&mut step)?;
        if let Some(trial) = tape.trials.last_mut().filter(|_| begins) {
            trial.iter_mut().for_each(|of_trial| of_trial.episode = step.episode);
        }
        let coordinates = self.system.equations.forces.joints().iter().map(|joint| joint.coordinate);
        tape.push(step, coordinates, closing, |joint| self.joint_name(joint).to_owned())
    }
}
