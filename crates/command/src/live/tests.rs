//! Machines for the tests of this module.

use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::Interface;
use std::sync::Arc;

/// Table and plant of a shipped model, initialised.
pub fn started(name: &str) -> (Interface, Plant) {
    let path = format!("{}/../../examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let machine = foldwing_file::parse(&std::fs::read_to_string(path).unwrap(), name).unwrap();
    let interface = Interface::new(&machine);
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap();
    (interface, plant)
}
