//! Derivatives of whole runs by parameters, through latches and end stops, also with strip theory, NOTATION eqs. (X6)–(X13), (X17)–(X23).
//!
//! [`Plant::run_on_tape`] keeps the steps of a run on a [`Tape`]. [`Gradient`] differentiates the discrete run along it, whose step lengths
//! stay as they are except two kinds: a step that ends at a crossing moves with the crossing, and steps to given times, those of rows of the
//! inputs and the separate ones to requested times, end there. [`Gradient::forward`] carries one variation per parameter;
//! [`Gradient::adjoint`] carries the multipliers of one result back, at a cost that hardly depends on the number of parameters. Both are
//! exact for that discrete run and agree to round-off.

mod account;
mod adjoint;
mod air;
mod block;
mod directions;
mod forward;
mod inputs;
mod jump;
mod mean;
mod outputs;
mod parameter;
mod prescribed;
mod projection;
mod run;
mod sections;
mod slopes;
mod step;
mod tape;

pub use inputs::{InputColumn, InputRows};
pub use parameter::Parameter;
pub use tape::Tape;

use crate::multibody::derivative::Derivative;
use crate::run::Plant;
use crate::solve::tableau::Tableau;
use crate::system::{PlantError, System};
use account::Account;
use directions::Directions;
use inputs::Piece;
use outputs::{Part, Seed};
use parameter::Neighbours;
use sections::Sections;
use step::{Factors, Side};

/// Reason why a run has no gradient.
#[derive(Debug, thiserror::Error)]
pub enum GradientError {
    /// A part of the machine has no exact derivative yet.
    #[error("gradients do not cover {part} ({place}); remove it, or use finite differences")]
    NotCovered {
        /// Kind of part, in words.
        part: &'static str,
        /// Its name.
        place: String,
    },
    /// A crossing that the motion only touches: its instant has no derivative.
    #[error(
        "joint {joint} reaches its latch or end stop at {time_s} s with a rate of only {closing_1_s:.1e} rad/s (or \
         m/s), less than a millionth of its largest rate: the time of contact has no derivative; change the model so \
         that the joint arrives faster or does not arrive"
    )]
    Grazing {
        /// Joint.
        joint: String,
        /// Time in s.
        time_s: f64,
        /// Rate at which the indicator falls.
        closing_1_s: f64,
    },
    /// Two crossings at one instant.
    #[error(
        "joints {first} and {second} have events at the same time, {time_s} s: a parameter changes the order of the \
         events, so the two one-sided derivatives differ; separate the events by a small asymmetry"
    )]
    Simultaneous {
        /// One joint.
        first: String,
        /// The other, or the same.
        second: String,
        /// Time in s.
        time_s: f64,
    },
    /// Inputs over time that are not possible.
    #[error("inputs over time: {cause}")]
    Inputs {
        /// Cause, in words.
        cause: String,
    },
    /// A requested time that is not after the one before it.
    #[error("the requested times must increase from the present, {from_s} s, on; {time_s} s does not")]
    Times {
        /// Time before it in s.
        from_s: f64,
        /// Time requested in s.
        time_s: f64,
    },
    /// A neighbouring machine has other coordinates or starts in another state.
    #[error(
        "a small change of parameter {parameter} changes {what}, so the derivative is not defined; choose another \
         value, or another parameter"
    )]
    Structure {
        /// Name of the parameter.
        parameter: String,
        /// Change, in words.
        what: &'static str,
    },
    /// A result that this run does not have.
    #[error("the run has no {what}; use a later stop time, or choose another result")]
    Absent {
        /// Result, in words.
        what: String,
    },
    /// A linear system without a solution to round-off.
    #[error(
        "the iteration for the linear equations of the step to {time_s} s converges too slowly (relative residual \
         {left:.1e}); use a smaller solver.tolerance or solver.max_step"
    )]
    NotSolved {
        /// End of the step in s.
        time_s: f64,
        /// Size of the last correction relative to the solution.
        left: f64,
    },
    /// The run itself failed.
    #[error(transparent)]
    Run(#[from] PlantError),
}

