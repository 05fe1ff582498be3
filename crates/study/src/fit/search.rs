//! Levenberg–Marquardt method with bounds.

use crate::fit::{Loss, Problem};
use nalgebra::{DMatrix, DVector};

/// Damping of the first step, relative to the largest squared singular value of the scaled Jacobian.
const FIRST_DAMPING: f64 = 1e-6;
/// Smallest factor by which the damping changes after a step. Numbers with little effect have singular values of 1e-4 of the largest: with
/// a factor of a third, as in Nielsen's rule, the damping would take a dozen steps to become that small.
const FASTEST: f64 = 0.1;
/// Product of the residuals with a free column of the Jacobian, relative to the sum of the magnitudes of its terms, below which they count
/// as orthogonal.
const ORTHOGONAL: f64 = 1e-9;
/// Predicted relative reduction of the cost by an undamped step, below which a rejected step ends the search: 1e-4 of a standard error
/// times the square root of the degrees of freedom.
const DROWNED: f64 = 1e-8;
/// Predicted relative reduction below which an accepted step ends the search: the Jacobian of the result is that before this step.
const SETTLED: f64 = 1e-12;
/// Damping that only keeps dependent columns solvable, relative to the largest squared singular value.
const UNDAMPED: f64 = 1e-12;
/// Step, relative to the scaled numbers, below which the search ends.
const STEP: f64 = 1e-10;

/// Start and limits of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// Start.
    pub first: DVector<f64>,
    /// Lower and upper bound of each number; infinite for none. The start lies within the bounds.
    pub bounds: Vec<[f64; 2]>,
    /// Loss of a residual.
    pub loss: Loss,
    /// Maximum number of points at which residuals are evaluated.
    pub max_runs: usize,
}

/// Reason for the end of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The residuals are orthogonal to the free columns of the Jacobian.
    Orthogonal,
    /// The reduction of the cost is below round-off.
    Reduction,
    /// The step is below round-off.
    Step,
    /// The maximum number of runs is reached.
    Runs,
}

impl Ended {
    /// Whether the search found a minimum.
    pub fn converged(self) -> bool {
        !matches!(self, Self::Runs)
    }
}

impl std::fmt::Display for Ended {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Orthogonal => {
                "the residuals are orthogonal to their derivatives with respect to the numbers within \
                                 their bounds"
            }
            Self::Reduction => "no step reduces the cost by more than 1e-8 of its value",
            Self::Step => "a step changes the numbers by less than 1e-10 of their values",
            Self::Runs => "the maximum number of runs is reached",
        })
    }
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The numbers.
    pub x: DVector<f64>,
    /// Residuals at these numbers.
    pub residuals: DVector<f64>,
    /// Jacobian at these numbers, or before a last step of less than 1e-6 of a standard error times the square root of the degrees of
    /// freedom; rows are weighted by the curvature of the loss, eq. (X14).
    pub jacobian: DMatrix<f64>,
    /// Points at which residuals were evaluated.
    pub runs: usize,
    /// Reason for the end.
    pub ended: Ended,
}

