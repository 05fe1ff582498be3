//! Loss, jam or runaway of motors; latches that break or do not close; a lock that opens.

use crate::breaking::*;
use crate::plant::machines::default_wing;
use foldwing::machine::builder::JointBuilder;
use foldwing::machine::{Beyond, Effect, Failure, GeneratorLaw, Latch, Motor, Spring};

/// Instant inside a communication step, when the rotor moves at about −4 rad/s.
const FAILS_S: f64 = 0.123_456_789;

/// Angle and rate of the rotor on the spring of its motor.
fn swinging(time_s: f64) -> (f64, f64) {
    let phase = FREQUENCY_RAD_S * time_s;
    (START_RAD * phase.cos(), -START_RAD * FREQUENCY_RAD_S * phase.sin())
}

/// FL-02. After the loss of its motor at a given time the rotor coasts; the energy of the motor's spring is dissipated, and the result is
/// bit-identical for all communication steps.
#[test]
fn fl02_a_motor_loss_at_its_time() {
    let (angle_rad, rate_rad_s) = swinging(FAILS_S);
    let mut ends = Vec::new();
    for steps in [1, 7, 1000] {
        let mut plant = begun(sprung, Failure::motor_loss("motor", "hinge").at_time_s(FAILS_S));
        let drift = drift_j(&mut plant, 0.5, steps);
        let found = plant.outputs().joints()[0];
        assert_eq!(failed_s(&plant, 0), Some(FAILS_S));
        let coasted_rad = angle_rad + rate_rad_s * (0.5 - FAILS_S);
        let misses = [found.angle_rad - coasted_rad, found.rate_rad_s - rate_rad_s];
        assert!(misses[0].abs() < 1e-8 && misses[1].abs() < 1e-7, "{steps} steps: {misses:?}");
        assert!(drift < 1e-8, "energy account drifts by {drift:e} J");
        let spring_j = 0.5 * INERTIA_KG_M2 * (FREQUENCY_RAD_S * angle_rad).powi(2);
        let dissipated_j = plant.outputs().energy().dissipated;
        assert!((dissipated_j - spring_j).abs() < 1e-8, "{dissipated_j} J of {spring_j} J in the spring");
        assert_eq!(found.motor_torque_n_m, 0.0);
        ends.push([found.angle_rad, found.rate_rad_s, dissipated_j].map(f64::to_bits));
    }
    assert!(ends[0] == ends[1] && ends[1] == ends[2], "the communication step changes bits");
}

/// FL-03. The failure's input triggers the same at a communication point, and nothing reverses it.
#[test]
fn fl03_a_motor_loss_on_its_input() {
    let end = |by_input: bool| {
        let failure = Failure::motor_loss("motor", "hinge");
        let failure = if by_input { failure } else { failure.at_time_s(0.12) };
        let mut plant = begun(sprung, failure);
        assert!(drift_j(&mut plant, 0.12, 12) < 1e-8);
        if by_input {
            trigger(&mut plant, 0);
        }
        drift_j(&mut plant, 0.2, 8);
        plant.inputs_mut().failures_mut()[0] = false.into();
        drift_j(&mut plant, 0.5, 30);
        assert_eq!(failed_s(&plant, 0), Some(0.12));
        plant.outputs().joints()[0]
    };
    let (by_input, at_time) = (end(true), end(false));
    assert!((by_input.angle_rad - at_time.angle_rad).abs() < 1e-9);
    assert!((by_input.rate_rad_s - at_time.rate_rad_s).abs() < 1e-9);
}

