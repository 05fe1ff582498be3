//! Types of joints in the builder.

use super::freedom::{CYLINDRICAL, Freedom};
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
    Cylindrical,
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
            Self::Cylindrical => "cylindrical",
        }
    }

    /// Degrees of freedom of a joint that is a chain of joints with one degree of freedom each; none for all others.
    pub fn freedoms(self) -> &'static [Freedom] {
        match self {
            Self::Cylindrical => CYLINDRICAL,
            Self::Clamped
            | Self::Revolute
            | Self::Prismatic
            | Self::Sliding
            | Self::Universal
            | Self::Ball
            | Self::Free => &[],
        }
    }

    /// Type of a joint with one degree of freedom along or about its axis.
    pub fn of_travel(travel: Travel) -> Self {
        match travel {
            Travel::Rotation => Self::Revolute,
            Travel::Translation => Self::Prismatic,
        }
    }
}