/// Minimises half of the sum of the losses of the residuals within bounds by the method of Levenberg and Marquardt, eq. (X15); `None`
/// if there are no residuals at the start.
///
/// Numbers are scaled by their start values. A number whose step crosses its bound is set to the bound, and the step of the others is
/// computed again.
///
/// # Errors
/// Those of the problem.
pub fn search<P: Problem>(problem: &mut P, search: &Search) -> Result<Option<Found>, P::Error> {
    let Search { first, bounds, loss, max_runs } = search;
    let sizes = first.map(|x| if x == 0.0 { 1.0 } else { x.abs() });
    let mut x = first.clone();
    let Some(mut residuals) = problem.residuals(&x)? else { return Ok(None) };
    let (mut runs, mut cost) = (1, loss.cost(&residuals));
    let (mut damping, mut growth) = (None, 2.0);
    loop {
        let (weighted, jacobian) = loss.weighted(residuals.clone(), problem.jacobian(&x)?);
        let mut scaled = jacobian.clone();
        scaled.column_iter_mut().zip(sizes.iter()).for_each(|(mut column, size)| column.scale_mut(*size));
        let room: Vec<[f64; 2]> = (0..x.len()).map(|i| bounds[i].map(|bound| (bound - x[i]) / sizes[i])).collect();
        let model = Model { jacobian: &scaled, residuals: &weighted, room: &room };
        let mut lambda = *damping.get_or_insert_with(|| FIRST_DAMPING * scaled.norm_squared());
        // the time steps of the run change with the numbers, and the cost with them: a smaller reduction is below this noise
        let promised = model.reduction(&model.step(UNDAMPED * scaled.norm_squared())) / cost;
        let ended = loop {
            if model.is_orthogonal() {
                break Some(Ended::Orthogonal);
            }
            let step = model.step(lambda);
            let small = step.norm() <= STEP * (STEP + x.component_div(&sizes).norm());
            if small {
                break Some(Ended::Step);
            }
            if runs >= *max_runs {
                break Some(Ended::Runs);
            }
            let predicted = model.reduction(&step);
            let trial = DVector::from_fn(x.len(), |i, _| (x[i] + step[i] * sizes[i]).clamp(bounds[i][0], bounds[i][1]));
            runs += 1;
            let found = problem.residuals(&trial)?.filter(|found| found.iter().all(|r| r.is_finite()));
            let reduced = found.as_ref().map(|found| cost - loss.cost(found)).filter(|reduced| *reduced > 0.0);
            let (Some(found), Some(reduced)) = (found, reduced) else {
                if promised <= DROWNED {
                    break Some(Ended::Reduction);
                }
                lambda *= growth;
                growth *= 2.0;
                continue;
            };
            let ratio = reduced / predicted;
            // Nielsen's rule: continuous in the ratio
            lambda *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(FASTEST);
            growth = 2.0;
            (x, residuals, cost) = (trial, found, cost - reduced);
            break (promised <= SETTLED).then_some(Ended::Reduction);
        };
        damping = Some(lambda);
        if let Some(ended) = ended {
            return Ok(Some(Found { x, residuals, jacobian, runs, ended }));
        }
    }
}

/// The linear problem at a point, in scaled numbers.
struct Model<'a> {
    jacobian: &'a DMatrix<f64>,
    residuals: &'a DVector<f64>,
    /// Distances to the bounds.
    room: &'a [[f64; 2]],
}

impl Model<'_> {
    /// Whether no free number can reduce the residuals: their product with each column vanishes, or the number is at the bound towards
    /// which they decrease.
    fn is_orthogonal(&self) -> bool {
        self.jacobian.column_iter().zip(self.room).all(|(column, [below, above])| {
            let slope = column.dot(self.residuals);
            let blocked = slope > 0.0 && *below >= 0.0 || slope < 0.0 && *above <= 0.0;
            // relative to the sum of the magnitudes: a robust loss gives residuals without curvature, whose norm has no bound
            let size: f64 = column.iter().zip(self.residuals).map(|(entry, r)| (entry * r).abs()).sum();
            blocked || slope.abs() <= ORTHOGONAL * size
        })
    }

    /// Step with a damping, eq. (X15).
    fn step(&self, lambda: f64) -> DVector<f64> {
        let count = self.room.len();
        let (mut step, mut free) = (DVector::zeros(count), vec![true; count]);
        loop {
            let columns: Vec<usize> = (0..count).filter(|i| free[*i]).collect();
            if columns.is_empty() {
                return step;
            }
            // least squares of the rows of the Jacobian and the damping rows below them, which does not square the condition number
            let rows = self.residuals.len();
            let fixed = DVector::from_fn(count, |i, _| if free[i] { 0.0 } else { step[i] });
            let left = self.residuals + self.jacobian * fixed;
            let matrix = DMatrix::from_fn(rows + columns.len(), columns.len(), |i, j| match i.checked_sub(rows) {
                None => self.jacobian[(i, columns[j])],
                Some(k) if k == j => lambda.sqrt(),
                Some(_) => 0.0,
            });
            let right = DVector::from_fn(rows + columns.len(), |i, _| if i < rows { -left[i] } else { 0.0 });
            let parts = matrix.qr();
            let solved = parts.r().solve_upper_triangular(&(parts.q().transpose() * right));
            // fails only without damping, for columns of zeros
            let Some(solved) = solved.filter(|solved| solved.iter().all(|s| s.is_finite())) else {
                return DVector::zeros(count);
            };
            let mut inside = true;
            for (column, value) in columns.iter().zip(solved.iter()) {
                let [below, above] = self.room[*column];
                step[*column] = value.clamp(below.min(0.0), above.max(0.0));
                if step[*column] != *value {
                    free[*column] = false;
                    inside = false;
                }
            }
            if inside {
                return step;
            }
        }
    }

    /// Reduction of half the sum of squares along a step.
    fn reduction(&self, step: &DVector<f64>) -> f64 {
        let change = self.jacobian * step;
        -(change.dot(self.residuals) + 0.5 * change.norm_squared())
    }
}
