//! Control surfaces: rear parts of strips of a lifting surface, which rotate about a hinge at a fraction of the chord.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A control surface: the part of some strips aft of its hinge. It has no mass; its angle is an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Flap {
    /// Identifier.
    pub name: String,
    /// Index of the surface.
    pub surface: usize,
    /// Strips of the control surface, counted from the surface's inner end.
    pub strips: Range<usize>,
    /// Hinge position from the leading edge as a fraction of the chord, between 0 and 1.
    pub hinge_fraction: f64,
    /// Smallest angle in rad.
    pub lower_rad: f64,
    /// Largest angle in rad.
    pub upper_rad: f64,
    /// Initial angle in rad.
    pub command_rad: f64,
    /// 1 if a positive angle moves the trailing edge opposite to the normal of eq. (W1), −1 if along it: a positive angle always moves it
    /// towards the section's `−z`.
    pub downward: f64,
}

/// Deflection angle of a control surface and its rate at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deflection {
    /// Angle in rad; positive moves the trailing edge towards the section's `−z`.
    pub angle_rad: f64,
    /// Rate of the angle in rad/s.
    pub rate_rad_s: f64,
}

/// Aerodynamic hinge moment of a control surface in N·m, positive in the direction of positive angles.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct HingeMoment {
    /// Part due to circulation, velocity and angle, at the end of the step.
    pub circulatory_n_m: f64,
    /// Part due to the apparent mass, mean over the step.
    pub impulsive_n_m: f64,
}

impl HingeMoment {
    /// Total moment at a fraction of the step between this state and `end`; the impulsive part is that of the step.
    pub fn between(&self, end: &Self, share: f64) -> f64 {
        self.circulatory_n_m + (end.circulatory_n_m - self.circulatory_n_m) * share + end.impulsive_n_m
    }
}
