//! A page that plays a run in a browser: one file with its data, no network, no library.

use crate::report::recording::{BodyScene, Frame, GaugeScene, Recording};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use foldwing_engine::machine::Travel;
use foldwing_engine::plant::SurfaceLattice;
use serde_json::{Value, json};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 4] =
    [include_str!("scene.js"), include_str!("camera.js"), include_str!("draw.js"), include_str!("page.js")];

/// Numbers (single precision) that a page holds at most: 6 MB, 8 MB as text.
const MOST_NUMBERS: usize = 1_500_000;

/// The page as HTML. Of recordings that would make it too large, frames are left out at equal intervals, never the first
/// nor the last.
pub fn page(recording: &Recording) -> String {
    let chosen = chosen(&recording.frames, &recording.scene.travels);
    let mut numbers: Vec<f32> = Vec::new();
    let mut begins = Vec::new();
    let mut rows = Vec::new();
    for frame in &chosen {
        begins.push(numbers.len());
        rows.push(frame.lattice.iter().map(|surface| surface.wake_circulation_m2_s.len()).collect::<Vec<_>>());
        numbers.extend(fixed_part(frame, &recording.scene.travels));
        numbers.extend(frame.lattice.iter().flat_map(wake_part));
    }
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let described = in_script(&description(recording, &chosen, &begins, &rows));
    let title = recording.scene.name.replace('&', "&amp;").replace('<', "&lt;");
    PAGE.replace("{{title}}", &title)
        .replace("{{style}}", STYLE)
        .replace("{{script}}", &SCRIPTS.concat())
        .replace("{{description}}", &described)
        .replace("{{data}}", &STANDARD.encode(bytes))
}

/// JSON that stays within its element of the page, and that holds none of the page's own placeholders.
fn in_script(value: &Value) -> String {
    // both stand in texts only, where the escapes mean the same
    value.to_string().replace('<', "\\u003c").replace("{{", "{\\u007b")
}

/// As many frames as the page has room for, at equal intervals.
fn chosen<'f>(frames: &'f [Frame], travels: &[Travel]) -> Vec<&'f Frame> {
    let size = |frame: &Frame| {
        fixed_part(frame, travels).len() + frame.lattice.iter().map(|s| wake_part(s).len()).sum::<usize>()
    };
    let largest = frames.iter().map(size).max().unwrap_or(0).max(1);
    let count = frames.len().min((MOST_NUMBERS / largest).max(2));
    (0..count).map(|i| &frames[(frames.len() - 1) * i / (count - 1).max(1)]).collect()
}

/// Scalars, then what is drawn, in the order that `scene.js` reads.
fn fixed_part(frame: &Frame, travels: &[Travel]) -> Vec<f32> {
    let energy = &frame.energy;
    let coordinates = travels.iter().zip(&frame.angles_rad).map(|(travel, coordinate)| travel.shown(*coordinate));
    let scalars = [frame.time_s].into_iter().chain(coordinates);
    let scalars = scalars.chain(frame.strains.iter().copied());
    let energies =
        [energy.kinetic, energy.elastic, energy.gravity, energy.drive, energy.work, energy.dissipated, energy.total];
    let gauges = frame.gauges_m.iter().flat_map(|place| place.iter().copied());
    let sections = frame.sections.iter().flatten().flat_map(|section| {
        let axes = [section.position_m, section.rotation.column(1).into(), section.rotation.column(2).into()];
        let measures = [section.measures[0], section.measures[2], section.measures[3]];
        axes.into_iter().flat_map(|axis| [axis.x, axis.y, axis.z]).chain(measures)
    });
    let edges = frame.edges_m.iter().flatten().flatten().flat_map(|point| point.iter().copied());
    scalars.chain(energies).chain(gauges).chain(sections).chain(edges).map(|number| number as f32).collect()
}

