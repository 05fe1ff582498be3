//! A run in the format of the page: a description as JSON, and single-precision numbers in base64.

use crate::acting::Event;
use crate::outlines::AerofoilScene;
use crate::recording::{BodyScene, Frame, Recording, Scene};
use crate::signals::Signals;
use crate::turbine::SolidScene;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use foldwing_engine::machine::Travel;
use foldwing_engine::plant::{SectionPlace, SurfaceLattice};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Maximum number of values in the frames of all runs of a page: with signals and libraries a page of one run stays below 10 MB.
pub const MAXIMUM_NUMBERS: usize = 1_200_000;

/// Maximum number of values in the frames of a video, which no browser loads.
const MAXIMUM_NUMBERS_OF_FILM: usize = 40_000_000;

/// Version of the format read by `run.js`; a page of another version cannot be compared.
pub const FORMAT: u64 = 4;

/// A run as text.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedRun {
    /// JSON that is safe inside a script element of a page.
    pub description: String,
    /// Little-endian single-precision numbers, base64.
    pub numbers: String,
}

/// A run as numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Packing {
    /// JSON that is safe inside a script element of a page.
    pub description: String,
    /// Signals, then frames.
    pub numbers: Vec<f32>,
}

impl PackedRun {
    /// Packs a recording with its signals; frames are thinned at equal intervals, keeping the first and the last, to the space that one
    /// of `runs` runs has in a page.
    pub fn new(recording: &Recording, signals: &Signals, runs: usize) -> Self {
        Packing::of_run(recording, signals, runs).into()
    }

    /// Packs a recording for a video: without signals, with all frames as far as memory allows.
    pub fn for_film(recording: &Recording) -> Self {
        let Recording { scene, frames, .. } = recording;
        let chosen = chosen(frames, &scene.travels, MAXIMUM_NUMBERS_OF_FILM);
        let signals = Signals::new([], 1);
        Packing::of(scene, (&recording.watch.events, recording.seen), &signals, &chosen).into()
    }

    /// Packs all states, without a history.
    pub fn of_states(scene: &Scene, frames: &[Frame], signals: &Signals) -> Self {
        Packing::of(scene, (&[], frames.len() as u64), signals, &frames.iter().collect::<Vec<_>>()).into()
    }
}

impl From<Packing> for PackedRun {
    fn from(Packing { description, numbers }: Packing) -> Self {
        Self { description, numbers: encoded(&numbers) }
    }
}

impl Packing {
    /// Packs a recording with its signals, as [`PackedRun::new`].
    pub fn of_run(recording: &Recording, signals: &Signals, runs: usize) -> Self {
        let Recording { scene, frames, .. } = recording;
        let chosen = chosen(frames, &scene.travels, MAXIMUM_NUMBERS / runs.max(1));
        Self::of(scene, (&recording.watch.events, recording.seen), signals, &chosen)
    }

    fn of(scene: &Scene, (events, seen): (&[Event], u64), signals: &Signals, chosen: &[&Frame]) -> Self {
        let mut numbers: Vec<f32> = signals.rows.clone();
        let mut begins = Vec::new();
        let mut rows = Vec::new();
        for frame in chosen {
            begins.push(numbers.len());
            rows.push(frame.lattice.iter().map(|surface| surface.wake_circulation_m2_s.len()).collect::<Vec<_>>());
            numbers.extend(fixed_part(frame, &scene.travels));
            numbers.extend(frame.lattice.iter().flat_map(wake_part));
        }
        let description = in_script(&description(scene, (events, seen), signals, chosen, (&begins, &rows)));
        Self { description, numbers }
    }
}

/// Encodes numbers as text.
pub fn encoded(numbers: &[f32]) -> String {
    STANDARD.encode(numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>())
}

