//! Lifting line through the strips: downwash at the sections due to the trailing vortices of a wing of finite span.
//!
//! Every strip is a horseshoe vortex: a bound vortex at the quarter chord and, from each of its ends, a leg along the chord to the trailing
//! edge and on along the relative flow. Their velocity at three quarters of the chord, minus that of an infinite bound vortex, is the
//! velocity that strip theory neglects, eqs. (W10)–(W12). For a thin profile in steady flow this is the vortex lattice with a single
//! chordwise panel.

use crate::aero::biot_savart::{Arm, Block, Kernel, LANES, Sheet, blocks};
use crate::aero::flow::Flow;
use crate::aero::joined_edges::{merged_share, overlap_m};
use crate::aero::linear_system::LinearSystem;
use crate::aero::near_sheets::CrossedSheets;
use crate::aero::strip::section::Strip;
use crate::aero::surface::Sides;
use crate::load::SectionMotion;
use crate::math::wide::wide;
use nalgebra::Vector3;
use pulp::Arch;
use std::f64::consts::PI;

/// Length of the legs divided by the diameter of the line: the part beyond contributes `1/(4·200²)` of the near part.
const LEG_DIAMETERS: f64 = 200.0;

/// Settings of the lifting line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftingLineOptions {
    /// Radius of the vortex core in m, positive.
    pub core_radius_m: f64,
    /// Unit normal of a mirror plane through the origin of the root frame.
    pub mirror_normal: Option<Vector3<f64>>,
}

/// Edges of a strip and the relative flow at them, root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StripEdges {
    /// Leading and trailing edge at the inner and at the outer section, in m.
    at_m: [[Vector3<f64>; 2]; 2],
    /// Velocity in m/s of the air, without gusts, relative to the downstream edge, at both sections.
    air_m_s: [Vector3<f64>; 2],
    /// Velocity in m/s of the air, without gusts, relative to the point where the forces on the chordwise leg act, at both sections.
    leg_air_m_s: [Vector3<f64>; 2],
    /// `γ` of eq. (W4): which edge is upstream.
    bias: f64,
}

impl StripEdges {
    /// Evaluates the edges and the relative flow of a strip at one instant.
    pub fn of(strip: &Strip, motions: &[SectionMotion], flow: &Flow, bias: f64) -> Self {
        let ends = [0, 1].map(|end| (&motions[strip.sections[end]], &strip.chords[end]));
        let air_at = |fraction: f64| {
            ends.map(|(motion, chord)| {
                let place_m = chord.at(fraction);
                flow.convection_m_s(&motion.point_m(&place_m)) - motion.point_velocity_m_s(&place_m)
            })
        };
        let at_m =
            ends.map(|(motion, chord)| [chord.leading_m, chord.trailing_m].map(|edge_m| motion.point_m(&edge_m)));
        let behind = if bias < 0.0 { 0.0 } else { 1.0 };
        Self { at_m, air_m_s: air_at(behind), leg_air_m_s: air_at(leg_fraction(bias)), bias }
    }

    /// Leading and trailing edge at mid-span of the strip, in m.
    fn middle_m(&self) -> [Vector3<f64>; 2] {
        [0, 1].map(|edge| 0.5 * (self.at_m[0][edge] + self.at_m[1][edge]))
    }

    /// Unit vector along the quarter-chord line.
    fn along(&self) -> Vector3<f64> {
        (between(&self.at_m[1], 0.25) - between(&self.at_m[0], 0.25)).normalize()
    }

    /// Unit vectors normal to the strip, upward, and normal to the quarter-chord line, towards the trailing edge: eq. (W1).
    fn normals(&self) -> (Vector3<f64>, Vector3<f64>) {
        let ([leading_m, trailing_m], along) = (self.middle_m(), self.along());
        let up = (trailing_m - leading_m).cross(&along).normalize();
        (up, along.cross(&up))
    }

    /// Chord normal to the quarter-chord line in m.
    fn chord_m(&self) -> f64 {
        let [leading_m, trailing_m] = self.middle_m();
        (trailing_m - leading_m).dot(&self.normals().1)
    }

    /// Chordwise position of the bound vortex as a fraction: a quarter chord downstream of the upstream edge.
    fn bound_fraction(&self) -> f64 {
        if self.bias < 0.0 { 0.75 } else { 0.25 }
    }

