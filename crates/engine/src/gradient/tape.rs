//! The steps of a run.

use crate::force::memory::JointMemory;
use crate::force::set::Indicator;
use crate::gradient::GradientError;
use crate::gradient::inputs::{InputRows, Piece};
use crate::gradient::timer::Timer;
use crate::multibody::rigid_loop::RigidFactor;
use crate::solve::point::Point;
use crate::system::air::AirHistory;
use crate::system::failure_memory::FailureMemory;
use nalgebra::UnitQuaternion;
use std::ops::Range;
use std::sync::Arc;

/// Closing speed at a crossing, as a share of the joint's largest rate so far, below which the crossing is grazing.
const GRAZING: f64 = 1e-6;

/// Distance of a requested time from the end of a step, as a share of the step, within which it is that end: accumulated round-off.
pub(crate) const AT_END: f64 = 1e-9;

/// Rule for the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ending {
    /// Its length is that of the run.
    Chosen,
    /// A given time: requested, of a row of the inputs, or of a knot of a prescribed motion.
    Given,
    /// The time of its timers, which may depend on the parameters: the end of a slew or of a ramp, a failure.
    Timed,
    /// An indicator falls through zero.
    Crossing(Indicator),
}

/// An accepted step.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// Its start, behind an event.
    pub start: Point,
    /// Its inner stages.
    pub stages: Vec<Point>,
    /// Its end, before an event.
    pub end: Point,
    /// Its last stage, for machines whose ends are projected onto the constraints of joints, (J6); otherwise it is the end.
    pub last: Option<Box<Point>>,
    /// The factors of its projection onto the constraints of rigid loops, skates and wheels, (C7).
    pub closing: Option<Arc<RigidFactor>>,
    /// States of the joints in it.
    pub joints: Vec<JointMemory>,
    /// States of the failures in it; empty without failures.
    pub failures: Vec<FailureMemory>,
    /// Number of changes of slews and failures before it.
    pub episode: usize,
    /// The timers that end it.
    pub timers: Vec<Timer>,
    /// The accelerations at its start follow from the equations there: at the start of the run and behind an event.
    pub renewed: bool,
    /// Rule for its end.
    pub ending: Ending,
    /// Its stretch of the inputs over time.
    pub piece: Piece,
    /// The quaternions of joints, tips and stations at its end, whose signs continue.
    pub attitudes: [Vec<UnitQuaternion<f64>>; 3],
    /// The air in its aerodynamic step.
    pub air: Option<Arc<AirHistory>>,
}

impl Step {
    /// Its stages behind the start, the end included.
    pub fn later(&self) -> impl DoubleEndedIterator<Item = &Point> {
        self.stages.iter().chain(std::iter::once(&self.end))
    }

    /// The stages behind the start, at which the equations of motion are satisfied.
    pub fn solved(&self) -> impl DoubleEndedIterator<Item = &Point> {
        self.stages.iter().chain(std::iter::once(self.last.as_deref().unwrap_or(&self.end)))
    }

    /// Whether a time lies in it, its end included.
    pub fn has(&self, time_s: f64) -> bool {
        time_s <= self.end.time_s + AT_END * self.length_s()
    }

    /// Whether a time is its end.
    pub fn ends_at(&self, time_s: f64) -> bool {
        (time_s - self.end.time_s).abs() <= AT_END * self.length_s()
    }

    /// Length in s.
    pub fn length_s(&self) -> f64 {
        self.end.time_s - self.start.time_s
    }

    /// Time within it whose branch of prescribed motions holds, in s.
    pub fn middle_s(&self) -> f64 {
        self.start.time_s + 0.5 * self.length_s()
    }
}

/// A requested time.
#[derive(Debug, Clone)]
pub(crate) struct Mark {
    /// The step in which it lies.
    pub step: usize,
    /// The step from that step's start to it; none at the start of the run.
    pub branch: Option<Step>,
}

/// The steps of a run, its events and the steps that end at the requested times.
#[derive(Debug, Clone, Default)]
pub struct Tape {
    /// Inputs over time; no columns for constant inputs.
    pub(crate) inputs: InputRows,
    pub(crate) steps: Vec<Step>,
    /// Per aerodynamic step of the staggered coupling: the steps of its trial march. Empty without this coupling.
    pub(crate) trials: Vec<Vec<Step>>,
    /// The requested times.
    pub(crate) marks: Vec<Mark>,
    /// Times in s of the knots of prescribed motions, at which accelerations may jump, and of failures.
    pub(crate) knots_s: Vec<f64>,
    /// Per joint the largest rate so far.
    pub(crate) largest: Vec<f64>,
    /// The air in the present aerodynamic step.
    pub(crate) air: Option<Arc<AirHistory>>,
    /// Ends in s of the steps of the run with whose steps this one was taken; empty for a run that chose its own.
    pub(crate) along_s: Vec<f64>,
}

impl Tape {
    /// An empty tape.
    pub(crate) fn with_inputs(inputs: InputRows) -> Self {
        Self { inputs, ..Self::default() }
    }

