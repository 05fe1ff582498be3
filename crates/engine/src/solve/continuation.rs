//! States between the ends of a step: combinations of the states of its stages, NOTATION eq. (T6).

use crate::solve::Powers;
use crate::solve::point::{Point, Quintic};
use crate::solve::tableau::{MAX_STAGES, Tableau};
use nalgebra::DMatrix;

/// Number of powers of the position within a step in the polynomial weights.
const POWERS: usize = 5;

/// Weights of a method's stages as polynomials of the position `s` within the step, 0 to 1.
///
/// Every stage satisfies the equations of motion, and so do combinations of stages if the equations are linear over the step, for any
/// frequency: no mode is larger than at the step's start. Methods without stages have no weights.
#[derive(Debug, Clone, Default)]
pub struct Continuation(Vec<[f64; POWERS]>);

impl Continuation {
    /// Weights `w(s)` of the method's order, at most three: `Σ wᵢ = 1`, `Σ wᵢ cᵢ = s`, … with one condition per stage.
    pub fn of(tableau: &Tableau) -> Self {
        let stages = tableau.stages();
        let abscissae: Vec<f64> = (0..stages).map(|stage| tableau.abscissa(stage)).collect();
        let power = |n: i32| -> Vec<f64> { abscissae.iter().map(|c| c.powi(n)).collect() };
        let integral = |n: i32| -> Vec<f64> {
            let values = power(n);
            let sum = |row: &[f64], stage: usize| {
                row.iter().zip(&values).map(|(a, value)| a * value).sum::<f64>() + tableau.gamma * values[stage]
            };
            (0..stages).map(|stage| if stage == 0 { 0.0 } else { sum(tableau.rows[stage - 1], stage) }).collect()
        };
        // (values at the stages, then factor and power of `s` of the required sum)
        let mut conditions = vec![(power(0), 1.0, 0), (power(1), 1.0, 1), (integral(1), 0.5, 2)];
        if stages > 3 {
            conditions.push((integral(2), 1.0 / 3.0, 3));
        }
        if stages > 4 {
            conditions.extend([(power(3), 1.0, 3), (integral(3), 0.25, 4)]);
        }
        let matrix = DMatrix::from_fn(stages, stages, |row, column| conditions[row].0[column]);
        let Some(inverse) = matrix.try_inverse() else { return Self::default() };
        let weights = (0..stages).map(|stage| {
            let mut polynomial = [0.0; POWERS];
            for (i, (_, factor, power)) in conditions.iter().enumerate() {
                polynomial[*power] += inverse[(stage, i)] * factor;
            }
            polynomial
        });
        Self(weights.collect())
    }

    /// Number of stages strictly between the ends that must be stored with a step.
    pub fn inner_stages(&self) -> usize {
        self.0.len().saturating_sub(2)
    }

    fn weights_at(&self, s: f64) -> [f64; MAX_STAGES] {
        let mut weights = [0.0; MAX_STAGES];
        for (weight, polynomial) in weights.iter_mut().zip(&self.0) {
            *weight = polynomial.iter().rev().fold(0.0, |value, c| value * s + c);
        }
        weights
    }
}

/// A completed step: its ends and the stages in between.
#[derive(Debug, Clone, Copy)]
pub struct Taken<'a> {
    /// Point at the start.
    pub start: &'a Point,
    /// Stages between the ends, [`Continuation::inner_stages`] of them; without auxiliary accelerations.
    pub stages: &'a [Point],
    /// Point at the end.
    pub end: &'a Point,
    /// Weights of the stages.
    pub continuation: &'a Continuation,
}

