//! Modified Newton iteration for the accelerations of one stage, with one factorisation per step.

use crate::solve::{EquationsOfMotion, Open, Singular};

/// Reason why a stage failed. A shorter step may help in each case.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NewtonError {
    /// The iteration converges too slowly or diverges.
    #[error("the correction {correction:.1e} after {iterations} iterations exceeds {tolerance:.1e}")]
    NotConverged {
        /// Number of iterations.
        iterations: usize,
        /// Kinematic norm of the last correction.
        correction: f64,
        /// Tolerance of the remaining error.
        tolerance: f64,
    },
    /// The matrix cannot be factorised at this iterate.
    #[error(transparent)]
    Singular(#[from] Singular),
    /// The loops cannot be closed at the end of the step.
    #[error(transparent)]
    Open(#[from] Open),
    /// The residual is NaN or infinite.
    #[error("the residual is not finite in iteration {iteration}")]
    NotFinite {
        /// Number of the iteration.
        iteration: usize,
    },
}

/// Required accuracy and allowed effort of a stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Allowed remaining error of the displacement, in the kinematic norm.
    pub tolerance: f64,
    /// Maximum number of iterations of a stage in real-time mode, after which the result is accepted and counted. `None`: a stage that does
    /// not converge is an error.
    pub most_iterations: Option<usize>,
    /// Whether the step size is prescribed: a stage may then take more iterations, with new factors if they contract slowly, before the
    /// step fails.
    pub persistent: bool,
    /// Whether the accelerations at the step's start have jumped by too much for a predictor over the whole step, NOTATION eq. (T10).
    pub jumped: bool,
    /// Whether to use the slower of the last two contractions, and none faster than `CAUTIOUS_RATE`: if the first correction removes a
    /// large transient of stiff coordinates, the ratio of the next one to it does not predict the slow remainder.
    pub cautious: bool,
}

impl Accuracy {
    /// Accuracy that requires stages to converge to `tolerance`.
    pub const fn within(tolerance: f64) -> Self {
        Self { tolerance, most_iterations: None, persistent: false, jumped: false, cautious: false }
    }
}

/// Counters of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effort {
    /// Number of residuals, each with a solve.
    pub iterations: u64,
    /// Number of factorisations.
    pub factorizations: u64,
    /// Number of stages accepted without convergence.
    pub unconverged: u64,
    /// Maximum number of iterations of one stage.
    pub largest: u64,
    /// Largest last correction of the stages accepted without convergence, in the kinematic norm.
    pub rest: f64,
}

/// State of one stage during the iteration.
pub struct Stage<'a> {
    /// Time of the stage in s.
    pub time_s: f64,
    /// Coordinates.
    pub q: &'a mut [f64],
    /// Rates.
    pub v: &'a mut [f64],
    /// Accelerations: the unknowns.
    pub a: &'a mut [f64],
    /// Workspace for the residual.
    pub residual: &'a mut [f64],
    /// Derivative `∂v/∂a` in s.
    pub velocity_gain: f64,
    /// Derivative `∂q/∂a` in s².
    pub position_gain: f64,
}

/// Maximum number of iterations with one factorisation before the step fails.
const MAX_ITERATIONS: usize = 10;
/// Fastest contraction assumed by a cautious estimate: a factor of 0.01 per iteration is usual.
const CAUTIOUS_RATE: f64 = 0.01;
/// Maximum number of iterations of a stage in a step of prescribed size: at a contraction of one half, the slowest without new factors,
/// they reduce the first correction by a factor of 1e-9.
const MAX_ITERATIONS_PERSISTENT: usize = 30;
/// Number of piece changes of forces with kinks in one stage above which only the first force may change at a time, which excludes cycles.
const FREE_MOVES: usize = 6;
/// Maximum number of piece changes of forces with kinks in one stage; each change allows one more iteration.
const MAX_MOVES: usize = 40;

