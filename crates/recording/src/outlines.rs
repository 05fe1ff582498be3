//! Outlines of aerofoils on the lifting surfaces, for pictures.
//!
//! The outline is that of the section if the model gives it, otherwise symmetric: of the thickness that the model gives, or of an assumed one.

use foldwing_engine::machine::{LiftingSurface, Machine};

/// Thickness of an aerofoil relative to its chord where the model gives none: of wings, and of the blades of rotors.
pub const ASSUMED: [f64; 2] = [0.12, 0.18];

/// A section whose width is the chord to this fraction is the aerofoil, not a spar in it.
const WIDTH: f64 = 0.15;

/// Intervals along the chord in addition to those of the panels.
const INTERVALS: usize = 8;

/// Maximum number of panels along the chord whose edges are points of the outline.
const MAXIMUM_PANELS: usize = 40;

/// Heights of an aerofoil over its chord line at common positions, relative to the chord.
#[derive(Debug, Clone, PartialEq)]
pub struct AerofoilScene {
    /// Positions behind the leading edge, from 0 to 1; the edges of the panels are among them.
    pub stations: Vec<f64>,
    /// Upper and lower height at each position, for each edge of the strips. Positive is the direction of chord × span, where the chord
    /// points to the trailing edge and the span to the outer end.
    pub heights: Vec<Vec<[f64; 2]>>,
    /// Source of the heights.
    pub source: AerofoilSource,
    /// The aerofoil hides a spar whose outline the model gives.
    pub hides_spar: bool,
}

/// Source of the outline of an aerofoil.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AerofoilSource {
    /// Outline of the section.
    Outline,
    /// Symmetric, with the thickness of the section.
    Thickness,
    /// Symmetric, with an assumed thickness.
    Assumed,
}

/// The aerofoil of each lifting surface; `None` for a plate, which is drawn as the body that it is.
pub(crate) fn aerofoils(machine: &Machine) -> Vec<Option<AerofoilScene>> {
    let surfaces = machine.air.iter().flat_map(|air| &air.surfaces).enumerate();
    surfaces.map(|(index, surface)| aerofoil(machine, surface, index)).collect()
}

/// Sentence that names the outlines that are not in the model.
pub(crate) fn note(machine: &Machine, aerofoils: &[Option<AerofoilScene>]) -> Option<String> {
    let source = aerofoils.iter().flatten().map(|aerofoil| aerofoil.source).max()?;
    match source {
        AerofoilSource::Outline => None,
        AerofoilSource::Thickness => Some("Aerofoils: symmetric, with the thickness of the sections.".to_owned()),
        AerofoilSource::Assumed => {
            let air = machine.air.as_ref()?;
            let [wing, blade] = ASSUMED.map(|assumed| 100.0 * assumed);
            let assumed = match (air.is_rotor(), air.rotors().next()) {
                (true, _) => format!("{blade} %"),
                (false, None) => format!("{wing} %"),
                (false, Some(_)) => format!("{wing} % (blades {blade} %)"),
            };
            Some(format!("Aerofoils: symmetric, {assumed} thick where the model has no outline or thickness."))
        }
    }
}

fn aerofoil(machine: &Machine, surface: &LiftingSurface, index: usize) -> Option<AerofoilScene> {
    let body = &machine.bodies[surface.body];
    let stations = stations(surface.chord_panels);
    let chord_m = |column: usize| (surface.chords[column].trailing_m - surface.chords[column].leading_m).norm();
    if !body.aerofoil.is_empty() {
        let flip = surface.chords[0].leading_m.y < surface.chords[0].trailing_m.y;
        let own: Vec<[f64; 2]> = stations.iter().map(|x| heights(&body.aerofoil, *x, flip)).collect();
        let heights = vec![own; surface.positions_m.len()];
        return Some(AerofoilScene { stations, heights, source: AerofoilSource::Outline, hides_spar: false });
    }
    let [wing, blade] = ASSUMED;
    let (part, _) = machine.air.as_ref()?.part_of(index)?;
    let assumed = if part.options.is_rotor() { blade } else { wing };
    let (mut source, mut hides_spar) = (AerofoilSource::Assumed, false);
    let mut found = Vec::with_capacity(surface.positions_m.len());
    for (column, place_m) in surface.positions_m.iter().enumerate() {
        let mut thickness = if is_round(machine, index, *place_m) { 1.0 } else { assumed };
        if !body.is_rigid() {
            let section = body.section.at(*place_m);
            let [width, height] =
                [section.half_width_m, section.half_height_m].map(|half_m| 2.0 * half_m / chord_m(column));
            if width > 1.0 - WIDTH && height > 0.0 {
                if body.section.solid_at(*place_m).is_some() {
                    return None;
                }
                (thickness, source) = (height, AerofoilSource::Thickness);
            } else if width > 0.0 {
                hides_spar = true;
            }
        }
        found.push(stations.iter().map(|x| [symmetric(*x, thickness), -symmetric(*x, thickness)]).collect());
    }
    Some(AerofoilScene { stations, heights: found, source, hides_spar })
}

