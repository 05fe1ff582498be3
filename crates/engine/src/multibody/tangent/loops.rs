//! Closed loops in the tangent as data: the points that a loop holds together, and the factors of the coupling of distant branches.

use crate::multibody::tangent::twist::twist;
use crate::multibody::workspace::Pair;
use nalgebra::{DMatrix, Dyn, LU, Matrix3x6, Vector3};

/// One closure linearised about the current poses.
#[derive(Debug, Clone)]
pub(super) struct ClosureTangent {
    /// Nodes that carry the points; `None` for a point on the root.
    pub(super) nodes: [Option<usize>; 2],
    /// Displacement of each point per twist of its node; zero on the root.
    pub(super) points: [Matrix3x6<f64>; 2],
    pub(super) stiffness_n_m: f64,
}

impl ClosureTangent {
    /// Displacement of a point due to those of the nodes.
    pub(super) fn displacement(&self, side: usize, displaced: &[Pair]) -> Vector3<f64> {
        self.nodes[side].map_or_else(Vector3::zeros, |n| self.points[side] * twist(&displaced[n]))
    }
}

/// Factor of the coupling of all closures.
#[derive(Debug, Clone)]
pub(super) struct Coupling {
    /// `K⁻¹Gᵀ`, one column per coordinate of a closure's points.
    pub(super) columns: DMatrix<f64>,
    /// Number of positive eigenvalues of the symmetric part of the small matrix, eq. (L16).
    pub(super) positive: usize,
    pub(super) lu: LU<f64, Dyn, Dyn>,
}

/// Factor of the constraints of all rigid loops.
#[derive(Debug, Clone)]
pub(super) struct RigidTangent {
    /// `Z = K⁻¹ Gᵀ`, one column per row of the gaps.
    pub(super) columns: DMatrix<f64>,
    /// Pseudo-inverse of `S = G Z`.
    pub(super) inverse: DMatrix<f64>,
    /// Number of negative eigenvalues of the symmetric part of `S`.
    pub(super) negative: usize,
    pub(super) support_n_m: f64,
}
