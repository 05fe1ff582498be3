//! Properties of joint types, for code that is independent of the type.

use crate::machine::{JointKind, JointMotion, OneFreedom, Spatial, SpatialFreedom, Travel};
use crate::multibody::joint;
use nalgebra::Matrix3;

impl JointKind {
    /// The joint type in the recursions over the tree.
    pub(crate) fn in_tree(&self) -> joint::JointKind {
        match self {
            Self::Clamped => joint::JointKind::Clamped,
            Self::Revolute(own) => joint::JointKind::Revolute { axis: own.axis },
            Self::Prismatic(own) => joint::JointKind::Prismatic { axis: own.axis },
            Self::Sliding(_) => joint::JointKind::Sliding,
            Self::Spatial(own) => match own.freedom {
                SpatialFreedom::Universal { parent_axis, body_axis } => {
                    joint::JointKind::universal(parent_axis, body_axis)
                }
                SpatialFreedom::Ball => joint::JointKind::Ball,
                SpatialFreedom::Free => joint::JointKind::Free,
            },
        }
    }

    /// Name of the joint type in files and messages.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Clamped => "clamped",
            Self::Revolute(_) => Travel::Rotation.joint_type(),
            Self::Prismatic(_) => Travel::Translation.joint_type(),
            Self::Sliding(_) => "sliding",
            Self::Spatial(own) => match own.freedom {
                SpatialFreedom::Universal { .. } => "universal",
                SpatialFreedom::Ball => "ball",
                SpatialFreedom::Free => "free",
            },
        }
    }

    /// Joint type and, unless it is free, the motion of a joint with one degree of freedom, as in `revolute, locked`.
    pub fn described(&self) -> String {
        let motion = self.one_freedom().map_or("", |(_, own)| match own.motion {
            JointMotion::Free => "",
            JointMotion::Locked => ", locked",
            JointMotion::Prescribed(_) => ", prescribed",
        });
        format!("{}{motion}", self.type_name())
    }

    /// Travel and parts of a joint with one degree of freedom; `None` for all others.
    pub fn one_freedom(&self) -> Option<(Travel, &OneFreedom)> {
        match self {
            Self::Revolute(joint) => Some((Travel::Rotation, joint)),
            Self::Prismatic(joint) | Self::Sliding(joint) => Some((Travel::Translation, joint)),
            Self::Clamped | Self::Spatial(_) => None,
        }
    }

    /// Data of a universal, ball or free joint; `None` for all others.
    pub fn spatial(&self) -> Option<&Spatial> {
        match self {
            Self::Spatial(joint) => Some(joint),
            Self::Clamped | Self::Revolute(_) | Self::Prismatic(_) | Self::Sliding(_) => None,
        }
    }

    /// Rotates data in the body's frame: the second axis of a universal joint.
    pub(crate) fn turn_body_axis(&mut self, turn: &Matrix3<f64>) {
        if let Self::Spatial(joint) = self
            && let SpatialFreedom::Universal { body_axis, .. } = &mut joint.freedom
        {
            *body_axis = turn * *body_axis;
        }
    }

    /// Whether it has no degree of freedom.
    pub fn is_clamped(&self) -> bool {
        self.one_freedom().is_none() && self.spatial().is_none()
    }

    /// Number of degrees of freedom that forces can move: none for a joint that is locked or prescribed.
    pub fn freedoms(&self) -> usize {
        match (self.one_freedom(), self.spatial()) {
            (Some((_, joint)), _) => usize::from(joint.motion == JointMotion::Free),
            (_, Some(joint)) => match joint.freedom {
                SpatialFreedom::Universal { .. } => 2,
                SpatialFreedom::Ball => 3,
                SpatialFreedom::Free => 6,
            },
            (None, None) => 0,
        }
    }

    /// Whether body and parent have no relative motion.
    pub fn is_rigid(&self) -> bool {
        self.spatial().is_none() && self.one_freedom().is_none_or(|(_, own)| own.motion == JointMotion::Locked)
    }

    /// Whether the body slides along the axis of a beam.
    pub fn rides(&self) -> bool {
        matches!(self, Self::Sliding(_))
    }

    /// Whether the body can translate along an axis.
    pub fn slides(&self) -> bool {
        self.one_freedom().is_some_and(|(travel, _)| travel == Travel::Translation)
    }

    /// Whether the body's inner end stays at the joint.
    pub fn holds_place(&self) -> bool {
        !self.slides()
            && self.spatial().is_none_or(|joint| match joint.freedom {
                SpatialFreedom::Universal { .. } | SpatialFreedom::Ball => true,
                SpatialFreedom::Free => false,
            })
    }
}
