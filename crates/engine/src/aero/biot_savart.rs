//! Velocity induced by vortex sheets of quadrilateral rings: segment by segment, for eight points at a time.
//!
//! The vortex core is that of Rosenhead and Moore: every distance `|r|` becomes `√(r² + δ²)`. A straight segment then has a closed form
//! without singularities and branches, and the field is that of a smooth vorticity distribution (closed rings cancel exactly). Bound and
//! wake vorticity use the same core radius: a larger one in the wake alone would break the cancellation at the trailing edge.
//!
//! Lanes run over points, never over segments, so that results depend neither on the width of the processor's vectors nor on the number of
//! threads.

use crate::aero::images::{Plane, Stretch};
pub use crate::aero::sheet::{Block, Filaments, LANES, Sheet, blocks};
pub use crate::aero::vortex_segments::Arm;
use crate::aero::vortex_segments::{RingInfluence, SheetVelocity, Straight};
use nalgebra::Vector3;
use pulp::Arch;
use std::f64::consts::PI;

/// Kernel of the induced velocity at points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// Square of the core radius in m².
    pub core_squared_m2: f64,
    /// Unit normal of a mirror plane through the origin.
    pub mirror_normal: Option<Vector3<f64>>,
    /// Ground plane, normal to the mirror plane: a second mirror, eq. (U23).
    pub ground: Option<Plane>,
    /// Prandtl-Glauert stretching for compressible air.
    pub stretch: Option<Stretch>,
}

impl Kernel {
    /// Adds the velocity in m/s that the sheets induce at some points. `arms` is scratch for two rows of nodes.
    ///
    /// The velocity induced by a mirror image at a point is the reflection of the velocity of the original at the reflected point, eq.
    /// (U2).
    pub fn induce(
        &self,
        sheets: &[Sheet],
        nodes_m: &[Vector3<f64>],
        filaments: &Filaments,
        points_m: &Block,
        arms: &mut [Arm],
        velocity_m_s: &mut Block,
    ) {
        let arch = Arch::new();
        let mut of = |sheet: &Sheet, points_m: &Block| {
            let (core_squared_m2, stretch) = (self.core_squared_m2, self.stretch.as_ref());
            let arms = &mut *arms;
            let sum =
                arch.dispatch(SheetVelocity { sheet, nodes_m, filaments, points_m, arms, core_squared_m2, stretch });
            stretch.map_or(sum, |stretch| sum.stretched(stretch))
        };
        for sheet in sheets {
            let own = of(sheet, points_m);
            velocity_m_s.add(1.0 / (4.0 * PI), &own);
            if let Some(normal) = &self.mirror_normal {
                let image = of(sheet, &points_m.mirrored(normal));
                velocity_m_s.add(1.0 / (4.0 * PI), &image.mirrored(normal));
            }
            if let Some(ground) = &self.ground {
                let below_m = points_m.below(ground);
                let image = of(sheet, &below_m);
                velocity_m_s.add(1.0 / (4.0 * PI), &image.mirrored(&ground.normal));
                if let Some(normal) = &self.mirror_normal {
                    let image = of(sheet, &below_m.mirrored(normal));
                    velocity_m_s.add(1.0 / (4.0 * PI), &image.mirrored(normal).mirrored(&ground.normal));
                }
            }
        }
    }

    /// Velocity in m/s induced by a straight segment of unit circulation at some points, without its image.
    pub fn straight(&self, ends_m: [Vector3<f64>; 2], points_m: &Block) -> Block {
        let unit = Arch::new().dispatch(Straight { ends_m, points_m, core_squared_m2: self.core_squared_m2 });
        let mut velocity = Block::default();
        velocity.add(1.0 / (4.0 * PI), &unit);
        velocity
    }

