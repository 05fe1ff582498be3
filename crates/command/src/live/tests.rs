//! Machines for the tests of this module.

use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::Interface;
use std::sync::Arc;

/// Table and plant of a shipped model, initialised.
pub fn started(name: &str) -> (Interface, Plant) {
    changed(name, "", "")
}

/// The same with other text in the first place of `old`.
pub fn changed(name: &str, old: &str, new: &str) -> (Interface, Plant) {
    let path = format!("{}/../../examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap().replacen(old, new, 1);
    let machine = foldwing_file::parse(&text, name).unwrap();
    let interface = Interface::new(&machine);
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap();
    (interface, plant)
}