/// FL-09. Loss of the grid: with the loss of its motor the joint also loses the torque of its generator, whatever the input of the
/// generator. The rotor coasts from then on; until then the energy balance contains the mechanical, not the electrical, power of the
/// generator. A jammed motor holds the rotor against the generator, which gives no power at standstill.
#[test]
fn fl09_the_grid_is_lost() {
    let torque_n_m = 0.03;
    let generating = |joint: JointBuilder| {
        let law = GeneratorLaw {
            gear_ratio: 2.0,
            rows: vec![[1.0, torque_n_m], [50.0, torque_n_m]],
            square_gain_n_m_s2: None,
            beyond: Beyond::Torque,
            efficiency: 0.8,
            connected: true,
        };
        joint.generator(law).start_rate_rad_s(4.0)
    };
    let lost_s = 0.123_456_789;
    let mut plant = begun(generating, Failure::motor_loss("grid", "hinge").at_time_s(lost_s));
    let before = plant.outputs().generators()[0];
    assert_eq!((before.torque_n_m, before.power_w), (torque_n_m, 0.8 * torque_n_m * 8.0));
    assert!(drift_j(&mut plant, 0.5, 50) < 1e-9);
    let rate_rad_s = 4.0 - 2.0 * torque_n_m / INERTIA_KG_M2 * lost_s;
    let found = plant.outputs().joints()[0];
    assert!((found.rate_rad_s - rate_rad_s).abs() < 1e-9, "{} of {rate_rad_s} rad/s", found.rate_rad_s);
    let after = plant.outputs().generators()[0];
    assert_eq!((after.torque_n_m, after.power_w), (0.0, 0.0));
    // energy lost by the rotor, all of it work on the generator
    let work_j = 0.5 * INERTIA_KG_M2 * (rate_rad_s.powi(2) - 16.0);
    assert!((plant.outputs().energy().work - work_j).abs() < 1e-9, "{} of {work_j} J", plant.outputs().energy().work);
    plant.inputs_mut().joints_mut()[0].generator_on = true.into();
    drift_j(&mut plant, 0.6, 5);
    assert_eq!(plant.outputs().generators()[0].torque_n_m, 0.0, "nothing repairs it");

    let mut jammed = begun(generating, Failure::motor_jam("jam", "hinge").at_time_s(lost_s));
    assert!(drift_j(&mut jammed, 0.5, 50) < 1e-9);
    assert_eq!(jammed.outputs().joints()[0].rate_rad_s, 0.0);
    assert_eq!(jammed.outputs().generators()[0].power_w, 0.0);
}

/// FL-04. A jam stops the joint where it is, even if the joint is released, and its kinetic energy is lost.
#[test]
fn fl04_a_drive_jams() {
    let mut plant = begun(sprung, Failure::motor_jam("jam", "hinge").at_time_s(FAILS_S));
    assert!(drift_j(&mut plant, 0.4, 13) < 1e-8);
    let (angle_rad, rate_rad_s) = swinging(FAILS_S);
    let kinetic_j = 0.5 * INERTIA_KG_M2 * rate_rad_s * rate_rad_s;
    assert!((plant.outputs().energy().dissipated - kinetic_j).abs() < 1e-8);
    for release in [false, true] {
        plant.inputs_mut().joints_mut()[0].release = release.into();
        drift_j(&mut plant, if release { 0.6 } else { 0.5 }, 3);
        let found = plant.outputs().joints()[0];
        assert!((found.angle_rad - angle_rad).abs() < 1e-9 && found.rate_rad_s == 0.0, "{found:?}");
    }
}

/// FL-05. A runaway motor moves its neutral angle independently of the command.
#[test]
fn fl05_a_drive_runs_away() {
    let damped =
        |joint: JointBuilder| joint.motor(Motor { stiffness_n_m_rad: 4.0, damping_n_m_s_rad: 0.5, ..Motor::default() });
    let mut plant = begun(damped, Failure::motor_runaway("runaway", "hinge", -2.0, 5.0).at_time_s(0.1));
    let mut worst = 0.0f64;
    for i in 1..=150 {
        let time_s = 0.01 * f64::from(i);
        plant.inputs_mut().joints_mut()[0].command_rad = if i > 30 { 1.0 } else { 0.0 };
        worst = worst.max(drift_j(&mut plant, time_s, 1));
        let neutral_rad = -(5.0 * (time_s - 0.1)).clamp(0.0, 2.0);
        assert!((plant.outputs().joints()[0].neutral_angle_rad - neutral_rad).abs() < 1e-12, "at {time_s} s");
    }
    assert!(worst < 1e-7, "energy account drifts by {worst:e} J in a step");
    assert!((plant.outputs().joints()[0].angle_rad + 2.0).abs() < 1e-3);
}

