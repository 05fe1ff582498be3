//! Types of joints in the builder.

use crate::machine::Travel;

/// Type of a joint in the builder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::machine::builder) enum Type {
    Clamped,
    Revolute,
    Prismatic,
    Sliding,
    Universal,
    Ball,
    Free,
}

impl Type {
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamped => "clamped",
            Self::Revolute => Travel::Rotation.joint_type(),
            Self::Prismatic => Travel::Translation.joint_type(),
            Self::Sliding => "sliding",
            Self::Universal => "universal",
            Self::Ball => "ball",
            Self::Free => "free",
        }
    }
}
