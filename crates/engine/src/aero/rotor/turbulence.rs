//! Turbulence generated from a seed: Kaimal spectra with the exponential coherence of IEC 61400-1, by Veers' method.
//!
//! Sources: IEC 61400-1, edition 3 (2005), annex B; Veers, *Three-dimensional wind simulation*, SAND88-0152 (1988).
//! The standard specifies a coherence for the longitudinal component only; the other two are independent from point to point, as by default
//! in TurbSim.

use crate::aero::fourier::inverse;
use crate::aero::random::Random;
use crate::aero::rotor::turbulence_box::TurbulenceBox;
use std::f64::consts::TAU;

/// Decay of the coherence with frequency.
const DECAY: f64 = 12.0;
/// Decay of the coherence with distance divided by the coherence scale.
const DISTANCE_DECAY: f64 = 0.12;
/// Length scales of the components, relative to the length parameter of the standard.
const LENGTHS: [f64; 3] = [8.10, 2.70, 0.66];
/// Standard deviations of the components, relative to the longitudinal one.
const DEVIATIONS: [f64; 3] = [1.0, 0.8, 0.5];
/// Coherence below which two points are treated as independent; the squares of a thousand such neighbours sum to 1e-5.
const MINIMUM_COHERENCE: f64 = 1e-4;

/// Parameters of the turbulence.
#[derive(Debug, Clone, PartialEq)]
pub struct Turbulence {
    /// Seed: the same seed gives the same box.
    pub seed: u64,
    /// Mean wind at the reference height in m/s.
    pub mean_m_s: f64,
    /// Exponent of the power law of the mean wind over height.
    pub power_exponent: f64,
    /// Standard deviation of the longitudinal component in m/s.
    pub standard_deviation_m_s: f64,
    /// Reference height in m, at which the box is centred.
    pub reference_height_m: f64,
    /// Numbers of points in the lateral and the vertical direction.
    pub points: [usize; 2],
    /// Spacing of the points in m in the lateral and the vertical direction.
    pub spacing_m: [f64; 2],
    /// Number of planes: a power of two.
    pub planes: usize,
    /// Time between planes in s.
    pub plane_interval_s: f64,
}

/// Reason why no turbulence box can be generated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoTurbulence {
    /// A setting has a value that is not allowed.
    #[error("{field} is {value}; {allowed}")]
    Field {
        /// Name of the setting.
        field: &'static str,
        /// Rejected value.
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
}

/// Standard deviation in m/s of the normal turbulence model at a mean wind, for the reference intensity at 15 m/s (0.16, 0.14 and 0.12 for
/// classes A, B and C), eq. (B21).
pub fn normal_deviation_m_s(reference_intensity: f64, mean_m_s: f64) -> f64 {
    reference_intensity * (0.75 * mean_m_s + 5.6)
}

/// Length parameter of the standard in m at a height, eq. (B21).
pub fn length_parameter_m(height_m: f64) -> f64 {
    0.7 * height_m.min(60.0)
}

/// One-sided spectrum in m²/s of a component (0 longitudinal, 1 lateral, 2 upward) at a frequency in Hz, eq. (B21).
pub fn kaimal_m2_s(
    component: usize,
    frequency_hz: f64,
    standard_deviation_m_s: f64,
    mean_m_s: f64,
    height_m: f64,
) -> f64 {
    let time_s = LENGTHS[component] * length_parameter_m(height_m) / mean_m_s;
    let standard_deviation_m_s = DEVIATIONS[component] * standard_deviation_m_s;
    4.0 * standard_deviation_m_s * standard_deviation_m_s * time_s / (1.0 + 6.0 * frequency_hz * time_s).powf(5.0 / 3.0)
}

/// Coherence of the longitudinal components at two points whose lateral distance is given in m, eq. (B22): modulus of the cross spectrum
/// divided by the spectrum.
pub fn coherence(distance_m: f64, frequency_hz: f64, mean_m_s: f64, height_m: f64) -> f64 {
    let length_m = LENGTHS[0] * length_parameter_m(height_m);
    (-DECAY * distance_m * (frequency_hz / mean_m_s).hypot(DISTANCE_DECAY / length_m)).exp()
}