    /// Inputs over time; no columns for constant inputs.
    pub fn inputs(&self) -> &InputRows {
        &self.inputs
    }

    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// The step in which a time lies; in a run along another's steps, the step in which it lies there. Behind a crossing that moves, a time may
    /// lie in the next step of a neighbouring run; a state from there would have the error of another step, and the difference of both runs
    /// would not tend to the derivative.
    pub(crate) fn step_at(&self, time_s: f64) -> usize {
        match self.along_s.is_empty() {
            true => self.steps.partition_point(|step| !step.has(time_s)),
            false => self.along_s.partition_point(|end_s| *end_s < time_s),
        }
    }

    /// Times in s up to which the steps have a time.
    pub(crate) fn ends_s(&self) -> Vec<f64> {
        self.steps.iter().map(|step| step.end.time_s + AT_END * step.length_s()).collect()
    }

    /// The point at a requested time.
    pub(crate) fn point(&self, time: usize) -> &Point {
        let Mark { step, branch, .. } = &self.marks[time];
        branch.as_ref().map_or(&self.steps[*step].start, |branch| &branch.end)
    }

    /// Steps that share loads of the air: those of an aerodynamic step. Without air each is alone.
    pub(crate) fn spans(&self) -> Vec<Range<usize>> {
        let together = |a: &Step, b: &Step| match (&a.air, &b.air) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, _) | (_, None) => false,
        };
        let mut first = 0;
        let of = |steps: &[Step]| {
            first += steps.len();
            first - steps.len()..first
        };
        self.steps.chunk_by(together).map(of).collect()
    }

    /// Whether the last step ends an aerodynamic step, if there is air.
    pub(crate) fn is_whole(&self) -> bool {
        let end_s = |air: &Arc<AirHistory>| air.loads.end_s;
        self.steps.last().is_none_or(|step| step.air.as_ref().is_none_or(|air| step.ends_at(end_s(air))))
    }

    /// Times in s at which outputs may jump: of crossings of latches and stops, of jumps of the inputs and of knots of prescribed motions.
    pub fn jumps_s(&self) -> impl Iterator<Item = f64> {
        self.inputs.jumps_s().chain(self.crossings_s()).chain(self.knots_s.iter().copied())
    }

    /// Times in s of the crossings of latches and stops.
    pub fn crossings_s(&self) -> impl Iterator<Item = f64> {
        let crossings = self.steps.iter().filter(|step| matches!(step.ending, Ending::Crossing(_)));
        crossings.map(|step| step.end.time_s)
    }

    /// Time in s at which the latch of a joint closes for the first time; `None` if it does not.
    pub fn latch_time_s(&self, joint: usize) -> Option<f64> {
        let closed = |step: &Step| step.joints.get(joint).is_some_and(|memory| memory.latch.closed);
        let behind = self.steps.windows(2).find(|pair| !closed(&pair[0]) && closed(&pair[1]))?;
        Some(behind[1].start.time_s)
    }

    /// Sets the state of the air at the end of the last aerodynamic step. `first`: index of the first of its steps.
    pub(crate) fn set_air_after(&mut self, first: usize, found: &AirHistory) {
        let Some(mut air) = self.air.as_deref().cloned() else { return };
        air.after.clone_from(&found.after);
        let air = Arc::new(air);
        self.steps[first..].iter_mut().for_each(|step| step.air = Some(Arc::clone(&air)));
        self.air = Some(air);
    }

    /// Size of its numbers in bytes.
    pub fn bytes(&self) -> usize {
        let point = |point: &Point| 8 * (3 * point.q.len() + point.auxiliary.len() + 6);
        let branches = self.marks.iter().filter_map(|mark| mark.branch.as_ref());
        self.steps
            .iter()
            .chain(self.trials.iter().flatten())
            .chain(branches)
            .map(|step| {
                let attitudes: usize = step.attitudes.iter().map(|own| size_of_val(&own[..])).sum();
                point(&step.start)
                    + step.later().map(point).sum::<usize>()
                    + size_of_val(&step.joints[..])
                    + size_of_val(&step.failures[..])
                    + attitudes
            })
            .sum::<usize>()
            + self.spans().len() * self.air.as_ref().map_or(0, |air| air.bytes())
    }

    /// Adds a step; `closing_1_s`: the rate at which the crossed indicator falls. `name`: of a joint.
    pub(crate) fn push(
        &mut self,
        step: Step,
        coordinates: impl Iterator<Item = usize>,
        closing_1_s: f64,
        name: impl Fn(usize) -> String,
    ) -> Result<(), GradientError> {
        self.largest.resize(step.joints.len(), 0.0);
        for (largest, c) in self.largest.iter_mut().zip(coordinates) {
            *largest = step.later().fold(largest.max(step.start.v[c].abs()), |largest, at| largest.max(at.v[c].abs()));
        }
        if let Ending::Crossing(Indicator { joint, .. }) = step.ending
            && closing_1_s <= GRAZING * self.largest[joint]
        {
            return Err(GradientError::Grazing { joint: name(joint), time_s: step.end.time_s, closing_1_s });
        }
        self.steps.push(step);
        Ok(())
    }
}
