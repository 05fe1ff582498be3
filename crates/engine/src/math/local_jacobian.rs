//! Jacobian of one constant-strain link in its inner frame, NOTATION eqs. (K3), (K4).

use crate::math::local_link::{LocalLinks, matrix, vector};
use crate::math::se3::Link;
use crate::math::strain::{SHEAR_Y, SHEARED, STRETCH, TWIST};
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;

/// Jacobian of one link in its inner frame, which projects a wrench at the outer end onto the strains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalJacobian {
    /// Vector from the inner to the outer end in m.
    pub arm_m: Vector3<f64>,
    /// Rotation matrix whose columns are the axes of the outer frame.
    pub rotation: Matrix3<f64>,
    /// Tangent `V`: rotation of the outer end per curvature and length.
    pub tangent: Matrix3<f64>,
    /// `∂(V n)/∂Θ` in m, without shear `a ∂u/∂Θ`.
    pub slope_m: Matrix3<f64>,
}

impl LocalJacobian {
    /// Extracts one of the links computed together.
    #[inline(always)]
    pub fn of(links: &LocalLinks, lane: usize) -> Self {
        Self {
            arm_m: vector(&links.arm_m, lane),
            rotation: matrix(&links.rotation, lane),
            tangent: matrix(&links.tangent, lane),
            slope_m: matrix(&links.slope_m, lane),
        }
    }

    /// Generalised forces `Jᵀ (F, M)` for a wrench at the outer end, in the inner frame: N·m and N·m².
    #[inline(always)]
    pub fn project<const N: usize>(
        &self,
        length_m: f64,
        force_n: &Vector3<f64>,
        moment_n_m: &Vector3<f64>,
    ) -> [f64; N] {
        let column = |matrix: &Matrix3<f64>, j: usize, vector: &Vector3<f64>| {
            matrix[(0, j)] * vector.x + matrix[(1, j)] * vector.y + matrix[(2, j)] * vector.z
        };
        let bend = |j: usize| length_m * (column(&self.slope_m, j, force_n) + column(&self.tangent, j, moment_n_m));
        let shift = |j: usize| length_m * column(&self.tangent, j, force_n);
        from_fn(|strain| match strain {
            STRETCH => shift(0),
            SHEAR_Y.. => shift(strain - SHEAR_Y + 1),
            TWIST.. => bend(strain - TWIST),
        })
    }

    /// Product `J ε`: displacement in m and rotation in rad of the outer end for a change of the strains, in the inner frame.
    #[inline(always)]
    pub fn push<const N: usize>(&self, length_m: f64, strain: &[f64; N]) -> (Vector3<f64>, Vector3<f64>) {
        let change = strain.map(|strain| strain * length_m);
        let column = |matrix: &Matrix3<f64>, j: usize| matrix.fixed_view::<3, 1>(0, j).into_owned();
        let sum = |m: &Matrix3<f64>| {
            column(m, 0) * change[TWIST] + column(m, 1) * change[TWIST + 1] + column(m, 2) * change[TWIST + 2]
        };
        let mut linear = column(&self.tangent, 0) * change[STRETCH] + sum(&self.slope_m);
        if N == SHEARED {
            linear += column(&self.tangent, 1) * change[SHEAR_Y] + column(&self.tangent, 2) * change[SHEAR_Y + 1];
        }
        (linear, sum(&self.tangent))
    }

    /// Rotates the link into the world frame, with the inner frame `inner` (world ← a).
    #[inline(always)]
    pub fn turned<const N: usize>(&self, inner: &Matrix3<f64>, length_m: f64) -> Link<N> {
        let spin = inner * self.tangent * length_m;
        let bend = inner * self.slope_m * length_m;
        let column = |matrix: &Matrix3<f64>, j: usize| matrix.fixed_view::<3, 1>(0, j).into_owned();
        let spin_columns = [column(&spin, 0), column(&spin, 1), column(&spin, 2)];
        Link {
            arm_m: inner * self.arm_m,
            rotation: inner * self.rotation,
            velocity: from_fn(|strain| match strain {
                STRETCH => spin_columns[0],
                SHEAR_Y.. => spin_columns[strain - SHEAR_Y + 1],
                TWIST.. => column(&bend, strain - TWIST),
            }),
            spin: spin_columns,
        }
    }
}
