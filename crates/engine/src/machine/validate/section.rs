//! Checks of cross-sections: physically possible stiffnesses and inertias of a beam.

use crate::beam::section::Section;
use crate::machine::UNLIMITED;
use crate::math::strain::StrainMatrix;
use nalgebra::{Cholesky, Matrix3};

/// Asymmetry of a stiffness matrix that is treated as round-off, relative to its diagonal.
const SYMMETRY_TOLERANCE: f64 = 1e-9;

/// Smallest pivot of a stiffness matrix scaled to a unit diagonal, below which the matrix counts as singular.
const SMALLEST_PIVOT: f64 = 1e-10;

/// Violation of an inequality between moments of inertia that is treated as round-off, relative to the largest.
const INERTIA_TOLERANCE: f64 = 1e-9;

/// Whether the properties were computed from the dimensions without overflow or underflow.
pub fn is_sound(section: &Section) -> bool {
    let in_range = |value: f64| value > 0.0 && value <= UNLIMITED;
    let [yy, _, zz] = section.second_moment_kg_m;
    section.stiffness.diagonal().iter().copied().all(in_range) && in_range(section.mass_kg_m) && in_range(yy + zz)
}

/// The first entry below the diagonal, as row and column, that differs from the opposite entry by more than round-off.
pub fn asymmetry<const N: usize>(matrix: &StrainMatrix<N>) -> Option<(usize, usize)> {
    let scale = |i: usize, j: usize| matrix[(i, i)].abs().sqrt() * matrix[(j, j)].abs().sqrt();
    let entries = (0..N).flat_map(|i| (0..i).map(move |j| (i, j)));
    entries.into_iter().find(|&(i, j)| {
        let difference = (matrix[(i, j)] - matrix[(j, i)]).abs();
        difference > SYMMETRY_TOLERANCE * scale(i, j) || difference.is_nan()
    })
}

/// Whether a symmetric matrix, scaled to a unit diagonal, has pivots above `SMALLEST_PIVOT`.
pub fn is_positive_definite<const N: usize>(matrix: &StrainMatrix<N>) -> bool {
    let diagonal = matrix.diagonal();
    if !diagonal.iter().all(|entry| *entry > 0.0) {
        return false;
    }
    let scaled = StrainMatrix::<N>::from_fn(|i, j| matrix[(i, j)] / (diagonal[i].sqrt() * diagonal[j].sqrt()));
    Cholesky::new(scaled).is_some_and(|factor| factor.l().diagonal().iter().all(|pivot| pivot * pivot > SMALLEST_PIVOT))
}

/// Whether second moments of mass `[∫ρy² dA, ∫ρyz dA, ∫ρz² dA]` about a centre of mass are physically possible and not zero.
pub fn are_second_moments([yy, yz, zz]: [f64; 3]) -> bool {
    let semidefinite = yy >= 0.0 && zz >= 0.0 && yz.abs() <= (yy.sqrt() * zz.sqrt()) * (1.0 + 1e-9);
    semidefinite && yy + zz > 0.0
}

/// Whether the second moments of mass of a section about its axis are physically possible, to round-off of the shift from the centre of
/// mass.
pub(super) fn has_second_moments(section: &Section) -> bool {
    let (mass_kg_m, [y, z], [yy, yz, zz]) = (section.mass_kg_m, section.first_moment_kg, section.second_moment_kg_m);
    let forgiven = 1e-9 * (yy + zz);
    let about_centre = [yy - y * y / mass_kg_m, yz - y * z / mass_kg_m, zz - z * z / mass_kg_m];
    let [least_y, mixed, least_z] = about_centre;
    let product = (least_y.max(0.0) + forgiven).sqrt() * (least_z.max(0.0) + forgiven).sqrt();
    least_y >= -forgiven && least_z >= -forgiven && mixed.abs() <= product
}

/// Whether the principal moments of a finite tensor are non-negative and satisfy the triangle inequality.
pub(crate) fn is_rigid_body(tensor: &Matrix3<f64>) -> bool {
    let scale = tensor.amax();
    if scale == 0.0 {
        return true;
    }
    let moments = (tensor / scale).symmetric_eigenvalues();
    moments.min() >= -INERTIA_TOLERANCE && moments.max() <= 0.5 * moments.sum() + INERTIA_TOLERANCE
}

/// Whether the principal moments of a finite tensor are non-negative.
pub(crate) fn is_not_negative(tensor: &Matrix3<f64>) -> bool {
    let scale = tensor.amax();
    scale == 0.0 || (tensor / scale).symmetric_eigenvalues().min() >= -INERTIA_TOLERANCE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::strain::{FLAP, STRAINS, Strain, TWIST};

    #[test]
    fn definiteness_does_not_depend_on_units() {
        // A bend–twist coupling of 99 % of the geometric mean of the stiffnesses, which differ by eight decades.
        let mut matrix = StrainMatrix::from_diagonal(&Strain::<STRAINS>::new(1e9, 1e1, 2e1, 3e2));
        let coupling = 0.99 * (1e1_f64 * 2e1).sqrt();
        (matrix[(TWIST, FLAP)], matrix[(FLAP, TWIST)]) = (coupling, coupling);
        assert!(is_positive_definite(&matrix));
        (matrix[(TWIST, FLAP)], matrix[(FLAP, TWIST)]) = (coupling / 0.98, coupling / 0.98);
        assert!(!is_positive_definite(&matrix));
    }

    #[test]
    fn inertia_of_real_bodies_is_accepted() {
        for moments in [[0.0, 0.0, 0.0], [0.0, 2.0, 2.0], [1.0, 1.0, 2.0], [1e-30, 1e-30, 1e-30]] {
            assert!(is_rigid_body(&Matrix3::from_diagonal(&moments.into())), "{moments:?}");
        }
        for moments in [[1.0, 1.0, 2.1], [-1.0, 1.0, 1.0], [0.0, 0.0, 1.0]] {
            assert!(!is_rigid_body(&Matrix3::from_diagonal(&moments.into())), "{moments:?}");
        }
    }
}
