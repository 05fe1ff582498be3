//! Lifting surfaces in code, and their strips on valid bodies.

use crate::aero::surface::{ChordLine, Profile};
use crate::beam::profile::Profile as Along;
use crate::machine::builder::flap::FlapBuilder;
use crate::machine::edges::{RootEdge, free_edges, other_half, slit, stands_on};
use crate::machine::fault::{Checker, Range, array_text};
use crate::machine::units::shortest;
use crate::machine::validate::air::MAXIMUM_STRIPS;
use crate::machine::validate::body::section_stands;
use crate::machine::validate::profile::{least_of, profile};
use crate::machine::{Body, LiftingSurface};
use nalgebra::Vector3;

/// Inset of a free edge of the lattice in panels: the error of uniform lattices that extend to the tip only decreases as `1/N`.
const INSET_PANELS: f64 = 0.25;
/// Distance, relative to a body's length, below which two positions coincide.
const NEAR: f64 = 1e-9;

/// Lifting surface of a body under construction, see [`LiftingSurface::on`].
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceBuilder {
    pub(super) body: String,
    pub(super) strips: usize,
    pub(super) chord_panels: usize,
    elastic_axis_fraction: Along,
    lift_slope_1_rad: Option<Along>,
    pub(super) forward: f64,
    chord_m: Option<Along>,
    incidence_deg: Along,
    flare_deg: Along,
    profile: Profile,
    /// Length in m of a blade on a rigid body.
    pub(super) length_m: Option<f64>,
    /// For a rotor blade: positions of its sections in m, and the name of the polar of each.
    pub(super) blade: Option<(Vec<f64>, Vec<String>)>,
}

impl LiftingSurface {
    /// A surface on the named body, with strips along the span. By default its chord is the width of the body's section, with the leading
    /// edge on the side of `+y` and the axis at mid-chord.
    pub fn on(body: impl Into<String>, strips: usize) -> SurfaceBuilder {
        SurfaceBuilder {
            body: body.into(),
            strips,
            chord_panels: 4,
            elastic_axis_fraction: Along::constant(0.5),
            lift_slope_1_rad: None,
            forward: 1.0,
            chord_m: None,
            incidence_deg: Along::constant(0.0),
            flare_deg: Along::constant(0.0),
            profile: Profile::THIN,
            length_m: None,
            blade: None,
        }
    }
}

impl SurfaceBuilder {
    /// Chord along the body in m.
    pub fn chord_m(self, chord_m: Along) -> Self {
        Self { chord_m: Some(chord_m), ..self }
    }

    /// Number of panels of the lattice along the chord. Default 4.
    pub fn chord_panels(self, chord_panels: usize) -> Self {
        Self { chord_panels, ..self }
    }

    /// Position of the beam's axis behind the leading edge, as a fraction of the chord along the body. Default 0.5.
    pub fn elastic_axis_fraction(self, elastic_axis_fraction: impl Into<Along>) -> Self {
        Self { elastic_axis_fraction: elastic_axis_fraction.into(), ..self }
    }

    /// Places the leading edge on the side of `−y`.
    pub fn leading_edge_minus_y(self) -> Self {
        Self { forward: -1.0, ..self }
    }

    /// Incidence of the chord relative to the section, along the body, in degrees, which are interpolated; positive raises the leading edge
    /// towards `+z`. Default 0.
    pub fn incidence_deg(self, incidence_deg: Along) -> Self {
        Self { incidence_deg, ..self }
    }

    /// Angle in degrees in the plane of the chord between the chordwise lines of the lattice and the chord, along the body, -75 to 75;
    /// positive moves the leading edge outboard along the body. The chord perpendicular to the body keeps its length. At a flared hinge it
    /// is the flare angle, so that the edges of both surfaces lie on the hinge and coincide while it folds. Lattice only. Default 0.
    pub fn flare_deg(self, flare_deg: impl Into<Along>) -> Self {
        Self { flare_deg: flare_deg.into(), ..self }
    }

