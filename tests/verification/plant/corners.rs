//! Special cases of motor, lock and latch.

use crate::plant::machines::*;
use foldwing::beam::section::{Material, Section};
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::{Matrix3, Vector3};

/// A stiff rod of 0.15 m on a hinge at the root, without gravity: only one coordinate matters, and closed forms exist.
pub fn rod(revolute: Revolute) -> Machine {
    let material = Material { youngs_modulus_pa: 2.83e12, shear_modulus_pa: 1e12, density_kg_m3: 1425.0 };
    let section = Section::rectangle(0.02, 0.01, &material, None);
    let rod = body("rod", 0.15, &section, ElementKind::Linear, 1).stiffness_damping_s(1e-5);
    machine([(rod, hinged_to_root(revolute))])
}

/// Adds a second, equal rod to the first one's outer end, on a hinge `fold0`.
pub fn add_rod(machine: &mut Machine, elbow: Revolute) {
    let mut outer = machine.bodies[0].clone();
    outer.name = "outer".into();
    outer.joint = Joint {
        name: "fold0".into(),
        parent: Parent::Body { index: 0, position_m: outer.length_m },
        offset_m: Vector3::zeros(),
        mount: Matrix3::identity(),
        kind: JointKind::Revolute(Box::new(elbow)),
    };
    machine.bodies.push(outer);
}

/// Inertia of [`rod`] about its hinge in kg·m², rotary inertia of the section included.
pub fn rod_inertia_kg_m2() -> f64 {
    let mass_kg = 1425.0 * 0.02 * 0.01 * 0.15;
    mass_kg * (0.15f64.powi(2) / 3.0 + 0.01f64.powi(2) / 12.0)
}

fn only(plant: &Plant) -> foldwing::plant::JointOutputs {
    plant.outputs().joints()[0]
}

/// P-40. A command to a latched joint moves the drive's neutral angle, and the joint only by the fraction `k/(k + k_L)` of it.
///
/// Closed form, against the mean over the last 50 ms; the vibration on the latch decays because of the drive's damper.
#[test]
fn p40_command_while_latched_moves_the_joint_by_the_ratio_of_stiffnesses() {
    let mut revolute = free_hinge(0.0);
    revolute.motor = Motor { stiffness_n_m_rad: 0.1, damping_n_m_s_rad: 0.01, ..Motor::default() };
    revolute.latch = Some(Latch { initially_closed: true, ..latch(10.0) });
    let mut plant = start(rod(revolute));
    assert!(latch_of(&plant).closed.is_on() && latch_of(&plant).count.get() == 0 && latch_of(&plant).time_s == -1.0);
    plant.inputs_mut().joints_mut()[0].command_rad = 0.5;
    coast(&mut plant, 1.0);
    let expected_rad = 0.5 * 0.1 / 10.1;
    let error_rad = only(&plant).angle_rad - expected_rad;
    assert!(latch_of(&plant).closed.is_on(), "a command must not open the latch");
    assert!(error_rad.abs() < 1e-6 * expected_rad, "angle misses {expected_rad} rad by {error_rad:.1e} rad");
    let sum_n_m = only(&plant).torque_applied_n_m + only(&plant).latch_torque_n_m;
    assert!(sum_n_m.abs() < 1e-6 * only(&plant).latch_torque_n_m.abs(), "drive and latch differ by {sum_n_m:.1e} N·m");
}

/// P-41. A free hinge (k = 0) with an elastic latch latches at the time of the closed form `Δθ/θ̇` and then oscillates at `√(k_L/J)`.
///
/// The rod is rigid to 1e-5 rad; times to 1e-6 s.
#[test]
fn p41_latch_on_a_free_hinge() {
    let mut revolute = free_hinge(0.5);
    revolute.start_rate_rad_s = -4.0;
    revolute.latch = Some(latch(2.0));
    let mut plant = start(rod(revolute));
    coast(&mut plant, 0.13);
    let joint = only(&plant);
    let latch = latch_of(&plant);
    assert!((latch.time_s - 0.125).abs() < 1e-6, "caught at {} s, expected 0.125 s", latch.time_s);
    let frequency = (2.0 / rod_inertia_kg_m2()).sqrt();
    let expected_rad = -4.0 / frequency * (frequency * 0.005).sin();
    let error_rad = joint.angle_rad - expected_rad;
    println!("latch at {} s, angle misses the sine by {error_rad:.1e} rad of {expected_rad:.2e}", latch.time_s);
    assert!(error_rad.abs() < 5e-4 * (4.0 / frequency), "angle misses the sine by {error_rad:.1e} rad");
}

