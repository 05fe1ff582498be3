//! A moving root: against gravity, against a rotated model, against the same motion imposed by a joint.

use crate::plant::machines::*;
use foldwing::load::Wrench;
use foldwing::machine::{JointKind, JointMotion, Machine, Motion};
use foldwing::math::so3::rotation_about;
use foldwing::plant::{Outputs, Plant};
use nalgebra::{Matrix3, Unit, Vector3};

/// P-30. A root acceleration `a` is equivalent to gravity minus `a`, bit-identical, because only `g − a` enters.
///
/// The values are dyadic, so `g − a` is exact. Inertial accelerations of the tip differ by exactly `a`.
#[test]
fn p30_root_acceleration_is_changed_gravity() {
    let acceleration = Vector3::new(1.5, -2.0, 0.25);
    let gravity = Vector3::new(-9.5, 0.5, 0.0);
    let mut accelerated = default_wing(1e-4);
    accelerated.gravity_m_s2 = gravity;
    let (mut accelerated, mut heavy) = (start(accelerated.clone()), start(accelerated));
    for i in 1..=150 {
        let share = f64::from(i / 50);
        accelerated.inputs_mut().root_mut().acceleration_m_s2 = acceleration * share;
        heavy.inputs_mut().root_mut().gravity_m_s2 = gravity - acceleration * share;
        coast(&mut accelerated, 1e-3 * f64::from(i));
        coast(&mut heavy, 1e-3 * f64::from(i));
        let (a, b) = (accelerated.outputs(), heavy.outputs());
        assert_eq!(a.joints(), b.joints(), "t = {} s", a.time_s);
        assert_eq!((&a.gauges(), a.root(), a.energy()), (&b.gauges(), b.root(), b.energy()), "t = {} s", a.time_s);
        assert_eq!(a.tips()[0].position_m, b.tips()[0].position_m);
        let difference = a.tips()[0].acceleration_m_s2 - b.tips()[0].acceleration_m_s2 - acceleration * share;
        assert!(difference.norm() < 1e-11 * (1.0 + a.tips()[0].acceleration_m_s2.norm()), "{difference} m/s²");
        let [a, b] = [a, b].map(|outputs| outputs.tips()[0].specific_force_m_s2);
        assert!((a - b).norm() < 1e-11 * (1.0 + a.norm()), "an accelerometer distinguishes {a} from {b} m/s²");
    }
}

/// The wing with stations, a skew fold axis (torsion and both bendings move) and no latch.
fn skew_wing(tolerance: f64) -> Machine {
    let mut machine = default_wing(tolerance);
    let hinge = hinge_of(&mut machine, 1);
    hinge.axis = Vector3::new(0.3, 0.9, 0.2).normalize();
    hinge.start_angle_rad = 1.0;
    hinge.latch = None;
    for body in &mut machine.bodies {
        body.station_positions_m = vec![0.07, 0.15];
        (body.mass_damping_1_s, body.stiffness_damping_s) = (0.0, 2e-5);
    }
    machine
}

/// P-31. Rotating the whole machine and everything that acts on it rotates the results and does not change angles and strains.
///
/// Exact apart from round-off, which the motion and the choice of steps amplify to 1e-9 in 0.1 s.
#[test]
fn p31_turning_the_model_turns_the_answer() {
    let turn = rotation_about(&Vector3::new(1.0, -2.0, 0.5).normalize(), 2.1);
    let plain = skew_wing(1e-5);
    let mut turned = plain.clone();
    turned.bodies[0].joint.mount = turn * plain.bodies[0].joint.mount;
    turned.gravity_m_s2 = turn * plain.gravity_m_s2;
    let (mut plain, mut turned) = (start(plain), start(turned));
    let set = |plant: &mut Plant, turn: &Matrix3<f64>| {
        let inputs = plant.inputs_mut();
        inputs.root_mut().acceleration_m_s2 = turn * Vector3::new(3.0, 1.0, -2.0);
        inputs.root_mut().angular_velocity_rad_s = turn * Vector3::new(-2.0, 4.0, 3.0);
        inputs.root_mut().angular_acceleration_rad_s2 = turn * Vector3::new(10.0, -20.0, 5.0);
        inputs.stations_mut()[1].force_n = turn * Vector3::new(0.1, 0.05, -0.1);
        inputs.stations_mut()[3].moment_n_m = turn * Vector3::new(0.01, 0.005, -0.01);
    };
    set(&mut plain, &Matrix3::identity());
    set(&mut turned, &turn);
    coast(&mut plain, 0.1);
    coast(&mut turned, 0.1);
    let (a, b) = (plain.outputs(), turned.outputs());
    let angle_rad = a.joints()[0].angle_rad - b.joints()[0].angle_rad;
    assert!(angle_rad.abs() < 1e-9, "fold angles differ by {angle_rad:.1e} rad");
    let strain = (a.gauges()[0] - b.gauges()[0]).abs();
    assert!(strain < 1e-9, "strains differ by {strain:.1e}");
    for (what, a, b, unit, limit) in [
        ("tip", a.tips()[0].position_m, b.tips()[0].position_m, "m", 1e-9),
        ("velocity", a.tips()[0].velocity_m_s, b.tips()[0].velocity_m_s, "m/s", 1e-7),
        ("station", a.stations()[2].position_m, b.stations()[2].position_m, "m", 1e-9),
        ("root force", a.root().force_n, b.root().force_n, "N", 1e-6),
        ("root moment", a.root().moment_n_m, b.root().moment_n_m, "N·m", 1e-7),
    ] {
        let miss = (turn * a - b).norm();
        assert!(miss < limit, "{what} misses by {miss:.1e} {unit}");
    }
    // in the section frame, an accelerometer's reading does not rotate with the machine
    for (a, b) in [(&a.tips()[0], &b.tips()[0]), (&a.stations()[2], &b.stations()[2])] {
        let miss = (a.specific_force_m_s2 - b.specific_force_m_s2).norm();
        let size = 1.0 + a.specific_force_m_s2.norm();
        assert!(miss < 1e-7 * size, "specific force misses by {miss:.1e} of {size} m/s²");
    }
}

