//! The steps of a run.

use crate::force::memory::JointMemory;
use crate::force::set::Indicator;
use crate::gradient::GradientError;
use crate::solve::point::Point;
use nalgebra::UnitQuaternion;

/// Closing speed at a crossing, as a share of the joint's largest rate so far, below which the crossing is grazing.
const GRAZING: f64 = 1e-6;

/// Rule for the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ending {
    /// Its length is that of the run.
    Chosen,
    /// A requested time.
    Given,
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
    /// States of the joints in it.
    pub joints: Vec<JointMemory>,
    /// The accelerations at its start follow from the equations there: at the start of the run and behind an event.
    pub renewed: bool,
    /// Its end.
    pub ending: Ending,
}

impl Step {
    /// Its stages behind the start, the end included.
    pub fn later(&self) -> impl DoubleEndedIterator<Item = &Point> {
        self.stages.iter().chain(std::iter::once(&self.end))
    }

    /// Length in s.
    pub fn length_s(&self) -> f64 {
        self.end.time_s - self.start.time_s
    }
}

/// The steps of a run, its events and the steps that end at the requested times.
#[derive(Debug, Clone, Default)]
pub struct Tape {
    pub(crate) steps: Vec<Step>,
    /// Per requested time, the step that ends there.
    pub(crate) marks: Vec<usize>,
    /// Per requested time the last quaternions of tips and stations, whose signs continue.
    pub(crate) attitudes: Vec<[Vec<UnitQuaternion<f64>>; 2]>,
    /// Per joint the largest rate so far.
    largest: Vec<f64>,
}

impl Tape {
    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// Size of its numbers in bytes.
    pub fn bytes(&self) -> usize {
        let point = |point: &Point| 8 * (3 * point.q.len() + point.auxiliary.len() + 6);
        self.steps
            .iter()
            .map(|step| point(&step.start) + step.later().map(point).sum::<usize>() + size_of_val(&step.joints[..]))
            .sum()
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