/// JSON that is safe inside a script element of the page and contains none of the page's placeholders.
pub fn in_script(value: &Value) -> String {
    // both occur only in JSON strings, where the escapes are equivalent
    value.to_string().replace('<', "\\u003c").replace("{{", "{\\u007b")
}

/// Returns whether a text could be the output of [`in_script`].
pub fn stays_in_script(text: &str) -> bool {
    !text.contains('<') && !text.contains("{{")
}

/// Selects frames at equal intervals, with at most `most` numbers in total.
fn chosen<'f>(frames: &'f [Frame], travels: &[Travel], most: usize) -> Vec<&'f Frame> {
    let size = |frame: &Frame| {
        fixed_part(frame, travels).len() + frame.lattice.iter().map(|s| wake_part(s).len()).sum::<usize>()
    };
    let largest = frames.iter().map(size).max().unwrap_or(0).max(1);
    let count = frames.len().min((most / largest).max(2));
    (0..count).map(|i| &frames[(frames.len() - 1) * i / (count - 1).max(1)]).collect()
}

/// Scalars, followed by the geometry, in the order read by `run.js`.
pub fn fixed_part(frame: &Frame, travels: &[Travel]) -> Vec<f32> {
    let (energy, acting) = (&frame.energy, &frame.acting);
    let coordinates = travels.iter().zip(&frame.angles_rad).map(|(travel, coordinate)| travel.shown(*coordinate));
    let latched = frame.latched.iter().map(|latched| f64::from(u8::from(*latched)));
    let scalars = [frame.time_s].into_iter().chain(coordinates).chain(latched).chain(frame.strains.iter().copied());
    let energies =
        [energy.kinetic, energy.elastic, energy.gravity, energy.motor, energy.work, energy.dissipated, energy.total];
    let sections = frame.sections.iter().flatten().flat_map(|section| {
        let axes: [Vector3<f64>; 4] = [
            section.position_m,
            section.rotation.column(1).into(),
            section.rotation.column(2).into(),
            section.velocity_m_s,
        ];
        axes.into_iter().flat_map(components).chain(section.measures.iter().copied().collect::<Vec<_>>())
    });
    let edges = frame.edges_m.iter().flatten().flatten().copied().flat_map(components);
    let stations = (0..acting.stations_m.len()).flat_map(|i| {
        let of_one = [acting.stations_m[i], acting.forces_n[i], acting.moments_n_m[i], acting.air_n[i]];
        of_one.into_iter().flat_map(components)
    });
    let loads =
        frame.loads.iter().flatten().flat_map(|wrench| [wrench.force_n, wrench.moment_n_m]).flat_map(components);
    let edge_forces = frame.edge_forces_n.iter().flatten().copied().flat_map(components);
    // the forces of the panels are not known for a state that was restored
    let panel_forces = frame.lattice.iter().flat_map(|surface| {
        let panels = (surface.corner_m.len() - 2) * surface.circulation_m2_s.len();
        let known = surface.panel_force_n.iter().flatten().copied();
        known.chain(std::iter::repeat(f64::NAN)).take(panels)
    });
    let reactions = acting.reactions.iter().flatten().copied().flat_map(components);
    let wind = acting.wind_m_s.iter().copied().flat_map(components);
    scalars
        .chain(energies)
        .chain(frame.gauges_m.iter().copied().flat_map(components))
        .chain(sections)
        .chain(edges)
        .chain(stations)
        .chain(reactions)
        .chain(components(acting.gravity_m_s2))
        .chain(wind)
        .chain(acting.circulation_m2_s.iter().copied())
        .chain(loads)
        .chain(edge_forces)
        .chain(panel_forces)
        .map(|number| number as f32)
        .collect()
}

fn components(vector: Vector3<f64>) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

/// Nodes of the wake, followed by the circulations of its rings.
pub fn wake_part(surface: &SurfaceLattice) -> Vec<f32> {
    let nodes = surface.wake_node_m.iter().flatten().flat_map(|node| node.iter());
    nodes.chain(surface.wake_circulation_m2_s.iter().flatten()).map(|number| *number as f32).collect()
}

