//! Continuous turbulence in flight: one velocity component of the gusts along a line, with a Dryden or von Kármán spectrum, from a seed.
//!
//! Sources: MIL-F-8785C (1980), section 3.7; Hoblit, *Gust Loads on Aircraft* (1988), chapter 4. All components have the same scale `L`
//! here, as in that standard above 1750 ft.

use crate::aero::fourier::inverse;
use crate::aero::random::Random;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Number of points per shortest wavelength: the cubic interpolation between points reduces its amplitude by 3 %.
const POINTS_OF_SHORTEST: usize = 4;
/// Minimum and maximum number of points of a series.
const POINTS: std::ops::RangeInclusive<usize> = 64..=1 << 20;
/// Factor of the scale in von Kármán's spectra.
const KARMAN: f64 = 1.339;

/// Spectrum of the turbulence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spectrum {
    /// Dryden spectrum: rational in the wave number.
    Dryden,
    /// Von Kármán spectrum: falls with the power −5/3 of the wave number, like measured turbulence.
    VonKarman,
}

/// Direction of the component relative to the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// Component along the line.
    Longitudinal,
    /// Component normal to the line.
    Transverse,
}

impl Spectrum {
    /// One-sided spectral density `Φ` in m as a function of the wave number `Ω` in rad/m, for a standard deviation of 1 and a scale `L` in
    /// m: its integral from 0 is 1, eq. (U13).
    pub fn density_m(self, component: Component, scale_m: f64, wave_number_rad_m: f64) -> f64 {
        let reach = scale_m * wave_number_rad_m;
        match (self, component) {
            (Self::Dryden, Component::Longitudinal) => 2.0 * scale_m / PI / (1.0 + reach.powi(2)),
            (Self::Dryden, Component::Transverse) => {
                scale_m / PI * (1.0 + 3.0 * reach.powi(2)) / (1.0 + reach.powi(2)).powi(2)
            }
            (Self::VonKarman, Component::Longitudinal) => {
                2.0 * scale_m / PI / (1.0 + (KARMAN * reach).powi(2)).powf(5.0 / 6.0)
            }
            (Self::VonKarman, Component::Transverse) => {
                let square = (KARMAN * reach).powi(2);
                scale_m / PI * (1.0 + 8.0 / 3.0 * square) / (1.0 + square).powf(11.0 / 6.0)
            }
        }
    }
}

/// Specification of the turbulence.
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuousTurbulence {
    /// Spectrum.
    pub spectrum: Spectrum,
    /// Direction of the velocity relative to the path of the gust.
    pub component: Component,
    /// Scale `L` in m.
    pub scale_m: f64,
    /// Seed: the same seed gives the same series.
    pub seed: u64,
    /// Period of the series in m; `None`: 256 scales.
    pub length_m: Option<f64>,
    /// Spacing of the points in m; wavelengths below four spacings are omitted. `None`: a 256th of the scale. The number of points is
    /// rounded up to a power of two, which reduces the spacing.
    pub resolution_m: Option<f64>,
}

/// Reason why no series can be generated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field} is {value}; {allowed}")]
pub struct NoSeries {
    /// Name of the setting.
    pub field: &'static str,
    /// Rejected value.
    pub value: f64,
    /// Allowed values.
    pub allowed: &'static str,
}

/// Equidistant values along a periodic line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Spacing of the points in m.
    pub spacing_m: f64,
    /// Distance in m into the series at which the line starts.
    pub begin_m: f64,
    /// The values; their number is a power of two.
    pub values: Arc<[f64]>,
}

