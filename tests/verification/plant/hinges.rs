//! Torques about a hinge: the motor's torque, a joint that is locked again, a latch that closes on a motionless joint.

use crate::plant::corners::{rod, rod_inertia_kg_m2};
use crate::plant::machines::*;
use foldwing::machine::*;
use foldwing::plant::{Holding, JointOutputs, Plant};
use nalgebra::Vector3;

fn only(plant: &Plant) -> JointOutputs {
    plant.outputs().joints()[0]
}

/// AT-01. The torque limit applies only to the motor: an external torque of −1 N·m and a motor limited to 0.02 N·m accelerate the rod by
/// −1.02 N·m divided by its inertia. The total used to be limited to −0.02 N·m.
#[test]
fn at01_the_limit_leaves_the_external_torque_alone() {
    let mut revolute = free_hinge(0.5);
    revolute.motor = Motor { constant_torque_n_m: 5.0, torque_limit_n_m: 0.02, ..Motor::default() };
    let mut plant = Plant::new(std::sync::Arc::new(rod(revolute)));
    plant.inputs_mut().joints_mut()[0].torque_n_m = -1.0;
    plant.initialize(0.0).expect("initial accelerations");
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, 0.01);
    let joint = only(&plant);
    let torques = [joint.motor_torque_n_m, joint.external_torque_n_m, joint.torque_applied_n_m];
    assert_eq!(torques, [-0.02, -1.0, -1.02]);
    let expected_rad = -0.5 * 1.02 / rod_inertia_kg_m2() * 1e-4;
    let error_rad = joint.angle_rad - 0.5 - expected_rad;
    // the rod bends by 1e-5 of the rotation
    assert!(error_rad.abs() < 1e-4 * expected_rad.abs(), "turned by {error_rad:.1e} rad more than {expected_rad} rad");
    let drift_j = balance_j(plant.outputs()) - before_j;
    assert!(drift_j.abs() < 1e-4 * plant.outputs().energy().kinetic, "energy drifts by {drift_j:.1e} J");
}

/// AT-02. On the spring of a joint, the rod oscillates about its neutral angle at `√(k/J)`; the motor's limit does not apply to the spring,
/// and the joint's damper dissipates energy. In equilibrium under an external torque `τ` the angle is `θ_0 + τ/k`.
#[test]
fn at02_a_spring_of_the_joint_itself() {
    let spring = Spring { stiffness_n_m_rad: 0.5, damping_n_m_s_rad: 0.0, rest_angle_rad: 0.2 };
    let mut revolute = free_hinge(0.3);
    revolute.motor = Motor { torque_limit_n_m: 1e-6, ..Motor::default() };
    revolute.spring = Some(spring);
    let mut plant = start(rod(revolute.clone()));
    let stored_j = plant.outputs().energy().elastic;
    assert!((stored_j - 0.5 * 0.5 * 0.01).abs() < 1e-12, "stored {stored_j} J");
    let half_s = std::f64::consts::PI / (0.5 / rod_inertia_kg_m2()).sqrt();
    coast(&mut plant, half_s);
    let error_rad = only(&plant).angle_rad - 0.1;
    assert!(error_rad.abs() < 2e-5, "half a swing ends {error_rad:.1e} rad off 0.1 rad");
    assert!((only(&plant).spring_torque_n_m + 0.5 * (only(&plant).angle_rad - 0.2)).abs() < 1e-12);

    plant.parameters_mut().joints_mut()[0].spring_damping_n_m_s_rad = 0.002;
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, half_s + 0.5);
    let drift_j = balance_j(plant.outputs()) - before_j;
    assert!(drift_j.abs() < 1e-4 * stored_j, "energy drifts by {drift_j:.1e} J of {stored_j:.1e} J");
    assert!(plant.outputs().energy().dissipated > 0.9 * stored_j, "{:?}", plant.outputs().energy());

    let mut still = Plant::new(std::sync::Arc::new(rod(revolute)));
    still.inputs_mut().joints_mut()[0].torque_n_m = 0.1;
    still.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let error_rad = only(&still).angle_rad - 0.4;
    assert!(error_rad.abs() < 1e-9, "rests {error_rad:.1e} rad off 0.4 rad");
    let frequency_hz = still.study().modes(1).expect("modes")[0].frequency_hz;
    let expected_hz = 0.5 / half_s;
    assert!((frequency_hz / expected_hz - 1.0).abs() < 1e-4, "{frequency_hz} Hz, expected {expected_hz} Hz");
}

