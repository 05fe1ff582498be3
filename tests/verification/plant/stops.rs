//! End stops at the ends of a joint's range: impacts in closed form, energies, equilibrium, rejected values.

use crate::agreement::agree;
use crate::plant::machines::*;
use foldwing::machine::builder::JointBuilder;
use foldwing::machine::*;
use foldwing::plant::{Holding, Plant};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

const INERTIA_KG_M2: f64 = 0.02;
/// Half-period of a contact without damper: 10 ms.
const FREQUENCY_RAD_S: f64 = 100.0 * PI;
const LOWER_RAD: f64 = -0.4;
const UPPER_RAD: f64 = 0.7;
const RATE_RAD_S: f64 = 3.0;

/// End stops with a fraction of critical damping.
fn stops(ratio: f64) -> EndStops {
    EndStops {
        lower_rad: Some(LOWER_RAD),
        upper_rad: Some(UPPER_RAD),
        stiffness_n_m_rad: INERTIA_KG_M2 * FREQUENCY_RAD_S.powi(2),
        damping_n_m_s_rad: 2.0 * ratio * INERTIA_KG_M2 * FREQUENCY_RAD_S,
    }
}

/// A rotor on a hinge without gravity.
fn rotor(change: impl Fn(JointBuilder) -> JointBuilder) -> Machine {
    let body = Body::rigid("rotor").inertia(1.0, [0.0; 3], Matrix3::identity() * INERTIA_KG_M2);
    let mut machine = machine([(body, change(Joint::revolute("hinge", Vector3::y())))]);
    machine.solver.tolerance = 1e-9;
    machine
}

/// Angle and rate after `time_s` of free flights and contacts starting at angle 0, in closed form: a contact ends when the sum of spring
/// and damper force vanishes, at `ω_d t = π − 2 asin ζ`, with `exp(−ζ/√(1 − ζ²) (π − 2 asin ζ))` of the initial speed.
fn bounced(ratio: f64, mut time_s: f64) -> (f64, f64, usize) {
    let (mut angle_rad, mut rate_rad_s, mut impacts) = (0.0, RATE_RAD_S, 0);
    let damped_rad_s = FREQUENCY_RAD_S * (1.0 - ratio * ratio).sqrt();
    let contact_s = (PI - 2.0 * ratio.asin()) / damped_rad_s;
    loop {
        let end_rad = if rate_rad_s > 0.0 { UPPER_RAD } else { LOWER_RAD };
        let flight_s = (end_rad - angle_rad) / rate_rad_s;
        if time_s <= flight_s {
            return (angle_rad + rate_rad_s * time_s, rate_rad_s, impacts);
        }
        time_s -= flight_s;
        impacts += 1;
        let beyond = |t: f64| {
            let (decay, (sin, cos)) = ((-ratio * FREQUENCY_RAD_S * t).exp(), (damped_rad_s * t).sin_cos());
            let depth = rate_rad_s / damped_rad_s * decay * sin;
            (depth, decay * rate_rad_s * (cos - ratio * FREQUENCY_RAD_S / damped_rad_s * sin))
        };
        let (depth, rate) = beyond(time_s.min(contact_s));
        (angle_rad, rate_rad_s) = (end_rad + depth, rate);
        if time_s <= contact_s {
            return (angle_rad, rate_rad_s, impacts);
        }
        time_s -= contact_s;
    }
}

/// Largest errors of angle and rate, and of the energy balance in J, over free flights and contacts at a tolerance.
fn misses(ratio: f64, end_s: f64, steps: u32, tolerance: f64) -> [f64; 3] {
    let mut machine = rotor(|joint| joint.end_stops(stops(ratio)).start_rate_rad_s(RATE_RAD_S));
    machine.solver.tolerance = tolerance;
    let mut plant = start(machine);
    let before_j = balance_j(plant.outputs());
    let (mut worst, mut most) = ([0.0f64; 3], 0);
    for i in 1..=steps {
        let time_s = end_s * f64::from(i) / f64::from(steps);
        coast(&mut plant, time_s);
        let (angle_rad, rate_rad_s, impacts) = bounced(ratio, time_s);
        let found = &plant.outputs().joints()[0];
        worst[0] = worst[0].max((found.angle_rad - angle_rad).abs());
        worst[1] = worst[1].max((found.rate_rad_s - rate_rad_s).abs());
        worst[2] = worst[2].max((balance_j(plant.outputs()) - before_j).abs());
        most = most.max(impacts);
    }
    assert!(most >= if ratio < 0.1 { 5 } else { 2 }, "{most} impacts");
    assert!(plant.statistics().events >= 2 * (most as u64 - 1), "{:?}", plant.statistics());
    worst
}

