//! Edges that two surfaces share at hinges, for the Kutta-Joukowski rule, eq. (U12).
//!
//! Each surface has its own rings, so that a common edge has two lines of vorticity, whose sum is small and whose circulations are those of
//! whole strips. They are treated as one line: they do not act on each other, and both sections share the force on their sum equally. Lines
//! separated by a flared hinge by less than a panel are closer than the lattice can resolve.

use crate::aero::AirLoads;
use crate::aero::biot_savart::{Block, LANES};
use crate::aero::lattice::VortexLattice;
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::nearness;
pub use crate::aero::surface::Edge;
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
    /// Width of the adjacent strip in m.
    strip_m: f64,
}

impl VortexLattice {
    /// Joins two edges of surfaces with the same number of chordwise panels, where their bodies are connected.
    pub fn join(&mut self, edges: [Edge; 2]) {
        let rows = edges.map(|edge| self.bound[edge.surface].rows);
        if rows[0] == rows[1] {
            self.joined.push(edges);
        }
    }

    /// Whether two surfaces are joined at the edge given by this column of the first.
    pub(super) fn is_joined(&self, own: usize, column: usize, other: usize) -> bool {
        self.joined.iter().any(|pair| {
            [[pair[0], pair[1]], [pair[1], pair[0]]]
                .iter()
                .any(|[one, two]| one.surface == own && two.surface == other && self.column(*one) == column)
        })
    }

    fn column(&self, edge: Edge) -> usize {
        if edge.outer { self.bound[edge.surface].strips } else { 0 }
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
        let beside = if edge.outer { column - 1 } else { 1 };
        let circulation = self.bound_filaments.chordwise[sheet.node(row, column)];
        Piece {
            segment: self.first_segment(edge.surface) + row * (2 * sheet.strips + 1) + sheet.strips + column,
            section,
            middle_m: 0.5 * (from_m + to_m),
            vortex: circulation * (to_m - from_m),
            arm_m: motions[section].rotation * surface.chords[column].at(middle),
            strip_m: (from_m - corner(row, beside)).norm(),
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
        for pair in &self.joined {
            for row in 0..self.bound[pair[0].surface].rows {
                let pieces = pair.map(|edge| self.piece(edge, row, motions, state));
                let apart_m = (pieces[0].middle_m - pieces[1].middle_m).norm();
                let share = nearness(apart_m / (0.5 * (pieces[0].strip_m + pieces[1].strip_m)));
                if share <= 0.0 {
                    continue;
                }
                let seen_m_s =
                    [0, 1].map(|own| self.velocities[pieces[own].segment / LANES].get(pieces[own].segment % LANES));
                let alone_m_s = [0, 1]
                    .map(|own| seen_m_s[own] - self.edge_velocity_m_s(pair[1 - own], &pieces[own].middle_m, state));
                let mean_m_s = 0.5 * (alone_m_s[0] + alone_m_s[1]);
                let half_n = 0.5 * density_kg_m3 * mean_m_s.cross(&(pieces[0].vortex + pieces[1].vortex));
                for (piece, seen_m_s) in pieces.iter().zip(&seen_m_s) {
                    let separate_n = density_kg_m3 * seen_m_s.cross(&piece.vortex);
                    loads.circulatory[piece.section].add_force_at(&piece.arm_m, &(share * (half_n - separate_n)));
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
}
