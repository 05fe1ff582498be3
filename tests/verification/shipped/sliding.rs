//! The shipped models with sliding joints, of `examples/sliding`.

use super::{machine, run, start};
use crate::plant::sliding::modal_tip_m;
use foldwing::machine::Machine;
use foldwing::plant::{Holding, Plant};
use nalgebra::Matrix2;

const CRANE: &str = include_str!("../../../examples/sliding/jib_crane.toml");
const MASS: &str = include_str!("../../../examples/sliding/moving_mass.toml");
const BRIDGE: &str = include_str!("../../../examples/sliding/bridge_crane.toml");
/// Mass of trolley and load, kg.
const CARRIED_KG: f64 = 38.0;

fn balance_j(plant: &Plant) -> f64 {
    let energy = plant.outputs().energy();
    energy.total - energy.work + energy.dissipated
}

/// The crane with a given command and stop time.
fn crane(command_m: f64, stop_s: f64) -> Machine {
    let changes = [
        ("command_m = 2.6", format!("command_m = {command_m}")),
        ("stop_time_s = 8.0", format!("stop_time_s = {stop_s:?}")),
    ];
    machine(CRANE, &changes.each_ref().map(|(old, new)| (*old, new.as_str())))
}

/// SJ-12. The crane of `examples/sliding`: the trolley stops where its drive balances the component of the weight of trolley and load along
/// the slope of the jib. The load at the trolley contributes `F x² / 2 EI` to this slope, the weight of the jib `w (L³ − (L − x)³) / 6 EI`;
/// the mast carries the moments of the weights. The energy balance closes across element boundaries. With a command beyond the end of the
/// jib, the end stop holds the trolley.
#[test]
fn sj12_a_trolley_carries_a_load_along_a_jib() {
    let mut begin_j = None;
    let (mut drift_j, mut swing_rad) = (0.0f64, 0.0f64);
    let plant = run(crane(2.6, 20.0), |plant| {
        let start_j = *begin_j.get_or_insert_with(|| balance_j(plant));
        drift_j = drift_j.max((balance_j(plant) - start_j).abs());
        swing_rad = swing_rad.max(plant.outputs().joints()[1].angle_rad.abs());
    });
    let [travel, rope] = [0, 1].map(|joint| plant.outputs().joints()[joint]);
    let (reach_m, jib) = (travel.angle_rad, &plant.machine().bodies[0]);
    let bending_n_m2 = jib.section.at(0.0).stiffness[(2, 2)];
    let (weight_n, own_n_m) = (CARRIED_KG * 9.81, 9.81 * jib.section.mass_kg(jib.length_m) / jib.length_m);
    let own = jib.length_m.powi(3) - (jib.length_m - reach_m).powi(3);
    // the centres of mass are below the axis, in the frame of the section, which the slope rotates towards the mast
    let below_n_m = 9.81 * (8.0 * 0.06 + 30.0 * 0.1);
    let slope = (weight_n * reach_m.powi(2) / 2.0 + own_n_m * own / 6.0) / (bending_n_m2 + below_n_m * reach_m);
    let due_m = 2.6 + weight_n * slope.sin() / 150.0;
    let moment_n_m = weight_n * reach_m - below_n_m * slope + own_n_m * jib.length_m.powi(2) / 2.0;
    let foot = plant.outputs().internal_loads()[0].moment_n_m.y;
    println!(
        "SJ-12 rest at {reach_m:.6} m of {due_m:.6} m, slope {slope:.5}, rope {:.5} rad, swing {:.2} deg; foot {foot:.3} N·m of \
         {moment_n_m:.3}; drift {drift_j:.1e} J; {} events",
        rope.angle_rad,
        swing_rad.to_degrees(),
        plant.statistics().events
    );
    // the reduction of the lever arms by the square of the slope is neglected
    let share = 2.0 * slope * slope;
    assert!((reach_m - due_m).abs() < share * (due_m - 2.6), "{reach_m} m for {due_m} m");
    assert!((rope.angle_rad + slope).abs() < share * slope, "{} rad for the slope {slope}", rope.angle_rad);
    assert!((foot.abs() / moment_n_m - 1.0).abs() < share, "{foot} N·m for {moment_n_m}");
    assert!(swing_rad > 0.1 && plant.statistics().events >= 4);
    assert!(drift_j < 1e-2, "{drift_j:e} J");
    let held = run(crane(3.5, 20.0), |_| {});
    let stopped = held.outputs().joints()[0];
    println!("SJ-12 a command of 3.5 m: {:.5} m, {:.1e} m/s", stopped.angle_rad, stopped.rate_rad_s);
    assert!(stopped.angle_rad > 2.8 && stopped.angle_rad < 2.802 && stopped.rate_rad_s.abs() < 1e-3);
}

