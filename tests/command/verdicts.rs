//! The commands' verdicts refer to the machine with its aerodynamics, or are omitted.

use crate::command_line::{foldwing, succeeds};
use crate::whole::is_whole;

const GOLAND: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/goland_wing.toml");
const TUNNEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/wind_tunnel/sideslip_wing.toml");

/// Goland's wing with its axis at half the chord, at incidence, diverges below 160 m/s: the command used to report only flutter, because
/// the sign of the stiffness changes where no equilibrium is found. It reports the event and the speed at which the sweep ended.
#[test]
fn flutter_names_what_no_speed_stands_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("loaded.toml");
    let text = std::fs::read_to_string(GOLAND).unwrap();
    let loaded = text
        .replace("elastic_axis_fraction = 0.33", "elastic_axis_fraction = 0.5")
        .replace("incidence_deg = 0.0", "incidence_deg = 0.5");
    std::fs::write(&path, loaded).unwrap();
    let path = path.to_str().unwrap();
    let found = succeeds(&foldwing(&["flutter", path, "--wind-m-s", "130:160:2", "--count", "4", "--json"]));
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let found = &found["results"][0];
    let kinds: Vec<&str> =
        found["changes"].as_array().unwrap().iter().filter_map(|change| change["kind"].as_str()).collect();
    let named = !found["divergence_m_s"].as_array().unwrap().is_empty() || !kinds.is_empty();
    assert!(named, "{found}");
    assert_eq!(found["covered_m_s"].as_array().unwrap()[1], 160.0);
    assert_eq!(found["unstable_from_first"], true);
}

/// A wing swept forward by 30 deg on an elastic axis at the quarter chord, with aerodynamics and without gravity: its bending increases the
/// incidence.
fn swept_wing(air: &str, incidence_deg: f64, [elements, strips]: [usize; 2]) -> String {
    format!(
        r#"
name = "SweptForward"
gravity_m_s2 = [0.0, 0.0, 0.0]

[section.plate]
shape = "explicit"
axial_stiffness_N = 1e6
torsional_rigidity_N_m2 = 3.0
flap_stiffness_N_m2 = 2.622
edge_stiffness_N_m2 = 100.0
mass_kg_m = 0.3
second_moments_kg_m = [2e-4, 0.0, 2e-6]

[body.wing]
length_m = 0.6
section = "plate"
elements = {elements}

[joint.mount]
type = "clamped"
parent = "root"
child = "wing"
mount_rotation_deg = [0.0, 0.0, 30.0]

[aerodynamics]
{air}
density_kg_m3 = 1.225
wind_m_s = [0.0, -20.0, 0.0]

[surface.wing]
body = "wing"
chord_m = 0.1
elastic_axis_fraction = 0.25
strips = {strips}
incidence_deg = {incidence_deg}
"#
    )
}

/// Elements and strips for which the divergence speed is known, and a mesh of half of them or less.
const FINE: [usize; 2] = [6, 8];
const COARSE: [usize; 2] = [2, 4];
const LINE: &str = "model = \"strip\"\ntip_loss = \"lifting_line\"";
const LATTICE: &str = "model = \"uvlm\"\nwake_rows = 40";