    /// Lift-curve slope along the body in 1/rad, for strip theory: each strip has the value at its middle. Default: that of the profile.
    pub fn lift_slope_1_rad(self, lift_slope_1_rad: impl Into<Along>) -> Self {
        Self { lift_slope_1_rad: Some(lift_slope_1_rad.into()), ..self }
    }

    /// Makes the surface a rotor blade: positions of its sections in m from the inner end, ascending, and the name of the polar of each.
    pub fn blade(self, stations_m: Vec<f64>, polars: Vec<String>) -> Self {
        Self { strips: stations_m.len().saturating_sub(1), blade: Some((stations_m, polars)), ..self }
    }

    /// Length in m of a rotor blade on a rigid body, along the body's x axis from its origin.
    pub fn length_m(self, length_m: f64) -> Self {
        Self { length_m: Some(length_m), ..self }
    }

    /// Profile, with its upper side towards the section's `+z`, whichever side the leading edge is on. Default: a thin plate.
    pub fn profile(self, profile: Profile) -> Self {
        Self { profile, ..self }
    }
}

/// A surface with the data from which its strips are built.
pub(super) struct Draft<'b> {
    pub surface: &'b SurfaceBuilder,
    pub body: usize,
    chord_m: Along,
    /// Whether the body has a single frame, to which all chords refer.
    rigid: bool,
}

impl Draft<'_> {
    /// Chord at a distance in m from the body's inner end; in a `lattice` along the flared line.
    fn chord_line(&self, s: f64, lattice: bool) -> ChordLine {
        let SurfaceBuilder { incidence_deg, flare_deg, forward, elastic_axis_fraction, .. } = self.surface;
        let (chord_m, incidence_rad) = (self.chord_m.at(s), incidence_deg.at(s).to_radians());
        let elastic_axis_fraction = elastic_axis_fraction.at(s);
        let outward = if lattice { flare_deg.at(s).to_radians().tan() } else { 0.0 };
        let forward = Vector3::new(outward, forward * incidence_rad.cos(), incidence_rad.sin());
        let from_frame_m = Vector3::x() * if self.rigid { s } else { 0.0 };
        ChordLine {
            leading_m: from_frame_m + forward * (elastic_axis_fraction * chord_m),
            trailing_m: from_frame_m + forward * ((elastic_axis_fraction - 1.0) * chord_m),
        }
    }
}

/// Checks a surface: its body, numbers of strips and panels, chord and incidence. `None` after an error.
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
    let rigid = bodies[body].is_rigid();
    if rigid && surface.blade.is_none() {
        checker.refuse(&place, format!("{name:?}"), "a flexible body, or a rotor's blade; this one is rigid");
        return None;
    }
    if surfaces[..index].iter().any(|other| other.body == name) {
        checker.refuse(&place, format!("{name:?}"), "a body without a surface; this one already has one");
        return None;
    }
    let length_m = length_m(surface, &bodies[body], checker)?;
    let counted = checker.count(&["surface", name, "strips"], surface.strips, 1, MAXIMUM_STRIPS)
        & checker.count(&["surface", name, "chord_panels"], surface.chord_panels, 1, MAXIMUM_STRIPS);
    let placed =
        axis(surface, length_m, checker) & slope(surface, length_m, checker) & stations(surface, length_m, checker);
    let chord_m = chord(surface, &bodies[body], length_m, checker)?;
    let turned = profile(&["surface", name, "incidence_deg"], &surface.incidence_deg, length_m, checker)
        & flare(surface, length_m, checker);
    (counted && placed && turned).then_some(Draft { surface, body, chord_m, rigid })
}

/// Length of a surface: that of its body, or of a blade on a rigid body.
fn length_m(surface: &SurfaceBuilder, body: &Body, checker: &mut Checker) -> Option<f64> {
    let place = ["surface", surface.body.as_str(), "length_m"];
    match (surface.length_m, body.is_rigid()) {
        (None, false) => Some(body.length_m),
        (Some(length_m), true) if length_m > 0.0 && length_m.is_finite() => Some(length_m),
        (Some(length_m), false) => {
            checker.refuse(&place, shortest(length_m), "this key only on a rigid body; others have a length");
            None
        }
        (stated, true) => {
            let found = stated.map_or_else(|| "none".to_owned(), shortest);
            checker.refuse(&place, found, "a finite length > 0 m: a rigid body has none");
            None
        }
    }
}

