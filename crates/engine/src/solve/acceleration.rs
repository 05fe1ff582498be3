//! Anderson acceleration of a fixed-point iteration: the next guess is the combination of the previous guesses that minimises the
//! combination of their residuals.

use nalgebra::{SMatrix, SVector};

/// Number of differences that are kept.
const DEPTH: usize = 6;
/// Regularisation of the small least-squares problem, relative to its largest entry: directions that differ by less than its square root
/// are treated as equal.
const REGULARIZATION: f64 = 1e-12;

/// History of an iteration `x ← x + residual(x)`.
#[derive(Debug, Clone)]
pub struct Anderson {
    guesses: Vec<Vec<f64>>,
    residuals: Vec<Vec<f64>>,
    last_guess: Vec<f64>,
    last_residual: Vec<f64>,
    count: usize,
}

impl Anderson {
    /// Accelerator for vectors of `size` entries.
    pub fn new(size: usize) -> Self {
        let zeros = vec![0.0; size];
        Self {
            guesses: vec![zeros.clone(); DEPTH],
            residuals: vec![zeros.clone(); DEPTH],
            last_guess: zeros.clone(),
            last_residual: zeros,
            count: 0,
        }
    }

    /// Clears the history for a new iteration.
    pub fn restart(&mut self) {
        self.count = 0;
    }

    /// Replaces `guess`, with the given residual, by the next one; NOTATION eq. (Q3). Allocates nothing.
    pub fn next(&mut self, guess: &mut [f64], residual: &[f64]) {
        if self.count > 0 {
            let slot = (self.count - 1) % DEPTH;
            for i in 0..guess.len() {
                self.guesses[slot][i] = guess[i] - self.last_guess[i];
                self.residuals[slot][i] = residual[i] - self.last_residual[i];
            }
        }
        self.last_guess.copy_from_slice(guess);
        self.last_residual.copy_from_slice(residual);
        let kept = self.count.min(DEPTH);
        self.count += 1;
        guess.iter_mut().zip(residual).for_each(|(guess, residual)| *guess += residual);
        let Some(weights) = self.weights(residual, kept) else { return };
        for (j, weight) in weights.iter().enumerate().take(kept) {
            for (guess, (step, change)) in guess.iter_mut().zip(self.guesses[j].iter().zip(&self.residuals[j])) {
                *guess -= weight * (step + change);
            }
        }
    }

    /// Weights of the kept differences that cancel as much of the residual as possible.
    fn weights(&self, residual: &[f64], kept: usize) -> Option<SVector<f64, DEPTH>> {
        if kept == 0 {
            return None;
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut matrix = SMatrix::<f64, DEPTH, DEPTH>::identity();
        let mut right = SVector::<f64, DEPTH>::zeros();
        // scaled to a unit diagonal: recent differences are smaller by orders of magnitude
        let sizes: [f64; DEPTH] =
            std::array::from_fn(|j| if j < kept { dot(&self.residuals[j], &self.residuals[j]).sqrt() } else { 1.0 });
        if sizes.iter().any(|size| !size.is_normal()) {
            return None;
        }
        for i in 0..kept {
            right[i] = dot(&self.residuals[i], residual) / sizes[i];
            for j in 0..kept {
                matrix[(i, j)] = dot(&self.residuals[i], &self.residuals[j]) / (sizes[i] * sizes[j]);
            }
            matrix[(i, i)] += REGULARIZATION;
        }
        let mut weights = matrix.cholesky()?.solve(&right);
        for (weight, size) in weights.iter_mut().zip(sizes) {
            *weight /= size;
        }
        Some(weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear iteration that diverges without acceleration (factors −3 … 0.9) converges in as many iterations as it has dimensions.
    #[test]
    fn linear_iterations_end_in_their_dimension_where_plain_ones_diverge() {
        let factors = [-3.0, -1.5, 0.3, 0.9];
        let residual = |x: &[f64]| -> Vec<f64> {
            factors.iter().zip(x).enumerate().map(|(i, (f, x))| (f - 1.0) * x + i as f64 + 1.0).collect()
        };
        let mut x = vec![0.0; 4];
        let mut anderson = Anderson::new(4);
        for _ in 0..6 {
            let r = residual(&x);
            anderson.next(&mut x, &r);
        }
        let left = residual(&x).iter().map(|r| r.abs()).fold(0.0, f64::max);
        // limited by the regularisation: 1e-12 in the normal equations
        assert!(left < 1e-8, "{left:e}");
    }
}
