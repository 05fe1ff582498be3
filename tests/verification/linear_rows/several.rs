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

/// LR-17. Strips with a slender body: the glider in steady flight, and in a wind tunnel on a hinge and in a gust, moving.
#[test]
fn lr17_wing_with_fuselage() {
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
    // the root moves too
    let root = plant.inputs_mut().root_mut();
    (root.angular_velocity_rad_s, root.acceleration_m_s2) = (Vector3::new(0.2, -0.3, 0.4), Vector3::new(1.0, 2.0, -0.5));
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
            ("count = 3", "count = 2"),
            ("elements = 2", "elements = 1"),
            ("hub_radius_m = 0.6\ndynamic_inflow = true\n\n", "hub_radius_m = 0.6\n\n"),
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
            ("hub = \"left_hub\"", "hub = \"left_hub\"\ndynamic_stall = true"),
            ("[simulation]", "[solver]\ntolerance = 1e-8\n[simulation]"),
        ],
    );
    let mut plant = started(&text);
    plant.step(0.0217).unwrap_or_else(|error| panic!("{error}"));
    agree("LR-19", &mut plant);
}
