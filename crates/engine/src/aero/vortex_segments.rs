//! Inner loops of the Biot-Savart law, written for the SIMD vectors of the processor.
//!
//! The vectors are explicit because compilers do not vectorise square roots of arrays, which halves the speed. Each lane undergoes the same
//! operations in the same order for any vector width, without fused multiply-add: results are bit-identical on all processors.

use crate::aero::images::Stretch;
use crate::aero::sheet::{Block, Filaments, LANES, Sheet};
use nalgebra::Vector3;
use pulp::{Simd, WithSimd};
use std::f64::consts::PI;

/// One number for each point of a block.
type Lane = [f64; LANES];

/// Vectors from a node to the points of a block: components and smoothed distance.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub struct Arm {
    xyz: [Lane; 3],
    distance: Lane,
    /// Normal velocity induced by the segment from the previous column's node to this node.
    spanwise: Lane,
}

/// Returns one SIMD vector of a lane array.
#[inline(always)]
fn part_of<S: Simd>(lane: &Lane, part: usize) -> S::f64s {
    S::as_simd_f64s(lane).0[part]
}

/// Sets one SIMD vector of a lane array.
#[inline(always)]
fn set_part<S: Simd>(lane: &mut Lane, part: usize, value: S::f64s) {
    S::as_mut_simd_f64s(lane).0[part] = value;
}

/// Three components, each a SIMD vector of points.
type Three<V> = [V; 3];

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &Three<S::f64s>, b: &Three<S::f64s>) -> S::f64s {
    let first = simd.add_f64s(simd.mul_f64s(a[0], b[0]), simd.mul_f64s(a[1], b[1]));
    simd.add_f64s(first, simd.mul_f64s(a[2], b[2]))
}

/// Cross product.
#[inline(always)]
fn cross<S: Simd>(simd: S, a: &Three<S::f64s>, b: &Three<S::f64s>) -> Three<S::f64s> {
    let mut product = *a;
    for (entry, [i, j]) in product.iter_mut().zip([[1, 2], [2, 0], [0, 1]]) {
        *entry = simd.sub_f64s(simd.mul_f64s(a[i], b[j]), simd.mul_f64s(a[j], b[i]));
    }
    product
}

/// Adds a vector to a sum.
#[inline(always)]
fn add<S: Simd>(simd: S, sum: &mut Three<S::f64s>, part: Three<S::f64s>) {
    for (sum, part) in sum.iter_mut().zip(part) {
        *sum = simd.add_f64s(*sum, part);
    }
}

/// Product of a number and a vector.
#[inline(always)]
fn times<S: Simd>(simd: S, factor: S::f64s, vector: &Three<S::f64s>) -> Three<S::f64s> {
    let mut product = *vector;
    for entry in &mut product {
        *entry = simd.mul_f64s(factor, *entry);
    }
    product
}

/// Vector from a node: components and smoothed distance.
#[derive(Clone, Copy)]
struct Reach<V> {
    xyz: Three<V>,
    distance: V,
}

impl Arm {
    #[inline(always)]
    fn set<S: Simd>(&mut self, part: usize, reach: &Reach<S::f64s>) {
        for (lane, value) in self.xyz.iter_mut().zip(reach.xyz) {
            set_part::<S>(lane, part, value);
        }
        set_part::<S>(&mut self.distance, part, reach.distance);
    }

    #[inline(always)]
    fn get<S: Simd>(&self, part: usize) -> Reach<S::f64s> {
        let [x, y, z] = &self.xyz;
        Reach {
            xyz: [part_of::<S>(x, part), part_of::<S>(y, part), part_of::<S>(z, part)],
            distance: part_of::<S>(&self.distance, part),
        }
    }
}

/// Vortex core and compressibility stretching as SIMD vectors.
#[derive(Clone, Copy)]
struct Smooth<V> {
    core_squared: V,
    /// Axis and excess of [`Stretch`].
    stretch: Option<(Three<V>, V)>,
}

impl<V: Copy> Smooth<V> {
    #[inline(always)]
    fn new<S: Simd<f64s = V>>(simd: S, core_squared_m2: f64, stretch: Option<&Stretch>) -> Self {
        let splat = |value: f64| simd.splat_f64s(value);
        let stretch = stretch.map(|stretch| {
            ([splat(stretch.axis.x), splat(stretch.axis.y), splat(stretch.axis.z)], splat(stretch.excess))
        });
        Self { core_squared: splat(core_squared_m2), stretch }
    }

