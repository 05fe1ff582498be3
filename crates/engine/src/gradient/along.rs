//! Runs with the steps of another run: those whose differences are compared with derivatives.

use crate::force::Outcome;
use crate::force::drive::{Pieces, SlewPart};
use crate::force::generator::Segment;
use crate::force::memory::JointMemory;
use crate::gradient::inputs::InputRows;
use crate::gradient::tape::{Ending, Step};
use crate::gradient::{GradientError, Tape};
use crate::load::Wrench;
use crate::run::Plant;
use crate::system::PlantError;
use crate::system::air::{AirHistory, StepLoads};
use crate::system::state::State;
use std::ops::Range;
use std::sync::Arc;

/// Room for a crossing that moves, as a share of its step.
const ROOM: f64 = 1.4;
/// Change of the loads of an aerodynamic step between two trials, relative to the largest, that is round-off.
const SAME_LOADS: f64 = 1e-14;
/// The same where it no longer falls.
const STALLED_LOADS: f64 = 1e-11;
/// Trials of an aerodynamic step.
const MOST_TRIALS: usize = 60;

/// Smooth pieces on which the forces of a run lie, eq. (X34), stage by stage and joint by joint, and those of the sections of a rotor, eq.
/// (X37), aerodynamic step by aerodynamic step.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPieces(Vec<Option<PointPieces>>, Vec<usize>);

/// Pieces of the forces of one joint: of the torques of its motor and of its slew, and of its generator.
type PointPieces = (Option<(Pieces, SlewPart)>, Option<Segment>);

/// Whether latch, lock and stops of a joint are in the same states.
fn is_alike(a: &JointMemory, b: &JointMemory) -> bool {
    (a.released, a.latch.closed, a.latch.enabled, a.contact) == (b.released, b.latch.closed, b.latch.enabled, b.contact)
}

impl Plant {
    /// Runs with the steps of a tape, which another machine has run: lengths that the run has chosen stay, given times are reached, and
    /// crossings are located, to round-off. Of this run [`Gradient`](crate::gradient::Gradient) gives the derivative, so that differences
    /// between machines tend to it.
    ///
    /// The plant is initialised with the first values of `inputs`, whose rows have the times of those on the tape. The new tape has no
    /// requested times; one that is added belongs to the step in which it lies on the given tape.
    ///
    /// # Errors
    /// [`GradientError::Apart`] if another event ends a step, or joints are in other states than on the tape; those of [`Plant::run_on_tape`].
    pub fn run_along(&mut self, tape: &Tape, inputs: &InputRows) -> Result<Tape, GradientError> {
        self.system.refuse_gradient()?;
        let mut copy = Tape::with_inputs(inputs.clone());
        copy.along_s = tape.ends_s();
        match tape.steps.first().and_then(|step| step.air.as_deref()) {
            Some(first) => self.run_along_in_air((tape, inputs), first, &mut copy)?,
            None => {
                let mut piece = None;
                for index in 0..tape.steps.len() {
                    let step = &tape.steps[index];
                    let begins =
                        piece.replace(step.piece) != Some(step.piece) && self.begin_piece(inputs, step.piece)?;
                    self.step_along(&mut copy, (step, begins))?;
                    if step.ending == Ending::Given {
                        self.end_piece(&mut copy, step.end.time_s)?;
                    }
                }
            }
        }
        Ok(copy)
    }

    /// Pieces of the forces in a run of this plant.
    pub fn pieces_on_tape(&mut self, tape: &Tape) -> RunPieces {
        let mut pieces = Vec::new();
        for step in &tape.steps {
            crate::gradient::parameter::adopt(&mut self.system, step, &tape.inputs);
            let forces = &mut self.system.equations.forces;
            for at in std::iter::once(&step.start).chain(step.solved()) {
                forces.hold([at.time_s, step.middle_s()], &at.q, &at.v);
                let of_joint = |joint: &crate::force::joint::JointForces| {
                    let motor = joint.motor().and_then(|motor| motor.held).map(|held| held.pieces());
                    let segment = joint.generator().and_then(|generator| generator.held);
                    (!joint.held).then_some((motor, segment))
                };
                pieces.extend(forces.joints().iter().map(of_joint));
                forces.let_go();
            }
        }
        let mut of_air = Vec::new();
        for (place, span) in tape.spans().into_iter().enumerate() {
            // the loads follow from the motion at the end of the trial march, if there is one
            let of_trial = tape.trials.get(place).and_then(|trial| trial.last());
            let Some(step) = of_trial.or(tape.steps.get(span.end - 1)) else { continue };
            let Some(air) = step.air.as_deref() else { continue };
            crate::gradient::parameter::adopt(&mut self.system, step, &tape.inputs);
            if let Ok(pieces) = self.system.step_pieces(air, &step.end) {
                of_air.extend(pieces.choices());
            }
        }
        RunPieces(pieces, of_air)
    }

