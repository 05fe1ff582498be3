//! Skates and wheels of the description: no-slip constraints on a plane.

use crate::multibody::no_slip::Runner;
use nalgebra::Vector3;

/// A skate or a wheel on a section of a body, on a plane that is fixed in the root frame. Its constraints act in both directions: it neither
/// slips nor lifts off.
#[derive(Debug, Clone, PartialEq)]
pub struct NoSlip {
    /// Identifier.
    pub name: String,
    /// Index into [`Machine::bodies`](crate::machine::Machine::bodies).
    pub body: usize,
    /// Distance of the section from the body's inner end in m.
    pub position_m: f64,
    /// Position of the skate's point, or of the wheel's centre, relative to the section's axis, section frame, m.
    pub offset_m: Vector3<f64>,
    /// Kind, with its directions in the section frame.
    pub runner: Runner,
    /// Unit normal of the plane, root frame, on the side of the body.
    pub plane_normal: Vector3<f64>,
    /// A point of the plane, root frame, m.
    pub plane_point_m: Vector3<f64>,
    /// Whether the point of contact stays in the plane; else only its velocities in the plane are constrained.
    pub hold_normal: bool,
}

impl NoSlip {
    /// Table of the model file: `skate` or `wheel`.
    pub fn table(&self) -> &'static str {
        match self.runner {
            Runner::Skate { .. } => "skate",
            Runner::Wheel { .. } => "wheel",
        }
    }
}