    /// Vector from a node to some points, stretched if the air is compressible.
    #[inline(always)]
    fn reach<S: Simd<f64s = V>>(&self, simd: S, points_m: &Three<V>, node_m: &Vector3<f64>) -> Reach<V> {
        let [x, y, z] = points_m;
        let mut xyz = [
            simd.sub_f64s(*x, simd.splat_f64s(node_m.x)),
            simd.sub_f64s(*y, simd.splat_f64s(node_m.y)),
            simd.sub_f64s(*z, simd.splat_f64s(node_m.z)),
        ];
        if let Some((axis, excess)) = &self.stretch {
            let along = simd.mul_f64s(*excess, dot(simd, &xyz, axis));
            for (coordinate, component) in xyz.iter_mut().zip(axis) {
                *coordinate = simd.add_f64s(*coordinate, simd.mul_f64s(along, *component));
            }
        }
        let squares = dot(simd, &xyz, &xyz);
        Reach { xyz, distance: simd.sqrt_f64s(simd.add_f64s(squares, self.core_squared)) }
    }

    /// Numerator and denominator of a segment's strength, eq. (U1).
    #[inline(always)]
    fn strength<S: Simd<f64s = V>>(&self, simd: S, from: &Reach<V>, to: &Reach<V>) -> [V; 2] {
        let product = simd.mul_f64s(from.distance, to.distance);
        let sum = simd.add_f64s(simd.add_f64s(product, dot(simd, &from.xyz, &to.xyz)), self.core_squared);
        [simd.add_f64s(from.distance, to.distance), simd.mul_f64s(product, sum)]
    }

    /// Factor by which the cross product of the vectors to the ends of a segment is multiplied to give `4π` times the velocity induced at
    /// unit circulation, eq. (U1).
    #[inline(always)]
    fn one_strength<S: Simd<f64s = V>>(&self, simd: S, from: &Reach<V>, to: &Reach<V>) -> V {
        let [above, below] = self.strength(simd, from, to);
        simd.div_f64s(above, below)
    }

    /// As `one_strength`, for two segments that end at the same node: they share one division, because divisions limit the speed of the
    /// kernels.
    #[inline(always)]
    fn two_strengths<S: Simd<f64s = V>>(&self, simd: S, from: [&Reach<V>; 2], to: &Reach<V>) -> [V; 2] {
        let [above, below] = self.strength(simd, from[0], to);
        let [other_above, other_below] = self.strength(simd, from[1], to);
        let share = simd.div_f64s(simd.splat_f64s(1.0), simd.mul_f64s(below, other_below));
        let own = simd.mul_f64s(simd.mul_f64s(above, other_below), share);
        let other = simd.mul_f64s(simd.mul_f64s(other_above, below), share);
        [own, other]
    }

    /// `4π` times the velocity induced by a straight segment of given circulation from one node to another.
    #[inline(always)]
    fn segment<S: Simd<f64s = V>>(&self, simd: S, circulation_m2_s: f64, from: &Reach<V>, to: &Reach<V>) -> Three<V> {
        let strength = simd.mul_f64s(simd.splat_f64s(circulation_m2_s), self.one_strength(simd, from, to));
        cross(simd, &times(simd, strength, &from.xyz), &to.xyz)
    }

    /// As `segment`, for two segments that end at the same node: they share one cross product.
    #[inline(always)]
    fn two_segments<S: Simd<f64s = V>>(
        &self,
        simd: S,
        circulations_m2_s: [f64; 2],
        from: [&Reach<V>; 2],
        to: &Reach<V>,
    ) -> Three<V> {
        let [own, other] = self.two_strengths(simd, from, to);
        let [own_m2_s, other_m2_s] = circulations_m2_s;
        let mut arm = times(simd, simd.mul_f64s(simd.splat_f64s(own_m2_s), own), &from[0].xyz);
        add(simd, &mut arm, times(simd, simd.mul_f64s(simd.splat_f64s(other_m2_s), other), &from[1].xyz));
        cross(simd, &arm, &to.xyz)
    }
}

/// One SIMD vector of the points of a block.
#[inline(always)]
fn points<S: Simd>(block: &Block, part: usize) -> Three<S::f64s> {
    let [x, y, z] = &block.xyz;
    [part_of::<S>(x, part), part_of::<S>(y, part), part_of::<S>(z, part)]
}

/// `4π` times the velocity of one sheet at the points of a block, not yet stretched.
pub(super) struct SheetVelocity<'a> {
    pub sheet: &'a Sheet,
    pub nodes_m: &'a [Vector3<f64>],
    pub filaments: &'a Filaments,
    pub points_m: &'a Block,
    /// Scratch for two rows of nodes.
    pub arms: &'a mut [Arm],
    pub core_squared_m2: f64,
    pub stretch: Option<&'a Stretch>,
}

