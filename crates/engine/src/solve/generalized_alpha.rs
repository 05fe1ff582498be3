//! Generalised-α of Chung and Hulbert with variable step, NOTATION eqs. (T4)–(T5).

use crate::solve::newton::{Accuracy, Effort, NewtonError, Stage, iterate};
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Powers};

/// Parameters of the method, as functions of its spectral radius at infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
}

impl Parameters {
    /// Parameters for `rho_infinity` in `[0, 1]`: 0 annihilates the highest modes in one step, 1 has no numerical damping.
    pub fn new(rho_infinity: f64) -> Self {
        let alpha_m = (2.0 * rho_infinity - 1.0) / (rho_infinity + 1.0);
        let alpha_f = rho_infinity / (rho_infinity + 1.0);
        let gamma = 0.5 + alpha_f - alpha_m;
        Self { alpha_m, alpha_f, beta: 0.25 * (gamma + 0.5).powi(2), gamma }
    }
}

/// Workspace of a generalised-α step, allocated once.
#[derive(Debug, Clone)]
pub struct GeneralizedAlpha {
    residual: Vec<f64>,
}

impl GeneralizedAlpha {
    /// Workspace for `coordinates` unknowns.
    pub fn new(coordinates: usize) -> Self {
        Self { residual: vec![0.0; coordinates] }
    }

    /// Error estimate or last correction of the last step.
    pub fn remainder(&self) -> &[f64] {
        &self.residual
    }

    /// Performs one step of `h_s` from `start`; fills `end` and returns the error estimate in the kinematic norm.
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
        if equations.close(&mut end.q, &mut end.v, &mut end.a)? {
            // the next step starts with the powers of its own start
            end.powers = equations.powers(end.time_s, &end.q, &end.v, &end.a);
        }
        Ok(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::test_oscillator::Oscillator;

    /// The estimate is no smaller than the displacement error of the step, except for terms of the next order: equal to the error without
    /// numerical damping, and up to 4.5 times as large with it, because the error has `−(α_f − α_m)/2` in place of `+`. The steps start
    /// from the exact motion `q = cos(t + φ)`, with the auxiliary acceleration of the time `α_m − α_f` steps later.
    #[test]
    fn estimate_covers_the_error_of_the_step() {
        for rho_infinity in [0.0, 0.3, 0.5, 0.8, 1.0] {
            let parameters = Parameters::new(rho_infinity);
            let lead = parameters.alpha_m - parameters.alpha_f;
            let ratio = |h_s: f64| {
                // sine and cosine of the phase are nonzero: the leading term does not vanish
                let phase = 0.9_f64;
                let mut start = Point::zeros(1);
                (start.q[0], start.v[0], start.a[0]) = (phase.cos(), -phase.sin(), -phase.cos());
                start.auxiliary[0] = -(phase + lead * h_s).cos();
                let mut end = Point::zeros(1);
                let (accuracy, mut effort) = (Accuracy::within(1e-15), Effort::default());
                let mut equations = Oscillator::new(1.0);
                let estimate = GeneralizedAlpha::new(1)
                    .step(&parameters, &mut equations, &start, h_s, &mut end, accuracy, &mut effort)
                    .unwrap();
                estimate / (end.q[0] - (phase + h_s).cos()).abs()
            };
            let Parameters { alpha_m, alpha_f, beta, .. } = parameters;
            let of = |half_lead: f64| beta + half_lead - 1.0 / 6.0;
            let expected = of(0.5 * (alpha_f - alpha_m)) / of(-0.5 * (alpha_f - alpha_m));
            let times = ratio(0.01);
            // terms of the next order: one per cent, times coefficients of order 1
            assert!((times / expected - 1.0).abs() < 0.05, "ρ = {rho_infinity}: {times:.3} for {expected:.3}");
            assert!((0.95..4.6).contains(&times), "ρ = {rho_infinity}: {times:.3} times the error");
        }
    }
}
