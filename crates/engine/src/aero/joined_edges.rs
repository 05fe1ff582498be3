//! Edges that two surfaces share at hinges, or that a surface shares with its image in a mirror plane, eq. (U12).
//!
//! Each surface has its own rings, so that a common edge has two lines of vorticity, whose sum is small and whose circulations are those of
//! whole strips. They are treated as one line: both lie in the middle between the two edges, they do not act on each other, and with the
//! Kutta-Joukowski rule both sections share the force on their sum equally. Lines separated by a flared hinge or by incidence by less than a
//! panel are closer than the lattice can resolve: on one side of the hinge the sheets would overlap there, which no grid resolves.

use crate::aero::AirLoads;
use crate::aero::biot_savart::{Block, LANES};
use crate::aero::lattice::VortexLattice;
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::{CROSSED_PANELS, CrossedSheets, ramp};
pub use crate::aero::surface::Edge;
use crate::aero::surface::{JoinedEdges, Sides};
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// One chordwise segment of an edge.
struct Piece {
    /// Index among the segments that carry forces.
    segment: usize,
    section: usize,
    middle_m: Vector3<f64>,
    /// Product of circulation and segment vector, in m³/s.
    vortex: Vector3<f64>,
    /// Lever arm of the force about the section's reference point, root frame, m.
    arm_m: Vector3<f64>,
}

/// A point of an edge and its velocity in the sections, root frame.
struct EdgePoint {
    position_m: Vector3<f64>,
    velocity_m_s: Vector3<f64>,
    /// Point with the same fraction of the chord at the other side of the adjacent strip.
    beside_m: Vector3<f64>,
}

/// Added by merging to a point of the first edge of a pair; its opposite is added to the point of the second.
struct Shift {
    position_m: Vector3<f64>,
    velocity_m_s: Vector3<f64>,
    /// Share, from 0 to 1, to which both points count as one.
    share: f64,
}

/// Distances of two edges in strips: up to the first they are merged, from the second they are separate. The first is the width that a
/// lattice resolves.
const MERGED_STRIPS: [f64; 2] = [0.8, 1.2];

/// Share, from 0 to 1, to which two joined edges count as one, by their distance and the mean width of the strips beside them.
pub(super) fn merged_share(apart_m: f64, strip_m: f64) -> f64 {
    1.0 - ramp(MERGED_STRIPS[0], MERGED_STRIPS[1], apart_m / strip_m)
}

/// Depth in m by which a sheet passes through the strip of another one beside their joint, 0 if it does not. Points of both at one fraction
/// of the chord: on the edge, then beyond the adjacent strip; `chord_m` and `strips` are those of the sheet that is passed.
pub(super) fn overlap_m(
    [edge_m, beside_m]: [Vector3<f64>; 2],
    chord_m: &Vector3<f64>,
    [near_m, far_m]: [Vector3<f64>; 2],
    strips: usize,
) -> f64 {
    let strip_m = beside_m - edge_m;
    let normal = strip_m.cross(chord_m);
    // the other sheet as far as the edges are apart, and a strip further
    let reach = 1.0 + (near_m - edge_m).norm() / (far_m - near_m).norm();
    let far_m = near_m + (far_m - near_m) * reach;
    let [near, far] = [near_m, far_m].map(|point_m| normal.dot(&(point_m - edge_m)));
    if near * far >= 0.0 {
        return 0.0;
    }
    // point at which the strip of the other sheet passes through the plane of this one
    let point_m = near_m + (far_m - near_m) * (near / (near - far));
    let across_m = strip_m - chord_m * (strip_m.dot(chord_m) / chord_m.norm_squared());
    let depth = across_m.dot(&(point_m - edge_m)) / across_m.norm_squared();
    let is_on_sheet = depth > CROSSED_PANELS && depth < strips as f64;
    if is_on_sheet { depth * across_m.norm() } else { 0.0 }
}