impl WithSimd for SheetVelocity<'_> {
    type Output = Block;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Block {
        let Self { sheet, nodes_m, filaments, points_m, arms, core_squared_m2, stretch } = self;
        let smooth = Smooth::new(simd, core_squared_m2, stretch);
        let columns = sheet.strips + 1;
        let mut velocity = Block::default();
        for part in 0..LANES / S::F64_LANES {
            let points_m = points::<S>(points_m, part);
            let mut sum = [simd.splat_f64s(0.0); 3];
            let (mut ahead, mut here) = arms[..2 * columns].split_at_mut(columns);
            for row in 0..=sheet.rows {
                let nodes = &nodes_m[sheet.node(row, 0)..][..columns];
                let spanwise = &filaments.spanwise[sheet.ring(row, 0)..][..sheet.strips];
                let mut last = smooth.reach(simd, &points_m, &nodes[0]);
                here[0].set::<S>(part, &last);
                if row == 0 {
                    for ((node, circulation), arm) in nodes[1..].iter().zip(spanwise).zip(&mut here[1..]) {
                        let reach = smooth.reach(simd, &points_m, node);
                        arm.set::<S>(part, &reach);
                        add(simd, &mut sum, smooth.segment(simd, *circulation, &last, &reach));
                        last = reach;
                    }
                } else if !sheet.has_spanwise(row) {
                    let chordwise = &filaments.chordwise[sheet.node(row - 1, 0)..][..columns];
                    add(simd, &mut sum, smooth.segment(simd, chordwise[0], &ahead[0].get::<S>(part), &last));
                    let arms = here[1..].iter_mut().zip(&ahead[1..]);
                    for ((node, circulation), (arm, before)) in nodes[1..].iter().zip(&chordwise[1..]).zip(arms) {
                        let reach = smooth.reach(simd, &points_m, node);
                        arm.set::<S>(part, &reach);
                        add(simd, &mut sum, smooth.segment(simd, *circulation, &before.get::<S>(part), &reach));
                    }
                } else {
                    let chordwise = &filaments.chordwise[sheet.node(row - 1, 0)..][..columns];
                    add(simd, &mut sum, smooth.segment(simd, chordwise[0], &ahead[0].get::<S>(part), &last));
                    let circulations = spanwise.iter().zip(&chordwise[1..]);
                    let arms = here[1..].iter_mut().zip(&ahead[1..]);
                    for ((node, (along_span, along_chord)), (arm, before)) in
                        nodes[1..].iter().zip(circulations).zip(arms)
                    {
                        let reach = smooth.reach(simd, &points_m, node);
                        arm.set::<S>(part, &reach);
                        let from = [&last, &before.get::<S>(part)];
                        add(simd, &mut sum, smooth.two_segments(simd, [*along_span, *along_chord], from, &reach));
                        last = reach;
                    }
                }
                std::mem::swap(&mut ahead, &mut here);
            }
            for (lane, sum) in velocity.xyz.iter_mut().zip(sum) {
                set_part::<S>(lane, part, sum);
            }
        }
        velocity
    }
}

/// Adds to a column-major matrix with `rows` rows the velocity that unit rings of a sheet induce at the points of a block along `normals`,
/// which are already stretched. The columns of a row of rings are contiguous from `first_column(row)`; the points start at row `first` of
/// the matrix. Every entry is read and written once, when the last segment of its ring is known.
pub(super) struct RingInfluence<'a, F> {
    pub sheet: &'a Sheet,
    pub nodes_m: &'a [Vector3<f64>],
    pub points_m: &'a Block,
    pub normals: &'a Block,
    /// Scratch for two rows of nodes.
    pub arms: &'a mut [Arm],
    pub matrix: &'a mut [f64],
    pub place: (usize, usize),
    pub first_column: F,
    pub core_squared_m2: f64,
    pub stretch: Option<&'a Stretch>,
}

