//! Real-time mode: bounded work in every step, and otherwise unchanged results.

use crate::plant::chains::chain;
use crate::plant::machines;
use foldwing::machine::Machine;
use foldwing::machine::{ElementKind, Method};
use foldwing::plant::{Plant, PlantError};
use std::sync::Arc;

/// Step of a hardware-in-the-loop rig in s, and the default bound on the iterations of a stage.
const STEP_S: f64 = 1e-3;
const MOST: usize = 4;
/// Stages of the method.
const STAGES: u64 = 2;

/// The deployment with 15 constant elements per body and fixed steps; in real-time mode if iterations are bounded.
fn wing(step_s: f64, most_iterations: Option<usize>) -> Machine {
    let mut machine = machines::wing(ElementKind::Constant, 15, Method::Sdirk2, 1e-4);
    machine.solver.fixed_step_s = Some(step_s);
    machine.solver.most_iterations = most_iterations;
    with_stations(machine)
}

/// Three load stations on each body, as required for the load of a turbulent wind.
fn with_stations(mut machine: Machine) -> Machine {
    for body in &mut machine.bodies {
        body.station_positions_m = vec![0.05, 0.1, 0.15];
    }
    machine
}

fn started(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap();
    plant
}

/// The deployment with the default method.
fn accurate(tolerance: f64) -> Machine {
    with_stations(machines::wing(ElementKind::Constant, 15, Method::Esdirk4, tolerance))
}

/// Fold angle, tip height and latch time after the deployment.
fn deployed(machine: Machine) -> (Vec<[f64; 2]>, f64, Plant) {
    let mut plant = started(machine);
    let mut course = Vec::new();
    for step in 1..=200 {
        plant.step(f64::from(step) * STEP_S).unwrap();
        let outputs = plant.outputs();
        course.push([outputs.joints()[0].angle_rad, outputs.tips()[0].position_m.z]);
    }
    let latch_time_s = plant.outputs().latches()[0].time_s;
    (course, latch_time_s, plant)
}

/// P-110. If no iteration is truncated, real-time mode follows the ordinary mode with the same method and fixed step: both solve the same
/// equations, so they differ only by the residual of Newton's iteration, at most 1e-8 of the wing's length in a stage, and by the latch
/// time, which is located by two trials instead of forty. The allowed difference is the sum of this over 2000 steps, in rad and m; for the
/// latch time it is divided by the rate of about 10 rad/s. With longer steps the ordinary mode shortens the first one.
#[test]
fn p110_nothing_cut_short_changes_nothing() {
    let (real_time, real_time_latch_s, plant) = deployed(wing(1e-4, Some(10)));
    let (ordinary, ordinary_latch_s, ordinary_plant) = deployed(wing(1e-4, None));
    assert_eq!(ordinary_plant.statistics().failures, 0, "the ordinary mode has cut no step");
    assert_eq!(plant.statistics().unconverged, 0);
    let apart = |n: usize| real_time.iter().zip(&ordinary).map(|(a, b)| (a[n] - b[n]).abs()).fold(0.0, f64::max);
    println!(
        "P-110: apart by {:.1e} rad, {:.1e} m, {:.1e} s",
        apart(0),
        apart(1),
        real_time_latch_s - ordinary_latch_s
    );
    assert!(apart(0) < 2e-5 && apart(1) < 2e-5);
    assert!(ordinary_latch_s > 0.1 && (real_time_latch_s - ordinary_latch_s).abs() < 2e-6);
}

/// P-111. The deployment at steps of 1 ms, with an abrupt release that excites modes a thousand times faster than the step: latch time
/// within 0.1 % of that of the shipped solver at 1e-6, fold angle within 0.01 rad until the latch closes. This is the discretisation error
/// of the method, P-112.
#[test]
fn p111_the_deployment_at_a_millisecond() {
    let (real_time, latch_s, plant) = deployed(wing(STEP_S, Some(MOST)));
    let (exact, exact_latch_s, _) = deployed(accurate(1e-6));
    let apart = real_time.iter().zip(&exact).map(|(a, b)| (a[0] - b[0]).abs());
    let until_latch = apart.take(122).fold(0.0, f64::max);
    let error = latch_s / exact_latch_s - 1.0;
    println!(
        "P-111: latch {latch_s:.6} s, {error:+.1e}; fold angle within {until_latch:.1e} rad; {:?}",
        plant.statistics()
    );
    assert!(error.abs() < 1e-3 && until_latch < 0.01);
    assert_eq!(plant.statistics().rejections + plant.statistics().failures, 0);
}

/// P-112. The fold angle at 0.1 s, before the latch, converges with the step: from 1 to ⅛ ms its error falls by at least a factor of five,
/// but not with the square of the step, and not below 3e-5 rad: the abrupt release excites modes that only steps of microseconds resolve;
/// unresolved modes are damped. For the order of the method with all modes resolved see P-12.
#[test]
fn p112_the_angle_converges_with_the_step() {
    let angle = |machine: Machine| {
        let mut plant = started(machine);
        (1..=100).for_each(|step| plant.step(f64::from(step) * STEP_S).unwrap());
        plant.outputs().joints()[0].angle_rad
    };
    let exact = angle(accurate(1e-8));
    let errors = [1e-3, 5e-4, 2.5e-4, 1.25e-4].map(|step_s| (angle(wing(step_s, Some(MOST))) - exact).abs());
    println!("P-112: errors {errors:?} rad");
    assert!(errors[3] < errors[0] / 5.0);
}

