//! Floquet exponents of perturbations of a periodic motion, NOTATION eq. (L35).
//!
//! Multipliers determine frequencies only up to multiples of the rotor speed. The multiple follows from the motion over the revolution, as
//! in Bottasso and Cacciola, *Model-independent periodic stability analysis of wind turbines*, Wind Energy 18 (2015).

use nalgebra::{Complex, DMatrix, DVector, Dyn, SymmetricEigen};
use std::f64::consts::TAU;

/// Participation of the second harmonic, relative to the first, above which their order may depend on the choice of coordinates.
const AMBIGUOUS: f64 = 0.5;

/// A frequency in the response of a Floquet mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Multiple of the rotor speed that is added to the principal exponent.
    pub number: i32,
    /// Participation in the motion; the sum over all harmonics is 1.
    pub share: f64,
    /// Magnitude of the imaginary part of the exponent with this multiple, in rad/s.
    pub frequency_rad_s: f64,
}

/// A multiplier with its frequency, determined from its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolved {
    /// Floquet exponent in 1/s, with i·n·Ω added for the harmonic n of largest participation; the sign is chosen so that the imaginary part
    /// is >= 0.
    pub exponent_1_s: Complex<f64>,
    /// Harmonics, largest participation first.
    pub harmonics: Vec<Harmonic>,
    /// Motion of the first harmonic: complex amplitudes of the coordinates.
    pub shape: DVector<Complex<f64>>,
}

impl Resolved {
    /// Whether the participations of two harmonics are so close that neither can be called the frequency of the mode.
    pub fn is_ambiguous(&self) -> bool {
        self.harmonics.len() > 1 && self.harmonics[1].share > AMBIGUOUS * self.harmonics[0].share
    }
}

/// Principal exponent `ln μ / T` in 1/s, with an imaginary part from `-π/T` to `π/T`; `π/T` for a negative `μ`.
pub fn principal_1_s(multiplier: Complex<f64>, period_s: f64) -> Complex<f64> {
    let angle = if multiplier.im == 0.0 { multiplier.arg().abs() } else { multiplier.arg() };
    Complex::new(multiplier.norm().ln(), angle) / period_s
}

/// Determines the exponent of a multiplier from its motion: `motion[k]` are the coordinates, in the fixed frame, at the fraction `k/K` of
/// the revolution. `weights` are the masses of the coordinates.
///
/// With `p(t) = u(t) e^{−λt}`, which is periodic over the revolution, a harmonic `h` participates in proportion to `Σ m |p_h|²`.
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
        // the spectrum of a real motion is symmetric: each frequency occurs with both signs
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

