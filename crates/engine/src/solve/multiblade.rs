//! Multi-blade (Coleman) transformation of a rotor's equations of motion and the resulting whirl, NOTATION eqs. (L25) and (L26).
//!
//! Coleman and Feingold, *Theory of self-excited mechanical oscillations of helicopter rotors with hinged blades*, NACA Report
//! 1351 (1958); Hansen, *Improved modal dynamics of wind turbines to avoid stall-induced vibrations*, Wind Energy 6 (2003).

use crate::solve::linearize::SecondOrder;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// Difference of the participations of two opposite whirls, relative to their sum, below which the motion is a standing wave: neither
/// direction dominates.
const STANDING: f64 = 0.1;

/// Relative motion of equal blades in the fixed frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Whirl {
    /// All blades in phase.
    Collective,
    /// A wave that travels in the direction of rotation, with this number of waves around the rotor.
    Forward(usize),
    /// A wave that travels against the direction of rotation.
    Backward(usize),
    /// A standing wave.
    Standing(usize),
    /// Neighbouring blades in opposition, for an even number of blades.
    Differential,
}

impl std::fmt::Display for Whirl {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (word, waves) = match self {
            Self::Collective => ("collective", 1),
            Self::Differential => ("differential", 1),
            Self::Forward(waves) => ("forward", *waves),
            Self::Backward(waves) => ("backward", *waves),
            Self::Standing(waves) => ("standing", *waves),
        };
        if waves == 1 { f.write_str(word) } else { write!(f, "{word} ({waves} waves)") }
    }
}

/// Coordinates of equal blades, evenly spaced around the shaft.
#[derive(Debug, Clone, PartialEq)]
pub struct Multiblade {
    /// Coordinates of every blade, in the same order for all blades; each blade leads the previous one in azimuth.
    pub blades: Vec<Vec<usize>>,
}

