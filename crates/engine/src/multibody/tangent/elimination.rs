//! Elimination of the unknowns of one element, pair, joint or modal body by a small LU factorisation; NOTATION eq. (L5).

use crate::multibody::tangent::block::{Block, UNKNOWNS, Unknowns};
use nalgebra::{Const, DMatrix, DimMin, LU, Matrix6, SMatrix};

/// Smallest pivot of a scaled block, below which the block counts as singular.
const SMALLEST_PIVOT: f64 = 1e-13;

/// Factor of one elimination.
#[derive(Debug, Clone)]
pub(super) struct Factor<const U: usize = UNKNOWNS>
where
    Const<U>: DimMin<Const<U>, Output = Const<U>>,
{
    lu: LU<f64, Const<U>, Const<U>>,
    /// Scales of the unknowns: inverse square roots of the pivots' magnitudes; 1 for unused entries.
    pub(super) scale: Unknowns<U>,
    /// Number of negative eigenvalues of the symmetric part of the pivot block.
    pub(super) negative: usize,
    pub(super) xa: SMatrix<f64, U, 6>,
    pub(super) ax: SMatrix<f64, 6, U>,
    /// Right-hand side of the last inward sweep.
    pub(super) right: Unknowns<U>,
}

impl<const U: usize> Factor<U>
where
    Const<U>: DimMin<Const<U>, Output = Const<U>>,
{
    /// Eliminates the first `count` unknowns; returns the tangent at the inner node. `sizes` scale the pivots.
    pub(super) fn new(mut block: Block<U>, sizes: &[f64; U], count: usize) -> Option<(Self, Matrix6<f64>)> {
        let mut scale = Unknowns::<U>::from_element(1.0);
        for k in 0..U {
            if k >= count {
                block.xx[(k, k)] = 1.0;
            } else if sizes[k] > 0.0 && sizes[k].is_finite() {
                scale[k] = 1.0 / sizes[k].sqrt();
            } else {
                return None;
            }
        }
        let scaled = SMatrix::<f64, U, U>::from_fn(|i, j| block.xx[(i, j)] * scale[i] * scale[j]);
        let negative = negative_eigenvalues(&scaled);
        let lu = scaled.lu();
        let upper = lu.u();
        // a NaN pivot fails the comparison as well
        if !(0..U).all(|k| upper[(k, k)].abs() > SMALLEST_PIVOT) {
            return None;
        }
        let mut factor = Self { lu, scale, negative, xa: block.xa, ax: block.ax, right: Unknowns::<U>::zeros() };
        let mut passed = block.aa;
        for j in 0..6 {
            let solved = factor.solve(&factor.xa.column(j).into_owned());
            let mut column = passed.column_mut(j);
            column -= factor.ax * solved;
        }
        factor.right.fill(0.0);
        Some((factor, passed))
    }

    /// Solution for a right-hand side.
    pub(super) fn solve(&self, right: &Unknowns<U>) -> Unknowns<U> {
        let mut x = right.component_mul(&self.scale);
        self.lu.solve_mut(&mut x);
        x.component_mul(&self.scale)
    }
}

/// Number of negative eigenvalues of the symmetric part; it is almost always zero, which a Cholesky factorisation confirms.
fn negative_eigenvalues<const U: usize>(block: &SMatrix<f64, U, U>) -> usize {
    let symmetric = (block + block.transpose()) * 0.5;
    if nalgebra::Cholesky::new(symmetric).is_some() {
        return 0;
    }
    DMatrix::from_column_slice(U, U, symmetric.as_slice())
        .symmetric_eigenvalues()
        .iter()
        .filter(|value| **value < 0.0)
        .count()
}
