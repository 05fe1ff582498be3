//! A simulation that cannot continue ends with an error that gives time and cause, never with a panic.

use crate::plant::machines::*;
use foldwing::plant::{Inputs, Parameters, Plant, PlantError};
use std::sync::Arc;

/// P-95. A tolerance that the smallest step cannot meet: the error gives the last valid time, which is that of the plant.
#[test]
fn p95_impossible_tolerance_is_an_error() {
    let mut machine = default_wing(1e-7);
    (machine.solver.min_step_s, machine.solver.max_step_s) = (2e-3, 5e-3);
    let mut plant = start(machine);
    let error = (1..=40).find_map(|i| plant.step(5e-3 * f64::from(i)).err()).expect("no step of 2 ms meets 1e-7");
    println!("{error}");
    let PlantError::NoConvergence { time_s, step_s, .. } = &error else { panic!("{error}") };
    assert_eq!(*time_s, plant.time_s(), "the plant must stand at the last good time");
    assert_eq!(plant.outputs().time_s, plant.time_s());
    assert!(*step_s < 2e-3 && error.to_string().contains("exceeds the tolerance"), "{error}");
    assert!(plant.outputs().joints()[0].angle_rad.is_finite());
}

/// P-96. Contradictory step limits are rejected at the start; they used to panic.
#[test]
fn p96_contradicting_step_limits_are_an_error() {
    let mut plant = Plant::new(Arc::new(default_wing(1e-4)));
    plant.parameters_mut().solver_mut().min_step_s = 1e-2;
    plant.parameters_mut().solver_mut().max_step_s = 1e-3;
    let error = plant.initialize(0.0).expect_err("1e-2 s is more than 1e-3 s");
    assert_eq!(error, PlantError::Steps { min_step_s: 1e-2, max_step_s: 1e-3 });
    assert_eq!(
        error.to_string(),
        "solver.min_step, 1e-2 s, is longer than solver.max_step, 1e-3 s; change one of them"
    );
    plant.parameters_mut().solver_mut().min_step_s = 1e-3;
    plant.initialize(0.0).expect("equal limits are one step");
}

/// P-97. A value that is not a number gives an error and does not affect time, state and later steps with valid values.
///
/// The FMI layer rejects such values first; the checks of the plant are a second line of defence.
#[test]
fn p97_values_that_are_not_numbers_are_errors() {
    type Spoil = (&'static str, fn(&mut Inputs));
    let spoil: [Spoil; 6] = [
        ("command", |inputs| inputs.joints_mut()[0].command_rad = f64::NAN),
        ("torque", |inputs| inputs.joints_mut()[0].torque_n_m = f64::INFINITY),
        ("force", |inputs| inputs.stations_mut()[0].force_n.y = f64::NAN),
        ("moment", |inputs| inputs.stations_mut()[1].moment_n_m.x = f64::NEG_INFINITY),
        ("gravity", |inputs| inputs.root_mut().gravity_m_s2.z = f64::NAN),
        ("angular velocity", |inputs| inputs.root_mut().angular_velocity_rad_s.x = f64::NAN),
    ];
    for (name, spoil) in spoil {
        let mut machine = default_wing(1e-4);
        machine.bodies[0].station_positions_m = vec![0.1, 0.15];
        let mut plant = start(machine);
        coast(&mut plant, 0.05);
        let (good, snapshot) = (plant.inputs().clone(), plant.snapshot());
        spoil(plant.inputs_mut());
        let error = plant.step(0.06).expect_err(name);
        println!("{name}: {error}");
        assert_eq!(plant.time_s(), 0.05, "{name}: time moved");
        *plant.inputs_mut() = good;
        plant.restore(&snapshot).expect("own snapshot");
        coast(&mut plant, 0.06);
        assert!(plant.outputs().tips()[0].position_m.norm().is_finite(), "{name}: not finite after recovery");
    }
}

/// P-98. Invalid parameters neither panic nor hang.
///
/// A limit that is NaN used to panic in `clamp`.
#[test]
fn p98_spoilt_parameters_do_not_panic() {
    let spoil: [fn(&mut Parameters, f64); 8] = [
        |parameters, value| parameters.joints_mut()[0].stiffness_n_m_rad = value,
        |parameters, value| parameters.joints_mut()[0].damping_n_m_s_rad = value,
        |parameters, value| parameters.joints_mut()[0].torque_limit_n_m = value,
        |parameters, value| parameters.joints_mut()[0].rate_limit_rad_s = value,
        |parameters, value| parameters.joints_mut()[0].latch_stiffness_n_m_rad = value,
        |parameters, value| parameters.joints_mut()[0].constant_torque_n_m = value,
        |parameters, value| parameters.bodies_mut()[0].mass_damping_1_s = value,
        |parameters, value| parameters.bodies_mut()[0].stiffness_damping_s = value,
    ];
    for spoil in spoil {
        for value in [f64::NAN, f64::INFINITY, -1.0] {
            let mut plant = start(default_wing(1e-4));
            coast(&mut plant, 0.01);
            spoil(plant.parameters_mut(), value);
            let _ = plant.step(0.011);
        }
    }
}
