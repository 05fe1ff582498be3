//! Motion of the wake.

use crate::aero::biot_savart::{Block, LANES, blocks};
use crate::aero::flow::Flow;
use crate::aero::lattice::{SheetKind, VortexLattice, WakeModel};
use crate::aero::lattice_state::LatticeState;
use crate::aero::surface::Surface;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Part of a panel chord past which the air must move before the wake gets a new row.
///
/// Air that does not move sheds nothing: the rings would pile up at the trailing edge. Where steps are shorter than
/// this, the foremost row grows until it is long enough.
pub(super) const SHED_PANELS: f64 = 0.05;

/// Length of the wake at the start of established flow, in diameters of the lattice: the legs behind contribute
/// `1/(4·200²)` of what they do near by.
const ESTABLISHED_DIAMETERS: f64 = 200.0;

/// Rows of the wake that [`solve`](VortexLattice::solve) sums anew for every motion that it is given. Those behind are
/// summed once for a step, at the collocation points as the velocities of its begin carry them: the points then are off by
/// the acceleration times half the square of the step, small against the distance of these rows.
pub(super) const NEAR_ROWS: usize = 8;

impl VortexLattice {
    /// Moves the wake to the end of a step and sheds the row that the trailing edge leaves behind, with the circulation
    /// that it had at the begin, eq. (U5). Done once for a step, before [`solve`](Self::solve).
    ///
    /// The undisturbed air moves on its exact path in the rotating frame; in a free wake gusts and induced velocities of
    /// the begin of the step are added (first order). The foremost row of nodes is attached to the trailing edge by
    /// `solve`. A wake that is full keeps its far end: its last ring grows from step to step, with the circulation of the
    /// ring that it takes in, so that what is lost is the history of the far wake and not its length.
    pub fn convect(&mut self, from: &LatticeState, flow: &Flow, step_s: f64, to: &mut LatticeState) {
        let (columns, strips) = (self.wake_columns, self.wake_strips);
        let nodes = (from.wake_rows + 1) * columns;
        let free = self.options.wake == WakeModel::Free;
        if free {
            self.wake_velocity(from, flow, nodes);
        }
        let path = AirPath::new(flow, step_s);
        let moved_m = |node: usize| {
            let disturbance_m_s = if free { self.velocities[node / LANES].get(node % LANES) } else { Vector3::zeros() };
            path.end_m(&from.wake_node_m[node]) + disturbance_m_s * step_s
        };
        let way_m = (0..columns).map(|node| (moved_m(node) - from.wake_node_m[node]).norm()).fold(0.0, f64::max);
        to.unshed_m = from.unshed_m + way_m;
        let shed = to.unshed_m >= self.shed_way_m() && way_m > 0.0;

        let shift = usize::from(shed);
        to.wake_rows = (from.wake_rows + shift).min(self.options.wake_rows);
        let kept = (to.wake_rows + 1 - shift) * columns;
        for node in 0..kept.min(nodes) {
            to.wake_node_m[node + shift * columns] = moved_m(node);
        }
        if shed && to.wake_rows == from.wake_rows {
            // full: the last ring keeps its far end and takes in the one before
            for node in from.wake_rows * columns..nodes {
                to.wake_node_m[node] = moved_m(node);
            }
        }
        let rings = (to.wake_rows - shift.min(to.wake_rows)) * strips;
        to.wake_circulation_m2_s[shift.min(to.wake_rows) * strips..][..rings]
            .copy_from_slice(&from.wake_circulation_m2_s[..rings]);
        // what lies behind the last row is no part of the state
        to.wake_node_m[(to.wake_rows + 1) * columns..].fill(Vector3::zeros());
        to.wake_circulation_m2_s[to.wake_rows * strips..].fill(0.0);
        if shed {
            to.unshed_m = 0.0;
            if to.wake_rows > 0 {
                self.shed_row(from, to);
            }
        }
        self.sum_far_wake(from, step_s, to);
    }

    /// Velocity that the far wake at the end of a step induces at the collocation points.
    fn sum_far_wake(&mut self, from: &LatticeState, step_s: f64, to: &mut LatticeState) {
        to.far_wake_m_s.fill(Vector3::zeros());
        if to.wake_rows <= NEAR_ROWS {
            return;
        }
        let mut panel = 0;
        for sheet in &self.bound {
            for ring in sheet.first_ring..sheet.ring(sheet.rows, 0) {
                let point_m = from.collocation_m[ring] + step_s * from.surface_m_s[ring];
                self.points[panel / LANES].set(panel % LANES, &point_m);
                panel += 1;
            }
        }
        self.velocities[..blocks(panel)].fill(Block::default());
        self.gather_wake(to, NEAR_ROWS..to.wake_rows);
        self.induce(panel, &to.wake_node_m, SheetKind::Wake);
        panel = 0;
        for sheet in &self.bound {
            for ring in sheet.first_ring..sheet.ring(sheet.rows, 0) {
                to.far_wake_m_s[ring] = self.velocities[panel / LANES].get(panel % LANES);
                panel += 1;
            }
        }
    }

