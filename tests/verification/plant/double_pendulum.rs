//! Shipped models with ball and free joints: the double pendulum of Otsuka et al., Table 3, and a wing in free flight.

use crate::plant::machines::*;
use foldwing::config;
use foldwing::machine::Machine;
use nalgebra::Vector3;
use std::path::Path;

fn shipped(name: &str) -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models").join(name);
    config::read(path).unwrap_or_else(|error| panic!("{error}")).0
}

/// P-83. Ball and ball joints up to 1 s: the tip is within 1 mm of the reference, energy is conserved, the bars stay joined.
///
/// Source: `double_pendulum_ball_ball_exudyn.csv`, 8 elements of another formulation, converged to 2e-5 m. The total
/// energy is zero at the start and stays so within 1e-4 of the largest kinetic energy at the model's tolerance.
#[test]
fn p83_double_pendulum_falls_as_the_reference() {
    let machine = shipped("double_pendulum.toml");
    assert!(machine.bodies.iter().all(|body| body.elements == 8));
    let mut plant = start(machine);
    let (mut largest_m, mut kinetic_j, mut drift_j) = (0.0_f64, 0.0_f64, 0.0_f64);
    for row in
        reference_rows("double_pendulum_ball_ball_exudyn.csv").iter().filter(|row| row[0] > 0.0 && row[0] < 1.005)
    {
        plant.step(row[0]).expect("a step");
        let outputs = plant.outputs();
        let tip = Vector3::new(row[4], row[5], row[6]);
        largest_m = largest_m.max((outputs.tips()[0].position_m - tip).norm());
        kinetic_j = kinetic_j.max(outputs.energy().kinetic);
        drift_j = drift_j.max(outputs.energy().total.abs());
        for joint in outputs.spatial() {
            assert!((joint.rotation.coords.norm() - 1.0).abs() < 1e-12);
        }
    }
    println!("tip within {largest_m:.1e} m, energy within {drift_j:.1e} J of {kinetic_j:.1} J");
    assert!(largest_m < 1e-3, "tip {largest_m:.1e} m off");
    assert!(drift_j < 1e-4 * kinetic_j, "{drift_j:.1e} J of {kinetic_j:.1} J");
    assert!((plant.outputs().tips()[0].position_m - Vector3::new(-1.37383526, -2.80077724, -0.05711964)).norm() < 1e-3);
}

/// P-84. The centre of mass of the free wing moves as a point mass: half a second of gravity and start velocity, whatever its other motion.
///
/// The height of the centre of mass follows from the energy of gravity, `m g z`; there is no load on the root.
#[test]
fn p84_free_wing_falls_as_a_point() {
    const TIME_S: f64 = 0.5;
    let mut plant = start(shipped("flying_wing.toml"));
    let before = *plant.outputs().energy();
    plant.step(TIME_S).expect("a step");
    let after = plant.outputs();
    let fallen_m = (before.gravity - after.energy().gravity) / (9.81 * plant.mass_kg());
    assert!((fallen_m - 0.5 * 9.81 * TIME_S * TIME_S).abs() < 1e-6, "fell {fallen_m} m");
    assert!((after.energy().total + after.energy().dissipated - before.total).abs() < 1e-4 * before.kinetic);
    assert!(after.root().force_n.amax() < 1e-9 && after.root().moment_n_m.amax() < 1e-9, "{:?}", after.root());
}
