//! `--set NAME=VALUE`: plants with the start values that the command line gives.

use crate::cli::simulate::unknown;
use crate::cli::{Failure, read_model};
use foldwing::config::Machine;
use foldwing::interface::{Interface, Value};
use foldwing::plant::Plant;
use std::path::Path;
use std::sync::Arc;

/// A plant of a model file with start values set, not yet initialised.
pub(super) fn read_plant(model: &Path, settings: &[String]) -> Result<Plant, Failure> {
    let (machine, _) = read_model(model)?;
    let interface = Interface::new(&machine);
    plant_with(machine, &interface, settings)
}

/// A plant of a machine with start values set, not yet initialised.
pub(super) fn plant_with(
    machine: impl Into<Arc<Machine>>,
    interface: &Interface,
    settings: &[String],
) -> Result<Plant, Failure> {
    let mut plant = Plant::new(machine.into());
    for setting in settings {
        apply_setting("--set", setting, interface, &mut plant)?;
    }
    Ok(plant)
}

/// `NAME=VALUE` of an input or parameter; `option` is what messages begin with.
pub(super) fn apply_setting(
    option: &str,
    setting: &str,
    interface: &Interface,
    plant: &mut Plant,
) -> Result<(), Failure> {
    let refused = |cause: String| Failure::Usage(format!("{option} {setting}: {cause}"));
    let (name, text) = setting.split_once('=').ok_or_else(|| refused("must be NAME=VALUE".to_owned()))?;
    let variable = interface.find(name).ok_or_else(|| unknown(name, "input or parameter", interface.variables()))?;
    let value = match variable.value {
        Value::Real(_) => text.parse().map(Value::Real).map_err(|_| "is not a number"),
        Value::Integer(_) => text.parse().map(Value::Integer).map_err(|_| "is not a whole number"),
        Value::Boolean(_) => match text {
            "1" | "true" => Ok(Value::Boolean(true)),
            "0" | "false" => Ok(Value::Boolean(false)),
            _ => Err("is not a Boolean; allowed are 0, 1, false and true"),
        },
    };
    let value = value.map_err(|cause| refused(format!("`{text}` {cause}")))?;
    interface.set(plant, variable.value_reference, value).map_err(|error| refused(error.to_string()))
}