/// FL-06. A broken latch dissipates its energy and does not close again; a latch that fails to close lets the joint pass.
#[test]
fn fl06_latches_break_and_do_not_catch() {
    let wing = |effect: Option<(Effect, f64)>| {
        let mut machine = default_wing(1e-6);
        machine.failures = Vec::from_iter(effect.map(|(effect, at_s)| Failure {
            name: "latch".to_owned(),
            effect,
            at_time_s: Some(at_s),
            after: None,
            when: None,
            delay_s: 0.0,
        }));
        assert!(machine.validate().is_empty());
        let mut plant = start(machine);
        let drift = drift_j(&mut plant, 0.4, 200);
        (drift, plant)
    };
    let (_, sound) = wing(None);
    assert!(sound.outputs().latches()[0].closed.is_on());
    let (drift, broken) = wing(Some((Effect::LatchBreak { body: 1 }, 0.2)));
    let latch = broken.outputs().latches()[0];
    assert!(!latch.closed.is_on() && latch.count.get() == 1 && latch.time_s < 0.2, "{latch:?}");
    assert!(drift < 1e-4, "energy account drifts by {drift:e} J");
    let (drift, uncaught) = wing(Some((Effect::LatchNoCapture { body: 1 }, 0.05)));
    let latch = uncaught.outputs().latches()[0];
    assert!(!latch.closed.is_on() && latch.count.get() == 0, "{latch:?}");
    let least_rad = uncaught.outputs().joints()[0].angle_rad;
    assert!(drift < 1e-4 && least_rad < 0.0, "energy account drifts by {drift:e} J; at {least_rad} rad");
}

/// FL-07. The lock of a joint opens and never holds the joint again.
#[test]
fn fl07_a_stopper_opens() {
    let held = |joint: JointBuilder| sprung(joint).release(false);
    let mut plant = begun(held, Failure::lock_release("link", "hinge").at_time_s(FAILS_S));
    assert!(drift_j(&mut plant, 0.5, 17) < 1e-8);
    let (angle_rad, rate_rad_s) = swinging(0.5 - FAILS_S);
    let found = plant.outputs().joints()[0];
    assert!((found.angle_rad - angle_rad).abs() < 1e-8 && (found.rate_rad_s - rate_rad_s).abs() < 1e-7, "{found:?}");
}

/// FL-08. Failures already present at the start: triggered by a time in the past, by an input, or by another failure that has occurred.
#[test]
fn fl08_failures_may_be_there_at_the_start() {
    let failures = [
        Failure::motor_loss("motor", "hinge").at_time_s(-1.0),
        Failure::motor_jam("jam", "hinge").after("motor"),
        Failure::latch_no_capture("latch", "hinge"),
        Failure::spring_break("spring", "hinge", 0.5).after("latch").delay_s(0.25),
    ];
    let spring = Spring { stiffness_n_m_rad: 1.0, ..Spring::default() };
    let joint = |joint: JointBuilder| sprung(joint).spring(spring).latch(Latch::rigid().angle_rad(START_RAD));
    let mut plant = Plant::new(std::sync::Arc::new(rotor(joint, &failures)));
    trigger(&mut plant, 2);
    plant.initialize(0.0).expect("starts");
    assert_eq!([0, 1, 2, 3].map(|i| failed_s(&plant, i)), [Some(0.0), Some(0.0), Some(0.0), None]);
    assert!(!plant.outputs().latches()[0].closed.is_on());
    assert!(drift_j(&mut plant, 1.0, 10) < 1e-12);
    assert_eq!(failed_s(&plant, 3), Some(0.25));
    let found = plant.outputs().joints()[0];
    assert_eq!((found.angle_rad, found.rate_rad_s, found.motor_torque_n_m), (START_RAD, 0.0, 0.0));
    assert_eq!(found.spring_torque_n_m, -0.5 * START_RAD);
}
