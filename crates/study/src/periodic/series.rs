//! Outputs over a revolution, with their harmonics.

use foldwing_engine::plant::SAMPLES;
use serde::Serialize;
use std::f64::consts::TAU;

/// Change over a revolution, relative to the range of an output, above which it is not periodic.
const DRIFT: f64 = 1e-2;
/// Change over a revolution below which it is round-off: relative to the largest magnitude of the output, and in its unit.
const ROUND_OFF: [f64; 2] = [1e-6, 1e-9];

/// An output over a revolution.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name of the output.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Values at the [`SAMPLES`] azimuths of the revolution, and at its end.
    pub values: Vec<f64>,
}

impl Series {
    /// Returns a series without values.
    pub fn of(name: &str, unit: &'static str) -> Self {
        Self { name: name.to_owned(), unit, values: Vec::with_capacity(SAMPLES + 1) }
    }

    /// Returns whether all values are zero.
    pub fn is_zero(&self) -> bool {
        self.values.iter().all(|value| *value == 0.0)
    }

    /// Whether the value at the end of the revolution equals that at its start.
    pub fn is_periodic(&self) -> bool {
        let largest = self.values.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        self.drift() <= (2.0 * DRIFT * self.half_range()).max(ROUND_OFF[0] * largest).max(ROUND_OFF[1])
    }

    /// Difference of the values at the end and at the start of the revolution.
    pub fn drift(&self) -> f64 {
        let (Some(first), Some(last)) = (self.values.first(), self.values.last()) else { return 0.0 };
        (last - first).abs()
    }

    /// Half the difference of the largest and the smallest value.
    pub fn half_range(&self) -> f64 {
        let high = self.values.iter().fold(f64::MIN, |high, value| high.max(*value));
        let low = self.values.iter().fold(f64::MAX, |low, value| low.min(*value));
        0.5 * (high - low)
    }

    /// Amplitude of a harmonic, and the azimuth from the start in rad of its first maximum; for harmonic 0 the mean.
    pub fn harmonic(&self, n: usize) -> [f64; 2] {
        let values = &self.values[..SAMPLES.min(self.values.len())];
        let count = values.len() as f64;
        if n == 0 {
            return [values.iter().sum::<f64>() / count, 0.0];
        }
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (k, value) in values.iter().enumerate() {
            let (s, c) = (TAU * (n * k % SAMPLES) as f64 / SAMPLES as f64).sin_cos();
            cosine += value * c * 2.0 / count;
            sine += value * s * 2.0 / count;
        }
        [cosine.hypot(sine), sine.atan2(cosine).rem_euclid(TAU) / n as f64]
    }

    /// Name, unit, mean, half the range, and amplitudes and phases of the first harmonics; phases are rotation angles of the shaft in its
    /// direction of rotation, `sense` = 1 or -1.
    pub fn summary(&self, harmonics: usize, sense: f64) -> Summary<'_> {
        let parts: Vec<[f64; 2]> = (1..=harmonics).map(|n| self.harmonic(n)).collect();
        Summary {
            name: &self.name,
            unit: self.unit,
            periodic: self.is_periodic(),
            mean: self.harmonic(0)[0],
            half_range: self.half_range(),
            amplitudes: parts.iter().map(|part| part[0]).collect(),
            largest_at_deg: parts.iter().map(|part| sense * part[1].to_degrees()).collect(),
        }
    }
}

/// Summary of an output over a revolution, in its unit. Its JSON is that of `foldwing periodic`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary<'a> {
    /// Name of the output.
    pub name: &'a str,
    /// Its unit.
    pub unit: &'static str,
    /// Whether the value at the end of the revolution equals that at its start.
    pub periodic: bool,
    /// Mean over the revolution.
    pub mean: f64,
    /// Half the difference of the largest and the smallest value.
    pub half_range: f64,
    /// Amplitudes of the harmonics of the shaft speed, starting with the first.
    pub amplitudes: Vec<f64>,
    /// Rotation of the shaft from the start, in degrees, at which each harmonic has its first maximum.
    pub largest_at_deg: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `2 + 3 cos(2(ψ − 0.4))`: mean, second harmonic with its phase, no other; a ramp is not periodic, a constant is.
    #[test]
    fn harmonics_of_a_series() {
        let of = |f: &dyn Fn(f64) -> f64| {
            let mut series = Series::of("x", "m");
            series.values = (0..=SAMPLES).map(|k| f(TAU * k as f64 / SAMPLES as f64)).collect();
            series
        };
        let wave = of(&|turn| 2.0 + 3.0 * (2.0 * (turn - 0.4)).cos());
        assert!(
            (wave.harmonic(0)[0] - 2.0).abs() < 1e-13 && wave.harmonic(1)[0] < 1e-13 && wave.harmonic(3)[0] < 1e-13
        );
        let [amplitude, place] = wave.harmonic(2);
        assert!((amplitude - 3.0).abs() < 1e-12 && (place - 0.4).abs() < 1e-12, "{amplitude} {place}");
        assert!(wave.is_periodic() && (wave.half_range() - 3.0).abs() < 1e-2);
        assert!(!of(&|turn| turn).is_periodic() && of(&|_| 7.0).is_periodic());
        assert!((of(&|turn| turn).drift() - TAU).abs() < 1e-12);
        // for a shaft that rotates in the negative direction, the angles are positive in that direction, as in the table over the
        // revolution
        let places = [1.0, -1.0].map(|sense| wave.summary(2, sense).largest_at_deg[1]);
        assert!((places[0] - 0.4f64.to_degrees()).abs() < 1e-9 && places[1] == -places[0], "{places:?}");
    }
}
