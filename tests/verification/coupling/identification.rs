//! Growth rate and frequency of a free motion from its samples.

use nalgebra::{Complex, DMatrix, DVector};

/// Singular values of the record below this fraction of the largest are noise: the coupling iterates the loads to 1e-7.
const NOISE: f64 = 1e-6;
/// Maximum number of exponentials in the decomposition of a record.
const MAXIMUM_POLES: usize = 12;

/// A component `exp(growth t) cos(frequency t + …)` of a record.
#[derive(Debug, Clone, Copy)]
pub struct Oscillation {
    /// Growth rate in 1/s.
    pub growth_1_s: f64,
    /// Frequency in rad/s.
    pub frequency_rad_s: f64,
}

/// The least damped oscillation between two frequencies, by the matrix pencil (Hua and Sarkar, IEEE Transactions on Acoustics, Speech and
/// Signal Processing 38, 1990): for samples that are a sum of exponentials, the shift by one row of their Hankel matrix, projected onto its
/// dominant singular vectors, has the factors of the exponentials per sample as eigenvalues.
pub fn least_damped(samples: &[f64], interval_s: f64, band_rad_s: [f64; 2]) -> Oscillation {
    let columns = samples.len() / 2;
    let rows = samples.len() - columns;
    let hankel = |shift: usize| DMatrix::from_fn(rows, columns, |i, j| samples[i + j + shift]);
    let svd = hankel(0).svd(true, true);
    let order = svd.singular_values.iter().take_while(|value| **value > NOISE * svd.singular_values[0]).count();
    let order = order.min(MAXIMUM_POLES);
    let (left, right) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
    let scale = DMatrix::from_diagonal(&DVector::from_fn(order, |i, _| 1.0 / svd.singular_values[i]));
    let pencil = scale * left.columns(0, order).transpose() * hankel(1) * right.rows(0, order).transpose();
    let poles = pencil.complex_eigenvalues().map(|factor: Complex<f64>| factor.ln() / interval_s);
    poles
        .iter()
        .filter(|pole| pole.im > band_rad_s[0] && pole.im < band_rad_s[1])
        .map(|pole| Oscillation { growth_1_s: pole.re, frequency_rad_s: pole.im })
        .max_by(|a, b| a.growth_1_s.total_cmp(&b.growth_1_s))
        .unwrap_or_else(|| panic!("no oscillation between {band_rad_s:?} rad/s: {poles}"))
}

/// The method decomposes a synthetic record: two oscillations close to each other, one growing, and two decays.
#[test]
fn q21_matrix_pencil_recovers_known_exponentials() {
    let record = |t: f64| {
        1e-5 * ((0.4 * t).exp() * (69.0 * t + 0.3).cos() + 0.8 * (-9.0 * t).exp() * (75.0 * t).sin())
            + 1e-6 * ((-6.0 * t).exp() + (-40.0 * t).exp())
    };
    let samples: Vec<f64> = (0..100).map(|i| record(0.1 + 4e-3 * f64::from(i))).collect();
    let found = least_damped(&samples, 4e-3, [40.0, 110.0]);
    println!("Q-21 {found:?}");
    // truncation at the noise level shifts the remaining poles
    assert!((found.growth_1_s - 0.4).abs() < 1e-3 && (found.frequency_rad_s - 69.0).abs() < 1e-3, "{found:?}");
}
