//! Rows of the table of variables, and Python's numbers as their values.

use crate::refusal;
use foldwing_command::report;
use foldwing_fmi::interface::{self, Causality, Interface, Variability, Variable};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

/// Returns the row of a name; an unknown name is an error with the closest one.
pub fn row<'a>(interface: &'a Interface, name: &str, what: &'static str) -> PyResult<&'a Variable> {
    interface
        .find(name)
        .ok_or_else(|| refusal::usage(report::inputs::unknown_name(name, what, interface.variables().iter())))
}

/// Converts a Python number to a value of a row's type.
pub fn of_kind(row: &Variable, value: &Bound<'_, PyAny>) -> PyResult<interface::Value> {
    let refused = |what: &str| {
        let text = value.repr().map(|text| text.to_string()).unwrap_or_default();
        refusal::usage(format!("{}: {text} is not {what}", row.name))
    };
    match row.value {
        interface::Value::Real(_) if !value.is_instance_of::<PyBool>() => {
            value.extract().map(interface::Value::Real).map_err(|_| refused("a number"))
        }
        interface::Value::Real(_) => Err(refused("a number")),
        interface::Value::Integer(_) => {
            value.extract().map(interface::Value::Integer).map_err(|_| refused("a whole number"))
        }
        interface::Value::Boolean(_) => match value.extract::<f64>() {
            Ok(number) if number == 0.0 || number == 1.0 => Ok(interface::Value::Boolean(number != 0.0)),
            _ => value
                .extract()
                .map(interface::Value::Boolean)
                .map_err(|_| refused("a Boolean; allowed are 0, 1, False and True")),
        },
    }
}

/// A row as a dictionary with the fields of `foldwing.Variable`.
pub fn described<'py>(py: Python<'py>, row: &Variable) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    fields.set_item("name", &row.name)?;
    fields.set_item(
        "causality",
        match row.causality {
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Parameter => "parameter",
            Causality::Local => "local",
            Causality::Independent => "independent",
        },
    )?;
    fields.set_item(
        "variability",
        match row.variability {
            Variability::Fixed => "fixed",
            Variability::Tunable => "tunable",
            Variability::Discrete => "discrete",
            Variability::Continuous => "continuous",
        },
    )?;
    match row.value {
        interface::Value::Real(start) => {
            fields.set_item("type", "Real")?;
            fields.set_item("start", start)?;
        }
        interface::Value::Integer(start) => {
            fields.set_item("type", "Integer")?;
            fields.set_item("start", start)?;
        }
        interface::Value::Boolean(start) => {
            fields.set_item("type", "Boolean")?;
            fields.set_item("start", start)?;
        }
    }
    fields.set_item("unit", row.unit())?;
    fields.set_item("range", row.range)?;
    fields.set_item("description", &row.description)?;
    Ok(fields)
}
