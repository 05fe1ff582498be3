//! Lifting surfaces: chord lines fixed to the sections of bodies, and the panels between them.

use crate::aero::polar::{Polar, PolarRow};
use nalgebra::Vector3;
use std::ops::Range;

/// Chord of one section, fixed to the section frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChordLine {
    /// Vector from the section's axis to the leading edge, section frame, m.
    pub leading_m: Vector3<f64>,
    /// Vector from the section's axis to the trailing edge, section frame, m.
    pub trailing_m: Vector3<f64>,
}

impl ChordLine {
    /// Point at a fraction of the chord aft of the leading edge, section frame, m; fractions above 1 are behind the trailing edge.
    pub fn at(&self, fraction: f64) -> Vector3<f64> {
        self.leading_m + (self.trailing_m - self.leading_m) * fraction
    }

    /// Length in m.
    pub fn length_m(&self) -> f64 {
        (self.trailing_m - self.leading_m).norm()
    }
}

/// Profile data for strips and lattice: constant coefficients with a lift-curve slope, or a polar.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Lift-curve slope in 1/rad; 2π for a thin profile in plane flow.
    pub lift_slope_1_rad: f64,
    /// Lift-curve slopes of the individual strips, inner strip first, if they differ; otherwise empty.
    pub lift_slopes_1_rad: Vec<f64>,
    /// Zero-lift angle of attack in rad, from the chord line, positive along the normal of eq. (W1); with a polar, the angle from which the
    /// lag starts.
    pub zero_lift_angle_rad: f64,
    /// Moment coefficient about the quarter chord, nose up positive.
    pub moment_coefficient: f64,
    /// Drag coefficient.
    pub drag_coefficient: f64,
    /// Polar, which replaces slope, moment and drag.
    pub polar: Option<Polar>,
}

impl Profile {
    /// Thin symmetric plate.
    pub const THIN: Self = Self {
        lift_slope_1_rad: std::f64::consts::TAU,
        lift_slopes_1_rad: Vec::new(),
        zero_lift_angle_rad: 0.0,
        moment_coefficient: 0.0,
        drag_coefficient: 0.0,
        polar: None,
    };

    /// Whether it is a thin symmetric plate without drag.
    pub fn is_thin(&self) -> bool {
        *self == Self::THIN
    }

    /// Returns the profile upside down, with camber, moment and polar reversed.
    pub fn upside_down(self) -> Self {
        let turned =
            |row: &PolarRow| PolarRow { angle_rad: -row.angle_rad, lift: -row.lift, moment: -row.moment, ..*row };
        Self {
            zero_lift_angle_rad: -self.zero_lift_angle_rad,
            moment_coefficient: -self.moment_coefficient,
            polar: self.polar.map(|polar| Polar { rows: polar.rows.iter().rev().map(turned).collect() }),
            ..self
        }
    }

    /// Lift-curve slope of a strip in 1/rad.
    pub fn lift_slope_of_strip_1_rad(&self, strip: usize) -> f64 {
        self.lift_slopes_1_rad.get(strip).copied().unwrap_or(self.lift_slope_1_rad)
    }
}

/// Lifting surface of one body: strips between consecutive sections, each with the same number of chordwise panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Indices of the sections, inner end first, in the list of all sections; one more than the number of strips.
    pub sections: Range<usize>,
    /// Chords of the sections.
    pub chords: Vec<ChordLine>,
    /// Number of chordwise panels.
    pub chord_panels: usize,
    /// Profile of the strips.
    pub profile: Profile,
}

impl Surface {
    /// Number of strips.
    pub fn strips(&self) -> usize {
        self.sections.len() - 1
    }

    /// Number of panels.
    pub fn panels(&self) -> usize {
        self.strips() * self.chord_panels
    }
}

/// An edge of a surface along the chord.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Index of the surface.
    pub surface: usize,
    /// Whether it is the outer edge; otherwise the inner one.
    pub outer: bool,
}

/// The two sides of joined edges: two surfaces, or a surface and its image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides {
    /// Unit normal of the mirror plane through the origin, if the second side is the image of the first.
    mirror_normal: Option<Vector3<f64>>,
}

impl Sides {
    /// Two surfaces.
    pub const SURFACES: Self = Self { mirror_normal: None };

    /// A surface and its image in the plane through the origin with this unit normal.
    pub fn image(mirror_normal: Vector3<f64>) -> Self {
        Self { mirror_normal: Some(mirror_normal) }
    }

    /// Whether the second side is the image of the first.
    pub fn is_image(&self) -> bool {
        self.mirror_normal.is_some()
    }

    /// The sides that are surfaces, each with the sign of its shift towards the other one: both, or the first.
    pub fn of_surfaces(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        [(0, 1.0), (1, -1.0)].into_iter().take(if self.is_image() { 1 } else { 2 })
    }

    /// A position or velocity of one side in space, given that of its surface, and vice versa.
    pub fn of_side(&self, side: usize, vector: Vector3<f64>) -> Vector3<f64> {
        let normal = self.mirror_normal.filter(|_| side == 1);
        normal.map_or(vector, |normal| vector - normal * (2.0 * normal.dot(&vector)))
    }
}

/// Two edges that count as one where they are close.
#[derive(Debug, Clone, Copy)]
pub(super) struct JoinedEdges {
    /// The edges; the same twice if the second is the image of the first.
    pub edges: [Edge; 2],
    /// Two surfaces, or a surface and its image.
    pub sides: Sides,
}