    /// Adds to a column-major matrix with `rows` rows the normal velocity that unit rings of a sheet induce at some points, eq. (U4). The
    /// columns of a row of rings are contiguous from `first_column(row)`; the points start at row `first` of the matrix.
    #[expect(clippy::too_many_arguments, reason = "a kernel: every argument is one plain operand of its loops")]
    pub fn influence(
        &self,
        sheet: &Sheet,
        nodes_m: &[Vector3<f64>],
        points_m: &Block,
        normals: &Block,
        arms: &mut [Arm],
        matrix: &mut [f64],
        (rows, first): (usize, usize),
        first_column: impl Fn(usize) -> usize,
    ) {
        let (arch, core_squared_m2) = (Arch::new(), self.core_squared_m2);
        let mut add = |points_m: &Block, normals: &Block| {
            let (stretch, arms, matrix, first_column) =
                (self.stretch.as_ref(), &mut *arms, &mut *matrix, &first_column);
            // the component of the stretched velocity along a normal equals that of the velocity along the stretched normal
            let normals = &stretch.map_or(*normals, |stretch| normals.stretched(stretch));
            let place = (rows, first);
            arch.dispatch(RingInfluence {
                sheet,
                nodes_m,
                points_m,
                normals,
                arms,
                matrix,
                place,
                first_column,
                core_squared_m2,
                stretch,
            });
        };
        add(points_m, normals);
        if let Some(normal) = &self.mirror_normal {
            add(&points_m.mirrored(normal), &normals.mirrored(normal));
        }
        if let Some(ground) = &self.ground {
            let (below_m, turned) = (points_m.below(ground), normals.mirrored(&ground.normal));
            add(&below_m, &turned);
            if let Some(normal) = &self.mirror_normal {
                add(&below_m.mirrored(normal), &turned.mirrored(normal));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_CORE: Kernel = Kernel { core_squared_m2: 0.0, mirror_normal: None, ground: None, stretch: None };

    /// Velocity induced at a point by a sheet with unit circulation in some of its rings.
    fn velocity(
        kernel: Kernel,
        rows: usize,
        strips: usize,
        nodes_m: &[Vector3<f64>],
        point_m: Vector3<f64>,
    ) -> Vector3<f64> {
        let sheet = Sheet {
            rows,
            strips,
            first_node: 0,
            node_stride: strips + 1,
            first_ring: 0,
            ring_stride: strips,
            joined_rear: false,
        };
        let mut filaments = Filaments::new((rows + 1) * strips, nodes_m.len());
        filaments.gather(&sheet, &vec![1.0; rows * strips]);
        let (mut points_m, mut sum) = (Block::default(), Block::default());
        (0..LANES).for_each(|lane| points_m.set(lane, &(point_m + Vector3::repeat(lane as f64))));
        let mut arms = vec![Arm::default(); 2 * (strips + 1)];
        kernel.induce(&[sheet], nodes_m, &filaments, &points_m, &mut arms, &mut sum);
        sum.get(0)
    }

    fn rectangle(length_m: f64, width_m: f64) -> Vec<Vector3<f64>> {
        let corner = |x: f64, y: f64| Vector3::new(x * length_m, y * width_m, 0.0);
        vec![corner(-0.5, 0.5), corner(0.5, 0.5), corner(-0.5, -0.5), corner(0.5, -0.5)]
    }

    /// Velocity in the middle of a rectangular ring `a × b` of unit circulation: `2√(a² + b²)/(πab)` (Katz and Plotkin). The first segment
    /// runs along `+x` on the side of `+y`, so that the velocity is along `−z`.
    #[test]
    fn velocity_in_the_middle_of_a_rectangle() {
        let (a, b) = (3.0_f64, 2.0_f64);
        let got = velocity(NO_CORE, 1, 1, &rectangle(a, b), Vector3::zeros());
        approx::assert_relative_eq!(got.z, -2.0 * a.hypot(b) / (PI * a * b), max_relative = 1e-14);
        assert_eq!((got.x, got.y), (0.0, 0.0));
    }

    /// Close to one side of a very long ring the velocity is that of an infinite line, `1/(2πh)`, and with a core `h/(2π(h² + δ²))`. The
    /// other sides, 500 m and 1000 m away, contribute 5e-4 m/s.
    #[test]
    fn velocity_beside_a_long_line() {
        let nodes_m: Vec<_> = rectangle(1e3, 1e3).iter().map(|node| node - Vector3::y() * 0.5e3).collect();
        let height_m = 0.3;
        let point_m = Vector3::new(0.0, 0.0, height_m);
        for core_m in [0.0, 0.1] {
            let kernel = Kernel { core_squared_m2: core_m * core_m, mirror_normal: None, ground: None, stretch: None };
            let got = velocity(kernel, 1, 1, &nodes_m, point_m);
            let expected = height_m / (2.0 * PI * (height_m * height_m + core_m * core_m));
            assert!((got.norm() - expected).abs() < 1e-3, "{got} for {expected}");
            // right-hand rule about +x, above the line: along −y
            assert!(got.y < 0.0, "{got}");
        }
    }

    /// At a large distance a ring is a doublet given by its vector area: `u = (3(m·e)e − m)/(4πr³)`. The next term is of order `(size/r)²`.
    #[test]
    fn distant_ring_is_a_doublet() {
        let point_m = Vector3::new(40.0, 30.0, 50.0);
        let moment = Vector3::z() * -1.0;
        let got = velocity(NO_CORE, 1, 1, &rectangle(1.0, 1.0), point_m);
        let (along, distance_m) = (point_m.normalize(), point_m.norm());
        let expected = (3.0 * moment.dot(&along) * along - moment) / (4.0 * PI * distance_m.powi(3));
        assert!((got - expected).norm() < 1e-3 * expected.norm(), "{got} {expected}");
    }

    /// Rings of equal circulation have no vorticity inside the sheet: it is equivalent to the ring around its edge.
    #[test]
    fn sheet_of_equal_rings_is_its_rim() {
        let node = |i: usize| Vector3::new((i % 4) as f64 - 1.5, 1.0 - (i / 4) as f64, 0.0);
        let many: Vec<_> = (0..12).map(node).collect();
        let point_m = Vector3::new(0.2, 0.4, 0.7);
        let difference =
            velocity(NO_CORE, 2, 3, &many, point_m) - velocity(NO_CORE, 1, 1, &rectangle(3.0, 2.0), point_m);
        assert!(difference.norm() < 1e-15, "{difference}");
    }

    /// At a node, on a segment and on its extension the velocity is finite and almost equal to that nearby (the field is smooth on the
    /// scale of the core, with gradients below `1/(2πδ²)`).
    #[test]
    fn velocity_is_smooth_through_the_core() {
        let core_m = 0.05;
        let kernel = Kernel { core_squared_m2: core_m * core_m, mirror_normal: None, ground: None, stretch: None };
        for point_m in [Vector3::new(-0.5, 0.5, 0.0), Vector3::new(0.1, 0.5, 0.0), Vector3::new(0.9, 0.5, 0.0)] {
            let at = velocity(kernel, 1, 1, &rectangle(1.0, 1.0), point_m);
            let near = velocity(kernel, 1, 1, &rectangle(1.0, 1.0), point_m + Vector3::repeat(1e-6));
            let steepest = 2.0 / (2.0 * PI * core_m * core_m);
            assert!(at.norm().is_finite() && (near - at).norm() < steepest * 2e-6, "{point_m}: {at} {near}");
        }
    }

    /// The image induces the velocity of a mirrored ring of opposite direction; no air flows through the plane.
    #[test]
    fn image_is_a_mirrored_ring() {
        let kernel = Kernel { mirror_normal: Some(Vector3::x()), ..NO_CORE };
        let nodes_m: Vec<_> = rectangle(1.0, 1.0).iter().map(|node| node + Vector3::new(2.0, 0.1, 0.3)).collect();
        let on_plane = velocity(kernel, 1, 1, &nodes_m, Vector3::new(0.0, 0.7, -0.4));
        assert!(on_plane.x.abs() < 1e-16 && on_plane.norm() > 1e-3, "{on_plane}");
        // columns are exchanged: the mirrored ring runs along +x again
        let mirrored: Vec<_> =
            [1, 0, 3, 2].iter().map(|i| nodes_m[*i]).map(|node| Vector3::new(-node.x, node.y, node.z)).collect();
        let point_m = Vector3::new(0.5, 0.7, -0.4);
        let both = velocity(NO_CORE, 1, 1, &nodes_m, point_m) + velocity(NO_CORE, 1, 1, &mirrored, point_m);
        assert!((velocity(kernel, 1, 1, &nodes_m, point_m) - both).norm() < 1e-15);
    }

    /// The kernels use the processor's SIMD vectors: without its cargo feature the dispatching crate silently falls back to scalars, at
    /// half the speed.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn kernels_are_dispatched_to_wide_vectors() {
        let wide = std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
        assert_eq!(matches!(pulp::Arch::new(), pulp::Arch::Scalar), !wide);
    }
}
