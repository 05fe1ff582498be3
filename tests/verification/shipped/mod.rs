//! The shipped example models with special mechanisms, against independent computations.
//!
//! Cases are numbered F-210 and on.

mod braced_wing;
mod flared_tip;
mod roll_fold;
mod slender_wing;
mod sliding;

use foldwing::config;
use foldwing::machine::Machine;
use foldwing::plant::Plant;
use std::sync::Arc;

/// A machine from a model's text with texts replaced; each of these must occur.
fn machine(text: &str, changes: &[(&str, &str)]) -> Machine {
    let mut text = text.to_owned();
    for (old, new) in changes {
        assert!(text.contains(old), "the model has no {old:?}");
        text = text.replace(old, new);
    }
    config::parse(&text, "model.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// A plant at the start of its experiment.
fn start(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Steps through the default experiment; `see` is called with the plant at the start and after every step.
fn run(machine: Machine, mut see: impl FnMut(&Plant)) -> Plant {
    let experiment = machine.experiment.clone();
    let steps = (experiment.stop_time_s / experiment.step_s).round() as u32;
    let mut plant = start(machine);
    see(&plant);
    for i in 1..=steps {
        let end_s = experiment.stop_time_s * f64::from(i) / f64::from(steps);
        plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
        see(&plant);
    }
    plant
}

/// Relative differences in percent, for printing.
fn percent(shares: &[f64]) -> Vec<f64> {
    shares.iter().map(|share| 100.0 * share).collect()
}
