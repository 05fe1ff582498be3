//! The blade in the wind as a model file alone: the series and the roots of the reference, with the engine's own aerodynamics.

use super::air::polar;
use super::failing::misses;
use super::{joint_of, shipped};
use crate::plant::machines::{reference_rows, start};
use foldwing::aero::polar::{Polar, PolarRow};
use foldwing::machine::{AirOptions, JointMotion, Machine, Motion};
use foldwing::plant::Plant;

/// The shipped blade in the wind with gears of an inertia in kg·m² that remain in the pitch circuit.
pub fn blade_in_wind(pitch_kg_m2: f64) -> Machine {
    let mut machine = shipped("pitch_link_in_wind");
    joint_of(&mut machine, "pitch").motor.inertia_kg_m2 = pitch_kg_m2;
    machine
}

/// Angles and rates of shaft, flap and pitch every 50 ms up to a time.
pub fn series(machine: Machine, end_s: f64) -> Vec<[f64; 7]> {
    let mut plant = start(machine);
    let mut rows = vec![row(&plant)];
    for i in 1..=(end_s / 0.05).round() as u32 {
        plant.step(0.05 * f64::from(i)).expect("runs");
        rows.push(row(&plant));
    }
    rows
}

fn row(plant: &Plant) -> [f64; 7] {
    let joints = plant.outputs().joints();
    let mut row = [plant.time_s(); 7];
    for (i, joint) in joints.iter().enumerate() {
        (row[1 + i], row[4 + i]) = (joint.angle_rad, joint.rate_rad_s);
    }
    row
}

/// PL-07. `foldwing simulate examples/failures/pitch_link_in_wind.toml` reproduces the series of the independent solution.
#[test]
fn pl07_the_model_file_gives_the_series() {
    for (pitch_kg_m2, file) in
        [(0.0, "pitch_link_J0.csv"), (30.0, "pitch_link_J30.csv"), (300.0, "pitch_link_J300.csv")]
    {
        let rows = series(blade_in_wind(pitch_kg_m2), 8.0);
        let (early, late) = misses(&rows, file);
        println!("{pitch_kg_m2} kg·m²: {early:.1e} rad until 2 s, {late:.1e} of the peaks until 8 s");
        assert!(early < 1e-3 && late < 0.05, "{pitch_kg_m2} kg·m²: {early:e} rad, {late:e}");
    }
}

/// Oscillatory roots of a blade in the wind at a shaft speed in rad/s, least damped first, 1/s and rad/s. With `balanced`, the moment held
/// by the link is applied as a torque, so that the pitch does not move; otherwise at the instant at which the link opens.
pub fn roots(mut machine: Machine, speed_rad_s: f64, balanced: bool) -> Vec<(f64, f64)> {
    machine.failures.clear();
    let shaft = joint_of(&mut machine, "shaft");
    (shaft.motion, shaft.start_rate_rad_s) = (JointMotion::Prescribed(Motion::Polynomial(vec![0.0, speed_rad_s])), 0.0);
    if balanced {
        let held = start(machine.clone());
        let torque_n_m = held.outputs().joints()[2].holding_torque_n_m;
        joint_of(&mut machine, "pitch").motor.constant_torque_n_m = -torque_n_m;
    }
    joint_of(&mut machine, "pitch").release = true;
    let mut plant = start(machine);
    let modes = plant.study().modes(14).expect("modes");
    let mut roots: Vec<(f64, f64)> = modes.iter().map(|mode| mode.eigenvalue_1_s).map(|z| (z.re, z.im.abs())).collect();
    roots.retain(|root| root.1 > 0.5);
    roots.sort_by(|a, b| b.0.total_cmp(&a.0));
    roots.dedup();
    roots
}

/// Gives the blade the reference's polar with a number of rows per degree.
fn with_fine_polar(mut machine: Machine, per_degree: i32) -> Machine {
    let AirOptions::Rotor(rotor) = &mut machine.air.as_mut().expect("air").parts[0].options else { panic!("a rotor") };
    let row = |i: i32| {
        let angle_rad = (f64::from(i) / f64::from(per_degree)).to_radians();
        let [lift, drag, moment] = polar(angle_rad);
        PolarRow { angle_rad, lift, drag, moment }
    };
    rotor.polars = vec![Polar { rows: (-180 * per_degree..=180 * per_degree).map(row).collect() }];
    machine
}

/// PL-08. Flutter roots as functions of the gear inertia by the engine's linear aeroelastic model of the blade: with the reference's polar,
/// and with the rows of the model file.
#[test]
fn pl08_flutter_roots_of_the_model_file() {
    // linear interpolation between rows: an error of 1.0e-5 rad/s remains with 50 per degree
    for (per_degree, growth_1_s, frequency_rad_s) in [(1000, 1e-4, 1e-5), (0, 5e-4, 1e-3)] {
        let mut worst = [0.0f64; 2];
        for row in reference_rows("pitch_link_growth.csv") {
            let machine = blade_in_wind(row[0]);
            let roots = roots(if per_degree > 0 { with_fine_polar(machine, per_degree) } else { machine }, 4.0, false);
            for (found, expected) in roots.iter().zip(row[1..].chunks(2)) {
                worst[0] = worst[0].max((found.0 - expected[0]).abs());
                worst[1] = worst[1].max((found.1 - expected[1]).abs());
            }
        }
        println!("{per_degree} rows per degree: largest misses {:.1e} 1/s, {:.1e} rad/s", worst[0], worst[1]);
        assert!(worst[0] < growth_1_s && worst[1] < frequency_rad_s, "{per_degree}: {worst:?}");
    }
}
