//! Geometry and relative velocity of one strip.

use crate::aero::flow::Flow;
use crate::aero::surface::ChordLine;
use crate::load::{SectionMotion, Wrench};
use nalgebra::Vector3;

/// Strip of a surface between two sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Indices of the strip's sections, inner end first.
    pub sections: [usize; 2],
    /// Chords of the two sections.
    pub chords: [ChordLine; 2],
    /// Index of the surface.
    pub surface: usize,
    /// Lift-curve slope in 1/rad.
    pub lift_slope_1_rad: f64,
    /// Speed of sound in m/s; infinite for incompressible air.
    pub speed_of_sound_m_s: f64,
}

/// Geometry and flow of a strip at one instant, root frame. The section is cut normal to the quarter-chord line, eqs. (W1) and (W2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// Vectors from the reference points of both sections, inner one first, to the leading and the trailing edge, in m.
    pub arms_m: [[Vector3<f64>; 2]; 2],
    /// Midpoint of the leading edge in m.
    pub leading_m: Vector3<f64>,
    /// Midpoint of the trailing edge in m.
    pub trailing_m: Vector3<f64>,
    /// Velocity of the air, without gusts, relative to the leading edge in m/s.
    pub leading_air_m_s: Vector3<f64>,
    /// Velocity of the air, without gusts, relative to the trailing edge in m/s.
    pub trailing_air_m_s: Vector3<f64>,
    /// Unit vector normal to the span in the plane of the strip, towards the trailing edge.
    pub aft: Vector3<f64>,
    /// Unit normal; lift at positive angle of attack points along it.
    pub up: Vector3<f64>,
    /// Chord measured normal to the quarter-chord line in m.
    pub chord_m: f64,
    /// Length of the quarter-chord line in m.
    pub span_m: f64,
}

impl Strip {
    /// Geometry and relative velocities, eqs. (W1) and (W2).
    pub fn cut(&self, motions: &[SectionMotion], flow: &Flow) -> Cut {
        let ends = self.sections.map(|section| &motions[section]);
        let arms_m: [[Vector3<f64>; 2]; 2] = std::array::from_fn(|end| {
            [self.chords[end].leading_m, self.chords[end].trailing_m].map(|edge_m| ends[end].rotation * edge_m)
        });
        let mean_m = |edge: usize| 0.5 * (ends[0].position_m + arms_m[0][edge] + ends[1].position_m + arms_m[1][edge]);
        let air_m_s = |edge: usize, place_m: &Vector3<f64>| {
            let moving = |end: usize| ends[end].velocity_m_s + ends[end].spin_rad_s.cross(&arms_m[end][edge]);
            flow.convection_m_s(place_m) - 0.5 * (moving(0) + moving(1))
        };
        let (leading_m, trailing_m) = (mean_m(0), mean_m(1));
        let chord_m = trailing_m - leading_m;
        let quarter_m = |end: usize| ends[end].position_m + arms_m[end][0] * 0.75 + arms_m[end][1] * 0.25;
        let span_m = quarter_m(1) - quarter_m(0);
        let along = span_m.normalize();
        let up = chord_m.cross(&along).normalize();
        let aft = along.cross(&up);
        Cut {
            arms_m,
            leading_m,
            trailing_m,
            leading_air_m_s: air_m_s(0, &leading_m),
            trailing_air_m_s: air_m_s(1, &trailing_m),
            aft,
            up,
            chord_m: chord_m.dot(&aft),
            span_m: span_m.norm(),
        }
    }

    /// Adds a force in N at a fraction of the chord, one half at each section: eq. (W3).
    pub fn add_force(&self, loads: &mut [Wrench], cut: &Cut, fraction: f64, force_n: &Vector3<f64>) {
        let half_n = 0.5 * force_n;
        for (section, [leading_m, trailing_m]) in self.sections.into_iter().zip(&cut.arms_m) {
            loads[section].add_force_at(&(leading_m + (trailing_m - leading_m) * fraction), &half_n);
        }
    }

    /// Adds a nose-up moment in N·m as a couple of forces at the two edges, eq. (W3).
    pub fn add_moment(&self, loads: &mut [Wrench], cut: &Cut, moment_n_m: f64) {
        let force_n = cut.up * (moment_n_m / cut.chord_m);
        self.add_force(loads, cut, 0.0, &force_n);
        self.add_force(loads, cut, 1.0, &-force_n);
    }
}

impl Cut {
    /// Velocity of the air, without gusts, relative to the point at a fraction of the chord, in m/s.
    pub fn air_m_s(&self, fraction: f64) -> Vector3<f64> {
        self.leading_air_m_s + (self.trailing_air_m_s - self.leading_air_m_s) * fraction
    }

    /// Mid-span point of the strip at a fraction of the chord, in m.
    pub fn point_m(&self, fraction: f64) -> Vector3<f64> {
        self.leading_m + (self.trailing_m - self.leading_m) * fraction
    }

    /// Unit vector along the quarter-chord line.
    pub fn along(&self) -> Vector3<f64> {
        self.up.cross(&self.aft)
    }

    /// Spanwise slope towards `up` of the trailing edge minus that of the leading edge: `τ` of eq. (W2).
    pub fn twist(&self, up: &Vector3<f64>) -> f64 {
        let [[inner_leading_m, inner_trailing_m], [outer_leading_m, outer_trailing_m]] = &self.arms_m;
        up.dot(&((outer_trailing_m - inner_trailing_m) - (outer_leading_m - inner_leading_m))) / self.span_m
    }
}

/// Flow direction `γ` of eq. (W4): 1 for flow from the leading edge, −1 from the trailing edge, 0 for flow from below or for a plate in
/// pure rotation.
pub fn bias(along_m_s: f64, across_m_s: f64, difference_m_s: f64) -> f64 {
    let size_m_s = along_m_s.hypot(across_m_s).hypot(0.25 * difference_m_s);
    if size_m_s > 0.0 { along_m_s / size_m_s } else { 0.0 }
}
