//! Values of variables by name: start values and targets.

use crate::names::NameError;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{AccessError, Interface, Value};
use std::sync::Arc;

/// A start value of an input or a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Name of the input or parameter.
    pub name: String,
    /// Its value, a real in SI units.
    pub value: Value,
}

impl Setting {
    /// A real in SI units.
    pub fn real(name: impl Into<String>, value: f64) -> Self {
        Self { name: name.into(), value: Value::Real(value) }
    }
}

/// Reason why a start value is rejected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// No variable has the name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The variable does not take the value.
    #[error(transparent)]
    Value(#[from] AccessError),
}

/// An output with its target value.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Name of a real output.
    pub output: String,
    /// Its value in SI units.
    pub value: f64,
}

/// Creates a plant of a model with start values, not yet initialised. `interface` is that of the
/// model.
///
/// # Errors
/// Names that do not belong to an input or parameter, values of another type or out of range.
pub fn plant_with(
    machine: impl Into<Arc<Machine>>,
    interface: &Interface,
    settings: &[Setting],
) -> Result<Plant, SettingError> {
    let mut plant = Plant::new(machine.into());
    for Setting { name, value } in settings {
        let row = interface.find(name).ok_or_else(|| no_row(name, "input or parameter", interface))?;
        interface.set(&mut plant, row.value_reference, *value)?;
    }
    Ok(plant)
}

/// The error for a name that no variable has.
pub(crate) fn no_row(name: &str, expected: &'static str, interface: &Interface) -> NameError {
    NameError::unknown(name, expected, interface.variables().iter().map(|row| row.name.as_str()))
}
