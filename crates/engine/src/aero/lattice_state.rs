//! State of the lattice: bound rings, their nodes and the wake.

use crate::aero::flap::HingeMoment;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Everything in the lattice that depends on history; all else is rebuilt from it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LatticeState {
    /// Circulations of the bound rings in m²/s, surface by surface, row by row from the leading edge, including the row behind the trailing
    /// edge. Positive by the right-hand rule along the leading segment from the inner to the outer section.
    pub circulation_m2_s: Vec<f64>,
    /// Corners of the bound rings, root frame, m.
    pub corner_m: Vec<Vector3<f64>>,
    /// Vector areas in m² of the panels between the quarter chords of neighbours, in the order of the circulations.
    pub area_m2: Vec<Vector3<f64>>,
    /// Collocation points, root frame, m, in the order of the circulations.
    pub collocation_m: Vec<Vector3<f64>>,
    /// Velocity of the surface at the collocation points, root frame, m/s.
    pub surface_m_s: Vec<Vector3<f64>>,
    /// Velocity induced by the far wake at the panels, root frame, m/s: summed once per step.
    pub far_wake_m_s: Vec<Vector3<f64>>,
    /// Nodes of the wake, root frame, m: row by row from the trailing edge, in each row surface by surface.
    pub wake_node_m: Vec<Vector3<f64>>,
    /// For a free wake: velocity in m/s induced by all vortices at its nodes, root frame, as last computed, eq. (U31); otherwise empty.
    pub induced_m_s: Vec<Vector3<f64>>,
    /// Number of steps without shedding, modulo the period of the updates of far rows, eq. (U31).
    pub unshed_steps: usize,
    /// Circulations of the wake's rings in m²/s, row by row as the nodes.
    pub wake_circulation_m2_s: Vec<f64>,
    /// Number of rows of rings in the wake.
    pub wake_rows: usize,
    /// Whether the last row is the straight wake of an established initial flow.
    pub established: bool,
    /// Whether this is the wake of a steady turn, eq. (U30): its number of rows is constant, and the last row moves with the others.
    pub turning: bool,
    /// Trailing edge, root frame, m: one point per column of the wake.
    pub edge_m: Vec<Vector3<f64>>,
    /// Velocity of the points of the trailing edge, root frame, m/s.
    pub edge_m_s: Vec<Vector3<f64>>,
    /// Position, root frame, m, of the trailing edge at the end of the last step that shed a row, convected with the undisturbed air since
    /// then. Not part of the state if `sheds`, because it is then the current edge.
    pub left_m: Vec<Vector3<f64>>,
    /// Whether the step that ends here shed a row; true at the start.
    pub sheds: bool,
    /// Whether the strips follow their polars with the lag of eq. (U32): from a step in which one was beyond stall, or in which no
    /// circulation gave all of them the lift of their polars, until they agree with their polars and none is beyond stall.
    pub lags: bool,
    /// Mean velocity of the air relative to the sections, root frame, m/s: the direction of the Prandtl-Glauert stretching.
    pub relative_m_s: Vector3<f64>,
    /// Hinge moments, one per control surface.
    pub hinges: Vec<HingeMoment>,
    /// Velocity in m/s through the panels of the strips whose profile is not a thin plate, eq. (U27).
    pub profile_m_s: Vec<f64>,
}

impl LatticeState {
    /// Copies another state that [fits](Self::fits), without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.circulation_m2_s.clone_from(&other.circulation_m2_s);
        self.corner_m.clone_from(&other.corner_m);
        self.area_m2.clone_from(&other.area_m2);
        self.collocation_m.clone_from(&other.collocation_m);
        self.surface_m_s.clone_from(&other.surface_m_s);
        self.far_wake_m_s.clone_from(&other.far_wake_m_s);
        self.wake_node_m.clone_from(&other.wake_node_m);
        self.induced_m_s.clone_from(&other.induced_m_s);
        self.unshed_steps = other.unshed_steps;
        self.wake_circulation_m2_s.clone_from(&other.wake_circulation_m2_s);
        (self.wake_rows, self.established, self.turning) = (other.wake_rows, other.established, other.turning);
        self.edge_m.clone_from(&other.edge_m);
        self.edge_m_s.clone_from(&other.edge_m_s);
        self.left_m.clone_from(&other.left_m);
        self.sheds = other.sheds;
        self.hinges.clone_from(&other.hinges);
        self.profile_m_s.clone_from(&other.profile_m_s);
        (self.relative_m_s, self.lags) = (other.relative_m_s, other.lags);
    }

    /// Whether another state can belong to the same lattice.
    pub fn fits(&self, other: &Self) -> bool {
        self.circulation_m2_s.len() == other.circulation_m2_s.len()
            && self.corner_m.len() == other.corner_m.len()
            && self.area_m2.len() == other.area_m2.len()
            && self.collocation_m.len() == other.collocation_m.len()
            && self.surface_m_s.len() == other.surface_m_s.len()
            && self.far_wake_m_s.len() == other.far_wake_m_s.len()
            && self.wake_node_m.len() == other.wake_node_m.len()
            && self.induced_m_s.len() == other.induced_m_s.len()
            && self.wake_circulation_m2_s.len() == other.wake_circulation_m2_s.len()
            && [&other.edge_m, &other.edge_m_s, &other.left_m].iter().all(|edge| edge.len() == self.edge_m.len())
            && self.hinges.len() == other.hinges.len()
            && self.profile_m_s.len() == other.profile_m_s.len()
            && other.wake_rows <= self.wake_circulation_m2_s.len()
            && (other.wake_rows > 0 || !other.established)
            && (other.wake_rows > 1 && other.established || !other.turning)
    }
}

/// Kind of the inducing vortices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SheetKind {
    /// Bound vortices of the lattice.
    Bound,
    /// Vortices of the wake.
    Wake,
}