/// ST-01. A rotor moves to and fro between its stops: angle and rate through impacts on either side, with dampers of 0, 5, 40 % of critical
/// damping and communication steps of any length; the energy balance closes. Errors of the angle fall with the tolerance.
#[test]
fn st01_impacts_follow_the_closed_form() {
    for (ratio, end_s) in [(0.0, 3.0), (0.05, 3.0), (0.4, 4.0)] {
        for steps in [3000, 37] {
            let [coarse, fine] = [1e-9, 1e-11].map(|tolerance| misses(ratio, end_s, steps, tolerance));
            println!("ST-01 {ratio}, {steps} steps: {coarse:?}, {fine:?} rad, rad/s, J of 0.09 J");
            // about a thousand steps with errors of 1e-11 each; errors of the rate are larger by the frequency of the contact
            assert!(fine[0] < 1e-6 && fine[1] < 1e-4 && fine[2] < 1e-7, "{fine:?}");
            assert!(fine[0] < 0.1 * coarse[0], "{coarse:?} {fine:?}");
        }
    }
}

/// ST-02. A rotor that starts inside its stop is pushed out by the energy stored there; if it moves out faster than the stop can follow,
/// the stop does not pull it back, and the stored energy is dissipated.
#[test]
fn st02_starts_beyond_an_end() {
    let depth_rad = 0.01;
    let stored_j = 0.5 * stops(0.0).stiffness_n_m_rad * depth_rad * depth_rad;
    for (angle_rad, sign) in [(UPPER_RAD + depth_rad, -1.0), (LOWER_RAD - depth_rad, 1.0)] {
        let mut plant = start(rotor(|joint| joint.end_stops(stops(0.0)).start_angle_rad(angle_rad)));
        assert!((plant.outputs().energy().elastic - stored_j).abs() < 1e-12);
        coast(&mut plant, 0.05);
        let found = plant.outputs();
        assert!((found.joints()[0].rate_rad_s - sign * FREQUENCY_RAD_S * depth_rad).abs() < 1e-5, "{found:?}");
        assert!((found.energy().kinetic - stored_j).abs() < 1e-6 && found.energy().elastic == 0.0);

        let leaving = rotor(|joint| {
            joint
                .end_stops(stops(0.5))
                .start_angle_rad(angle_rad)
                .start_rate_rad_s(sign * FREQUENCY_RAD_S * 3.0 * depth_rad)
        });
        let mut plant = start(leaving);
        coast(&mut plant, 0.02);
        let found = plant.outputs();
        let rate_rad_s = sign * FREQUENCY_RAD_S * 3.0 * depth_rad;
        assert!((found.joints()[0].rate_rad_s - rate_rad_s).abs() < 1e-12, "nothing pulls: {found:?}");
        assert!(
            (found.energy().dissipated - stored_j).abs() < 1e-6 * stored_j,
            "{} of {stored_j} J",
            found.energy().dissipated
        );
    }
}

/// ST-03. A motor with a command beyond an end presses the joint on its stop, in the static analysis and in a simulation, on either side;
/// the stop's stiffness enters the mode about this equilibrium.
#[test]
fn st03_rests_on_a_stop() {
    for (command_rad, end_rad) in [(-1.5, LOWER_RAD), (1.5, UPPER_RAD)] {
        let (motor, stop) = (2.0, stops(0.0).stiffness_n_m_rad);
        let drive = Motor { stiffness_n_m_rad: motor, command_rad, ..Motor::default() };
        let machine = rotor(|joint| joint.end_stops(stops(0.7)).motor(drive.clone()));
        let rest_rad = (motor * command_rad + stop * end_rad) / (motor + stop);
        let frequency_hz = ((motor + stop) / INERTIA_KG_M2).sqrt() / (2.0 * PI);
        let mut plant = Plant::new(std::sync::Arc::new(machine.clone()));
        plant.study().equilibrium(0.0, Holding::AsReleased).expect("rests on the stop");
        assert!((plant.outputs().joints()[0].angle_rad - rest_rad).abs() < 1e-9);
        let mode = &plant.study().modes(1).expect("a mode")[0];
        assert!((mode.frequency_hz / frequency_hz - 1.0).abs() < 1e-9, "{} Hz", mode.frequency_hz);
        let mut plant = start(machine);
        coast(&mut plant, 3.0);
        assert!((plant.outputs().joints()[0].angle_rad - rest_rad).abs() < 1e-6, "{:?}", plant.outputs().joints()[0]);
    }
}