/// A file with a model next to others of the test.
fn file(folder: &tempfile::TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// The measured sideslip wing with changed lines.
fn tunnel_wing(changes: &[(&str, &str)]) -> String {
    let mut text = std::fs::read_to_string(TUNNEL).unwrap();
    for (line, other) in changes {
        assert!(text.contains(line), "{line}");
        text = text.replace(line, other);
    }
    text
}

/// Exit code and JSON of `static` with the default branch, or its error message.
fn at_rest(arguments: &[&str]) -> Result<serde_json::Value, String> {
    let output = foldwing(&[&["static", "--json"], arguments].concat());
    match output.status.code() {
        Some(0) => Ok(serde_json::from_slice(&output.stdout).unwrap()),
        _ => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

/// `static` used to judge the stability of wings in a lattice with constant loads: it reported the measured wings, whose modes are stable,
/// as unstable, and a wing beyond its divergence speed as stable. Without options its verdict is that of the aeroelastic modes.
#[test]
fn statics_in_a_lattice_judge_the_wing_with_its_air() {
    let folder = tempfile::tempdir().unwrap();
    let pitched = tunnel_wing(&[("mount_rotation_deg = [3.0,", "mount_rotation_deg = [9.0,")]);
    let stability = at_rest(&[&file(&folder, "pitched.toml", &pitched)]).expect("at rest")["stability"].clone();
    assert_eq!(stability["stable"], true, "{stability}");
    assert_eq!((&stability["with_air_of_lattice"], &stability["left_path"]), (&true.into(), &serde_json::Value::Null));
    let lco = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/wind_tunnel/lco_wing.toml");
    let stability = at_rest(&[lco, "--set", "wind.velocity.y=-26"]).expect("at rest")["stability"].clone();
    assert_eq!((&stability["stable"], &stability["with_air_of_lattice"]), (&true.into(), &true.into()), "{stability}");
}

/// A forward-swept wing is stable below its divergence speed; beyond it, where no path leads to another equilibrium, there is an error that
/// names divergence; the branch `path` gives the state without a verdict. The speeds of lifting line and lattice differ by less than a
/// tenth.
#[test]
fn statics_name_divergence_in_every_air() {
    let folder = tempfile::tempdir().unwrap();
    for air in [LINE, LATTICE] {
        let model = file(&folder, "swept.toml", &swept_wing(air, 0.0, FINE));
        let below = at_rest(&[&model, "--set", "wind.velocity.y=-23"]).expect("at rest");
        assert_eq!(below["stability"]["stable"], true, "{}", below["stability"]);
        for speed in ["30", "45", "60"] {
            let wind = format!("wind.velocity.y=-{speed}");
            let refused = at_rest(&[&model, "--set", &wind]).expect_err("diverges");
            assert!(refused.contains("is unstable (body \"wing\" leaves it with"), "{speed}: {refused}");
            let kept = at_rest(&[&model, "--set", &wind, "--branch", "path"]).expect("on the path");
            assert_ne!(kept["stability"]["stable"], true, "{speed}");
        }
    }
}

/// From fold 0 the load path of the measured wing in sideslip, its tip twisted by 9 deg, leads to a saddle beyond 80 deg of fold. The
/// result used to be the saddle, with exit code 0; now it is the stable state below it, to which a start at 30 deg also leads.
#[test]
#[ignore = "long; `make long` runs it"]
fn statics_leave_a_saddle_of_a_free_tip() {
    let folder = tempfile::tempdir().unwrap();
    let angle_deg = |rest: &serde_json::Value| rest["joints"][0]["angle_rad"].as_f64().unwrap().to_degrees();
    let sideslips_deg: &[f64] = if is_whole() { &[16.0, 18.0] } else { &[18.0] };
    for sideslip_deg in sideslips_deg {
        let (sin, cos) = sideslip_deg.to_radians().sin_cos();
        let model = |start_deg: &str| {
            tunnel_wing(&[
                ("mount_rotation_deg = [3.0,", "mount_rotation_deg = [-3.0,"),
                ("start_angle_deg = 5.0", &format!("start_angle_deg = {start_deg}")),
                ("mirror_normal = [1.0, 0.0, 0.0]", ""),
                ("wind_m_s = [0.0, -22.0, 0.0]", &format!("wind_m_s = [{:?}, {:?}, 0.0]", -22.0 * sin, -22.0 * cos)),
                (
                    "strips = 5",
                    "strips = 5\nincidence_deg = { table = [[0.0, 0.0], [0.06, 0.0], [0.085, 9.0], [0.135, 9.0]] }",
                ),
            ])
        };
        let model_file = file(&folder, "from_0.toml", &model("0.0"));
        let saddle = at_rest(&[&model_file, "--branch", "path"]).expect("on the path");
        let found = at_rest(&[&model_file]).expect("at rest");
        let below = at_rest(&[&file(&folder, "from_30.toml", &model("30.0"))]).expect("at rest");
        assert!(angle_deg(&saddle).abs() > 80.0, "{}", angle_deg(&saddle));
        assert_eq!(found["stability"]["left_path"]["unstable_directions"], 1, "{}", found["stability"]);
        assert_eq!((&found["stability"]["stable"], &below["stability"]["stable"]), (&true.into(), &true.into()));
        assert_eq!(below["stability"]["left_path"], serde_json::Value::Null);
        // both equilibria converge to 1e-8 rad
        assert!((angle_deg(&found) - angle_deg(&below)).abs() < 1e-5, "{} {}", angle_deg(&found), angle_deg(&below));
    }
}

/// Divergence of a wing under load, at 26.05 m/s without load: at 0.05 deg of incidence the command used to report only flutter beyond it,
/// at 0.3 deg "neither flutter nor divergence" up to the last equilibrium. It reports the interval in which divergence lies, and its kind.
#[test]
#[ignore = "long; `make long` runs it"]
fn flutter_names_the_divergence_of_a_wing_under_load() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = |incidence_deg: f64, options: &[&str]| {
        // under load each speed takes ten times as long
        let mesh = if incidence_deg == 0.0 { FINE } else { COARSE };
        let path = file(&folder, "swept.toml", &swept_wing(LINE, incidence_deg, mesh));
        succeeds(&foldwing(&[&["flutter", &path, "--wind-m-s", "22.5:30:4", "--count", "4"], options].concat()))
    };
    let read = |incidence_deg: f64| -> serde_json::Value {
        let found: serde_json::Value = serde_json::from_str(&sweep(incidence_deg, &["--json"])).unwrap();
        found["results"][0].clone()
    };
    let divergence_m_s = read(0.0)["divergence_m_s"][0].as_f64().expect("divergence");
    assert!((divergence_m_s - 26.05).abs() < 0.05, "{divergence_m_s}");
    let incidences_deg: &[f64] = if is_whole() { &[0.05, 0.3] } else { &[0.3] };
    for &incidence_deg in incidences_deg {
        let found = read(incidence_deg);
        let changes = found["changes"].as_array().unwrap();
        let named = changes.iter().any(|change| {
            let at = |end: usize| change["between_m_s"][end].as_f64().unwrap();
            let kind = change["kind"].as_str().unwrap();
            // a wing under load jumps to another state at a slightly different speed: between the speeds of the sweep about it
            ["divergence", "jump", "unstable"].contains(&kind) && at(0) >= 25.0 && at(1) <= 27.5
        });
        assert!(named, "{incidence_deg}: {found}");
        // if the sweep ends because there is no equilibrium, this is reported
        assert!(found["covered_m_s"][1] == 30.0 || !found["ended"].is_null(), "{found}");
    }
    let text = sweep(0.3, &[]);
    assert!(!text.contains("neither flutter nor divergence") && text.contains("jumps"), "{text}");
}

/// The equilibria of a wing under load end where its stiffness vanishes: this speed is reported as a divergence speed, not only in the
/// message on the end of the sweep. `static` finds an equilibrium below it and none above.
#[test]
fn flutter_has_the_speed_at_which_equilibria_end() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string("examples/tutorial/sketch.toml").unwrap();
    let path = file(&folder, "aft.toml", &text.replace("elastic_axis_fraction = 0.25", "elastic_axis_fraction = 0.3"));
    let deployed = ["--set", "fold1.start_angle=0", "--set", "fold2.start_angle=0"];
    let text = succeeds(&foldwing(
        &[&["flutter", &path, "--wind-m-s", "48:60:3", "--count", "2"], deployed.as_slice()].concat(),
    ));
    let speed = text.lines().find_map(|line| line.strip_prefix("divergence at ")?.strip_suffix(" m/s"));
    let speed_m_s: f64 = speed.unwrap_or_else(|| panic!("{text}")).parse().unwrap();
    assert!(!text.contains("neither flutter nor divergence"), "{text}");
    for (share, stands) in [(0.999, true), (1.001, false)] {
        let wind = format!("wind.velocity.y={}", -share * speed_m_s);
        let found = foldwing(&[&["static", &path, "--set", &wind], deployed.as_slice()].concat());
        assert_eq!(found.status.success(), stands, "{share} of {speed_m_s} m/s");
    }
}

/// A motor that drives the joint away from its latch is reported in wind too, where the latch might still be reached.
#[test]
fn check_names_a_motor_that_pulls_away_from_the_latch() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string("examples/tutorial/sketch.toml").unwrap();
    let warnings = |text: &str| {
        let answer = foldwing(&["check", &file(&folder, "sign.toml", text)]);
        String::from_utf8_lossy(&answer.stderr).into_owned()
    };
    let wrong = warnings(&text.replace("constant_torque_N_m = -7.0", "constant_torque_N_m = 7.0"));
    assert!(wrong.contains("joint fold1: motor and spring pull the joint away from the latch at 0 deg"), "{wrong}");
    assert!(!wrong.contains("fold2") && !warnings(&text).contains("pull the joint away"), "{wrong}");
}

