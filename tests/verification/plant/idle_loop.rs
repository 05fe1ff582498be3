//! Rigid loops that restrain nothing, and the refusal of gradients.

use foldwing::config;
use foldwing::plant::{GradientError, Plant};
use std::sync::Arc;

fn plant(text: &str) -> Plant {
    Plant::new(Arc::new(config::parse(text, "pendulum.toml").unwrap_or_else(|error| panic!("{error}"))))
}

/// A pendulum of two rigid bars; `of_loop` closes a loop between the bars.
fn pendulum(of_loop: &str) -> Plant {
    let text = format!(
        r#"
name = "Pendulum"
gravity_m_s2 = [0.3, 0.2, -9.8]

[rigid_body.upper]
mass_kg = 1.3
centre_of_mass_m = [0.31, 0.02, -0.01]
inertia_kg_m2 = [0.01, 0.02, 0.03, 0.0, 0.0, 0.0]

[rigid_body.lower]
mass_kg = 0.7
centre_of_mass_m = [0.17, 0.0, 0.03]
inertia_kg_m2 = [0.004, 0.01, 0.012, 0.0, 0.0, 0.0]

[joint.first]
type = "revolute"
parent = "root"
child = "upper"
axis = [0.3, 1.0, 0.2]
motor.stiffness_N_m_rad = 20.0

[joint.second]
type = "revolute"
parent = "upper"
child = "lower"
parent_offset_m = [0.7, 0.1, 0.0]
axis = [0.0, 0.6, 0.8]
motor.stiffness_N_m_rad = 5.0
{of_loop}
[solver]
tolerance = 1e-9

[simulation]
stop_time_s = 1.0
step_s = 1e-2
"#
    );
    let mut plant = plant(&text);
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Both points on the axis of the second hinge, 0.25 m beside it.
const ON_AXIS: &str =
    "\n[loop.idle]\nbodies = [\"upper\", \"lower\"]\noffsets_m = [[0.7, 0.25, 0.2], [0.0, 0.15, 0.2]]\nrigid = true\n";

/// LP-40. A loop between two points of the axis of a hinge restrains nothing, and all of its rows are redundant: their matrix is round-off.
/// It carries no force and does not change the motion.
#[test]
fn lp40_a_loop_without_a_freedom_carries_nothing() {
    let (mut with, mut without) = (pendulum(ON_AXIS), pendulum(""));
    let (mut apart, mut force_n, mut gap_m) = (0.0f64, 0.0f64, 0.0f64);
    for step in 1..=100 {
        let time_s = 1e-2 * f64::from(step);
        for plant in [&mut with, &mut without] {
            plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        }
        for (a, b) in with.outputs().joints().iter().zip(without.outputs().joints()) {
            apart = apart.max((a.angle_rad - b.angle_rad).abs()).max((a.rate_rad_s - b.rate_rad_s).abs());
        }
        let idle = with.outputs().loops()[0];
        (force_n, gap_m) = (force_n.max(idle.force_n.norm()), gap_m.max(idle.gap_m.norm()));
    }
    println!("LP-40 apart {apart:.1e}, force {force_n:.1e} N, gap {gap_m:.1e} m");
    // the steps are those of the same error to the tolerance
    assert!(apart < 1e-7 && force_n < 1e-12 && gap_m < 1e-14, "{apart:.1e} {force_n:.1e} N {gap_m:.1e} m");
}

/// LP-39. The gradient of a run is refused with the name of the loop; without the loop it exists.
#[test]
fn lp39_gradients_refuse_rigid_loops() {
    match pendulum(ON_AXIS).run_on_tape(&[0.01]) {
        Err(GradientError::NotCovered { part: "rigid loops", place }) => assert_eq!(place, "idle"),
        other => panic!("{:?}", other.map(|_| ()).map_err(|error| error.to_string())),
    }
    pendulum("").run_on_tape(&[0.01]).unwrap_or_else(|error| panic!("{error}"));
}