/// The axis of the spinning tests; gravity lies along it, so that it is the same in both frames.
fn spin_axis() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.3, -0.5, 1.0))
}

/// The same machine on a spinning root (first) and on a rotating joint whose angle is the polynomial `law` (second).
fn spinning_pair(law: Vec<f64>) -> (Plant, Plant) {
    let mut on_root = skew_wing(1e-8);
    on_root.gravity_m_s2 = spin_axis().into_inner() * -4.0;
    let mut on_joint = on_root.clone();
    let mut joint = free_hinge(0.0);
    (joint.axis, joint.motion) = (spin_axis().into_inner(), JointMotion::Prescribed(Motion::Polynomial(law)));
    on_joint.bodies[0].joint.kind = JointKind::Revolute(Box::new(joint));
    (start(on_root), start(on_joint))
}

/// Differences of tip position (m), velocity (m/s), inertial acceleration (m/s²), root force (N) and root moment (N·m) between the frames,
/// the second of which is rotated by `angle_rad` and rotates at `rate_rad_s`; of the fold angle (rad); and of the specific force at the tip in
/// the section frame (m/s²).
fn misses(on_root: &Outputs, on_joint: &Outputs, angle_rad: f64, rate_rad_s: f64) -> [f64; 7] {
    let turn = rotation_about(&spin_axis(), angle_rad);
    let (a, b) = (&on_root.tips()[0], &on_joint.tips()[0]);
    let Wrench { force_n, moment_n_m } = on_root.root();
    let spin = spin_axis().into_inner() * rate_rad_s;
    [
        (turn * a.position_m - b.position_m).norm(),
        (turn * (a.velocity_m_s + spin.cross(&a.position_m)) - b.velocity_m_s).norm(),
        (turn * a.acceleration_m_s2 - b.acceleration_m_s2).norm(),
        (turn * force_n - on_joint.root().force_n).norm(),
        (turn * moment_n_m - on_joint.root().moment_n_m).norm(),
        (on_root.joints()[0].angle_rad - on_joint.joints()[1].angle_rad).abs(),
        (a.specific_force_m_s2 - b.specific_force_m_s2).norm(),
    ]
}

/// P-32. A root at constant spin gives the same motion as a joint at constant rate: centrifugal and Coriolis terms against the engine's
/// ordinary inertia, which has no such terms. Both runs have the error of the tolerance.
#[test]
fn p32_constant_spin_equals_a_turning_joint() {
    let (mut on_root, mut on_joint) = spinning_pair(vec![0.0, 6.0]);
    on_root.inputs_mut().root_mut().angular_velocity_rad_s = spin_axis().into_inner() * 6.0;
    for time_s in [0.02, 0.05, 0.1, 0.15] {
        coast(&mut on_root, time_s);
        coast(&mut on_joint, time_s);
        let misses = misses(on_root.outputs(), on_joint.outputs(), 6.0 * time_s, 6.0);
        println!("t = {time_s} s: misses {misses:?}");
        assert!(misses[0] < 1e-6 && misses[5] < 1e-5, "t = {time_s} s: tip {:.1e} m, {misses:?}", misses[0]);
        assert!(misses[1] < 1e-4 && misses[3] < 3e-3 && misses[4] < 3e-4, "t = {time_s} s: {misses:?}");
        // as for the acceleration, the error is that of the motion times the square of the highest frequency
        let size_m_s2 = on_root.outputs().tips()[0].specific_force_m_s2.norm();
        assert!(
            misses[6] < 1e-3 * size_m_s2,
            "t = {time_s} s: specific force misses by {} of {size_m_s2} m/s²",
            misses[6]
        );
    }
}

/// P-33. A root with increasing spin gives the same motion as a joint with `½ a t²`: the Euler term.
///
/// The root's rate is an input, held at its mean value during each communication step: the difference must fall with the square of the
/// step, down to the integrator's error.
#[test]
fn p33_spinning_up_equals_an_accelerating_joint() {
    const ACCELERATION_RAD_S2: f64 = 80.0;
    let tips_m = [2e-3, 1e-3, 5e-4].map(|step_s: f64| {
        let (mut on_root, mut on_joint) = spinning_pair(vec![0.0, 0.0, 0.5 * ACCELERATION_RAD_S2]);
        let steps = (0.1 / step_s).round() as usize;
        for i in 0..steps {
            let root = on_root.inputs_mut().root_mut();
            let middle_s = (i as f64 + 0.5) * step_s;
            root.angular_velocity_rad_s = spin_axis().into_inner() * (ACCELERATION_RAD_S2 * middle_s);
            root.angular_acceleration_rad_s2 = spin_axis().into_inner() * ACCELERATION_RAD_S2;
            coast(&mut on_root, (i + 1) as f64 * step_s);
        }
        coast(&mut on_joint, 0.1);
        let angle_rad = 0.5 * ACCELERATION_RAD_S2 * 0.01;
        let misses = misses(on_root.outputs(), on_joint.outputs(), angle_rad, ACCELERATION_RAD_S2 * 0.1);
        println!("step {step_s} s: misses {misses:?}");
        misses[0]
    });
    let order = (tips_m[1] / tips_m[2]).log2();
    assert!(tips_m[2] < 1e-5, "tip misses by {:.1e} m", tips_m[2]);
    assert!(order > 1.7 || tips_m[2] < 1e-7, "misses {tips_m:?} m fall with order {order:.2}");
}
