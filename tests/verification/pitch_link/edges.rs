//! Special cases of the aerodynamics of the failing blade: errors, limits, values a thousand times larger.

use super::air::{Induced, loads};
use super::joint_of;
use crate::plant::machines::start;
use foldwing::aero::rotor::options::{PitchRate, Spread};
use foldwing::config;
use foldwing::machine::{AirOptions, JointMotion, Machine, Motion};
use nalgebra::Vector3;
use std::path::Path;

fn text() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/failures/pitch_link_in_wind.toml");
    std::fs::read_to_string(path).expect("a shipped model")
}

fn machine_of(changes: &[(&str, &str)]) -> Result<Machine, String> {
    let mut text = text();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    config::parse(&text, "blade").map_err(|error| error.to_string())
}

fn machine(changes: &[(&str, &str)]) -> Machine {
    machine_of(changes).unwrap_or_else(|error| panic!("{error}"))
}

/// PL-14. Incompatible keys are rejected with the key and the remedy.
#[test]
fn pl14_what_does_not_go_together_is_refused() {
    let lag = "inflow_lag_s = 0.8";
    for (from, to, expected) in [
        (
            lag,
            "inflow_lag_s = 0.002",
            "key 'aerodynamics.inflow_lag_s': 0.002 is not allowed; allowed: a finite time >= 0.0025 s",
        ),
        (lag, "inflow_lag_s = 0.0", "key 'aerodynamics.inflow_lag_s': 0"),
        (lag, "inflow_lag_s = -1.0", "key 'aerodynamics.inflow_lag_s': -1"),
        (
            lag,
            "inflow_lag_s = 0.8\ndynamic_inflow = true",
            "only without inflow_lag_s, which replaces the momentum balance",
        ),
        (lag, "inflow_lag_s = 0.8\nskewed_wake = true", "key 'aerodynamics.skewed_wake'"),
        (lag, "inflow_lag_s = 0.8\naerodyn_compatible = true", "key 'aerodynamics.aerodyn_compatible'"),
        (lag, "inflow_lag_s = 0.8\nend_loads = \"full_induction\"", "key 'aerodynamics.end_loads'"),
        (lag, "inflow_lag_s = 0.8\ndynamic_stall = true", "key 'aerodynamics.pitch_rate'"),
        ("blades = 2", "blades = 0", "key 'aerodynamics.blades'"),
        ("blades = 2", "blades = 101", "key 'aerodynamics.blades'"),
        ("pitch_rate = \"hub\"", "pitch_rate = \"shaft\"", "key 'aerodynamics.pitch_rate'"),
        (
            "load_interpolation = \"piecewise_constant\"",
            "load_interpolation = \"cell\"",
            "key 'aerodynamics.load_interpolation'",
        ),
        ("length_m = 20.25", "length_m = 0.0", "key 'surface.blade.length_m'"),
        ("length_m = 20.25", "length_m = 19.0", "key 'surface.blade.stations_m'"),
        ("length_m = 20.25\n", "", "a rigid body has none"),
        ("chord_m = { table = [[0.0, 1.71], [20.25, 0.9]] }\n", "", "a rigid body has no section to take it from"),
        ("pressure_shift_deg = 10.0", "pressure_shift_deg = 0.0", "key 'polar.profile.pressure_shift_deg'"),
        ("pressure_shift_deg = 10.0", "pressure_shift_deg = 81.0", "an angle > 0 deg, at most 80"),
        ("aspect_ratio = 15.0\n", "", "key 'polar.profile.pressure_shift_deg'"),
        ("    [-10, ", "    [-95, ", "a polar from negative to positive stall must begin"),
    ] {
        let message = machine_of(&[(from, to)]).expect_err(to);
        assert!(message.contains(expected), "{to}: {message}");
    }
    // the same keys without a rotor
    for (key, value) in [
        ("inflow_lag_s", "0.8"),
        ("blades", "2"),
        ("pitch_rate", "\"hub\""),
        ("load_interpolation", "\"piecewise_constant\""),
    ] {
        let without = format!("[aerodynamics]\nmodel = \"none\"\n{key} = {value}\n");
        let text =
            std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/slender_wing.toml"))
                .expect("a model");
        let text = text.replacen("[aerodynamics]\n", &format!("[aerodynamics]\n{key} = {value}\n"), 1);
        let message = config::parse(&text, "wing").expect_err(key).to_string();
        assert!(message.contains("this key only with model = \"bem\""), "{without}: {message}");
    }
}