/// Applies `force_n` of alternating sign at all stations, steps, and returns the result of the step.
fn shake(plant: &mut Plant, step: u32, force_n: f64) -> Result<(), PlantError> {
    for (place, station) in plant.inputs_mut().stations_mut().iter_mut().enumerate() {
        station.force_n.z = if (step as usize + place).is_multiple_of(2) { force_n } else { -force_n };
    }
    plant.step(f64::from(step) * STEP_S)
}

/// P-113. Under an extreme load of tens of times the weight, stages do not converge and are counted, and no step costs more than its number
/// of stages times the bound, plus three times that for each latch that closes (two trials and the rest of the step). Nothing is repeated.
#[test]
fn p113_work_is_bounded_under_an_absurd_load() {
    let mut plant = started(wing(STEP_S, Some(MOST)));
    for step in 1..=300 {
        let before = plant.statistics();
        shake(&mut plant, step, 5.0).unwrap();
        let after = plant.statistics();
        let marches = 1 + 3 * (after.events - before.events);
        assert!(after.iterations - before.iterations <= marches * STAGES * MOST as u64, "{step}: {before:?} {after:?}");
        assert_eq!(after.rejections + after.failures, 0);
    }
    let statistics = plant.statistics();
    println!("P-113: {statistics:?}");
    assert_eq!(statistics.largest_iterations, MOST as u64, "the bound was reached");
    assert!(statistics.unconverged > 0);
}

/// P-114. Values that are not finite remain an error, and the plant stays at the last valid time.
#[test]
fn p114_what_is_not_finite_is_an_error() {
    let mut plant = started(wing(STEP_S, Some(MOST)));
    plant.step(STEP_S).unwrap();
    let error = (2..200).find_map(|step| shake(&mut plant, step, 1e30).err()).expect("1e30 N blow up");
    println!("P-114: {error}");
    assert!(plant.time_s() < 0.2 && plant.outputs().tips()[0].position_m.norm().is_finite());
}

/// P-115. Steps with unconverged stages are bit-identical when repeated from a restored state.
#[test]
fn p115_unconverged_steps_repeat() {
    let mut plant = started(wing(STEP_S, Some(2)));
    (1..=20).for_each(|step| shake(&mut plant, step, 5.0).unwrap());
    let kept = plant.snapshot();
    let mut go_on = || {
        (21..=40).for_each(|step| shake(&mut plant, step, 5.0).unwrap());
        let result = (plant.outputs().clone(), plant.statistics());
        plant.restore(&kept).unwrap();
        result
    };
    let first = go_on();
    assert_eq!(first, go_on());
    assert!(first.1.unconverged > 0, "{:?}", first.1);
}

/// P-118. Forty chains of folds in violent motion at steps of 1 ms: each continues with plausible angles or stops with an error that
/// mentions real-time mode; none continues with angles beyond those that its torques can cause. Without this check, angles used to grow to
/// 5e14 rad.
#[test]
fn p118_a_motion_that_is_lost_is_an_error() {
    let (mut ended, mut lost) = (0, 0);
    for seed in 0..40 {
        let machine = foldwing::config::parse(&chain(seed, "mode = \"real_time\""), "chain.toml").unwrap();
        let mut plant = started(machine);
        let outcome = (1..=1000).try_for_each(|step| {
            plant.step(f64::from(step) * STEP_S)?;
            let angle_rad = plant.outputs().joints().iter().map(|joint| joint.angle_rad.abs()).fold(0.0, f64::max);
            assert!(angle_rad < 50.0, "chain {seed}, step {step}: {angle_rad:e} rad");
            Ok(())
        });
        match outcome {
            Ok(()) => ended += 1,
            Err(error) => {
                let error: PlantError = error;
                assert!(error.to_string().contains("in real-time mode"), "chain {seed}: {error}");
                lost += 1;
            }
        }
    }
    println!("P-118: {ended} end, {lost} stop");
    assert!(ended > 0 && lost > 0);
}

/// P-116. A gust-like load on the latched wing: the tip follows the ordinary mode at 1e-6 within 2 % of the motion's range (the step
/// resolves the first modes, but not the stiff ones).
#[test]
fn p116_turbulence_on_the_latched_wing() {
    let shaken = |machine: Machine| {
        let mut plant = started(machine);
        (1..=1500u32)
            .map(|step| {
                let time_s = f64::from(step) * STEP_S;
                let force_n = 0.05 * (40.0 * time_s).sin() + 0.03 * (97.0 * time_s + 1.0).sin();
                plant.inputs_mut().stations_mut().iter_mut().for_each(|station| station.force_n.z = force_n);
                plant.step(time_s).unwrap();
                plant.outputs().tips()[0].position_m.z
            })
            .skip(500)
            .collect::<Vec<f64>>()
    };
    let real_time = shaken(wing(STEP_S, Some(MOST)));
    let exact = shaken(accurate(1e-6));
    let (low, high) = exact.iter().fold((f64::MAX, f64::MIN), |(low, high), z| (z.min(low), z.max(high)));
    let apart = real_time.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("P-116: apart by {apart:.1e} m of a range of {:.3} m", high - low);
    assert!(apart < 0.02 * (high - low));
}
