//! Models for the tests of this module.

use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::Interface;
use std::sync::Arc;

/// Interface and initialised plant of a supplied model.
pub fn started(name: &str) -> (Interface, Plant) {
    changed(name, "", "")
}

/// Like [`started`], with the first occurrence of `old` in the model file replaced by `new`.
pub fn changed(name: &str, old: &str, new: &str) -> (Interface, Plant) {
    let path = format!("{}/../../examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap().replacen(old, new, 1);
    let machine = foldwing_file::parse(&text, name).unwrap();
    let interface = Interface::new(&machine);
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap();
    (interface, plant)
}
