//! Machines with several aerodynamic models: LR-17 to LR-19.

use super::compare::{Rows, linear_rows_agree_at};
use crate::rotor::several::{PROPELLERS, TWIN, machine, started};
use crate::slender::machines::GLIDER;
use foldwing::plant::{Holding, Plant};
use nalgebra::Vector3;
use std::sync::Arc;

/// Text with parts replaced, each of which it has.
fn replaced(text: &str, parts: &[(&str, &str)]) -> String {
    parts.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

fn turn_root(plant: &mut Plant) {
    let root = plant.inputs_mut().root_mut();
    root.angular_velocity_rad_s = Vector3::new(0.2, -0.3, 0.4);
    root.acceleration_m_s2 = Vector3::new(1.0, 2.0, -0.5);
}

fn agree(name: &str, plant: &mut Plant) {
    let rows = linear_rows_agree_at(plant);
    println!("{name}: {rows:?}");
    assert!(matches!(rows, Rows::Agree(_)), "{name}: {rows:?}");
}

/// The glider at rest in steady flight, held by loads on its fuselage that balance the rest.
fn balanced() -> Plant {
    let mut plant = Plant::new(Arc::new(machine(GLIDER)));
    for _ in 0..6 {
        let held = plant.study().rest_held_in_flight(0.0).unwrap_or_else(|error| panic!("{error}"))[0];
        let arm_m = plant.outputs().stations()[0].position_m;
        let load = &mut plant.inputs_mut().stations_mut()[0];
        load.force_n += held.force_n;
        load.moment_n_m += held.moment_n_m - arm_m.cross(&held.force_n);
    }
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// A wing on strips that flaps on a pod that pitches, with a slender body that has an open end and drag.
const POD: &str = r#"
name = "Pod"
[rigid_body.pod]
mass_kg = 5.0
inertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
[joint.pitch]
type = "revolute"
parent = "root"
child = "pod"
axis = [0.0, 1.0, 0.3]
start_angle_deg = 4.0
start_rate_deg_s = 30.0
motor.stiffness_N_m_rad = 400.0
[section.spar]
shape = "rectangle"
width_m = 0.2
height_m = 0.02
density_kg_m3 = 500.0
youngs_modulus_Pa = 3e10
shear_modulus_Pa = 6e9
[body.wing]
section = "spar"
length_m = 2.0
elements = 1
load_stations = 0
[joint.flap]
type = "revolute"
parent = "pod"
parent_offset_m = [0.1, 0.0, 0.0]
child = "wing"
axis = [1.0, 0.0, 0.0]
mount_rotation_deg = [0.0, 0.0, 90.0]
motor.stiffness_N_m_rad = 200.0
[surface.wing]
body = "wing"
chord_m = 0.5
elastic_axis_fraction = 0.25
leading_edge = "+y"
strips = 2
[aerodynamics]
wind_m_s = [15.0, 0.5, 1.0]
step_s = 0.002
[aerodynamics.surfaces]
model = "strip"
[aerodynamics.pod]
model = "slender_body"
body = "pod"
radius_m = [[-0.8, 0.0], [-0.3, 0.15], [0.6, 0.12], [1.2, 0.05]]
segments = 3
cross_flow_drag_coefficient = 1.0
axial_drag_coefficient = 0.1
[gust.side]
shape = "one_minus_cosine"
velocity_m_s = [0.0, 1.5, 1.0]
direction = [1.0, 0.0, 0.0]
length_m = 12.0
start_s = -0.2
[solver]
tolerance = 1e-9
"#;

/// LR-17. Strips with a slender body, moving, in a gust and on a root that turns.
#[test]
fn lr17_wing_with_fuselage() {
    let mut plant = started(POD);
    plant.step(0.011).unwrap_or_else(|error| panic!("{error}"));
    turn_root(&mut plant);
    agree("LR-17", &mut plant);
}

/// LR-17. The glider in steady flight, and in a wind tunnel on a hinge and in a gust, moving, also on a root that turns.
#[test]
#[ignore = "minutes; `make validate` runs it"]
fn lr17_the_glider() {
    agree("LR-17 in flight", &mut balanced());
    let tunnel = replaced(
        GLIDER,
        &[
            (
                "type = \"free\"\n",
                "type = \"revolute\"\naxis = [0.2, 1.0, 0.3]\nstart_angle_deg = 3.0\nstart_rate_deg_s = 25.0\n\
                 motor.stiffness_N_m_rad = 60.0\nmotor.damping_N_m_s_rad = 0.5\n",
            ),
            ("start_s = 0.2", "start_s = -0.3"),
            ("[simulation]", "[solver]\ntolerance = 1e-9\n[simulation]"),
        ],
    );
    let mut plant = started(&tunnel);
    plant.step(0.011).unwrap_or_else(|error| panic!("{error}"));
    agree("LR-17 in a tunnel", &mut plant);
    turn_root(&mut plant);
    agree("LR-17 on a root that turns", &mut plant);
}

/// LR-18. Two rotors on a tower, one with dynamic inflow and dynamic stall, the other without lags: moving, with shear and tower bending.
#[test]
fn lr18_two_rotors_on_a_tower() {
    let symmetric = "\"symmetric\", \"symmetric\", \"symmetric\"";
    let text = replaced(
        TWIN,
        &[
            ("stations_m = [0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.6, 5.1, 5.4]", "stations_m = [0.0, 2.4, 5.4]"),
            (&format!("[{symmetric}, {symmetric}, {symmetric}]"), &format!("[{symmetric}]")),
            ("count = 3\n", ""),
            ("hub_radius_m = 0.6\n", "hub_radius_m = 0.6\nblades = 3\n"),
            ("elements = 2", "elements = 1"),
            ("stiffness_damping_s", "load_stations = 0\nstiffness_damping_s"),
            ("blades = 3\ndynamic_inflow = true\n\n", "blades = 3\n\n"),
            ("dynamic_inflow = true", "dynamic_inflow = true\ndynamic_stall = true\nskewed_wake = true"),
            ("[simulation]", "[solver]\ntolerance = 1e-8\n[simulation]"),
        ],
    );
    let mut plant = started(&text);
    plant.step(0.033).unwrap_or_else(|error| panic!("{error}"));
    agree("LR-18", &mut plant);
}

/// LR-19. Strips with two rotors, whose states are beside those of the strips: the wing with propellers, moving.
#[test]
fn lr19_wing_with_propellers() {
    let symmetric = "\"symmetric\", \"symmetric\", \"symmetric\"";
    let text = replaced(
        PROPELLERS,
        &[
            ("stations_m = [0.0, 0.08, 0.18, 0.28, 0.38, 0.44, 0.48]", "stations_m = [0.0, 0.28, 0.48]"),
            (&format!("[{symmetric}, {symmetric}, \"symmetric\"]"), &format!("[{symmetric}]")),
            ("elements = 3", "elements = 1"),
            ("strips = 8", "strips = 2"),
            ("load_stations = 4", "load_stations = 1"),
            ("hub = \"left_hub\"", "hub = \"left_hub\"\ndynamic_stall = true"),
            ("[simulation]", "[solver]\ntolerance = 1e-8\n[simulation]"),
        ],
    );
    let mut plant = started(&text);
    plant.step(0.0217).unwrap_or_else(|error| panic!("{error}"));
    agree("LR-19", &mut plant);
}
