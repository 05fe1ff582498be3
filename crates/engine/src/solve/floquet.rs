//! Exponents of a motion about a periodic one, NOTATION eq. (L35).
//!
//! Multipliers fix frequencies up to multiples of the rotor's. Which multiple is meant follows from the motion over the turn, as in
//! Bottasso and Cacciola, *Model-independent periodic stability analysis of wind turbines*, Wind Energy 18 (2015).

use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// Share of the second harmonic over the first from which their order may be a matter of the coordinates.
const AMBIGUOUS: f64 = 0.5;

/// A frequency that a Floquet mode shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Multiple of the rotor's speed that is added to the principal exponent.
    pub number: i32,
    /// Share of the motion that goes with it; all add up to 1.
    pub share: f64,
    /// Imaginary part of the exponent with it, in rad/s, positive or 0.
    pub frequency_rad_s: f64,
}

/// A multiplier read over the motion that belongs to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolved {
    /// Exponent in 1/s with the harmonic of the largest share; its imaginary part is positive or 0.
    pub exponent_1_s: Complex<f64>,
    /// Harmonics, largest share first.
    pub harmonics: Vec<Harmonic>,
    /// Motion of the first harmonic: amplitudes of the coordinates.
    pub shape: DVector<Complex<f64>>,
}

impl Resolved {
    /// Whether the second harmonic has so large a share that the first is no more the frequency than it.
    pub fn is_ambiguous(&self) -> bool {
        self.harmonics.len() > 1 && self.harmonics[1].share > AMBIGUOUS * self.harmonics[0].share
    }
}

/// `ln μ / T` in 1/s with an imaginary part from `-π/T` to `π/T`; of a negative `μ` it is `π/T`.
pub fn principal_1_s(multiplier: Complex<f64>, period_s: f64) -> Complex<f64> {
    let angle = if multiplier.im == 0.0 { multiplier.arg().abs() } else { multiplier.arg() };
    Complex::new(multiplier.norm().ln(), angle) / period_s
}