impl ContinuousTurbulence {
    /// Generates the series, which starts at a zero. Over many seeds its standard deviation is 1, except for the omitted part, eq. (U14).
    ///
    /// # Errors
    /// If a setting has a value that is not allowed.
    pub fn series(&self) -> Result<Series, NoSeries> {
        let scale_m = self.scale_m;
        let positive = |field: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(value),
            false => Err(NoSeries { field, value, allowed: "a finite length > 0 m" }),
        };
        positive("scale_m", scale_m)?;
        let length_m = positive("length_m", self.length_m.unwrap_or(256.0 * scale_m))?;
        let resolution_m = positive("resolution_m", self.resolution_m.unwrap_or(scale_m / 256.0))?;
        let asked = (length_m / resolution_m).ceil();
        if !(asked >= 1.0 && asked <= *POINTS.end() as f64) {
            let allowed = "a length > 0 m that is at least length_m / 1048576";
            return Err(NoSeries { field: "resolution_m", value: resolution_m, allowed });
        }
        let count = (asked as usize).max(*POINTS.start()).next_power_of_two();
        let mut random = Random(self.seed);
        let (mut real, mut imaginary) = (vec![0.0; count], vec![0.0; count]);
        let step_rad_m = TAU / length_m;
        for m in 1..=count / POINTS_OF_SHORTEST {
            let density_m = self.spectrum.density_m(self.component, scale_m, m as f64 * step_rad_m);
            let size = 0.5 * (density_m * step_rad_m).sqrt();
            let [a, b] = random.normal_pair().map(|number| size * number);
            (real[m], imaginary[m]) = (a, b);
            (real[count - m], imaginary[count - m]) = (a, -b);
        }
        inverse(&mut real, &mut imaginary);
        let mut series = Series { spacing_m: length_m / count as f64, begin_m: 0.0, values: real.into() };
        series.begin_m = series.first_zero_m();
        Ok(series)
    }
}

impl Series {
    /// Value at a distance in m from the beginning, by cubic interpolation between two points with slopes from their neighbours.
    pub fn at(&self, distance_m: f64) -> f64 {
        let place = (distance_m + self.begin_m) / self.spacing_m;
        let count = self.values.len();
        let first = place.floor();
        let part = place - first;
        let index = first.rem_euclid(count as f64) as usize;
        let [a, b, c, d] = [count - 1, 0, 1, 2].map(|step| self.values[(index + step) % count]);
        let (rise, fall) = (0.5 * (c - a), 0.5 * (d - b));
        let square = part * part;
        b + part * rise + square * (3.0 * (c - b) - 2.0 * rise - fall) + square * part * (2.0 * (b - c) + rise + fall)
    }