    /// Vectors from the bound vortex to the downstream edge, at the inner and the outer section, in m.
    fn legs_m(&self) -> [Vector3<f64>; 2] {
        let share = if self.bias < 0.0 { -0.75 } else { 0.75 };
        self.at_m.map(|[leading_m, trailing_m]| (trailing_m - leading_m) * share)
    }

    /// Circulation of the vortices divided by `Γ` of eq. (W7), such that the Kutta-Joukowski theorem gives the plate's lift with suction.
    fn share(&self) -> f64 {
        self.bias * (self.bias.abs() + 1.0 - self.bias * self.bias)
    }
}

/// Fraction of the chord at which the forces on its leg act. The circulation of a flat plate, and with it that of the leg, grows along the
/// chord, so that the mean is 7/12, not the 5/8 of a single vortex at the quarter chord.
fn leg_fraction(bias: f64) -> f64 {
    if bias < 0.0 { 5.0 / 12.0 } else { 7.0 / 12.0 }
}

/// Interpolates linearly between two points: fraction 0 is the first, 1 the second.
fn between(edges: &[Vector3<f64>; 2], fraction: f64) -> Vector3<f64> {
    edges[0] + (edges[1] - edges[0]) * fraction
}

/// The edge of a surface at which it is joined to another one or to its image.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineEnd {
    /// Index of the surface.
    pub surface: usize,
    /// Number of its strips.
    pub strips: usize,
    /// Index among all strips of the strip at this edge.
    pub strip: usize,
    /// End of that strip: 0 inner, 1 outer.
    pub end: usize,
}

/// An edge that two surfaces share, or a surface and its image.
#[derive(Debug, Clone, Copy)]
struct SharedEdge {
    /// The edges; the same twice if the second is the image of the first.
    ends: [LineEnd; 2],
    sides: Sides,
}

impl SharedEdge {
    /// The leading or the trailing edge (0 or 1) of the strip of one side, at the shared end and at the other one, in m.
    fn ends_m(&self, side: usize, edges: &[StripEdges], edge: usize) -> [Vector3<f64>; 2] {
        let LineEnd { strip, end, .. } = self.ends[side];
        [end, 1 - end].map(|end| self.sides.of_side(side, edges[strip].at_m[end][edge]))
    }
}

/// Coefficients of the equation of one strip, eq. (W11): `Γ = k (e + b w_Γ)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct StripEquation {
    /// `k`: circulation per effective downwash in m.
    pub slope_m: f64,
    /// `e`: effective downwash without the velocity induced by the line at the end of the step, in m/s.
    pub effective_m_s: f64,
    /// `b`: fraction of that induced velocity that is effective without lag.
    pub gain: f64,
}

/// Mutual influence of the strips, and scratch for their equations.
#[derive(Debug, Clone)]
pub(super) struct LiftingLine {
    kernel: Kernel,
    arch: Arch,
    rows: usize,
    /// Normal velocity at each strip (row) due to unit circulation `Γ` of each strip (column), 1/m.
    influence: Vec<f64>,
    system: LinearSystem,
    /// Coefficients for each strip.
    pub equations: Vec<StripEquation>,
    right: Vec<f64>,
    /// Normal velocity that the line induces at each strip in m/s.
    pub induced_m_s: Vec<f64>,
    edges: Vec<StripEdges>,
    /// The same with shared edges in the middle, eq. (U12), where the vortices lie.
    merged: Vec<StripEdges>,
    shared: Vec<SharedEdge>,
    /// Share, from 0 to 1, to which the leg at each end of a strip coincides with its image.
    imaged: Vec<[f64; 2]>,
    /// Surfaces that overlap at a shared edge, as placed last.
    pub overlap: Option<CrossedSheets>,
    nodes_m: Vec<Vector3<f64>>,
    sheets: Vec<Sheet>,
    points: Vec<Block>,
    normals: Vec<Block>,
    arms: Vec<Arm>,
}

