//! Motion of the wake.

use crate::aero::biot_savart::{Block, LANES, blocks};
use crate::aero::flow::{AirPath, Flow};
use crate::aero::lattice::{Factors, VortexLattice, WakeModel};
use crate::aero::lattice_state::{LatticeState, SheetKind};
use crate::aero::surface::Surface;
use nalgebra::Vector3;

/// Part of a panel chord that trailing edge and air must move against each other before the wake gets a new row.
///
/// An edge that rests in the air sheds nothing: the rings would pile up there. Where steps are shorter than this, the
/// foremost row grows until it is long enough.
pub(super) const SHED_PANELS: f64 = 0.05;

/// Share of that way by which round-off may miss it: the way of a round number of steps can be the way itself, and then
/// must shed in every frame.
pub(super) const SHED_ROUND_OFF: f64 = 1e-9;

/// Rows of the wake that [`solve`](VortexLattice::solve) sums anew for every motion that it is given. Those behind are
/// summed once for a step, at the collocation points as the velocities of its start carry them: the points then are off by
/// the acceleration times half the square of the step, small against the distance of these rows.
pub(super) const NEAR_ROWS: usize = 8;

impl VortexLattice {
    /// Moves the wake to the end of a step and sheds the row that the trailing edge leaves behind, with the circulation
    /// that it had at the start, eqs. (U5) and (U10). Done once for a step, before [`solve`](Self::solve).
    ///
    /// The undisturbed air moves on its exact path in the rotating frame; in a free wake gusts and induced velocities of
    /// the start of the step are added (first order). The foremost row of nodes is attached to the trailing edge by
    /// `solve`. A wake that is full keeps its far end: its last ring grows from step to step, with the circulation of the
    /// ring that it takes in, so that what is lost is the history of the far wake and not its length. The wake of an
    /// established flow stays behind all that as the one ring that it is: it takes nothing in.
    pub fn convect(&mut self, from: &LatticeState, flow: &Flow, step_s: f64, to: &mut LatticeState) {
        self.factors = Factors::Due;
        self.stretch_along(&from.relative_m_s);
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
        let shed = self.leaves_a_row(from, &path, step_s, to);
        to.sheds = shed;

        (to.established, to.turning) = (from.established, from.turning);
        let established = usize::from(from.established);
        // rings in front of an established wake, which end at this row of nodes
        let ended = from.wake_rows - established;
        // in a steady turn the wake keeps its number of rows from the start on
        let full = shed && (ended == self.options.wake_rows || from.turning);
        to.wake_rows = from.wake_rows + usize::from(shed && !full);
        // full: the last of these rings keeps its far end and takes in the one before
        let goes_to = |row: usize| match (shed, full) {
            (false, _) => Some(row),
            (true, false) => Some(row + 1),
            (true, true) if from.turning => Some(row + 1).filter(|next| *next <= ended),
            (true, true) if row >= ended => Some(row),
            (true, true) => Some(row + 1).filter(|next| *next < ended),
        };
        for row in 0..=from.wake_rows {
            let Some(next) = goes_to(row) else { continue };
            for column in 0..columns {
                to.wake_node_m[next * columns + column] = moved_m(row * columns + column);
            }
            if row < from.wake_rows {
                to.wake_circulation_m2_s[next * strips..][..strips]
                    .copy_from_slice(&from.wake_circulation_m2_s[row * strips..][..strips]);
            }
        }
        if from.turning && shed {
            // the straight wake behind them begins where the last of them now ends, has taken in the circulation of the row before, and
            // keeps its place against that as seen from the root frame, eq. (U30)
            for at in ended * columns..(ended + 1) * columns {
                let behind_m = from.wake_node_m[at + columns] - from.wake_node_m[at];
                to.wake_node_m[at + columns] = to.wake_node_m[at] + behind_m;
            }
        }
        // what lies behind the last row is no part of the state
        to.wake_node_m[(to.wake_rows + 1) * columns..].fill(Vector3::zeros());
        to.wake_circulation_m2_s[to.wake_rows * strips..].fill(0.0);
        if shed && to.wake_rows > 0 {
            self.shed_row(from, to);
        }
        self.sum_far_wake(from, step_s, to);
    }

    /// Carries what the last row has left with the air; true where some point of the trailing edge will be far enough
    /// from it at the end of the step for the next row, eq. (U10).
    ///
    /// The edge goes on as it moves at the start of the step: what decides must not change while air and structure
    /// are brought to agree. Only distances between the edge and the air count, which are the same in every frame.
    fn leaves_a_row(&self, from: &LatticeState, path: &AirPath, step_s: f64, to: &mut LatticeState) -> bool {
        let left_m = if from.sheds { &from.edge_m } else { &from.left_m };
        let mut farthest_m = 0.0_f64;
        for (column, left_m) in left_m.iter().enumerate() {
            to.left_m[column] = path.end_m(left_m);
            let edge_m = from.edge_m[column] + from.edge_m_s[column] * step_s;
            farthest_m = farthest_m.max((edge_m - to.left_m[column]).norm());
        }
        farthest_m >= self.shed_way_m() * (1.0 - SHED_ROUND_OFF)
    }

    /// Longest way of the trailing edge through the air in a step between two states, in panel chords: the length of the
    /// row that a step leaves. `path` is that of the flow of [`convect`](Self::convect).
    pub fn row_panels(&self, from: &LatticeState, to: &LatticeState, path: &AirPath) -> f64 {
        let mut longest = 0.0_f64;
        for (surface, wake) in self.surfaces.iter().zip(&self.wake) {
            for (column, chord) in surface.chords.iter().enumerate() {
                let at = wake.node(0, column);
                let way_m = (to.edge_m[at] - path.end_m(&from.edge_m[at])).norm();
                longest = longest.max(way_m / chord.length_m() * surface.chord_panels as f64);
            }
        }
        longest
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

    /// Foremost row of the wake: circulation of the trailing edge at the start of the step.
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

    /// Gives a row of the wake the circulation of the trailing edge.
    pub(super) fn shed_into(&self, row: usize, state: &mut LatticeState) {
        for (bound, wake) in self.bound.iter().zip(&self.wake) {
            for strip in 0..bound.strips {
                state.wake_circulation_m2_s[wake.ring(row, strip)] =
                    state.circulation_m2_s[bound.ring(bound.rows - 1, strip)];
            }
        }
    }

    /// Way in m that trailing edge and air must make against each other before a row is shed.
    pub(super) fn shed_way_m(&self) -> f64 {
        let panel_m = |surface: &Surface| {
            let shortest = surface.chords.iter().map(|chord| chord.length_m()).fold(f64::INFINITY, f64::min);
            shortest / surface.chord_panels as f64
        };
        SHED_PANELS * self.surfaces.iter().map(panel_m).fold(f64::INFINITY, f64::min)
    }
}
