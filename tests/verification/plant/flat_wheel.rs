//! Wheels that fall flat and skates with blades along the normal: the error names them.

use foldwing::config;
use foldwing::machine::{Machine, Runner};
use foldwing::plant::{Plant, PlantError};
use nalgebra::{Rotation3, Vector3};
use std::sync::Arc;

fn array(vector: Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", vector.x, vector.y, vector.z)
}

/// A disc without spin that leans by 0.3 rad, in a frame turned by `turn`, behind a skate on the same plane.
fn falling(solver: &str, turn: Rotation3<f64>) -> Machine {
    let (radius_m, lean_rad) = (0.2, 0.3f64);
    let mount = turn * Rotation3::from_axis_angle(&Vector3::x_axis(), -lean_rad);
    let text = format!(
        r#"
name = "FallingDisc"
gravity_m_s2 = {gravity}

[rigid_body.sledge]
mass_kg = 3.0
inertia_kg_m2 = [0.1, 0.1, 0.1, 0.0, 0.0, 0.0]

[rigid_body.disc]
mass_kg = 2.0
inertia_kg_m2 = [0.02, 0.04, 0.02, 0.0, 0.0, 0.0]

[joint.sledge]
type = "free"
parent = "root"
child = "sledge"
root_position_m = {beside}
mount_rotation_deg = {upright}

[joint.disc]
type = "free"
parent = "root"
child = "disc"
root_position_m = {centre}
mount_rotation_deg = {mounted}

[skate.blade]
body = "sledge"
plane_normal = {normal}

[wheel.tyre]
body = "disc"
radius_m = {radius_m}
plane_normal = {normal}

[solver]
{solver}

[simulation]
stop_time_s = 2.0
step_s = 0.01
"#,
        gravity = array(turn * Vector3::new(0.0, 0.0, -9.81)),
        beside = array(turn * Vector3::new(2.0, 1.0, 0.0)),
        upright = array(turn.scaled_axis().map(f64::to_degrees)),
        centre = array(turn * (Vector3::z() * (radius_m * lean_rad.cos()))),
        mounted = array(mount.scaled_axis().map(f64::to_degrees)),
        normal = array(turn * Vector3::z()),
    );
    config::parse(&text, "disc.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// The error of a run, and the time of the last step.
fn failed(machine: Machine) -> PlantError {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let run = (1..=200).map(|index| plant.step(0.01 * f64::from(index)));
    run.into_iter().find_map(Result::err).expect("the disc falls flat")
}

/// WH-15. A disc that falls over ends the run where it lies flat: its contact point has no place. The error names the wheel, not the skate beside
/// it, with the angle of its axis to the normal and the remedy, in any frame and with steps of variable and of fixed size; so does that of a skate whose
/// blade stands along the normal at the start of a machine that was not validated.
#[test]
fn wh15_a_wheel_that_lies_flat_is_named() {
    let turned = Rotation3::from_euler_angles(0.4, -1.1, 2.3);
    for solver in
        ["tolerance = 1e-6", "mode = \"real_time\"\nfixed_step_s = 1e-3", "mode = \"real_time\"\nfixed_step_s = 1e-2"]
    {
        for turn in [Rotation3::identity(), turned] {
            let error = failed(falling(solver, turn));
            let text = error.to_string();
            println!("WH-15 {text}");
            let PlantError::NoHeading { time_s, kind, name, angle_deg, .. } = error else { panic!("{text}") };
            assert!((kind, name.as_str()) == ("wheel", "tyre"), "{text}");
            // a bar of this lean falls within 0.3 to 0.8 s
            assert!((0.3..0.8).contains(&time_s) && angle_deg < 10.0, "{text}");
            assert!(text.contains("lies flat: its axis is at") && text.contains("end_stops"), "{text}");
        }
    }
    let mut standing = falling("tolerance = 1e-6", Rotation3::identity());
    standing.no_slips[0].runner = Runner::Skate { direction: Vector3::z() };
    let error = Plant::new(Arc::new(standing)).initialize(0.0).expect_err("no heading");
    let text = error.to_string();
    assert!(text.contains("the skate \"blade\" stands on its tip: its blade is at 0.00°"), "{text}");
}
