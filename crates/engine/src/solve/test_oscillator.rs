//! The oscillator for unit tests of integrators.

use crate::solve::{EquationsOfMotion, Powers, Singular};

/// Harmonic oscillator `q̈ + ω² q = 0`.
pub(super) struct Oscillator {
    pub omega_1_s: f64,
    factor: f64,
}

impl Oscillator {
    pub fn new(omega_1_s: f64) -> Self {
        Self { omega_1_s, factor: 1.0 }
    }
}

impl EquationsOfMotion for Oscillator {
    fn coordinates(&self) -> usize {
        1
    }
    fn prescribe(&self, _: f64, _: &mut [f64], _: &mut [f64], _: &mut [f64]) {}
    fn project(&self, _: &mut [f64], _: &mut [f64], _: &mut [f64]) {}
    fn residual(&mut self, _: f64, q: &[f64], _: &[f64], a: &[f64], residual: &mut [f64]) {
        residual[0] = a[0] + self.omega_1_s.powi(2) * q[0];
    }
    fn factorize(&mut self, mass: f64, _: f64, stiffness: f64) -> Result<(), Singular> {
        self.factor = mass + stiffness * self.omega_1_s.powi(2);
        Ok(())
    }
    fn solve(&mut self, x: &mut [f64]) -> f64 {
        x[0] /= self.factor;
        x[0].abs()
    }
    fn norm(&mut self, change: &[f64]) -> f64 {
        change[0].abs()
    }
    fn powers(&mut self, _: f64, _: &[f64], _: &[f64], _: &[f64]) -> Powers {
        Powers::default()
    }
}
