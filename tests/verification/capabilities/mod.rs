//! Optional capabilities of FMI at the level of plant and variable table: inputs that vary in time, rates of outputs, derivatives with
//! respect to inputs and parameters.
//!
//! Cases are numbered E-xx.

mod course;
mod feedthrough;
mod rates;
mod rates_at_ends;
mod response;

use foldwing::config;
use foldwing::interface::{Causality, Interface, Value, Variable};
use foldwing::machine::Machine;
use foldwing::plant::Plant;
use std::path::Path;

/// A plant at time zero with its variable table.
pub struct Bench {
    pub plant: Plant,
    pub table: Interface,
}

impl Bench {
    /// A shipped model.
    pub fn shipped(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/models/{name}.toml"));
        let text = std::fs::read_to_string(path).expect("a shipped model");
        Self::of(config::parse(&text, name).expect("valid"))
    }

    /// A bench for any machine.
    pub fn of(machine: Machine) -> Self {
        let table = Interface::new(&machine);
        Self { plant: crate::coupling::wings::start(machine), table }
    }

    /// Value reference of a name.
    pub fn reference(&self, name: &str) -> u32 {
        self.table.find(name).unwrap_or_else(|| panic!("no variable {name}")).value_reference
    }

    /// Sets a Real.
    pub fn set(&mut self, name: &str, value: f64) {
        let reference = self.reference(name);
        self.table.set(&mut self.plant, reference, Value::Real(value)).unwrap_or_else(|error| panic!("{error}"));
    }

    /// Sets the rate of an input for the next step.
    pub fn set_rate(&mut self, name: &str, value: f64) {
        let reference = self.reference(name);
        let outcome = self.table.set_input_rates(&mut self.plant, &[reference], &[1], &[value]);
        outcome.unwrap_or_else(|error| panic!("{error}"));
    }

    /// Reads a Real.
    pub fn get(&self, name: &str) -> f64 {
        self.values(&[self.reference(name)])[0]
    }

    /// Reads Reals.
    pub fn values(&self, references: &[u32]) -> Vec<f64> {
        let mut values = vec![0.0; references.len()];
        self.table.get_all(&self.plant, references, &mut values).unwrap_or_else(|error| panic!("{error}"));
        values
    }

    /// The Real variables of a causality.
    pub fn reals(&self, causality: Causality) -> Vec<&Variable> {
        let wanted = |row: &&Variable| row.causality == causality && matches!(row.value, Value::Real(_));
        self.table.variables().iter().filter(wanted).collect()
    }

    /// Steps to a time.
    pub fn step(&mut self, end_s: f64) {
        self.plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
    }

    /// Equal steps to a time.
    pub fn march(&mut self, end_s: f64, steps: usize) {
        let start_s = self.plant.time_s();
        for i in 1..=steps {
            self.step(start_s + (end_s - start_s) * i as f64 / steps as f64);
        }
    }
}

/// Pseudo-random numbers in [−1, 1], the same in every run.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