impl Turbulence {
    /// Generates the box. The frequencies are integer multiples of the inverse of its duration, so that it is periodic.
    ///
    /// # Errors
    /// If a setting has a value that is not allowed.
    #[expect(clippy::needless_range_loop, reason = "the component selects a spectrum as well as a place")]
    pub fn generate(&self) -> Result<TurbulenceBox, NoTurbulence> {
        self.check()?;
        let [across, upward] = self.points;
        let bottom_m = self.reference_height_m - 0.5 * (upward - 1) as f64 * self.spacing_m[1];
        let places: Vec<[f64; 2]> = (0..upward)
            .flat_map(|row| (0..across).map(move |point| [point, row]))
            .map(|[point, row]| [point as f64 * self.spacing_m[0], row as f64 * self.spacing_m[1]])
            .collect();
        let count = places.len();
        let half = self.planes / 2;
        let frequency_hz = |m: usize| m as f64 / (self.planes as f64 * self.plane_interval_s);
        let mut random = Random(self.seed);
        let mut velocity_m_s = vec![[0f32; 3]; self.planes * count];
        let mut factor = vec![0.0; count * count];
        let mut amplitudes = vec![[0.0f64; 2]; count * half];
        for component in 0..3 {
            for m in 1..half {
                if component == 0 {
                    self.factor_coherence(&places, frequency_hz(m), &mut factor);
                }
                let share = 0.5 / (self.planes as f64 * self.plane_interval_s);
                let spectrum = kaimal_m2_s(
                    component,
                    frequency_hz(m),
                    self.standard_deviation_m_s,
                    self.mean_m_s,
                    self.reference_height_m,
                );
                let size = (spectrum * share).sqrt();
                let phases: Vec<[f64; 2]> = (0..count)
                    .map(|_| {
                        let (sine, cosine) = (TAU * random.uniform()).sin_cos();
                        [size * cosine, size * sine]
                    })
                    .collect();
                for point in 0..count {
                    amplitudes[point * half + m] = if component == 0 {
                        let row = &factor[point * count..=point * count + point];
                        row.iter().zip(&phases).fold([0.0; 2], |[x, y], (h, [a, b])| [x + h * a, y + h * b])
                    } else {
                        phases[point]
                    };
                }
            }
            let (mut real, mut imaginary) = (vec![0.0; self.planes], vec![0.0; self.planes]);
            for point in 0..count {
                real.fill(0.0);
                imaginary.fill(0.0);
                for m in 1..half {
                    let [a, b] = amplitudes[point * half + m];
                    (real[m], imaginary[m]) = (a, b);
                    (real[self.planes - m], imaginary[self.planes - m]) = (a, -b);
                }
                inverse(&mut real, &mut imaginary);
                for (plane, value) in real.iter().enumerate() {
                    velocity_m_s[plane * count + point][component] = *value as f32;
                }
            }
        }
        for (index, velocity) in velocity_m_s.iter_mut().enumerate() {
            let height_m = bottom_m + places[index % count][1];
            velocity[0] += (self.mean_m_s * (height_m / self.reference_height_m).powf(self.power_exponent)) as f32;
        }
        Ok(TurbulenceBox {
            across,
            upward,
            planes: self.planes,
            across_m: self.spacing_m[0],
            upward_m: self.spacing_m[1],
            plane_interval_s: self.plane_interval_s,
            bottom_m,
            carried_m_s: self.mean_m_s,
            periodic: true,
            velocity_m_s,
        })
    }

    /// Cholesky factor of the coherence matrix of all points: the lower triangle whose product with its transpose is that matrix.
    fn factor_coherence(&self, places: &[[f64; 2]], frequency_hz: f64, factor: &mut [f64]) {
        let count = places.len();
        // if the nearest neighbours are independent, all points are
        let nearest_m = self.spacing_m[0].min(self.spacing_m[1]);
        let bound = |distance_m: f64| coherence(distance_m, frequency_hz, self.mean_m_s, self.reference_height_m);
        if bound(nearest_m) < MINIMUM_COHERENCE {
            factor.fill(0.0);
            (0..count).for_each(|i| factor[i * count + i] = 1.0);
            return;
        }
        for i in 0..count {
            for j in 0..=i {
                let distance_m = (places[i][0] - places[j][0]).hypot(places[i][1] - places[j][1]);
                let (upper, lower) = factor.split_at_mut(i * count);
                let row_j = if j == i { None } else { Some(&upper[j * count..j * count + j + 1]) };
                let row_i = &mut lower[..=j];
                match row_j {
                    Some(row_j) => {
                        let sum: f64 = row_i[..j].iter().zip(&row_j[..j]).map(|(a, b)| a * b).sum();
                        row_i[j] = (bound(distance_m) - sum) / row_j[j];
                    }
                    None => {
                        let sum: f64 = row_i[..j].iter().map(|a| a * a).sum();
                        row_i[j] = (1.0 - sum).max(1e-12).sqrt(); // round-off for points that nearly coincide
                    }
                }
            }
        }
    }

