//! Rollback, continuation in another plant, and repetition: bit-identical.

use crate::plant::machines::*;
use crate::share::share;
use foldwing::config;
use foldwing::interface::{Interface, Value};
use foldwing::machine::{ElementKind, Method};
use foldwing::plant::{
    BodyParameters, JointInputs, Outputs, ParameterLayout, Plant, PlantError, Snapshot, SolverParameters,
};
use std::mem::offset_of;
use std::sync::Arc;

const METHODS: [Method; 5] =
    [Method::Esdirk4, Method::Esdirk3, Method::TrBdf2, Method::Sdirk2, Method::GeneralizedAlpha];

/// Outputs of some steps from the current time on, with a torque that changes at every third step.
fn steps(plant: &mut Plant, count: usize) -> Vec<Outputs> {
    let begin_s = plant.time_s();
    (1..=count)
        .map(|i| {
            plant.inputs_mut().joints_mut()[0].torque_n_m = 1e-4 * (i / 3) as f64;
            coast(plant, begin_s + 1e-3 * i as f64);
            plant.outputs().clone()
        })
        .collect()
}

/// P-90. Steps repeated from a snapshot are bit-identical, across the latch, for every method.
///
/// The snapshot is taken in the middle of an internal step: the integrator is ahead of the communication point.
#[test]
fn p90_restored_steps_repeat_to_the_bit() {
    for method in METHODS {
        let mut plant = start(wing(ElementKind::Linear, 2, method, 1e-4));
        coast(&mut plant, 0.1101);
        let (before, outputs) = (plant.snapshot(), plant.outputs().clone());
        let first = steps(&mut plant, 40);
        assert!(
            first[39].latches()[0].closed.is_on() && !first[0].latches()[0].closed.is_on(),
            "{method:?}: must span the latch"
        );
        plant.restore(&before).expect("own snapshot");
        assert_eq!(plant.outputs(), &outputs, "{method:?}: outputs after restoring");
        assert!(steps(&mut plant, 40) == first, "{method:?}: repeated steps differ");
    }
}

/// P-91. A serialised snapshot continues bit-identically in a new plant.
#[test]
fn p91_serialised_snapshot_continues_elsewhere() {
    for method in METHODS {
        let machine = wing(ElementKind::Constant, 5, method, 1e-4);
        let mut plant = start(machine.clone());
        coast(&mut plant, 0.1101);
        let bytes = postcard::to_stdvec(&plant.snapshot()).expect("serialises");
        let snapshot: Snapshot = postcard::from_bytes(&bytes).expect("deserialises");
        let mut other = Plant::new(Arc::new(machine));
        other.restore(&snapshot).expect("same model");
        assert_eq!(other.outputs(), plant.outputs(), "{method:?}: outputs after restoring");
        assert!(steps(&mut other, 40) == steps(&mut plant, 40), "{method:?}: the copy goes another way");
        assert_eq!(other.statistics(), plant.statistics());
    }
}

/// P-92. The snapshot of another model is rejected and leaves the plant unchanged.
///
/// The last two have the same joints, bodies and stations and differ only in the mesh, which used to panic.
#[test]
fn p92_snapshot_of_another_model_is_refused() {
    let mut plant = start(default_wing(1e-4));
    coast(&mut plant, 0.01);
    let outputs = plant.outputs().clone();
    let mut with_stations = default_wing(1e-4);
    with_stations.bodies[0].station_positions_m = vec![0.1];
    let single = machine([(body("b", 0.1, &wing_section(), ElementKind::Linear, 1), clamped())]);
    let finer = wing(ElementKind::Linear, 3, Method::Esdirk4, 1e-4);
    let constant = wing(ElementKind::Constant, 5, Method::Esdirk4, 1e-4);
    for other in [single, with_stations, finer, constant] {
        let snapshot = start(other).snapshot();
        let refused = plant.restore(&snapshot);
        assert!(matches!(refused, Err(PlantError::Snapshot(_))), "{refused:?}");
        assert_eq!(plant.outputs(), &outputs);
    }
    coast(&mut plant, 0.02);
}

/// P-99. A state with parameter values that no importer could set is rejected and changes nothing. A stiffness factor of −1 in the bytes of
/// a state used to be accepted, and the instance then failed when gauges were read.
#[test]
fn p99_parameters_that_cannot_be_set_are_refused_in_a_state() {
    let mut plant = start(default_wing(1e-4));
    coast(&mut plant, 0.01);
    let outputs = plant.outputs().clone();
    let good = serde_json::to_value(plant.snapshot()).expect("serialises");
    let ParameterLayout { bodies, solver, .. } = *plant.parameters().layout();
    let stiffness = |body| bodies.place(body, offset_of!(BodyParameters, stiffness_factor));
    for (which, place, value) in [
        ("parameters", stiffness(0), -1.0),
        ("applied_parameters", stiffness(1), 0.0),
        ("applied_parameters", bodies.place(0, offset_of!(BodyParameters, mass_factor)), 1e30),
        ("parameters", solver.place(0, offset_of!(SolverParameters, tolerance)), 0.0),
        // a switch is on or off, and has no rate
        ("inputs", plant.inputs().layout().joints.place(0, offset_of!(JointInputs, release)), 0.5),
        ("rates", plant.inputs().layout().joints.place(0, offset_of!(JointInputs, release)), 1.0),
    ] {
        let path = format!("/{which}/values/{place}");
        let mut forged = good.clone();
        *forged.pointer_mut(&path).expect("a number") = value.into();
        let forged: Snapshot = serde_json::from_value(forged).expect("a state in form");
        let refused = plant.restore(&forged);
        assert!(matches!(refused, Err(PlantError::Snapshot(_))), "{path} = {value}: {refused:?}");
        assert_eq!(plant.outputs(), &outputs, "{path}");
    }
    let good: Snapshot = serde_json::from_value(good).expect("a state");
    plant.restore(&good).expect("the state itself");
}

