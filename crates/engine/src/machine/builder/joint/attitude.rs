//! Attitudes of bodies on sliding joints.

use super::freedom::carriage;
use nalgebra::Vector3;

/// Attitude of the body of a sliding joint relative to the beam's section.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Attitude {
    /// That of the section, times the joint's mount.
    #[default]
    Section,
    /// Free rotation about an axis in the frame of the section, of any nonzero length; see [`Attitude::hinge`].
    Hinge(Vector3<f64>),
    /// Free rotation about all axes.
    Ball,
}

impl Attitude {
    /// Free rotation about an axis in the frame of the section, of any nonzero length; positive angles by the right-hand rule.
    pub fn hinge(axis: impl Into<Vector3<f64>>) -> Self {
        Self::Hinge(axis.into())
    }

    /// Names of the parts of a joint whose body rotates: the carriage, and the joint of the body on it. `None` for a body that has the
    /// attitude of the section.
    pub fn parts(&self, joint: &str) -> Option<[String; 2]> {
        let named = |part: &str| Some([carriage(joint, 0), format!("{joint}_{part}")]);
        match self {
            Self::Section => None,
            Self::Hinge(_) => named("hinge"),
            Self::Ball => named("ball"),
        }
    }
}

/// Attitude of the body of a sliding joint that has a start value, by its name.
pub(super) fn of_start(key: &str) -> Option<&'static str> {
    match key {
        "start_angle_rad" | "start_rate_rad_s" => Some("hinge"),
        "start_angular_velocity_rad_s" => Some("ball"),
        _ => None,
    }
}
