//! A state at a time, and the polynomial between two of them.

use crate::solve::Powers;
use serde::{Deserialize, Serialize};

/// Coordinates with their rates at one time, and the energy accounts.
#[derive(Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Point {
    /// Time in s.
    pub time_s: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Rates.
    pub v: Vec<f64>,
    /// Accelerations.
    pub a: Vec<f64>,
    /// Auxiliary accelerations of generalised-α; empty for other methods.
    pub auxiliary: Vec<f64>,
    /// Work of the inputs in J.
    pub work: f64,
    /// Dissipated energy in J.
    pub dissipated: f64,
    /// Rates of work and dissipated energy.
    pub powers: Powers,
}

impl Clone for Point {
    fn clone(&self) -> Self {
        Self { q: self.q.clone(), v: self.v.clone(), a: self.a.clone(), auxiliary: self.auxiliary.clone(), ..*self }
    }

    fn clone_from(&mut self, source: &Self) {
        let Self { time_s, q, v, a, auxiliary, work, dissipated, powers } = source;
        (self.time_s, self.work, self.dissipated, self.powers) = (*time_s, *work, *dissipated, *powers);
        self.q.clone_from(q);
        self.v.clone_from(v);
        self.a.clone_from(a);
        self.auxiliary.clone_from(auxiliary);
    }
}

impl Point {
    /// A point with `coordinates` zero entries.
    pub fn zeros(coordinates: usize) -> Self {
        let zeros = vec![0.0; coordinates];
        Self { q: zeros.clone(), v: zeros.clone(), a: zeros.clone(), auxiliary: zeros, ..Self::default() }
    }

    /// Copies without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.time_s = other.time_s;
        self.q.copy_from_slice(&other.q);
        self.v.copy_from_slice(&other.v);
        self.a.copy_from_slice(&other.a);
        self.auxiliary.copy_from_slice(&other.auxiliary);
        self.work = other.work;
        self.dissipated = other.dissipated;
        self.powers = other.powers;
    }

    /// Interpolates the state at `time_s` between `start` and `end`: quintic Hermite polynomial for the coordinates, with its derivatives
    /// for rates and accelerations, and cubic Hermite polynomial for the energies; NOTATION eq. (T6), methods without stages.
    pub(super) fn interpolate(&mut self, start: &Self, end: &Self, time_s: f64) {
        let h = end.time_s - start.time_s;
        let s = (time_s - start.time_s) / h;
        let basis = Quintic::at(s);
        let n = self.q.len();
        let (q, v, a) = (&mut self.q[..n], &mut self.v[..n], &mut self.a[..n]);
        let [q0, v0, a0] = [&start.q[..n], &start.v[..n], &start.a[..n]];
        let [q1, v1, a1] = [&end.q[..n], &end.v[..n], &end.a[..n]];
        for i in 0..n {
            let ends = [q1[i] - q0[i], h * v0[i], h * v1[i], h * h * a0[i], h * h * a1[i]];
            let [value, slope, curvature] = basis.apply(&ends);
            q[i] = q0[i] + value;
            v[i] = slope / h;
            a[i] = curvature / (h * h);
        }
        let auxiliary = self.auxiliary.iter_mut().zip(&start.auxiliary).zip(&end.auxiliary);
        auxiliary.for_each(|((now, start), end)| *now = start + s * (end - start));
        let cubic = |y0: f64, y1: f64, d0: f64, d1: f64| {
            let (s2, s3) = (s * s, s * s * s);
            y0 + (3.0 * s2 - 2.0 * s3) * (y1 - y0) + h * ((s - 2.0 * s2 + s3) * d0 + (s3 - s2) * d1)
        };
        self.work = cubic(start.work, end.work, start.powers.work, end.powers.work);
        self.dissipated = cubic(start.dissipated, end.dissipated, start.powers.dissipated, end.powers.dissipated);
        self.powers = Powers {
            work: start.powers.work + s * (end.powers.work - start.powers.work),
            dissipated: start.powers.dissipated + s * (end.powers.dissipated - start.powers.dissipated),
        };
        self.time_s = time_s;
    }
}

