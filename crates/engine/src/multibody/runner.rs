//! Skates and wheels as data.

use nalgebra::Vector3;

/// Rows of a constraint by multipliers; of a skate or a wheel: across the heading, along the heading, along the normal of the plane.
pub const ROWS: usize = 3;

/// Least sine of the angle between the blade, or the axis of a wheel, and the normal of the plane: the heading is not defined at 0.
pub const LEAST_SINE: f64 = 0.05;

/// The part that touches the plane; directions are unit vectors of the section's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Runner {
    /// A blade: its point moves along its direction only.
    Skate {
        /// Direction of the blade.
        direction: Vector3<f64>,
    },
    /// A thin disc about an axis of its body: its point of contact does not slip sideways.
    Wheel {
        /// Axis of the disc; a positive rotation rolls it along `axis × normal`.
        axis: Vector3<f64>,
        /// Radius in m.
        radius_m: f64,
        /// Whether the point of contact does not slip along the heading either.
        rolling: bool,
    },
}

/// Description of a no-slip constraint for meshing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoSlipDescription {
    /// Body and distance of the section from its inner end in m.
    pub place: (usize, f64),
    /// Position of the skate's point, or of the wheel's centre, relative to the section's axis, section frame, m.
    pub offset_m: Vector3<f64>,
    /// The part that touches the plane.
    pub runner: Runner,
    /// Unit normal of the plane, root frame, on the side of the body.
    pub normal: Vector3<f64>,
    /// Distance of the plane from the origin of the root frame along the normal, m.
    pub distance_m: f64,
    /// Whether the point of contact stays in the plane.
    pub holds_normal: bool,
}

/// No-slip constraint in the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoSlip {
    /// Node of the section.
    pub node: usize,
    /// As described.
    pub described: NoSlipDescription,
}