/// PL-15. One blade that represents two, and two blades with equal motion, give the same loads on air and shaft.
#[test]
fn pl15_a_blade_stands_for_others() {
    let of = |machine: Machine| {
        let mut plant = start(machine);
        let steady = plant.outputs().rotor()[0];
        plant.step(0.5).expect("runs");
        (plant.outputs().joints()[2].angle_rad, steady)
    };
    let (two_rad, two) = of(machine(&[]));
    let (one_rad, one) = of(machine(&[("blades = 2", "blades = 1")]));
    // four blades of half the chord instead of two: the same total chord
    let (_, four) = of(machine(&[
        ("blades = 2", "blades = 4"),
        ("chord_m = { table = [[0.0, 1.71], [20.25, 0.9]] }", "chord_m = { table = [[0.0, 0.855], [20.25, 0.45]] }"),
    ]));
    assert!((two_rad - one_rad).abs() > 1e-4, "induction follows the number of blades: {two_rad} {one_rad}");
    assert!(two.induction > 1.5 * one.induction, "{} {}", two.induction, one.induction);
    assert!((four.induction / two.induction - 1.0).abs() < 1e-9, "{} {}", four.induction, two.induction);
    assert!((four.thrust_n / two.thrust_n - 1.0).abs() < 1e-9, "{} {}", four.thrust_n, two.thrust_n);
    assert!(
        two.thrust_n > 1.6 * one.thrust_n && two.thrust_n < 2.0 * one.thrust_n,
        "{} {}",
        two.thrust_n,
        one.thrust_n
    );
}

/// PL-19. Torque and power of the rotor include all its blades: twice the torque that holds the shaft of one of two blades at its speed.
#[test]
fn pl19_torque_of_like_blades() {
    let mut turning = machine(&[]);
    turning.failures.clear();
    joint_of(&mut turning, "shaft").motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 4.0]));
    joint_of(&mut turning, "shaft").start_rate_rad_s = 0.0;
    joint_of(&mut turning, "shaft").motor.constant_torque_n_m = 0.0;
    joint_of(&mut turning, "flap").motion = JointMotion::Locked;
    let plant = start(turning);
    let (rotor, held_n_m) = (plant.outputs().rotor()[0], plant.outputs().joints()[0].holding_torque_n_m);
    println!("torque {:.1} N·m, one blade {held_n_m:.1}", rotor.torque_n_m);
    assert!((rotor.torque_n_m / (2.0 * held_n_m.abs()) - 1.0).abs() < 1e-9, "{} {held_n_m}", rotor.torque_n_m);
    assert!((rotor.power_w / (4.0 * rotor.torque_n_m.abs()) - 1.0).abs() < 1e-12, "{}", rotor.power_w);
}

/// PL-16. Limits. Simulations in still air, in wind from behind and in a wind a thousand times stronger succeed; a motionless rotor without
/// wind has no load; piecewise constant and piecewise linear loads agree as the stations get dense; the pitch rate relative to the air
/// contains Ω sin β in addition to the rate relative to the hub.
#[test]
fn pl16_limits() {
    let wind = "wind_m_s = [0.0, 0.0, 13.0]";
    for other in ["wind_m_s = [0.0, 0.0, 0.0]", "wind_m_s = [0.0, 0.0, -13.0]", "wind_m_s = [0.0, 13.0, 0.0]"] {
        let mut plant = start(machine(&[(wind, other)]));
        plant.step(1.0).unwrap_or_else(|error| panic!("{other}: {error}"));
        assert!(plant.outputs().rotor()[0].thrust_n.is_finite());
    }
    // dynamic pressure 1e6 times as large: the run succeeds, or its error names the cause
    let mut plant = start(machine(&[(wind, "wind_m_s = [0.0, 0.0, 13000.0]")]));
    match plant.step(0.05) {
        Ok(()) => assert!(plant.outputs().joints().iter().all(|joint| joint.angle_rad.is_finite())),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let mut still = machine(&[
        (wind, "wind_m_s = [0.0, 0.0, 0.0]"),
        ("start_rate_deg_s = 229.1831180523293", "start_rate_deg_s = 0.0"),
    ]);
    joint_of(&mut still, "shaft").motor.constant_torque_n_m = 0.0;
    joint_of(&mut still, "flap").start_angle_rad = 0.0;
    let mut plant = start(still);
    plant.step(0.5).expect("runs");
    assert_eq!(plant.outputs().rotor()[0].thrust_n, 0.0);
    // piecewise linear loads cover the blade from its first to its last station: with dense stations from end to end both agree
    let dense = |spread: &str| {
        let places: Vec<String> = (0..=80).map(|i| format!("{}", 20.25 * f64::from(i) / 80.0)).collect();
        let text = text();
        let begin = text.find("stations_m").expect("stations");
        let end = text[begin..].find("\n\n").expect("an end") + begin;
        let stations =
            format!("stations_m = [{}]\npolars = [{}]", places.join(", "), vec!["\"profile\""; 81].join(", "));
        let text = format!("{}{stations}{}", &text[..begin], &text[end..])
            .replace("load_interpolation = \"piecewise_constant\"", spread);
        let plant = start(config::parse(&text, "blade").unwrap_or_else(|error| panic!("{error}")));
        plant.outputs().rotor()[0].thrust_n
    };
    let (cells, lines) =
        (dense("load_interpolation = \"piecewise_constant\""), dense("load_interpolation = \"linear\""));
    // both are of second order in cells of 0.25 m on 20 m: about 1e-4
    assert!((cells / lines - 1.0).abs() < 5e-4, "{cells} {lines}");
    let mut turning = machine(&[]);
    turning.failures.clear();
    // an angular acceleration would also load the link
    joint_of(&mut turning, "shaft").motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 4.0]));
    joint_of(&mut turning, "shaft").start_rate_rad_s = 0.0;
    joint_of(&mut turning, "flap").motion = JointMotion::Locked;
    let hold = |machine: &Machine| start(machine.clone()).outputs().joints()[2].holding_torque_n_m;
    let hub = hold(&turning);
    let AirOptions::Rotor(rotor) = &mut turning.air.as_mut().expect("air").parts[0].options else { panic!("a rotor") };
    assert_eq!((rotor.features.pitch_rate, rotor.features.spread), (PitchRate::Hub, Spread::Cells));
    rotor.features.pitch_rate = PitchRate::Air;
    let air = hold(&turning);
    // the reference's aerodynamics with Ω sin β as pitch rate
    let flap_rad = 0.6301876f64.to_radians();
    let moment = |rate_rad_s: f64| {
        let (q, rates) = (Vector3::new(0.0, flap_rad, (-2f64).to_radians()), Vector3::new(4.0, 0.0, rate_rad_s));
        let mut induced = Induced::zeros();
        for _ in 0..4000 {
            induced += 0.05 * 0.8 * loads(&q, &rates, &induced).1;
        }
        loads(&q, &rates, &induced).0[2]
    };
    let expected = moment(4.0 * flap_rad.sin()) - moment(0.0);
    println!("rate in the air: {:.2} N·m, by hand {expected:.2}", hub - air);
    // derivatives of the polar's rows
    assert!((hub - air - expected).abs() < 0.01 * expected.abs() && expected < -15.0, "{hub} {air} {expected}");
}