/// Whether the stations of a blade are in ascending order and on the body.
fn stations(surface: &SurfaceBuilder, length_m: f64, checker: &mut Checker) -> bool {
    let Some((stations_m, _)) = &surface.blade else { return true };
    let within = stations_m.iter().all(|s| (0.0..=length_m * (1.0 + 1e-12)).contains(s));
    let fine = within && stations_m.len() >= 2 && stations_m.windows(2).all(|pair| pair[0] < pair[1]);
    if !fine {
        let allowed =
            format!("at least 2 lengths ascending from 0 to {} m, the length of the body", shortest(length_m));
        checker.refuse(&["surface", &surface.body, "stations_m"], array_text(stations_m), allowed);
    }
    fine
}

/// Whether the axis is near the chord along the whole body.
fn axis(surface: &SurfaceBuilder, length_m: f64, checker: &mut Checker) -> bool {
    let (what, allowed) = ("fractions", "a fraction of the chord from -10 to 10 all along the body");
    bounded(
        surface,
        ("elastic_axis_fraction", &surface.elastic_axis_fraction, 10.0),
        (what, allowed),
        length_m,
        checker,
    )
}

/// Whether the angle between the chordwise lines and the body's axis is large enough.
fn flare(surface: &SurfaceBuilder, length_m: f64, checker: &mut Checker) -> bool {
    let (what, allowed) = ("angles", "an angle from -75 to 75 deg all along the body");
    bounded(surface, ("flare_deg", &surface.flare_deg, 75.0), (what, allowed), length_m, checker)
}

/// Whether a function is within plus and minus a bound along the whole body; `what` and `allowed` are texts for the error.
fn bounded(
    surface: &SurfaceBuilder,
    (key, function, bound): (&str, &Along, f64),
    (what, allowed): (&str, &str),
    length_m: f64,
    checker: &mut Checker,
) -> bool {
    let place = ["surface", surface.body.as_str(), key];
    if let Some(value) = number(function) {
        return checker.number(&place, value, Range::Within(-bound, bound));
    }
    if !profile(&place, function, length_m, checker) {
        return false;
    }
    let (smallest, largest) = (least_of(function, length_m), -least_of(&negative(function), length_m));
    let within = smallest >= -bound && largest <= bound;
    if !within {
        let found = format!("{what} from {} to {} on the body", shortest(smallest), shortest(largest));
        checker.refuse_state(&place, found, allowed);
    }
    within
}

/// Whether the lift-curve slope is 0 or more along the whole body.
fn slope(surface: &SurfaceBuilder, length_m: f64, checker: &mut Checker) -> bool {
    let place = ["surface", surface.body.as_str(), "lift_slope_1_rad"];
    let Some(slope) = &surface.lift_slope_1_rad else { return true };
    if let Some(value) = number(slope) {
        return checker.number(&place, value, Range::AtLeast(0.0));
    }
    if !profile(&place, slope, length_m, checker) {
        return false;
    }
    let least = least_of(slope, length_m);
    if least < 0.0 {
        let found = format!("a lift slope that falls to {} on the body", shortest(least));
        checker.refuse_state(&place, found, "a slope >= 0 all along the body");
    }
    least >= 0.0
}

/// The value of a function that is given as a constant.
fn number(function: &Along) -> Option<f64> {
    match function {
        Along::Polynomial(coefficients) if coefficients.len() == 1 => coefficients.first().copied(),
        Along::Polynomial(_) | Along::Table(_) | Along::Pieces(_) => None,
    }
}

