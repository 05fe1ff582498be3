//! Lifting surfaces in code, and their strips on bodies that stand.

use crate::aero::surface::{ChordLine, Profile};
use crate::beam::profile::Profile as Along;
use crate::machine::edges::{RootEdge, free_edges, other_half};
use crate::machine::fault::{Checker, Range};
use crate::machine::units::shortest;
use crate::machine::validate::air::MOST_STRIPS;
use crate::machine::validate::body::{least_of, profile, section_stands};
use crate::machine::{Body, LiftingSurface};
use nalgebra::Vector3;

/// Inset of a free edge of the lattice in panels: uniform lattices that reach the tip converge only as `1/N`.
const INSET_PANELS: f64 = 0.25;

/// Lifting surface of a body under construction: [`LiftingSurface::on`].
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceBuilder {
    pub(super) body: String,
    pub(super) strips: usize,
    pub(super) chord_panels: usize,
    axis_fraction: f64,
    forward: f64,
    chord_m: Option<Along>,
    incidence_deg: Along,
    profile: Profile,
}

impl LiftingSurface {
    /// A surface on the body of a name, with strips along the span. Its chord is the width of the body's section, the
    /// leading edge on the side of `+y` and the axis in the middle of the chord, unless told otherwise.
    pub fn on(body: impl Into<String>, strips: usize) -> SurfaceBuilder {
        SurfaceBuilder {
            body: body.into(),
            strips,
            chord_panels: 4,
            axis_fraction: 0.5,
            forward: 1.0,
            chord_m: None,
            incidence_deg: Along::constant(0.0),
            profile: Profile::THIN,
        }
    }
}

impl SurfaceBuilder {
    /// Chord along the body in m.
    pub fn chord_m(self, chord_m: Along) -> Self {
        Self { chord_m: Some(chord_m), ..self }
    }

    /// Panels of the lattice along the chord. Default 4.
    pub fn chord_panels(self, chord_panels: usize) -> Self {
        Self { chord_panels, ..self }
    }

    /// Place of the beam's axis on the chord, from the leading edge, as a fraction of the chord. Default 0.5.
    pub fn axis_fraction(self, axis_fraction: f64) -> Self {
        Self { axis_fraction, ..self }
    }

    /// Puts the leading edge on the side of `−y`.
    pub fn leading_edge_minus_y(self) -> Self {
        Self { forward: -1.0, ..self }
    }

    /// Incidence of the chord against the section along the body in degrees, in which it is interpolated; positive raises
    /// the leading edge towards `+z`. Default 0.
    pub fn incidence_deg(self, incidence_deg: Along) -> Self {
        Self { incidence_deg, ..self }
    }

    /// Profile, for strip theory. Default a thin plate.
    pub fn profile(self, profile: Profile) -> Self {
        Self { profile, ..self }
    }
}

/// A surface with what its place along the span is made of.
pub(super) struct Draft<'b> {
    pub surface: &'b SurfaceBuilder,
    body: usize,
    chord_m: Along,
}

impl Draft<'_> {
    /// Chord at a distance in m from the body's inner end.
    fn chord_line(&self, s: f64) -> ChordLine {
        let SurfaceBuilder { incidence_deg, forward, axis_fraction, .. } = self.surface;
        let (chord_m, incidence_rad) = (self.chord_m.at(s), incidence_deg.at(s).to_radians());
        let forward = Vector3::new(0.0, forward * incidence_rad.cos(), incidence_rad.sin());
        ChordLine {
            leading_m: forward * (axis_fraction * chord_m),
            trailing_m: forward * ((axis_fraction - 1.0) * chord_m),
        }
    }
}

