//! Degrees: every key that ends in `_deg` or `_deg_s`, read from one file and compared with radians.

use foldwing::config::{parse, schema};
use foldwing::force::prescribed::Motion;
use foldwing::machine::{AirOptions, Effect, JointKind, JointMotion, Machine, SectionLaw};
use std::collections::BTreeSet;

/// A machine with every angle that a file can contain.
const MODEL: &str = r#"name = "Angles"
[section.s]
shape = "rectangle"
width_m = 0.05
height_m = 0.002
density_kg_m3 = 1425.0
youngs_modulus_Pa = 2.83e9
poisson_ratio = 0.3
[body]
a = { length_m = 0.1, section = "s", elements = 1 }
b = { length_m = 0.1, section = "s", elements = 1 }
c = { length_m = 0.1, section = "s", elements = 1 }
d = { length_m = 0.1, section = "s", elements = 1 }
[joint.mount]
type = "clamped"
parent = "root"
child = "a"
mount_rotation_deg = [90, 0, 0]
[joint.fold]
type = "revolute"
parent = "a"
child = "b"
axis = [0, 1, 0]
start_angle_deg = 60
start_rate_deg_s = 45
[joint.fold.motor]
stiffness_N_m_rad = 0.02
rate_limit_deg_s = 180
command_deg = 30
[joint.fold.spring]
stiffness_N_m_rad = 0.01
rest_angle_deg = 25
[joint.fold.latch]
angle_deg = -20
capture_deg = 2
stiffness_N_m_rad = 10
[joint.fold.end_stops]
lower_deg = -25
upper_deg = 65
stiffness_N_m_rad = 5
[joint.turn]
type = "revolute"
parent = "b"
child = "c"
axis = [0, 1, 0]
motion = "prescribed"
polynomial_deg = [10, 20, 30]
[joint.sway]
type = "revolute"
parent = "root"
root_position_m = [0, 1, 0]
child = "d"
axis = [0, 1, 0]
motion = "prescribed"
table_s_deg = [[0, 15], [1, 75]]
"#;

/// A ball joint, and a body with aerodynamics.
const BALL_IN_AIR: &str = r#"name = "Ball"
[section.s]
shape = "rectangle"
width_m = 0.05
height_m = 0.002
density_kg_m3 = 1425.0
youngs_modulus_Pa = 2.83e9
poisson_ratio = 0.3
[body.a]
length_m = 0.1
section = "s"
elements = 1
[joint.neck]
type = "ball"
parent = "root"
child = "a"
start_angular_velocity_deg_s = [90, -45, 30]
[aerodynamics]
model = "strip"
density_kg_m3 = 1.2
wind_m_s = [0, -10, 0]
step_s = 1e-3
[surface.plate]
body = "a"
chord_m = 0.05
elastic_axis_fraction = 0.25
leading_edge = "+y"
strips = 1
incidence_deg = 30
flare_deg = 20
zero_lift_angle_deg = -3
"#;

/// A modal body.
const MODAL: &str = r#"name = "Blade"
[modal_body.blade]
length_m = 10.0
nodes = 5
stations = [0, 1]
mass_kg_m = [10, 10]
flap_stiffness_N_m2 = [1e6, 1e6]
edge_stiffness_N_m2 = [2e6, 2e6]
twist_deg = [12, -3]
flap_shapes = [[1.0]]
[joint.mount]
type = "clamped"
parent = "root"
child = "blade"
"#;

/// Failures triggered by angles and rates.
const FAILING: &str = r#"
[failure.away]
kind = "motor_runaway"
joint = "fold"
to_deg = 75
rate_deg_s = 15
when = { joint = "fold", angle_above_deg = 90 }
[failure.back]
kind = "motor_loss"
joint = "fold"
when = { joint = "fold", angle_below_deg = -30 }
[failure.brake]
kind = "brake_applied"
joint = "fold"
torque_N_m = 1.0
slip_deg_s = 0.5
when = { joint = "fold", rate_above_deg_s = 120 }
[failure.slow]
kind = "motor_loss"
joint = "fold"
when = { joint = "fold", rate_below_deg_s = -60 }
"#;

