//! Universal, ball and free joints in the table.

use super::machine;
use crate::interface::Interface;
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{JointKind, SpatialFreedom};

/// Every type of joint, each outboard of one that rotates or starts at an angle, and a floating branch.
pub(super) const SPATIAL: &str = r#"
name = "Spatial"
gravity_m_s2 = [0.3, -0.4, -9.81]
[section.plate]
shape = "rectangle"
width_m = 0.05
height_m = 0.004
density_kg_m3 = 1400
youngs_modulus_Pa = 3e9
poisson_ratio = 0.3
[body]
a = { length_m = 0.2, section = "plate", elements = 1, load_stations = 1 }
b = { length_m = 0.15, section = "plate", elements = 1, load_stations = 1 }
c = { length_m = 0.1, section = "plate", elements = 1, load_stations = 1 }
d = { length_m = 0.2, section = "plate", elements = 1, load_stations = 1 }
e = { length_m = 0.15, section = "plate", elements = 1, load_stations = 1 }
f = { length_m = 0.15, section = "plate", elements = 1, load_stations = 1 }
[joint.hinge]
type = "revolute"
parent = "root"
child = "a"
axis = [0.1, 1, 0.3]
start_angle_deg = 20
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.cross]
type = "universal"
parent = "a"
child = "b"
axis = [0.2, 1, 0.1]
body_axis = [0.1, -0.2, 1]
mount_rotation_deg = [10, 20, 30]
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.ball]
type = "ball"
parent = "b"
child = "c"
mount_rotation_deg = [-10, 40, 30]
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.flight]
type = "free"
parent = "root"
child = "d"
root_position_m = [0, 1, 0]
mount_rotation_deg = [30, 10, -20]
[joint.flap]
type = "revolute"
parent = "d"
child = "e"
axis = [0.2, 1, 0.3]
start_angle_deg = 30
motor = { stiffness_N_m_rad = 0.1, damping_N_m_s_rad = 0.01 }
[joint.tail]
type = "ball"
parent = "e"
child = "f"
mount_rotation_deg = [0, 20, 10]
[mass] # not damped: without them, the damping of a body that turns about its own joint only slows it down
c = { body = "c", position_m = 0.07, mass_kg = 0.02, offset_m = [0, 0.02, 0] }
f = { body = "f", position_m = 0.1, mass_kg = 0.02, offset_m = [0, 0.02, 0] }
[gauge]
c = { body = "c", position_m = 0.02, y_m = 0.01 }
e = { body = "e", position_m = 0.02, y_m = 0.01 }
"#;

/// The model with every type of joint; the named ones rotate at the start, `drift` gives the free body a velocity.
pub(super) fn with_spins(names: &[&str]) -> Machine {
    let mut machine = machine(SPATIAL);
    for body in &mut machine.bodies {
        let JointKind::Spatial(joint) = &mut body.joint.kind else { continue };
        if names.contains(&body.joint.name.as_str()) {
            joint.start_angular_velocity_rad_s = match joint.freedom {
                SpatialFreedom::Universal { parent_axis, body_axis } => {
                    parent_axis * 0.8 + body.joint.mount * body_axis * 0.5
                }
                SpatialFreedom::Ball | SpatialFreedom::Free => nalgebra::Vector3::new(0.9, -0.6, 1.3),
            };
        }
        if joint.freedom == SpatialFreedom::Free && names.contains(&"drift") {
            joint.start_velocity_m_s = nalgebra::Vector3::new(3.0, 1.0, -0.5);
        }
    }
    machine
}

#[test]
fn joints_of_several_degrees_of_freedom_have_the_promised_names() {
    let interface = Interface::new(&machine(SPATIAL));
    for joint in ["cross", "ball", "tail", "flight"] {
        let free = joint == "flight";
        for name in "rotation.w rotation.x rotation.y rotation.z angular_velocity.x angular_velocity.z".split(' ') {
            assert!(interface.find(&format!("{joint}.{name}")).is_some(), "{joint}.{name} is missing");
        }
        // a free joint has no spring and no reaction
        for name in "reaction_force.x reaction_force.z reaction_moment.y stiffness damping".split(' ') {
            assert_eq!(interface.find(&format!("{joint}.{name}")).is_none(), free, "{joint}.{name}");
        }
    }
}