/// P-42. A saturated drive accelerates the rod by `limit/J`; the torque output equals the limit.
#[test]
fn p42_torque_limit_gives_constant_acceleration() {
    let mut revolute = free_hinge(2.0);
    revolute.motor = Motor { stiffness_n_m_rad: 1.0, torque_limit_n_m: 0.01, ..Motor::default() };
    let mut plant = start(rod(revolute));
    coast(&mut plant, 0.05);
    let expected_rad = 2.0 - 0.5 * 0.01 / rod_inertia_kg_m2() * 0.05f64.powi(2);
    let error_rad = only(&plant).angle_rad - expected_rad;
    assert_eq!(only(&plant).torque_applied_n_m, -0.01);
    assert!(error_rad.abs() < 2e-5 * (2.0 - expected_rad), "angle misses the parabola by {error_rad:.1e} rad");
}

/// P-43. A rate-limited command: the motor torque is that of the slewing neutral angle, exact at every time.
#[test]
fn p43_slew_limits_the_neutral_angle() {
    let mut revolute = free_hinge(0.0);
    revolute.motor = Motor { stiffness_n_m_rad: 0.2, rate_limit_rad_s: 3.0, ..Motor::default() };
    let mut plant = start(rod(revolute));
    coast(&mut plant, 0.1);
    plant.inputs_mut().joints_mut()[0].command_rad = 0.9;
    for (time_s, neutral_rad) in [(0.15, 0.15), (0.3, 0.6), (0.45, 0.9), (0.6, 0.9)] {
        coast(&mut plant, time_s);
        let expected_n_m = -0.2 * (only(&plant).angle_rad - neutral_rad);
        let error_n_m = only(&plant).torque_applied_n_m - expected_n_m;
        assert!(error_n_m.abs() < 1e-12, "t = {time_s} s: torque misses {expected_n_m} by {error_n_m:.1e} N·m");
        let shown_rad = only(&plant).neutral_angle_rad;
        assert!((shown_rad - neutral_rad).abs() < 1e-14, "t = {time_s} s: neutral angle {shown_rad} rad");
    }
}

/// P-149. The neutral angle and its rate as outputs: at the start, during the slew at the rate limit, at its end.
#[test]
fn p149_the_neutral_angle_has_the_rate_of_its_slew() {
    let mut revolute = free_hinge(0.0);
    revolute.motor = Motor { stiffness_n_m_rad: 0.2, rate_limit_rad_s: 3.0, ..Motor::default() };
    let mut plant = start(rod(revolute));
    let rate = |plant: &mut Plant| plant.study().output_rates().joints()[0].neutral_angle_rad;
    assert_eq!((only(&plant).neutral_angle_rad, rate(&mut plant)), (0.0, 0.0));
    plant.inputs_mut().joints_mut()[0].command_rad = 0.9;
    for (time_s, expected_rad_s) in [(0.1, 3.0), (0.25, 3.0), (0.5, 0.0)] {
        coast(&mut plant, time_s);
        let rate_rad_s = rate(&mut plant);
        println!("P-149 at {time_s} s off by {:.1e} rad/s", rate_rad_s - expected_rad_s);
        assert!((rate_rad_s - expected_rad_s).abs() < 1e-9, "t = {time_s} s: {rate_rad_s} rad/s");
    }
}