/// PL-17. Dynamic stall on the same blade: in the steady rotor it reduces to the static polar; after the failure stall occurs later and the
/// oscillation differs, but it is still limited and the blade still goes to feather.
#[test]
fn pl17_dynamic_stall() {
    let of = |changes: &[(&str, &str)]| {
        let mut machine = machine(changes);
        joint_of(&mut machine, "pitch").motor.inertia_kg_m2 = 30.0;
        let mut plant = start(machine);
        let steady = plant.outputs().rotor()[0].thrust_n;
        let mut least_deg = f64::INFINITY;
        for i in 1..=600 {
            plant.step(0.01 * f64::from(i)).expect("runs");
            if i <= 240 {
                least_deg = least_deg.min(plant.outputs().joints()[2].angle_rad.to_degrees());
            }
        }
        let joints = plant.outputs().joints();
        (steady, least_deg, joints[2].angle_rad.to_degrees(), joints[0].rate_rad_s)
    };
    let plain = of(&[]);
    let dynamic = of(&[("pitch_rate = \"hub\"", "dynamic_stall = true")]);
    println!("static {plain:.2?}, dynamic {dynamic:.2?}: thrust, pitch down to 2.4 s, pitch and rotor speed at 6 s");
    // the rotation about the shaft is not a pitch rate of the coned blade, with or without dynamic stall
    assert!((dynamic.0 / plain.0 - 1.0).abs() < 1e-9, "{plain:?} {dynamic:?}");
    assert!((dynamic.1 - plain.1).abs() > 1.0, "{plain:?} {dynamic:?}");
    assert!(dynamic.1 < -15.0 && dynamic.2 < -40.0 && dynamic.3 < 2.0, "{dynamic:?}");
}

/// PL-18. The same failure on a beam: the root strain after the failure falls with the remaining inertia; before it the inertia does not
/// matter. No independent solution of the beam exists.
#[test]
fn pl18_a_blade_that_bends() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/failures/pitch_link_flexible.toml");
    let text = std::fs::read_to_string(path).expect("a shipped model");
    let of = |pitch_kg_m2: f64| {
        let mut machine = config::parse(&text, "blade").unwrap_or_else(|error| panic!("{error}"));
        joint_of(&mut machine, "pitch").motor.inertia_kg_m2 = pitch_kg_m2;
        let mut plant = start(machine);
        let (mut before, mut after) = (0.0f64, 0.0f64);
        for i in 1..=120 {
            plant.step(0.05 * f64::from(i)).expect("runs");
            let strain = plant.outputs().gauges()[0].abs();
            if i <= 60 { before = before.max(strain) } else { after = after.max(strain) }
        }
        (before, after, plant.outputs().joints()[1].angle_rad.to_degrees())
    };
    let [none, some, many] = [0.0, 30.0, 300.0].map(of);
    println!("strain at the root before and after, pitch at 6 s: {none:?} {some:?} {many:?}");
    assert!((none.0 - many.0).abs() < 1e-3 * many.0, "the link holds alike before: {} {}", none.0, many.0);
    assert!(none.1 > 1.01 * some.1 && some.1 > 1.05 * many.1, "{none:?} {some:?} {many:?}");
    assert!(many.1 > 2.0 * many.0, "the jump alone: {many:?}");
}
