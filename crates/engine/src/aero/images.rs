//! The ground as a mirror, and the stretching that relates compressible to incompressible flow.

use crate::aero::sheet::{Block, LANES};
use nalgebra::Vector3;

/// A plane that mirrors the flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit normal, pointing to the side of the wing.
    pub normal: Vector3<f64>,
    /// Distance in m of the root frame's origin from the plane, positive on that side.
    pub distance_m: f64,
}

/// Prandtl-Glauert stretching along the flow, which relates compressible to incompressible flow, eq. (U22).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Unit vector along the flow.
    pub axis: Vector3<f64>,
    /// Stretching factor minus 1: `1/√(1 − M²) − 1`.
    pub excess: f64,
}

impl Block {
    /// Returns the block mirrored at the ground.
    #[inline(always)]
    pub(super) fn below(&self, ground: &Plane) -> Self {
        let mut image = self.mirrored(&ground.normal);
        for (coordinates, component) in image.xyz.iter_mut().zip(ground.normal.iter()) {
            coordinates.iter_mut().for_each(|coordinate| *coordinate -= 2.0 * ground.distance_m * component);
        }
        image
    }

    /// Returns the block stretched along an axis.
    #[inline(always)]
    pub(super) fn stretched(&self, stretch: &Stretch) -> Self {
        let (mut longer, axis) = (*self, &stretch.axis);
        for lane in 0..LANES {
            let along = self.xyz[0][lane] * axis.x + self.xyz[1][lane] * axis.y + self.xyz[2][lane] * axis.z;
            for (coordinates, component) in longer.xyz.iter_mut().zip(axis.iter()) {
                coordinates[lane] += stretch.excess * along * component;
            }
        }
        longer
    }
}