/// Data with which `run.js` interprets the numbers, and the texts of the page.
fn description(
    scene: &Scene,
    (events, seen): (&[Event], u64),
    signals: &Signals,
    frames: &[&Frame],
    (begins, rows): (&[usize], &[Vec<usize>]),
) -> Value {
    let body = |(body, places): (&BodyScene, &Vec<SectionPlace>)| {
        let loaded = !places.is_empty();
        json!({
            "name": body.name, "joint": body.joint, "rims": body.rims_m, "places": body.places_m,
            "stiffness": body.stiffness, "rigid": body.is_rigid, "loaded": loaded, "outlined": body.has_outline, "carrier": body.carrier,
        })
    };
    let first = frames.first();
    let columns = first.map_or_else(Vec::new, |frame| frame.edges_m.iter().map(Vec::len).collect());
    let surfaces: Vec<_> = scene
        .surfaces
        .iter()
        .zip(&columns)
        .map(|(surface, columns)| {
            json!({
                "body": surface.body, "columns": columns, "panels": surface.chord_panels, "places": surface.places_m,
            })
        })
        .collect();
    let wake_columns = |surface: &SurfaceLattice| surface.wake_node_m.first().map_or(0, Vec::len);
    let wakes = first.map_or_else(Vec::new, |frame| frame.lattice.iter().map(wake_columns).collect::<Vec<_>>());
    let acting = first.map(|frame| &frame.acting);
    let hinges: Vec<_> = scene
        .hinges
        .iter()
        .map(|hinge| {
            json!({
                "name": hinge.name, "body": hinge.body, "kind": hinge.kind, "axis": components(hinge.axis),
                "freedom": hinge.freedom, "latch": hinge.has_latch,
            })
        })
        .collect();
    let masses: Vec<_> = scene
        .masses
        .iter()
        .map(|mass| {
            json!({
                "name": mass.name, "body": mass.body, "place": mass.place_m, "offset": components(mass.offset_m),
                "kg": mass.mass_kg,
            })
        })
        .collect();
    let stations: Vec<_> =
        scene.stations.iter().map(|station| json!({ "name": station.name, "body": station.body })).collect();
    let mut events: Vec<_> = events.iter().collect();
    events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let events: Vec<_> =
        events.iter().map(|event| json!({ "t": event.time_s, "text": event.text, "kind": event.kind })).collect();
    json!({
        "format": FORMAT,
        "name": scene.name,
        "description": scene.description,
        "bodies": scene.bodies.iter().zip(&scene.load_places).map(body).collect::<Vec<_>>(),
        "joints": scene.joints.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        "units": scene.travels.iter().map(|travel| if *travel == Travel::Rotation { "°" } else { " m" }).collect::<Vec<_>>(),
        "coordinates": scene.travels.iter().map(|travel| travel.coordinate()).collect::<Vec<_>>(),
        "gauges": scene.gauges.iter().map(|gauge| json!({ "name": gauge.name, "body": gauge.body, "place": gauge.place_m, "point": gauge.point_m })).collect::<Vec<_>>(),
        "tips": scene.tips,
        "hinges": hinges,
        "masses": masses,
        "stations": stations,
        "energies": ["kinetic", "elastic", "gravity", "motor", "work of inputs", "dissipated", "total"],
        "surfaces": surfaces,
        "winds": acting.map_or(0, |acting| acting.wind_m_s.len()),
        "strips": acting.map_or(0, |acting| acting.circulation_m2_s.len()),
        "wakes": wakes,
        "edgeForces": first.is_some_and(|frame| !frame.edge_forces_n.is_empty()),
        "panelForces": first.is_some_and(|frame| !frame.lattice.is_empty()),
        "rotor": scene.is_rotor,
        "aerofoils": scene.aerofoils.iter().map(|aerofoil| aerofoil.as_ref().map(aerofoil_json)).collect::<Vec<_>>(),
        "solids": solids_json(&scene.solids),
        "notes": scene.notes,
        "events": events,
        "begins": begins,
        "rows": rows,
        "signals": signals.columns.iter().map(|(name, unit)| json!([name, unit])).collect::<Vec<_>>(),
        "signalRows": signals.kept(),
        "points": signals.points,
        "recorded": seen,
    })
}