/// P-44. Opening the latch releases the wing, and enabling it catches the wing at the next crossing: two closings.
#[test]
fn p44_latch_opens_and_catches_again() {
    let mut plant = start(default_wing(1e-5));
    coast(&mut plant, 0.2);
    let first_s = latch_of(&plant).time_s;
    plant.inputs_mut().joints_mut()[0].latch_enable = false.into();
    plant.inputs_mut().joints_mut()[0].command_rad = 4.0;
    plant.inputs_mut().joints_mut()[0].torque_n_m = 0.05;
    coast(&mut plant, 0.3);
    assert!(!latch_of(&plant).closed.is_on() && only(&plant).angle_rad > 0.2, "open at {} rad", only(&plant).angle_rad);
    assert_eq!((latch_of(&plant).count.get(), latch_of(&plant).time_s), (1, first_s), "the past must stay");
    assert_eq!(only(&plant).latch_torque_n_m, 0.0);
    plant.inputs_mut().joints_mut()[0].latch_enable = true.into();
    plant.inputs_mut().joints_mut()[0].command_rad = -1.0;
    plant.inputs_mut().joints_mut()[0].torque_n_m = 0.0;
    coast(&mut plant, 0.7);
    assert!(latch_of(&plant).closed.is_on() && latch_of(&plant).count.get() == 2, "{:?}", only(&plant));
    assert!(latch_of(&plant).time_s > 0.3, "second closing at {} s", latch_of(&plant).time_s);
}

/// P-45. A latch enabled inside the capture window closes at once; outside, it waits for the crossing.
#[test]
fn p45_capture_window() {
    for (capture_rad, at_once) in [(0.6, true), (0.4, false)] {
        let mut revolute = free_hinge(0.5);
        revolute.latch = Some(Latch { capture_rad, enable: false, ..latch(2.0) });
        let mut plant = start(rod(revolute));
        coast(&mut plant, 0.01);
        plant.inputs_mut().joints_mut()[0].latch_enable = true.into();
        coast(&mut plant, 0.0101);
        assert_eq!(latch_of(&plant).closed.is_on(), at_once, "window {capture_rad} rad, angle 0.5 rad");
        if at_once {
            assert!((latch_of(&plant).time_s - 0.01).abs() < 1e-12, "closed at {} s", latch_of(&plant).time_s);
        }
    }
}

/// P-46. A latch that is enabled while the joint is beyond the latch angle catches the joint on its return, also from that side.
#[test]
fn p46_latch_closes_from_either_side() {
    let mut revolute = free_hinge(0.5);
    revolute.start_rate_rad_s = -4.0;
    revolute.latch = Some(Latch { enable: false, ..latch(2.0) });
    let mut plant = start(rod(revolute));
    coast(&mut plant, 0.2);
    assert!(only(&plant).angle_rad < -0.29, "passed the disabled latch to {} rad", only(&plant).angle_rad);
    plant.inputs_mut().joints_mut()[0].latch_enable = true.into();
    plant.inputs_mut().joints_mut()[0].torque_n_m = 0.05;
    coast(&mut plant, 0.35);
    assert!(
        latch_of(&plant).closed.is_on() && latch_of(&plant).count.get() == 1,
        "must catch on the way back: {:?}",
        only(&plant)
    );
}

/// Three bodies: two folds that latch at different times.
fn three_bodies() -> Machine {
    let section = wing_section();
    let bar = |name| body(name, 0.1, &section, ElementKind::Linear, 2);
    let mut first = wing_hinge(0.05);
    first.start_angle_rad = 1.2;
    let mut second = wing_hinge(0.05);
    second.start_angle_rad = -1.0;
    second.motor.constant_torque_n_m = -0.05;
    machine([
        (bar("a"), clamped()),
        (bar("b"), Joint::hinge("fold0", first).on("a")),
        (bar("c"), Joint::hinge("fold1", second).on("b")),
    ])
}

/// P-47. Two joints latch at different times, each coming from its folded side.
#[test]
fn p47_two_joints_latch_at_different_times() {
    let mut plant = start(three_bodies());
    coast(&mut plant, 0.3);
    let latches = plant.outputs().latches();
    println!("latched at {} s and {} s", latches[0].time_s, latches[1].time_s);
    assert!(latches.iter().all(|latch| latch.closed.is_on() && latch.count.get() == 1), "{latches:?}");
    assert!((latches[0].time_s - latches[1].time_s).abs() > 1e-3, "the times must differ: {latches:?}");
}