impl LiftingLine {
    pub fn new(strips: usize, options: &LiftingLineOptions) -> Self {
        let rows = blocks(strips) * LANES;
        Self {
            kernel: Kernel {
                core_squared_m2: options.core_radius_m * options.core_radius_m,
                mirror_normal: options.mirror_normal,
                ground: None,
                stretch: None,
            },
            arch: Arch::new(),
            rows,
            influence: vec![0.0; strips * rows],
            system: LinearSystem::new(strips, rows),
            equations: vec![StripEquation::default(); strips],
            right: vec![0.0; strips],
            induced_m_s: vec![0.0; strips],
            edges: Vec::with_capacity(strips),
            merged: Vec::with_capacity(strips),
            shared: Vec::new(),
            imaged: vec![[0.0; 2]; strips],
            overlap: None,
            nodes_m: vec![Vector3::zeros(); 6 * strips],
            sheets: Vec::with_capacity(strips),
            points: vec![Block::default(); blocks(strips)],
            normals: vec![Block::default(); blocks(strips)],
            arms: vec![Arm::default(); 2 * (strips + 1)],
        }
    }

    /// Computes the mutual influence of the strips at their current positions, eq. (W10).
    ///
    /// `turn` returns the sine and cosine of the zero-lift angle of a strip.
    pub fn look(
        &mut self,
        strips: &[Strip],
        edges: impl Iterator<Item = StripEdges>,
        turn: impl Fn(&Strip) -> (f64, f64),
    ) {
        self.edges.clear();
        self.edges.extend(edges);
        self.merge();
        self.lay(strips);
        for (at, (strip, edges)) in strips.iter().zip(&self.edges).enumerate() {
            let (up, aft) = edges.normals();
            let (sine, cosine) = turn(strip);
            let (block, lane) = (at / LANES, at % LANES);
            let [own_m, merged_m] =
                [edges, &self.merged[at]].map(|edges| between(&edges.middle_m(), 1.0 - edges.bound_fraction()));
            // in the middle between the vortices of the strip, on its plane
            let moved_m = merged_m - own_m;
            self.points[block].set(lane, &(own_m + moved_m - up * up.dot(&moved_m)));
            self.normals[block].set(lane, &(up * cosine - aft * sine));
        }
        self.influence.fill(0.0);
        let (kernel, arch, rows) = (self.kernel, self.arch, self.rows);
        let Self { sheets, nodes_m, points, normals, arms, influence, .. } = self;
        wide(
            arch,
            #[inline(always)]
            || {
                for (block, (points, normals)) in points.iter().zip(normals.iter()).enumerate() {
                    for sheet in sheets.iter() {
                        let of = |_: usize| sheet.first_ring;
                        kernel.influence(sheet, nodes_m, points, normals, arms, influence, (rows, block * LANES), of);
                    }
                }
            },
        );
        for (at, edges) in self.edges.iter().enumerate() {
            let column = &mut self.influence[at * rows..][..rows];
            column.iter_mut().for_each(|entry| *entry *= edges.share());
            // strip theory already includes the velocity of an infinite bound vortex
            let height_m = 0.5 * edges.chord_m();
            let endless = height_m / (2.0 * PI * (height_m * height_m + kernel.core_squared_m2));
            column[at] += edges.share().abs() * endless;
        }
    }

    /// Adds an edge that two surfaces share.
    pub fn join(&mut self, ends: [LineEnd; 2]) {
        self.shared.push(SharedEdge { ends, sides: Sides::SURFACES });
    }

    /// Adds an edge that a surface shares with its image. Without a mirror plane there is none.
    pub fn join_image(&mut self, end: LineEnd) {
        let image = self.kernel.mirror_normal.map(Sides::image);
        self.shared.extend(image.map(|sides| SharedEdge { ends: [end; 2], sides }));
    }

    /// Places shared edges that are closer than the strips resolve in the middle between both, eq. (U12), and finds surfaces that still
    /// overlap.
    fn merge(&mut self) {
        self.merged.clone_from(&self.edges);
        self.overlap = None;
        for at in 0..self.shared.len() {
            let shared = self.shared[at];
            let shares = [0, 1].map(|edge| self.merge_edge(&shared, edge));
            if shared.sides.is_image() {
                let LineEnd { strip, end, .. } = shared.ends[0];
                self.imaged[strip][end] = shares[0].min(shares[1]);
            }
            self.overlap = self.overlap.or(self.overlap_at(&shared));
        }
    }

