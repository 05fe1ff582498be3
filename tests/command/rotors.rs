//! Studies of rotors in scripts: `periodic`, `operating-points`, `modes --vary rotor_speed_rpm`.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// The stand of the turbine tests, small and fast: three blades with one flap and one edge shape, pitched by locked joints.
const ROTOR: &str = r#"
name = "Rotor"
gravity_m_s2 = [0.0, 0.0, 0.0]
[rigid_body.hub]
mass_kg = 10.0
inertia_kg_m2 = [1.0, 1.0, 1.0, 0, 0, 0]
[joint.shaft]
type = "revolute"
parent = "root"
child = "hub"
axis = [1, 0, 0]
start_rate_deg_s = 240.0
[modal_body.blade]
count = 3
length_m = 9.5
nodes = 8
stations = [0, 1]
mass_kg_m = [10, 5]
flap_stiffness_N_m2 = [1e6, 2e5]
edge_stiffness_N_m2 = [2e6, 4e5]
flap_shapes = [[1.0]]
edge_shapes = [[1.0]]
flap_damping_ratios = [0.01]
edge_damping_ratios = [0.01]
[joint.pitch]
type = "revolute"
parent = "hub"
child = "blade"
axis = [0.0, 0.0, -1.0]
motion = "locked"
parent_offset_m = [0.0, 0.0, 0.5]
mount_rotation_deg = [127.27922061357854, 0.0, 127.27922061357854]
"#;

const AIR: &str = r#"
[aerodynamics]
model = "bem"
hub = "hub"
hub_radius_m = 0.5
wind_m_s = [8.0, 0.0, 0.0]
step_s = 0.02
[surface.blade]
body = "blade"
elastic_axis_fraction = 0.25
stations_m = [0.0, 2.0, 4.0, 6.0, 8.0, 9.5]
polars = ["plate", "plate", "plate", "plate", "plate", "plate"]
chord_m = 0.5
incidence_deg = { table = [[0.0, -20.0], [2.0, -12.0], [5.0, -5.0], [9.5, -1.0]] }
[polar.plate]
rows = [[-180, 0, 0.5, 0], [-12, -1.1, 0.03, 0], [12, 1.1, 0.03, 0], [180, 0, 0.5, 0]]
"#;

/// A folder with the rotor, with and without aerodynamics.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("windy.toml"), format!("{ROTOR}{AIR}")).expect("a file");
    std::fs::write(folder.path().join("bare.toml"), ROTOR).expect("a file");
    folder
}

fn call(folder: &Path, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_foldwing"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .output()
        .expect("the command runs")
}

