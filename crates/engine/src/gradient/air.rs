//! Aerodynamic steps: variations and multipliers of the loads, which follow from the motion at the end of their own step, eqs. (X12), (X13),
//! or of its trial march, eq. (X39).

use crate::gradient::block::{self, Remains};
use crate::gradient::integrand::Mean;
use crate::gradient::sums::{OnEnd, Sums};
use crate::gradient::tape::Step;
use crate::gradient::variation::{Causes, Front, Variation};
use crate::gradient::{Gradient, GradientError, add, dot};
use crate::solve::point::Point;
use crate::system::System;
use crate::system::air::step_slopes::{AirStepSlopes, NoSlopes};
use nalgebra::Matrix3;
use std::ops::Range;

/// An aerodynamic step with its derivatives.
pub(super) struct AirStep<'a> {
    slopes: AirStepSlopes,
    /// Motion from which its loads follow.
    end: &'a Point,
    /// With the staggered coupling: the steps of the trial march that ends with this motion.
    trial: Option<&'a [Step]>,
    /// Per neighbour: slopes of the memory at its end and of the loads that act.
    by_neighbours: Vec<Vec<f64>>,
}

impl AirStep<'_> {
    /// Number of entries of a memory.
    pub fn memory_entries(&self) -> usize {
        self.slopes.memory_entries()
    }

    /// Place of a load or coefficient of a rotor in a memory.
    pub fn place_of(&self, [rotor, number]: [usize; 2]) -> Option<usize> {
        self.slopes.places_of_rotors().nth(rotor).map(|first| first + number)
    }

    /// Share of the step that has passed at a time.
    pub fn share_at(&self, time_s: f64) -> f64 {
        self.slopes.share_at(self.end.time_s - time_s)
    }
}

/// Variations of the loads in an aerodynamic step by the parameters, and with the staggered coupling those of the memory at its end.
#[derive(Default)]
pub(super) struct LoadVariations {
    pub loads: Vec<Vec<f64>>,
    pub memories: Option<Vec<Vec<f64>>>,
}

impl<'a> Gradient<'a> {
    /// Entries of the loads of the air.
    pub(super) fn load_entries(&self) -> usize {
        self.sections.as_ref().map_or(0, |sections| sections.entries(&self.system.equations))
    }

    /// Slopes along a change of each load of the air alone; `slope` need not set the loads back to the bit.
    pub(super) fn by_each_load(&mut self, slope: impl Fn(&mut System, &[f64]) -> f64) -> Vec<f64> {
        let entries = self.load_entries();
        let mut unit = vec![0.0; entries];
        let along = |load: usize| {
            unit[load] = 1.0;
            let slope = slope(self.system, &unit);
            unit[load] = 0.0;
            slope
        };
        let slopes = (0..entries).map(along).collect();
        self.system.configure();
        slopes
    }