    /// Merges the leading or the trailing edge (0 or 1) of both sides; returns the share to which they count as one.
    fn merge_edge(&mut self, shared: &SharedEdge, edge: usize) -> f64 {
        let [one_m, two_m] = [0, 1].map(|side| shared.ends_m(side, &self.edges, edge));
        let strip_m = 0.5 * ((one_m[1] - one_m[0]).norm() + (two_m[1] - two_m[0]).norm());
        let apart_m = two_m[0] - one_m[0];
        let share = merged_share(apart_m.norm(), strip_m);
        let air_m_s = |of: fn(&StripEdges) -> &[Vector3<f64>; 2]| {
            let [one_m_s, two_m_s] = [0, 1].map(|side| {
                let LineEnd { strip, end, .. } = shared.ends[side];
                shared.sides.of_side(side, of(&self.edges[strip])[end])
            });
            two_m_s - one_m_s
        };
        let [behind_m_s, leg_m_s] = [air_m_s(|edges| &edges.air_m_s), air_m_s(|edges| &edges.leg_air_m_s)];
        for (side, sign) in shared.sides.of_surfaces() {
            let LineEnd { strip, end, .. } = shared.ends[side];
            let (half, merged) = (0.5 * share * sign, &mut self.merged[strip]);
            merged.at_m[end][edge] += half * apart_m;
            // the velocities once: the legs leave the strips at the downstream edge
            if edge == usize::from(self.edges[shared.ends[0].strip].bias >= 0.0) {
                merged.air_m_s[end] += half * behind_m_s;
                merged.leg_air_m_s[end] += half * leg_m_s;
            }
        }
        share
    }

    /// Whether the surfaces on the two sides of a merged edge overlap there.
    fn overlap_at(&self, shared: &SharedEdge) -> Option<CrossedSheets> {
        let mut deepest_m = 0.0_f64;
        for (own, _) in shared.sides.of_surfaces() {
            let ends_m = |side: usize, edge: usize| shared.ends_m(side, &self.merged, edge);
            let chord_m = ends_m(own, 1)[0] - ends_m(own, 0)[0];
            for edge in 0..2 {
                let strips = shared.ends[own].strips;
                let depth_m = overlap_m(ends_m(own, edge), &chord_m, ends_m(1 - own, edge), strips);
                deepest_m = deepest_m.max(depth_m);
            }
        }
        let surfaces = shared.ends.map(|side| side.surface);
        (deepest_m > 0.0).then_some(CrossedSheets { surfaces, depth_m: deepest_m })
    }

    /// Sets the nodes of the horseshoes: one ring on the chord and one in the wake. Adjacent strips with the same leading edge share their
    /// legs.
    fn lay(&mut self, strips: &[Strip]) {
        let edges = &self.merged;
        let first_m = edges.first().map_or(Vector3::zeros(), |edges| edges.at_m[0][0]);
        let places_m = edges.iter().flat_map(|edges| edges.at_m.iter().flatten());
        let leg_m = 2.0 * LEG_DIAMETERS * places_m.map(|place_m| (place_m - first_m).norm()).fold(0.0, f64::max);
        self.sheets.clear();
        let (mut next_node, mut at) = (0, 0);
        while at < strips.len() {
            let fraction = edges[at].bound_fraction();
            let goes_on =
                |next: usize| strips[next].surface == strips[at].surface && edges[next].bound_fraction() == fraction;
            let end = (at + 1..strips.len()).find(|next| !goes_on(*next)).unwrap_or(strips.len());
            let (own, columns) = (end - at, end - at + 1);
            for column in 0..columns {
                let (strip, side) = if column < own { (at + column, 0) } else { (end - 1, 1) };
                let edge_m = edges[strip].at_m[side][usize::from(fraction < 0.5)];
                let direction = edges[strip].air_m_s[side].try_normalize(0.0).unwrap_or_default();
                let node_m = between(&edges[strip].at_m[side], fraction);
                for (row, place_m) in [node_m, edge_m, edge_m + direction * leg_m].into_iter().enumerate() {
                    self.nodes_m[next_node + row * columns + column] = place_m;
                }
            }
            self.sheets.push(Sheet {
                rows: 2,
                strips: own,
                first_node: next_node,
                node_stride: columns,
                first_ring: at,
                ring_stride: own,
                joined_rear: false,
            });
            next_node += 3 * columns;
            at = end;
        }
    }