#[track_caller]
fn told(folder: &Path, line: &str) -> String {
    let output = call(folder, line);
    assert!(output.status.success(), "{line}\n{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[track_caller]
fn json(folder: &Path, line: &str) -> Value {
    serde_json::from_str(&told(folder, &format!("{line} --json"))).expect("JSON")
}

/// Mean of an output at a point.
#[track_caller]
fn mean(table: &Value, point: usize, name: &str) -> f64 {
    let outputs = table["outputs"].as_array().expect("outputs");
    let place = outputs.iter().position(|output| output["name"] == name).expect(name);
    table["points"][point]["mean"][place].as_f64().expect("a number")
}

/// Lists are combined value by value, or in all combinations; CSV and JSON have the same numbers; the speed for a tip speed ratio is
/// bounded; the torque that holds the shaft balances the aerodynamic torque.
#[test]
fn points_of_a_rotor() {
    let folder = folder();
    let folder = folder.path();
    let table =
        json(folder, "operating-points windy.toml --wind-m-s 7,9 --speed-rpm 30:50:3 --pitch-deg 0,2 --csv points.csv");
    let points = table["points"].as_array().expect("points");
    assert_eq!(points.len(), 12);
    let of = |k: usize, key: &str| points[k][key].as_f64().expect(key);
    assert_eq!([of(3, "wind_m_s"), of(3, "rotor_speed_rpm").round(), of(3, "pitch_deg")], [7.0, 40.0, 2.0]);
    assert!(points.iter().all(|point| point["state"] == "steady" && point["peak_to_peak"][0] == 0.0));
    let csv = std::fs::read_to_string(folder.join("points.csv")).expect("a table");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let column = reader.headers().expect("a header").iter().position(|name| name == "rotor.power.mean").expect("power");
    let powers: Vec<f64> = reader.records().map(|row| row.expect("a row")[column].parse().expect("a number")).collect();
    // the JSON reader may lose the last digit
    assert!(powers.iter().enumerate().all(|(k, power)| (power / mean(&table, k, "rotor.power") - 1.0).abs() < 1e-14));
    // the torque that holds the shaft is opposite to the aerodynamic torque
    let [torque, holding] = ["rotor.torque", "shaft.holding_torque"].map(|name| mean(&table, 2, name));
    assert!((torque + holding).abs() < 1e-6 * torque.abs(), "{torque} {holding}");
    assert!(
        (mean(&table, 2, "rotor.power") / torque - of(2, "rotor_speed_rpm") * std::f64::consts::PI / 30.0).abs() < 1e-9
    );

    let paired = json(folder, "operating-points windy.toml --wind-m-s 7,9 --speed-rpm 30,50 --pitch-deg 2 --paired");
    assert_eq!(paired["points"].as_array().expect("points").len(), 2);
    assert_eq!(mean(&paired, 1, "rotor.thrust"), mean(&table, 11, "rotor.thrust"));

    let bounded = json(folder, "operating-points windy.toml --wind-m-s 4,8 --tip-speed-ratio 6 --speed-rpm 40");
    let ratio = mean(&bounded, 0, "rotor.tip_speed_ratio");
    // for the wind at the bent blades; the given ratio is that of the rigid rotor
    assert!((ratio / 6.0 - 1.0).abs() < 0.02, "{ratio}");
    assert!((bounded["points"][1]["rotor_speed_rpm"].as_f64().expect("a speed") - 40.0).abs() < 1e-12);
}

/// The pitch and the speed that hold an output, from either side of the last point, and where holding is unnecessary or impossible.
#[test]
fn points_that_hold_an_output() {
    let folder = folder();
    let folder = folder.path();
    let free = json(folder, "operating-points windy.toml --wind-m-s 8,10,12 --speed-rpm 40 --pitch-deg 6");
    // the power at 10 m/s and 6 degrees: at 12 m/s more pitch holds it, at 10 m/s those 6 degrees, at 6 m/s the power is lower
    let power = mean(&free, 1, "rotor.power");
    assert!(power > 0.0);
    let line = format!(
        "operating-points windy.toml --wind-m-s 12,10,14,6 --speed-rpm 40 --solve-for pitch_deg=0:40 --target rotor.power={power:?}"
    );
    let held = json(folder, &line);
    for (k, expected) in ["held", "held", "held", "below"].iter().enumerate() {
        assert_eq!(held["points"][k]["hold"], *expected, "point {k}");
    }
    let pitch = |k: usize| held["points"][k]["pitch_deg"].as_f64().expect("a pitch");
    assert!((pitch(1) - 6.0).abs() < 1e-3, "{}", pitch(1));
    assert!(pitch(2) > pitch(0) && pitch(0) > 6.0 && pitch(3) == 0.0);
    (0..3).for_each(|k| assert!((mean(&held, k, "rotor.power") / power - 1.0).abs() < 1e-6, "point {k}"));
    assert!(mean(&held, 3, "rotor.power") < power);

    let torque = mean(&json(folder, "operating-points windy.toml --wind-m-s 8 --speed-rpm 55"), 0, "rotor.torque");
    let line = format!(
        "operating-points windy.toml --wind-m-s 8 --solve-for speed_rpm=35:90 --target rotor.torque={torque:?}"
    );
    let held = json(folder, &line);
    assert!((held["points"][0]["rotor_speed_rpm"].as_f64().expect("a speed") - 55.0).abs() < 1e-3, "{held:#}");
    // a row without a state contains the cause, the other rows are kept; a single such row is an error
    let line = format!(
        "operating-points windy.toml --wind-m-s 6,14 --speed-rpm 40 --solve-for pitch_deg=0:1 --target rotor.power={power:?}"
    );
    let output = call(folder, &line);
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    assert!(
        output.status.success() && out.contains("none") && err.contains("is above the target everywhere"),
        "{out}{err}"
    );
    let output = call(folder, &line.replace("6,14", "14"));
    assert_eq!(output.status.code(), Some(3));
}

/// Searches compute energies only if these are outputs. Over the revolution at the end of the search, dissipated energy and work are those
/// of the motion found by `periodic`. Tolerances: the ends of the revolution differ by 1e-8, which affects work more than the dissipated
/// energy.
#[test]
fn accounts_of_an_operating_point_are_those_of_its_turn() {
    let folder = folder();
    let common =
        "--speed-rpm 40 --steps 144 --tolerance 1e-8 --set gravity=0,0,-9.81 --variables energy.work,energy.dissipated";
    let point = json(folder.path(), &format!("operating-points windy.toml --wind-m-s 8 {common}"));
    let turn = json(folder.path(), &format!("periodic windy.toml --count 0 {common}"));
    assert_eq!(point["points"][0]["state"], "periodic");
    for (name, share) in [("energy.work", 1e-3), ("energy.dissipated", 1e-5)] {
        let outputs = turn["outputs"].as_array().expect("outputs");
        let of_turn = outputs.iter().find(|output| output["name"] == name).expect(name);
        let [found, known] = [mean(&point, 0, name), of_turn["mean"].as_f64().expect("a number")];
        assert!(known > 0.05 && (found / known - 1.0).abs() < share, "{name}: {found} J instead of {known}");
    }
}

/// A pitch held by a motor is equivalent to that of a locked joint: start angle and command are both set.
#[test]
fn drives_pitch_the_blades_too() {
    let folder = folder();
    let folder = folder.path();
    let drive = "motor = { stiffness_N_m_rad = 1e9, damping_N_m_s_rad = 1e6, inertia_kg_m2 = 1.0 }";
    let driven = format!("{ROTOR}{AIR}").replace("motion = \"locked\"", drive);
    std::fs::write(folder.join("driven.toml"), driven).expect("a file");
    let power = |model: &str| {
        mean(
            &json(folder, &format!("operating-points {model} --wind-m-s 8 --speed-rpm 40 --pitch-deg 6")),
            0,
            "rotor.power",
        )
    };
    let [locked, driven] = ["windy.toml", "driven.toml"].map(power);
    assert!((driven / locked - 1.0).abs() < 1e-5, "{driven} {locked}");
    let free = format!("{ROTOR}{AIR}").replace("motion = \"locked\"", "motor = { inertia_kg_m2 = 1.0 }");
    std::fs::write(folder.join("free.toml"), free).expect("a file");
    let output = call(folder, "operating-points free.toml --wind-m-s 8 --speed-rpm 40 --pitch-deg 6");
    assert!(String::from_utf8_lossy(&output.stderr).contains("no motor holds its pitch angle"));
}

/// Gravity causes a periodic variation: the table contains ranges, equal to those printed by `periodic`.
#[test]
fn points_that_swing() {
    let folder = folder();
    let folder = folder.path();
    let table =
        json(folder, "operating-points windy.toml --wind-m-s 8 --speed-rpm 40 --set gravity.z=-9.81 --steps 288");
    assert_eq!(table["points"][0]["state"], "periodic");
    let line = "periodic windy.toml --speed-rpm 40 --set gravity.z=-9.81 --steps 288 --count 0 --variables body.blade1.deflection.y,rotor.power";
    let periodic = json(folder, line);
    for output in periodic["outputs"].as_array().expect("outputs") {
        let name = output["name"].as_str().expect("a name");
        let outputs = table["outputs"].as_array().expect("outputs");
        let place = outputs.iter().position(|own| own["name"] == name).expect(name);
        let range = table["points"][0]["peak_to_peak"][place].as_f64().expect("a range");
        let other = 2.0 * output["half_range"].as_f64().expect("a range");
        // ends of the revolution that agree to 1e-6, and to 1e-8
        let size = mean(&table, 0, name).abs();
        assert!((range - other).abs() < 1e-3 * other + 1e-6 * size, "{name}: {range} {other}");
        let (own, other) = (mean(&table, 0, name), output["mean"].as_f64().expect("a mean"));
        assert!((own - other).abs() < 1e-4 * own.abs().max(range), "{name}: {own} {other}");
    }
    let text =
        told(folder, "operating-points windy.toml --wind-m-s 8 --speed-rpm 40 --set gravity.z=-9.81 --steps 288");
    assert!(text.contains("means | peak to peak") && text.contains("periodic"), "{text}");
}

/// The periodic motion of the command: table, CSV over the revolution, modes; its text describes the state.
#[test]
fn a_motion_that_repeats() {
    let folder = folder();
    let folder = folder.path();
    let text =
        told(folder, "periodic bare.toml --speed-rpm 40 --set gravity.z=-9.81 --steps 288 --count 6 --csv turn.csv");
    assert!(text.contains("periodic at 40.000000 rpm") && text.contains("blade flap 1"), "{text}");
    let csv = std::fs::read_to_string(folder.join("turn.csv")).expect("a table");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 146);
    assert!(lines[0].starts_with("turn_deg,") && lines[145].starts_with("360,"));
    let other = call(folder, "periodic bare.toml --speed-rpm 40 --steps 288 --count 0 --variables tip --csv turn.csv");
    assert!(!other.status.success(), "another table is not overwritten");
}

/// `modes --vary rotor_speed_rpm` uses Floquet theory automatically under gravity and for a rotor with a heavier blade, with the picture;
/// with nearly zero gravity its modes are those by the Coleman transformation.
#[test]
fn campbell_diagrams_of_both_kinds() {
    let folder = folder();
    let folder = folder.path();
    let over = "modes bare.toml --vary rotor_speed_rpm=20,40 --count 6";
    let coleman = told(folder, &format!("{over} --csv coleman.csv"));
    let floquet = told(folder, &format!("{over} --csv floquet.csv --set gravity.z=-1e-9 --plot pictures"));
    assert!(coleman.contains("without aerodynamics") && floquet.contains("about the periodic steady state"));
    assert!(folder.join("pictures/campbell.png").is_file());
    let rows = |name: &str| -> Vec<(f64, f64, f64, String)> {
        let text = std::fs::read_to_string(folder.join(name)).expect("a table");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let mut list: Vec<(f64, f64, f64, String)> = reader
            .records()
            .map(|row| {
                let row = row.expect("a row");
                let number = |k: usize| row[k].parse().expect("a number");
                (number(0), number(2), number(3), row[6].to_owned())
            })
            .collect();
        list.sort_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).expect("numbers"));
        list
    };
    let (one, other) = (rows("coleman.csv"), rows("floquet.csv"));
    // the shaft is free in one case and its speed prescribed in the other: collective edge modes differ
    let blades = |list: Vec<(f64, f64, f64, String)>| -> Vec<(f64, f64, f64, String)> {
        list.into_iter().filter(|row| row.3.contains("ward") || row.3.contains("flap 1 collective")).collect()
    };
    let (one, other) = (blades(one), blades(other));
    assert!(one.len() >= 8, "{one:?}");
    for row in &one {
        let same = other.iter().filter(|known| known.0 == row.0 && known.3 == row.3);
        let near = same.map(|known| (known.1 / row.1 - 1.0).abs() + (known.2 - row.2).abs()).fold(f64::MAX, f64::min);
        // 720 steps of fourth order
        assert!(near < 1e-5, "{row:?} in {other:?}");
    }
    // one blade is heavier: the transformation does not give constant coefficients
    let heavy = format!(
        "{ROTOR}[rigid_body.ball]\nmass_kg = 5.0\ninertia_kg_m2 = [0.1, 0.1, 0.1, 0, 0, 0]\n[joint.ball]\ntype = \"clamped\"\nparent = \"blade1\"\nchild = \"ball\"\n"
    );
    std::fs::write(folder.join("heavy.toml"), heavy).expect("a file");
    let output = call(folder, "modes heavy.toml --vary rotor_speed_rpm=20,40 --count 4");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && stderr.contains("not isotropic"), "{stderr}");
    let output = call(folder, "modes heavy.toml --state undeformed --vary rotor_speed_rpm=20,40 --count 4");
    assert_eq!(output.status.code(), Some(3));
}