/// The function with the opposite sign.
fn negative(function: &Along) -> Along {
    match function {
        Along::Polynomial(coefficients) => Along::Polynomial(coefficients.iter().map(|c| -c).collect()),
        Along::Table(rows) => Along::Table(rows.iter().map(|row| [row[0], -row[1]]).collect()),
        Along::Pieces(pieces) => {
            Along::Pieces(pieces.iter().map(|[start, a, b, c, d]| [*start, -a, -b, -c, -d]).collect())
        }
    }
}

/// Chord along the body: as given, or the width of its section.
fn chord(surface: &SurfaceBuilder, body: &Body, length_m: f64, checker: &mut Checker) -> Option<Along> {
    let place = ["surface", surface.body.as_str(), "chord_m"];
    if !(length_m > 0.0 && length_m < f64::INFINITY) {
        return None; // already reported with the body
    }
    let chord_m = match &surface.chord_m {
        Some(chord_m) => {
            if !profile(&place, chord_m, length_m, checker) {
                return None;
            }
            chord_m.clone()
        }
        None if body.is_rigid() => {
            checker.refuse(&place, "none", "a finite length > 0 m: a rigid body has no section to take it from");
            return None;
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

/// Places all surfaces in the order of their bodies. `lattice`: surfaces of a lattice; `spans`: of a lattice or a lifting line, which
/// depend on the ends of a wing.
pub(super) fn place_all(
    drafts: &[Draft],
    flaps: &[FlapBuilder],
    (lattice, spans): (bool, bool),
    bodies: &[Body],
    mirror: Option<Vector3<f64>>,
    checker: &mut Checker,
) -> Option<Vec<LiftingSurface>> {
    let edges: Vec<RootEdge> =
        drafts.iter().map(|draft| RootEdge { body: draft.body, chord: draft.chord_line(0.0, lattice) }).collect();
    let free = |draft: &Draft| if spans { free_edges(draft.body, &edges, bodies, mirror) } else { [false; 2] };
    let placed = drafts.iter().map(|draft| place(draft, flaps, (free(draft), lattice), bodies, checker));
    // collects all of them first, so that every error is reported
    let mut surfaces: Vec<LiftingSurface> = placed.collect::<Vec<_>>().into_iter().collect::<Option<_>>()?;
    for surface in &mut surfaces {
        surface.other_half = other_half(surface.body, &edges, bodies).filter(|_| spans);
        surface.slit = slit(surface.body, &edges, bodies).filter(|_| spans);
        surface.at_mirror = spans && mirror.is_some_and(|normal| stands_on(&normal, surface.body, bodies));
    }
    surfaces.sort_by_key(|surface| surface.body);
    Some(surfaces)
}

/// Edges of the strips along the span, and their chord lines; the ends of control surfaces coincide with such edges.
fn place(
    draft: &Draft,
    flaps: &[FlapBuilder],
    (free, lattice): ([bool; 2], bool),
    bodies: &[Body],
    checker: &mut Checker,
) -> Option<LiftingSurface> {
    let (surface, length_m) = (draft.surface, bodies[draft.body].length_m);
    let positions_m: Vec<f64> = match &surface.blade {
        Some((stations_m, _)) => stations_m.clone(),
        None => {
            let ends = flaps.iter().filter(|flap| flap.is_on(&surface.body)).flat_map(|flap| flap.ends_m(length_m));
            let mut breaks_m: Vec<f64> = ends.filter(|place_m| *place_m > 0.0 && *place_m < length_m).collect();
            breaks_m.sort_by(f64::total_cmp);
            breaks_m.dedup_by(|later, earlier| *later - *earlier <= NEAR * length_m);
            let parts = breaks_m.len() + 1;
            if surface.strips < parts {
                let allowed = format!(
                    "at least {parts} strips, because the ends of the control surfaces divide the surface into {parts} parts"
                );
                checker.refuse(&["surface", &surface.body, "strips"], surface.strips, allowed);
                return None;
            }
            edges_m(length_m, &breaks_m, surface.strips, free)
        }
    };
    let chords: Vec<ChordLine> = positions_m.iter().map(|&s| draft.chord_line(s, lattice)).collect();
    if !lines_apart(surface, &positions_m, &chords, checker) {
        return None;
    }
    // for a leading edge towards -y the normal of eq. (W1), to which profiles refer, points along the section's -z
    let mut profile = match draft.surface.forward < 0.0 {
        true => draft.surface.profile.clone().upside_down(),
        false => draft.surface.profile.clone(),
    };
    match &draft.surface.lift_slope_1_rad {
        Some(slope) if slope.is_constant() => profile.lift_slope_1_rad = slope.at(0.0),
        Some(slope) => {
            let slopes = positions_m.windows(2).map(|edges| slope.at(0.5 * (edges[0] + edges[1])));
            profile.lift_slopes_1_rad = slopes.collect();
        }
        None => {}
    }
    Some(LiftingSurface {
        body: draft.body,
        other_half: None,
        slit: None,
        at_mirror: false,
        positions_m,
        chords,
        chord_panels: draft.surface.chord_panels,
        profile,
    })
}

/// Whether chordwise lines do not cross: each strip is at least a twentieth as wide at the leading and trailing edges as on the axis.
fn lines_apart(surface: &SurfaceBuilder, positions_m: &[f64], chords: &[ChordLine], checker: &mut Checker) -> bool {
    let narrow = positions_m.windows(2).zip(chords.windows(2)).find(|(ends_m, lines)| {
        let width_m = ends_m[1] - ends_m[0];
        let wide = |of: fn(&ChordLine) -> f64| width_m + of(&lines[1]) - of(&lines[0]);
        wide(|line| line.leading_m.x).min(wide(|line| line.trailing_m.x)) < 0.05 * width_m
    });
    if let Some((ends_m, _)) = narrow {
        let found = format!("chord lines that meet between {} and {} m", shortest(ends_m[0]), shortest(ends_m[1]));
        let allowed = "a flare that changes over a longer part of the body, so that chord lines do not cross";
        checker.refuse_state(&["surface", &surface.body, "flare_deg"], found, allowed);
    }
    narrow.is_none()
}

/// Edges of strips on a body with edges at given positions: every part between these is divided evenly into a number of strips in
/// proportion to its length, at least one. The lattice ends a quarter of a strip before a free end.
fn edges_m(length_m: f64, breaks_m: &[f64], strips: usize, free: [bool; 2]) -> Vec<f64> {
    let ends_m: Vec<f64> = [0.0].iter().chain(breaks_m).chain(&[length_m]).copied().collect();
    let parts = ends_m.len() - 1;
    let counts = shares(&ends_m, strips);
    let mut edges_m = Vec::with_capacity(strips + 1);
    for part in 0..parts {
        let [begin_m, end_m] = [ends_m[part], ends_m[part + 1]];
        let inset =
            [free[0] && part == 0, free[1] && part + 1 == parts].map(|free| if free { INSET_PANELS } else { 0.0 });
        let width_m = (end_m - begin_m) / (counts[part] as f64 + inset[0] + inset[1]);
        edges_m.extend((0..counts[part]).map(|edge| begin_m + (inset[0] + edge as f64) * width_m));
        if part + 1 == parts {
            edges_m.push(if free[1] { begin_m + (inset[0] + counts[part] as f64) * width_m } else { end_m });
        }
    }
    edges_m
}

/// Number of strips of each part between consecutive ends: in proportion to its length, at least one, with the given sum. `strips` is at
/// least the number of parts.
fn shares(ends_m: &[f64], strips: usize) -> Vec<usize> {
    let widths_m: Vec<f64> = ends_m.windows(2).map(|ends| ends[1] - ends[0]).collect();
    let mut counts = vec![1; widths_m.len()];
    // the next strip is added where the strips are widest
    for _ in counts.len()..strips {
        let width_m = |part: usize| widths_m[part] / counts[part] as f64;
        let widest =
            (0..counts.len()).fold(0, |widest, part| if width_m(part) > width_m(widest) { part } else { widest });
        counts[widest] += 1;
    }
    counts
}
