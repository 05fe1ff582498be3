//! Discrete Fourier transform for a number of points that is a power of two.

use std::f64::consts::TAU;

/// Computes `x_n = Σ_m X_m exp(2πi m n/N)` in place, for real and imaginary parts; the number of points must be a power of two.
///
/// # Panics
/// If the number of points is not a power of two, or the parts differ in length.
pub fn inverse(real: &mut [f64], imaginary: &mut [f64]) {
    let points = real.len();
    assert!(points.is_power_of_two() && imaginary.len() == points, "{points} points, a power of two is needed");
    let bits = points.trailing_zeros();
    for i in 0..points {
        let j = i.reverse_bits().checked_shr(usize::BITS - bits).unwrap_or(0);
        if i < j {
            real.swap(i, j);
            imaginary.swap(i, j);
        }
    }
    let mut half = 1;
    while half < points {
        let step = TAU / (2 * half) as f64;
        for k in 0..half {
            let (sine, cosine) = (step * k as f64).sin_cos();
            for start in (k..points).step_by(2 * half) {
                let other = start + half;
                let x = real[other] * cosine - imaginary[other] * sine;
                let y = real[other] * sine + imaginary[other] * cosine;
                (real[other], imaginary[other]) = (real[start] - x, imaginary[start] - y);
                real[start] += x;
                imaginary[start] += y;
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transform_is_its_sum() {
        for points in [1usize, 2, 4, 16, 32] {
            let start = |i: usize| ((i * i) as f64 * 0.37).sin();
            let (mut real, mut imaginary): (Vec<f64>, Vec<f64>) = (0..points).map(|i| (start(i), start(i + 7))).unzip();
            let (a, b) = (real.clone(), imaginary.clone());
            inverse(&mut real, &mut imaginary);
            for n in 0..points {
                let mut sum = [0.0; 2];
                for m in 0..points {
                    let (s, c) = (TAU * (m * n) as f64 / points as f64).sin_cos();
                    sum[0] += a[m] * c - b[m] * s;
                    sum[1] += a[m] * s + b[m] * c;
                }
                assert!((sum[0] - real[n]).abs() + (sum[1] - imaginary[n]).abs() < 1e-12, "{points} {n}");
            }
        }
    }
}
