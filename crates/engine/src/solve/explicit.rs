//! The classical explicit Runge–Kutta method of order 4 with fixed step, as in \[O\] section 4; NOTATION eq. (T8).

use crate::solve::newton::{Effort, NewtonError};
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Powers};

/// Velocities and accelerations of one stage.
type Rates = (Vec<f64>, Vec<f64>);

/// Workspace of an explicit step, allocated once.
#[derive(Debug, Clone)]
pub struct Rk4 {
    q: Vec<f64>,
    v: Vec<f64>,
    stages: [Rates; 4],
    residual: Vec<f64>,
}

/// Abscissae and weights.
const NODES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHTS: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

impl Rk4 {
    /// Workspace for `coordinates` unknowns.
    pub fn new(coordinates: usize) -> Self {
        let zeros = vec![0.0; coordinates];
        Self {
            q: zeros.clone(),
            v: zeros.clone(),
            stages: std::array::from_fn(|_| (zeros.clone(), zeros.clone())),
            residual: zeros,
        }
    }

    /// Solution of the equations of the last stage, in place of an error estimate, which this method lacks.
    pub fn remainder(&self) -> &[f64] {
        &self.residual
    }

    /// Performs one step of `h_s` from `start` to `end`. The accelerations at the end are those of the next step's first stage.
    ///
    /// There is no error estimate: beyond the stability limit the result is not finite, which is reported as an error.
    pub fn step(
        &mut self,
        equations: &mut impl EquationsOfMotion,
        start: &Point,
        h_s: f64,
        end: &mut Point,
        effort: &mut Effort,
    ) -> Result<(), NewtonError> {
        self.stages[0].0.copy_from_slice(&start.v);
        self.stages[0].1.copy_from_slice(&start.a);
        let mut powers = [start.powers; 4];
        for stage in 1..4 {
            let time_s = start.time_s + NODES[stage] * h_s;
            let (before, rest) = self.stages.split_at_mut(stage);
            let (velocity, acceleration) = &before[stage - 1];
            for i in 0..self.q.len() {
                self.q[i] = start.q[i] + NODES[stage] * h_s * velocity[i];
                self.v[i] = start.v[i] + NODES[stage] * h_s * acceleration[i];
            }
            let (velocity, acceleration) = &mut rest[0];
            accelerate(equations, time_s, (&mut self.q, &mut self.v, acceleration), &mut self.residual, effort)?;
            velocity.copy_from_slice(&self.v);
            powers[stage] = equations.powers(time_s, &self.q, &self.v, acceleration);
        }

        let mut sums = Powers::default();
        for (powers, weight) in powers.iter().zip(WEIGHTS) {
            sums.work += weight * powers.work;
            sums.dissipated += weight * powers.dissipated;
        }
        for i in 0..self.q.len() {
            let weighted = |pick: fn(&Rates) -> &Vec<f64>| -> f64 {
                self.stages.iter().zip(WEIGHTS).map(|(stage, weight)| weight * pick(stage)[i]).sum()
            };
            end.q[i] = start.q[i] + h_s * weighted(|stage| &stage.0);
            end.v[i] = start.v[i] + h_s * weighted(|stage| &stage.1);
        }
        end.time_s = start.time_s + h_s;
        end.work = start.work + h_s * sums.work;
        end.dissipated = start.dissipated + h_s * sums.dissipated;
        end.a.fill(0.0);
        equations.project(&mut end.q, &mut end.v, &mut end.a);
        equations.close(&mut end.q, &mut end.v, &mut end.a)?;
        accelerate(equations, end.time_s, (&mut end.q, &mut end.v, &mut end.a), &mut self.residual, effort)?;
        end.auxiliary.copy_from_slice(&end.a);
        end.powers = equations.powers(end.time_s, &end.q, &end.v, &end.a);
        Ok(())
    }
}

/// Computes the accelerations at a state: one residual with zero accelerations, one factorisation of the mass matrix, one solve.
fn accelerate(
    equations: &mut impl EquationsOfMotion,
    time_s: f64,
    (q, v, a): (&mut [f64], &mut [f64], &mut [f64]),
    residual: &mut [f64],
    effort: &mut Effort,
) -> Result<(), NewtonError> {
    a.fill(0.0);
    equations.prescribe(time_s, q, v, a);
    equations.residual(time_s, q, v, a, residual);
    equations.factorize(1.0, 0.0, 0.0)?;
    effort.iterations += 1;
    effort.factorizations += 1;
    if !equations.solve(residual).is_finite() {
        return Err(NewtonError::NotFinite { iteration: 0 });
    }
    a.iter_mut().zip(residual.iter()).for_each(|(a, step)| *a -= step);
    Ok(())
}
