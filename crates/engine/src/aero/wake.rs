//! Convection and shedding of the wake.

use crate::aero::biot_savart::{Block, LANES, blocks};
use crate::aero::flow::{AirPath, Flow};
use crate::aero::lattice::{Factors, VortexLattice, WakeModel};
use crate::aero::lattice_state::{LatticeState, SheetKind};
use crate::aero::rear::SHED_PANELS;
use crate::aero::surface::Surface;
use nalgebra::Vector3;

/// Relative round-off of the displacement [`SHED_PANELS`]: a round number of steps can give exactly the threshold, and must then shed in every frame of
/// reference.
pub(super) const SHED_ROUND_OFF: f64 = 1e-9;

/// Number of wake rows whose velocities [`solve`](VortexLattice::solve) sums again for every motion. Those further behind are summed once
/// per step, at the collocation points extrapolated with the velocities at its start: the points are then off by half the acceleration
/// times the square of the step, which is small compared with the distance of these rows.
pub(super) const NEAR_ROWS: usize = 8;

/// Number of rows of a free wake whose velocities are summed in every step, eq. (U31).
pub(super) const FRESH_ROWS: usize = 40;

impl VortexLattice {
    /// Convects the wake to the end of a step and sheds a row behind the trailing edge, with the circulation at the start of the step, eqs.
    /// (U5) and (U10). Called once per step, before [`solve`](Self::solve).
    ///
    /// The undisturbed air moves on its exact path in the rotating frame; for a free wake, gusts and induced velocities at the start of the
    /// step are added (first order). `solve` attaches the foremost row of nodes to the trailing edge. A full wake keeps its far end: its
    /// last ring grows in each step and takes the circulation of the ring that it absorbs, so that the history of the far wake is lost but
    /// not its length. The wake of an established flow stays behind it as a single ring that absorbs none.
    pub fn convect(&mut self, from: &LatticeState, flow: &Flow, step_s: f64, to: &mut LatticeState) {
        self.factors = Factors::Due;
        self.stretch_along(&from.relative_m_s);
        let (columns, strips) = (self.wake_columns, self.wake_strips);
        let nodes = (from.wake_rows + 1) * columns;
        let free = self.options.wake == WakeModel::Free;
        if free {
            self.wake_velocity(from, nodes);
        }
        let path = AirPath::new(flow, step_s);
        let moved_m = |node: usize| {
            let node_m = &from.wake_node_m[node];
            if !free {
                return path.end_m(node_m);
            }
            let gust_m_s = flow.gust_m_s(node_m);
            path.end_m(node_m) + (self.free_m_s[node] + gust_m_s) * step_s
        };
        let shed = self.leaves_a_row(from, &path, step_s, to);
        to.sheds = shed;
        to.unshed_steps = (from.unshed_steps + usize::from(!shed)) % self.far_period;

        (to.established, to.turning) = (from.established, from.turning);
        let established = usize::from(from.established);
        // number of rows in front of an established wake, which starts at this row of nodes
        let ended = from.wake_rows - established;
        // in a steady turn the wake keeps its initial number of rows
        let full = shed && (ended == self.options.wake_rows || from.turning);
        to.wake_rows = from.wake_rows + usize::from(shed && !full);
        // full: the last of these rings keeps its far end and absorbs the one in front of it
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
                let (node, moved) = (row * columns + column, next * columns + column);
                to.wake_node_m[moved] = moved_m(node);
                if free {
                    to.induced_m_s[moved] = path.turned(&self.free_m_s[node]);
                }
            }
            if row < from.wake_rows {
                to.wake_circulation_m2_s[next * strips..][..strips]
                    .copy_from_slice(&from.wake_circulation_m2_s[row * strips..][..strips]);
            }
        }
        if from.turning && shed {
            // the straight wake starts at the current end of the last of these rows, has absorbed the circulation of the row in front, and
            // keeps its position relative to it in the root frame, eq. (U30)
            for at in ended * columns..(ended + 1) * columns {
                let behind_m = from.wake_node_m[at + columns] - from.wake_node_m[at];
                to.wake_node_m[at + columns] = to.wake_node_m[at] + behind_m;
            }
        }
        // nodes behind the last row are not part of the state
        to.wake_node_m[(to.wake_rows + 1) * columns..].fill(Vector3::zeros());
        to.wake_circulation_m2_s[to.wake_rows * strips..].fill(0.0);
        if free {
            to.induced_m_s[(to.wake_rows + 1) * columns..].fill(Vector3::zeros());
        }
        if shed && to.wake_rows > 0 {
            self.shed_row(from, to);
        }
        self.sum_far_wake(from, step_s, to);
    }

    /// Convects the line left by the last shedding with the air; returns whether some point of the trailing edge will be far enough from it
    /// at the end of the step to shed the next row, eq. (U10).
    ///
    /// The edge is extrapolated with its velocity at the start of the step, because the result must not change during the iteration between
    /// aerodynamics and structure. It depends only on distances between the edge and the air, which are the same in every frame.
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

    /// Largest displacement of the trailing edge through the air in a step between two states, in panel chords: the length of the row of
    /// the step. `path` belongs to the flow of [`convect`](Self::convect).
    pub fn row_panels(&self, from: &LatticeState, to: &LatticeState, path: &AirPath) -> f64 {
        let mut longest = 0.0_f64;
        for (surface, wake) in self.surfaces.iter().zip(&self.wake) {
            for (column, chord) in surface.chords.iter().enumerate() {
                let at = wake.node(0, column);
                let displacement_m = (to.edge_m[at] - path.end_m(&from.edge_m[at])).norm();
                longest = longest.max(displacement_m / chord.length_m() * surface.chord_panels as f64);
            }
        }
        longest
    }

    /// Computes the velocity that the far wake at the end of a step induces at the collocation points.
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

    /// Sets the circulation of the foremost row of the wake to that of the trailing edge at the start of the step.
    fn shed_row(&self, from: &LatticeState, to: &mut LatticeState) {
        for (bound, wake) in self.bound.iter().zip(&self.wake) {
            for strip in 0..bound.strips {
                to.wake_circulation_m2_s[wake.ring(0, strip)] =
                    from.circulation_m2_s[bound.ring(bound.rows - 1, strip)];
            }
        }
    }

    /// Computes the induced velocity at the nodes of the wake into `free_m_s`: summed if the row is due, otherwise unchanged.
    fn wake_velocity(&mut self, from: &LatticeState, nodes: usize) {
        let columns = self.wake_columns;
        let due = |row: usize| is_due(row, from, self.far_period);
        let mut count = 0;
        for (row, nodes_m) in from.wake_node_m[..nodes].chunks_exact(columns).enumerate() {
            for point_m in nodes_m.iter().filter(|_| due(row)) {
                self.points[count / LANES].set(count % LANES, point_m);
                count += 1;
            }
        }
        self.velocities[..blocks(count)].fill(Block::default());
        self.gather_wake(from, 0..from.wake_rows);
        for sheet in &self.inducing {
            self.bound_filaments.gather(sheet, &from.circulation_m2_s);
        }
        let core_squared_m2 = self.kernel.core_squared_m2;
        self.kernel.core_squared_m2 = core_squared_m2.max(self.spacing_squared_m2(from));
        self.induce(count, &from.corner_m, SheetKind::Bound);
        self.induce(count, &from.wake_node_m, SheetKind::Wake);
        self.kernel.core_squared_m2 = core_squared_m2;
        count = 0;
        for (row, own_m_s) in self.free_m_s[..nodes].chunks_exact_mut(columns).enumerate() {
            if is_due(row, from, self.far_period) {
                for velocity_m_s in own_m_s {
                    *velocity_m_s = self.velocities[count / LANES].get(count % LANES);
                    count += 1;
                }
            } else {
                own_m_s.copy_from_slice(&from.induced_m_s[row * columns..][..columns]);
            }
        }
    }

    /// Squared spacing in m² of the lines of a free wake, eq. (U31): width of the widest strip or length of the longest panel. It is the
    /// core for convection. Nodes that come closer to a line, at folds, free edges and where two wakes meet, would be thrown far away by
    /// the line although a continuous sheet has no such velocity: cores must overlap. All lines have the same core, so that those of two
    /// bodies on a common edge cancel.
    fn spacing_squared_m2(&self, state: &LatticeState) -> f64 {
        let spacings = self.bound.iter().flat_map(|sheet| {
            let corner = move |row, column| state.corner_m[sheet.node(row, column)];
            let widths = (0..sheet.strips).map(move |strip| corner(0, strip + 1) - corner(0, strip));
            let chords = (0..=sheet.strips)
                .map(move |column| (corner(sheet.rows, column) - corner(0, column)) / (sheet.rows as f64 - 0.25));
            widths.chain(chords)
        });
        spacings.map(|spacing_m| spacing_m.norm_squared()).fold(0.0, f64::max)
    }

    /// Number of wake nodes with individual velocities; zero for a prescribed wake.
    pub(super) fn free_nodes(&self) -> usize {
        if self.options.wake == WakeModel::Free { (self.options.wake_rows + 2) * self.wake_columns } else { 0 }
    }

    /// Sets the circulation of a row of the wake to that of the trailing edge.
    pub(super) fn shed_into(&self, row: usize, state: &mut LatticeState) {
        for (bound, wake) in self.bound.iter().zip(&self.wake) {
            for strip in 0..bound.strips {
                state.wake_circulation_m2_s[wake.ring(row, strip)] =
                    state.circulation_m2_s[bound.ring(bound.rows - 1, strip)];
            }
        }
    }

    /// Distance in m that the trailing edge must move relative to the air before a row is shed.
    pub(super) fn shed_way_m(&self) -> f64 {
        let panel_m = |surface: &Surface| {
            let shortest = surface.chords.iter().map(|chord| chord.length_m()).fold(f64::INFINITY, f64::min);
            shortest / surface.chord_panels as f64
        };
        SHED_PANELS * self.surfaces.iter().map(panel_m).fold(f64::INFINITY, f64::min)
    }
}

