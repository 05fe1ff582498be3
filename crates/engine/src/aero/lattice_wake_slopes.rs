//! Derivatives of the lattice with respect to circulations and node displacements of its wake, eqs. (U24) and (U25).
//!
//! Neither changes the wing. The velocities of unit rings at the points of the lattice are summed once, and the change due to a circulation
//! or a node is added to the velocities of the steady flow: the perturbation of one ring or node then costs one solution with the current
//! factors and one product with the influence of the wing, instead of a sum over the whole wake.

use crate::aero::biot_savart::{Block, LANES, Sheet, blocks};
use crate::aero::flap::HingeMoment;
use crate::aero::lattice::{LoadRule, VortexLattice};
use crate::aero::lattice_linear::{About, MOVING_ROWS, NO_CIRCULATION, STEP, WEIGHTS, in_sections};
use crate::aero::lattice_state::SheetKind;
use crate::aero::near_sheets::{Facing, NoCirculation};
use crate::aero::rear::SHED_PANELS;
use crate::aero::{AirLoads, lattice_loads};
use crate::math::wide::wide;
use nalgebra::{DMatrix, Vector3};

/// Points at which velocities are evaluated, with the near-field data of those close to other sheets.
struct View {
    points_m: Vec<Block>,
    facings: Vec<Facing>,
}

impl View {
    /// Number of points, including those that fill the last block.
    fn rows(&self) -> usize {
        self.points_m.len() * LANES
    }
}

/// Steady flow, and the velocities needed for its perturbations.
pub(super) struct Seen {
    /// Views from the collocation points and from the points at which the loads act.
    panels: View,
    loads: View,
    /// Velocity at the points of action of the loads per circulation of the panels in 1/m: axis by axis, panel by panel, point by point.
    bound_1_m: Vec<f64>,
    /// Relative velocity of the steady flow in m/s.
    relative_m_s: Vec<Vector3<f64>>,
    velocities: Vec<Block>,
    circulation_m2_s: Vec<f64>,
    /// Velocity increments at the points of the two views in a perturbation, in m/s: axis by axis, point by point.
    more_m_s: [Vec<f64>; 2],
    changed_m2_s: Vec<f64>,
    sums_m_s: Vec<f64>,
    air_loads: AirLoads,
}

impl VortexLattice {
    /// Evaluates the steady flow at all points.
    pub(super) fn look_at_steady(&mut self, about: &mut About, rows: usize) -> Result<Seen, NoCirculation> {
        self.answer(about, &mut Vec::with_capacity(rows))?;
        let (panels, suction) = (self.right.len(), self.options.load_rule == LoadRule::KuttaJoukowski);
        let points = match suction {
            true => self.bound.iter().map(|sheet| sheet.rows * (2 * sheet.strips + 1)).sum(),
            false => panels,
        };
        // for the points of action of the loads, if they differ from those of the panels
        let loads = View { points_m: self.points[..blocks(points)].to_vec(), facings: self.facings.clone() };
        let velocities = self.velocities[..blocks(points)].to_vec();
        let circulation_m2_s = self.solution.clone();
        self.look_from_panels(&about.state);
        let mut panel = 0;
        for sheet in &self.bound {
            for ring in sheet.first_ring..sheet.ring(sheet.rows, 0) {
                self.points[panel / LANES].set(panel % LANES, &about.state.collocation_m[ring]);
                panel += 1;
            }
        }
        let own = View { points_m: self.points[..blocks(panels)].to_vec(), facings: self.facings.clone() };
        let mut bound_1_m = vec![0.0; 3 * panels * loads.rows()];
        for surface in 0..self.bound.len() {
            let (sheet, first) = (self.inducing[surface], self.first_panel[surface]);
            let kind = SheetKind::Bound;
            self.see_rings(&loads, (surface, &sheet, kind), &about.state.corner_m, (first, panels), &mut bound_1_m);
        }
        Ok(Seen {
            bound_1_m,
            relative_m_s: self.relative_m_s.clone(),
            velocities,
            circulation_m2_s,
            more_m_s: [&own, &loads].map(|view| vec![0.0; 3 * view.rows()]),
            changed_m2_s: vec![0.0; panels],
            sums_m_s: vec![0.0; 3 * loads.rows()],
            air_loads: AirLoads::still(about.motions.len()),
            panels: own,
            loads,
        })
    }