/// Nodes of the wake, then circulations of its rings.
fn wake_part(surface: &SurfaceLattice) -> Vec<f32> {
    let nodes = surface.wake_node_m.iter().flatten().flat_map(|node| node.iter());
    nodes.chain(surface.wake_circulation_m2_s.iter().flatten()).map(|number| *number as f32).collect()
}

/// What `scene.js` must know to read the numbers, and the words of the page.
fn description(recording: &Recording, frames: &[&Frame], begins: &[usize], rows: &[Vec<usize>]) -> Value {
    let (scene, history) = (&recording.scene, &recording.history);
    let body = |body: &BodyScene| {
        json!({
            "name": body.name, "joint": body.joint, "rims": body.rims_m,
        })
    };
    let gauge = |gauge: &GaugeScene| json!({ "name": gauge.name });
    let surfaces = frames.first().map_or_else(Vec::new, |frame| frame.edges_m.iter().map(Vec::len).collect());
    let columns = |surface: &SurfaceLattice| surface.wake_node_m.first().map_or(0, Vec::len);
    let wakes = frames.first().map_or_else(Vec::new, |frame| frame.lattice.iter().map(columns).collect::<Vec<_>>());
    let unit = |travel: &Travel| if *travel == Travel::Rotation { "°" } else { " m" };
    json!({
        "name": scene.name,
        "description": scene.description,
        "bodies": scene.bodies.iter().map(body).collect::<Vec<_>>(),
        "joints": scene.joints.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        "units": scene.travels.iter().map(unit).collect::<Vec<_>>(),
        "coordinates": scene.travels.iter().map(|travel| travel.coordinate()).collect::<Vec<_>>(),
        "latches": history.latches_s,
        "gauges": scene.gauges.iter().map(gauge).collect::<Vec<_>>(),
        "energies": ["kinetic", "elastic", "gravity", "drive", "work of inputs", "dissipated", "total"],
        "surfaces": surfaces,
        "wakes": wakes,
        "begins": begins,
        "rows": rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::recording::tests::{recorded, shipped};

    #[test]
    fn page_has_every_placeholder_once() {
        for name in ["title", "style", "script", "description", "data"] {
            assert_eq!(PAGE.matches(&format!("{{{{{name}}}}}")).count(), 1, "{name}");
        }
        for script in SCRIPTS {
            assert!(!script.contains("{{") && !script.contains("</script"), "a script would be torn");
        }
    }

    /// A description cannot end the element that holds it, nor draw the data into it.
    #[test]
    fn texts_of_the_model_stay_texts() {
        let mut machine = shipped("folding_wing");
        let hostile = "</script><script>alert(1)</script>{{data}} & \"quoted\"";
        machine.description = hostile.to_owned();
        let page = page(&recorded(machine, 3));
        assert_eq!(page.matches("</script").count(), PAGE.matches("</script").count());
        let begin = page.find("id=\"description\">").unwrap() + "id=\"description\">".len();
        let end = begin + page[begin..].find("</script").unwrap();
        let read: Value = serde_json::from_str(&page[begin..end]).unwrap();
        assert_eq!(read["description"], hostile);
        assert_eq!(read["begins"].as_array().unwrap().len(), 4);
    }

    /// Frames are left out before a page becomes too large, and the first and the last stay.
    #[test]
    fn pages_are_bounded() {
        let short = recorded(shipped("folding_wing"), 2);
        let one = fixed_part(&short.frames[0], &short.scene.travels).len();
        let count = 3 * MOST_NUMBERS / one;
        let mut frames = vec![short.frames[1].clone(); count];
        frames[0] = short.frames[0].clone();
        frames[count - 1] = short.frames[2].clone();
        let kept = chosen(&frames, &short.scene.travels);
        assert!(kept.len() * one <= MOST_NUMBERS && (kept.len() + 1) * one > MOST_NUMBERS, "{} frames", kept.len());
        assert_eq!((kept[0].time_s, kept[kept.len() - 1].time_s), (short.frames[0].time_s, short.frames[2].time_s));
    }
}