/// P-48. Two mirrored wings reach their latches at the same instant: both latches close, at the same time.
///
/// The second latch used to be missed: the step ended at the first crossing, beyond the second by round-off.
#[test]
fn p48_two_joints_latch_at_the_same_instant() {
    for lag_rad in [0.0, 1e-15, 1e-13, 1e-11, 1e-9, -1e-13, -1e-11] {
        let material = Material { youngs_modulus_pa: 2.83e12, shear_modulus_pa: 1e12, density_kg_m3: 1425.0 };
        let section = Section::rectangle(0.02, 0.01, &material, None);
        let half = |name: &str, start_angle_rad: f64, rate: f64| {
            let mut revolute = free_hinge(start_angle_rad);
            revolute.start_rate_rad_s = rate;
            revolute.latch = Some(latch(2.0));
            (body(name, 0.15, &section, ElementKind::Linear, 1), Joint::hinge(format!("fold_{name}"), revolute))
        };
        let halves = [half("a", 0.5, -4.0), half("b", -0.5 + lag_rad, 4.0), half("c", 0.5 - lag_rad, -4.0)];
        let mut plant = start(machine(halves));
        coast(&mut plant, 0.2);
        for latch in plant.outputs().latches() {
            assert!(latch.closed.is_on() && (latch.time_s - 0.125).abs() < 1e-6, "lag {lag_rad:e} rad: {latch:?}");
        }
    }
}

/// P-53. Inputs that change exactly at the crossing, or within round-off of it, do not suppress the closing.
///
/// The plant used to lose a located closing when the inputs changed between it and the present.
#[test]
fn p53_inputs_changed_at_the_crossing_keep_the_closing() {
    let falling = || {
        let mut revolute = free_hinge(0.5);
        revolute.start_rate_rad_s = -4.0;
        revolute.latch = Some(latch(2.0));
        start(rod(revolute))
    };
    let mut plant = falling();
    coast(&mut plant, 0.13);
    let crossing_s = latch_of(&plant).time_s;
    for shift_s in [0.0, 1e-16, -1e-16, 1e-13, -1e-13, 1e-11, -1e-11, 1e-10, -1e-10, 1e-9, -1e-9] {
        for early in [false, true] {
            let mut plant = falling();
            for (i, time_s) in [0.05, 0.1, crossing_s + shift_s, 0.126, 0.13].into_iter().enumerate() {
                if early || i >= 3 {
                    plant.inputs_mut().joints_mut()[0].torque_n_m = 1e-12 * i as f64;
                }
                coast(&mut plant, time_s);
            }
            let joint = only(&plant);
            let latch = latch_of(&plant);
            assert!(latch.closed.is_on() && latch.count.get() == 1, "shift {shift_s:e} s, {early}: {joint:?}");
            assert!((latch.time_s - crossing_s).abs() < 1e-7, "closed at {} s", latch.time_s);
        }
    }
}

/// P-49. The lock holds exactly at the start angle until released; a release cannot be undone.
#[test]
fn p49_stopper_holds_until_released_and_again_where_it_is() {
    let mut machine = default_wing(1e-5);
    hinge_of(&mut machine, 1).release = false;
    let mut plant = start(machine);
    let start_rad = 170f64.to_radians();
    run(
        &mut plant,
        0.05,
        50,
        |_| {},
        |outputs| {
            assert_eq!((outputs.joints()[0].angle_rad, outputs.joints()[0].rate_rad_s), (start_rad, 0.0));
        },
    );
    plant.inputs_mut().joints_mut()[0].release = true.into();
    coast(&mut plant, 0.06);
    let released_rad = only(&plant).angle_rad;
    assert!(released_rad < start_rad - 0.01, "released, still at {released_rad} rad");
    plant.inputs_mut().joints_mut()[0].release = false.into();
    coast(&mut plant, 0.25);
    assert_eq!((only(&plant).angle_rad, only(&plant).rate_rad_s), (released_rad, 0.0), "held where it was");
}