/// A result of a run, a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunResult {
    /// An output at a requested time; the energy accounts are integrals up to there.
    Output {
        /// Index in [`Outputs::values`](crate::system::Outputs::values).
        index: usize,
        /// Index of the time among those requested.
        time: usize,
    },
    /// The instant of the first closing of the latch of a joint, s.
    LatchTime {
        /// Index of the joint among those with one freedom.
        joint: usize,
    },
    /// The impulse on the outer body with which a rigid latch closes for the first time, N·m·s; at prismatic joints N·s.
    Impulse {
        /// Index of the joint among those with one freedom.
        joint: usize,
    },
    /// The mean of an output from the start of the run to a requested time, by the stages of its steps.
    Mean {
        /// Index in [`Outputs::values`](crate::system::Outputs::values).
        index: usize,
        /// Index of the time among those requested.
        time: usize,
        /// Whether it is the mean of the output's square.
        square: bool,
    },
}

impl RunResult {
    /// Whether it is an instant, known at the end of the step that ends there.
    fn is_latch_time(&self) -> bool {
        match self {
            Self::LatchTime { .. } => true,
            Self::Output { .. } | Self::Impulse { .. } | Self::Mean { .. } => false,
        }
    }
}

/// Derivatives of a run that is on a tape.
pub struct Gradient<'a> {
    system: &'a mut System,
    tape: &'a Tape,
    tableau: &'static Tableau<'static>,
    neighbours: Vec<Neighbours>,
    entries: Vec<Entry>,
    /// Stretch of the inputs over time of the present step.
    piece: Piece,
    derivative: Derivative,
    directions: Directions,
    factors: Factors,
    /// Whether the model allows factors with all terms of the tree.
    has_exact: bool,
    lanes: Side,
    /// The sections on which air acts.
    sections: Option<Sections>,
    scratch: Vec<f64>,
}

/// A parameter: a column of the derivatives.
#[derive(Debug, Clone, Copy)]
struct Entry {
    /// Its machines among the neighbours.
    beside: usize,
    /// Its row of the inputs over time, or `None` for a single number.
    row: Option<usize>,
}

impl<'a> Gradient<'a> {
    /// Prepares the derivatives of a run of `plant` by `parameters`.
    ///
    /// The plant's state is changed; initialise it again before its next run. Errors for parameters that change the mesh or the discrete
    /// state of the start.
    pub fn new(plant: &'a mut Plant, tape: &'a Tape, parameters: Vec<Parameter>) -> Result<Self, GradientError> {
        let tableau = plant
            .tableau()
            .ok_or(GradientError::NotCovered { part: "methods without stages", place: "solver.method".into() })?;
        let system = plant.system_mut();
        let neighbours = parameters
            .into_iter()
            .map(|parameter| Neighbours::new(parameter, system, tape))
            .collect::<Result<Vec<_>, GradientError>>()?;
        let of = |(beside, neighbours): (usize, &Neighbours)| -> Vec<Entry> {
            match &neighbours.rows {
                None => vec![Entry { beside, row: None }],
                Some(rows) => rows.iter().map(|row| Entry { beside, row: Some(*row) }).collect(),
            }
        };
        let entries = neighbours.iter().enumerate().flat_map(of).collect();
        let derivative = Derivative::new(&system.equations.model);
        let piece = tape.steps.first().map_or(Piece::default(), |step| step.piece);
        let directions = Directions::new(&system.equations.model);
        let sections = system.state.air.as_ref().map(|_| Sections::new(&system.equations));
        let scratch = vec![0.0; system.coordinates()];
        let (factors, has_exact) = (Factors::Symmetric, Derivative::has_factors(&system.equations.model));
        let lanes = Side::new(&system.equations.model);
        Ok(Self {
            system,
            tape,
            tableau,
            neighbours,
            entries,
            piece,
            derivative,
            directions,
            factors,
            has_exact,
            lanes,
            sections,
            scratch,
        })
    }

