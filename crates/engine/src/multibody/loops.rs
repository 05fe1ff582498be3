//! Closed loops as data: their points, their gaps, and the workspace of the correction for them.

use nalgebra::Vector3;

/// Penalty on the gap of a closed loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Penalty {
    /// Inertia `m` in kg.
    pub inertia_kg: f64,
    /// Damping `c` in N·s/m.
    pub damping_n_s_m: f64,
    /// Stiffness `k` in N/m.
    pub stiffness_n_m: f64,
}

/// Description of a closure for meshing: two points that coincide.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosureDescription {
    /// Bodies and the distances of the sections from their inner ends in m; `None` for a point on the root.
    pub places: [Option<(usize, f64)>; 2],
    /// Positions of the points relative to the sections' axes, section frames, m; on the root its position in the root frame.
    pub offsets_m: [Vector3<f64>; 2],
    /// Whether constraint forces hold the points together; the penalty is then zero.
    pub rigid: bool,
    /// Penalty on the gap.
    pub penalty: Penalty,
}

/// Closure in the tree: two points that must coincide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closure {
    /// Nodes that carry the points; `None` for a point on the root.
    pub nodes: [Option<usize>; 2],
    /// Positions of the points relative to the nodes, node frames, m; on the root its position in the root frame.
    pub offsets_m: [Vector3<f64>; 2],
    /// Penalty on the gap.
    pub penalty: Penalty,
}

/// Gap of a closure with its rates, root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Position of the second point relative to the first in m.
    pub position_m: Vector3<f64>,
    /// Rate of the gap in m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Second rate of the gap in m/s².
    pub acceleration_m_s2: Vector3<f64>,
}

/// Workspace for the closures and the damped modes of a model.
#[derive(Debug, Clone)]
pub(crate) struct ClosureFactor {
    /// Columns `Z = A⁻¹ Gᵀ`, one per row of the gaps, then one per damped mode.
    pub(super) columns: Vec<Vec<f64>>,
    /// Lower Cholesky factor of `S = D⁻¹ + G Z`, by rows.
    pub(super) cholesky: Vec<f64>,
    pub(super) gaps: Vec<f64>,
}

impl ClosureFactor {
    /// Workspace for `rows` rows and `coordinates` coordinates.
    pub(crate) fn new(rows: usize, coordinates: usize) -> Self {
        Self { columns: vec![vec![0.0; coordinates]; rows], cholesky: vec![0.0; rows * rows], gaps: vec![0.0; rows] }
    }
}
