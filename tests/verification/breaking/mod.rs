//! Failures of joints, latches, springs, loops and beams, and brakes: against closed forms, with the energy balance, and bit-identical for
//! all communication steps and after rollback.
//!
//! Cases are numbered FL-xx.

mod bounds;
mod brakes;
mod drives;
mod rollback;
mod shipped;
mod stiffness;

use crate::plant::machines::{balance_j, machine, start};
use foldwing::machine::builder::{FailureBuilder, JointBuilder};
use foldwing::machine::{Body, Failure, Joint, Machine, Motor};
use foldwing::plant::{FailureOutputs, Plant, Switch};
use nalgebra::{Matrix3, Vector3};

const INERTIA_KG_M2: f64 = 0.02;
/// Frequency of the rotor on its motor's spring.
const FREQUENCY_RAD_S: f64 = 7.0;
const START_RAD: f64 = 0.8;

/// A rotor on a hinge without gravity, with the hinge modified by `change` and with failures.
fn rotor(change: impl Fn(JointBuilder) -> JointBuilder, failures: &[FailureBuilder]) -> Machine {
    let body = Body::rigid("rotor").inertia(1.0, [0.0; 3], Matrix3::identity() * INERTIA_KG_M2);
    let plain = machine([(body.clone(), Joint::revolute("hinge", Vector3::y()))]);
    let solver = foldwing::machine::Solver { tolerance: 1e-11, ..plain.solver };
    let empty = Machine::builder("test").solver(solver).stop_time_s(1.0).step_s(1e-3);
    let whole = empty.body(body, change(Joint::revolute("hinge", Vector3::y())));
    let whole = failures.iter().cloned().fold(whole, |machine, failure| machine.failure(failure));
    whole.build().unwrap_or_else(|refused| panic!("{refused}"))
}

/// Adds a motor whose spring makes the rotor oscillate.
fn sprung(joint: JointBuilder) -> JointBuilder {
    let stiffness_n_m_rad = INERTIA_KG_M2 * FREQUENCY_RAD_S.powi(2);
    joint.motor(Motor { stiffness_n_m_rad, ..Motor::default() }).start_angle_rad(START_RAD)
}

/// Time at which a failure occurred, if it has.
fn failed_s(plant: &Plant, failure: usize) -> Option<f64> {
    let FailureOutputs { failed, time_s } = plant.outputs().failures()[failure];
    assert_eq!(failed.is_on(), time_s >= 0.0, "both outputs say the same");
    failed.is_on().then_some(time_s)
}

/// Runs in equal steps and returns the largest drift of the energy balance in J.
fn drift_j(plant: &mut Plant, end_s: f64, steps: usize) -> f64 {
    let (begin_s, begin_j) = (plant.time_s(), balance_j(plant.outputs()));
    let mut worst = 0.0f64;
    for i in 1..=steps {
        plant.step(begin_s + (end_s - begin_s) * i as f64 / steps as f64).unwrap_or_else(|error| panic!("{error}"));
        worst = worst.max((balance_j(plant.outputs()) - begin_j).abs());
    }
    worst
}

/// Triggers a failure at the next step.
fn trigger(plant: &mut Plant, failure: usize) {
    plant.inputs_mut().failures_mut()[failure] = Switch::ON;
}

/// A machine at its start, with one failure of the hinge.
fn begun(change: impl Fn(JointBuilder) -> JointBuilder, failure: FailureBuilder) -> Plant {
    start(rotor(change, &[failure]))
}

/// A failure that does not occur leaves the results bit-identical.
#[test]
fn fl01_a_failure_that_does_not_happen_changes_nothing() {
    let mut sound = start(rotor(sprung, &[]));
    let mut other = begun(sprung, Failure::motor_loss("motor", "hinge"));
    for i in 1..=100 {
        sound.step(f64::from(i) * 1e-2).expect("runs");
        other.step(f64::from(i) * 1e-2).expect("runs");
        assert_eq!(sound.outputs().joints(), other.outputs().joints());
        assert_eq!(sound.outputs().energy(), other.outputs().energy());
        assert_eq!(failed_s(&other, 0), None);
    }
}