    /// Foremost row of the wake: circulation of the trailing edge at the begin of the step.
    fn shed_row(&self, from: &LatticeState, to: &mut LatticeState) {
        for (bound, wake) in self.bound.iter().zip(&self.wake) {
            for strip in 0..bound.strips {
                to.wake_circulation_m2_s[wake.ring(0, strip)] =
                    from.circulation_m2_s[bound.ring(bound.rows - 1, strip)];
            }
        }
    }

    /// Gusts and induced velocity at the nodes of the wake, into `velocities`.
    fn wake_velocity(&mut self, from: &LatticeState, flow: &Flow, nodes: usize) {
        for (node, point_m) in from.wake_node_m[..nodes].iter().enumerate() {
            self.points[node / LANES].set(node % LANES, point_m);
        }
        self.velocities[..blocks(nodes)].fill(Block::default());
        self.gather_wake(from, 0..from.wake_rows);
        for sheet in &self.bound {
            self.bound_filaments.gather(sheet, &from.circulation_m2_s);
        }
        self.induce(nodes, &from.corner_m, SheetKind::Bound);
        self.induce(nodes, &from.wake_node_m, SheetKind::Wake);
        for (node, point_m) in from.wake_node_m[..nodes].iter().enumerate() {
            let gust_m_s = flow.velocity_m_s(point_m) - flow.convection_m_s(point_m);
            let (block, lane) = (node / LANES, node % LANES);
            let sum_m_s = self.velocities[block].get(lane) + gust_m_s;
            self.velocities[block].set(lane, &sum_m_s);
        }
    }

    /// Straight wake along the flow at the trailing edge in rows of a panel chord, the last one very long; false where
    /// the air does not move.
    pub(super) fn lay_straight_wake(&mut self, flow: &Flow, state: &mut LatticeState) -> bool {
        let origin = state.corner_m[0];
        let diameter_m = 2.0 * state.corner_m.iter().map(|corner| (corner - origin).norm()).fold(0.0, f64::max);
        for ((surface, sheet), wake) in self.surfaces.iter().zip(&self.bound).zip(&mut self.wake) {
            wake.rows = self.options.wake_rows;
            for (column, chord) in surface.chords.iter().enumerate() {
                let edge_m = state.corner_m[sheet.node(sheet.rows, column)];
                let Some(along) = flow.convection_m_s(&edge_m).try_normalize(0.0) else { return false };
                let row_m = chord.length_m() / surface.chord_panels as f64;
                for row in 1..=wake.rows {
                    let way_m = if row < wake.rows { row as f64 * row_m } else { ESTABLISHED_DIAMETERS * diameter_m };
                    state.wake_node_m[wake.node(row, column)] = edge_m + along * way_m;
                }
            }
        }
        state.wake_rows = self.options.wake_rows;
        state.wake_rows > 0
    }

    /// Gives a row of the wake the circulation of the trailing edge.
    pub(super) fn shed_into(&self, row: usize, state: &mut LatticeState) {
        for (bound, wake) in self.bound.iter().zip(&self.wake) {
            for strip in 0..bound.strips {
                state.wake_circulation_m2_s[wake.ring(row, strip)] =
                    state.circulation_m2_s[bound.ring(bound.rows - 1, strip)];
            }
        }
    }

    /// Way in m that the air must make past the trailing edge before a row is shed.
    pub(super) fn shed_way_m(&self) -> f64 {
        let panel_m = |surface: &Surface| {
            let shortest = surface.chords.iter().map(|chord| chord.length_m()).fold(f64::INFINITY, f64::min);
            shortest / surface.chord_panels as f64
        };
        SHED_PANELS * self.surfaces.iter().map(panel_m).fold(f64::INFINITY, f64::min)
    }
}

/// Path of undisturbed air over a step: `ẋ = w − ω × x` with constant `w` and `ω`, eq. (U5).
struct AirPath {
    rotation: Matrix3<f64>,
    shift_m: Vector3<f64>,
}

impl AirPath {
    fn new(flow: &Flow, step_s: f64) -> Self {
        let turn = -flow.spin_rad_s * step_s;
        let (angle, hat) = (turn.norm(), turn.cross_matrix());
        // (1 − cos φ)/φ² and (φ − sin φ)/φ³; below the limit the series' next terms are below 1e-16
        let (a, b) = if angle < 1e-3 {
            let square = angle * angle;
            (0.5 - square * (1.0 / 24.0 - square / 720.0), 1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0))
        } else {
            let half_sine = (0.5 * angle).sin();
            (2.0 * half_sine * half_sine / (angle * angle), (angle - angle.sin()) / (angle * angle * angle))
        };
        let mean = Matrix3::identity() + a * hat + b * hat * hat;
        Self { rotation: Rotation3::new(turn).into_inner(), shift_m: mean * flow.wind_m_s * step_s }
    }

    fn end_m(&self, begin_m: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * begin_m + self.shift_m
    }
}
