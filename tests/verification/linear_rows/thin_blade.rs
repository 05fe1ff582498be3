//! Rows of a beam with shear and little rotary inertia, about a motion.

use super::Rows;
use super::compare::linear_rows_agree_at;
use foldwing::config;
use foldwing::plant::Plant;
use std::sync::Arc;

/// A thin blade with shear in the wind, released from its undeformed state: its sections accelerate by thousands of m/s².
const BLADE: &str = r#"
name = "ThinBlade"

[section.s0]
shape = "ellipse"
width_m = 0.077
height_m = 0.0034
density_kg_m3 = 1100.0
youngs_modulus_Pa = 4400000000.0
poisson_ratio = 0.3

[body.b0]
length_m = 0.5
section = "s0"
elements = 2
stiffness_damping_s = 0.00013
shear = true

[joint.j0]
type = "revolute"
parent = "root"
root_position_m = [0.014, 0.066, 0.27]
child = "b0"
mount_rotation_deg = [0.0, 0.0, 0.0]
axis = [0.222, 1.0, 0.285]

[surface.b0]
body = "b0"
strips = 3
chord_m = { polynomial = [0.14, -0.040000000000000036] }

[aerodynamics]
model = "strip"
wind_m_s = [-0.79, 5.7, -0.88]

[failure.x0]
kind = "motor_jam"
joint = "j0"
at_time_s = 0.016

[simulation]
step_s = 0.002

[solver]
tolerance = 1e-9
"#;

/// LR-16. Derivatives of loads with respect to strains and wind for a blade with shear, 16 ms after its release. Central differences of the
/// sections' accelerations with respect to accelerations of the coordinates used to be taken about the current accelerations, and lost
/// digits because these are large; the inverse of the mass matrix, whose smallest entries are the rotary inertias of the thin sections,
/// amplified the loss.
#[test]
fn lr16_loads_of_a_blade_with_shear_keep_their_digits() {
    let machine = config::parse(BLADE, "thin_blade.toml").unwrap_or_else(|error| panic!("{error}"));
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    for step in 1..=8 {
        plant.step(2e-3 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
    }
    match linear_rows_agree_at(&mut plant) {
        Rows::Agree(off) => {
            println!("LR-16: off by at most {off:.1e} of a row's scale");
            // round-off of the reference
            assert!(off < 1e-8, "{off:.1e}");
        }
        Rows::Miss(why) | Rows::Refused(why) => panic!("{why}"),
    }
}
