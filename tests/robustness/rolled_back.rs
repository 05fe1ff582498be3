//! Communication steps that fail before the state changes: the state is bit-identical to the one before.

use foldwing::interface::{Interface, Value};
use foldwing::plant::Plant;
use std::sync::Arc;

/// A failure triggered by its input in a step that itself fails does not take effect: the state, with the memory of failures and the
/// aerodynamics, equals the previous one, outputs agree, and the machine continues as if the step had not been attempted.
#[test]
fn a_failed_step_takes_failures_back() {
    for model in [
        "failures/motor_loss.toml",
        "failures/latch_no_capture.toml",
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
