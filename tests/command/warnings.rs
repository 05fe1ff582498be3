//! Warnings about the flow and about suction: for the wind actually set, in the state computed.

use crate::command_line::{foldwing, succeeds};

/// A clamped wing along x with its leading edge to +y.
fn wing(air: &str, wind_m_s: &str, incidence_deg: f64) -> String {
    format!(
        r#"
name = "Implausible"
gravity_m_s2 = [0.0, 0.0, 0.0]

[section.plate]
shape = "explicit"
axial_stiffness_N = 1e6
torsional_rigidity_N_m2 = 300.0
flap_stiffness_N_m2 = 300.0
edge_stiffness_N_m2 = 100.0
mass_kg_m = 0.3
second_moments_kg_m = [2e-4, 0.0, 2e-6]

[body.wing]
length_m = 0.6
section = "plate"
elements = 2
mass_damping_1_s = 5.0

[joint.mount]
type = "clamped"
parent = "root"
child = "wing"

[aerodynamics]
{air}
density_kg_m3 = 1.225
wind_m_s = {wind_m_s}

[surface.wing]
body = "wing"
chord_m = 0.1
elastic_axis_fraction = 0.25
strips = 4
incidence_deg = {incidence_deg}
"#
    )
}

const STRIPS: &str = "model = \"strip\"";
const LATTICE: &str = "model = \"uvlm\"\nwake_rows = 20";
const FRONT: &str = "[0.0, -10.0, 0.0]";
const SPAN: &str = "[10.0, 0.0, 0.0]"; // from root to tip: in the opposite direction the apparent mass reduces the damping of bending

/// Runs a command that must succeed on a model, and returns its standard error and its JSON if requested.
fn warnings(text: &str, command: &[&str]) -> (String, serde_json::Value) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wing.toml");
    std::fs::write(&path, text).unwrap();
    let mut arguments = vec![command[0], path.to_str().unwrap()];
    arguments.extend(&command[1..]);
    let output = foldwing(&arguments);
    let printed = succeeds(&output);
    (String::from_utf8(output.stderr).unwrap(), serde_json::from_str(&printed).unwrap_or_default())
}

/// Runs a command that must fail on a model, and returns its standard error and exit code.
fn failing(text: &str, command: &[&str]) -> (String, i32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wing.toml");
    std::fs::write(&path, text).unwrap();
    let mut arguments = vec![command[0], path.to_str().unwrap()];
    arguments.extend(&command[1..]);
    let output = foldwing(&arguments);
    (String::from_utf8(output.stderr).unwrap(), output.status.code().unwrap())
}

const ALONG: &str = "warning: the wind meets the surface of wing along the span, at 90 deg from its chord";
const SUCTION: &str = "warning: the lattice has no suction at the leading edge";

const FLUTTER: [&str; 5] = ["flutter", "--wind-m-s", "5:6:2", "--count=2", "--json"];

/// `trim` and `flutter` used to check the wind of the file: there was no warning for a wind from behind set by an option, and one for a
/// wind from the front that replaced a spanwise one.
#[test]
fn the_wind_that_is_set_counts() {
    let trim = ["trim", "--solve-for", "wind.velocity.z", "--target", "root.force.z=-0.05", "--json"];
    for command in [&["static", "--json"][..], &FLUTTER, &trim] {
        let behind = [command, &["--set", "wind.velocity.y=10"]].concat();
        let (told, json) = warnings(&wing(STRIPS, FRONT, 2.0), &behind);
        assert!(told.contains("warning: the wind meets the surface of wing from behind, at 17"), "{behind:?}: {told}");
        let found = if command[0] == "flutter" { &json["results"][0] } else { &json };
        let listed = found["warnings"].as_array().unwrap_or_else(|| panic!("{json}"));
        assert!(
            listed[0]
                .as_str()
                .is_some_and(|warning| warning.starts_with("the wind meets the surface of wing from behind")),
            "{listed:?}"
        );

        let front = [command, &["--set", "wind.velocity.x=0", "--set", "wind.velocity.y=-10"]].concat();
        let (told, json) = warnings(&wing(STRIPS, SPAN, 2.0), &front);
        assert!(!told.contains("the wind meets"), "{front:?}: {told}");
        let found = if command[0] == "flutter" { &json["results"][0] } else { &json };
        assert_eq!(found["warnings"].as_array().map(Vec::len), Some(0), "{json}");
    }
}

/// A spanwise wind in the file: every command prints the warning; for a wind from the front none does. The lag states of strips are neutral
/// without flow in the plane of the section: `static` used to report the wing as unstable by 1e-15 1/s.
#[test]
fn a_wind_along_the_span_has_a_warning() {
    for command in [&["check"][..], &["static"], &FLUTTER] {
        let (told, _) = warnings(&wing(STRIPS, SPAN, 2.0), command);
        assert!(told.contains(ALONG), "{command:?}: {told}");
        let (told, _) = warnings(&wing(STRIPS, FRONT, 2.0), command);
        assert!(!told.contains("the wind meets"), "{command:?}: {told}");
    }
}