    /// Share of each parameter in a change of its machines at a time of the present step: 1, or that of its row of the inputs over time.
    fn shares(&self, time_s: f64) -> Vec<f64> {
        let share = |entry: &Entry| entry.row.map_or(1.0, |row| self.tape.inputs.weight(row, self.piece, time_s));
        self.entries.iter().map(share).collect()
    }

    /// Slopes with respect to the parameters from those of the perturbed models.
    fn by_parameters(&self, time_s: f64, by_neighbours: &[f64]) -> Vec<f64> {
        let shares = self.shares(time_s);
        self.entries.iter().zip(shares).map(|(entry, share)| share * by_neighbours[entry.beside]).collect()
    }

    /// The step at which a result is known; an error for results without a derivative.
    fn step_of(&self, result: RunResult) -> Result<usize, GradientError> {
        match result {
            RunResult::Output { index, time } => {
                self.check_output(index, time)?;
                Ok(self.tape.marks[time].step)
            }
            RunResult::LatchTime { joint } => self.latch_step(joint),
            RunResult::Impulse { joint } => self.impulse_step(joint),
            RunResult::Mean { index, time, .. } => {
                self.check_mean(index, time)?;
                Ok(self.tape.marks[time].step)
            }
        }
    }

    /// The values of results.
    ///
    /// # Errors
    /// Results that the run does not have, or that have no derivative.
    pub fn values(&mut self, results: &[RunResult]) -> Result<Vec<f64>, GradientError> {
        let value = |result: &RunResult| {
            let step = self.step_of(*result)?;
            match *result {
                RunResult::Output { index, time } => self.output_at(index, time),
                RunResult::LatchTime { .. } => Ok(self.tape.steps[step].end.time_s),
                RunResult::Impulse { joint } => Ok(self.tape.steps[step].joints[joint].latch.impulse_n_m_s),
                RunResult::Mean { .. } => Ok(self.mean_value(*result)),
            }
        };
        results.iter().map(value).collect()
    }

    /// The slopes of a result with respect to the state at its instant and to the parameters.
    fn seed(&mut self, result: RunResult) -> Result<Seed<'a>, GradientError> {
        let step = self.step_of(result)?;
        match result {
            RunResult::Output { index, time } if Account::of(self.system, index).is_some() => {
                Ok(self.no_seed(step, Part::of(&self.tape.marks[time].branch)))
            }
            RunResult::Output { index, time } => self.output_seed(index, time),
            RunResult::LatchTime { .. } => Ok(Seed { by_shift: 1.0, ..self.no_seed(step, Part::Whole) }),
            RunResult::Impulse { joint } => {
                let coordinate = self.system.equations.forces.joints()[joint].coordinate;
                Ok(self.no_seed(step, Part::Jump(coordinate)))
            }
            RunResult::Mean { time, .. } => Ok(self.no_seed(step, Part::of(&self.tape.marks[time].branch))),
        }
    }
}

/// Number of partial sums of a product and of partial maxima: each waits only for the one eight entries before it.
const LANES: usize = 8;

/// Sum of products.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// The largest magnitude among the products of two lists; NaN does not count.
fn largest_product(a: &[f64], b: &[f64]) -> f64 {
    let mut largest = [0.0f64; LANES];
    let (a, b) = (a.chunks(LANES), b.chunks(LANES));
    for (a, b) in a.zip(b) {
        for ((largest, a), b) in largest.iter_mut().zip(a).zip(b) {
            let product = (a * b).abs();
            *largest = if product > *largest { product } else { *largest };
        }
    }
    largest.into_iter().fold(0.0, f64::max)
}

/// `sum += factor · values`.
fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}

#[cfg(test)]
mod tests;