/// P-50. A wing folded to the other side is the mirror image: angle and z-positions change sign, the strain at the mirrored point is
/// unchanged.
///
/// The equations are mirrored term by term, but the order of summation differs: round-off grows to 1e-9 within 0.2 s.
#[test]
fn p50_folding_to_the_other_side_mirrors_the_answer() {
    let mut mirrored = default_wing(1e-5);
    let hinge = hinge_of(&mut mirrored, 1);
    hinge.start_angle_rad = -hinge.start_angle_rad;
    hinge.motor.constant_torque_n_m = -hinge.motor.constant_torque_n_m;
    mirrored.gauges[0].z_m = -mirrored.gauges[0].z_m;
    let (mut plant, mut mirror) = (start(default_wing(1e-5)), start(mirrored));
    coast(&mut plant, 0.2);
    coast(&mut mirror, 0.2);
    let (plant, mirror) = (plant.outputs(), mirror.outputs());
    let (a, b) = (plant.joints()[0], mirror.joints()[0]);
    let [closed_s, mirrored_s] = [plant, mirror].map(|outputs| outputs.latches()[0].time_s);
    assert!(closed_s > 0.0 && (closed_s - mirrored_s).abs() < 1e-9, "{closed_s} s, {mirrored_s} s");
    assert!((a.angle_rad + b.angle_rad).abs() < 1e-9, "angles {} and {} rad", a.angle_rad, b.angle_rad);
    let reflected = Vector3::new(1.0, 1.0, -1.0).component_mul(&mirror.tips()[0].position_m);
    let miss_m = (reflected - plant.tips()[0].position_m).norm();
    assert!(miss_m < 1e-9, "the mirrored tip misses by {miss_m:.1e} m");
    let strain = plant.gauges()[0] - mirror.gauges()[0];
    assert!(strain.abs() < 1e-9, "strains differ by {strain:.1e}");
}

/// P-51. A locked joint behaves as a clamped one mounted at its angle.
#[test]
fn p51_locked_joint_equals_clamped_mount() {
    let mut locked = default_wing(1e-7);
    let hinge = hinge_of(&mut locked, 1);
    (hinge.motion, hinge.start_angle_rad) = (JointMotion::Locked, 0.7);
    let mut fixed = locked.clone();
    fixed.bodies[1].joint.mount = foldwing::math::so3::rotation_about(&Vector3::y(), 0.7);
    fixed.bodies[1].joint.kind = JointKind::Clamped;
    let (mut locked, mut fixed) = (start(locked), start(fixed));
    coast(&mut locked, 0.1);
    coast(&mut fixed, 0.1);
    let miss_m = (locked.outputs().tips()[0].position_m - fixed.outputs().tips()[0].position_m).norm();
    assert!(miss_m < 1e-12, "tips differ by {miss_m:.1e} m");
    assert_eq!(only(&locked).angle_rad, 0.7);
    assert_eq!(only(&locked).torque_applied_n_m, 0.0, "no drive acts on a locked joint");
}

/// P-52. A prescribed joint follows its motion, and the energy it supplies is counted as work: P-11 checks the balance.
#[test]
fn p52_prescribed_joint_follows_its_law() {
    let law = |t: f64| 3.0 - 100.0 * t * t + 500.0 * t * t * t;
    let mut machine = default_wing(1e-6);
    hinge_of(&mut machine, 1).motion = JointMotion::Prescribed(Motion::Polynomial(vec![3.0, 0.0, -100.0, 500.0]));
    let mut plant = start(machine);
    run(
        &mut plant,
        0.1,
        73,
        |_| {},
        |outputs| {
            let error_rad = outputs.joints()[0].angle_rad - law(outputs.time_s);
            assert!(
                error_rad.abs() < 1e-9,
                "t = {} s: the angle misses its law by {error_rad:.1e} rad",
                outputs.time_s
            );
        },
    );
    assert!(plant.outputs().energy().work.abs() > 1e-3, "work {} J", plant.outputs().energy().work);
}