    /// Forces in N on the chordwise legs of a strip of circulation `Γ`, at its inner and its outer section, and the fraction of the chord
    /// at which they act, eq. (W16). Zero for a leg that coincides with its image, because they cancel each other.
    pub fn leg_forces_n(
        &self,
        strip: usize,
        circulation_m2_s: f64,
        gust_m_s: &Vector3<f64>,
        density_kg_m3: f64,
    ) -> ([Vector3<f64>; 2], f64) {
        let edges = &self.merged[strip];
        let legs_m = edges.legs_m();
        let bound_kg_m_s = density_kg_m3 * edges.share() * circulation_m2_s;
        // the vortex runs up the inner leg and down the outer one
        let forces_n = [(0, -bound_kg_m_s), (1, bound_kg_m_s)].map(|(end, circulation)| {
            let alone = 1.0 - self.imaged[strip][end];
            (edges.leg_air_m_s[end] + gust_m_s).cross(&legs_m[end]) * (alone * circulation)
        });
        (forces_n, leg_fraction(edges.bias))
    }

    /// Solves for the circulations and fills [`LiftingLine::induced_m_s`], eq. (W11). The values are NaN if there is no solution.
    pub fn induce(&mut self) {
        let (strips, rows) = (self.equations.len(), self.rows);
        let matrix = self.system.cleared();
        for column in 0..strips {
            let entries = matrix[column * rows..][..strips].iter_mut();
            for ((entry, influence), equation) in entries.zip(&self.influence[column * rows..]).zip(&self.equations) {
                *entry = -equation.slope_m * equation.gain * influence;
            }
            matrix[column * rows + column] += 1.0;
        }
        for (right, equation) in self.right.iter_mut().zip(&self.equations) {
            *right = equation.slope_m * equation.effective_m_s;
        }
        match self.system.factorize(self.arch) {
            Ok(()) => self.system.solve(self.arch, &mut self.right),
            Err(_) => self.right.fill(f64::NAN),
        }
        self.induced_m_s.fill(0.0);
        for (column, circulation_m2_s) in self.right.iter().enumerate() {
            for (induced_m_s, influence) in self.induced_m_s.iter_mut().zip(&self.influence[column * rows..]) {
                *induced_m_s += influence * circulation_m2_s;
            }
        }
    }
}

impl PartialEq for LiftingLine {
    /// Compares the settings only; everything else is scratch.
    fn eq(&self, other: &Self) -> bool {
        self.kernel == other.kernel && self.equations.len() == other.equations.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::surface::ChordLine;
    use crate::aero::test_lattices::{chord, flow, section};

    /// In a rigid motion of two joined wings, whose edges are 0.3 strips apart, the air meets the legs at their common edge with the
    /// velocity of that motion, at the trailing edge and where their forces act.
    #[test]
    fn joined_legs_move_with_the_wings() {
        let motion = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -0.7, 1.1)];
        let air_m_s = |point_m: &Vector3<f64>| -(motion[0] + motion[1].cross(point_m));
        let motions: Vec<SectionMotion> = [(-1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.3, 0.1), (1.0, 0.3, 0.1)]
            .map(|(x, height_m, pitch_rad)| section(Vector3::new(x, 0.0, height_m), pitch_rad))
            .map(|still| SectionMotion {
                velocity_m_s: motion[0] + motion[1].cross(&still.position_m),
                spin_rad_s: motion[1],
                ..still
            })
            .to_vec();
        let chords: [ChordLine; 2] = [chord(); 2];
        let strips = [0, 1].map(|surface| Strip {
            sections: [2 * surface, 2 * surface + 1],
            chords,
            surface,
            lift_slope_1_rad: 2.0 * PI,
            speed_of_sound_m_s: f64::INFINITY,
        });
        let options = LiftingLineOptions { core_radius_m: 1e-3, mirror_normal: None };
        let mut line = LiftingLine::new(2, &options);
        line.join([0, 1].map(|side| LineEnd { surface: side, strips: 1, strip: side, end: 1 - side }));
        let edges = strips.each_ref().map(|strip| StripEdges::of(strip, &motions, &flow(Vector3::zeros()), 1.0));
        line.look(&strips, edges.into_iter(), |_| (0.0, 1.0));
        for (strip, end) in [(0, 1), (1, 0)] {
            let merged = &line.merged[strip];
            assert!((merged.at_m[end][1] - edges[strip].at_m[end][1]).norm() > 0.1, "not merged");
            let leg_m = between(&merged.at_m[end], leg_fraction(1.0));
            assert!((merged.leg_air_m_s[end] - air_m_s(&leg_m)).norm() < 1e-12, "{strip}");
            assert!((merged.air_m_s[end] - air_m_s(&merged.at_m[end][1])).norm() < 1e-12, "{strip}");
        }
    }
}