/// A strip of two plies.
const LAMINATE: &str = r#"name = "Strip"
[section.plate]
shape = "laminate"
width_m = 0.03
layup_deg = [90, 90]
ply_thickness_m = 1e-3
material = "CFRP AS4/3501-6"
[body.beam]
length_m = 1.0
section = "plate"
elements = 2
[joint.mount]
type = "clamped"
parent = "root"
child = "beam"
"#;

/// A polar that includes stall.
const STALLED: &str = include_str!("../../examples/failures/pitch_link_in_wind.toml");

fn read(text: &str) -> Machine {
    parse(text, "angles.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts that a value equals one given in degrees, to the last bits.
fn close(what: &str, found: f64, degrees: f64) {
    let expected = degrees * std::f64::consts::PI / 180.0;
    assert!((found - expected).abs() <= 1e-15 * expected.abs().max(1.0), "{what}: {found}, not {expected}");
}

/// Keys of the schema with a unit of degrees.
fn keys_in_degrees(node: &serde_json::Value, found: &mut BTreeSet<String>) {
    if let Some(map) = node["properties"].as_object() {
        found.extend(map.keys().filter(|key| key.ends_with("_deg") || key.ends_with("_deg_s")).cloned());
    }
    match node {
        serde_json::Value::Object(map) => map.values().for_each(|value| keys_in_degrees(value, found)),
        serde_json::Value::Array(items) => items.iter().for_each(|value| keys_in_degrees(value, found)),
        _ => {}
    }
}

/// Every key in degrees occurs in the files above.
#[test]
fn every_key_in_degrees_is_compared() {
    let mut keys = BTreeSet::new();
    keys_in_degrees(&serde_json::from_str(&schema()).expect("JSON"), &mut keys);
    assert!(keys.len() >= 12, "{keys:?}");
    for key in &keys {
        assert!(
            [MODEL, BALL_IN_AIR, MODAL, FAILING, STALLED, LAMINATE]
                .iter()
                .any(|text| text.contains(&format!("{key} = "))),
            "{key} is not compared"
        );
    }
}

/// For plies at 90 degrees, the modulus along the body is that normal to their fibres; for those at 60 degrees that of the textbook's
/// transformation.
#[test]
fn plies_are_read_in_radians() {
    let stiffness_pa = |text: &str| read(text).bodies[0].section.at(0.0).stiffness[(0, 0)] / (0.03 * 2e-3);
    assert!((stiffness_pa(LAMINATE) / 10.3e9 - 1.0).abs() < 1e-12);
    // balanced: E1, E2, Poisson's ratio and G by the invariants of the reduced stiffness
    let scale = 1.0 / (1.0 - 0.27 * 0.27 * 10.3 / 147.0);
    let (q11, q22, q12, q66) = (147.0 * scale, 10.3 * scale, 0.27 * 10.3 * scale, 7.0);
    let (c, s) = (0.25, 0.75); // squares of cosine and sine
    let along = q11 * c * c + 2.0 * (q12 + 2.0 * q66) * c * s + q22 * s * s;
    let across = q11 * s * s + 2.0 * (q12 + 2.0 * q66) * c * s + q22 * c * c;
    let mixed = (q11 + q22 - 4.0 * q66) * c * s + q12 * (c * c + s * s);
    let balanced = LAMINATE.replace("[90, 90]", "[60, -60]\nsymmetric = true").replace("1e-3", "0.5e-3");
    assert!((stiffness_pa(&balanced) / (1e9 * (along - mixed * mixed / across)) - 1.0).abs() < 1e-12);
}

/// The kink of the moment is at this angle beyond the stall at 12 degrees: there is a row.
#[test]
fn angle_of_the_pressure_shift_is_read_in_radians() {
    let machine = read(STALLED);
    let Some(AirOptions::Rotor(rotor)) = machine.air.as_ref().map(|air| &air.parts[0].options) else {
        panic!("a rotor")
    };
    let beyond = rotor.polars[0].rows.iter().map(|row| row.angle_rad);
    let nearest = beyond.min_by(|a, b| (a - 22f64.to_radians()).abs().total_cmp(&(b - 22f64.to_radians()).abs()));
    close("pressure_shift_deg", nearest.expect("rows"), 22.0);
}

#[test]
fn angles_are_read_in_radians() {
    let machine = read(MODEL);
    let body = |name: &str| machine.bodies.iter().find(|body| body.name == name).expect("a body");
    let turned = body("a").joint.mount * nalgebra::Vector3::y();
    assert!((turned - nalgebra::Vector3::z()).norm() < 1e-15, "mount_rotation_deg turns y to {turned}");
    let JointKind::Revolute(fold) = &body("b").joint.kind else { panic!("a hinge") };
    close("start_angle_deg", fold.start_angle_rad, 60.0);
    close("start_rate_deg_s", fold.start_rate_rad_s, 45.0);
    close("rate_limit_deg_s", fold.motor.rate_limit_rad_s, 180.0);
    close("command_deg", fold.motor.command_rad, 30.0);
    close("rest_angle_deg", fold.spring.as_ref().expect("a spring").rest_angle_rad, 25.0);
    let latch = fold.latch.as_ref().expect("a latch");
    close("angle_deg", latch.angle_rad, -20.0);
    close("capture_deg", latch.capture_rad, 2.0);
    let stops = fold.end_stops.as_ref().expect("stops");
    close("lower_deg", stops.lower_rad.expect("an end"), -25.0);
    close("upper_deg", stops.upper_rad.expect("an end"), 65.0);
    let motion = |name: &str| match &body(name).joint.kind {
        JointKind::Revolute(revolute) => match &revolute.motion {
            JointMotion::Prescribed(motion) => motion.clone(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    };
    let Motion::Polynomial(coefficients) = motion("c") else { panic!("a polynomial") };
    [10.0, 20.0, 30.0].iter().zip(coefficients).for_each(|(deg, found)| close("polynomial_deg", found, *deg));
    let Motion::Table(rows) = motion("d") else { panic!("a table") };
    assert_eq!([rows[0].0, rows[1].0], [0.0, 1.0], "times are no angles");
    [15.0, 75.0].iter().zip(rows).for_each(|(deg, row)| close("table_s_deg", row.1, *deg));
}

#[test]
fn angles_of_a_ball_joint_and_of_air_are_read_in_radians() {
    let machine = read(BALL_IN_AIR);
    let JointKind::Spatial(ball) = &machine.bodies[0].joint.kind else { panic!("a ball joint") };
    let rates = ball.start_angular_velocity_rad_s;
    [90.0, -45.0, 30.0].iter().zip(&rates).for_each(|(deg, found)| close("start_angular_velocity_deg_s", *found, *deg));
    let surface = &machine.air.as_ref().expect("air").surfaces[0];
    let chord = &surface.chords[0];
    let forward = (chord.leading_m - chord.trailing_m).normalize();
    close("incidence_deg", forward.z.atan2(forward.y), 30.0);
    let lattice = read(&BALL_IN_AIR.replace("\"strip\"", "\"uvlm\"")).air.expect("air");
    let forward = lattice.surfaces[0].chords[0].leading_m - lattice.surfaces[0].chords[0].trailing_m;
    close("flare_deg", forward.x.atan2(forward.y.hypot(forward.z)), 20.0);
    close("zero_lift_angle_deg", surface.profile.zero_lift_angle_rad, -3.0);
}

#[test]
fn twist_of_a_modal_body_is_read_in_radians() {
    let machine = read(MODAL);
    let SectionLaw::Modal(law) = &machine.bodies[0].section else { panic!("a modal body") };
    let twist = law.twist_rad.as_ref().expect("twist");
    let places = [(0.0, 12.0), (5.0, 4.5), (10.0, -3.0)];
    places.iter().for_each(|(place_m, deg)| close("twist_deg", twist.at(*place_m), *deg));
}

#[test]
fn angles_of_failures_are_read_in_radians() {
    let machine = read(&format!("{MODEL}{FAILING}"));
    let Effect::MotorRunaway { to_rad, rate_rad_s, .. } = machine.failures[0].effect else { panic!("runs away") };
    close("to_deg", to_rad, 75.0);
    close("rate_deg_s", rate_rad_s, 15.0);
    let Effect::BrakeApplied { brake, .. } = machine.failures[2].effect else { panic!("a brake") };
    close("slip_deg_s", brake.slip_rad_s, 0.5);
    let bounds = [
        ("angle_above_deg", 90.0),
        ("angle_below_deg", -30.0),
        ("rate_above_deg_s", 120.0),
        ("rate_below_deg_s", -60.0),
    ];
    for ((key, degrees), failure) in bounds.into_iter().zip(&machine.failures) {
        close(key, failure.when.expect("a bound").value, degrees);
    }
}
