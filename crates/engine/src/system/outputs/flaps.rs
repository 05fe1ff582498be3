//! Flaps of machines in air.

use bytemuck::{Pod, Zeroable};

/// Outputs of one control surface.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct FlapOutputs {
    /// Angle in rad; positive moves the trailing edge towards the section's `−z`.
    pub angle_rad: f64,
    /// Its rate in rad/s.
    pub rate_rad_s: f64,
    /// Moment of the air about the hinge in N·m, positive along positive angles.
    pub hinge_moment_n_m: f64,
}