/// AT-03. Release reset to false stops a rotating rod: all its energy is dissipated, the lock carries the load, and the joint is free again
/// when released again. The input used to be ignored.
#[test]
fn at03_release_taken_back_holds_the_joint_where_it_is() {
    let mut revolute = free_hinge(0.5);
    revolute.start_rate_rad_s = -3.0;
    let mut plant = start(rod(revolute));
    // most of the energy first goes into bending and is damped there: the balance of that decay has an error of 3 % at 1e-4
    plant.parameters_mut().solver_mut().tolerance = 1e-8;
    coast(&mut plant, 0.1);
    let (kinetic_j, angle_rad) = (plant.outputs().energy().kinetic, only(&plant).angle_rad);
    let (before_j, dissipated_j) = (balance_j(plant.outputs()), plant.outputs().energy().dissipated);
    plant.inputs_mut().joints_mut()[0].release = false.into();
    coast(&mut plant, 0.15);
    let dissipated_j = plant.outputs().energy().dissipated - dissipated_j;
    assert!((dissipated_j / kinetic_j - 1.0).abs() < 2e-3, "{dissipated_j} J of {kinetic_j} J");
    let drift_j = balance_j(plant.outputs()) - before_j;
    assert!(drift_j.abs() < 2e-3 * kinetic_j, "energy drifts by {drift_j:.1e} J");
    plant.inputs_mut().joints_mut()[0].torque_n_m = 0.7;
    coast(&mut plant, 0.2);
    let joint = only(&plant);
    assert_eq!((joint.angle_rad, joint.rate_rad_s), (angle_rad, 0.0));
    assert!((joint.holding_torque_n_m + 0.7).abs() < 1e-3, "holds with {} N·m", joint.holding_torque_n_m);
    plant.inputs_mut().joints_mut()[0].release = true.into();
    coast(&mut plant, 0.21);
    assert!(only(&plant).rate_rad_s > 1.0 && only(&plant).holding_torque_n_m == 0.0, "{:?}", only(&plant));
}

/// AT-04. Locking an elbow while two rods rotate is an inelastic stop of that joint alone: the angular momentum about the shoulder is
/// conserved, and the energy lost is `½ M_eff θ̇²`, both in closed form for rods in line.
#[test]
fn at04_a_stop_keeps_the_momentum_about_the_joints_that_stay_free() {
    let mut shoulder = free_hinge(0.0);
    shoulder.start_rate_rad_s = 2.0;
    let mut machine = rod(shoulder);
    let mut elbow = free_hinge(0.0);
    elbow.start_rate_rad_s = 5.0;
    let mut outer = machine.bodies[0].clone();
    let parent = Parent::Body { index: 0, position_m: outer.length_m };
    let kind = JointKind::Revolute(Box::new(elbow));
    (outer.name, outer.joint) = ("outer".into(), Joint { name: "elbow".into(), parent, kind, ..outer.joint });
    machine.bodies.push(outer);
    let mut plant = start(machine);
    let kinetic_j = plant.outputs().energy().kinetic;
    plant.inputs_mut().joints_mut()[1].release = false.into();
    coast(&mut plant, 1e-9);
    let (length_m, mass_kg) = (0.15, 1425.0 * 0.02 * 0.01 * 0.15);
    let about_middle = mass_kg * (f64::powi(length_m, 2) + 0.01f64.powi(2)) / 12.0;
    let momentum = |shoulder: f64, elbow: f64| {
        let middle_m_s = shoulder * length_m + (shoulder + elbow) * 0.5 * length_m;
        rod_inertia_kg_m2() * shoulder + mass_kg * 1.5 * length_m * middle_m_s + about_middle * (shoulder + elbow)
    };
    let expected_rad_s = momentum(2.0, 5.0) / momentum(1.0, 0.0);
    // strain rates jump too: the rods are stiff, but an impulse does not depend on stiffness
    let rates: Vec<f64> = plant.outputs().joints().iter().map(|joint| joint.rate_rad_s).collect();
    println!("rates {rates:?} rad/s, rigid rods {expected_rad_s} rad/s");
    assert_eq!(rates[1], 0.0);
    let lost_j = kinetic_j - plant.outputs().energy().kinetic;
    assert!((plant.outputs().energy().dissipated - lost_j).abs() < 1e-9 * kinetic_j, "lost {lost_j} J");
    // once bending has decayed the rods rotate as one
    coast(&mut plant, 0.2);
    let error_rad_s = plant.outputs().joints()[0].rate_rad_s - expected_rad_s;
    assert!(error_rad_s.abs() < 1e-3 * expected_rad_s, "turns {error_rad_s:.1e} rad/s off {expected_rad_s} rad/s");
}

/// AT-05. A wing released at initialisation and locked before its first step stays at its start angle.
#[test]
fn at05_held_before_the_first_step() {
    let mut plant = start(default_wing(1e-4));
    plant.inputs_mut().joints_mut()[0].release = false.into();
    coast(&mut plant, 0.1);
    assert_eq!((only(&plant).angle_rad, only(&plant).rate_rad_s), (170f64.to_radians(), 0.0));
    assert!(!plant.joint_statuses().next().expect("a joint").released);
}