    fn check(&self) -> Result<(), NoTurbulence> {
        let [across, upward] = self.points;
        let field = |field, value: f64, fine: bool, allowed| {
            if fine { Ok(()) } else { Err(NoTurbulence::Field { field, value, allowed }) }
        };
        let positive = |value: f64| value > 0.0 && value.is_finite();
        field("mean_m_s", self.mean_m_s, positive(self.mean_m_s), "a finite number > 0")?;
        field(
            "power_exponent",
            self.power_exponent,
            (-1.0..=1.0).contains(&self.power_exponent),
            "a number from -1 to 1",
        )?;
        let deviation = self.standard_deviation_m_s;
        field("standard_deviation_m_s", deviation, deviation >= 0.0 && deviation.is_finite(), "a finite number >= 0")?;
        field("reference_height_m", self.reference_height_m, positive(self.reference_height_m), "a finite number > 0")?;
        for (spacing_m, points) in self.spacing_m.into_iter().zip(self.points) {
            field("spacing_m", spacing_m, positive(spacing_m), "finite numbers > 0")?;
            field("points", points as f64, (2..=100).contains(&points), "2 to 100 points in each direction")?;
        }
        let bottom_m = self.reference_height_m - 0.5 * (upward - 1) as f64 * self.spacing_m[1];
        field(
            "spacing_m",
            self.spacing_m[1],
            bottom_m > 0.0,
            "a spacing at which the lowest points are above the ground",
        )?;
        field("plane_interval_s", self.plane_interval_s, positive(self.plane_interval_s), "a finite number > 0")?;
        let fine = self.planes.is_power_of_two() && (8..=1 << 20).contains(&self.planes);
        field("planes", self.planes as f64, fine, "a power of two from 8 to 1048576")?;
        let values = (across * upward * self.planes) as f64;
        field("planes", values, values <= 3e7, "at most 3e7 for the product of points and planes")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(seed: u64) -> Turbulence {
        Turbulence {
            seed,
            mean_m_s: 12.0,
            power_exponent: 0.2,
            standard_deviation_m_s: 1.8,
            reference_height_m: 90.0,
            points: [4, 4],
            spacing_m: [20.0, 20.0],
            planes: 1024,
            plane_interval_s: 0.25,
        }
    }

    /// Fourier coefficient of a frequency at a point, as a direct sum.
    fn coefficient(grid: &TurbulenceBox, point: usize, component: usize, m: usize) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for plane in 0..grid.planes {
            let value = f64::from(grid.velocity_m_s[plane * grid.across * grid.upward + point][component]);
            let (s, c) = (TAU * ((m * plane) % grid.planes) as f64 / grid.planes as f64).sin_cos();
            sum = [sum[0] + value * c, sum[1] - value * s];
        }
        sum.map(|x| x / grid.planes as f64)
    }

    /// Compares the spectra of all components, averaged over frequency bands and 8 seeds. With independent phases the mean of `n`
    /// periodograms has a relative standard deviation of at most `1/√n`; the tolerance is four of these.
    #[test]
    fn spectra_are_kaimals() {
        let boxes: Vec<TurbulenceBox> = (0..8).map(|seed| asked(seed).generate().unwrap()).collect();
        let points = [0, 5, 10, 15];
        for component in 0..3 {
            for band in [1..5, 5..15, 40..60, 200..220, 500..511] {
                let (mut measured, mut expected) = (0.0, 0.0);
                for m in band.clone() {
                    let frequency_hz = m as f64 / 256.0;
                    expected += kaimal_m2_s(component, frequency_hz, 1.8, 12.0, 90.0);
                    for grid in &boxes {
                        for point in points {
                            let [a, b] = coefficient(grid, point, component, m);
                            measured += 2.0 * (a * a + b * b) * 256.0 / (boxes.len() * points.len()) as f64;
                        }
                    }
                }
                // the points of one box are coherent at low frequencies: only seeds and frequencies give independent samples
                let limit = 4.0 / ((boxes.len() * band.len()) as f64).sqrt();
                let error = measured / expected - 1.0;
                assert!(error.abs() < limit, "component {component}, {band:?}: {error:+.3}, limit {limit:.3}");
            }
        }
    }