impl Multiblade {
    /// `T`, `dT/dψ` and `d²T/dψ²` of eq. (L25) for `n` coordinates, with the first blade at `azimuth_rad`.
    fn matrices(&self, n: usize, azimuth_rad: f64) -> [DMatrix<f64>; 3] {
        let mut matrices = [DMatrix::identity(n, n), DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
        let count = self.blades.len();
        for (k, blade) in self.blades.iter().enumerate() {
            let azimuth_rad = azimuth_rad + TAU * k as f64 / count as f64;
            for (j, &row) in blade.iter().enumerate() {
                for (component, of) in self.blades.iter().enumerate() {
                    let values = entries(component, count, k, azimuth_rad);
                    for (matrix, value) in matrices.iter_mut().zip(values) {
                        matrix[(row, of[j])] = value;
                    }
                }
            }
        }
        matrices
    }

    /// Equations for the multi-blade components, eq. (L25): `M`, `C`, `K` are the matrices with the first blade at `azimuth_rad`, on a
    /// shaft that rotates at `speed_rad_s`. For an isotropic rotor the result does not depend on the azimuth.
    pub fn transform(&self, system: &SecondOrder, azimuth_rad: f64, speed_rad_s: f64) -> SecondOrder {
        let SecondOrder { mass, damping, stiffness } = system;
        let [t, first, second] = self.matrices(mass.nrows(), azimuth_rad);
        let transposed = t.transpose();
        SecondOrder {
            mass: &transposed * mass * &t,
            damping: &transposed * (damping * &t + mass * &first * (2.0 * speed_rad_s)),
            stiffness: &transposed
                * (stiffness * &t + damping * &first * speed_rad_s + mass * &second * (speed_rad_s * speed_rad_s)),
        }
    }

    /// Shift in 1/s² that makes the transformed stiffness positive, relative to the mass: `n²Ω²` of the blades' shortest wave, plus three
    /// times that for gyroscopic forces.
    pub fn shift_1_s2(&self, speed_rad_s: f64) -> f64 {
        let waves = (self.blades.len().saturating_sub(1) / 2) as f64;
        4.0 * (waves * speed_rad_s).powi(2)
    }

    /// Coordinates at an azimuth, from the multi-blade components.
    pub fn coordinates(&self, components: &DVector<Complex<f64>>, azimuth_rad: f64) -> DVector<Complex<f64>> {
        let [t, ..] = self.matrices(components.len(), azimuth_rad);
        t.map(|x| Complex::new(x, 0.0)) * components
    }

    /// Multi-blade components of the coordinates at an azimuth: the inverse of [`Multiblade::coordinates`].
    pub fn components(&self, coordinates: &DVector<Complex<f64>>, azimuth_rad: f64) -> DVector<Complex<f64>> {
        let mut components = coordinates.clone();
        let count = self.blades.len();
        for component in 0..count {
            let alone = component == 0 || component + 1 == count && count.is_multiple_of(2);
            let weight = if alone { 1.0 } else { 2.0 } / count as f64;
            for (j, &row) in self.blades[component].iter().enumerate() {
                let of_blade = |(k, blade): (usize, &Vec<usize>)| {
                    let [entry, ..] = entries(component, count, k, azimuth_rad + TAU * k as f64 / count as f64);
                    coordinates[blade[j]] * (weight * entry)
                };
                components[row] = self.blades.iter().enumerate().map(of_blade).sum();
            }
        }
        components
    }

    /// Participation of each motion in a mode, eq. (L26): coordinate of the first blade or of another part, whirl of the blades, and
    /// fraction of `Σ m |z|²` with the diagonal of the transformed mass; the fractions add up to 1. Forward is the direction of rotation of
    /// the rotor at `speed_rad_s`.
    pub fn shares(
        &self,
        shape: &DVector<Complex<f64>>,
        mass: &DMatrix<f64>,
        speed_rad_s: f64,
    ) -> Vec<(usize, Option<Whirl>, f64)> {
        let count = self.blades.len();
        let size = |i: usize| mass[(i, i)] * shape[i].norm_sqr();
        let mut list: Vec<(usize, Option<Whirl>, f64)> = (0..shape.len())
            .filter(|i| !self.blades.iter().any(|blade| blade.contains(i)))
            .map(|i| (i, None, size(i)))
            .collect();
        let blades = self.blades.first().map_or(0, Vec::len);
        for j in 0..blades {
            let at = |component: usize| self.blades[component][j];
            list.push((at(0), Some(Whirl::Collective), size(at(0))));
            for waves in 1..=(count - 1) / 2 {
                let (cosine, sine) = (at(2 * waves - 1), at(2 * waves));
                let weight = 0.5 * mass[(cosine, cosine)];
                let turned = Complex::new(0.0, 1.0_f64.copysign(speed_rad_s)) * shape[sine];
                let forward = weight * (shape[cosine] + turned).norm_sqr();
                let backward = weight * (shape[cosine] - turned).norm_sqr();
                if (forward - backward).abs() <= STANDING * (forward + backward) {
                    list.push((at(0), Some(Whirl::Standing(waves)), forward + backward));
                } else {
                    list.push((at(0), Some(Whirl::Forward(waves)), forward));
                    list.push((at(0), Some(Whirl::Backward(waves)), backward));
                }
            }
            if count.is_multiple_of(2) {
                list.push((at(0), Some(Whirl::Differential), size(at(count - 1))));
            }
        }
        let sum: f64 = list.iter().map(|(.., share)| share).sum();
        if sum > 0.0 {
            list.iter_mut().for_each(|(.., share)| *share /= sum);
        }
        list
    }
}

/// Entry of a blade (counted from 0) and component in `T` and its derivatives: one, alternating cosines and sines, and for an even number
/// of blades the alternating sign.
fn entries(component: usize, blades: usize, blade: usize, azimuth_rad: f64) -> [f64; 3] {
    if component == 0 {
        return [1.0, 0.0, 0.0];
    }
    if component + 1 == blades && blades.is_multiple_of(2) {
        return [if blade.is_multiple_of(2) { 1.0 } else { -1.0 }, 0.0, 0.0];
    }
    let waves = component.div_ceil(2) as f64;
    let (sine, cosine) = (waves * azimuth_rad).sin_cos();
    match component % 2 {
        1 => [cosine, -waves * sine, -waves * waves * cosine],
        _ => [sine, waves * cosine, -waves * waves * sine],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::modes::modes_beyond;

    /// Uncoupled blades fixed to the hub, `q̈ + 2ζω q̇ + ω² q = 0`: in the fixed frame each wave has the eigenvalues `λ ± i n Ω` and the
    /// corresponding whirl, for any number of blades.
    #[test]
    fn separate_blades_whirl_at_their_frequency_and_the_speed() {
        let (speed, omega, zeta) = (0.7, 3.0, 0.02);
        for count in 2..=6usize {
            let rotor = Multiblade { blades: (0..count).map(|k| vec![k]).collect() };
            let of = |value: f64| DMatrix::from_diagonal_element(count, count, value);
            let system =
                SecondOrder { mass: of(2.0), damping: of(4.0 * zeta * omega), stiffness: of(2.0 * omega * omega) };
            for azimuth in [0.0, 0.4, 2.0] {
                let seen = rotor.transform(&system, azimuth, speed);
                let matrices = [&seen.mass, &seen.damping, &seen.stiffness];
                let modes = modes_beyond(matrices, count, rotor.shift_1_s2(speed)).unwrap();
                assert_eq!(modes.len(), count);
                let (re, im) = (-zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
                for mode in modes {
                    let shares = rotor.shares(&mode.shape, &seen.mass, speed);
                    let (_, whirl, share) = shares.iter().max_by(|a, b| a.2.total_cmp(&b.2)).unwrap();
                    let travel = match whirl.unwrap() {
                        Whirl::Collective | Whirl::Differential => 0.0,
                        Whirl::Forward(waves) => waves as f64,
                        Whirl::Backward(waves) => -(waves as f64),
                        Whirl::Standing(_) => panic!("a standing motion of a rotor that turns"),
                    };
                    // whirls have distinct frequencies, so that each mode is pure; collective and differential modes have equal ones
                    assert!(travel == 0.0 || *share > 1.0 - 1e-9, "{count} blades: {shares:?}");
                    let expected = Complex::new(re, im + travel * speed);
                    assert!(
                        (mode.eigenvalue_1_s - expected).norm() < 1e-9,
                        "{count} blades: {} {whirl:?}",
                        mode.eigenvalue_1_s
                    );
                }
            }
        }
    }

    /// The transformation and its inverse are consistent with the dynamics: `q = T z` satisfies the equations of the coordinates.
    #[test]
    fn components_give_back_the_motion_of_the_blades() {
        let rotor = Multiblade { blades: vec![vec![1], vec![2], vec![3]] };
        let z = DVector::from_vec([5.0, 1.0, 2.0, -3.0].map(|x| Complex::new(x, 0.5)).to_vec());
        let q = rotor.coordinates(&z, 0.3);
        assert_eq!(q[0], z[0]);
        for count in 1..=6usize {
            let rotor = Multiblade { blades: (0..count).map(|k| vec![k, count + k]).collect() };
            let z = DVector::from_fn(2 * count, |i, _| Complex::new(i as f64 - 1.5, 0.3 * i as f64));
            let back = rotor.components(&rotor.coordinates(&z, 0.9), 0.9);
            assert!((back - z).norm() < 1e-13, "{count} blades");
        }
        // sums of numbers of magnitude 5 lose a few of their last bits, 9e-16 each
        let sum: Complex<f64> = q.rows(1, 3).iter().sum();
        assert!((sum / 3.0 - z[1]).norm() < 1e-14);
        let cosines: Complex<f64> = (0..3).map(|k| q[1 + k] * (0.3 + TAU * k as f64 / 3.0).cos()).sum();
        assert!((cosines * (2.0 / 3.0) - z[2]).norm() < 1e-14);
    }
}