/// AT-06. An enabled latch catches a wing at the latch angle: at the start, locked there, approached slowly, from either side. In all these
/// cases the latch used to stay open.
#[test]
fn at06_a_latch_catches_what_rests_at_its_angle() {
    const DEFAULT_RAD: f64 = 1e-6;
    let latched = Latch { capture_rad: DEFAULT_RAD, ..latch(2.0) };
    let with = |start_rad: f64, change: &dyn Fn(&mut Revolute)| {
        let mut revolute = free_hinge(start_rad);
        revolute.latch = Some(latched.clone());
        change(&mut revolute);
        start(rod(revolute))
    };
    for start_rad in [0.0, 0.9e-6, -0.9e-6] {
        let plant = with(start_rad, &|_| ());
        assert!(latch_of(&plant).closed.is_on() && latch_of(&plant).count.get() == 0, "starts at {start_rad} rad");
        let held = with(start_rad, &|revolute| revolute.release = false);
        assert!(latch_of(&held).closed.is_on(), "held at {start_rad} rad");
    }
    for start_rad in [0.3, -0.3] {
        let mut creeps = with(start_rad, &|revolute| {
            revolute.motor = Motor { stiffness_n_m_rad: 0.3, damping_n_m_s_rad: 0.2, ..Motor::default() };
        });
        coast(&mut creeps, 15.0);
        let expected_s = 0.2 / 0.3 * (0.3 / DEFAULT_RAD).ln();
        let error_s = latch_of(&creeps).time_s - expected_s;
        // effect of the rod's inertia, 1e-3 s of the time constant, and of the tolerance of 1e-6 at an angle of 1e-6 rad
        assert!(error_s.abs() < 1.0, "creeps from {start_rad} rad: closed {error_s} s off {expected_s} s");
        assert!(latch_of(&creeps).closed.is_on());
        let mut passes = with(start_rad, &|revolute| revolute.start_rate_rad_s = -10.0 * start_rad);
        coast(&mut passes, 0.2);
        let error_s = latch_of(&passes).time_s - 0.1 * (0.3 - DEFAULT_RAD) / 0.3;
        assert!(error_s.abs() < 1e-8, "passes from {start_rad} rad: closed {error_s:.1e} s off");
    }
}

/// AT-07. A joint caught off the latch angle starts to oscillate about it: the energy stored in the latch at closing is counted as work,
/// the energy stored at opening as dissipated, term by term.
#[test]
fn at07_energy_of_a_latch_that_closes_and_opens_off_its_angle() {
    let mut revolute = free_hinge(0.3);
    revolute.start_rate_rad_s = -3.0;
    revolute.latch = Some(Latch { capture_rad: 0.1, ..latch(2.0) });
    let mut plant = start(rod(revolute));
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, 0.08);
    assert!(latch_of(&plant).closed.is_on(), "closes at the window's edge");
    let closed_s = 0.2 / 3.0;
    assert!((latch_of(&plant).time_s - closed_s).abs() < 1e-7, "at {} s", latch_of(&plant).time_s);
    let booked_j = plant.outputs().energy().work;
    assert!((booked_j - 0.5 * 2.0 * 0.01).abs() < 1e-8, "booked {booked_j} J");
    let (stored_j, dissipated_j) = (0.5 * 2.0 * only(&plant).angle_rad.powi(2), plant.outputs().energy().dissipated);
    plant.inputs_mut().joints_mut()[0].latch_enable = false.into();
    coast(&mut plant, 0.08 + 1e-9);
    let jump_j = plant.outputs().energy().dissipated - dissipated_j;
    // within the instant the rod rotates by 1e-8 rad
    assert!((jump_j / stored_j - 1.0).abs() < 1e-5, "dissipated {jump_j} J of {stored_j} J");
    // drift of the integration at its default tolerance, through an oscillation
    let drift_j = balance_j(plant.outputs()) - before_j;
    assert!(drift_j.abs() < 1e-4 * booked_j, "energy drifts by {drift_j:.1e} J");
}

/// A swinging wing with a motor and no latch: number of Newton iterations in 1 s, drift of the energy relative to the largest kinetic
/// energy, angle at the end.
fn swing(drive: Motor, start_deg: f64, method: Method, tolerance: f64) -> (u64, f64, f64) {
    let mut machine = wing(ElementKind::Linear, 4, method, tolerance);
    let hinge = hinge_of(&mut machine, 1);
    (hinge.start_angle_rad, hinge.motor, hinge.latch) = (start_deg.to_radians(), drive, None);
    let mut plant = start(machine);
    let first_j = balance_j(plant.outputs());
    let (mut drift_j, mut kinetic_j) = (0.0f64, 0.0f64);
    run(
        &mut plant,
        1.0,
        100,
        |_| {},
        |outputs| {
            drift_j = drift_j.max((balance_j(outputs) - first_j).abs());
            kinetic_j = kinetic_j.max(outputs.energy().kinetic);
        },
    );
    (plant.statistics().iterations, drift_j / kinetic_j, only(&plant).angle_rad)
}

