//! The Jacobian of one constant-strain link in its inner frame, NOTATION eqs. (K3), (K4).

use crate::math::local_link::{LocalLinks, matrix, vector};
use crate::math::se3::Link;
use nalgebra::{Matrix3, Vector3};

/// Jacobian of one link in its inner frame: projects a wrench at its outer end on its strains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalJacobian {
    /// Inner to outer end in m.
    pub arm_m: Vector3<f64>,
    /// Outer frame's axes.
    pub rotation: Matrix3<f64>,
    /// `V`.
    pub tangent: Matrix3<f64>,
    /// `a ∂u/∂Θ` in m.
    pub slope_m: Matrix3<f64>,
}

impl LocalJacobian {
    /// One of some links.
    #[inline(always)]
    pub fn of(links: &LocalLinks, lane: usize) -> Self {
        Self {
            arm_m: vector(&links.arm_m, lane),
            rotation: matrix(&links.rotation, lane),
            tangent: matrix(&links.tangent, lane),
            slope_m: matrix(&links.slope_m, lane),
        }
    }

    /// `Jᵀ (F, M)` for a wrench at the outer end, in the inner frame: N·m and N·m².
    #[inline(always)]
    pub fn project(&self, length_m: f64, force_n: &Vector3<f64>, moment_n_m: &Vector3<f64>) -> [f64; 4] {
        let column = |matrix: &Matrix3<f64>, j: usize, vector: &Vector3<f64>| {
            matrix[(0, j)] * vector.x + matrix[(1, j)] * vector.y + matrix[(2, j)] * vector.z
        };
        let bend = |j: usize| length_m * (column(&self.slope_m, j, force_n) + column(&self.tangent, j, moment_n_m));
        [length_m * column(&self.tangent, 0, force_n), bend(0), bend(1), bend(2)]
    }

    /// `J ε`: displacement in m and turn in rad of the outer end for a change of the strains, in the inner frame.
    #[inline(always)]
    pub fn push(&self, length_m: f64, strain: &[f64; 4]) -> (Vector3<f64>, Vector3<f64>) {
        let [stretch, x, y, z] = strain.map(|strain| strain * length_m);
        let column = |matrix: &Matrix3<f64>, j: usize| matrix.fixed_view::<3, 1>(0, j).into_owned();
        let sum = |m: &Matrix3<f64>| column(m, 0) * x + column(m, 1) * y + column(m, 2) * z;
        (column(&self.tangent, 0) * stretch + sum(&self.slope_m), sum(&self.tangent))
    }

    /// The link in the world, on an inner frame (world ← a).
    #[inline(always)]
    pub fn turned(&self, inner: &Matrix3<f64>, length_m: f64) -> Link {
        let spin = inner * self.tangent * length_m;
        let bend = inner * self.slope_m * length_m;
        let column = |matrix: &Matrix3<f64>, j: usize| matrix.fixed_view::<3, 1>(0, j).into_owned();
        Link {
            arm_m: inner * self.arm_m,
            rotation: inner * self.rotation,
            velocity: [column(&spin, 0), column(&bend, 0), column(&bend, 1), column(&bend, 2)],
            spin: [column(&spin, 0), column(&spin, 1), column(&spin, 2)],
        }
    }
}