/// ST-04. A run from a snapshot taken in contact is bit-identical.
#[test]
fn st04_contact_survives_a_rollback() {
    let mut plant = start(rotor(|joint| joint.end_stops(stops(0.05)).start_rate_rad_s(RATE_RAD_S)));
    coast(&mut plant, UPPER_RAD / RATE_RAD_S + 0.003);
    let saved = plant.snapshot();
    coast(&mut plant, 1.0);
    let first = plant.outputs().clone();
    plant.restore(&saved).expect("the same model");
    coast(&mut plant, 1.0);
    assert_eq!(&first, plant.outputs());
}

/// ST-06. A start exactly at an end stop, moving outward, is in contact from the first instant: a half period of `(π − 2 asin ζ)/ω_d`, and
/// back with the fraction of the speed given by (A8), nothing counted as work.
#[test]
fn st06_a_start_at_an_end_moves_into_the_stop() {
    for ratio in [0.0f64, 0.4] {
        let stops = stops(ratio);
        let mut machine = rotor(|joint| joint.end_stops(stops).start_angle_rad(UPPER_RAD).start_rate_rad_s(RATE_RAD_S));
        machine.solver.tolerance = 1e-10;
        let mut plant = start(machine);
        let damped_rad_s = FREQUENCY_RAD_S * (1.0 - ratio * ratio).sqrt();
        let contact_s = (PI - 2.0 * ratio.asin()) / damped_rad_s;
        let rate_rad_s = -RATE_RAD_S * (-ratio * FREQUENCY_RAD_S * contact_s).exp();
        let time_s = contact_s + 0.02;
        coast(&mut plant, time_s);
        let (joint, energy) = (plant.outputs().joints()[0], plant.outputs().energy());
        let depth_rad = match ratio == 0.0 {
            true => 0.0,
            // instant at which the sum of spring and damper force vanishes
            false => -2.0 * ratio / FREQUENCY_RAD_S * rate_rad_s,
        };
        let angle_rad = UPPER_RAD + depth_rad + 0.02 * rate_rad_s;
        let errors = [joint.angle_rad - angle_rad, joint.rate_rad_s - rate_rad_s, energy.work];
        println!("ST-06 ζ = {ratio}: {errors:?}");
        // the tolerance of 1e-10 in each of a few hundred steps; errors of rates are larger by the frequency of the stop
        agree("ST-06 angle in rad", errors[0].abs(), 1e-7);
        agree("ST-06 rate in rad/s", errors[1].abs(), 1e-5);
        assert!(errors[2].abs() < 1e-16, "round-off of half a joule: {errors:?}");
    }
}

#[test]
fn stops_that_cannot_be_are_refused() {
    let refused = |change: fn(&mut EndStops)| {
        let mut stops = stops(0.1);
        change(&mut stops);
        let body = Body::rigid("rotor").inertia(1.0, [0.0; 3], Matrix3::identity());
        let built =
            Machine::builder("test").body(body, Joint::revolute("hinge", Vector3::y()).end_stops(stops)).build();
        built.map(|_| ()).expect_err("refused").to_string()
    };
    assert!(refused(|stops| (stops.lower_rad, stops.upper_rad) = (None, None)).contains("lower_rad or upper_rad"));
    assert!(refused(|stops| stops.lower_rad = Some(1.0)).contains("above lower_rad"));
    assert!(refused(|stops| stops.stiffness_n_m_rad = 0.0).contains("stiffness_n_m_rad"));
    assert!(refused(|stops| stops.damping_n_m_s_rad = -1.0).contains("damping_n_m_s_rad"));
    assert!(refused(|stops| stops.upper_rad = Some(f64::NAN)).contains("upper_rad"));
}

