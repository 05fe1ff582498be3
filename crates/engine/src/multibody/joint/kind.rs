//! Kinds of joints, with the numbers of their coordinates and constraints.

use nalgebra::{Matrix3, Vector3};

/// Kind of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// No degree of freedom.
    Clamped,
    /// Rotation about a unit axis in the parent's frame.
    Revolute {
        /// Unit axis in the parent's frame.
        axis: Vector3<f64>,
    },
    /// Translation along a unit axis in the parent's frame.
    Prismatic {
        /// Unit axis in the parent's frame.
        axis: Vector3<f64>,
    },
    /// Motion along the axis of a beam, with the attitude of its section: the coordinate is an arc length.
    Sliding,
    /// Two axes: one fixed to the parent, one to the body; the angle between them is constant.
    Universal {
        /// Unit axis in the parent's frame.
        parent_axis: Vector3<f64>,
        /// Unit axis in the body's frame, not parallel to the other one.
        body_axis: Vector3<f64>,
        /// Cosine of the angle between the axes.
        cosine: f64,
    },
    /// All rotations.
    Ball,
    /// All rotations and translations; only on the root frame.
    Free,
}

impl JointKind {
    /// A universal joint about a unit axis in the parent's frame and one in the body's frame; the angle between them follows from the
    /// mount.
    pub const fn universal(parent_axis: Vector3<f64>, body_axis: Vector3<f64>) -> Self {
        Self::Universal { parent_axis, body_axis, cosine: 0.0 }
    }

    /// The joint of a body mounted by `mount`, parent ← body.
    pub(crate) fn mounted(self, mount: &Matrix3<f64>) -> Self {
        match self {
            Self::Universal { parent_axis, body_axis, .. } => {
                Self::Universal { parent_axis, body_axis, cosine: parent_axis.dot(&(mount * body_axis)) }
            }
            Self::Clamped
            | Self::Revolute { .. }
            | Self::Prismatic { .. }
            | Self::Sliding
            | Self::Ball
            | Self::Free => self,
        }
    }

    /// Number of coordinates in `q`.
    pub fn coordinates(&self) -> usize {
        match self {
            Self::Clamped => 0,
            Self::Revolute { .. } | Self::Prismatic { .. } | Self::Sliding => 1,
            Self::Universal { .. } => 9,
            Self::Ball => 4,
            Self::Free => 7,
        }
    }

    /// Number of constraints `Ψ` among the coordinates.
    pub fn constraints(&self) -> usize {
        match self {
            Self::Clamped | Self::Revolute { .. } | Self::Prismatic { .. } | Self::Sliding => 0,
            Self::Universal { .. } => 7,
            Self::Ball | Self::Free => 1,
        }
    }

    /// Number of degrees of freedom: coordinates minus constraints.
    pub fn freedoms(&self) -> usize {
        self.coordinates() - self.constraints()
    }

    /// Whether the coordinates are redundant parameters with constraints.
    pub fn is_redundant(&self) -> bool {
        self.constraints() > 0
    }

    /// Number of translations among the degrees of freedom; they come first.
    pub fn translations(&self) -> usize {
        match self {
            Self::Prismatic { .. } | Self::Sliding => 1,
            Self::Free => 3,
            Self::Clamped | Self::Revolute { .. } | Self::Universal { .. } | Self::Ball => 0,
        }
    }

    /// Whether the joint transmits forces from the body to its parent: true for all joints except free ones.
    pub fn transmits(&self) -> bool {
        !self.floats()
    }

    /// Whether the body's first node is free: its position is among the coordinates.
    pub fn floats(&self) -> bool {
        match self {
            Self::Free => true,
            Self::Clamped
            | Self::Revolute { .. }
            | Self::Prismatic { .. }
            | Self::Sliding
            | Self::Universal { .. }
            | Self::Ball => false,
        }
    }
}

/// A joint with its position in `q`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Type of the extreme value.
    pub kind: JointKind,
    /// Index of its first coordinate in `q`.
    pub coordinate: usize,
    /// Inertia that moves only with the coordinate, for joints with one degree of freedom, in kg·m² or kg: motor and gear, eq. (D16).
    pub drive_inertia: f64,
    /// Factor of the carrier's rotation in the rotation of the motor's rotor, for revolute joints: the inverse of its gear ratio, 0 if the
    /// inertia rotates with the coordinate only, eq. (D17).
    pub drive_carried: f64,
}

impl Joint {
    /// Range of its coordinates in `q`.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.coordinate..self.coordinate + self.kind.coordinates()
    }
}
