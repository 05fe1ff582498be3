//! `--set NAME=VALUE`: plants with the start values given on the command line.

use crate::cli::choice::unknown;
use crate::cli::{Failure, read_model};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Plant, Turn};
use foldwing_fmi::interface::{AccessError, Interface, UNITS, Value, Variable};
use foldwing_study::names::shortened;
use foldwing_study::values::Setting;
use std::path::Path;
use std::sync::Arc;

/// Reads a model file and returns a plant with start values set, not yet initialised.
pub(super) fn read_plant(model: &Path, settings: &[String]) -> Result<Plant, Failure> {
    let (machine, _) = read_model(model)?;
    let interface = Interface::new(&machine);
    plant_with(machine, &interface, settings)
}

/// Returns a plant of a model with start values set, not yet initialised.
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

/// Sets `NAME=VALUE` of an input or parameter, or `NAME=X,Y,Z` of all components of a vector, and returns the value set; messages
/// start with `option`.
pub(super) fn apply_setting(
    option: &str,
    setting: &str,
    interface: &Interface,
    plant: &mut Plant,
) -> Result<Vec<Setting>, Failure> {
    let refused = |cause: String| Failure::Usage(format!("{option} {}: {cause}", shortened(setting)));
    let (name, text) = setting.split_once('=').ok_or_else(|| refused("must be NAME=VALUE".to_owned()))?;
    if name.starts_with("file:") {
        return Err(refused(
            "keys of the model file can be varied by `foldwing sweep --vary`, not by --set; edit the file".to_owned(),
        ));
    }
    if let Some(rows) = components(name, interface) {
        return set_vector(text, rows, interface, plant).map_err(refused);
    }
    let variable = interface.find(name).ok_or_else(|| unknown(name, "input or parameter", interface.variables()))?;
    let value = match variable.value {
        Value::Real(_) => {
            let value = set_real(text, variable, interface, plant).map_err(refused)?;
            return Ok(vec![Setting::real(name, value)]);
        }
        Value::Integer(_) => text.parse().map(Value::Integer).map_err(|_| "is not a whole number"),
        Value::Boolean(_) => match text {
            "1" | "true" => Ok(Value::Boolean(true)),
            "0" | "false" => Ok(Value::Boolean(false)),
            _ => Err("is not a Boolean; allowed are 0, 1, false and true"),
        },
    };
    let value = value.map_err(|cause| refused(format!("`{text}` {cause}")))?;
    interface.set(plant, variable.value_reference, value).map_err(|error| refused(error.to_string()))?;
    Ok(vec![Setting { name: name.to_owned(), value }])
}

/// Components of a vector of real inputs or parameters; `None` for other names.
fn components<'a>(name: &str, interface: &'a Interface) -> Option<&'a [Variable]> {
    let signal = interface.signals().iter().find(|signal| signal.name == name)?;
    let (first, count) = (signal.first_reference as usize, signal.shape.components().len());
    let rows = interface.variables().get(first..first + count)?;
    (count > 1 && rows.iter().all(|row| matches!(row.value, Value::Real(_)))).then_some(rows)
}

/// Sets all components of a vector from numbers separated by commas; a unit after the last number is valid for all.
fn set_vector(text: &str, rows: &[Variable], interface: &Interface, plant: &mut Plant) -> Result<Vec<Setting>, String> {
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    let unit = words.last().and_then(|last| last.split_once(' ')).map_or("", |(_, unit)| unit.trim());
    if words.len() != rows.len() {
        let names: Vec<&str> = rows.iter().map(|row| row.name.rsplit('.').next().unwrap_or(&row.name)).collect();
        let form: Vec<String> = names.iter().map(|name| name.to_uppercase()).collect();
        return Err(format!("{} values for {} components; write {}", words.len(), rows.len(), form.join(",")));
    }
    let with_unit = |word: &str| match unit.is_empty() || word.contains(' ') {
        true => word.to_owned(),
        false => format!("{word} {unit}"),
    };
    let mut settings = Vec::new();
    for (word, row) in words.iter().zip(rows) {
        let value =
            set_real(&with_unit(word), row, interface, plant).map_err(|cause| format!("{}: {cause}", row.name))?;
        settings.push(Setting::real(row.name.as_str(), value));
    }
    Ok(settings)
}

/// Start values, in the format of `--set`, for a study in which a shaft rotates, set on the model with the rotating shaft. `turn`
/// is the shaft, its speed in rad/s and the steps per revolution. Empty if the shaft is not valid, which the study itself reports.
pub(super) fn settings_of_turning(
    machine: &Machine,
    (shaft, speed_rad_s, steps): (Option<&str>, Option<f64>, usize),
    settings: &[String],
) -> Result<Vec<Setting>, Failure> {
    if settings.is_empty() {
        return Ok(Vec::new());
    }
    match Turn::of(machine, shaft, speed_rad_s, steps) {
        Ok((turning, _)) => typed_settings(&turning, settings),
        Err(_) => Ok(Vec::new()),
    }
}

/// Start values for a study of a model, in the format of `--set`.
pub(super) fn typed_settings(machine: &Machine, settings: &[String]) -> Result<Vec<Setting>, Failure> {
    if settings.is_empty() {
        return Ok(Vec::new());
    }
    let interface = Interface::new(machine);
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let mut list = Vec::new();
    for setting in settings {
        list.extend(apply_setting("--set", setting, &interface, &mut plant)?);
    }
    Ok(list)
}

/// Sets a real number, given in the variable's unit or in a display unit that follows it (`90 deg`).
fn set_real(text: &str, variable: &Variable, interface: &Interface, plant: &mut Plant) -> Result<f64, String> {
    let own = variable.unit();
    let (number, unit) = text.trim().split_once(' ').map_or((text, own), |(number, unit)| (number, unit.trim()));
    let value: f64 = number.parse().map_err(|_| format!("`{}` is not a number", shortened(number)))?;
    let shown = display_unit(own);
    let factor = match shown {
        _ if unit == own => 1.0,
        Some((name, factor)) if name == unit => factor,
        _ => {
            let other = shown.map_or(String::new(), |(name, _)| format!(" and {name}"));
            return Err(format!("`{}` is not one of its units; allowed: {own}{other}", shortened(unit)));
        }
    };
    let set = interface.set(plant, variable.value_reference, Value::Real(value / factor));
    set.map_err(|error| refusal(&error, (unit == own).then_some(variable), number))?;
    Ok(value / factor)
}

/// Reason why a value is rejected, with an example of `number` in the display unit of `variable` if it has one.
pub(super) fn refusal(error: &AccessError, variable: Option<&Variable>, number: &str) -> String {
    match variable.and_then(|variable| display_unit(variable.unit())) {
        Some((name, _)) if error.is_bad_value() => format!("{error}; in degrees write \"{number} {name}\""),
        _ => error.to_string(),
    }
}

/// Display unit of a unit, and its factor.
fn display_unit(unit: &str) -> Option<(&'static str, f64)> {
    UNITS.iter().find(|known| known.name == unit).and_then(|known| known.display)
}
