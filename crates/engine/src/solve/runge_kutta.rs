//! ESDIRK steps for second-order equations, with the accelerations as the unknowns of a stage, NOTATION eqs. (T1)–(T3).

use crate::solve::newton::{Accuracy, Effort, NewtonError, Stage, iterate};
use crate::solve::point::Point;
use crate::solve::tableau::{MAX_STAGES, Tableau};
use crate::solve::{EquationsOfMotion, Powers};

/// Workspace of an ESDIRK step, allocated once.
#[derive(Debug, Clone)]
pub struct Esdirk {
    velocities: Vec<Vec<f64>>,
    accelerations: Vec<Vec<f64>>,
    powers: [Powers; MAX_STAGES],
    q: Vec<f64>,
    v: Vec<f64>,
    residual: Vec<f64>,
}

impl Esdirk {
    /// Workspace for `coordinates` unknowns.
    pub fn new(coordinates: usize) -> Self {
        let zeros = vec![0.0; coordinates];
        Self {
            velocities: vec![zeros.clone(); MAX_STAGES],
            accelerations: vec![zeros.clone(); MAX_STAGES],
            powers: [Powers::default(); MAX_STAGES],
            q: zeros.clone(),
            v: zeros.clone(),
            residual: zeros,
        }
    }

    /// Error estimate or last correction of the last step.
    pub fn remainder(&self) -> &[f64] {
        &self.residual
    }

    /// Performs one step of `h_s` from `start`; fills `end` and the stages in between and returns the error estimate in the kinematic norm.
    #[allow(clippy::too_many_arguments)]
    pub fn step(
        &mut self,
        tableau: &Tableau,
        equations: &mut impl EquationsOfMotion,
        start: &Point,
        h_s: f64,
        (end, inner): (&mut Point, &mut [Point]),
        accuracy: Accuracy,
        effort: &mut Effort,
    ) -> Result<f64, NewtonError> {
        let gain = h_s * tableau.gamma;
        self.velocities[0].copy_from_slice(&start.v);
        self.accelerations[0].copy_from_slice(&start.a);
        self.powers[0] = start.powers;
        let mut factorized = false;
        for stage in 1..tableau.stages() {
            let row = tableau.rows[stage - 1];
            let (before, after) = self.accelerations.split_at_mut(stage);
            let a = &mut after[0];
            let [(first, share), (second, rest)] = match stage {
                _ if !accuracy.jumped => tableau.predictor(stage),
                1 => [(0, 0.0); 2],
                _ => [(stage - 1, 1.0), (stage - 1, 0.0)],
            };
            self.q.copy_from_slice(&start.q);
            self.v.copy_from_slice(&start.v);
            for ((weight, velocities), accelerations) in row.iter().zip(&self.velocities).zip(before.iter()) {
                add(&mut self.q, h_s * weight, velocities);
                add(&mut self.v, h_s * weight, accelerations);
            }
            for ((a, first), second) in a.iter_mut().zip(&before[first]).zip(&before[second]) {
                *a = share * first + rest * second;
            }
            add(&mut self.v, gain, a);
            add(&mut self.q, gain, &self.v);
            let time_s = start.time_s + tableau.abscissa(stage) * h_s;
            equations.prescribe(time_s, &mut self.q, &mut self.v, a);
            let mut unknown = Stage {
                time_s,
                q: &mut self.q,
                v: &mut self.v,
                a,
                residual: &mut self.residual,
                velocity_gain: gain,
                position_gain: gain * gain,
            };
            iterate(equations, &mut unknown, accuracy, &mut factorized, effort)?;
            self.velocities[stage].copy_from_slice(&self.v);
            self.powers[stage] = equations.powers(time_s, &self.q, &self.v, &self.accelerations[stage]);
            if let Some(point) = inner.get_mut(stage - 1) {
                point.time_s = time_s;
                point.q.copy_from_slice(&self.q);
                point.v.copy_from_slice(&self.v);
                point.a.copy_from_slice(&self.accelerations[stage]);
                self.accounts(tableau, stage, start, h_s, point);
            }
        }

        let last = tableau.stages() - 1;
        end.time_s = start.time_s + h_s;
        end.q.copy_from_slice(&self.q);
        end.v.copy_from_slice(&self.v);
        end.a.copy_from_slice(&self.accelerations[last]);
        self.accounts(tableau, last, start, h_s, end);

        self.residual.fill(0.0);
        for (e, velocities) in tableau.error.iter().zip(&self.velocities) {
            add(&mut self.residual, h_s * e, velocities);
        }
        let error = equations.norm(&self.residual);
        equations.project(&mut end.q, &mut end.v, &mut end.a);
        if equations.close(&mut end.q, &mut end.v, &mut end.a)? {
            // the next step starts with the powers of its own start
            end.powers = equations.powers(end.time_s, &end.q, &end.v, &end.a);
        }
        end.auxiliary.copy_from_slice(&end.a);
        Ok(error)
    }

    /// Integrates the energy accounts up to a stage with the quadrature weights of its row.
    fn accounts(&self, tableau: &Tableau, stage: usize, start: &Point, h_s: f64, point: &mut Point) {
        point.powers = self.powers[stage];
        (point.work, point.dissipated) = (start.work, start.dissipated);
        let weights = tableau.rows[stage - 1].iter().chain(std::iter::once(&tableau.gamma));
        for (weight, powers) in weights.zip(&self.powers) {
            point.work += h_s * weight * powers.work;
            point.dissipated += h_s * weight * powers.dissipated;
        }
    }
}

/// `sum += factor · values`.
#[inline]
fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}
