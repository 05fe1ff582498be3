//! Fastest motion: the largest eigenvalue of the equations, which limits the step of explicit integrators.

use crate::system::{PlantError, System};

/// Number of products with the Jacobian matrix, in pairs. Modes in which neighbouring elements move in opposition have close eigenvalues:
/// the estimate converges to the largest from below, and is within a few per cent long before convergence.
const PAIRS: usize = 60;
/// Number of final pairs over which the growth is averaged.
const AVERAGED: usize = 10;
/// Step of the finite differences: of strains and angles, and of their rates in 1/s; forces are nearly linear over both.
const STEP: f64 = 1e-7;
const STEP_RATE_1_S: f64 = 1e-3;

/// Damping ratio above which the magnitude is not that of the power iteration.
const DAMPED: f64 = 0.01;

/// Largest eigenvalue of the linearised equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FastestMotion {
    /// Its magnitude in rad/s; 0 for a model without restoring forces. For a motion without oscillation it is the damping rate.
    pub magnitude_rad_s: f64,
    /// The rate at which this motion decays, in 1/s: its negative real part, at most the magnitude, and 0 for a motion that does not decay.
    pub damping_rate_1_s: f64,
}

impl System {
    /// Largest eigenvalue of the equations linearised at the states set by [`System::begin_exchange`], by power iteration with finite
    /// differences of the derivatives, in O(n) each. For beams this is the shortest axial or torsional wave of the mesh. The magnitude is
    /// accurate to about 5 % from below. The damping rate is that of an oscillator with the damping and the stiffness which the shape of
    /// this motion has, a mean if several motions are equally fast.
    ///
    /// # Errors
    /// If the accelerations cannot be computed.
    pub fn fastest_motion(&mut self) -> Result<FastestMotion, PlantError> {
        let kept = self.exchange_states().to_vec();
        self.update_exchange()?;
        let found = self.largest_eigenvalue(&kept);
        self.set_exchange_states(&kept);
        found
    }

    fn largest_eigenvalue(&mut self, kept: &[f64]) -> Result<FastestMotion, PlantError> {
        let n = self.moving.len();
        let base = self.exchange_derivatives().to_vec();
        // not periodic, so that it has a component in every mode
        let mut v: Vec<f64> = (0..2 * n).map(|i| ((i * i) as f64 * 0.7 + i as f64).sin()).collect();
        let mut growth = Vec::new();
        for _ in 0..PAIRS {
            let before = norm(&v[n..]);
            if before == 0.0 {
                break;
            }
            v.iter_mut().for_each(|entry| *entry /= before);
            for _ in 0..2 {
                v = self.by_jacobian(&v, kept, &base)?;
            }
            growth.push(norm(&v[n..]));
        }
        let last = &growth[growth.len().saturating_sub(AVERAGED)..];
        // estimate of the squared eigenvalue from each pair
        let mean = last.iter().map(|growth| growth.ln()).sum::<f64>() / (2 * last.len().max(1)) as f64;
        let magnitude_rad_s = mean.exp();
        if last.is_empty() || !magnitude_rad_s.is_finite() {
            return Ok(FastestMotion { magnitude_rad_s: 0.0, damping_rate_1_s: 0.0 });
        }
        // the oscillator λ² + c λ + k = 0 of the shape, from accelerations by its rates alone, and by its coordinates alone
        let [damping_1_s, stiffness_1_s2] = [n..2 * n, 0..n].map(|part| {
            let shape = v[part.clone()].to_vec();
            let mut alone = vec![0.0; 2 * n];
            alone[part].copy_from_slice(&shape);
            self.by_jacobian(&alone, kept, &base).map(|slopes| -product(&shape, &slopes[n..]) / product(&shape, &shape))
        });
        let (half, stiffness_1_s2) = (0.5 * damping_1_s?, stiffness_1_s2?);
        let rate_1_s = half + (half * half - stiffness_1_s2).max(0.0).sqrt();
        if !(rate_1_s.is_finite() && rate_1_s > DAMPED * magnitude_rad_s) {
            return Ok(FastestMotion { magnitude_rad_s, damping_rate_1_s: rate_1_s.max(0.0) });
        }
        // the growth from pair to pair of a damped oscillation varies with its phase: its magnitude is that of the oscillator
        let magnitude_rad_s = rate_1_s.max(stiffness_1_s2.max(0.0).sqrt());
        Ok(FastestMotion { magnitude_rad_s, damping_rate_1_s: rate_1_s })
    }

    /// Product of the Jacobian matrix of coordinates and rates with `v`.
    fn by_jacobian(&mut self, v: &[f64], about: &[f64], base: &[f64]) -> Result<Vec<f64>, PlantError> {
        let n = self.moving.len();
        let largest = |part: &[f64]| part.iter().fold(f64::MIN_POSITIVE, |max, entry| max.max(entry.abs()));
        let step = (STEP / largest(&v[..n])).min(STEP_RATE_1_S / largest(&v[n..]));
        let mut shifted = about.to_vec();
        shifted.iter_mut().zip(v).for_each(|(state, entry)| *state += step * entry);
        self.set_exchange_states(&shifted);
        self.update_exchange()?;
        Ok(self
            .exchange_derivatives()
            .iter()
            .zip(base)
            .take(2 * n)
            .map(|(there, base)| (there - base) / step)
            .collect())
    }
}

fn norm(values: &[f64]) -> f64 {
    product(values, values).sqrt()
}

fn product(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}
