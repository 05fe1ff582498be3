//! Derivatives of whole runs by parameters, through latches and end stops, also with strip theory and rotors, NOTATION eqs. (X6)–(X13),
//! (X17)–(X23), (X37), (X39).
//!
//! [`Plant::run_on_tape`] keeps the steps of a run on a [`Tape`]. [`Gradient`] differentiates the discrete run along it, whose step lengths
//! stay as they are except two kinds: a step that ends at a crossing moves with the crossing, and steps to given times, those of rows of the
//! inputs and the separate ones to requested times, end there. [`Gradient::forward`] carries one variation per parameter;
//! [`Gradient::adjoint`] carries the multipliers of one result back, at a cost that hardly depends on the number of parameters. Both are
//! exact for that discrete run and agree to round-off.

mod account;
mod adjoint;
mod air;
mod along;
mod block;
mod difference;
mod directions;
mod ends;
mod error;
mod factors;
mod forward;
mod impulse;
mod inputs;
mod integrand;
mod jump;
mod mean;
mod outputs;
mod parameter;
mod prescribed;
mod projection;
mod redundant;
mod replay;
mod result;
mod rotor;
mod run;
mod sections;
mod slopes;
mod step;
mod sums;
mod tape;
mod timer;
mod values;
mod variation;
mod vectors;

pub use along::RunPieces;
pub use error::GradientError;
pub use inputs::{InputColumn, InputRows};
pub use parameter::Parameter;
pub use result::RunResult;
pub use tape::Tape;

use crate::multibody::derivative::Derivative;
use crate::run::Plant;
use crate::solve::tableau::Tableau;
use crate::system::System;
use directions::Directions;
use factors::{Factors, Side};
use inputs::Piece;
use parameter::Neighbours;
use sections::Sections;
use tape::Step;
use vectors::{add, add_all, dot, largest_products, scale};

/// Derivatives of a run that is on a tape.
pub struct Gradient<'a> {
    system: &'a mut System,
    tape: &'a Tape,
    /// The steps over which variations and multipliers march: those of the run, or of a trial march.
    steps: &'a [Step],
    /// The step before them.
    step_before: Option<&'a Step>,
    tableau: &'static Tableau<'static>,
    neighbours: Vec<Neighbours>,
    entries: Vec<Entry>,
    /// Stretch of the inputs over time of the present step.
    piece: Piece,
    /// Middle of the present step in s.
    middle_s: f64,
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
        let tableau = plant.tableau().ok_or(GradientError::NotCovered {
            part: "the methods generalized_alpha and rk4",
            place: "solver.method".into(),
        })?;
        let system = plant.system_mut();
        if let Some(first) = tape.steps.first() {
            parameter::adopt(system, first, &tape.inputs);
        }
        let begun = tape.steps.first().map(|first| system.start_pieces(&first.start)).unwrap_or_default();
        let neighbours = parameters
            .into_iter()
            .flat_map(|parameter| parameter.apart(system, tape))
            .map(|parameter| Neighbours::new(parameter, (system, &begun), tape))
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
        let with_rates = system.air_uses_rates();
        let sections = system.state.air.as_ref().map(|_| Sections::new(&system.equations, with_rates));
        let scratch = vec![0.0; system.coordinates()];
        let (factors, has_exact) = (Factors::Symmetric, Derivative::has_factors(&system.equations.model));
        let lanes = Side::new(&system.equations.model);
        Ok(Self {
            system,
            tape,
            steps: &tape.steps,
            step_before: None,
            tableau,
            neighbours,
            entries,
            piece,
            middle_s: 0.0,
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
}

#[cfg(test)]
mod tests;