/// Looks at a surface: its body, counts, chord and incidence. `None` where something is refused.
pub(super) fn draft<'b>(
    index: usize,
    surfaces: &'b [SurfaceBuilder],
    bodies: &[Body],
    checker: &mut Checker,
) -> Option<Draft<'b>> {
    let surface = &surfaces[index];
    let name = surface.body.as_str();
    let place = ["surface", name, "body"];
    let Some(body) = bodies.iter().position(|body| body.name == name) else {
        checker.unknown_name(&place, name, "a body", bodies.iter().map(|body| body.name.as_str()));
        return None;
    };
    if bodies[body].is_rigid() {
        checker.refuse(&place, format!("{name:?}"), "a body that bends; this one is rigid");
        return None;
    }
    if surfaces[..index].iter().any(|other| other.body == name) {
        checker.refuse(&place, format!("{name:?}"), "a body without a surface; one is on this one");
        return None;
    }
    let length_m = bodies[body].length_m;
    let counted = checker.count(&["surface", name, "strips"], surface.strips, 1, MOST_STRIPS)
        & checker.count(&["surface", name, "chord_panels"], surface.chord_panels, 1, MOST_STRIPS);
    let axis = ["surface", name, "axis_fraction"];
    let placed = checker.number(&axis, surface.axis_fraction, Range::Within(-10.0, 10.0));
    let chord_m = chord(surface, &bodies[body], checker)?;
    let turned = profile(&["surface", name, "incidence_deg"], &surface.incidence_deg, length_m, checker);
    (counted && placed && turned).then_some(Draft { surface, body, chord_m })
}

/// Chord along the body: stated, or the width of its section.
fn chord(surface: &SurfaceBuilder, body: &Body, checker: &mut Checker) -> Option<Along> {
    let place = ["surface", surface.body.as_str(), "chord_m"];
    let length_m = body.length_m;
    if !(length_m > 0.0 && length_m < f64::INFINITY) {
        return None; // refused with the body
    }
    let chord_m = match &surface.chord_m {
        Some(chord_m) => {
            if !profile(&place, chord_m, length_m, checker) {
                return None;
            }
            chord_m.clone()
        }
        None if !section_stands(&body.name, checker) => return None,
        None => {
            let law = &body.section;
            let samples = law.samples_m(length_m);
            let widths: Option<Vec<[f64; 2]>> =
                samples.iter().map(|&s| law.solid_at(s).map(|_| [s, 2.0 * law.at(s).half_width_m])).collect();
            let Some(mut widths) = widths else {
                let allowed = "a finite length > 0 m: the body's section has no width to take it from";
                checker.refuse(&place, "none", allowed);
                return None;
            };
            widths.sort_by(|a, b| a[0].total_cmp(&b[0]));
            widths.dedup_by(|b, a| b[0] <= a[0]);
            match widths.len() {
                1 => Along::constant(widths[0][1]),
                _ => Along::Table(widths),
            }
        }
    };
    let least = least_of(&chord_m, length_m);
    if least > 0.0 {
        return Some(chord_m);
    }
    let found = format!("a chord that falls to {} m on the body", shortest(least));
    checker.refuse_state(&place, found, "a chord > 0 m all along the body");
    None
}

/// All surfaces in the order of their bodies.
pub(super) fn place_all(
    drafts: &[Draft],
    lattice: bool,
    bodies: &[Body],
    mirror: Option<Vector3<f64>>,
) -> Vec<LiftingSurface> {
    let edges: Vec<RootEdge> =
        drafts.iter().map(|draft| RootEdge { body: draft.body, chord: draft.chord_line(0.0) }).collect();
    let free = |draft: &Draft| if lattice { free_edges(draft.body, &edges, bodies, mirror) } else { [false; 2] };
    let mut surfaces: Vec<LiftingSurface> = drafts.iter().map(|draft| place(draft, free(draft), bodies)).collect();
    for surface in &mut surfaces {
        surface.other_half = other_half(surface.body, &edges, bodies).filter(|_| lattice);
    }
    surfaces.sort_by_key(|surface| surface.body);
    surfaces
}

/// Edges of the strips along the span and their chord lines.
fn place(draft: &Draft, free: [bool; 2], bodies: &[Body]) -> LiftingSurface {
    let length_m = bodies[draft.body].length_m;
    let strips = draft.surface.strips;
    let inset = free.map(|free| if free { INSET_PANELS } else { 0.0 });
    let width_m = length_m / (strips as f64 + inset[0] + inset[1]);
    let positions_m: Vec<f64> = (0..=strips)
        .map(|edge| match edge == strips && !free[1] {
            true => length_m,
            false => (inset[0] + edge as f64) * width_m,
        })
        .collect();
    let chords = positions_m.iter().map(|&s| draft.chord_line(s)).collect();
    LiftingSurface {
        body: draft.body,
        other_half: None,
        positions_m,
        chords,
        chord_panels: draft.surface.chord_panels,
        profile: draft.surface.profile.clone(),
    }
}