/// Combinations of motions with a common multiplier, each with the largest possible participation of one harmonic, eq. (L35): the computed
/// modes of uncoupled blades are arbitrary mixtures of collective and whirling motions. `motions[i][k]` are the coordinates of the motion
/// `i` at the fraction `k/K` of the revolution.
///
/// The first combination maximises the participation of a harmonic over all combinations and harmonics, the next over those orthogonal to
/// it in the mean square, and so on. Linearly dependent motions are returned unchanged.
pub fn separate(
    multiplier: Complex<f64>,
    period_s: f64,
    motions: &[Vec<DVector<Complex<f64>>>],
    weights: &DVector<f64>,
) -> Vec<DVector<Complex<f64>>> {
    let m = motions.len();
    let as_they_are =
        || (0..m).map(|i| DVector::from_fn(m, |j, _| Complex::from(f64::from(u8::from(i == j))))).collect();
    let principal = principal_1_s(multiplier, period_s);
    let count = motions.first().map_or(0, Vec::len);
    let half = (count as i32 - 1) / 2;
    let shares: Vec<DMatrix<Complex<f64>>> = (-half..=half)
        .map(|number| {
            let mut shapes = DMatrix::<Complex<f64>>::zeros(weights.len(), m);
            for (i, motion) in motions.iter().enumerate() {
                for (k, u) in motion.iter().enumerate() {
                    let turn = (i64::from(number) * k as i64).rem_euclid(count as i64) as f64 / count as f64;
                    let still = (-principal * (period_s * k as f64 / count as f64)).exp();
                    let factor = still * Complex::from_polar(1.0 / count as f64, -TAU * turn);
                    shapes.column_mut(i).axpy(factor, u, Complex::new(1.0, 0.0));
                }
            }
            let weighted = DMatrix::from_fn(weights.len(), m, |row, i| shapes[(row, i)] * weights[row]);
            shapes.adjoint() * weighted
        })
        .collect();
    let whole = shares.iter().fold(DMatrix::zeros(m, m), |sum: DMatrix<Complex<f64>>, share| sum + share);
    let Some(factor) = whole.cholesky() else { return as_they_are() };
    let Some(mut basis) = factor.l().adjoint().try_inverse() else { return as_they_are() };
    let mut found = Vec::new();
    while basis.ncols() > 0 {
        let of = |share: &DMatrix<Complex<f64>>| (basis.adjoint() * share * &basis).symmetric_eigen();
        let largest = |eigen: &SymmetricEigen<Complex<f64>, Dyn>| eigen.eigenvalues.max();
        let Some(best) = shares.iter().map(of).max_by(|a, b| largest(a).total_cmp(&largest(b))) else { break };
        let place = best.eigenvalues.imax();
        found.push(&basis * best.eigenvectors.column(place));
        let rest = best.eigenvectors.remove_column(place);
        basis = &basis * rest;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `u = (e^{λt}, ¼ e^{(λ + 2iΩ)t})` with `λ` at 3.3 Ω: the multiplier does not contain the multiple 3, which follows from the motion.
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
        // a mode of 0.7 Ω appears as 0.3 Ω in the multiplier: its conjugate is the one to resolve
        let lambda = Complex::new(0.02, 0.7 * speed);
        let conjugate: Vec<DVector<Complex<f64>>> = (0..36)
            .map(|k| DVector::from_vec(vec![(lambda.conj() * (period_s * f64::from(k) / 36.0)).exp()]))
            .collect();
        let read = resolve((lambda.conj() * period_s).exp(), period_s, &conjugate, &DVector::from_vec(vec![1.0]));
        assert!((read.exponent_1_s - lambda).norm() < 1e-10, "{}", read.exponent_1_s);
    }

    /// The motion of a real multiplier has each harmonic with both signs, whose participations add up; the harmonic 0 occurs once.
    /// `e^{−0.1t}(1 + cos Ωt)`: mean squares 1 and ½. With a negative multiplier, `e^{−0.1t}(cos ½Ωt + ½ cos (3/2)Ωt)`: ½ and ⅛.
    #[test]
    fn shares_of_both_signs_add_up_for_real_multipliers() {
        let (period_s, speed) = (2.0, std::f64::consts::PI);
        let of = |motion: &dyn Fn(f64) -> f64, sign: f64| {
            let value = |k: i32| {
                let t = period_s * f64::from(k) / 36.0;
                DVector::from_vec(vec![Complex::from((-0.1 * t).exp() * motion(t))])
            };
            let motion: Vec<DVector<Complex<f64>>> = (0..36).map(value).collect();
            let multiplier = Complex::from(sign * (-0.1 * period_s).exp());
            resolve(multiplier, period_s, &motion, &DVector::from_vec(vec![1.0])).harmonics
        };
        for (harmonics, expected) in [
            (of(&|t| 1.0 + (speed * t).cos(), 1.0), [(0.0, 2.0 / 3.0), (speed, 1.0 / 3.0)]),
            (
                of(&|t| (0.5 * speed * t).cos() + 0.5 * (1.5 * speed * t).cos(), -1.0),
                [(0.5 * speed, 0.8), (1.5 * speed, 0.2)],
            ),
        ] {
            for (found, (frequency_rad_s, share)) in harmonics.iter().zip(expected) {
                assert!((found.frequency_rad_s - frequency_rad_s).abs() < 1e-9, "{harmonics:?}");
                assert!((found.share - share).abs() < 1e-10, "{harmonics:?}");
            }
        }
    }

    /// Three mixed motions with one multiplier, at 2.3, 3.3 and 4.3 Ω: each is recovered with its frequency.
    #[test]
    fn mixed_motions_are_separated() {
        let (period_s, speed) = (2.0, std::f64::consts::PI);
        let lambda = Complex::new(-0.1, 3.3 * speed);
        let pure = |coordinate: usize, harmonic: f64| -> Vec<DVector<Complex<f64>>> {
            let value =
                |k: i32| ((lambda + Complex::new(0.0, harmonic * speed)) * (period_s * f64::from(k) / 36.0)).exp();
            (0..36)
                .map(|k| DVector::from_fn(3, |i, _| if i == coordinate { value(k) } else { Complex::from(0.0) }))
                .collect()
        };
        let motions = [pure(0, -1.0), pure(1, 0.0), pure(2, 1.0)];
        let mixture = [[1.0, 0.4, -0.3], [0.2, -1.0, 0.5], [0.7, 0.6, 1.0]];
        let mixed: Vec<Vec<DVector<Complex<f64>>>> = mixture
            .iter()
            .map(|row| (0..36).map(|k| (0..3).map(|i| &motions[i][k] * Complex::from(row[i])).sum()).collect())
            .collect();
        let weights = DVector::from_vec(vec![1.0, 2.0, 3.0]);
        let multiplier = (lambda * period_s).exp();
        let mut frequencies: Vec<f64> = separate(multiplier, period_s, &mixed, &weights)
            .iter()
            .map(|amounts| {
                let sum: Vec<DVector<Complex<f64>>> =
                    (0..36).map(|k| (0..3).map(|i| &mixed[i][k] * amounts[i]).sum()).collect();
                let read = resolve(multiplier, period_s, &sum, &weights);
                assert!(read.harmonics[0].share > 1.0 - 1e-9, "{:?}", read.harmonics[0]);
                read.exponent_1_s.im / speed
            })
            .collect();
        frequencies.sort_by(f64::total_cmp);
        assert!(frequencies.iter().zip([2.3, 3.3, 4.3]).all(|(a, b)| (a - b).abs() < 1e-9), "{frequencies:?}");
    }

    /// A negative multiplier: harmonics at ½ and 3/2 of the rotor speed, each with both signs.
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
