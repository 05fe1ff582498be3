//! Small Cholesky factors over the strains of an element.

use crate::math::strain::{Strain, StrainMatrix};

/// Cholesky factor of a symmetric matrix given by its lower triangle, with inverted diagonal; `None` at a pivot that is not positive or not
/// finite.
#[inline]
pub(super) fn cholesky<const N: usize>(matrix: &StrainMatrix<N>) -> Option<StrainMatrix<N>> {
    let mut l = StrainMatrix::<N>::zeros();
    for j in 0..N {
        let mut pivot = matrix[(j, j)];
        for k in 0..j {
            pivot -= l[(j, k)] * l[(j, k)];
        }
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let inverse = 1.0 / pivot.sqrt();
        l[(j, j)] = inverse;
        for i in j + 1..N {
            let mut entry = matrix[(i, j)];
            for k in 0..j {
                entry -= l[(i, k)] * l[(j, k)];
            }
            l[(i, j)] = entry * inverse;
        }
    }
    Some(l)
}

/// Forward substitution `L⁻¹ b`.
#[inline]
pub(super) fn forward<const N: usize>(l: &StrainMatrix<N>, mut b: Strain<N>) -> Strain<N> {
    for i in 0..N {
        for k in 0..i {
            b[i] -= l[(i, k)] * b[k];
        }
        b[i] *= l[(i, i)];
    }
    b
}

/// Back substitution `L⁻ᵀ b`.
#[inline]
pub(super) fn back<const N: usize>(l: &StrainMatrix<N>, mut b: Strain<N>) -> Strain<N> {
    for i in (0..N).rev() {
        for k in i + 1..N {
            b[i] -= l[(k, i)] * b[k];
        }
        b[i] *= l[(i, i)];
    }
    b
}