/// Quintic Hermite basis at one position: weights of `(q₁ − q₀, h v₀, h v₁, h² a₀, h² a₁)` for the value and its first two derivatives.
pub(super) struct Quintic([[f64; 5]; 3]);

impl Quintic {
    /// One coordinate at `start + fraction·h`, by the quintic polynomial.
    pub fn coordinate_between(start: &Point, end: &Point, fraction: f64, index: usize) -> f64 {
        start.q[index] + Self::between(start, end, fraction, index)[0]
    }

    /// Rate of one coordinate at `start + fraction·h`, by the quintic polynomial.
    pub fn rate_between(start: &Point, end: &Point, fraction: f64, index: usize) -> f64 {
        Self::between(start, end, fraction, index)[1] / (end.time_s - start.time_s)
    }

    fn between(start: &Point, end: &Point, fraction: f64, index: usize) -> [f64; 3] {
        let h = end.time_s - start.time_s;
        let ends = [
            end.q[index] - start.q[index],
            h * start.v[index],
            h * end.v[index],
            h * h * start.a[index],
            h * h * end.a[index],
        ];
        Quintic::at(fraction).apply(&ends)
    }

    fn at(s: f64) -> Self {
        let (s2, s3, s4, s5) = (s * s, s.powi(3), s.powi(4), s.powi(5));
        Self([
            [
                10.0 * s3 - 15.0 * s4 + 6.0 * s5,
                s - 6.0 * s3 + 8.0 * s4 - 3.0 * s5,
                -4.0 * s3 + 7.0 * s4 - 3.0 * s5,
                0.5 * s2 - 1.5 * s3 + 1.5 * s4 - 0.5 * s5,
                0.5 * s3 - s4 + 0.5 * s5,
            ],
            [
                30.0 * s2 - 60.0 * s3 + 30.0 * s4,
                1.0 - 18.0 * s2 + 32.0 * s3 - 15.0 * s4,
                -12.0 * s2 + 28.0 * s3 - 15.0 * s4,
                s - 4.5 * s2 + 6.0 * s3 - 2.5 * s4,
                1.5 * s2 - 4.0 * s3 + 2.5 * s4,
            ],
            [
                60.0 * s - 180.0 * s2 + 120.0 * s3,
                -36.0 * s + 96.0 * s2 - 60.0 * s3,
                -24.0 * s + 84.0 * s2 - 60.0 * s3,
                1.0 - 9.0 * s + 18.0 * s2 - 10.0 * s3,
                3.0 * s - 12.0 * s2 + 10.0 * s3,
            ],
        ])
    }

    fn apply(&self, ends: &[f64; 5]) -> [f64; 3] {
        self.0.map(|row| row.iter().zip(ends).map(|(w, e)| w * e).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polynomial of degree five and its two derivatives are reproduced; the tolerance is round-off.
    #[test]
    fn interpolation_is_exact_for_quintics() {
        let value = |t: f64| {
            let c = [0.3, -1.0, 0.5, 2.0, -0.7, 0.2];
            let (mut q, mut v, mut a) = (0.0, 0.0, 0.0);
            for (i, c) in c.iter().enumerate() {
                let n = i as i32;
                q += c * t.powi(n);
                v += if n > 0 { f64::from(n) * c * t.powi(n - 1) } else { 0.0 };
                a += if n > 1 { f64::from(n * (n - 1)) * c * t.powi(n - 2) } else { 0.0 };
            }
            (q, v, a)
        };
        let point = |t: f64| {
            let (q, v, a) = value(t);
            Point { time_s: t, q: vec![q], v: vec![v], a: vec![a], auxiliary: vec![a], ..Point::default() }
        };
        let (start, end) = (point(0.4), point(1.5));
        let mut between = Point::zeros(1);
        for t in [0.41, 0.5, 0.77, 1.2, 1.49] {
            between.interpolate(&start, &end, t);
            let (q, v, a) = value(t);
            assert!(
                (between.q[0] - q).abs() < 1e-13
                    && (between.v[0] - v).abs() < 1e-12
                    && (between.a[0] - a).abs() < 1e-11
            );
            let fraction = (t - 0.4) / 1.1;
            assert!((Quintic::coordinate_between(&start, &end, fraction, 0) - q).abs() < 1e-13);
        }
    }
}