    /// Derivatives of the aerodynamic step of some steps of the tape, the `place`th; `None` without air.
    pub(super) fn air_step(&mut self, place: usize, span: &Range<usize>) -> Result<Option<AirStep<'a>>, GradientError> {
        let tape = self.tape;
        let trial = tape.trials.get(place).map(Vec::as_slice);
        let last = trial.and_then(<[Step]>::last).or(tape.steps.get(span.end - 1));
        let (Some(last), true) = (last, self.sections.is_some()) else { return Ok(None) };
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
        Ok(Some(AirStep { slopes, end: &last.end, trial, by_neighbours }))
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
        air: &AirStep,
        ends: &[Variation],
        memories: Option<&[Vec<f64>]>,
    ) -> Vec<Vec<f64>> {
        let at = air.end;
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

    /// Calls a function that marches over the steps of the trial of an aerodynamic step.
    fn on_trial<T>(
        &mut self,
        (trial, span): (&'a [Step], &Range<usize>),
        march: impl FnOnce(&mut Self, Range<usize>) -> T,
    ) -> T {
        let own = (self.steps, self.step_before);
        (self.steps, self.step_before) = (trial, span.start.checked_sub(1).map(|before| &own.0[before]));
        let found = march(self, 0..trial.len());
        (self.steps, self.step_before) = own;
        found
    }

    /// Variations of the loads in an aerodynamic step by the parameters, from those of the motion and the memory at its start.
    pub(super) fn loads_forward(
        &mut self,
        (span, air): (&Range<usize>, &AirStep<'a>),
        front: &Front,
        memories: &[Vec<f64>],
    ) -> Result<LoadVariations, GradientError> {
        if let Some(trial) = air.trial {
            return self.loads_after_trial((trial, span, air), front.clone(), memories);
        }
        let mut base = front.clone();
        self.march(span, &mut base, Causes::PARAMETERS)?;
        let first_load = air.slopes.memory_entries();
        let loads = |after: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            after.into_iter().map(|mut after| after.split_off(first_load)).collect()
        };
        let rights = loads(self.air_forward(air, &base.variations, Some(memories)));
        let solved = block::solve(rights, |directions| {
            let still = Variation::zeros(self.system.coordinates());
            let mut front = Front { variations: vec![still; directions.len()], shifts_s: vec![0.0; directions.len()] };
            self.march(span, &mut front, Causes { parameters: false, loads: directions })?;
            let mut images = loads(self.air_forward(air, &front.variations, None));
            for (image, direction) in images.iter_mut().zip(directions) {
                image.iter_mut().zip(direction).for_each(|(image, direction)| *image = direction - *image);
            }
            Ok(images)
        });
        let loads = solved.map_err(|failure: Unsolved| failure.at(air.end.time_s))?;
        Ok(LoadVariations { loads, memories: None })
    }

    /// The same with the staggered coupling: the loads are those of the motion at the end of the trial march, eq. (X39).
    fn loads_after_trial(
        &mut self,
        (trial, span, air): (&'a [Step], &Range<usize>, &AirStep<'a>),
        mut front: Front,
        memories: &[Vec<f64>],
    ) -> Result<LoadVariations, GradientError> {
        let predicted: Vec<Vec<f64>> = memories.iter().map(|memory| air.slopes.predict(memory)).collect();
        let causes = Causes { parameters: true, loads: &predicted };
        self.on_trial((trial, span), |own, steps| own.march(&steps, &mut front, causes))?;
        let mut behind = self.air_forward(air, &front.variations, Some(memories));
        let loads = behind.iter_mut().map(|memory| memory.split_off(air.memory_entries())).collect();
        Ok(LoadVariations { loads, memories: Some(behind) })
    }

    /// Multipliers of the motion and of the memory at the start of an aerodynamic step, from those at its end; `sums` has the multipliers of
    /// its loads by results within it and the mean that covers it, and receives the slopes with respect to the parameters.
    pub(super) fn air_back(
        &mut self,
        (span, air): (&Range<usize>, &AirStep<'a>),
        on: OnEnd,
        sums: &mut Sums,
    ) -> Result<OnEnd, GradientError> {
        if let Some(trial) = air.trial {
            return self.trial_back((trial, span, air), on, sums);
        }
        let entries = self.load_entries();
        let OnEnd { motion, memory } = on;
        let at = air.end;
        let mut with_loads = memory;
        with_loads.resize(air.memory_entries() + entries, 0.0);
        let mean = sums.mean;
        // of the loads through the motion at the end, and by a mean over the steps
        let through = |own: &mut Self, on: &[f64], motion: &Variation, mean: Option<Mean>| {
            let (_, poses) = air.slopes.reverse(on);
            let end = own.on_end(at, &poses, motion);
            let mut sums = Sums { gradient: None, loads: vec![0.0; entries], mean };
            own.back_march(span.clone(), (end, 0.0), &mut sums)?;
            Ok::<_, GradientError>(sums.loads)
        };
        let mut right = sums.loads.clone();
        add(&mut right, 1.0, &through(self, &with_loads, &motion, mean)?);
        let still = Variation::zeros(motion.q.len());
        let first_load = air.slopes.memory_entries();
        let solved = block::solve(vec![right], |directions| {
            let image = |direction: &Vec<f64>| {
                let mut on = vec![0.0; first_load + entries];
                on[first_load..].copy_from_slice(direction);
                let mut image = through(self, &on, &still, None)?;
                image.iter_mut().zip(direction).for_each(|(image, direction)| *image = direction - *image);
                Ok::<_, GradientError>(image)
            };
            Ok(directions.iter().map(image).collect::<Result<Vec<_>, _>>()?)
        });
        let solved = solved.map_err(|failure: Unsolved| failure.at(at.time_s))?;
        with_loads[first_load..].copy_from_slice(&solved[0]);
        let (memory, poses) = air.slopes.reverse(&with_loads);
        let end = self.on_end(at, &poses, &motion);
        let (motion, _) = self.back_march(span.clone(), (end, 0.0), sums)?;
        self.add_by_air(air, &with_loads, sums);
        Ok(OnEnd { motion, memory })
    }

    /// The same with the staggered coupling: the loads act on the steps of the run, and follow from the trial march, eq. (X39).
    fn trial_back(
        &mut self,
        (trial, span, air): (&'a [Step], &Range<usize>, &AirStep<'a>),
        on: OnEnd,
        sums: &mut Sums,
    ) -> Result<OnEnd, GradientError> {
        let still = Variation::zeros(on.motion.q.len());
        let (mut motion, _) = self.back_march(span.clone(), (on.motion, 0.0), sums)?;
        let mut with_loads = on.memory;
        with_loads.append(&mut sums.loads);
        let (mut memory, poses) = air.slopes.reverse(&with_loads);
        self.add_by_air(air, &with_loads, sums);
        let end = self.on_end(air.end, &poses, &still);
        let mut of_trial = Sums { gradient: sums.gradient.take(), loads: vec![0.0; self.load_entries()], mean: None };
        let before = self.on_trial((trial, span), |own, steps| own.back_march(steps, (end, 0.0), &mut of_trial));
        sums.gradient = of_trial.gradient;
        motion.add(1.0, &before?.0);
        air.slopes.predict_back(&of_trial.loads, &mut memory);
        Ok(OnEnd { motion, memory })
    }

    /// Adds the slopes with respect to the parameters, for multipliers of the memory at the end of an aerodynamic step and of its loads.
    fn add_by_air(&self, air: &AirStep, with_loads: &[f64], sums: &mut Sums) {
        if let Some(gradient) = &mut sums.gradient {
            let by_neighbours: Vec<f64> = air.by_neighbours.iter().map(|slopes| dot(slopes, with_loads)).collect();
            add(gradient, 1.0, &self.by_parameters(air.end.time_s, &by_neighbours));
        }
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
