//! Order of rotor aerodynamics in the aerodynamic step: wake and sections with their lags, separately and together, on an accelerating
//! rotor in a wind from the side.

use foldwing::config;
use foldwing::plant::Plant;
use std::fmt::Write;
use std::sync::Arc;

/// Duration of the run in s: three quarters of a revolution, ten times the slowest lag of the sections, half of that of the wake.
const END_S: f64 = 0.32;

/// A rigid blade on a flap hinge that represents three, and a shaft accelerated by a third by the wind. The polar is smooth from attached
/// flow to deep stall, with rows 1° apart: at 14 m/s and 9 rad/s the sections are on both sides of maximum lift.
pub fn model(air: &str, step_s: f64) -> String {
    let mut rows = String::new();
    for degree in -180..=180 {
        let angle_rad = f64::from(degree).to_radians();
        let lift = 3.0 * (2.0 * angle_rad).sin() * (1.0 - 0.5 * (angle_rad / 0.25).tanh().powi(2));
        let drag = 0.01 + 1.2 * angle_rad.sin().powi(2);
        let _ = write!(rows, "[{degree}, {lift}, {drag}, {}], ", -0.1 * angle_rad.sin());
    }
    format!(
        "name = \"rotor\"
[rigid_body.hub]
mass_kg = 40.0
inertia_kg_m2 = [30.0, 20.0, 20.0, 0.0, 0.0, 0.0]
[rigid_body.blade]
mass_kg = 20.0
centre_of_mass_m = [1.6, 0.0, 0.0]
inertia_kg_m2 = [0.3, 25.0, 25.2, 0.0, 0.0, 0.0]
[joint.shaft]
type = \"revolute\"
parent = \"root\"
child = \"hub\"
axis = [1.0, 0.0, 0.0]
start_rate_deg_s = 500.0
[joint.flap]
type = \"revolute\"
parent = \"hub\"
child = \"blade\"
parent_offset_m = [0.0, 0.0, 0.5]
mount_rotation_deg = [127.27922061357856, 0.0, 127.27922061357856]
axis = [0.0, 1.0, 0.0]
[joint.flap.motor]
stiffness_N_m_rad = 2e4
damping_N_m_s_rad = 100.0
[aerodynamics]
model = \"bem\"
hub = \"hub\"
hub_radius_m = 0.5
wind_m_s = [14.0, 3.0, 0.0]
blades = 3
step_s = {step_s:?}
coupling_tolerance = 1e-9
{air}
[surface.blade]
body = \"blade\"
length_m = 4.0
elastic_axis_fraction = 0.25
chord_m = {{ table = [[0.0, 0.5], [4.0, 0.25]] }}
incidence_deg = {{ table = [[0.0, -15.0], [4.0, -1.0]] }}
leading_edge = \"+y\"
stations_m = [0.0, 0.8, 2.0, 3.2, 4.0]
polars = [\"foil\", \"foil\", \"foil\", \"foil\", \"foil\"]
[polar.foil]
rows = [{rows}]
[solver]
fixed_step_s = 2.5e-4
tolerance = 1e-9
"
    )
}

/// Flap angle, shaft speed, thrust and torque at the end.
fn end(air: &str, step_s: f64) -> [f64; 4] {
    let machine = config::parse(&model(air, step_s), "rotor.toml").unwrap_or_else(|error| panic!("{error}"));
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("a start");
    plant.step(END_S).expect("a run");
    let outputs = plant.outputs();
    let (rotor, joints) = (outputs.rotor()[0], outputs.joints());
    [joints[1].angle_rad, joints[0].rate_rad_s, rotor.thrust_n, rotor.torque_n_m]
}

/// RT-19. Second order in the aerodynamic step with every aerodynamic lag, separately and together, for a steady and an impulsive start:
/// loads are linear over a step, every lag is integrated exactly for such loads, and its time constant is the mean of those at the ends of
/// the step.
#[test]
fn rt19_order_in_the_aerodynamic_step_is_two() {
    let both = "dynamic_inflow = true\ndynamic_stall = true\nskewed_wake = true\n";
    let sets_in = format!("{both}steady_initial_flow = false\n");
    for air in ["", "dynamic_inflow = true\nsteady_initial_flow = false\n", "dynamic_stall = true\n", both, &sets_in] {
        let ends = [4e-3, 2e-3, 1e-3, 5e-4].map(|step_s| end(air, step_s));
        // all outputs together, each relative to its magnitude: the error of a single one may pass through zero
        let change = |pair: &[[f64; 4]]| -> f64 {
            (0..4).map(|k| ((pair[0][k] - pair[1][k]) / pair[1][k]).powi(2)).sum::<f64>().sqrt()
        };
        let changes: Vec<f64> = ends.windows(2).map(change).collect();
        let orders: Vec<f64> = changes.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        println!("RT-19 {air:?}: {:.6?}, changes {changes:?}, orders {orders:.2?}", ends[3]);
        assert!(orders.iter().all(|order| (1.9..2.1).contains(order)), "{air}: {orders:?}");
    }
}