/// Positions along the chord: closer to each other at the edges, and the edges of the panels.
fn stations(panels: usize) -> Vec<f64> {
    let spread = (0..=INTERVALS).map(|i| 0.5 - 0.5 * (i as f64 * std::f64::consts::PI / INTERVALS as f64).cos());
    let edges = (1..panels.min(MAXIMUM_PANELS)).map(|k| k as f64 / panels as f64);
    let mut found: Vec<f64> = edges.chain(spread).collect();
    found.sort_by(f64::total_cmp);
    found.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    found
}

/// Half the thickness of a symmetric aerofoil: of four digits with a closed trailing edge up to a thickness of 0.4, an ellipse at 1.
fn symmetric(x: f64, thickness: f64) -> f64 {
    let naca = 5.0 * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x.powi(2) + 0.2843 * x.powi(3) - 0.1036 * x.powi(4));
    let round = (x * (1.0 - x)).max(0.0).sqrt();
    let roundness = ((thickness - 0.4) / 0.6).clamp(0.0, 1.0);
    thickness * (naca.max(0.0) + roundness * (round - naca.max(0.0)))
}

/// Returns whether the polar of a blade has no lift near a position: its sections are cylinders.
fn is_round(machine: &Machine, surface: usize, place_m: f64) -> bool {
    let part = machine.air.as_ref().and_then(|air| air.part_of(surface));
    let Some((rotor, blade)) = part.and_then(|(part, blade)| Some((part.options.rotor()?, blade))) else {
        return false;
    };
    let (Some(places_m), Some(sections)) = (rotor.positions_m.get(blade), rotor.sections.get(blade)) else {
        return false;
    };
    let near = places_m.iter().zip(sections).min_by(|a, b| (a.0 - place_m).abs().total_cmp(&(b.0 - place_m).abs()));
    near.is_some_and(|(_, polar)| rotor.polars[*polar].rows.iter().all(|row| row.lift == 0.0))
}