    /// Adds the velocities that unit rings of a sheet (part of a surface's rings) induce at all points of a view. `seen` has `columns`
    /// rings for each axis; those of the sheet start at `first`.
    fn see_rings(
        &mut self,
        view: &View,
        (surface, sheet, kind): (usize, &Sheet, SheetKind),
        nodes_m: &[Vector3<f64>],
        (first, columns): (usize, usize),
        seen: &mut [f64],
    ) {
        let (kernel, rows) = (&self.kernel, view.rows());
        let (arms, entries, sums) = (&mut self.arms[0], &mut self.facing_entries, &mut self.facing_sums);
        // rings behind the trailing edge are merged with those in front of them
        let rings = match kind {
            SheetKind::Bound => sheet.rows - 1,
            SheetKind::Wake => sheet.rows,
        };
        let of = |row: usize| row.min(rings - 1) * sheet.strips;
        for (axis, seen) in seen.chunks_exact_mut(columns * rows).enumerate() {
            let along = Vector3::ith(axis, 1.0);
            let mut normals = Block::default();
            (0..LANES).for_each(|lane| normals.set(lane, &along));
            let seen = &mut seen[first * rows..];
            for (block, points_m) in view.points_m.iter().enumerate() {
                let place = (rows, block * LANES);
                kernel.influence(sheet, nodes_m, points_m, &normals, arms, seen, place, of);
            }
            for facing in view.facings.iter().filter(|facing| facing.sheet == surface) {
                let share = if kind == SheetKind::Wake { facing.wake_share } else { facing.share };
                if share <= 0.0 {
                    continue;
                }
                let sums = &mut sums[..rings * sheet.strips];
                sums.fill(0.0);
                facing.direct().influence(kernel, sheet, nodes_m, &along, arms, entries, sums, of);
                sums.iter_mut().for_each(|sum| *sum = -*sum);
                facing.influence(kernel, sheet, nodes_m, &along, arms, entries, sums, of);
                for (ring, sum) in sums.iter().enumerate() {
                    seen[ring * rows + facing.point] += share * sum;
                }
            }
        }
    }

    /// Appends to `rows` the response of the lattice to the velocity increments `more_m_s` at its points.
    fn respond(&mut self, about: &mut About, seen: &mut Seen, rows: &mut Vec<f64>) -> Result<(), NoCirculation> {
        let About { state, motions, flow, .. } = about;
        let own = seen.panels.rows();
        let mut panel = 0;
        for sheet in &self.bound {
            for ring in sheet.first_ring..sheet.ring(sheet.rows, 0) {
                let more_m_s: Vector3<f64> = Vector3::from_fn(|axis, _| seen.more_m_s[0][axis * own + panel]);
                self.relative_m_s[ring] = seen.relative_m_s[ring] + more_m_s;
                panel += 1;
            }
        }
        self.circulate(motions, flow, state)?;
        let changes = seen.changed_m2_s.iter_mut().zip(self.solution.iter().zip(&seen.circulation_m2_s));
        changes.for_each(|(change, (now, steady))| *change = now - steady);
        // at the panels the relative velocity includes that of the wake
        match self.options.load_rule {
            LoadRule::Bernoulli => seen.sums_m_s.fill(0.0),
            LoadRule::KuttaJoukowski => seen.sums_m_s.copy_from_slice(&seen.more_m_s[1]),
        }
        let (count, panels) = (seen.loads.rows(), self.right.len());
        let Seen { sums_m_s, bound_1_m, changed_m2_s, .. } = &mut *seen;
        wide(
            self.arch,
            #[inline(always)]
            || {
                let axes = sums_m_s.chunks_exact_mut(count).zip(bound_1_m.chunks_exact(count * panels));
                for (sums, rings) in axes {
                    for (ring, change) in rings.chunks_exact(count).zip(changed_m2_s.iter()) {
                        sums.iter_mut().zip(ring).for_each(|(sum, entry)| *sum += entry * change);
                    }
                }
            },
        );
        for (block, steady) in seen.velocities.iter().enumerate() {
            for axis in 0..3 {
                let more_m_s = &seen.sums_m_s[axis * count + block * LANES..];
                let sums = self.velocities[block].xyz[axis].iter_mut().zip(&steady.xyz[axis]).zip(more_m_s);
                sums.for_each(|((sum, steady), more)| *sum = steady + more);
            }
        }
        seen.air_loads.clear();
        state.hinges.fill(HingeMoment::default());
        lattice_loads::sum(self, motions, flow.density_kg_m3, state, &mut seen.air_loads);
        rows.extend_from_slice(&self.solution);
        in_sections(motions, &seen.air_loads.circulatory, rows);
        rows.extend(state.hinges.iter().map(|hinge| hinge.circulatory_n_m));
        rows.extend(state.wake_node_m[..self.wake_columns].iter().flat_map(|node| [node.x, node.y, node.z]));
        Ok(())
    }

