//! Loads as plain data: motion of the root with gravity, motion of sections, and wrenches at stations.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Frame in which a station's force and moment are resolved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LoadFrame {
    /// Root frame `G`: a dead load.
    Root,
    /// Section frame at the station: a follower load.
    Section,
}

/// Force and moment at a point, resolved in the frame that the owning structure specifies.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct Wrench {
    /// Force in N.
    pub force_n: Vector3<f64>,
    /// Moment in N·m.
    pub moment_n_m: Vector3<f64>,
}

impl Wrench {
    /// Adds a force that acts at `arm_m` from the wrench's reference point.
    pub fn add_force_at(&mut self, arm_m: &Vector3<f64>, force_n: &Vector3<f64>) {
        self.force_n += force_n;
        self.moment_n_m += arm_m.cross(force_n);
    }

    /// Whether both force and moment are zero.
    pub fn is_zero(&self) -> bool {
        self.force_n == Vector3::zeros() && self.moment_n_m == Vector3::zeros()
    }
}

/// Motion of a section relative to the root frame, resolved in the root frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SectionMotion {
    /// Rotation matrix, root ← section.
    pub rotation: Matrix3<f64>,
    /// Position in m.
    pub position_m: Vector3<f64>,
    /// Velocity in m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity in rad/s.
    pub spin_rad_s: Vector3<f64>,
}

impl SectionMotion {
    /// Position in m of a point fixed to the section, given in the section frame.
    pub fn point_m(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.position_m + self.rotation * point_m
    }

    /// Velocity in m/s of a point fixed to the section, given in the section frame.
    pub fn point_velocity_m_s(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.velocity_m_s + self.spin_rad_s.cross(&(self.rotation * point_m))
    }
}

/// Motion of the root frame and gravity, all resolved in the root frame `G`.
///
/// Gravity and acceleration affect the wing only through `gravity − acceleration`; Coriolis, centrifugal and Euler terms follow from the
/// angular velocity and acceleration (NOTATION eq. (D5)).
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct RootMotion {
    /// Gravity in m/s².
    pub gravity_m_s2: Vector3<f64>,
    /// Inertial acceleration of the root's origin, without gravity, in m/s².
    pub acceleration_m_s2: Vector3<f64>,
    /// Angular velocity of the root frame in rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
    /// Angular acceleration of the root frame in rad/s².
    pub angular_acceleration_rad_s2: Vector3<f64>,
}

impl RootMotion {
    /// Apparent gravity, the uniform field `gravity − acceleration`, in m/s².
    pub fn apparent_gravity_m_s2(&self) -> Vector3<f64> {
        self.gravity_m_s2 - self.acceleration_m_s2
    }

    /// Inertial acceleration in m/s² of a point that moves relative to the root frame, all resolved in the root frame.
    pub fn inertial_acceleration_m_s2(
        &self,
        position_m: &Vector3<f64>,
        velocity_m_s: &Vector3<f64>,
        acceleration_m_s2: &Vector3<f64>,
    ) -> Vector3<f64> {
        let omega = &self.angular_velocity_rad_s;
        acceleration_m_s2
            + self.acceleration_m_s2
            + omega.cross(&(velocity_m_s * 2.0 + omega.cross(position_m)))
            + self.angular_acceleration_rad_s2.cross(position_m)
    }

    /// Inertial angular acceleration in rad/s² of a frame that rotates relative to the root frame, all resolved in the root frame.
    pub fn inertial_angular_acceleration_rad_s2(
        &self,
        spin_rad_s: &Vector3<f64>,
        spin_rate_rad_s2: &Vector3<f64>,
    ) -> Vector3<f64> {
        spin_rate_rad_s2 + self.angular_acceleration_rad_s2 + self.angular_velocity_rad_s.cross(spin_rad_s)
    }

    /// Whether the root frame rotates or has an angular acceleration.
    pub fn rotates(&self) -> bool {
        self.angular_velocity_rad_s != Vector3::zeros() || self.angular_acceleration_rad_s2 != Vector3::zeros()
    }
}
