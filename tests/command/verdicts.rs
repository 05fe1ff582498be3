//! Verdicts of the commands are about the machine with its air, or are not given.

use crate::command_line::{foldwing, succeeds};

const GOLAND: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/goland_wing.toml");
const TUNNEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/wind_tunnel/sideslip_wing.toml");

/// Goland's wing with its axis at half the chord, at incidence, diverges below 160 m/s: the answer named only flutter, as the sign of
/// the stiffness changes where no equilibrium is found. It names what happens, and how far the sweep reached.
#[test]
fn flutter_names_what_no_speed_stands_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("loaded.toml");
    let text = std::fs::read_to_string(GOLAND).unwrap();
    let loaded = text
        .replace("axis_fraction = 0.33", "axis_fraction = 0.5")
        .replace("incidence_deg = 0.0", "incidence_deg = 0.5");
    std::fs::write(&path, loaded).unwrap();
    let path = path.to_str().unwrap();
    let found = succeeds(&foldwing(&["flutter", path, "--speeds", "130:160:30", "--count", "4", "--json"]));
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let found = &found["results"][0];
    let kinds: Vec<&str> =
        found["changes"].as_array().unwrap().iter().filter_map(|change| change["kind"].as_str()).collect();
    let named = !found["divergence_m_s"].as_array().unwrap().is_empty() || !kinds.is_empty();
    assert!(named, "{found}");
    assert_eq!(found["covered_m_s"].as_array().unwrap()[1], 160.0);
    assert_eq!(found["unstable_from_first"], true);
}

/// Wind from behind was taken without a word, and a latch was judged without the wind of the model.
#[test]
fn check_doubts_wind_from_behind_and_leaves_the_air_out_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("behind.toml");
    let text = std::fs::read_to_string(TUNNEL).unwrap();
    std::fs::write(&path, text.replace("wind_m_s = [0.0, -22.0, 0.0]", "wind_m_s = [0.0, 22.0, 0.0]")).unwrap();
    let answer = foldwing(&["check", path.to_str().unwrap()]);
    let doubts = String::from_utf8_lossy(&answer.stderr).into_owned();
    assert!(doubts.contains("from behind, at 177 deg from its chord"), "{doubts}");
    let along = foldwing(&["check", TUNNEL]);
    assert!(!String::from_utf8_lossy(&along.stderr).contains("from its chord"));
    let text = succeeds(&along);
    assert!(text.contains("are without the wind of the model") && !text.contains("is reached;"), "{text}");
}

/// A vector chooses its components; it was refused with one of them proposed.
#[test]
fn outputs_take_vectors() {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing_in_tunnel.toml");
    let table = succeeds(&foldwing(&["simulate", model, "--csv", "-", "--stop", "0.002", "--output", "aero.force"]));
    assert!(table.starts_with("time,aero.force.x,aero.force.y,aero.force.z"), "{table}");
}