/// SJ-13. The shipped model of a moving mass, against the modal solution of SJ-02.
#[test]
fn sj13_the_shipped_moving_mass() {
    let mut plant = start(machine(MASS, &[]));
    let (mut off_m, mut size_m) = (0.0f64, 0.0f64);
    for (i, due_m) in modal_tip_m(0.05).into_iter().enumerate() {
        plant.step(0.02 * (i + 1) as f64).unwrap_or_else(|error| panic!("{error}"));
        off_m = off_m.max((plant.outputs().tips()[0].position_m.z - due_m).abs());
        size_m = size_m.max(due_m.abs());
    }
    println!("SJ-13 {off_m:.1e} m of {size_m:.1e} m, {} events", plant.statistics().events);
    assert!(off_m < 2e-4 * size_m && plant.statistics().events >= 7, "{off_m:e} m of {size_m:e} m");
}

/// SJ-28. The shipped bridge crane. At rest the trolley is in the middle, where the girder deflects by `F L³/48 EI + 5 w L⁴/384 EI`, and half as much
/// as the loop at its right end; the two slowest modes are those of trolley and load on the drive. Over 20 s the energy account closes,
/// while the load swings.
#[test]
fn sj28_a_load_on_a_hinge_along_a_bridge() {
    // from 2 m the limit of the motor leaves the search without a stiffness
    let near = machine(BRIDGE, &[("start_position_m = 2.0", "start_position_m = 5.9")]);
    let mut plant = Plant::new(std::sync::Arc::new(near));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let (joints, tips) = (plant.outputs().joints().to_vec(), plant.outputs().tips().to_vec());
    let machine_of = plant.machine().clone();
    let index = |name: &str| machine_of.bodies.iter().position(|body| body.name == name).expect("a body");
    let joint = |name: &str| {
        let at = machine_of.one_freedoms().position(|(body, _)| machine_of.bodies[body].joint.name == name);
        at.expect("a joint")
    };
    let girder = &machine_of.bodies[index("girder")];
    let (length_m, bending_n_m2) = (girder.length_m, girder.section.at(0.0).stiffness[(2, 2)]);
    let (weight_n, own_n) = (2400.0 * 9.81, 9.81 * girder.section.mass_kg(length_m));
    let support_m = 0.5 * (0.5 * (weight_n + own_n) / 1e8);
    let due_m = (weight_n / 48.0 + 5.0 * own_n / 384.0) * length_m.powi(3) / bending_n_m2 + support_m;
    let (travel, swing) = (joints[joint("travel")], joints[joint("travel_hinge")]);
    let sag_m = -(tips[1].position_m.z + 0.3);
    println!(
        "SJ-28 at {:.6} m, sag {sag_m:.6} m of {due_m:.6}, hinge {:.1e} rad, tip {:.1e} m",
        travel.angle_rad, swing.angle_rad, tips[0].position_m.z
    );
    assert!(
        (travel.angle_rad - 6.0).abs() < 1e-3 && (sag_m / due_m - 1.0).abs() < 1e-3 && swing.angle_rad.abs() < 1e-3
    );
    let mass = Matrix2::new(2400.0, -1e4, -1e4, 2000.0 * 25.0 + 300.0);
    let stiffness = Matrix2::new(8e3, 0.0, 0.0, 2000.0 * 9.81 * 5.0);
    let lower = mass.cholesky().expect("positive").l().try_inverse().expect("regular");
    let due = (lower * stiffness * lower.transpose())
        .symmetric_eigenvalues()
        .map(|square: f64| square.sqrt() / std::f64::consts::TAU);
    let modes = plant.study().modes(4).unwrap_or_else(|error| panic!("{error}"));
    let found: Vec<f64> = modes.iter().map(|mode| mode.frequency_hz).collect();
    println!("SJ-28 modes {found:?} Hz; undamped drive {due:?}");
    let mut begin_j = None;
    let (mut drift_j, mut swing_rad) = (0.0f64, 0.0f64);
    let plant = run(machine(BRIDGE, &[]), |plant| {
        let start_j = *begin_j.get_or_insert_with(|| balance_j(plant));
        drift_j = drift_j.max((balance_j(plant) - start_j).abs());
        swing_rad = swing_rad.max(plant.outputs().joints()[joint("travel_hinge")].angle_rad.abs());
    });
    let (travel, lost_j) = (plant.outputs().joints()[joint("travel")], plant.outputs().energy().dissipated);
    println!(
        "SJ-28 after 20 s at {:.4} m, swing {:.2} deg, drift {drift_j:.1e} J of {lost_j:.1} J dissipated, {} events",
        travel.angle_rad,
        swing_rad.to_degrees(),
        plant.statistics().events
    );
    assert!((travel.angle_rad - 6.0).abs() < 0.5 && swing_rad > 0.02 && plant.statistics().events >= 2);
    assert!(drift_j < 1e-3 * lost_j, "{drift_j:e} J");
}
