//! Outputs of control surfaces.

use bytemuck::{Pod, Zeroable};

/// Outputs of one control surface.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct FlapOutputs {
    /// Angle in rad; a positive angle moves the trailing edge towards the section's `−z`.
    pub angle_rad: f64,
    /// Rate of the angle in rad/s.
    pub rate_rad_s: f64,
    /// Aerodynamic hinge moment in N·m, positive in the direction of positive angles.
    pub hinge_moment_n_m: f64,
}