impl VortexLattice {
    /// Joins two edges of surfaces with the same number of chordwise panels, where their bodies are connected.
    pub fn join(&mut self, edges: [Edge; 2]) {
        let rows = edges.map(|edge| self.bound[edge.surface].rows);
        if rows[0] == rows[1] {
            self.joined.push(JoinedEdges { edges, sides: Sides::SURFACES });
        }
    }

    /// Joins an edge that lies at the mirror plane with its image. Without a mirror plane there is none.
    pub fn join_image(&mut self, edge: Edge) {
        let image = self.kernel.mirror_normal.map(Sides::image);
        self.joined.extend(image.map(|sides| JoinedEdges { edges: [edge; 2], sides }));
    }

    /// Whether two surfaces are joined at the edge given by this column of the first.
    pub(super) fn is_joined(&self, own: usize, column: usize, other: usize) -> bool {
        self.joined.iter().any(|joined| {
            let [one, two] = joined.edges;
            [[one, two], [two, one]]
                .iter()
                .any(|[one, two]| one.surface == own && two.surface == other && self.column(*one) == column)
        })
    }

    fn column(&self, edge: Edge) -> usize {
        if edge.outer { self.bound[edge.surface].strips } else { 0 }
    }

    /// Column at the other side of the strip that the edge bounds.
    fn beside(&self, edge: Edge) -> usize {
        if edge.outer { self.bound[edge.surface].strips - 1 } else { 1 }
    }

    fn edge_point(&self, edge: Edge, chord_fraction: f64, motions: &[SectionMotion]) -> EdgePoint {
        let surface = &self.surfaces[edge.surface];
        let section =
            |column: usize| (&motions[surface.sections.start + column], surface.chords[column].at(chord_fraction));
        let ((motion, point_m), (beside, beside_m)) = (section(self.column(edge)), section(self.beside(edge)));
        EdgePoint {
            position_m: motion.point_m(&point_m),
            velocity_m_s: motion.point_velocity_m_s(&point_m),
            beside_m: beside.point_m(&beside_m),
        }
    }

    /// Half the vector between two joined edges times the share to which they are merged.
    fn shift(&self, joined: &JoinedEdges, chord_fraction: f64, motions: &[SectionMotion]) -> Shift {
        let points = [0, 1].map(|side| {
            let EdgePoint { position_m, velocity_m_s, beside_m } =
                self.edge_point(joined.edges[side], chord_fraction, motions);
            let [position_m, velocity_m_s, beside_m] =
                [position_m, velocity_m_s, beside_m].map(|vector| joined.sides.of_side(side, vector));
            EdgePoint { position_m, velocity_m_s, beside_m }
        });
        let strips_m = points.iter().map(|point| (point.position_m - point.beside_m).norm()).sum::<f64>();
        let apart_m = points[1].position_m - points[0].position_m;
        let share = merged_share(apart_m.norm(), 0.5 * strips_m);
        let velocity_m_s = 0.5 * share * (points[1].velocity_m_s - points[0].velocity_m_s);
        Shift { position_m: 0.5 * share * apart_m, velocity_m_s, share }
    }

    /// Moves joined edges that are closer than the lattice resolves to the middle between both, with the collocation points beside them;
    /// finds joined sheets of which one still passes through the other.
    pub(super) fn merge_edges(&mut self, motions: &[SectionMotion], state: &mut LatticeState) {
        self.crossed_edges = None;
        for at in 0..self.joined.len() {
            let joined = self.joined[at];
            let rows = self.bound[joined.edges[0].surface].rows;
            for row in 0..=rows {
                let shift = self.shift(&joined, Self::chord_fraction(rows, row), motions);
                for (side, sign) in joined.sides.of_surfaces() {
                    self.shift_corners(joined.edges[side], row, sign, &shift, state);
                }
            }
            for row in 0..rows {
                let middle = (row as f64 + 0.75) / rows as f64;
                let shift_m = self.shift(&joined, middle, motions).position_m;
                for (side, sign) in joined.sides.of_surfaces() {
                    self.shift_panel(joined.edges[side], row, &(sign * shift_m), motions, state);
                }
            }
            self.crossed_edges = self.crossed_edges.or(self.overlap(&joined, state));
        }
    }