/// Reads a multiplier over its motion: `motion[k]` are the coordinates, as the ground sees them, at the share `k/K` of the turn.
/// `weights` are the masses of the coordinates.
///
/// With `p(t) = u(t) e^{−λt}`, which has the period of the turn, the share of a harmonic is that of `Σ m |p_h|²`.
pub fn resolve(
    multiplier: Complex<f64>,
    period_s: f64,
    motion: &[DVector<Complex<f64>>],
    weights: &DVector<f64>,
) -> Resolved {
    let principal = principal_1_s(multiplier, period_s);
    let count = motion.len();
    let speed_rad_s = TAU / period_s;
    let still: Vec<DVector<Complex<f64>>> =
        motion.iter().enumerate().map(|(k, u)| u * (-principal * (period_s * k as f64 / count as f64)).exp()).collect();
    let half = (count as i32 - 1) / 2;
    let mut list: Vec<(Harmonic, DVector<Complex<f64>>)> = Vec::new();
    for number in -half..=half {
        let mut shape = DVector::<Complex<f64>>::zeros(weights.len());
        for (k, p) in still.iter().enumerate() {
            let turn = (i64::from(number) * k as i64).rem_euclid(count as i64) as f64 / count as f64;
            shape.axpy(Complex::from_polar(1.0 / count as f64, -TAU * turn), p, Complex::new(1.0, 0.0));
        }
        let share: f64 = shape.iter().zip(weights.iter()).map(|(x, weight)| weight * x.norm_sqr()).sum();
        let frequency_rad_s = principal.im + f64::from(number) * speed_rad_s;
        // a real motion shows a frequency with both signs
        let same = |known: &&mut (Harmonic, DVector<Complex<f64>>)| {
            multiplier.im == 0.0 && (known.0.frequency_rad_s - frequency_rad_s.abs()).abs() < 1e-9 * speed_rad_s
        };
        match list.iter_mut().find(same) {
            Some(known) => {
                known.0.share += share;
                (known.0.number, known.1) = (number, shape);
            }
            None => {
                let shape = if frequency_rad_s < 0.0 { shape.map(|x| x.conj()) } else { shape };
                list.push((Harmonic { number, share, frequency_rad_s: frequency_rad_s.abs() }, shape));
            }
        }
    }
    let sum: f64 = list.iter().map(|(harmonic, _)| harmonic.share).sum();
    if sum > 0.0 {
        list.iter_mut().for_each(|(harmonic, _)| harmonic.share /= sum);
    }
    list.sort_by(|a, b| b.0.share.total_cmp(&a.0.share));
    let shape = list.first().map_or_else(|| DVector::zeros(weights.len()), |(_, shape)| shape.clone());
    let harmonics: Vec<Harmonic> = list.into_iter().map(|(harmonic, _)| harmonic).collect();
    let frequency_rad_s = harmonics.first().map_or(principal.im, |harmonic| harmonic.frequency_rad_s);
    Resolved { exponent_1_s: Complex::new(principal.re, frequency_rad_s), harmonics, shape }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `u = (e^{λt}, ¼ e^{(λ + 2iΩ)t})` with `λ` at 3.3 Ω: the multiplier has lost the 3, the motion has it.
    #[test]
    fn the_motion_knows_the_frequency() {
        let (period_s, speed) = (2.0, std::f64::consts::PI);
        let lambda = Complex::new(-0.1, 3.3 * speed);
        let motion: Vec<DVector<Complex<f64>>> = (0..36)
            .map(|k| {
                let t = period_s * f64::from(k) / 36.0;
                let u = (lambda * t).exp();
                DVector::from_vec(vec![u, 0.25 * u * Complex::new(0.0, 2.0 * speed * t).exp()])
            })
            .collect();
        let weights = DVector::from_vec(vec![1.0, 1.0]);
        let read = resolve((lambda * period_s).exp(), period_s, &motion, &weights);
        assert!((read.exponent_1_s - lambda).norm() < 1e-10, "{}", read.exponent_1_s);
        assert!(!read.is_ambiguous() && read.harmonics[0].number == 3);
        assert!((read.harmonics[1].share * 17.0 - 1.0).abs() < 1e-10 && read.harmonics[1].number == 5);
        // a mode of 0.7 Ω that the multiplier shows as 0.3 Ω: the conjugate is meant
        let lambda = Complex::new(0.02, 0.7 * speed);
        let conjugate: Vec<DVector<Complex<f64>>> = (0..36)
            .map(|k| DVector::from_vec(vec![(lambda.conj() * (period_s * f64::from(k) / 36.0)).exp()]))
            .collect();
        let read = resolve((lambda.conj() * period_s).exp(), period_s, &conjugate, &DVector::from_vec(vec![1.0]));
        assert!((read.exponent_1_s - lambda).norm() < 1e-10, "{}", read.exponent_1_s);
    }

    /// A negative multiplier: half the speed and one and a half of it with both signs each.
    #[test]
    fn a_motion_of_two_turns() {
        let period_s = 1.5;
        let motion: Vec<DVector<Complex<f64>>> = (0..24)
            .map(|k| {
                let angle = TAU * f64::from(k) / 24.0;
                let value = (1.5 * angle).cos() + 0.3 * (0.5 * angle).sin();
                DVector::from_vec(vec![Complex::new(value * (0.2 * angle / TAU).exp(), 0.0)])
            })
            .collect();
        let read = resolve(Complex::new(-(0.2f64.exp()), 0.0), period_s, &motion, &DVector::from_vec(vec![2.0]));
        assert!((read.exponent_1_s - Complex::new(0.2, 1.5 * TAU) / period_s).norm() < 1e-10, "{}", read.exponent_1_s);
        assert!((read.harmonics[0].share - 1.0 / 1.09).abs() < 1e-10, "{:?}", read.harmonics[0]);
    }
}