    /// Derivatives with respect to the circulations of the wake. The loads are quadratic in them, so that central differences are exact; a
    /// large step reduces their round-off.
    pub(super) fn wake_slopes(
        &mut self,
        about: &mut About,
        seen: &mut Seen,
        rows: usize,
    ) -> Result<DMatrix<f64>, NoCirculation> {
        let strips = self.wake_strips;
        let step_m2_s = about.flow.wind_m_s.norm() * self.shed_way_m() / SHED_PANELS;
        let mut matrix = DMatrix::zeros(rows, about.state.wake_rows * strips);
        let mut answer = Vec::with_capacity(rows);
        let suction = self.options.load_rule == LoadRule::KuttaJoukowski;
        let mut rings_1_m = [&seen.panels, &seen.loads].map(|view| vec![0.0; 3 * strips * view.rows()]);
        for row in 0..about.state.wake_rows {
            for (view, rings_1_m) in
                [&seen.panels, &seen.loads].into_iter().zip(&mut rings_1_m).take(1 + usize::from(suction))
            {
                rings_1_m.fill(0.0);
                for surface in 0..self.wake.len() {
                    let wake = &self.wake[surface];
                    let part = Sheet { rows: 1, first_node: wake.node(row, 0), first_ring: wake.ring(row, 0), ..*wake };
                    let nodes_m = &about.state.wake_node_m;
                    let first = (wake.first_ring, strips);
                    self.see_rings(view, (surface, &part, SheetKind::Wake), nodes_m, first, rings_1_m);
                }
            }
            for strip in 0..strips {
                let mut slopes = matrix.column_mut(row * strips + strip);
                for sign in [1.0, -1.0] {
                    for (more_m_s, rings_1_m) in seen.more_m_s.iter_mut().zip(&rings_1_m) {
                        let count = more_m_s.len() / 3;
                        for (more_m_s, rings_1_m) in
                            more_m_s.chunks_exact_mut(count).zip(rings_1_m.chunks_exact(strips * count))
                        {
                            let ring_1_m = &rings_1_m[strip * count..][..count];
                            more_m_s.iter_mut().zip(ring_1_m).for_each(|(more, ring)| *more = sign * step_m2_s * ring);
                        }
                    }
                    answer.clear();
                    self.respond(about, seen, &mut answer)?;
                    for (slope, row) in slopes.iter_mut().zip(&answer) {
                        *slope += sign * row / (2.0 * step_m2_s);
                    }
                }
            }
        }
        Ok(matrix)
    }