    /// One step of the tape, with the events at its start.
    fn step_along(&mut self, copy: &mut Tape, (step, begins): (&Step, bool)) -> Result<(), GradientError> {
        let apart = |what| GradientError::Apart { time_s: step.end.time_s, what };
        self.allow_work(1.0);
        self.step_on_tape(copy, (step.piece, begins), |plant| plant.closed_by(step, |plant| plant.retrace(step)))?;
        let Some(own) = copy.steps.last() else { return Ok(()) };
        let crossed = |ending| if let Ending::Crossing(indicator) = ending { Some(indicator) } else { None };
        if crossed(own.ending) != crossed(step.ending) {
            return Err(apart("another event ends its step"));
        }
        if !own.joints.iter().zip(&step.joints).all(|(own, taped)| is_alike(own, taped)) {
            return Err(apart("a lock, latch or stop is in another state"));
        }
        if own.failures.iter().zip(&step.failures).any(|(own, taped)| own.has_failed() != taped.has_failed()) {
            return Err(apart("a failure has occurred, or not"));
        }
        Ok(())
    }

    /// Takes a step again: a chosen length stays, a given end is reached, and a crossing that moves has room.
    fn retrace(&mut self, step: &Step) -> Result<(), PlantError> {
        let from_s = self.system.state.start.time_s;
        let (end_s, crossed) = match step.ending {
            Ending::Chosen => (from_s + step.length_s(), None),
            Ending::Given => (step.end.time_s, None),
            Ending::Timed => (self.system.equations.next_kink_s(from_s), None),
            Ending::Crossing(indicator) => (from_s + ROOM * step.length_s(), Some(indicator)),
        };
        self.take_fixed_step((end_s - from_s, end_s), crossed)
    }

    /// The same in air: in every aerodynamic step the loads are those of the motion at its end, to round-off.
    fn run_along_in_air(
        &mut self,
        (tape, inputs): (&Tape, &InputRows),
        first: &AirHistory,
        whole: &mut Tape,
    ) -> Result<(), GradientError> {
        let Some(own) = self.system.state.air.clone() else {
            return Err(GradientError::Apart { time_s: tape.steps[0].start.time_s, what: "it has no air" });
        };
        // the air at the start of the first step
        let mut before = AirHistory {
            before: own.after.clone(),
            begin: own.end.clone(),
            at_begin: own.loads.to.clone(),
            steps: 1,
            loads: StepLoads { end_s: first.loads.end_s, from: own.loads.to.clone(), ..own.loads.clone() },
            ..own
        };
        let mut piece = None;
        for (place, span) in tape.spans().into_iter().enumerate() {
            let next = tape.steps[span.start].piece;
            if piece.replace(next) != Some(next) {
                // rows are at ends of aerodynamic steps
                if let Some(last) = whole.steps.len().checked_sub(1) {
                    self.end_piece(whole, whole.steps[last].end.time_s)?;
                }
                self.begin_piece(inputs, next)?;
            }
            let found = match tape.trials.get(place) {
                Some(trial) => self.staggered_step_along((tape, span), trial, &mut before, whole)?,
                None => self.air_step_along((tape, span), &mut before, whole)?,
            };
            before = AirHistory {
                before: found.after.clone(),
                begin: found.end.clone(),
                at_begin: before.loads.from.clone(),
                steps: 2,
                loads: StepLoads { from: found.loads.to.clone(), ..found.loads.clone() },
                ..found
            };
        }
        Ok(())
    }