/// Iterates until the estimated error of the displacement, in the kinematic norm, falls below `tolerance`.
///
/// `factorized` tracks whether the factors of this step exist; they are computed at the first iterate, and once more if the contraction is
/// slower than a half, or every time in that case with [`Accuracy::persistent`]. With [`Accuracy::most_iterations`] the effort is bounded,
/// and only singular matrices and values that are not finite are errors.
///
/// Forces with kinks use one smooth piece per iteration, with its tangent, and change to the piece of the iterate, NOTATION eq. (T12);
/// convergence requires that the pieces do not change.
pub fn iterate(
    equations: &mut impl EquationsOfMotion,
    stage: &mut Stage,
    accuracy: Accuracy,
    factorized: &mut bool,
    effort: &mut Effort,
) -> Result<(), NewtonError> {
    let Accuracy { tolerance, most_iterations, persistent, cautious, .. } = accuracy;
    let most = most_iterations.unwrap_or(if persistent { MAX_ITERATIONS_PERSISTENT } else { MAX_ITERATIONS });
    let (mut previous, mut slower, mut refreshed) = (f64::INFINITY, 0.0_f64, false);
    let (mut moves, mut settled) = (0, false);
    let mut iteration = 0;
    // no additional iterations if the effort is bounded
    while iteration < most + if most_iterations.is_some() { 0 } else { moves } {
        equations.residual(stage.time_s, stage.q, stage.v, stage.a, stage.residual);
        iteration += 1;
        effort.iterations += 1;
        effort.largest = effort.largest.max(iteration as u64);
        if !*factorized {
            equations.factorize(1.0, stage.velocity_gain, stage.position_gain)?;
            effort.factorizations += 1;
            *factorized = true;
            refreshed = true;
        }
        let correction = equations.solve(stage.residual) * stage.position_gain;
        if !correction.is_finite() {
            return Err(NewtonError::NotFinite { iteration: iteration - 1 });
        }
        let unknowns = stage.a.iter_mut().zip(&mut *stage.v).zip(&mut *stage.q);
        for (((a, v), q), step) in unknowns.zip(&*stage.residual) {
            *a -= step;
            *v -= stage.velocity_gain * step;
            *q -= stage.position_gain * step;
        }
        let moved = moves < MAX_MOVES && equations.move_pieces(stage.time_s, stage.q, stage.v, moves >= FREE_MOVES);
        let rate = correction / previous;
        let left = if previous.is_infinite() {
            // no rate is known yet: a contraction by a factor of 0.01 is usual at these steps
            correction * if correction < tolerance { 0.5 } else { f64::INFINITY }
        } else {
            let counted = if cautious { rate.max(slower).max(CAUTIOUS_RATE) } else { rate };
            correction * counted / (1.0 - counted).max(0.0)
        };
        // if the effect of the last change of piece was below the tolerance, that of changing back is too
        if left <= tolerance && (!moved || settled) {
            *factorized &= !moved;
            return Ok(());
        }
        settled = correction <= tolerance;
        if moved {
            moves += 1;
            (*factorized, refreshed) = (false, false);
            (previous, slower) = (f64::INFINITY, 0.0);
            continue;
        }
        if previous.is_finite() && rate > 0.5 {
            if refreshed && rate > 1.0 && most_iterations.is_none() {
                return Err(NewtonError::NotConverged { iterations: iteration, correction, tolerance });
            }
            // if no shorter step will be tried, factorise at every iterate instead
            *factorized = refreshed && most_iterations.is_none() && !persistent;
        }
        (previous, slower) = (correction, if previous.is_finite() { rate } else { 0.0 });
    }
    if most_iterations.is_some() {
        effort.unconverged += 1;
        effort.rest = effort.rest.max(previous);
        return Ok(());
    }
    Err(NewtonError::NotConverged { iterations: iteration, correction: previous, tolerance })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::Powers;

    /// `q̈ = 1` with a force that changes to another piece at every iterate.
    struct Restless;

    impl EquationsOfMotion for Restless {
        fn coordinates(&self) -> usize {
            1
        }
        fn prescribe(&self, _: f64, _: &mut [f64], _: &mut [f64], _: &mut [f64]) {}
        fn project(&self, _: &mut [f64], _: &mut [f64], _: &mut [f64]) {}
        fn residual(&mut self, _: f64, _: &[f64], _: &[f64], a: &[f64], residual: &mut [f64]) {
            residual[0] = a[0] - 1.0;
        }
        fn move_pieces(&mut self, _: f64, _: &[f64], _: &[f64], _: bool) -> bool {
            true
        }
        fn factorize(&mut self, _: f64, _: f64, _: f64) -> Result<(), Singular> {
            Ok(())
        }
        fn solve(&mut self, x: &mut [f64]) -> f64 {
            x[0].abs()
        }
        fn norm(&mut self, change: &[f64]) -> f64 {
            change[0].abs()
        }
        fn powers(&mut self, _: f64, _: &[f64], _: &[f64], _: &[f64]) -> Powers {
            Powers::default()
        }
    }

    /// A stage that ends just after a force changed to another piece leaves no factors for the next stage, because they belong to the
    /// previous piece.
    #[test]
    fn factors_of_an_old_piece_are_not_kept() {
        let [mut q, mut v, mut a, mut residual] = [[0.0]; 4];
        let mut stage = Stage {
            time_s: 0.0,
            q: &mut q,
            v: &mut v,
            a: &mut a,
            residual: &mut residual,
            velocity_gain: 1.0,
            position_gain: 1.0,
        };
        let (mut factorized, mut effort) = (false, Effort::default());
        iterate(&mut Restless, &mut stage, Accuracy::within(1e-9), &mut factorized, &mut effort).unwrap();
        assert_eq!(a, [1.0]);
        assert!(!factorized, "{effort:?}");
        assert_eq!(effort.factorizations, effort.iterations, "each iterate has factors of its own piece");
    }
}