    /// Derivatives with respect to displacements of the nodes of the wake.
    pub(super) fn node_slopes(
        &mut self,
        about: &mut About,
        seen: &mut Seen,
        rows: usize,
    ) -> Result<DMatrix<f64>, NoCirculation> {
        let columns = self.wake_columns;
        let panel_m = self.shed_way_m() / SHED_PANELS;
        let scale_m2_s = about.flow.wind_m_s.norm() * panel_m;
        if about.state.wake_circulation_m2_s.iter().all(|ring| ring.abs() <= NO_CIRCULATION * scale_m2_s) {
            return Ok(DMatrix::zeros(rows, 0));
        }
        let last = about.state.wake_rows;
        let moving = MOVING_ROWS.min(last);
        let step_m = STEP * panel_m;
        let mut matrix = DMatrix::zeros(rows, 3 * columns * moving);
        let mut answer = Vec::with_capacity(rows);
        let mut nodes_m = about.state.wake_node_m.clone();
        for row in 1..=moving {
            let moved = row..if row == moving { last + 1 } else { row + 1 };
            for column in 0..columns {
                for part in 0..3 {
                    let mut slopes = matrix.column_mut(3 * ((row - 1) * columns + column) + part);
                    for (i, weight) in (1..).zip(WEIGHTS) {
                        for sign in [1.0, -1.0] {
                            let displacement_m = Vector3::ith(part, sign * f64::from(i) * step_m);
                            for row in moved.clone() {
                                nodes_m[row * columns + column] += displacement_m;
                            }
                            self.see_displaced((moved.start, moved.end.min(last)), column, about, &nodes_m, seen);
                            for row in moved.clone() {
                                nodes_m[row * columns + column] = about.state.wake_node_m[row * columns + column];
                            }
                            answer.clear();
                            self.respond(about, seen, &mut answer)?;
                            for (slope, row) in slopes.iter_mut().zip(&answer) {
                                *slope += sign * weight * row / (12.0 * step_m);
                            }
                        }
                    }
                }
            }
        }
        Ok(matrix)
    }

