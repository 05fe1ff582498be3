//! Generalised-α of Chung and Hulbert with variable step, NOTATION eqs. (T4)–(T5).

use crate::solve::newton::{Accuracy, Effort, NewtonError, Stage, iterate};
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Powers};

/// Parameters of the method, from its spectral radius at infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
}

impl Parameters {
    /// Parameters for `rho_infinity` in `[0, 1]`: 0 damps the highest modes in one step, 1 not at all.
    pub fn new(rho_infinity: f64) -> Self {
        let alpha_m = (2.0 * rho_infinity - 1.0) / (rho_infinity + 1.0);
        let alpha_f = rho_infinity / (rho_infinity + 1.0);
        let gamma = 0.5 + alpha_f - alpha_m;
        Self { alpha_m, alpha_f, beta: 0.25 * (gamma + 0.5).powi(2), gamma }
    }
}

/// Scratch of a generalised-α step, sized once.
#[derive(Debug, Clone)]
pub struct GeneralizedAlpha {
    residual: Vec<f64>,
}

impl GeneralizedAlpha {
    /// Scratch for `coordinates` unknowns.
    pub fn new(coordinates: usize) -> Self {
        Self { residual: vec![0.0; coordinates] }
    }

    /// Error estimate or last correction of the last step.
    pub fn remainder(&self) -> &[f64] {
        &self.residual
    }

    /// One step of `h_s` from `start`; fills `end` and returns the error estimate in the kinematic norm.
    #[allow(clippy::too_many_arguments)]
    pub fn step(
        &mut self,
        parameters: &Parameters,
        equations: &mut impl EquationsOfMotion,
        start: &Point,
        h_s: f64,
        end: &mut Point,
        accuracy: Accuracy,
        effort: &mut Effort,
    ) -> Result<f64, NewtonError> {
        let Parameters { alpha_m, alpha_f, beta, gamma } = *parameters;
        let share = (1.0 - alpha_f) / (1.0 - alpha_m);
        let auxiliary = |a: f64, start_a: f64, start_auxiliary: f64| {
            share * a + (alpha_f * start_a - alpha_m * start_auxiliary) / (1.0 - alpha_m)
        };
        end.time_s = start.time_s + h_s;
        end.a.copy_from_slice(&start.a);
        for i in 0..start.q.len() {
            let (old, new) = (start.auxiliary[i], auxiliary(end.a[i], start.a[i], start.auxiliary[i]));
            end.q[i] = start.q[i] + h_s * start.v[i] + h_s * h_s * ((0.5 - beta) * old + beta * new);
            end.v[i] = start.v[i] + h_s * ((1.0 - gamma) * old + gamma * new);
        }
        equations.prescribe(end.time_s, &mut end.q, &mut end.v, &mut end.a);
        let mut unknown = Stage {
            time_s: end.time_s,
            q: &mut end.q,
            v: &mut end.v,
            a: &mut end.a,
            residual: &mut self.residual,
            velocity_gain: h_s * gamma * share,
            position_gain: h_s * h_s * beta * share,
        };
        iterate(equations, &mut unknown, accuracy, &mut false, effort)?;

        let estimate = (beta + 0.5 * (alpha_f - alpha_m) - 1.0 / 6.0).abs() * h_s * h_s;
        for i in 0..start.q.len() {
            end.auxiliary[i] = auxiliary(end.a[i], start.a[i], start.auxiliary[i]);
            self.residual[i] = estimate * (end.auxiliary[i] - start.auxiliary[i]);
        }
        end.powers = equations.powers(end.time_s, &end.q, &end.v, &end.a);
        let mean = |from: f64, to: f64| 0.5 * h_s * (from + to);
        let Powers { work, dissipated } = start.powers;
        end.work = start.work + mean(work, end.powers.work);
        end.dissipated = start.dissipated + mean(dissipated, end.powers.dissipated);
        let error = equations.norm(&self.residual);
        equations.project(&mut end.q, &mut end.v, &mut end.a);
        Ok(error)
    }
}
