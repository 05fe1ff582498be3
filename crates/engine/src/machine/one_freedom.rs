//! Joints with a rotation about an axis or a translation along it.

use crate::machine::{DcMotor, EndStops, GeneratorLaw, JointMotion, Latch, Motor, Spring};
use nalgebra::Vector3;

/// A joint with one degree of freedom, either a rotation about its axis or a translation along it: [`Travel`](crate::machine::Travel).
///
/// Fields here, in [`Motor`], [`Spring`], [`Latch`] and [`EndStops`], and the joint's inputs, parameters and outputs in `plant`, are named
/// for a revolute joint. For a prismatic one, read m for rad, N for N·m and kg for kg·m²; [`LinearMotor`](crate::machine::LinearMotor),
/// [`LinearSpring`](crate::machine::LinearSpring) and [`JointBuilder`](crate::machine::builder::JointBuilder) name its quantities by the
/// units of a prismatic joint.
#[derive(Debug, Clone, PartialEq)]
pub struct OneFreedom {
    /// Unit axis in the parent's section frame.
    pub axis: Vector3<f64>,
    /// Initial fold angle in rad, or position in m.
    pub start_angle_rad: f64,
    /// Initial fold rate in rad/s, or velocity in m/s (joints that are free at the start).
    pub start_rate_rad_s: f64,
    /// Type of motion of the coordinate.
    pub motion: JointMotion,
    /// Start value of the release input.
    pub release: bool,
    /// Motor.
    pub motor: Motor,
    /// Spring and damper of the joint, apart from the motor.
    pub spring: Option<Spring>,
    /// Generator on the high-speed shaft of the motor; for revolute joints.
    pub generator: Option<GeneratorLaw>,
    /// Electrical DC motor, in addition to `motor`.
    pub dc_motor: Option<DcMotor>,
    /// Latch of the joint.
    pub latch: Option<Latch>,
    /// Stops at the ends of its travel.
    pub end_stops: Option<EndStops>,
}

/// A fold joint: the data of [`JointKind::Revolute`](crate::machine::JointKind::Revolute).
pub type Revolute = OneFreedom;

impl OneFreedom {
    /// A revolute joint about an axis in the parent's section frame: free, released, with zero angle and rate, without motor, spring or
    /// latch.
    pub fn about(axis: impl Into<Vector3<f64>>) -> Self {
        Self {
            axis: axis.into(),
            start_angle_rad: 0.0,
            start_rate_rad_s: 0.0,
            motion: JointMotion::Free,
            release: true,
            motor: Motor::default(),
            spring: None,
            generator: None,
            dc_motor: None,
            latch: None,
            end_stops: None,
        }
    }

    /// A prismatic joint along an axis in the parent's section frame, at position 0, otherwise like [`Self::about`].
    pub fn along(axis: impl Into<Vector3<f64>>) -> Self {
        Self::about(axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both joints keep the direction of the axis, at zero and free.
    #[test]
    fn joints_of_programs_keep_the_direction_of_their_axis() {
        let axis = Vector3::new(0.6, 0.0, -0.8);
        for joint in [OneFreedom::about(axis), OneFreedom::along(axis)] {
            assert_eq!(
                (joint.axis, joint.start_angle_rad, joint.start_rate_rad_s, joint.release),
                (axis, 0.0, 0.0, true)
            );
        }
    }
}