    /// Position of the first change of sign of the values, in m from the first point; 0 without one.
    fn first_zero_m(&self) -> f64 {
        let crossing = self.values.windows(2).position(|pair| (pair[0] < 0.0) != (pair[1] < 0.0));
        let Some(index) = crossing else { return 0.0 };
        let [mut low, mut high] = [index as f64, index as f64 + 1.0].map(|place| place * self.spacing_m);
        let below = self.values[index] < 0.0;
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if (self.at(middle) < 0.0) == below { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: [Component; 2] = [Component::Longitudinal, Component::Transverse];
    const SPECTRA: [Spectrum; 2] = [Spectrum::Dryden, Spectrum::VonKarman];

    fn asked(spectrum: Spectrum, component: Component, seed: u64) -> ContinuousTurbulence {
        ContinuousTurbulence { spectrum, component, scale_m: 3.0, seed, length_m: None, resolution_m: None }
    }

    /// The spectra integrate to 1, by the substitution `LΩ = s³/(1 − s³)` and the trapezoidal rule, to 1e-3.
    #[test]
    fn spectra_have_unit_variance() {
        for spectrum in SPECTRA {
            for component in BOTH {
                let points = 200_000;
                let sum: f64 = (1..points)
                    .map(|i| {
                        let s = i as f64 / points as f64;
                        let reach = s.powi(3) / (1.0 - s.powi(3));
                        let slope = 3.0 * s * s / (1.0 - s.powi(3)).powi(2);
                        spectrum.density_m(component, 3.0, reach / 3.0) * slope / 3.0 / points as f64
                    })
                    .sum();
                // von Kármán's tail beyond the last point, whose integral falls with the power −2/3
                assert!((sum - 1.0).abs() < 1e-3, "{spectrum:?} {component:?}: {sum}");
            }
        }
    }

    /// Averages the periodograms of 20 seeds over bands of harmonics. Each value is the density times an exponential variate with mean and
    /// standard deviation 1, so that the mean of `n` deviates by `1/√n`; the tolerance is four of these.
    #[test]
    fn periodograms_lie_in_their_confidence_band() {
        for spectrum in SPECTRA {
            for component in BOTH {
                let short = |seed| ContinuousTurbulence {
                    length_m: Some(64.0 * 3.0),
                    resolution_m: Some(3.0 / 64.0),
                    ..asked(spectrum, component, seed)
                };
                let list: Vec<Series> = (0..20).map(|seed| short(seed).series().unwrap()).collect();
                let step_rad_m = TAU / (64.0 * 3.0);
                for band in [1..6usize, 10..20, 50..60, 200..210, 1015..1025] {
                    let mut share = 0.0;
                    for m in band.clone() {
                        let expected = spectrum.density_m(component, 3.0, m as f64 * step_rad_m) * step_rad_m;
                        for series in &list {
                            share += power(series, m) / expected;
                        }
                    }
                    let samples = (list.len() * band.len()) as f64;
                    let error = share / samples - 1.0;
                    let limit = 4.0 / samples.sqrt();
                    assert!(error.abs() < limit, "{spectrum:?} {component:?} {band:?}: {error:+.3}, limit {limit:.3}");
                }
            }
        }
    }

    /// Power of a harmonic by direct summation.
    fn power(series: &Series, m: usize) -> f64 {
        let count = series.values.len();
        let mut sum = [0.0; 2];
        for (i, value) in series.values.iter().enumerate() {
            let (s, c) = (TAU * ((m * i) % count) as f64 / count as f64).sin_cos();
            sum = [sum[0] + value * c, sum[1] + value * s];
        }
        let [a, b] = sum.map(|x| x / count as f64);
        2.0 * (a * a + b * b)
    }

    /// Variance over seeds: 1 minus the omitted part, 0.24 % for Dryden's transverse spectrum and 1.4 % for von Kármán's. The variance of
    /// one series has a standard deviation of about `√(2 Σ(ΦΔΩ)²)`, 0.14 here; the tolerance is four of these divided by the square root of
    /// the number of seeds.
    #[test]
    fn variance_is_one_less_what_is_left_out() {
        for (spectrum, left_out) in SPECTRA.into_iter().zip([0.0024, 0.014]) {
            let mut sum = 0.0;
            for seed in 0..40 {
                let series = asked(spectrum, Component::Transverse, seed).series().unwrap();
                sum += series.values.iter().map(|x| x * x).sum::<f64>() / series.values.len() as f64 / 40.0;
            }
            let limit = 4.0 * 0.14 / 40f64.sqrt();
            assert!((sum - (1.0 - left_out)).abs() < limit, "{spectrum:?}: {sum}");
        }
    }

    #[test]
    fn series_is_smooth_goes_round_and_begins_at_zero() {
        let series = asked(Spectrum::VonKarman, Component::Transverse, 5).series().unwrap();
        assert_eq!(series.values.len(), 65_536);
        assert!(series.at(0.0).abs() < 1e-9);
        for place in [0.7, 5.01, 99.3, 767.999] {
            let [before, after] = [place, place + 256.0 * 3.0].map(|place| series.at(place));
            approx::assert_relative_eq!(before, after, epsilon = 1e-9);
            approx::assert_relative_eq!(series.at(place - 768.0), before, epsilon = 1e-9);
        }
        // the interpolation passes through the points, with equal slopes on both sides
        let point_m = 1000.0 * series.spacing_m - series.begin_m;
        approx::assert_relative_eq!(series.at(point_m), series.values[1000], epsilon = 1e-9);
        let slope = |sign: f64| (series.at(point_m + sign * 1e-6) - series.at(point_m)) / (sign * 1e-6);
        approx::assert_relative_eq!(slope(1.0), slope(-1.0), epsilon = 1e-3);
        assert_eq!(series, asked(Spectrum::VonKarman, Component::Transverse, 5).series().unwrap());
        assert_ne!(series, asked(Spectrum::VonKarman, Component::Transverse, 6).series().unwrap());
    }

    #[test]
    fn impossible_series_are_refused_by_name() {
        let asked = |scale_m: f64, length_m: Option<f64>, resolution_m: Option<f64>| {
            let rest = asked(Spectrum::Dryden, Component::Longitudinal, 0);
            ContinuousTurbulence { scale_m, length_m, resolution_m, ..rest }.series()
        };
        for (error, field) in [
            (asked(0.0, None, None), "scale_m"),
            (asked(f64::NAN, None, None), "scale_m"),
            (asked(1.0, Some(-1.0), None), "length_m"),
            (asked(1.0, None, Some(f64::INFINITY)), "resolution_m"),
            (asked(1.0, None, Some(1e-6)), "resolution_m"),
            (asked(1.0, Some(1e300), Some(1e-300)), "resolution_m"),
        ] {
            assert_eq!(error.unwrap_err().field, field);
        }
        assert_eq!(asked(1.0, Some(1.0), Some(10.0)).unwrap().values.len(), 64);
    }
}
