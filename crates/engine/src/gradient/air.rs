//! Aerodynamic steps: variations and multipliers of the loads, which follow from the motion at the end of their own step, eqs. (X12), (X13).

use crate::gradient::block::{self, Remains};
use crate::gradient::sums::{OnEnd, Sums};
use crate::gradient::variation::{Causes, Front, Variation};
use crate::gradient::{Gradient, GradientError, add, dot};
use crate::solve::point::Point;
use crate::system::air::step_slopes::{AirStepSlopes, NoSlopes};
use nalgebra::Matrix3;
use std::ops::Range;

/// An aerodynamic step with its derivatives.
pub(super) struct AirStep {
    slopes: AirStepSlopes,
    /// Per neighbour: slopes of the memory at its end and of the loads that act.
    by_neighbours: Vec<Vec<f64>>,
}

impl Gradient<'_> {
    /// Entries of the loads of the air.
    pub(super) fn load_entries(&self) -> usize {
        self.sections.as_ref().map_or(0, |sections| sections.entries(&self.system.equations))
    }

    /// Derivatives of the aerodynamic step of some steps of the tape; `None` without air.
    pub(super) fn air_step(&mut self, span: &Range<usize>) -> Result<Option<AirStep>, GradientError> {
        let tape = self.tape;
        let (Some(last), true) = (tape.steps.get(span.end - 1), self.sections.is_some()) else { return Ok(None) };
        let Some(air) = last.air.as_deref() else { return Ok(None) };
        self.adopt(last);
        let slopes = self.system.air_step_slopes(air, &last.end).map_err(|error| match error {
            NoSlopes::Still(body) => {
                let place = self.system.machine.bodies[body].name.clone();
                GradientError::NotCovered { part: "strips without relative flow", place }
            }
            NoSlopes::Kink(body) => {
                let (body, at) = (self.system.machine.bodies[body].name.clone(), "a row of its polar");
                GradientError::Corner { body, at, time_s: last.end.time_s }
            }
            NoSlopes::Node(body) => {
                let (body, at) = (self.system.machine.bodies[body].name.clone(), "a point of the turbulence grid");
                GradientError::Corner { body, at, time_s: last.end.time_s }
            }
            NoSlopes::End(body) => {
                let place = self.system.machine.bodies[body].name.clone();
                GradientError::NotCovered { part: "annuli whose momentum balance ends beside their state", place }
            }
            NoSlopes::NoWind => {
                let remedy = "use a wind along the shaft, or aerodynamics.skewed_wake = false".into();
                GradientError::OtherChoice { part: "a rotor with a skewed wake in still air", remedy }
            }
            NoSlopes::Step(error) => error.into(),
        })?;
        let reference: Vec<Matrix3<f64>> = self.system.section_attitudes(&last.end);
        let pieces = slopes.pieces();
        let each = self.neighbours.iter_mut().map(|beside| beside.air_slopes((air, pieces), &last.end, &reference));
        let by_neighbours = each.collect::<Result<_, _>>()?;
        Ok(Some(AirStep { slopes, by_neighbours }))
    }

    /// Variations of the memory of the air at the start of the run.
    pub(super) fn start_memories(&self) -> Vec<Vec<f64>> {
        let start_s = self.tape.steps.first().map_or(0.0, |step| step.start.time_s);
        let of = |(entry, share): (&crate::gradient::Entry, f64)| -> Vec<f64> {
            self.neighbours[entry.beside].start_memory.iter().map(|slope| share * slope).collect()
        };
        self.entries.iter().zip(self.shares(start_s)).map(of).collect()
    }

    /// Variations of the memory at the end of an aerodynamic step, and behind them those of the loads that act, for variations of the motion
    /// there. `memories`: at its start, by the parameters; without them those of the motion alone.
    pub(super) fn air_forward(
        &mut self,
        (span, air): (&Range<usize>, &AirStep),
        ends: &[Variation],
        memories: Option<&[Vec<f64>]>,
    ) -> Vec<Vec<f64>> {
        let tape = self.tape;
        let at = &tape.steps[span.end - 1].end;
        let none = vec![0.0; air.slopes.memory_entries()];
        let shares = self.shares(at.time_s);
        let mut all = Vec::with_capacity(ends.len());
        for (direction, end) in ends.iter().enumerate() {
            let Some(sections) = &mut self.sections else { break };
            let poses = sections.poses(&mut self.system.equations, [&at.q, &at.v], [&end.q, &end.v]);
            let memory = memories.map_or(&none, |memories| &memories[direction]);
            let mut after = air.slopes.forward(memory, &poses);
            if memories.is_some() {
                add(&mut after, shares[direction], &air.by_neighbours[self.entries[direction].beside]);
            }
            all.push(after);
        }
        all
    }

    /// Variations of the loads in an aerodynamic step by the parameters, from those of the motion and the memory at its start.
    pub(super) fn loads_forward(
        &mut self,
        (span, air): (&Range<usize>, &AirStep),
        front: &Front,
        memories: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, GradientError> {
        let mut base = front.clone();
        self.march(span, &mut base, Causes::PARAMETERS)?;
        let first_load = air.slopes.memory_entries();
        let loads = |after: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            after.into_iter().map(|mut after| after.split_off(first_load)).collect()
        };
        let rights = loads(self.air_forward((span, air), &base.variations, Some(memories)));
        block::solve(rights, |directions| {
            let still = Variation::zeros(self.system.coordinates());
            let mut front = Front { variations: vec![still; directions.len()], shifts_s: vec![0.0; directions.len()] };
            self.march(span, &mut front, Causes { parameters: false, loads: directions })?;
            let mut images = loads(self.air_forward((span, air), &front.variations, None));
            for (image, direction) in images.iter_mut().zip(directions) {
                image.iter_mut().zip(direction).for_each(|(image, direction)| *image = direction - *image);
            }
            Ok(images)
        })
        .map_err(|failure: Unsolved| failure.at(self.tape.steps[span.end - 1].end.time_s))
    }

    /// Multipliers of the motion and of the memory at the start of an aerodynamic step, from those at its end; `sums` has the multipliers of
    /// its loads by results within it, and receives the slopes with respect to the parameters.
    pub(super) fn air_back(
        &mut self,
        (span, air): (&Range<usize>, &AirStep),
        on: OnEnd,
        sums: &mut Sums,
    ) -> Result<OnEnd, GradientError> {
        let entries = self.load_entries();
        let OnEnd { motion, memory } = on;
        let tape = self.tape;
        let at = &tape.steps[span.end - 1].end;
        let time_s = self.end_s(span);
        let mut with_loads = memory;
        with_loads.resize(air.slopes.memory_entries() + entries, 0.0);
        // of the loads through the motion at the end
        let through = |own: &mut Self, on: &[f64], motion: &Variation| {
            let (_, poses) = air.slopes.reverse(on);
            let end = own.on_end(at, &poses, motion);
            let mut sums = Sums { gradient: None, loads: vec![0.0; entries], mean: None };
            own.back_march(span.clone(), (end, 0.0), &mut sums)?;
            Ok::<_, GradientError>(sums.loads)
        };
        let mut right = sums.loads.clone();
        add(&mut right, 1.0, &through(self, &with_loads, &motion)?);
        let still = Variation::zeros(motion.q.len());
        let first_load = air.slopes.memory_entries();
        let solved = block::solve(vec![right], |directions| {
            let image = |direction: &Vec<f64>| {
                let mut on = vec![0.0; first_load + entries];
                on[first_load..].copy_from_slice(direction);
                let mut image = through(self, &on, &still)?;
                image.iter_mut().zip(direction).for_each(|(image, direction)| *image = direction - *image);
                Ok::<_, GradientError>(image)
            };
            Ok(directions.iter().map(image).collect::<Result<Vec<_>, _>>()?)
        });
        let solved = solved.map_err(|failure: Unsolved| failure.at(time_s))?;
        with_loads[first_load..].copy_from_slice(&solved[0]);
        let (memory, poses) = air.slopes.reverse(&with_loads);
        let end = self.on_end(at, &poses, &motion);
        let (motion, _) = self.back_march(span.clone(), (end, 0.0), sums)?;
        if let Some(gradient) = &mut sums.gradient {
            let by_neighbours: Vec<f64> = air.by_neighbours.iter().map(|slopes| dot(slopes, &with_loads)).collect();
            add(gradient, 1.0, &self.by_parameters(at.time_s, &by_neighbours));
        }
        Ok(OnEnd { motion, memory })
    }

    /// Multipliers of the motion at the end of a step with those of the poses of the sections.
    fn on_end(&mut self, at: &Point, poses: &[f64], motion: &Variation) -> Variation {
        let mut end = motion.clone();
        if let Some(sections) = &mut self.sections {
            let [on_q, on_v] = sections.on_motion(&mut self.system.equations, [&at.q, &at.v], poses);
            add(&mut end.q, 1.0, &on_q);
            add(&mut end.v, 1.0, &on_v);
        }
        end
    }

    fn end_s(&self, span: &Range<usize>) -> f64 {
        self.tape.steps[span.end - 1].end.time_s
    }
}

/// Reason for which the loads of a step have no variation.
enum Unsolved {
    Left(f64),
    Other(GradientError),
}

impl From<Remains> for Unsolved {
    fn from(Remains(left): Remains) -> Self {
        Self::Left(left)
    }
}

impl From<GradientError> for Unsolved {
    fn from(error: GradientError) -> Self {
        Self::Other(error)
    }
}

impl Unsolved {
    fn at(self, time_s: f64) -> GradientError {
        match self {
            Self::Left(left) => GradientError::NotSolved { time_s, left },
            Self::Other(error) => error,
        }
    }
}