    /// Coherence of pairs of points 20 m and 40 m apart. An estimate from `n` samples at coherence `γ` has a standard deviation of about
    /// `(1 − γ²)/√(2n)`; the tolerance is four of these.
    #[test]
    fn coherence_is_the_standards() {
        let boxes: Vec<TurbulenceBox> = (100..124).map(|seed| asked(seed).generate().unwrap()).collect();
        for (pair, distance_m) in [([0, 1], 20.0), ([5, 9], 20.0), ([4, 6], 40.0), ([0, 5], 20.0 * 2f64.sqrt())] {
            for band in [1..4, 4..8, 8..16] {
                let (mut cross, mut own, mut expected) = ([0.0; 2], [0.0; 2], 0.0);
                for m in band.clone() {
                    expected += coherence(distance_m, m as f64 / 256.0, 12.0, 90.0) / band.len() as f64;
                    for grid in &boxes {
                        let [x, y] = pair.map(|point| coefficient(grid, point, 0, m));
                        cross = [cross[0] + x[0] * y[0] + x[1] * y[1], cross[1] + x[1] * y[0] - x[0] * y[1]];
                        own = [own[0] + x[0] * x[0] + x[1] * x[1], own[1] + y[0] * y[0] + y[1] * y[1]];
                    }
                }
                let measured = cross[0] / (own[0] * own[1]).sqrt();
                let samples = (boxes.len() * band.len()) as f64;
                let limit = 4.0 * (1.0 - expected * expected).max(0.05) / (2.0 * samples).sqrt();
                let error = measured - expected;
                assert!(error.abs() < limit, "{pair:?} {band:?}: {measured:.3} for {expected:.3}, limit {limit:.3}");
                assert!(cross[1].abs() / (own[0] * own[1]).sqrt() < 4.0 / (2.0 * samples).sqrt(), "phase {pair:?}");
            }
        }
    }

    #[test]
    fn seed_decides_and_the_mean_is_the_profile() {
        let (one, again, other) =
            (asked(7).generate().unwrap(), asked(7).generate().unwrap(), asked(8).generate().unwrap());
        assert_eq!(one, again);
        assert_ne!(one.velocity_m_s, other.velocity_m_s);
        let mean = |point: usize, component: usize| coefficient(&one, point, component, 0)[0];
        approx::assert_relative_eq!(mean(0, 0), 12.0 * (60.0f64 / 90.0).powf(0.2), max_relative = 1e-6);
        approx::assert_relative_eq!(mean(15, 0), 12.0 * (120.0f64 / 90.0).powf(0.2), max_relative = 1e-6);
        assert!(mean(3, 1).abs() < 1e-6 && mean(3, 2).abs() < 1e-6);
    }

    #[test]
    fn impossible_boxes_are_refused_by_name() {
        type Change = fn(&mut Turbulence);
        let cases: [(&str, Change); 9] = [
            ("mean_m_s", |asked| asked.mean_m_s = 0.0),
            ("power_exponent", |asked| asked.power_exponent = f64::NAN),
            ("standard_deviation_m_s", |asked| asked.standard_deviation_m_s = -1.0),
            ("reference_height_m", |asked| asked.reference_height_m = f64::INFINITY),
            ("points", |asked| asked.points = [1, 4]),
            ("spacing_m", |asked| asked.spacing_m = [20.0, 60.0]),
            ("plane_interval_s", |asked| asked.plane_interval_s = 0.0),
            ("planes", |asked| asked.planes = 1000),
            ("planes", |asked| (asked.points, asked.spacing_m, asked.planes) = ([100, 100], [1.0, 1.0], 4096)),
        ];
        for (name, change) in cases {
            let mut asked = asked(0);
            change(&mut asked);
            let error = asked.generate().unwrap_err().to_string();
            assert!(error.starts_with(name), "{error}");
        }
    }
}