/// Upper and lower height of an outline over a position; `flip` exchanges the sides.
fn heights(outline: &[[f64; 2]], x: f64, flip: bool) -> [f64; 2] {
    let nose = outline.iter().map(|point| point[0]).fold(f64::INFINITY, f64::min);
    let tail = outline.iter().map(|point| point[0]).fold(f64::NEG_INFINITY, f64::max);
    let at = nose + x * (tail - nose);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for pair in outline.windows(2) {
        let [[x0, z0], [x1, z1]] = [pair[0], pair[1]];
        if at < x0.min(x1) || at > x0.max(x1) {
            continue;
        }
        let ends = if x1 == x0 { [z0, z1] } else { [z0 + (at - x0) / (x1 - x0) * (z1 - z0); 2] };
        for z in ends {
            low = low.min(z);
            high = high.max(z);
        }
    }
    if low > high {
        [0.0; 2]
    } else if flip {
        [-low, -high]
    } else {
        [high, low]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldwing_file as config;

    fn wing(section: &str, surface: &str) -> Machine {
        let text = format!(
            "name = \"w\"\n[section.s]\n{section}\n[body.b]\nlength_m = 2.0\nsection = \"s\"\nelements = 2\n\
             [joint.j]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"b\"\n\
             [aerodynamics]\nmodel = \"strip\"\ndensity_kg_m3 = 1.2\nwind_m_s = [10.0, 0.0, 0.0]\n\
             [surface.b]\nbody = \"b\"\nstrips = 4\n{surface}\n[simulation]\nstop_time_s = 0.1\nstep_s = 0.01\n"
        );
        config::parse(&text, "w").unwrap_or_else(|error| panic!("{error:?}"))
    }

    const PROFILE: &str = "shape = \"profile\"\nchord_m = 0.5\naerofoil = \"naca2412\"\nskin_wall_m = 1e-3\nmaterial = \"aluminium 2024-T3\"";

    /// The outline of a profile is that of NACA 2412 (camber line and thickness of the four-digit series), on either side of the
    /// section: at 40 % of the chord the camber is 2 %, the thickness near 12 %.
    #[test]
    fn a_profile_has_its_own_outline() {
        for (side, sign) in [("+y", 1.0), ("-y", -1.0)] {
            let machine = wing(
                &format!("{PROFILE}\nleading_edge = \"{side}\""),
                &format!("leading_edge = \"{side}\"\nchord_m = 0.5\nelastic_axis_fraction = 0.4"),
            );
            let found = aerofoils(&machine).remove(0).unwrap();
            assert_eq!((found.source, found.heights.len(), found.hides_spar), (AerofoilSource::Outline, 5, false));
            let near = found.stations.iter().position(|x| *x > 0.3).unwrap();
            let [upper, lower] = found.heights[0][near];
            let middle = 0.5 * (upper + lower);
            // camber of 2412 at x = 0.309: 0.02/0.16·(0.8 x − x²) = 0.01896
            assert!((sign * middle - 0.018_96).abs() < 2e-4, "{side}: {middle}");
            assert!(((upper - lower) - 0.12).abs() < 1e-3, "{side}: {}", upper - lower);
            assert!(found.heights[0].iter().all(|[upper, lower]| upper >= lower), "{side}");
        }
    }

    /// Without an outline the aerofoil is symmetric: of the thickness of a section as wide as the chord, else of the assumed one; a solid
    /// section of this width is a plate. The largest thickness of the four-digit series lies at 30 % of the chord.
    #[test]
    fn thickness_is_that_of_the_section_or_assumed() {
        let explicit = |half_width: f64| {
            format!(
                "shape = \"explicit\"\naxial_stiffness_N = 1e6\ntorsional_rigidity_N_m2 = 1e3\nflap_stiffness_N_m2 = 1e3\nedge_stiffness_N_m2 = 1e4\n\
             mass_kg_m = 1.0\nsecond_moments_kg_m = [1e-3, 0.0, 1e-5]\nhalf_width_m = {half_width}\nhalf_height_m = 0.05"
            )
        };
        let largest =
            |found: &AerofoilScene| found.heights[2].iter().map(|[upper, lower]| upper - lower).fold(0.0, f64::max);
        for (section, source, thickness, hides) in [
            (explicit(0.25), AerofoilSource::Thickness, 0.2, false),
            (explicit(0.05), AerofoilSource::Assumed, ASSUMED[0], true),
        ] {
            let found = aerofoils(&wing(&section, "chord_m = 0.5")).remove(0).unwrap();
            assert_eq!((found.source, found.hides_spar), (source, hides));
            assert!((largest(&found) - thickness).abs() < 0.002 * thickness, "{}", largest(&found));
            assert!(found.heights.iter().all(|own| own[0] == [0.0; 2] && own[own.len() - 1][0].abs() < 1e-12));
        }
        let plate = "shape = \"rectangle\"\nwidth_m = 0.5\nheight_m = 0.01\ndensity_kg_m3 = 1e3\nyoungs_modulus_Pa = 1e9\npoisson_ratio = 0.3";
        assert_eq!(aerofoils(&wing(plate, "chord_m = 0.5")), [None]);
    }

    /// The edges of panels are among the positions along the chord.
    #[test]
    fn panels_end_at_positions() {
        for panels in [0, 1, 3, 7] {
            let found = stations(panels);
            assert!(
                (0..=panels).all(|k| found.iter().any(|x| panels == 0 || (x - k as f64 / panels as f64).abs() < 1e-6))
            );
            assert!(
                found.windows(2).all(|pair| pair[1] > pair[0])
                    && found[0] == 0.0
                    && (found[found.len() - 1] - 1.0).abs() < 1e-12
            );
        }
    }
}