impl<F: Fn(usize) -> usize> WithSimd for RingInfluence<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { sheet, nodes_m, points_m, normals, arms, matrix, place, first_column, core_squared_m2, stretch } =
            self;
        let smooth = Smooth::new(simd, core_squared_m2, stretch);
        let (rows, first) = place;
        let columns = sheet.strips + 1;
        let share = simd.splat_f64s(1.0 / (4.0 * PI));
        for part in 0..LANES / S::F64_LANES {
            let (points_m, normals) = (points::<S>(points_m, part), points::<S>(normals, part));
            let (mut ahead, mut here) = arms[..2 * columns].split_at_mut(columns);
            for row in 0..=sheet.rows {
                let nodes = &nodes_m[sheet.node(row, 0)..][..columns];
                let mut last = smooth.reach(simd, &points_m, &nodes[0]);
                here[0].set::<S>(part, &last);
                if row == 0 {
                    for (node, arm) in nodes[1..].iter().zip(&mut here[1..]) {
                        let reach = smooth.reach(simd, &points_m, node);
                        let along = dot(simd, &last.xyz, &cross(simd, &reach.xyz, &normals));
                        arm.set::<S>(part, &reach);
                        let spanwise = simd.mul_f64s(smooth.one_strength(simd, &last, &reach), along);
                        set_part::<S>(&mut arm.spanwise, part, spanwise);
                        last = reach;
                    }
                    std::mem::swap(&mut ahead, &mut here);
                    continue;
                }
                let before = ahead[0].get::<S>(part);
                let along = dot(simd, &before.xyz, &cross(simd, &last.xyz, &normals));
                let mut inner = simd.mul_f64s(smooth.one_strength(simd, &before, &last), along);
                let entries = matrix[first_column(row - 1) * rows..].chunks_exact_mut(rows);
                let arms = here[1..].iter_mut().zip(&ahead[1..]);
                let has_spanwise = sheet.has_spanwise(row);
                for ((node, (arm, before)), entries) in nodes[1..].iter().zip(arms).zip(entries) {
                    let reach = smooth.reach(simd, &points_m, node);
                    arm.set::<S>(part, &reach);
                    let leading = part_of::<S>(&before.spanwise, part);
                    let before = before.get::<S>(part);
                    // (from × to)·n = from·(to × n): one cross product serves both segments that end here
                    let turned = cross(simd, &reach.xyz, &normals);
                    let along_side = dot(simd, &before.xyz, &turned);
                    let (spanwise, outer) = if has_spanwise {
                        let [own, other] = smooth.two_strengths(simd, [&last, &before], &reach);
                        let along = dot(simd, &last.xyz, &turned);
                        (simd.mul_f64s(own, along), simd.mul_f64s(other, along_side))
                    } else {
                        let other = smooth.one_strength(simd, &before, &reach);
                        (simd.splat_f64s(0.0), simd.mul_f64s(other, along_side))
                    };
                    set_part::<S>(&mut arm.spanwise, part, spanwise);
                    let entry = &mut S::as_mut_simd_f64s(&mut entries[first..][..LANES]).0[part];
                    let ring = simd.sub_f64s(simd.sub_f64s(leading, inner), spanwise);
                    *entry = simd.add_f64s(*entry, simd.mul_f64s(simd.add_f64s(ring, outer), share));
                    (inner, last) = (outer, reach);
                }
                std::mem::swap(&mut ahead, &mut here);
            }
        }
    }
}

/// `4π` times the velocity of a straight segment of unit circulation at the points of a block.
pub(super) struct Straight<'a> {
    pub ends_m: [Vector3<f64>; 2],
    pub points_m: &'a Block,
    pub core_squared_m2: f64,
}