    /// Moves a corner of an edge; with the trailing edge also the corner behind it, where the wake starts.
    fn shift_corners(&mut self, edge: Edge, row: usize, sign: f64, shift: &Shift, state: &mut LatticeState) {
        let (sheet, column) = (self.bound[edge.surface], self.column(edge));
        let (shift_m, shift_m_s) = (sign * shift.position_m, sign * shift.velocity_m_s);
        let last = if row < sheet.rows { row } else { row + 1 };
        for node in (row..=last).map(|row| sheet.node(row, column)) {
            state.corner_m[node] += shift_m;
            self.corner_velocity_m_s[node] += shift_m_s;
        }
        if row == sheet.rows {
            let end = self.wake[edge.surface].node(0, column);
            state.wake_node_m[end] += shift_m;
            state.edge_m[end] += shift_m;
            state.edge_m_s[end] += shift_m_s;
        }
    }

    /// Moves the collocation point of a panel at an edge by half the shift of the edge there, within the panel: it stays in the middle
    /// between the lines of its strip, and the panel keeps the incidence of its body.
    fn shift_panel(
        &mut self,
        edge: Edge,
        row: usize,
        shift_m: &Vector3<f64>,
        motions: &[SectionMotion],
        state: &mut LatticeState,
    ) {
        let sheet = self.bound[edge.surface];
        let strip = if edge.outer { sheet.strips - 1 } else { 0 };
        let (ring, panel) = (sheet.ring(row, strip), self.first_panel[edge.surface] + row * sheet.strips + strip);
        let normal = self.panel_normal(panel);
        let moved_m = 0.5 * (shift_m - normal * normal.dot(shift_m));
        let section = self.surfaces[edge.surface].sections.start + self.column(edge);
        state.surface_m_s[ring] += motions[section].spin_rad_s.cross(&moved_m);
        state.collocation_m[ring] += moved_m;
        self.points[panel / LANES].set(panel % LANES, &state.collocation_m[ring]);
    }

    /// Whether one of two joined sheets passes through the strip of the other at their edge.
    fn overlap(&self, joined: &JoinedEdges, state: &LatticeState) -> Option<CrossedSheets> {
        let sheet = |side: usize| self.bound[joined.edges[side].surface];
        let corner =
            |side: usize, row, column| joined.sides.of_side(side, state.corner_m[sheet(side).node(row, column)]);
        let columns = joined.edges.map(|edge| [self.column(edge), self.beside(edge)]);
        let rows = sheet(0).rows;
        let mut deepest_m = 0.0_f64;
        for row in 0..=rows {
            let ends_m = [0, 1].map(|side| columns[side].map(|column| corner(side, row, column)));
            for (own, _) in joined.sides.of_surfaces() {
                let chord_m = corner(own, rows, columns[own][0]) - corner(own, 0, columns[own][0]);
                let depth_m = overlap_m(ends_m[own], &chord_m, ends_m[1 - own], sheet(own).strips);
                deepest_m = deepest_m.max(depth_m);
            }
        }
        let surfaces = joined.edges.map(|edge| edge.surface);
        (deepest_m > 0.0).then_some(CrossedSheets { surfaces, depth_m: deepest_m })
    }

    /// Index of the first segment of a surface in the order in which the loads are summed.
    fn first_segment(&self, surface: usize) -> usize {
        self.bound[..surface].iter().map(|sheet| sheet.rows * (2 * sheet.strips + 1)).sum()
    }

