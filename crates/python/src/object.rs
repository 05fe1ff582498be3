//! Results as Python objects: dictionaries, lists, numbers and texts under the keys of the command's JSON.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde::Serialize;
use serde_json::Value;

/// Converts a result to the object that Python reads from its JSON; numbers that are not finite are
/// `None`.
pub fn of(py: Python<'_>, result: &impl Serialize) -> PyResult<Py<PyAny>> {
    let value = serde_json::to_value(result).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    of_value(py, &value)
}

fn of_value(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    match value {
        Value::Null => Ok(py.None()),
        Value::Bool(value) => value.into_py_any(py),
        Value::Number(number) => match (number.as_i64(), number.as_f64()) {
            (Some(whole), _) => whole.into_py_any(py),
            (None, real) => real.into_py_any(py),
        },
        Value::String(text) => text.into_py_any(py),
        Value::Array(values) => {
            let list = PyList::empty(py);
            values.iter().try_for_each(|value| list.append(of_value(py, value)?))?;
            list.into_py_any(py)
        }
        Value::Object(fields) => {
            let dictionary = PyDict::new(py);
            fields.iter().try_for_each(|(key, value)| dictionary.set_item(key, of_value(py, value)?))?;
            dictionary.into_py_any(py)
        }
    }
}
