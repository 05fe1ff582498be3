//! Communication steps that fail before anything has moved: the state is that of before, to the last bit.

use foldwing::interface::{Interface, Value};
use foldwing::plant::Plant;
use std::sync::Arc;

/// A failure that its input brings about in a step that fails itself has not happened: the state, with the memory of failures and the air,
/// equals that of before, what is read says so, and the machine goes on like one that has never tried.
#[test]
fn a_failed_step_takes_failures_back() {
    for model in [
        "failures/motor_dies.toml",
        "failures/latch_does_not_catch.toml",
        "models/goland_wing.toml",
        "models/folding_wing_in_tunnel.toml",
    ] {
        let file = format!("{}/examples/{model}", env!("CARGO_MANIFEST_DIR"));
        let (machine, _) = foldwing::config::read(file).expect("a model that is shipped");
        let interface = Interface::new(&machine);
        let find = |fits: &dyn Fn(&str) -> bool| interface.variables().iter().find(|row| fits(&row.name));
        let failure = machine.failures.first().map(|failure| format!("failure.{}", failure.name));
        let (mut tried, mut other) = (Plant::new(Arc::new(machine.clone())), Plant::new(Arc::new(machine.clone())));
        for plant in [&mut tried, &mut other] {
            plant.initialize(0.0).expect("starts");
            plant.step(2e-3).expect("steps");
        }
        let before = tried.snapshot();
        let load =
            find(&|name| name.starts_with("load.") && name.ends_with("force.z")).expect("a load").value_reference;
        let set = |plant: &mut Plant, on: bool| {
            interface.set(plant, load, Value::Real(if on { 1e300 } else { 0.0 })).expect("settable");
            if let Some(name) = &failure {
                let row = interface.find(&format!("{name}.trigger")).expect("an input").value_reference;
                interface.set(plant, row, Value::Boolean(on)).expect("settable");
            }
        };
        set(&mut tried, true);
        assert!(tried.step(4e-3).is_err(), "{model}: a load of 1e300 N");
        if let Some(name) = &failure {
            let row = interface.find(&format!("{name}.failed")).expect("an output").value_reference;
            tried.provide(interface.needs([row].as_slice()));
            assert_eq!(interface.get(&tried, tried.outputs(), row), Some(Value::Boolean(false)), "{model}");
        }
        set(&mut tried, false);
        assert!(tried.snapshot() == before, "{model}: the failed step has left something behind");
        for plant in [&mut tried, &mut other] {
            plant.step(4e-3).unwrap_or_else(|error| panic!("{model}: {error}"));
        }
        assert!(tried.snapshot() == other.snapshot(), "{model}: it goes on otherwise");
    }
}

/// A failure at a time that is known happens at the begin of a step of the integrator, and that step fails: a load grows from nothing, so fast
/// that no step is short enough. The state is that of before to the last bit, the failure has not happened, and once the load is gone it
/// happens at its time.
#[test]
fn a_step_that_fails_behind_a_failure_takes_it_back() {
    let file = format!("{}/examples/failures/motor_dies.toml", env!("CARGO_MANIFEST_DIR"));
    let (mut machine, _) = foldwing::config::read(file).expect("a model that is shipped");
    (machine.failures[0].at_time_s, machine.failures[0].when, machine.failures[0].after) = (Some(2e-3), None, None);
    let interface = Interface::new(&machine);
    let load = interface
        .variables()
        .iter()
        .find(|row| row.name.starts_with("load.") && row.name.ends_with("force.z"))
        .expect("a load")
        .value_reference;
    let failed =
        interface.find(&format!("failure.{}.failed", machine.failures[0].name)).expect("an output").value_reference;
    let read = |plant: &mut Plant| {
        plant.provide(interface.needs([failed].as_slice()));
        interface.get(plant, plant.outputs(), failed)
    };
    let mut refused = 0;
    for load_n in [1e6, 1e8, 1e10, 1e12, 1e16, 1e20] {
        let mut plant = Plant::new(Arc::new(machine.clone()));
        plant.initialize(0.0).expect("starts");
        plant.step(1.5e-3).expect("steps");
        let before = plant.snapshot();
        interface.set(&mut plant, load, Value::Real(load_n)).expect("settable");
        let outcome = plant.step(3e-3);
        println!("{load_n:e} N: {outcome:?} at {} s", plant.outputs().time_s);
        if outcome.is_ok() || plant.outputs().time_s > 1.5e-3 {
            continue;
        }
        refused += 1;
        assert_eq!(read(&mut plant), Some(Value::Boolean(false)), "{load_n:e} N");
        interface.set(&mut plant, load, Value::Real(0.0)).expect("settable");
        assert!(plant.snapshot() == before, "{load_n:e} N: the failed step has left something behind");
        plant.step(3e-3).expect("a step");
        assert_eq!(read(&mut plant), Some(Value::Boolean(true)), "{load_n:e} N");
    }
    assert!(refused > 0, "no load was too much");
}