/// P-93. Repeated runs, runs after another initialisation, and two plants stepped alternately are bit-identical to a single run.
#[test]
fn p93_runs_repeat_to_the_bit() {
    let mut alone = start(default_wing(1e-4));
    let expected = steps(&mut alone, 150);
    alone.inputs_mut().joints_mut()[0].torque_n_m = 0.0;
    alone.initialize(0.0).expect("initialises again");
    assert!(steps(&mut alone, 150) == expected, "initialised again: differs");

    let mut other_machine = default_wing(1e-5);
    hinge_of(&mut other_machine, 1).start_angle_rad = 2.0;
    let (mut first, mut other) = (start(default_wing(1e-4)), start(other_machine));
    let mut interleaved = Vec::new();
    for i in 1..=150 {
        first.inputs_mut().joints_mut()[0].torque_n_m = 1e-4 * (i / 3) as f64;
        coast(&mut first, 1e-3 * i as f64);
        coast(&mut other, 1.3e-3 * i as f64);
        interleaved.push(first.outputs().clone());
    }
    assert!(interleaved == expected, "interleaved with another plant: differs");
}

/// P-94. A snapshot with corrupted bytes is rejected or gives finite numbers: NaN and 1e300 in place of every eight bytes, with and without
/// joints of several degrees of freedom. A rejected snapshot leaves the plant unchanged.
#[test]
fn p94_forged_snapshots_give_no_nan() {
    for name in ["folding_wing", "flying_wing", "double_pendulum"] {
        let path = format!("{}/examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let machine = config::parse(&std::fs::read_to_string(path).unwrap(), name).unwrap();
        let table = Interface::new(&machine);
        let reals: Vec<u32> = table
            .variables()
            .iter()
            .filter(|row| matches!(row.value, Value::Real(_)))
            .map(|row| row.value_reference)
            .collect();
        let mut plant = start(machine);
        coast(&mut plant, 0.0103);
        let (own, before) = (plant.snapshot(), plant.outputs().clone());
        let bytes = postcard::to_stdvec(&own).unwrap();
        let (mut set, mut refused) = (0, 0);
        for at in (0..bytes.len() - 8).step_by(share()) {
            for value in [f64::NAN, 1e300] {
                let mut forged = bytes.clone();
                forged[at..at + 8].copy_from_slice(&value.to_le_bytes());
                let Ok(snapshot) = postcard::from_bytes::<Snapshot>(&forged) else { continue };
                if plant.restore(&snapshot).is_err() {
                    assert_eq!(plant.outputs(), &before, "{name}: a refusal at byte {at} changes nothing");
                    refused += 1;
                    continue;
                }
                let mut values = vec![0.0; reals.len()];
                table.get_all(&plant, reals.as_slice(), &mut values).unwrap();
                for (value, reference) in values.iter().zip(&reals) {
                    let name = &table.variables()[*reference as usize].name;
                    assert!(value.is_finite(), "byte {at}: {name} is {value}");
                }
                plant.restore(&own).unwrap();
                set += 1;
            }
        }
        println!("P-94: {name}: {} bytes, {set} states set, {refused} refused", bytes.len());
        assert!(refused * share() > 100, "{name}");
    }
}

/// P-124. A failed step with input rates has no after-effects: the inputs keep the values reached at the end of the previous step, and the
/// run continues bit-identically to one without the failed step.
#[test]
fn p124_a_failed_step_with_input_rates_leaves_nothing_behind() {
    let ramp = |plant: &mut Plant, end_s: f64| {
        plant.input_rates_mut().joints_mut()[0].torque_n_m = 0.05;
        coast(plant, end_s);
    };
    let (mut smooth, mut disturbed) = (start(default_wing(1e-4)), start(default_wing(1e-4)));
    for plant in [&mut smooth, &mut disturbed] {
        ramp(plant, 0.01);
        ramp(plant, 0.03);
    }
    let led_n_m = smooth.inputs().joints()[0].torque_n_m;
    assert!((led_n_m - 0.05 * 0.03).abs() < 1e-15, "round-off: {led_n_m}");
    disturbed.input_rates_mut().joints_mut()[0].torque_n_m = 0.05;
    disturbed.inputs_mut().root_mut().gravity_m_s2.z = f64::NAN;
    disturbed.step(0.04).expect_err("gravity is not a number");
    assert_eq!(disturbed.inputs(), smooth.inputs(), "inputs after the failed step");
    for end_s in [0.04, 0.05, 0.13] {
        ramp(&mut smooth, end_s);
        ramp(&mut disturbed, end_s);
        assert_eq!(disturbed.outputs(), smooth.outputs(), "{end_s} s");
    }
}