/// Rounded to 1e-5 of the chord, which is invisible.
fn aerofoil_json(aerofoil: &AerofoilScene) -> Value {
    let rounded = |value: &f64| (value * 1e5).round() / 1e5;
    let heights = |side: usize| -> Vec<Vec<f64>> {
        aerofoil.heights.iter().map(|edge| edge.iter().map(|pair| rounded(&pair[side])).collect()).collect()
    };
    json!({
        "stations": aerofoil.stations.iter().map(rounded).collect::<Vec<_>>(), "upper": heights(0), "lower": heights(1),
        "hidesSpar": aerofoil.hides_spar,
    })
}

fn solids_json(solids: &[SolidScene]) -> Value {
    let solid = |solid: &SolidScene| {
        let rings: Vec<Vec<[f32; 3]>> = solid
            .rings_m
            .iter()
            .map(|ring| ring.iter().map(|point| point.map(|number| number as f32)).collect())
            .collect();
        json!({ "part": solid.part, "body": solid.body, "rings": rings, "round": solid.is_round })
    };
    solids.iter().map(solid).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::tests::{recorded, shipped};

    /// The two axes of a section in the page span the section: with the centre line of a straight body they form a right-handed
    /// orthogonal system.
    #[test]
    fn axes_of_sections_span_them() {
        let run = recorded(shipped("folding_wing"), 2);
        let frame = &run.frames[0];
        let numbers = fixed_part(frame, &run.scene.travels);
        let before =
            1 + frame.angles_rad.len() + frame.latched.len() + frame.strains.len() + 7 + 3 * frame.gauges_m.len();
        let measures = frame.sections[0][0].measures.len();
        let vector = |section: usize, part: usize| {
            let first = before + section * (12 + measures) + 3 * part;
            Vector3::new(numbers[first], numbers[first + 1], numbers[first + 2]).map(f64::from)
        };
        let count = frame.sections[0].len();
        let line = (vector(count - 1, 0) - vector(0, 0)).normalize();
        for section in 0..count {
            let [y, z] = [1, 2].map(|part| vector(section, part));
            // single precision
            assert!((y.cross(&z) - line).norm() < 1e-5, "section {section}: {y} {z} {line}");
            assert!(y.dot(&z).abs() < 1e-6 && (y.norm() - 1.0).abs() < 1e-6);
        }
    }

    /// Frames are thinned before a page becomes too large, keeping the first and the last.
    #[test]
    fn pages_are_bounded() {
        let short = recorded(shipped("folding_wing"), 2);
        let one = fixed_part(&short.frames[0], &short.scene.travels).len();
        let count = 3 * MAXIMUM_NUMBERS / one;
        let mut frames = vec![short.frames[1].clone(); count];
        frames[0] = short.frames[0].clone();
        frames[count - 1] = short.frames[2].clone();
        let kept = chosen(&frames, &short.scene.travels, MAXIMUM_NUMBERS);
        assert!(
            kept.len() * one <= MAXIMUM_NUMBERS && (kept.len() + 1) * one > MAXIMUM_NUMBERS,
            "{} frames",
            kept.len()
        );
        assert_eq!((kept[0].time_s, kept[kept.len() - 1].time_s), (short.frames[0].time_s, short.frames[2].time_s));
        assert!(chosen(&frames, &short.scene.travels, MAXIMUM_NUMBERS / 2).len() <= kept.len().div_ceil(2));
    }
}
