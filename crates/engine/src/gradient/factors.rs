//! Factors of the matrix of a stage: those of Newton's method or with all terms, and the workspace of equations that are solved side by side.

use crate::multibody::Model;
use crate::multibody::derivative::{Derivative, Lanes, Sweep};
use crate::solve::EquationsOfMotion;
use crate::system::equations::Equations;

/// Kind of the factors in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Factors {
    /// Those of Newton's method, without gyroscopic and geometric terms.
    Symmetric,
    /// Those with all terms of the tree.
    Exact,
}

impl Factors {
    /// Multiplies by the inverse of the factors' matrix.
    pub fn solve(self, equations: &mut Equations, derivative: &mut Derivative, values: &mut [f64]) {
        match self {
            Self::Symmetric => {
                equations.solve(values);
            }
            Self::Exact => derivative.solve(&equations.model, values),
        }
    }

    /// Multiplies by the transposed inverse.
    pub fn solve_transposed(self, equations: &mut Equations, derivative: &mut Derivative, values: &mut [f64]) {
        match self {
            Self::Symmetric => equations.solve_transposed(derivative, values),
            Self::Exact => derivative.solve_transposed(&equations.model, values),
        }
    }
}

/// Number of variations whose equations are solved side by side.
pub(super) const LANES: usize = 4;

/// Workspace of equations that are solved side by side.
pub(super) struct Side {
    pub along: [Vec<[f64; LANES]>; 3],
    pub left: Vec<[f64; LANES]>,
    pub product: Lanes<LANES>,
    pub sweep: Sweep<LANES>,
}

impl Side {
    pub fn new(model: &Model) -> Self {
        let rows = || vec![[0.0; LANES]; model.coordinates];
        Self { along: [rows(), rows(), rows()], left: rows(), product: Lanes::new(model), sweep: Sweep::new(model) }
    }
}
