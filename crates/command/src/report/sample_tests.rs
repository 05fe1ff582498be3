//! Recordings of supplied models for unit tests.

use crate::report::Recording;
use crate::report::recording::FRAMES;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::Plant;
use foldwing_file as config;
use std::sync::Arc;

/// Reads a supplied model.
pub fn shipped(name: &str) -> Machine {
    let path = format!("{}/../../examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    config::parse(&std::fs::read_to_string(path).unwrap(), name).unwrap()
}

/// Records `steps` steps of 1 ms.
pub fn recorded(machine: Machine, steps: u64) -> Recording {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap();
    let mut recording = Recording::new(&plant, steps, FRAMES);
    recording.include(&plant);
    for step in 1..=steps {
        plant.step(step as f64 * 1e-3).unwrap();
        recording.include(&plant);
    }
    recording
}