    /// Computes the velocity increments for a displacement of the nodes of a wake column over a range of rows, from the adjacent rings.
    fn see_displaced(
        &mut self,
        (row, end): (usize, usize),
        column: usize,
        about: &About,
        nodes_m: &[Vector3<f64>],
        seen: &mut Seen,
    ) {
        let own = |wake: &Sheet| (wake.first_node..=wake.first_node + wake.strips).contains(&column);
        let Some(surface) = self.wake.iter().position(own) else { return };
        let wake = &self.wake[surface];
        let at = column - wake.first_node;
        let first_strip = at.saturating_sub(1);
        let patch = Sheet {
            rows: end - (row - 1),
            strips: (at + 1).min(wake.strips) - first_strip,
            first_node: wake.node(row - 1, first_strip),
            first_ring: wake.ring(row - 1, first_strip),
            ..*wake
        };
        self.wake_filaments.gather(&patch, &about.state.wake_circulation_m2_s);
        let (kernel, filaments, arms) = (&self.kernel, &self.wake_filaments, &mut self.arms[0]);
        let Seen { panels, loads, more_m_s, .. } = seen;
        for (view, more_m_s) in [&*panels, &*loads].into_iter().zip(more_m_s.iter_mut()) {
            let count = view.rows();
            for (block, points_m) in view.points_m.iter().enumerate() {
                let mut ends = [Block::default(); 2];
                for (end, nodes_m) in ends.iter_mut().zip([&about.state.wake_node_m[..], nodes_m]) {
                    kernel.induce(&[patch], nodes_m, filaments, points_m, arms, end);
                }
                for axis in 0..3 {
                    let more_m_s = &mut more_m_s[axis * count + block * LANES..][..LANES];
                    let ends = ends[1].xyz[axis].iter().zip(&ends[0].xyz[axis]);
                    more_m_s.iter_mut().zip(ends).for_each(|(more, (now, steady))| *more = now - steady);
                }
            }
            let close = view.facings.iter().filter(|facing| facing.sheet == surface && facing.wake_share > 0.0);
            for facing in close {
                let [steady_m_s, now_m_s] = [&about.state.wake_node_m[..], nodes_m]
                    .map(|nodes_m| facing.correction_m_s(kernel, &patch, nodes_m, filaments, arms));
                for axis in 0..3 {
                    more_m_s[axis * count + facing.point] += facing.wake_share * (now_m_s[axis] - steady_m_s[axis]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::flow::Flow;
    use crate::aero::lattice::LatticeOptions;
    use crate::aero::lattice_state::LatticeState;
    use crate::aero::surface::{Edge, Profile, Surface};
    use crate::aero::test_lattices::{chord, flow, options, section};
    use crate::load::SectionMotion;

    const SPEED_M_S: f64 = 12.0;
    const STEP_S: f64 = 0.02;

    /// Two surfaces at incidence: the outer one is folded back over the inner one by a fifth of a chord, or joined to it at an angle.
    fn lattice(load_rule: LoadRule, folded: bool, mirrored: bool) -> (VortexLattice, Vec<SectionMotion>) {
        let surface = |sections: std::ops::Range<usize>| Surface {
            chords: vec![chord(); sections.len()],
            sections,
            chord_panels: 3,
            profile: Profile::THIN,
        };
        let options = LatticeOptions {
            wake_rows: 6,
            core_radius_m: 0.01,
            load_rule,
            mirror_normal: mirrored.then(Vector3::x),
            speed_of_sound_m_s: Some(60.0),
            ..options()
        };
        let mut lattice = VortexLattice::new(vec![surface(0..4), surface(4..7)], options);
        if !folded {
            lattice.join([Edge { surface: 0, outer: true }, Edge { surface: 1, outer: false }]);
            lattice.join_image(Edge { surface: 0, outer: false });
        }
        // 0.88 strips from the image: neither one edge nor two
        let inner_m = if folded { 0.3 } else { 0.22 };
        let place = |section: usize| match (section, folded) {
            (0..4, _) => Vector3::new(inner_m + 0.5 * section as f64, 0.0, 0.01 * (section * section) as f64),
            (_, true) => Vector3::new(1.75 - 0.5 * (section - 4) as f64, 0.02, 0.28),
            (_, false) => Vector3::new(1.8 + 0.5 * (section - 4) as f64, 0.0, 0.1 + 0.2 * (section - 4) as f64),
        };
        let motion = |number: usize| section(place(number), -0.1 - 0.005 * number as f64);
        (lattice, (0..7).map(motion).collect())
    }

    /// U-62. The derivatives with respect to rings and nodes agree with those of complete solutions, in which the lattice sums its whole wake again:
    /// loads with and without suction, sheets close to each other or with a common edge, a mirror plane, compressible air.
    #[test]
    fn slopes_are_those_of_whole_answers() {
        for (load_rule, folded, mirrored) in [
            (LoadRule::Bernoulli, true, true),
            (LoadRule::KuttaJoukowski, true, false),
            (LoadRule::KuttaJoukowski, false, true),
        ] {
            let (mut lattice, motions) = lattice(load_rule, folded, mirrored);
            let flow = Flow {
                time_s: 0.0,
                density_kg_m3: 1.2,
                wind_m_s: Vector3::y() * -SPEED_M_S,
                spin_rad_s: Vector3::zeros(),
                gusts: &[],
            };
            let slopes = lattice.linear(&motions, &flow, STEP_S, false, &lattice.blank_state()).expect("linear");
            assert!(!folded || !lattice.facings.is_empty(), "no point sees another sheet closely");
            let mut about = lattice.about_steady(&motions, &flow, STEP_S, &lattice.blank_state()).expect("steady");
            let (columns, strips) = (lattice.wake_columns, lattice.wake_strips);
            let mut whole = |change: &mut dyn FnMut(&mut LatticeState, f64), step: f64| {
                let mut ends = [1.0, -1.0].map(|sign| {
                    let mut answer = Vec::new();
                    let kept = about.state.clone();
                    change(&mut about.state, sign * step);
                    lattice.answer(&mut about, &mut answer).expect("solved");
                    about.state = kept;
                    answer
                });
                let below = std::mem::take(&mut ends[1]);
                let pairs = ends[0].iter().zip(below);
                pairs.map(|(above, below)| (above - below) / (2.0 * step)).collect::<Vec<f64>>()
            };
            let rows = slopes.edge_row();
            for (row, strip) in [(0, 0), (0, 4), (1, 2), (5, 3)] {
                let ring = row * strips + strip;
                let expected = whole(&mut |state, amount| state.wake_circulation_m2_s[ring] += amount, 4.0);
                let got = slopes.wake.column(ring);
                let scale = expected[..rows].iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
                let off = (0..rows).map(|i| (got[i] - expected[i]).abs()).fold(0.0, f64::max);
                // round-off of sums of some hundred segments in another order
                assert!(scale > 1e-6 && off < 1e-11 * scale, "ring {row} {strip}: {off:e} of {scale:e}");
            }
            for (row, column) in [(1, 0), (1, 4), (2, 3), (6, 6)] {
                for part in 0..3 {
                    let node = row * columns + column;
                    let expected = whole(&mut |state, amount| state.wake_node_m[node][part] += amount, 1e-5);
                    let got = slopes.node.column(3 * ((row - 1) * columns + column) + part);
                    let scale = slopes.node.amax();
                    let off = (0..rows).map(|i| (got[i] - expected[i]).abs()).fold(0.0, f64::max);
                    // error of second order in 1e-5 m, and round-off of loads of a few newtons divided by that step
                    assert!(off < 1e-7 * scale, "node {row} {column} {part}: {off:e} of {scale:e}");
                }
            }
        }
    }

    /// Rows behind the last independent one are displaced with it: its derivatives agree with those of complete solutions in which all
    /// nodes of a column from there to the end of the wake move. Tolerance: 1e-12 of the loads, divided by the difference steps.
    #[test]
    fn rows_far_behind_move_with_the_last_one() {
        let chords = vec![chord(); 3];
        let surface = Surface { chords, sections: 0..3, chord_panels: 1, profile: Profile::THIN };
        let rows = MOVING_ROWS + 6;
        let options = LatticeOptions { wake_rows: rows, load_rule: LoadRule::KuttaJoukowski, ..options() };
        let mut lattice = VortexLattice::new(vec![surface], options);
        let motions: Vec<SectionMotion> = (0..3).map(|i| section(Vector3::x() * 0.8 * f64::from(i), -0.1)).collect();
        let flow = flow(Vector3::y() * -SPEED_M_S);
        let slopes = lattice.linear(&motions, &flow, 3.0 * STEP_S, false, &lattice.blank_state()).expect("linear");
        let mut about = lattice.about_steady(&motions, &flow, 3.0 * STEP_S, &lattice.blank_state()).expect("steady");
        let (columns, last) = (lattice.wake_columns, about.state.wake_rows);
        assert!(last > MOVING_ROWS && slopes.node.ncols() == 3 * columns * MOVING_ROWS);
        for (column, part) in [(0, 2), (1, 2), (2, 0)] {
            let [above, below] = [0.05, -0.05].map(|displacement_m| {
                let (kept, mut answer) = (about.state.clone(), Vec::new());
                for row in MOVING_ROWS..=last {
                    about.state.wake_node_m[row * columns + column][part] += displacement_m;
                }
                lattice.answer(&mut about, &mut answer).expect("solved");
                about.state = kept;
                answer
            });
            let got = slopes.node.column(3 * ((MOVING_ROWS - 1) * columns + column) + part);
            let scale = got.rows(0, slopes.edge_row()).amax();
            for i in 0..slopes.edge_row() {
                let expected = (above[i] - below[i]) / 0.1;
                assert!(
                    (got[i] - expected).abs() < 0.05 * scale,
                    "column {column}, part {part}, row {i}: {} {expected}",
                    got[i]
                );
            }
        }
    }

    /// U-74. The steady flow of the linearisation, in sideslip: loads and circulations are equal for steps of half a row and of two rows,
    /// which divide the same wake differently. Round-off, the core and the end of the wake have an effect below 1e-7.
    #[test]
    fn steady_flow_does_not_depend_on_the_step() {
        for load_rule in [LoadRule::Bernoulli, LoadRule::KuttaJoukowski] {
            let (mut lattice, motions) = lattice(load_rule, false, false);
            let flow = Flow {
                time_s: 0.0,
                density_kg_m3: 1.2,
                wind_m_s: Vector3::new(0.4, -1.0, 0.05) * SPEED_M_S,
                spin_rad_s: Vector3::zeros(),
                gusts: &[],
            };
            let mut answer = |step_s: f64| {
                let mut about = lattice.about_steady(&motions, &flow, step_s, &lattice.blank_state()).expect("steady");
                let mut rows = Vec::new();
                lattice.answer(&mut about, &mut rows).expect("solved");
                // the last rows are the start of the wake, which depends on the step
                rows.truncate(rows.len() - 3 * lattice.wake_columns);
                rows
            };
            let (short, long) = (answer(0.5 * STEP_S), answer(2.0 * STEP_S));
            let scale = long.iter().fold(0.0_f64, |most, row| most.max(row.abs()));
            let off = short.iter().zip(&long).map(|(short, long)| (short - long).abs()).fold(0.0, f64::max);
            assert!(off < 1e-7 * scale, "{off:e} of {scale:e}");
        }
    }
}
