//! Contributions to the elimination of an element other than the inertia at its outer node: by the outer half of a pair, by bodies that slide
//! along it; NOTATION eqs. (D14), (J14).

use crate::math::strain::{Strain, StrainMatrix};
use crate::multibody::cholesky::{back, forward};
use crate::multibody::model::{Element, Strained};
use crate::multibody::node::ElementFactor;
use crate::multibody::slide::Coupling;
use nalgebra::Vector3;
use std::array::from_fn;

/// Contributions of an eliminated outer half to the inner half, and inertial coupling of the outer node with the strains.
pub(super) struct Carried<const N: usize> {
    /// Coupling of the outer node with the strains, velocity rows.
    pub velocity: [Vector3<f64>; N],
    /// Coupling of the outer node with the strains, spin rows.
    pub spin: [Vector3<f64>; N],
    /// Change of the diagonal block of the strains.
    pub block: StrainMatrix<N>,
}

impl<const N: usize> Carried<N>
where
    Element: Strained<N>,
{
    /// Computes `G = −U X⁻¹ D_BA`, `ΔD = −D_AB X⁻¹ D_BA`, eq. (D14).
    pub fn new(factor: &ElementFactor<N>) -> Self {
        let coupling = &factor.coupling;
        let solved: [Strain<N>; N] =
            from_fn(|j| back(&factor.cholesky, forward(&factor.cholesky, coupling.column(j).into_owned())));
        let solved = StrainMatrix::from_columns(&solved);
        Self {
            velocity: combine(&factor.velocity, &solved, -1.0),
            spin: combine(&factor.spin, &solved, -1.0),
            block: -(coupling.transpose() * solved),
        }
    }

    /// No contributions.
    pub const NONE: Self = Self {
        velocity: [Vector3::new(0.0, 0.0, 0.0); N],
        spin: [Vector3::new(0.0, 0.0, 0.0); N],
        block: StrainMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; N]; N])),
    };

    /// Adds the coupling by bodies that slide along the element, eq. (J14).
    pub fn add(&mut self, riders: &Coupling<N>) {
        for j in 0..N {
            self.velocity[j] += riders.velocity[j];
            self.spin[j] += riders.spin[j];
        }
        self.block += riders.block;
    }
}

#[inline]
fn combine<const N: usize>(columns: &[Vector3<f64>; N], weights: &StrainMatrix<N>, sign: f64) -> [Vector3<f64>; N] {
    from_fn(|j| {
        let mut sum = columns[0] * weights[(0, j)];
        for i in 1..N {
            sum += columns[i] * weights[(i, j)];
        }
        sum * sign
    })
}