impl Taken<'_> {
    /// Fills `now` with the state at `time_s`, NOTATION eq. (T6); bit-identical to the ends there. Returns whether `time_s` lies between
    /// the ends.
    pub fn fill(&self, now: &mut Point, time_s: f64) -> bool {
        let Self { start, end, continuation, .. } = *self;
        let h_s = end.time_s - start.time_s;
        let between = time_s < end.time_s && time_s > start.time_s;
        if !between {
            now.copy_from(if time_s >= end.time_s || h_s <= 0.0 { end } else { start });
        } else if continuation.0.is_empty() {
            now.interpolate(start, end, time_s);
        } else {
            self.combine(now, &continuation.weights_at((time_s - start.time_s) / h_s));
        }
        now.time_s = time_s;
        between
    }

    fn combine(&self, now: &mut Point, weights: &[f64; MAX_STAGES]) {
        let Point { q, v, a, auxiliary, work, dissipated, powers, .. } = now;
        // by differences, so that constant coordinates are bit-identical
        q.copy_from_slice(&self.start.q);
        v.fill(0.0);
        a.fill(0.0);
        (*work, *dissipated, *powers) = (0.0, 0.0, Powers::default());
        for (point, weight) in self.points().zip(weights) {
            for ((q, stage), start) in q.iter_mut().zip(&point.q).zip(&self.start.q) {
                *q += weight * (stage - start);
            }
            add(v, *weight, &point.v);
            add(a, *weight, &point.a);
            *work += weight * point.work;
            *dissipated += weight * point.dissipated;
            powers.work += weight * point.powers.work;
            powers.dissipated += weight * point.powers.dissipated;
        }
        auxiliary.copy_from_slice(a);
    }

    fn points(&self) -> impl Iterator<Item = &Point> {
        std::iter::once(self.start).chain(self.stages).chain(std::iter::once(self.end))
    }

    /// One coordinate at `start + fraction·h`, by the combination of [`Self::fill`].
    pub fn coordinate(&self, fraction: f64, index: usize) -> f64 {
        if self.continuation.0.is_empty() {
            return Quintic::coordinate_between(self.start, self.end, fraction, index);
        }
        let weights = self.continuation.weights_at(fraction);
        let begin = self.start.q[index];
        begin + self.points().zip(weights).map(|(point, weight)| weight * (point.q[index] - begin)).sum::<f64>()
    }

    /// The rate of one coordinate at `start + fraction·h`, by the combination of [`Self::fill`].
    pub fn rate(&self, fraction: f64, index: usize) -> f64 {
        if self.continuation.0.is_empty() {
            return Quintic::rate_between(self.start, self.end, fraction, index);
        }
        let weights = self.continuation.weights_at(fraction);
        self.points().zip(weights).map(|(point, weight)| weight * point.v[index]).sum()
    }
}

/// `sum += factor · values`.
#[inline]
fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::newton::{Accuracy, Effort};
    use crate::solve::stepper::{Method, Stepper};
    use crate::solve::test_oscillator::Oscillator;

    /// Largest error of the motion, largest magnitude and largest residual divided by `ω²` within one step of unit length from `q = 1`, `q̇
    /// = 0`.
    fn one_step(method: Method, omega_1_s: f64) -> [f64; 3] {
        let mut stepper = Stepper::new(method, 1);
        let mut start = Point::zeros(1);
        (start.q[0], start.a[0]) = (1.0, -omega_1_s.powi(2));
        let mut end = Point::zeros(1);
        let continuation = method.continuation();
        let mut stages = vec![Point::zeros(1); continuation.inner_stages()];
        let mut equations = Oscillator::new(omega_1_s);
        let (accuracy, mut effort) = (Accuracy::within(1e-14), Effort::default());
        stepper.step(&mut equations, &start, 1.0, (&mut end, &mut stages), accuracy, &mut effort).unwrap();
        let taken = Taken { start: &start, stages: &stages, end: &end, continuation: &continuation };
        let mut now = Point::zeros(1);
        let mut largest = [0f64; 3];
        for i in 0..=100 {
            let s = f64::from(i) / 100.0;
            taken.fill(&mut now, s);
            let departure = (now.q[0] - (omega_1_s * s).cos()).abs();
            let residual = (now.a[0] / omega_1_s.powi(2) + now.q[0]).abs();
            assert!((taken.coordinate(s, 0) - now.q[0]).abs() < 1e-13);
            for (largest, value) in largest.iter_mut().zip([departure, now.q[0].abs(), residual]) {
                *largest = largest.max(value);
            }
        }
        largest
    }

    /// Within a step a mode never exceeds its amplitude, however high its frequency, and the equations hold to round-off. The quintic
    /// Hermite polynomial through the ends reaches 173 at ωh = 100 and 17 000 at ωh = 1000.
    #[test]
    fn no_mode_swings_between_the_ends_of_a_step() {
        for method in [Method::Esdirk4, Method::Esdirk3, Method::TrBdf2, Method::Sdirk2] {
            for omega in [0.3, 1.0, 5.0, 10.0, 30.0, 100.0, 1e3, 1e5] {
                let [_, largest, residual] = one_step(method, omega);
                assert!(largest < 1.005, "{method:?}, ωh = {omega}: drawn up to {largest}");
                assert!(residual < 1e-9, "{method:?}, ωh = {omega}: residual {residual:e}");
            }
        }
    }

    /// Halving a step divides the error within it by `2^(order + 1)`, with an order of at most three.
    #[test]
    fn order_between_the_ends() {
        for (method, order) in [(Method::Esdirk4, 3), (Method::Esdirk3, 3), (Method::TrBdf2, 2), (Method::Sdirk2, 2)] {
            let ratio = one_step(method, 0.1)[0] / one_step(method, 0.05)[0];
            let observed = ratio.log2() - 1.0;
            assert!(observed > f64::from(order) - 0.1, "{method:?}: order {observed}");
        }
    }
}