/// A lattice without suction at incidence: there is a warning for thrust and drag. At zero incidence, with suction and with strips there is
/// none.
#[test]
fn a_lattice_without_suction_at_incidence_has_a_warning() {
    let with_suction = format!("{LATTICE}\nleading_edge_suction = true");
    for command in ["check", "static"] {
        let of = |air: &str, incidence_deg: f64| warnings(&wing(air, FRONT, incidence_deg), &[command]).0;
        assert!(of(LATTICE, 3.0).contains(SUCTION), "{command}");
        for (air, incidence_deg) in [(LATTICE, 0.0), (&with_suction, 3.0), (STRIPS, 3.0)] {
            let told = of(air, incidence_deg);
            assert!(!told.contains("suction"), "{command}, {air}, {incidence_deg} deg: {told}");
        }
    }
    // a trim balances forces: it warns for every lattice without suction, in text and JSON
    for (air, expected) in [(LATTICE, true), (&with_suction, false), (STRIPS, false)] {
        let trim = ["trim", "--solve-for", "wind.velocity.z", "--target", "root.force.z=1", "--json"];
        let (told, json) = warnings(&wing(air, FRONT, 0.0), &trim);
        assert_eq!(told.contains(SUCTION), expected, "{air}: {told}");
        let listed = json["warnings"].as_array().unwrap_or_else(|| panic!("{json}"));
        assert_eq!(
            listed.iter().any(|warning| warning.as_str().is_some_and(|warning| warning.contains("suction"))),
            expected
        );
    }
}

const TIP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/flared_wing_tip.toml");

/// A latch that closes at a speed: the free tip folds up with increasing speed until the latch holds it. One that opens: the weight holds
/// the tip at a latch until the lift raises it. The change is where the tip without a latch passes the angle, within a 256th of the
/// interval: 0.03 m/s, in which the tip rotates by up to 0.03 deg. The search for the equilibrium used to pass the latch with loads of
/// other states, and found the tip latched at all speeds up to 21 m/s.
#[test]
fn latches_close_and_open_between_speeds() {
    let text = std::fs::read_to_string(TIP).unwrap();
    let place = "[aerodynamics]";
    assert!(text.contains(place));
    for (angle_deg, event, speeds, end_m_s) in [(-8.5, "closes", "12:36:4", 36.0), (0.0, "opens", "9:33:4", 33.0)] {
        let latch = format!("[joint.fold.latch]\nkind = \"rigid\"\nangle_deg = {angle_deg:?}\n\n{place}");
        let latched = text.replacen(place, &latch, 1);
        let (told, json) = warnings(&latched, &["flutter", "--wind-m-s", speeds, "--count=4", "--json"]);
        assert_eq!(told, "", "{event}");
        let found = &json["results"][0];
        let changes = found["changes"].as_array().unwrap();
        let latches: Vec<_> = changes.iter().filter(|change| change["kind"] == "latch").collect();
        assert_eq!(latches.len(), 1, "{event}: {found}");
        let told = latches[0]["text"].as_str().unwrap();
        assert!(told.contains(&format!("the latch of fold {event}")), "{told}");
        assert_eq!(found["covered_m_s"][1], end_m_s, "{found}");
        let [low, high] = [0, 1].map(|end| latches[0]["between_m_s"][end].as_f64().unwrap());
        assert!(high - low <= 8.0 / 256.0 + 1e-9 && high > low, "{low} to {high}");
        let wind = format!("wind.velocity.y={}", -0.5 * (low + high));
        let (_, free) = warnings(&text, &["static", "--set", &wind, "--json"]);
        let free_deg = free["joints"][0]["angle_rad"].as_f64().unwrap().to_degrees();
        assert!((free_deg - angle_deg).abs() < 0.05, "{event}: the free tip is at {free_deg} deg");
    }
}

/// In still air and in the wind, a latch on the far side of the start does not hold the tip away from its equilibrium: exit code, angle and
/// torque equal those of the machine without the latch.
#[test]
fn a_latch_that_the_equilibrium_does_not_reach_stays_open() {
    let text = std::fs::read_to_string(TIP).unwrap();
    for kind in ["kind = \"rigid\"", "stiffness_N_m_rad = 500.0"] {
        let latch = format!("[joint.fold.latch]\n{kind}\nangle_deg = -10.0\n\n[aerodynamics]");
        let latched = text.replacen("[aerodynamics]", &latch, 1);
        for speed_m_s in [10, 16, 21] {
            let wind = format!("wind.velocity.y=-{speed_m_s}");
            let of = |text: &str| warnings(text, &["static", "--set", &wind, "--json"]).1["joints"][0].clone();
            let (found, free) = (of(&latched), of(&text));
            assert_eq!(found["latched"], false, "{kind}, {speed_m_s} m/s: {found}");
            let [found, free] = [found, free].map(|joint| joint["angle_rad"].as_f64().unwrap());
            // the accuracy of a hinge angle in equilibrium
            assert!((found - free).abs() < 1e-7, "{kind}, {speed_m_s} m/s: {found} instead of {free}");
        }
    }
}

