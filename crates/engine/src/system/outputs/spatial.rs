//! Universal, ball and free joints.

use crate::math::so3::quaternion_near;
use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};
use nalgebra::{UnitQuaternion, Vector3};

/// Outputs of one universal, ball or free joint.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SpatialOutputs {
    /// Attitude, parent ← body; sign continuous in time.
    pub rotation: UnitQuaternion<f64>,
    /// Angular velocity relative to the parent, parent's frame, rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
}

/// Writes the attitudes and angular velocities of the last sweep.
pub(crate) fn fill(outputs: &mut [SpatialOutputs], present: &Present) {
    let last = &present.state.spatial_rotations;
    for ((output, joint), last) in outputs.iter_mut().zip(&present.equations.spatial).zip(last) {
        let (rotation, angular_velocity_rad_s) = joint.motion(&present.equations.work, present.motion.v);
        *output = SpatialOutputs { rotation: quaternion_near(&rotation, last), angular_velocity_rad_s };
    }
}
