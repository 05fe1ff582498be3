//! Control surfaces: rear parts of strips of a lifting surface, which turn about a hinge at a fraction of the chord.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A control surface: the part of some strips behind its hinge. It has no mass; its angle is an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Flap {
    /// Identifier.
    pub name: String,
    /// Index of its surface.
    pub surface: usize,
    /// Strips that have it, counted from the surface's inner end.
    pub strips: Range<usize>,
    /// Place of the hinge on the chord, from the leading edge, between 0 and 1.
    pub hinge_fraction: f64,
    /// Smallest angle in rad.
    pub lower_rad: f64,
    /// Largest angle in rad.
    pub upper_rad: f64,
    /// Angle at the start in rad.
    pub command_rad: f64,
    /// 1 if a positive angle moves the trailing edge against the normal of eq. (W1), −1 if along it: positive angles always move it towards
    /// the section's `−z`.
    pub downward: f64,
}

/// Angle of a control surface and its rate at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deflection {
    /// Angle in rad; positive moves the trailing edge towards the section's `−z`.
    pub angle_rad: f64,
    /// Its rate in rad/s.
    pub rate_rad_s: f64,
}

/// Hinge moment of the air on a control surface in N·m, positive along positive angles.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct HingeMoment {
    /// Moment at the end of the step from circulation, velocity and angle.
    pub circulatory_n_m: f64,
    /// Mean over the step: that of the apparent mass.
    pub impulsive_n_m: f64,
}

impl HingeMoment {
    /// Both parts at a fraction of the step between this end and the other; the impulsive part is that of the step.
    pub fn between(&self, end: &Self, share: f64) -> f64 {
        self.circulatory_n_m + (end.circulatory_n_m - self.circulatory_n_m) * share + end.impulsive_n_m
    }
}