/// Wind from behind used to be accepted without a warning, and a latch was judged without the wind of the model.
#[test]
fn check_warns_of_wind_from_behind_and_excludes_the_air() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("behind.toml");
    let text = std::fs::read_to_string(TUNNEL).unwrap();
    std::fs::write(&path, text.replace("wind_m_s = [0.0, -22.0, 0.0]", "wind_m_s = [0.0, 22.0, 0.0]")).unwrap();
    let answer = foldwing(&["check", path.to_str().unwrap()]);
    let warnings = String::from_utf8_lossy(&answer.stderr).into_owned();
    assert!(warnings.contains("from behind, at 177 deg from its chord"), "{warnings}");
    let along = foldwing(&["check", TUNNEL]);
    assert!(!String::from_utf8_lossy(&along.stderr).contains("from its chord"));
    let text = succeeds(&along);
    assert!(text.contains("do not include the wind of the model") && !text.contains("; reaches"), "{text}");
}

/// Half a wing that overlaps with its image: `check` used to find nothing, and a run ended at its start.
#[test]
fn check_warns_of_a_run_that_does_not_start() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string("examples/tutorial/sketch.toml").unwrap();
    let section = text.split("[section.").nth(1).and_then(|part| part.split("\n[").next()).unwrap();
    let name = section.split(']').next().unwrap();
    let warnings = |incidence_deg: f64| {
        let model = format!(
            "name = \"Half\"\n[section.{section}\n[body.right]\nlength_m = 1.0\nsection = \"{name}\"\nelements = 1\n[joint.right]\n\
             type = \"clamped\"\nparent = \"root\"\nchild = \"right\"\nmount_rotation_deg = [0.0, 60.0, 0.0]\n\
             [aerodynamics]\nmodel = \"strip\"\ntip_loss = \"lifting_line\"\nwind_m_s = [0.0, -15.0, 0.0]\n\
             mirror_normal = [1.0, 0.0, 0.0]\n[surface.right]\nbody = \"right\"\nchord_m = 0.2\nstrips = 48\n\
             incidence_deg = {incidence_deg:?}\n"
        );
        let answer = foldwing(&["check", &file(&folder, "half.toml", &model)]);
        succeeds(&answer);
        String::from_utf8_lossy(&answer.stderr).into_owned()
    };
    let overlapping = warnings(15.0);
    assert!(overlapping.contains("simulations of this model do not start"), "{overlapping}");
    assert!(
        overlapping.contains("the surfaces of right and its image in the mirror plane overlap by"),
        "{overlapping}"
    );
    assert!(!warnings(0.0).contains("do not start"));
}

