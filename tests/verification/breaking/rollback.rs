//! Rollback to instants before failures, bit-identical; memory; aerodynamics.

use crate::breaking::*;
use crate::counting_allocator::allocations;
use foldwing::machine::Failure;
use foldwing::machine::failure::{BoundSide, FrictionBrake, Quantity};
use foldwing::plant::{Outputs, Snapshot};
use std::sync::Arc;

fn outputs_until(plant: &mut Plant, end_s: f64, steps: usize) -> Vec<Outputs> {
    let begin_s = plant.time_s();
    let step_s = (end_s - begin_s) / steps as f64;
    let mut all = Vec::new();
    for i in 1..=steps {
        plant.step(begin_s + step_s * i as f64).unwrap_or_else(|error| panic!("{error}"));
        all.push(plant.outputs().clone());
    }
    all
}

/// FL-20. Steps repeated from before, between and after failures give bit-identical results, in the same plant and in a new one.
#[test]
fn fl20_rollback_over_failures_to_the_bit() {
    let brake = FrictionBrake { torque_n_m: 0.05, ramp_s: 0.1, slip_rad_s: 1e-2 };
    let failures = [
        Failure::spring_break("spring", "hinge", 0.3).when("hinge", Quantity::Angle, BoundSide::Below, 0.1),
        Failure::motor_runaway("runaway", "hinge", 1.0, 2.0).at_time_s(0.31),
        Failure::brake_applied("brake", "hinge", brake).after("spring").delay_s(0.2),
        Failure::motor_jam("jam", "hinge").at_time_s(0.8),
    ];
    let spring = foldwing::machine::Spring { stiffness_n_m_rad: 0.5, ..Default::default() };
    let machine = rotor(|joint| sprung(joint).spring(spring), &failures);
    let mut plant = start(machine.clone());
    for until_s in [0.101, 0.25, 0.4, 0.9] {
        outputs_until(&mut plant, until_s, 10);
        let bytes = postcard::to_stdvec(&plant.snapshot()).expect("serialises");
        let first = outputs_until(&mut plant, 1.2, 40);
        let snapshot: Snapshot = postcard::from_bytes(&bytes).expect("deserialises");
        plant.restore(&snapshot).expect("own snapshot");
        assert!(outputs_until(&mut plant, 1.2, 40) == first, "repeated from {until_s} s");
        let mut other = Plant::new(Arc::new(machine.clone()));
        other.restore(&snapshot).expect("same model");
        assert!(outputs_until(&mut other, 1.2, 40) == first, "elsewhere from {until_s} s");
        plant.restore(&snapshot).expect("own snapshot");
    }
    outputs_until(&mut plant, 1.2, 3);
    assert!((0..4).all(|failure| failed_s(&plant, failure).is_some()));
}

/// FL-21. A snapshot of a machine without these failures is rejected.
#[test]
fn fl21_snapshots_of_other_failures_are_refused() {
    let plant = begun(sprung, Failure::motor_loss("motor", "hinge"));
    let mut other = start(rotor(sprung, &[]));
    assert!(other.restore(&plant.snapshot()).is_err());
}

/// FL-22. Failures cause no memory allocation.
#[test]
fn fl22_failures_allocate_nothing() {
    let failures = [
        Failure::motor_loss("motor", "hinge").at_time_s(0.11),
        Failure::motor_jam("jam", "hinge").when("hinge", Quantity::Angle, BoundSide::Below, -1.0).delay_s(0.02),
    ];
    let mut plant = start(rotor(sprung, &failures));
    plant.step(0.01).expect("runs");
    let before = allocations();
    for i in 2..=90 {
        plant.step(0.01 * f64::from(i)).expect("runs");
    }
    let count = allocations() - before;
    assert!((0..2).all(|failure| failed_s(&plant, failure).is_some()));
    assert_eq!(count, 0);
}
