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
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// Two edges that count as one where they are close: those of two surfaces, or one at the mirror plane and its image.
#[derive(Debug, Clone, Copy)]
pub(super) struct JoinedEdges {
    /// The edges; the same twice if the second is the image of the first.
    edges: [Edge; 2],
    /// Unit normal of the mirror plane, if the second edge is the image of the first.
    mirror_normal: Option<Vector3<f64>>,
}

impl JoinedEdges {
    /// The edges of surfaces with the sign of their shifts, see [`Shift`]: both, or the first if the second is its image.
    fn of_surfaces(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        [(0, 1.0), (1, -1.0)].into_iter().take(if self.mirror_normal.is_some() { 1 } else { 2 })
    }

    /// A position or velocity of one side in space, given that of its surface; or the other way round.
    fn of_side(&self, side: usize, vector: Vector3<f64>) -> Vector3<f64> {
        self.mirror_normal.filter(|_| side == 1).map_or(vector, |normal| reflected(&normal, &vector))
    }
}

/// A position or velocity reflected at a plane through the origin with this unit normal.
pub(super) fn reflected(normal: &Vector3<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
    vector - normal * (2.0 * normal.dot(vector))
}

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
            self.joined.push(JoinedEdges { edges, mirror_normal: None });
        }
    }

    /// Joins an edge that lies at the mirror plane with its image. Without a mirror plane there is none.
    pub fn join_image(&mut self, edge: Edge) {
        if self.kernel.mirror_normal.is_some() {
            self.joined.push(JoinedEdges { edges: [edge; 2], mirror_normal: self.kernel.mirror_normal });
        }
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
                [position_m, velocity_m_s, beside_m].map(|vector| joined.of_side(side, vector));
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
                for (side, sign) in joined.of_surfaces() {
                    self.shift_corners(joined.edges[side], row, sign, &shift, state);
                }
            }
            for row in 0..rows {
                let middle = (row as f64 + 0.75) / rows as f64;
                let shift_m = self.shift(&joined, middle, motions).position_m;
                for (side, sign) in joined.of_surfaces() {
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
        let corner = |side: usize, row, column| joined.of_side(side, state.corner_m[sheet(side).node(row, column)]);
        let columns = joined.edges.map(|edge| [self.column(edge), self.beside(edge)]);
        let rows = sheet(0).rows;
        let mut deepest_m = 0.0_f64;
        for row in 0..=rows {
            let ends_m = [0, 1].map(|side| columns[side].map(|column| corner(side, row, column)));
            for (own, _) in joined.of_surfaces() {
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
                    let middle_m = joined.of_side(own, pieces[own].middle_m);
                    let induced_m_s = self.edge_velocity_m_s(edges[other], &joined.of_side(other, middle_m), state);
                    joined.of_side(other, induced_m_s)
                });
                let alone_m_s = [0, 1].map(|own| joined.of_side(own, seen_m_s[own]) - mutual_m_s[own]);
                let mean_m_s = 0.5 * (alone_m_s[0] + alone_m_s[1]);
                // the image of a vortex turns the other way
                let turn = if joined.mirror_normal.is_some() { -1.0 } else { 1.0 };
                let vortex = pieces[0].vortex + turn * joined.of_side(1, pieces[1].vortex);
                let half_n = 0.5 * density_kg_m3 * mean_m_s.cross(&vortex);
                for (side, _) in joined.of_surfaces() {
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
mod tests {
    use super::*;
    use crate::aero::lattice::{LatticeOptions, LoadRule};
    use crate::aero::surface::{Profile, Surface};
    use crate::aero::test_lattices::{chord, flow, options, section};
    use crate::load::Wrench;

    /// Two adjacent wings in sideslip, whose common edges are a tenth of a strip apart. The loads do not depend on the order in which the
    /// edges or the wings are given.
    #[test]
    fn neither_body_of_a_joint_is_the_first() {
        let outwards_m = [[-2.0, -1.0, 0.0], [0.0, 1.0, 2.0]];
        let loads = |wings: [usize; 2], edges_swapped: bool| {
            let surface = |first: usize| Surface {
                sections: first..first + 3,
                chords: vec![chord(); 3],
                chord_panels: 3,
                profile: Profile::THIN,
            };
            let options =
                LatticeOptions { wake_rows: 5, core_radius_m: 1e-3, load_rule: LoadRule::KuttaJoukowski, ..options() };
            let mut lattice = VortexLattice::new(vec![surface(0), surface(3)], options);
            // the outer edge of the left wing and the inner edge of the right wing
            let mut edges = [0, 1].map(|surface| Edge { surface, outer: wings[surface] == 0 });
            if edges_swapped {
                edges.swap(0, 1);
            }
            lattice.join(edges);
            let motions: Vec<SectionMotion> = (wings.iter())
                .flat_map(|&wing| {
                    // one wing is higher and has another incidence: otherwise they would be mirror images
                    let [height_m, pitch_rad] = if wing == 0 { [0.0, 0.0] } else { [0.1, 0.05] };
                    outwards_m[wing].map(|x| (Vector3::new(x, 0.0, height_m), pitch_rad))
                })
                .map(|(position_m, pitch_rad)| section(position_m, pitch_rad))
                .collect();
            let flow = flow(Vector3::new(4.0, -10.0, 1.0));
            let (mut state, mut loads) = (lattice.blank_state(), AirLoads::still(6));
            lattice.start(&motions, &flow, None, &mut state, &mut loads).unwrap();
            let of = |wing: usize| {
                let first = 3 * usize::from(wings[0] != wing);
                loads.circulatory[first..first + 3].to_vec()
            };
            [of(0), of(1)].concat()
        };
        let expected = loads([0, 1], false);
        let largest_n = expected.iter().map(|load| load.force_n.norm()).fold(0.0, f64::max);
        for (wings, edges_swapped) in [([0, 1], true), ([1, 0], false), ([1, 0], true)] {
            for (own, expected) in loads(wings, edges_swapped).iter().zip(&expected) {
                let off_n = (own.force_n - expected.force_n).norm() + (own.moment_n_m - expected.moment_n_m).norm();
                assert!(off_n < 1e-11 * largest_n, "{wings:?} {edges_swapped}: {off_n:e} N of {largest_n}");
            }
        }
    }

    /// A left and a right wing of strips of 1 m with a joint at `x = 0`, the right one at a height and an incidence, in rigid motion.
    fn apart(
        height_m: f64,
        pitch_rad: f64,
        [velocity_m_s, spin_rad_s]: [Vector3<f64>; 2],
    ) -> (VortexLattice, LatticeState, Vec<SectionMotion>) {
        let surface = |first: usize| Surface {
            sections: first..first + 3,
            chords: vec![chord(); 3],
            chord_panels: 2,
            profile: Profile::THIN,
        };
        let mut lattice = VortexLattice::new(vec![surface(0), surface(3)], options());
        lattice.join([Edge { surface: 0, outer: true }, Edge { surface: 1, outer: false }]);
        let wings = [([-2.0, -1.0, 0.0], 0.0, 0.0), ([0.0, 1.0, 2.0], height_m, pitch_rad)];
        let motions: Vec<SectionMotion> = (wings.iter())
            .flat_map(|&(outwards_m, height_m, pitch_rad)| {
                outwards_m.map(|x| section(Vector3::new(x + 0.2 * height_m, 0.0, height_m), pitch_rad))
            })
            .map(|still| SectionMotion {
                velocity_m_s: velocity_m_s + spin_rad_s.cross(&still.position_m),
                spin_rad_s,
                ..still
            })
            .collect();
        let mut state = lattice.blank_state();
        state.wake_rows = 1;
        lattice.place(&motions, Some((&flow(Vector3::new(0.0, -10.0, 0.0)), 0.1)), &mut state);
        (lattice, state, motions)
    }

    /// Loads by the rule of Kutta and Joukowski at an incidence of 0.1, a surface for each list of sections.
    fn loads_of(
        wings: &[Vec<SectionMotion>],
        mirror_normal: Option<Vector3<f64>>,
        join: impl Fn(&mut VortexLattice),
    ) -> Vec<Wrench> {
        let surfaces = (wings.iter().enumerate()).map(|(at, wing)| Surface {
            sections: at * wing.len()..(at + 1) * wing.len(),
            chords: vec![chord(); wing.len()],
            chord_panels: 3,
            profile: Profile::THIN,
        });
        let options = LatticeOptions {
            wake_rows: 5,
            core_radius_m: 1e-3,
            load_rule: LoadRule::KuttaJoukowski,
            mirror_normal,
            ..options()
        };
        let mut lattice = VortexLattice::new(surfaces.collect(), options);
        join(&mut lattice);
        let motions = wings.concat();
        let (mut state, mut loads) = (lattice.blank_state(), AirLoads::still(motions.len()));
        lattice.start(&motions, &flow(Vector3::new(0.0, -10.0, 1.0)), None, &mut state, &mut loads).unwrap();
        loads.circulatory
    }

    /// Largest difference of forces and moments, relative to the largest force.
    fn largest_difference(loads: &[Wrench], expected: &[Wrench]) -> f64 {
        let largest_n = expected.iter().map(|load| load.force_n.norm()).fold(0.0, f64::max);
        let off = |(own, expected): (&Wrench, &Wrench)| {
            (own.force_n - expected.force_n).norm() + (own.moment_n_m - expected.moment_n_m).norm()
        };
        loads.iter().zip(expected).map(off).fold(0.0, f64::max) / largest_n
    }

    /// The right wing of three sections with a dihedral angle and an incidence, whose inner edge is at a distance from the plane `x = 0`,
    /// and its mirror image as a left wing.
    fn halves(from_plane_m: f64) -> [Vec<SectionMotion>; 2] {
        let section = |x: f64, side: f64| section(Vector3::new(side * (x + from_plane_m), 0.0, 0.3 * x), 0.05);
        [[2.0, 1.0, 0.0].map(|x| section(x, -1.0)).to_vec(), [0.0, 1.0, 2.0].map(|x| section(x, 1.0)).to_vec()]
    }

    const INNER: [Edge; 2] = [Edge { surface: 0, outer: true }, Edge { surface: 1, outer: false }];

    /// A half wing joined to its image has the loads of the right one of two halves, whether their edges count as one, as two, or as both to
    /// a share.
    #[test]
    fn an_image_is_the_other_half() {
        for apart_strips in [0.0, 0.3, 0.9, 1.1, 1.5] {
            let [left, right] = halves(0.5 * apart_strips * 1.09_f64.sqrt());
            let two = loads_of(&[left, right.clone()], None, |lattice| lattice.join(INNER));
            let one = loads_of(&[right], Some(Vector3::x()), |lattice| {
                lattice.join_image(Edge { surface: 0, outer: false });
            });
            let off = largest_difference(&one, &two[3..]);
            assert!(off < 1e-10, "{apart_strips}: {off:e}");
        }
    }

    /// The loads are continuous where edges begin to count as two and where they end to count as one. Between these distances the lines of
    /// both approach each other without limit; to the share to which they are one they induce nothing on each other.
    #[test]
    fn loads_are_continuous_where_edges_part() {
        let loads = |apart_strips: f64| {
            let wings = halves(0.5 * apart_strips * 1.09_f64.sqrt());
            loads_of(&wings, None, |lattice| lattice.join(INNER))
        };
        for border in MERGED_STRIPS {
            let off = largest_difference(&loads(border - 1e-5), &loads(border + 1e-5));
            assert!(off < 1e-4, "{border}: {off:e}");
        }
    }

    /// Edges up to 0.8 strips apart lie in the middle, from 1.2 strips on each lies on its own wing; in between they move towards each other
    /// by the share, with the point where the wake starts.
    #[test]
    fn edges_lie_in_the_middle_as_far_as_they_are_close() {
        for (apart_strips, share) in [(0.3, 1.0), (0.79, 1.0), (1.0, 0.5), (1.21, 0.0)] {
            let apart_m = apart_strips / 1.04_f64.sqrt(); // the height: a fifth of it lies along the span
            let (lattice, state, _) = apart(apart_m, 0.0, [Vector3::zeros(); 2]);
            let [left, right] = [(0, 2), (1, 0)].map(|(surface, column)| {
                let bound: Vec<f64> = (0..=3).map(|row| lattice.corner_m(&state, surface, row, column).z).collect();
                let wake_z = state.wake_node_m[lattice.wake[surface].node(0, column)].z;
                let edge_z = state.edge_m[lattice.wake[surface].node(0, column)].z;
                [&bound[..], &[wake_z, edge_z]].concat()
            });
            for (left, right) in left.iter().zip(&right) {
                assert!((left - 0.5 * share * apart_m).abs() < 1e-12, "{apart_m}: {left}");
                assert!((right - (1.0 - 0.5 * share) * apart_m).abs() < 1e-12, "{apart_m}: {right}");
            }
            // the other corners are those of the wings
            assert!(lattice.corner_m(&state, 1, 0, 1).z == apart_m && lattice.corner_m(&state, 0, 0, 1).z == 0.0);
        }
    }

    /// In a rigid motion of both wings the corners and the panels at joined edges have the velocities of that motion, and collocation points
    /// stay on the planes of their panels, in the middle between the lines of the strip.
    #[test]
    fn joined_edges_move_with_the_wings() {
        let motion = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -0.7, 1.1)];
        let rigid_m_s = |point_m: &Vector3<f64>| motion[0] + motion[1].cross(point_m);
        for height_m in [0.3, 1.0] {
            let (lattice, state, motions) = apart(height_m, 0.2, motion);
            for (surface, column) in [(0, 2), (1, 0)] {
                for row in 0..=2 {
                    let node = lattice.bound[surface].node(row, column);
                    let off_m_s = lattice.corner_velocity_m_s[node] - rigid_m_s(&state.corner_m[node]);
                    assert!(off_m_s.norm() < 1e-12, "{height_m}, {surface}, {row}: {off_m_s}");
                }
                let end = lattice.wake[surface].node(0, column);
                assert!((state.edge_m_s[end] - rigid_m_s(&state.edge_m[end])).norm() < 1e-12);
            }
            for (surface, strip, plane) in [(0, 1, 1), (1, 0, 4)] {
                for row in 0..2 {
                    let ring = lattice.bound[surface].ring(row, strip);
                    let point_m = state.collocation_m[ring];
                    assert!((state.surface_m_s[ring] - rigid_m_s(&point_m)).norm() < 1e-12, "{height_m}, {surface}");
                    let normal = motions[plane].rotation * Vector3::z();
                    assert!(normal.dot(&(point_m - motions[plane].position_m)).abs() < 1e-12, "{height_m}, {surface}");
                    let corner_m = |row, column| lattice.corner_m(&state, surface, row, column);
                    if height_m < 0.8 && row == 0 {
                        let middle_m: Vector3<f64> = [(0, strip), (0, strip + 1), (1, strip), (1, strip + 1)]
                            .map(|(row, at)| corner_m(row, at))
                            .iter()
                            .sum();
                        let off_m = normal.cross(&(0.25 * middle_m - point_m));
                        assert!(off_m.norm() < 1e-12, "{surface}: {off_m}");
                    }
                    let panel = 2 * 2 * surface + 2 * row + strip;
                    assert_eq!(lattice.points[panel / LANES].get(panel % LANES), point_m);
                }
            }
        }
    }

    /// A wing that folds over the strip of the other one overlaps it, however far apart the edges are; one that ends above it does not.
    #[test]
    fn sheets_that_overlap_are_found() {
        let overlap_m = |shift_m: f64, fold_rad: f64, raised_m: f64| {
            let (mut lattice, mut state, mut motions) = apart(0.0, 0.0, [Vector3::zeros(); 2]);
            for (column, motion) in motions[3..].iter_mut().enumerate() {
                let along = Vector3::new(fold_rad.cos(), 0.0, fold_rad.sin());
                motion.position_m = Vector3::new(-shift_m, 0.0, raised_m) + along * column as f64;
            }
            lattice.place(&motions, None, &mut state);
            lattice.crossed_edges.map(|crossed| (crossed.surfaces, crossed.depth_m))
        };
        // the right wing rises from below the left one, 1.5 and 1.9 strips inside of its edge
        for shift_m in [1.5, 1.9] {
            let (surfaces, depth_m) = overlap_m(shift_m, 1.0, -0.2).expect("an overlap");
            assert_eq!(surfaces, [0, 1]);
            assert!((depth_m - (shift_m - 0.2 / 1f64.tan())).abs() < 1e-12, "{depth_m}");
        }
        assert_eq!(overlap_m(0.5, 1.0, -0.2), None, "merged");
        assert_eq!(overlap_m(1.5, 1.0, 0.2), None, "above");
        assert_eq!(overlap_m(-1.5, 1.0, -0.2), None, "beside");
    }
}