/// AT-08. A torque limit costs at most three times the residual evaluations of the run without it: a stiff motor that saturates, and dry
/// friction modelled by a damper with a limit, which slips and sticks. It used to be up to 700 times.
#[test]
fn at08_a_torque_limit_is_cheap() {
    let drive = |stiffness_n_m_rad, damping_n_m_s_rad, constant_torque_n_m| Motor {
        stiffness_n_m_rad,
        damping_n_m_s_rad,
        constant_torque_n_m,
        ..Motor::default()
    };
    let cases = [
        (drive(20.0, 0.5, 0.0), 60.0, 0.02),
        (drive(50.0, 1.0, 0.0), 60.0, 0.02),
        (drive(0.0, 100.0, 0.05), 170.0, 0.02),
        (drive(0.0, 100.0, 0.0), 60.0, 0.005),
    ];
    let alpha = Method::GeneralizedAlpha;
    for (free, start_deg, torque_limit_n_m) in cases {
        let limited = Motor { torque_limit_n_m, ..free.clone() };
        for method in [Method::Esdirk4, Method::Esdirk3, Method::TrBdf2, Method::Sdirk2, alpha] {
            let (without, ..) = swing(free.clone(), start_deg, method, 1e-4);
            let (with, drift, angle_rad) = swing(limited.clone(), start_deg, method, 1e-4);
            let (times, k) = (with as f64 / without as f64, free.stiffness_n_m_rad);
            println!(
                "{method:?}, k = {k}: {times:.2} times {without} residuals, drift {drift:.1e}, ends at {angle_rad:.4} rad"
            );
            assert!(times <= 3.0, "{method:?}, k = {k}: {times} times the residuals of the run without limit");
        }
    }
}

/// AT-09. Inertial acceleration of a tip at rest in inertial space while the spin of the root increases: zero. The rod is on a free hinge
/// about the axis of spin, so its acceleration relative to the root is opposite to the Euler term.
#[test]
fn at09_euler_term_of_a_tip_s_acceleration() {
    let mut revolute = free_hinge(0.0);
    revolute.axis = Vector3::z();
    let mut plant = Plant::new(std::sync::Arc::new(rod(revolute)));
    plant.inputs_mut().root_mut().angular_acceleration_rad_s2 = Vector3::new(0.0, 0.0, 7.0);
    plant.initialize(0.0).expect("initial accelerations");
    let acceleration_m_s2 = plant.outputs().tips()[0].acceleration_m_s2.norm();
    // round-off of the relative acceleration, through the rod's elastic coordinates
    assert!(acceleration_m_s2 < 1e-9 * 7.0 * 0.15, "{acceleration_m_s2} m/s²");
}

/// AT-10. The moment of a ball joint's damper decelerates the body: it is `−c ω`, and the rate decays as `exp(−c t/J)`.
#[test]
fn at10_moment_of_a_ball_joint_s_damper() {
    let (damping_n_m_s_rad, rate_rad_s) = (1e-3, 4.0);
    let mut machine = rod(free_hinge(0.0));
    machine.bodies[0].joint.kind = JointKind::Spatial(Box::new(Spatial {
        freedom: SpatialFreedom::Ball,
        stiffness_n_m_rad: 0.0,
        damping_n_m_s_rad,
        start_angular_velocity_rad_s: Vector3::new(0.0, rate_rad_s, 0.0),
        start_velocity_m_s: Vector3::zeros(),
    }));
    let mut plant = start(machine);
    let moment_n_m = plant.outputs().joint_reactions()[0].moment_n_m;
    let error_n_m = (moment_n_m - Vector3::new(0.0, -damping_n_m_s_rad * rate_rad_s, 0.0)).norm();
    assert!(error_n_m < 1e-12, "{moment_n_m:?} N·m");
    coast(&mut plant, 0.2);
    let expected_rad_s = rate_rad_s * (-damping_n_m_s_rad * 0.2 / rod_inertia_kg_m2()).exp();
    let error_rad_s = plant.outputs().spatial()[0].angular_velocity_rad_s.y - expected_rad_s;
    assert!(error_rad_s.abs() < 1e-3 * rate_rad_s, "turns {error_rad_s:.1e} rad/s off {expected_rad_s} rad/s");
}