/// Whether the velocities of a row of nodes are summed in the step that starts at a state, eq. (U31). The row's count increases in every
/// step: by its position if the previous step shed a row, otherwise by the number of steps without shedding. The two ends of the wake keep
/// their positions in the list and are always due.
fn is_due(row: usize, from: &LatticeState, period: usize) -> bool {
    let ended = from.wake_rows - usize::from(from.established);
    row < FRESH_ROWS || row >= ended || (row + from.unshed_steps).is_multiple_of(period)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::AirLoads;
    use crate::aero::flow::{Gust, GustShape};
    use crate::aero::lattice::{FAR_PERIOD, LatticeOptions};
    use crate::aero::surface::{ChordLine, Profile};
    use crate::aero::test_lattices::{flow, options, section};

    const STEP_S: f64 = 0.01;

    /// A flat wing of 3 m span and 1 m chord at 6°, with two by two panels and `finer` times 90 wake rows; far rows are updated every
    /// `period` steps.
    fn wing((finer, period): (usize, usize)) -> VortexLattice {
        let (sine, cosine) = 6.0_f64.to_radians().sin_cos();
        let chord = ChordLine {
            leading_m: Vector3::new(0.0, 0.25 * cosine, 0.25 * sine),
            trailing_m: Vector3::new(0.0, -0.75 * cosine, -0.75 * sine),
        };
        let surface = Surface { sections: 0..3, chords: vec![chord; 3], chord_panels: 2, profile: Profile::THIN };
        let options = LatticeOptions { wake: WakeModel::Free, wake_rows: 90 * finer, ..options() };
        let mut lattice = VortexLattice::new(vec![surface], options);
        lattice.far_period = period;
        lattice
    }

    /// Uniform wind along `−y`.
    fn blows(speed_m_s: f64) -> Flow<'static> {
        flow(Vector3::y() * -speed_m_s)
    }

    /// The wing in a wind of 10 m/s that blows for some steps and then stops; there are `finer` times as many steps, each as much shorter.
    fn wake(
        (finer, period): (usize, usize),
        [blowing, resting]: [usize; 2],
        mut visit: impl FnMut(&LatticeState),
    ) -> LatticeState {
        let (step_s, blowing) = (STEP_S / finer as f64, finer * blowing);
        let mut lattice = wing((finer, period));
        let motions = [0.0, 1.5, 3.0].map(|x| section(Vector3::x() * x, 0.0));
        let (mut state, mut next) = (lattice.blank_state(), lattice.blank_state());
        let mut loads = AirLoads::still(3);
        lattice.start(&motions, &blows(10.0), None, &mut state, &mut loads).unwrap();
        for step in 0..blowing + resting {
            let flow = blows(if step < blowing { 10.0 } else { 0.0 });
            visit(&state);
            lattice.convect(&state, &flow, step_s, &mut next);
            lattice.solve(&state, &motions, &flow, step_s, &mut next, &mut loads).unwrap();
            std::mem::swap(&mut state, &mut next);
        }
        state
    }

    /// U-70. Far rows updated periodically end at the same positions as with all rows summed in every step, to within a fraction of the
    /// change with steps of half the length: the path of the wake is of first order in the step either way.
    #[test]
    fn rows_that_take_turns_follow_those_that_do_not() {
        let [all, turns, finer] = [(1, 1), (1, FAR_PERIOD), (2, 1)].map(|way| wake(way, [90, 0], |_| {}));
        assert_eq!([&all, &turns, &finer].map(|state| state.wake_rows), [90, 90, 180]);
        let node_m = |state: &LatticeState, row: usize, column: usize| state.wake_node_m[3 * row + column];
        let (mut off_m, mut by_step_m) = (0.0_f64, 0.0_f64);
        for (row, column) in (1..=90).flat_map(|row| (0..3).map(move |column| (row, column))) {
            let own_off_m = (node_m(&all, row, column) - node_m(&turns, row, column)).norm();
            assert!(row < FRESH_ROWS + 2 || own_off_m > 0.0, "row {row} took no turns");
            off_m = off_m.max(own_off_m);
            by_step_m = by_step_m.max((node_m(&all, row, column) - node_m(&finer, 2 * row, column)).norm());
        }
        // between two sums a velocity is up to three steps old instead of half a step on average, but far from the wing it changes less,
        // except near the starting vortex at the very end
        assert!(off_m < 0.5 * by_step_m, "{off_m:.1e} m, {by_step_m:.1e} m by half the step");
    }

    /// U-71. No row waits longer than one period, whether steps shed rows or not and whether the wake is growing or full, and the work is
    /// the same in all steps: a quarter of the far rows.
    #[test]
    fn no_row_waits_longer_than_its_turn() {
        // age in steps of the velocity of each row, identified by the position of its node along the wind at the end of the step
        let (mut ages, mut rows_before) = (vec![0_usize; 1], 0);
        wake((1, FAR_PERIOD), [100, 9], |state| {
            let full = state.wake_rows == rows_before && state.wake_rows == 90;
            if state.wake_rows > rows_before || full && state.sheds {
                ages.insert(0, 0);
            }
            // the far end stays, and the row in front of it is absorbed
            if full && state.sheds {
                ages.remove(90);
            }
            rows_before = state.wake_rows;
            let mut far = 0;
            for (row, age) in ages.iter_mut().enumerate() {
                *age = if is_due(row, state, FAR_PERIOD) { 0 } else { *age + 1 };
                assert!(*age < FAR_PERIOD, "row {row} of {}", state.wake_rows);
                far += usize::from(row >= FRESH_ROWS && *age == 0);
            }
            let all = state.wake_rows.saturating_sub(FRESH_ROWS);
            assert!(far <= all / FAR_PERIOD + 2, "{far} of {all} rows at once");
        });
        assert!(rows_before > 2 * FRESH_ROWS);
    }

    /// A free wake is convected by all velocities of the air: a gust moves every node by its velocity times the step; in a rotating root
    /// frame the stored velocities of the nodes rotate with the air relative to the frame.
    #[test]
    fn nodes_and_their_velocities_go_with_the_air() {
        let setting = (1, FAR_PERIOD);
        let (from, mut lattice) = (wake(setting, [60, 0], |_| {}), wing(setting));
        let mut moved = |flow: &Flow| {
            let mut to = lattice.blank_state();
            lattice.convect(&from, flow, STEP_S, &mut to);
            assert!(to.sheds && to.wake_rows == 61);
            to
        };
        let calm = moved(&blows(10.0));
        // nodes at the trailing edge are set later
        let nodes = 3..3 * 62;
        assert!(calm.induced_m_s[nodes.clone()].iter().all(|velocity_m_s| velocity_m_s.norm() > 1e-6));

        let velocity_m_s = Vector3::new(0.4, -0.7, 1.1);
        let gust = Gust {
            name: "front".to_owned(),
            shape: GustShape::SharpEdge,
            velocity_m_s,
            direction: -Vector3::y(),
            speed_m_s: 10.0,
            origin_m: Vector3::y() * 100.0,
            start_s: -1e3,
        };
        let gusty = moved(&Flow { gusts: &[gust], ..blows(10.0) });
        for node in nodes.clone() {
            let displacement_m = gusty.wake_node_m[node] - calm.wake_node_m[node];
            assert!((displacement_m - velocity_m_s * STEP_S).norm() < 1e-12, "{node}: {displacement_m}");
        }

        let spin_rad_s = Vector3::new(0.9, -1.4, 2.0);
        let turning = moved(&Flow { spin_rad_s, ..blows(10.0) });
        let turn = nalgebra::Rotation3::from_scaled_axis(-spin_rad_s * STEP_S);
        for node in nodes {
            let velocity_m_s = calm.induced_m_s[node];
            let off_m_s = turning.induced_m_s[node] - turn * velocity_m_s;
            assert!(off_m_s.norm() < 1e-12 * velocity_m_s.norm(), "{node}: {off_m_s}");
        }
    }
}
