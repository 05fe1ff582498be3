//! Failures triggered by the motion, and failures triggered by other failures.

use crate::breaking::*;
use foldwing::machine::Failure;
use foldwing::machine::builder::JointBuilder;
use foldwing::machine::failure::{BoundSide, Quantity};

const RATE_RAD_S: f64 = 3.0;

fn turning(joint: JointBuilder) -> JointBuilder {
    joint.start_rate_rad_s(RATE_RAD_S)
}

/// FL-10. The crossing of a bound on the angle is located to 1e-10 s, whatever the communication step; the jam follows after its delay.
#[test]
fn fl10_a_bound_on_the_angle_is_located() {
    for steps in [1, 9, 400] {
        let jam =
            Failure::motor_jam("jam", "hinge").when("hinge", Quantity::Angle, BoundSide::Above, 1.0).delay_s(0.05);
        let mut plant = begun(turning, jam);
        assert!(drift_j(&mut plant, 1.0, steps) < 1e-10);
        let found_s = failed_s(&plant, 0).expect("it fails");
        let expected_s = 1.0 / RATE_RAD_S + 0.05;
        assert!((found_s - expected_s).abs() < 2e-10, "{steps} steps: off by {:e} s", found_s - expected_s);
        assert!((plant.outputs().joints()[0].angle_rad - RATE_RAD_S * found_s).abs() < 1e-9);
    }
}

/// FL-11. A bound on the rate of an oscillation, against the closed form.
#[test]
fn fl11_a_bound_on_the_rate_is_located() {
    let falls = |bound_rad_s: f64| {
        let died = Failure::motor_loss("motor", "hinge").when("hinge", Quantity::Rate, BoundSide::Below, bound_rad_s);
        let mut plant = begun(sprung, died);
        assert!(drift_j(&mut plant, 1.0, 10) < 1e-8);
        plant
    };
    let plant = falls(-3.0);
    let expected_s = (3.0 / (START_RAD * FREQUENCY_RAD_S)).asin() / FREQUENCY_RAD_S;
    let found_s = failed_s(&plant, 0).expect("it fails");
    assert!((found_s - expected_s).abs() < 1e-9, "off by {:e} s", found_s - expected_s);
    assert!((plant.outputs().joints()[0].rate_rad_s + 3.0).abs() < 1e-8);
    // faster than any rate of the oscillation
    assert_eq!(failed_s(&falls(-START_RAD * FREQUENCY_RAD_S - 0.01), 0), None);
}

/// FL-12. One failure triggers another, at once or after a delay; an impulse jumps over a bound without a crossing.
#[test]
fn fl12_failures_follow_failures() {
    let failures = [
        Failure::motor_jam("first", "hinge").at_time_s(0.2),
        Failure::motor_loss("second", "hinge").when("hinge", Quantity::Rate, BoundSide::Below, 1.0),
        Failure::motor_loss("third", "hinge").after("second").delay_s(0.125),
        Failure::motor_loss("fourth", "hinge").after("third"),
    ];
    let mut plant = start(rotor(turning, &failures));
    drift_j(&mut plant, 1.0, 11);
    let times = [0, 1, 2, 3].map(|i| failed_s(&plant, i));
    assert_eq!(times, [Some(0.2), Some(0.2), Some(0.2 + 0.125), Some(0.2 + 0.125)]);
}

/// FL-13. A bound already exceeded at the start triggers the failure as soon as the simulation continues.
#[test]
fn fl13_a_bound_passed_at_the_start() {
    let jam = Failure::motor_jam("jam", "hinge").when("hinge", Quantity::Rate, BoundSide::Above, 1.0);
    let mut plant = begun(turning, jam);
    drift_j(&mut plant, 0.5, 5);
    assert_eq!(failed_s(&plant, 0), Some(0.0));
    assert_eq!(plant.outputs().joints()[0].angle_rad, 0.0);
}