/// The name of a vector selects its components; it used to be rejected with a suggestion of one of them.
#[test]
fn outputs_take_vectors() {
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing_in_tunnel.toml");
    let table = succeeds(&foldwing(&["simulate", model, "--csv", "-", "--stop", "0.002", "--variables", "aero.force"]));
    assert!(table.starts_with("time,aero.force.x,aero.force.y,aero.force.z"), "{table}");
}

/// The table of modes has the natural frequencies of damped modes, as the JSON; modes over a key use the start values of `--set`.
#[test]
fn modes_are_the_same_in_text_json_and_over_a_key() {
    let wing = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing.toml");
    let json = |arguments: &[&str]| -> serde_json::Value {
        serde_json::from_str(&succeeds(&foldwing(&[&["modes", wing, "--json"], arguments].concat()))).unwrap()
    };
    let mode = &json(&["--count", "1"])["modes"][0];
    let [frequency_hz, damping] = ["frequency_Hz", "damping_ratio"].map(|key| mode[key].as_f64().unwrap());
    assert!(damping > 0.03, "the frequencies differ by more than the digits: {damping}");
    let text = succeeds(&foldwing(&["modes", wing, "--count", "1"]));
    assert!(text.contains(&format!("{frequency_hz:14.6} {damping:10.6}")), "{frequency_hz}: {text}");
    let over = ["--count", "1", "--vary", "fold.motor_stiffness=0.02,0.04"];
    let of = |settings: &[&str]| json(&[&over[..], settings].concat())["modes"][0]["frequency_Hz"][0].as_f64().unwrap();
    let (usual, soft) = (of(&[]), of(&["--set", "fold.latch_stiffness=10"]));
    assert!((usual - frequency_hz).abs() < 1e-5 && soft < 0.998 * usual, "{usual} {soft}");
}

/// Notes and warnings of a run are separate fields of its JSON.
#[test]
fn notes_are_no_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("capture.toml");
    let text = include_str!("../../examples/models/folding_wing.toml");
    let captured = text.replace("[joint.fold.latch]\n", "[joint.fold.latch]\ncapture_deg = 3.0\n");
    assert_ne!(captured, text);
    std::fs::write(&path, captured).unwrap();
    let run = succeeds(&foldwing(&["simulate", path.to_str().unwrap(), "--json", "--stop", "0.002"]));
    let run: serde_json::Value = serde_json::from_str(&run).unwrap();
    let [notes, warnings] = ["notes", "warnings"].map(|key| run[key].as_array().unwrap());
    assert!(warnings.is_empty() && notes.len() == 1, "{run}");
    assert!(notes[0].as_str().unwrap().contains("with capture_deg = 3 the enabled latch"), "{run}");
}