impl WithSimd for Straight<'_> {
    type Output = Block;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Block {
        let smooth = Smooth::new(simd, self.core_squared_m2, None);
        let mut velocity = Block::default();
        for part in 0..LANES / S::F64_LANES {
            let points_m = points::<S>(self.points_m, part);
            let [from, to] = self.ends_m.map(|end_m| smooth.reach(simd, &points_m, &end_m));
            for (lane, value) in velocity.xyz.iter_mut().zip(smooth.segment(simd, 1.0, &from, &to)) {
                set_part::<S>(lane, part, value);
            }
        }
        velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, Scalar};

    /// U-63. Any vector width gives bit-identical results: the vectors of this processor and scalar code are compared.
    #[test]
    fn width_of_the_vectors_does_not_matter() {
        let sheet = Sheet {
            rows: 3,
            strips: 4,
            first_node: 0,
            node_stride: 5,
            first_ring: 0,
            ring_stride: 4,
            joined_rear: false,
        };
        let node = |i: usize| Vector3::new((i % 5) as f64, -((i / 5) as f64), (0.3 * (i * i) as f64).sin());
        let nodes_m: Vec<_> = (0..20).map(node).collect();
        let mut filaments = Filaments::new(16, 20);
        filaments.gather(&sheet, &(0..16).map(|i| (0.7 * f64::from(i)).cos()).collect::<Vec<_>>());
        let (mut points_m, mut normals) = (Block::default(), Block::default());
        for lane in 0..LANES {
            points_m.set(lane, &Vector3::new(0.4 * lane as f64, -0.3, 0.1 + 0.2 * lane as f64));
            normals.set(lane, &Vector3::new(0.1, 0.2, lane as f64).normalize());
        }
        let stretched = Stretch { axis: Vector3::new(0.0, 0.6, 0.8), excess: 0.3 };
        for stretch in [None, Some(&stretched)] {
            let (points_m, normals, nodes_m) = (&points_m, &normals, &nodes_m[..]);
            let mut arms = [vec![Arm::default(); 10], vec![Arm::default(); 10]];
            let [wide, single] = arms.each_mut().map(|arms| SheetVelocity {
                sheet: &sheet,
                nodes_m,
                filaments: &filaments,
                points_m,
                arms,
                core_squared_m2: 1e-4,
                stretch,
            });
            let wide = Arch::new().dispatch(wide);
            assert_eq!(wide, single.with_simd(Scalar::new()));
            assert!(wide.xyz.iter().flatten().all(|entry| entry.abs() > 1e-6));
            let mut matrices = [vec![0.0; 12 * LANES], vec![0.0; 12 * LANES]];
            let mut operands = arms.iter_mut().zip(&mut matrices).map(|(arms, matrix)| RingInfluence {
                sheet: &sheet,
                nodes_m,
                points_m,
                normals,
                arms,
                matrix,
                place: (LANES, 0),
                first_column: |row: usize| 4 * row,
                core_squared_m2: 1e-4,
                stretch,
            });
            Arch::new().dispatch(operands.next().expect("the first"));
            operands.next().expect("the second").with_simd(Scalar::new());
            drop(operands);
            assert_eq!(matrices[0], matrices[1]);
            assert!(matrices[0].iter().all(|entry| entry.abs() > 1e-9));
        }
    }

    /// U-83. A sheet whose last two rows have equal circulations induces the same velocity without the segments between them, which cancel,
    /// to the round-off of sums of numbers below one.
    #[test]
    fn joined_rows_need_no_segments_between_them() {
        let plain = Sheet {
            rows: 3,
            strips: 4,
            first_node: 0,
            node_stride: 5,
            first_ring: 0,
            ring_stride: 4,
            joined_rear: false,
        };
        let node = |i: usize| Vector3::new((i % 5) as f64, -((i / 5) as f64), (0.3 * (i * i) as f64).sin());
        let nodes_m: Vec<_> = (0..20).map(node).collect();
        let mut filaments = Filaments::new(16, 20);
        let circulation = |i: usize| (0.7 * if i < 8 { i } else { i - 4 } as f64).cos();
        filaments.gather(&plain, &(0..16).map(circulation).collect::<Vec<_>>());
        let (mut points_m, mut normals) = (Block::default(), Block::default());
        for lane in 0..LANES {
            points_m.set(lane, &Vector3::new(0.4 * lane as f64, -1.9, 0.1 + 0.2 * lane as f64));
            normals.set(lane, &Vector3::new(0.1, 0.2, lane as f64).normalize());
        }
        let found = [false, true].map(|joined_rear| {
            let (sheet, mut arms) = (Sheet { joined_rear, ..plain }, vec![Arm::default(); 10]);
            let (points_m, normals, nodes_m, core_squared_m2) = (&points_m, &normals, &nodes_m[..], 1e-4);
            let (sheet, stretch, filaments) = (&sheet, None, &filaments);
            let velocity =
                SheetVelocity { sheet, nodes_m, filaments, points_m, arms: &mut arms, core_squared_m2, stretch };
            let velocity = Arch::new().dispatch(velocity);
            let mut matrix = vec![0.0; 8 * LANES];
            let first_column = |row: usize| 4 * row.min(1);
            let (arms, place) = (&mut arms[..], (LANES, 0));
            let rings = RingInfluence {
                sheet,
                nodes_m,
                points_m,
                normals,
                arms,
                matrix: &mut matrix,
                place,
                first_column,
                core_squared_m2,
                stretch,
            };
            Arch::new().dispatch(rings);
            velocity.xyz.into_iter().flatten().chain(matrix).collect::<Vec<f64>>()
        });
        for (with, without) in found[0].iter().zip(&found[1]) {
            assert!((with - without).abs() < 1e-14 && with.abs() > 1e-9, "{with} {without}");
        }
    }
}