/// A pendulum that hangs down at 90 deg.
fn pendulum(start_deg: f64, parts: &str) -> String {
    format!(
        r#"
name = "Pendulum"
gravity_m_s2 = [0.0, 0.0, -9.81]

[rigid_body.arm]
mass_kg = 1.0
inertia_kg_m2 = [0.01, 0.1, 0.1, 0.0, 0.0, 0.0]
centre_of_mass_m = [0.3, 0.0, 0.0]

[joint.hinge]
type = "revolute"
parent = "root"
child = "arm"
axis = [0.0, 1.0, 0.0]
start_angle_deg = {start_deg:?}
motor = {{ damping_N_m_s_rad = 0.1 }}
{parts}
"#
    )
}

/// Equilibria with joints at unintended angles used to give no warning: a latch that stays open, for example with a start angle of 0 away
/// from the latch, and a hinge that has rotated by more than is physically possible. Trim has the warnings of `static`. There is none for a
/// latch that cannot close, a locked joint, or a hinge with end stops.
#[test]
fn joints_that_are_elsewhere_have_a_warning() {
    let latch = "latch = { angle_deg = 120.0, kind = \"rigid\" }";
    let open = "warning: the latch of joint hinge at 120 deg is open in this equilibrium; motor, spring and loads alone hold the joint at 90 deg";
    let trim = ["trim", "--solve-for", "hinge.external_torque", "--target", "hinge.angle=1.5707963", "--json"];
    for command in [&["static", "--json"][..], &trim] {
        let (told, json) = warnings(&pendulum(20.0, latch), command);
        assert!(told.contains(open) && told.contains("with hinge.start_angle = 2.094 rad it is closed"), "{told}");
        assert_eq!(json["warnings"].as_array().map(Vec::len), Some(1), "{json}");
    }
    // a failed trim reports the joint angles of its last equilibrium
    let without = ["trim", "--solve-for", "gravity.y", "--target", "root.force.x=1"];
    let (text, code) = failing(&pendulum(20.0, latch), &without);
    let place = "last equilibrium: the latch of joint hinge at 120 deg is open in this equilibrium";
    assert!(code == 3 && text.contains("error: no trim:") && text.contains(place), "{code}: {text}");
    for setting in ["hinge.release=0", "hinge.latch_enable=0", "hinge.start_angle=2.0943951023931953"] {
        let (told, _) = warnings(&pendulum(20.0, latch), &["static", "--set", setting]);
        assert!(!told.contains("warning"), "{setting}: {told}");
    }
    let turned = "warning: hinge rotates by 260 deg from its start angle to this equilibrium";
    assert!(warnings(&pendulum(-170.0, ""), &["static"]).0.contains(turned));
    for (start_deg, parts) in
        [(-80.0, ""), (-170.0, "end_stops = { lower_deg = -300.0, upper_deg = 100.0, stiffness_N_m_rad = 100.0 }")]
    {
        let (told, _) = warnings(&pendulum(start_deg, parts), &["static"]);
        assert!(!told.contains("rotates by"), "{start_deg} deg, {parts}: {told}");
    }
}

/// Two halves with 30° of dihedral, the axis at the quarter chord: their inner edges part by `1.5 sin 30° sin α` chords. Beyond 0.1 they are
/// not joined, and nothing said so.
#[test]
fn halves_that_are_not_joined_have_a_warning() {
    let halves = |air: &str, incidence_deg: f64| {
        let text = wing(air, FRONT, incidence_deg)
            .replace("child = \"wing\"", "child = \"wing\"\nmount_rotation_deg = [0.0, -30.0, 0.0]");
        let (sine, cosine) = 15f64.to_radians().sin_cos();
        format!(
            "{text}\n[body.left]\nlength_m = 0.6\nsection = \"plate\"\nelements = 2\n\n[joint.left]\ntype = \"clamped\"\nparent = \"root\"\n\
             child = \"left\"\nmount_rotation_deg = [{:?}, 0.0, {:?}]\n\n[surface.left]\nbody = \"left\"\nchord_m = 0.1\n\
             elastic_axis_fraction = 0.25\nstrips = 4\nleading_edge = \"-y\"\nincidence_deg = {incidence_deg}\n",
            180.0 * sine,
            180.0 * cosine
        )
    };
    let line = format!("{STRIPS}\ntip_loss = \"lifting_line\"");
    for air in [LATTICE, &line] {
        let (told, _) = warnings(&halves(air, 12.0), &["check"]);
        let expected = "warning: the inner edges of the surfaces of wing and left are attached to one point but lie 0.1559 chords apart";
        assert_eq!(told.matches("inner edges").count(), 1, "{air}: {told}");
        assert!(told.contains(expected), "{air}: {told}");
    }
    for (air, incidence_deg) in [(LATTICE, 7.0), (&line, 7.0), (STRIPS, 12.0)] {
        let (told, _) = warnings(&halves(air, incidence_deg), &["check"]);
        assert!(!told.contains("inner edges"), "{air}, {incidence_deg} deg: {told}");
    }
}
