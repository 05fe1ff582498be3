//! A rotor with a locked shaft: the tip speed has a corner at 0.

use foldwing::config;
use foldwing::interface::Interface;
use foldwing::plant::Plant;
use std::sync::Arc;

const ROTOR: &str = r#"
name = "StillShaft"
gravity_m_s2 = [-6.4, -2.8, 0.87]

[rigid_body.hub]
mass_kg = 40.0
inertia_kg_m2 = [3.0, 2.0, 2.0, 0.0, 0.0, 0.0]

[joint.shaft]
type = "revolute"
parent = "root"
child = "hub"
root_position_m = [0.0, 0.0, 12.0]
mount_rotation_deg = [0.0, -5.8, 4.5]
axis = [0.9918033057967827, 0.0783251098965487, 0.10095236386666277]
motion = "locked"

[modal_body.blade]
count = 2
length_m = 4.0
nodes = 8
stations = [0.0, 1.0]
mass_kg_m = [8.0, 3.0]
flap_stiffness_N_m2 = [200000.0, 20000.0]
edge_stiffness_N_m2 = [800000.0, 80000.0]
flap_shapes = [[1.5, -0.5]]
edge_shapes = [[1.5, -0.5]]
flap_damping_ratios = [0.01]
edge_damping_ratios = [0.01]

[joint.pitch]
type = "clamped"
parent = "hub"
parent_offset_m = [0.0, 0.0, 0.5]
child = "blade"
mount_rotation_deg = [127.27922061357856, 0.0, 127.27922061357856]

[aerodynamics]
model = "bem"
hub = "hub"
hub_radius_m = 0.5
wind_m_s = [6.2, -0.18, -0.82]
step_s = 0.01
dynamic_inflow = true
dynamic_stall = true
blades = 4

[surface.blade]
body = "blade"
chord_m = { table = [[0.0, 0.5], [4.0, 0.25]] }
elastic_axis_fraction = 0.32
leading_edge = "+y"
incidence_deg = { table = [[0.0, -15.0], [4.0, -1.0]] }
stations_m = [0.0, 0.8, 2.0, 3.2, 4.0]
polars = ["foil", "foil", "foil", "foil", "foil"]

[polar.foil]
rows = [[-180.0, 0.0, 0.01, 0.0], [-12.0, -0.8, 0.06, 0.0], [0.0, 0.3, 0.01, 0.0], [12.0, 1.28, 0.06, 0.0], [90.0, 0.0, 1.2, 0.0], [180.0, 0.0, 0.01, 0.0]]
"#;

/// LR-13. The tip speed ratio is a magnitude: about a shaft at standstill its derivative is the mean of both sides, 0. Differences over
/// finite steps contained the change of the wind, 2.6e-6 s per rad.
#[test]
fn lr13_tip_speed_ratio_of_a_still_shaft() {
    let machine = config::parse(ROTOR, "still.toml").unwrap_or_else(|error| panic!("{error}"));
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant.step(0.05).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::new(plant.machine());
    let inputs: Vec<_> = interface.real_inputs().filter(|row| row.name.starts_with("root.angular_velocity.")).collect();
    let outputs: Vec<_> = interface.real_outputs().filter(|row| row.name == "rotor.tip_speed_ratio").collect();
    assert_eq!((inputs.len(), outputs.len()), (3, 1));
    let model = interface.linearize(&mut plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}"));
    println!("LR-13: {}", model.matrices.d);
    assert!(model.matrices.d.iter().all(|entry| *entry == 0.0), "{}", model.matrices.d);
}