    fn piece(&self, edge: Edge, row: usize, motions: &[SectionMotion], state: &LatticeState) -> Piece {
        let (sheet, surface) = (&self.bound[edge.surface], &self.surfaces[edge.surface]);
        let column = self.column(edge);
        let corner = |row, column| state.corner_m[sheet.node(row, column)];
        let (from_m, to_m) = (corner(row, column), corner(row + 1, column));
        let middle = 0.5 * (Self::chord_fraction(sheet.rows, row) + Self::chord_fraction(sheet.rows, row + 1));
        let section = surface.sections.start + column;
        let circulation = self.bound_filaments.chordwise[sheet.node(row, column)];
        Piece {
            segment: self.first_segment(edge.surface) + row * (2 * sheet.strips + 1) + sheet.strips + column,
            section,
            middle_m: 0.5 * (from_m + to_m),
            vortex: circulation * (to_m - from_m),
            arm_m: motions[section].rotation * surface.chords[column].at(middle),
        }
    }

    /// Velocity in m/s that the bound vortices along an edge induce at a point.
    fn edge_velocity_m_s(&self, edge: Edge, point_m: &Vector3<f64>, state: &LatticeState) -> Vector3<f64> {
        let (sheet, column) = (&self.bound[edge.surface], self.column(edge));
        let mut point = Block::default();
        (0..LANES).for_each(|lane| point.set(lane, point_m));
        (0..sheet.rows)
            .map(|row| {
                let [from, to] = [row, row + 1].map(|row| sheet.node(row, column));
                let ends_m = [state.corner_m[from], state.corner_m[to]];
                self.bound_filaments.chordwise[from] * self.kernel.straight(ends_m, &point).get(0)
            })
            .sum()
    }

    /// Corrects the forces on joined edges; their velocities and separately computed forces are in `velocities` and `loads`.
    pub(super) fn join_loads(
        &self,
        motions: &[SectionMotion],
        density_kg_m3: f64,
        state: &LatticeState,
        loads: &mut AirLoads,
    ) {
        for joined in &self.joined {
            let edges = joined.edges;
            let rows = self.bound[edges[0].surface].rows;
            for row in 0..rows {
                let middle = 0.5 * (Self::chord_fraction(rows, row) + Self::chord_fraction(rows, row + 1));
                let share = self.shift(joined, middle, motions).share;
                if share <= 0.0 {
                    continue;
                }
                let pieces = edges.map(|edge| self.piece(edge, row, motions, state));
                let seen_m_s =
                    [0, 1].map(|side| self.velocities[pieces[side].segment / LANES].get(pieces[side].segment % LANES));
                // induced by the line on the other side
                let mutual_m_s = [0, 1].map(|own| {
                    let other = 1 - own;
                    let middle_m = joined.sides.of_side(own, pieces[own].middle_m);
                    let induced_m_s =
                        self.edge_velocity_m_s(edges[other], &joined.sides.of_side(other, middle_m), state);
                    joined.sides.of_side(other, induced_m_s)
                });
                let alone_m_s = [0, 1].map(|own| joined.sides.of_side(own, seen_m_s[own]) - mutual_m_s[own]);
                let mean_m_s = 0.5 * (alone_m_s[0] + alone_m_s[1]);
                // the image of a vortex turns the other way
                let turn = if joined.sides.is_image() { -1.0 } else { 1.0 };
                let vortex = pieces[0].vortex + turn * joined.sides.of_side(1, pieces[1].vortex);
                let half_n = 0.5 * density_kg_m3 * mean_m_s.cross(&vortex);
                for (side, _) in joined.sides.of_surfaces() {
                    let piece = &pieces[side];
                    let separate_n = density_kg_m3 * seen_m_s[side].cross(&piece.vortex);
                    let parted_m_s = alone_m_s[side] + (1.0 - share) * mutual_m_s[side];
                    let parted_n = density_kg_m3 * parted_m_s.cross(&piece.vortex);
                    let added_n = share * half_n + (1.0 - share) * parted_n - separate_n;
                    loads.circulatory[piece.section].add_force_at(&piece.arm_m, &added_n);
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "joined_edges_tests.rs"]
mod tests;
