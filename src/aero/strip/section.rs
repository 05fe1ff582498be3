//! Geometry and relative velocity of one strip.

use crate::aero::flow::Flow;
use crate::aero::split_between;
use crate::aero::surface::ChordLine;
use crate::load::{SectionMotion, Wrench};
use nalgebra::Vector3;

/// Strip between two sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Indices of its sections, inner end first.
    pub sections: [usize; 2],
    /// Their chords.
    pub chords: [ChordLine; 2],
    /// Index of its surface.
    pub surface: usize,
}

/// A strip at one instant, root frame. The section is cut across the quarter-chord line, eqs. (W1) and (W2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// Middle of the leading edge in m.
    pub leading_m: Vector3<f64>,
    /// Middle of the trailing edge in m.
    pub trailing_m: Vector3<f64>,
    /// Velocity of the air without gusts relative to the leading edge in m/s.
    pub leading_air_m_s: Vector3<f64>,
    /// The same at the trailing edge.
    pub trailing_air_m_s: Vector3<f64>,
    /// Unit vector across the span in the plane of the strip, towards the trailing edge.
    pub aft: Vector3<f64>,
    /// Unit normal; lift at positive angle of attack points along it.
    pub up: Vector3<f64>,
    /// Chord across the quarter-chord line in m.
    pub chord_m: f64,
    /// Length of the quarter-chord line in m.
    pub span_m: f64,
}

impl Strip {
    /// Geometry and relative velocities, eqs. (W1) and (W2).
    pub fn cut(&self, motions: &[SectionMotion], flow: &Flow) -> Cut {
        let place = |end: usize, fraction: f64| motions[self.sections[end]].point_m(&self.chords[end].at(fraction));
        let mean_m = |fraction: f64| 0.5 * (place(0, fraction) + place(1, fraction));
        let air_m_s = |fraction: f64| {
            let moving = |end: usize| motions[self.sections[end]].point_velocity_m_s(&self.chords[end].at(fraction));
            flow.convection_m_s(&mean_m(fraction)) - 0.5 * (moving(0) + moving(1))
        };
        let (leading_m, trailing_m) = (mean_m(0.0), mean_m(1.0));
        let chord_m = trailing_m - leading_m;
        let span_m = place(1, 0.25) - place(0, 0.25);
        let along = span_m.normalize();
        let up = chord_m.cross(&along).normalize();
        let aft = along.cross(&up);
        Cut {
            leading_m,
            trailing_m,
            leading_air_m_s: air_m_s(0.0),
            trailing_air_m_s: air_m_s(1.0),
            aft,
            up,
            chord_m: chord_m.dot(&aft),
            span_m: span_m.norm(),
        }
    }

    /// Adds a force in N at a fraction of the chord, halves at both sections: eq. (W3).
    pub fn add_force(&self, loads: &mut [Wrench], motions: &[SectionMotion], fraction: f64, force_n: &Vector3<f64>) {
        let points_m = self.chords.map(|chord| chord.at(fraction));
        split_between(loads, motions, self.sections, [&points_m[0], &points_m[1]], force_n);
    }

    /// Adds a nose-up moment in N·m as a pair of forces at both edges, eq. (W3).
    pub fn add_moment(&self, loads: &mut [Wrench], motions: &[SectionMotion], cut: &Cut, moment_n_m: f64) {
        let force_n = cut.up * (moment_n_m / cut.chord_m);
        self.add_force(loads, motions, 0.0, &force_n);
        self.add_force(loads, motions, 1.0, &-force_n);
    }
}

impl Cut {
    /// Velocity of the air without gusts relative to the point at a fraction of the chord, in m/s.
    pub fn air_m_s(&self, fraction: f64) -> Vector3<f64> {
        self.leading_air_m_s + (self.trailing_air_m_s - self.leading_air_m_s) * fraction
    }

    /// Middle of the strip at a fraction of the chord, in m.
    pub fn point_m(&self, fraction: f64) -> Vector3<f64> {
        self.leading_m + (self.trailing_m - self.leading_m) * fraction
    }

    /// Area in m².
    pub fn area_m2(&self) -> f64 {
        self.chord_m * self.span_m
    }
}