/// Linear models include rotor aerodynamics: states of dynamic inflow and dynamic stall with name and unit, wind and gusts as inputs, and
/// the rotor's outputs.
#[test]
fn linear_models_are_in_the_air_of_the_rotor() {
    let folder = folder();
    let folder = folder.path();
    let options = "model = \"bem\"\ndynamic_inflow = true\ndynamic_stall = true";
    std::fs::write(folder.join("lagging.toml"), format!("{ROTOR}{AIR}").replace("model = \"bem\"", options))
        .expect("a file");
    let read = |file: &str| -> Value {
        serde_json::from_str(&std::fs::read_to_string(folder.join(file)).expect("a file")).expect("JSON")
    };
    let line = "linearize lagging.toml --state start --inputs wind.velocity.x,gust.x --outputs rotor.thrust,rotor.power -o lagging.json";
    let text = told(folder, line);
    assert!(text.contains("with aerodynamics") && !text.contains("constant aerodynamic loads"), "{text}");
    let model = read("lagging.json");
    assert_eq!(model["without_air"], false);
    let states = model["states"].as_array().expect("states");
    let unit = |name: &str| {
        let state = states.iter().find(|state| state["name"] == name).unwrap_or_else(|| panic!("{name} in {states:?}"));
        state["unit"].as_str().expect("a unit")
    };
    // the blade root has no aerodynamic load and so no states
    assert!(states.iter().all(|state| !state["name"].as_str().expect("a name").contains("station[1]")), "{states:?}");
    for (name, expected) in [
        ("inflow_axial", "m/s"),
        ("inflow_tangential", "m/s"),
        ("induced_axial", "m/s"),
        ("induced_tangential", "m/s"),
        ("wake[1]", "rad"),
        ("wake[2]", "rad"),
        ("attached_lift", "1"),
        ("attachment", "1"),
    ] {
        assert_eq!(unit(&format!("blade3.station[4].{name}")), expected);
    }
    // 3 blades of 4 loaded stations with 8 states, and 7 degrees of freedom and their rates
    assert_eq!(states.len(), 3 * 4 * 8 + 14);
    let gain = |model: &Value, row: usize, column: usize| model["D"][row][column].as_f64().expect("a number");
    assert_eq!(gain(&model, 0, 0), gain(&model, 0, 1), "a uniform gust is wind");
    assert!(gain(&model, 0, 0) > 0.0 && gain(&model, 1, 0) > 0.0);
    told(folder, "linearize windy.toml --state start --inputs wind.velocity.x --outputs rotor.thrust -o windy.json");
    assert_eq!(read("windy.json")["states"].as_array().expect("states").len(), 14);
}

/// `package --interface me` warns of rotors whose loads jump with the momentum balance, with JSON too, and of no others.
#[test]
fn jumps_of_steady_inflow_have_a_warning() {
    let folder = folder();
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/airs");
    let cases =
        [("wing_with_propellers", "me", true), ("wing_with_propellers", "cs", false), ("twin_rotor", "me", false)];
    for (model, kind, jumps) in cases {
        let output = Command::new(env!("CARGO_BIN_EXE_foldwing"))
            .args(["package", &format!("{examples}/{model}.toml"), "--interface", kind, "--no-reference", "--json"])
            .args(["--force", "-o", "x.fmu", "--library"])
            .arg(crate::library())
            .current_dir(folder.path())
            .output()
            .expect("the command runs");
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && told.contains("steady inflow jumps") == jumps, "{model} {kind}: {told}");
    }
}
