//! The result of a trim.

use crate::trim::error::Residual;
use crate::warnings::Warning;
use serde::ser::{SerializeMap, SerializeStruct};
use serde::{Serialize, Serializer};

/// Values for which outputs at equilibrium have their targets.
///
/// Serialised, it is the JSON of `foldwing trim`.
#[derive(Debug, Clone, PartialEq)]
pub struct Trim {
    /// Name of the model.
    pub machine: String,
    /// The unknowns, in the order of [`Options::solve_for`](crate::trim::Options::solve_for).
    pub solved: Vec<Solved>,
    /// The outputs, in the order of [`Options::targets`](crate::trim::Options::targets).
    pub balanced: Vec<Balanced>,
    /// Components of the loads on free joints, forces in N and moments in N·m, which the trim makes vanish.
    pub joint_loads: Vec<Residual>,
    /// Start values, in SI units, of inputs and parameters that put the model into this state: those solved for, and those that the
    /// attitude and the turn set.
    pub settings: Vec<(String, f64)>,
    /// Newton steps.
    pub steps: usize,
    /// Warnings: assumptions of the aerodynamic models that the machine does not meet.
    pub warnings: Vec<Warning>,
}

/// An unknown with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Its name, as it was given.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
}

/// An output at equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Balanced {
    /// Its name.
    pub output: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Distance from its target.
    pub residual: f64,
}

impl Serialize for Trim {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let solved = self.solved.iter().map(|own| (own.name.as_str(), own.value));
        let balanced = self.balanced.iter().map(|own| (own.output.as_str(), own.value));
        let settings = self.settings.iter().map(|(name, value)| (name.as_str(), *value));
        let mut fields = serializer.serialize_struct("Trim", 6)?;
        fields.serialize_field("name", &self.machine)?;
        fields.serialize_field("free", &Pairs(solved.collect()))?;
        fields.serialize_field("balances", &Pairs(balanced.collect()))?;
        fields.serialize_field("settings", &Pairs(settings.collect()))?;
        fields.serialize_field("steps", &self.steps)?;
        fields.serialize_field("warnings", &self.warnings)?;
        fields.end()
    }
}

/// Values by name.
struct Pairs<'a>(Vec<(&'a str, f64)>);

impl Serialize for Pairs<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|(name, value)| map.serialize_entry(name, value))?;
        map.end()
    }
}