/// End stops defined in code equal those in a file, for both kinds of joint.
#[test]
fn st05_stops_of_a_file_are_those_of_code() {
    let text = |joint: &str| {
        format!(
            "name = \"r\"\n[rigid_body.rotor]\nmass_kg = 1.0\n[joint.hinge]\nparent = \"root\"\nchild = \"rotor\"\naxis = \
             [0, 1, 0]\n{joint}\n"
        )
    };
    let read = |joint: &str| foldwing::config::parse(&text(joint), "model.toml");
    let stops_of = |machine: &Machine| machine.bodies[0].joint.kind.one_freedom().expect("one freedom").1.end_stops;
    let hinge = read(
        "type = \"revolute\"\nend_stops.lower_deg = -90.0\nend_stops.upper_deg = 45.0\nend_stops.stiffness_N_m_rad = 3.0\n\
         end_stops.damping_N_m_s_rad = 0.1",
    );
    let both = EndStops {
        lower_rad: Some(-0.5 * PI),
        upper_rad: Some(0.25 * PI),
        stiffness_n_m_rad: 3.0,
        damping_n_m_s_rad: 0.1,
    };
    assert_eq!(stops_of(&hinge.expect("accepted")), Some(both));
    let slide = read("type = \"prismatic\"\nend_stops.upper_m = 0.5\nend_stops.stiffness_N_m = 3.0").expect("accepted");
    let upper = EndStops { lower_rad: None, upper_rad: Some(0.5), stiffness_n_m_rad: 3.0, damping_n_m_s_rad: 0.0 };
    assert_eq!(stops_of(&slide), Some(upper));
    let refused = |joint: &str| read(joint).expect_err("refused").to_string();
    let wrong = [
        ("type = \"revolute\"\nend_stops.upper_deg = 1.0", "stiffness_N_m_rad"),
        ("type = \"revolute\"\nend_stops.stiffness_N_m_rad = 1.0", "lower_deg or upper_deg"),
        ("type = \"prismatic\"\nend_stops.stiffness_N_m = 1.0", "lower_m or upper_m"),
        (
            "type = \"revolute\"\nend_stops.lower_deg = 2.0\nend_stops.upper_deg = 1.0\nend_stops.stiffness_N_m_rad = 1.0",
            "above lower_deg",
        ),
        ("type = \"revolute\"\nend_stops.upper_m = 2.0\nend_stops.stiffness_N_m_rad = 1.0", "upper_deg instead"),
        ("type = \"ball\"\nend_stops.upper_deg = 2.0\nend_stops.stiffness_N_m_rad = 1.0", "revolute"),
        (
            "type = \"revolute\"\nmotion = \"locked\"\nend_stops.upper_deg = 2.0\nend_stops.stiffness_N_m_rad = 1.0",
            "end stops only with motion",
        ),
    ];
    for (joint, part) in wrong {
        let message = refused(joint);
        println!("{message}");
        assert!(message.contains(part), "{part}: {message}");
    }
}

/// ST-07. A prismatic joint that leaves its stop faster than the stop follows, and is pushed back before it is clear of it: free flight
/// under the force alone until the sum of spring and damper force acts again, then critically damped motion about the new equilibrium.
/// Agrees with the closed form within the error of steps at this tolerance.
#[test]
fn st07_a_leaving_joint_is_pushed_back() {
    let text = "name = 'S'\n[rigid_body.block]\nmass_kg = 1.0\ninertia_kg_m2 = [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]\n\
                [joint.slide]\ntype = 'prismatic'\nparent = 'root'\nchild = 'block'\naxis = [1.0, 0.0, 0.0]\n\
                start_position_m = 0.05\nstart_rate_m_s = -3.0\nmotor.constant_force_N = -200.0\n\
                [joint.slide.end_stops]\nupper_m = 0.0\nstiffness_N_m = 100.0\ndamping_N_s_m = 20.0\n\
                [solver]\ntolerance = 1e-10\n[simulation]\nstop_time_s = 1.0\nstep_s = 1e-2\n";
    let machine = foldwing::config::parse(text, "slide.toml").unwrap_or_else(|error| panic!("{error}"));
    let mut plant = Plant::new(std::sync::Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    // 0.05 - 3 t + 100 t^2 + 0.2 (-3 + 200 t) = 0
    let pressed_s = (-37.0 + (37.0f64 * 37.0 + 4.0 * 100.0 * 0.55).sqrt()) / 200.0;
    let flight = |t: f64| (0.05 - 3.0 * t + 100.0 * t * t, -3.0 + 200.0 * t);
    let (from_m, rate_m_s) = flight(pressed_s);
    assert!(from_m > 0.0, "never free: {from_m} m");
    let expected = |time_s: f64| {
        if time_s < pressed_s {
            return flight(time_s).0;
        }
        let (t, a) = (time_s - pressed_s, from_m - 2.0);
        2.0 + (a + (rate_m_s + 10.0 * a) * t) * (-10.0 * t).exp()
    };
    for time_s in [0.01, 0.02, 0.05, 0.2, 0.5] {
        plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        let found = plant.outputs().joints()[0].angle_rad;
        assert!((found - expected(time_s)).abs() < 1e-8, "{time_s} s: {found} m for {} m", expected(time_s));
    }
}