    /// The steps of one aerodynamic step, and the air at its end.
    fn air_step_along(
        &mut self,
        (tape, span): (&Tape, Range<usize>),
        before: &mut AirHistory,
        whole: &mut Tape,
    ) -> Result<AirHistory, GradientError> {
        let Some(air) = tape.steps[span.start].air.as_deref() else {
            return Err(GradientError::Apart { time_s: tape.steps[span.start].start.time_s, what: "it has air" });
        };
        (before.loads.begin_s, before.loads.end_s) = (air.loads.begin_s, air.loads.end_s);
        let begin = self.system.state.clone();
        let taped = whole.clone();
        let mut loads = vec![Wrench::default(); before.begin.len()];
        air.loads.write(&mut loads);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_TRIALS {
            whole.clone_from(&taped);
            self.march_along((&begin, acting(before, &loads)), &tape.steps[span.clone()], whole)?;
            let end = self.system.state.ahead.clone();
            let Some(found) = self.system.air_step_after(before, &end)? else { break };
            let mut new = loads.clone();
            found.loads.write(&mut new);
            let change = new.iter().zip(&loads).fold(0.0f64, |most, (a, b)| {
                most.max((a.force_n - b.force_n).amax()).max((a.moment_n_m - b.moment_n_m).amax())
            });
            let size = new.iter().fold(f64::MIN_POSITIVE, |most, load| most.max(load.force_n.amax()));
            loads = new;
            if change < SAME_LOADS * size || (change >= last && change < STALLED_LOADS * size) {
                whole.set_air_after(taped.steps.len(), &found);
                return Ok(found);
            }
            last = change;
        }
        Err(GradientError::NotSolved { time_s: air.loads.end_s, left: last })
    }

    /// Steps of an aerodynamic step from a state under constant loads.
    fn march_along(
        &mut self,
        (begin, air): (&State, AirHistory),
        steps: &[Step],
        copy: &mut Tape,
    ) -> Result<(), GradientError> {
        self.allow_work(1.0);
        self.system.state = begin.clone();
        self.system.configure();
        self.system.state.air = Some(air);
        let ahead = self.system.state.ahead.clone();
        self.system.state.start.copy_from(&ahead);
        self.system.discontinuity(|_, _| Outcome::default())?;
        copy.air = self.system.state.air.clone().map(Arc::new);
        for (index, step) in steps.iter().enumerate() {
            self.step_along(copy, (step, index == 0))?;
        }
        Ok(())
    }

    /// The steps of one aerodynamic step of the staggered coupling, and the air at its end, eq. (X39): a trial march under the predicted loads,
    /// and the steps of the run under those of its end.
    fn staggered_step_along(
        &mut self,
        (tape, span): (&Tape, Range<usize>),
        trial: &[Step],
        before: &mut AirHistory,
        whole: &mut Tape,
    ) -> Result<AirHistory, GradientError> {
        let (Some(first), Some(last)) = (trial.first(), trial.last()) else {
            return Err(GradientError::Apart { time_s: before.loads.end_s, what: "it has no trial march" });
        };
        (before.loads.begin_s, before.loads.end_s) = (first.start.time_s, last.end.time_s);
        let begin = self.system.state.clone();
        let mut predicted = before.loads.clone();
        if before.steps > 1 {
            for (to, (from, earlier)) in predicted.to.iter_mut().zip(predicted.from.iter().zip(&before.at_begin)) {
                to.force_n = from.force_n * 2.0 - earlier.force_n;
                to.moment_n_m = from.moment_n_m * 2.0 - earlier.moment_n_m;
            }
        } else {
            predicted.to.copy_from_slice(&predicted.from);
        }
        let mut loads = vec![Wrench::default(); before.begin.len()];
        predicted.write(&mut loads);
        let mut copy = Tape { largest: whole.largest.clone(), ..Tape::with_inputs(whole.inputs.clone()) };
        self.march_along((&begin, acting(before, &loads)), trial, &mut copy)?;
        let end = self.system.state.ahead.clone();
        let apart = GradientError::Apart { time_s: end.time_s, what: "it has no air" };
        let found = self.system.air_step_after(before, &end)?.ok_or(apart)?;
        found.loads.write(&mut loads);
        let marched = whole.steps.len();
        self.march_along((&begin, acting(before, &loads)), &tape.steps[span], whole)?;
        whole.set_air_after(marched, &found);
        whole.trials.push(copy.steps);
        Ok(found)
    }
}

/// The loads that act, as those of a step without circulation.
fn acting(before: &AirHistory, loads: &[Wrench]) -> AirHistory {
    let mut history = before.clone();
    for (own, load) in history.loads.impulsive.iter_mut().zip(loads) {
        *own = *load;
    }
    history.loads.from.fill(Wrench::default());
    history.loads.to.fill(Wrench::default());
    history
}
