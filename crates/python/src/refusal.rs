//! Errors as exceptions of `foldwing.errors`, with the words of the command.

use foldwing_command::cli::Failure;
use foldwing_engine::plant::PlantError;
use foldwing_file::ConfigError;
use foldwing_fmi::interface::AccessError;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// An exception of the class `name` of `foldwing.errors`.
fn of_class(name: &str, message: &str) -> PyErr {
    Python::attach(|py| {
        let raised = || py.import("foldwing.errors")?.getattr(name)?.call1((message,));
        raised().map_or_else(|error| error, PyErr::from_value)
    })
}

/// A name or value that does not exist or is not allowed.
pub fn usage(message: impl AsRef<str>) -> PyErr {
    of_class("UsageError", message.as_ref())
}

/// The time integration gave up.
pub fn simulation(error: &PlantError) -> PyErr {
    of_class("SimulationError", &error.to_string())
}

/// Statics, modes or a linear model gave up.
pub fn statics(error: &PlantError) -> PyErr {
    of_class("StaticsError", &error.to_string())
}

/// A linear model that cannot be reduced or sampled.
pub fn no_linear_model(message: String) -> PyErr {
    of_class("StaticsError", &message)
}

/// A row that cannot be read or set.
pub fn access(error: &AccessError) -> PyErr {
    usage(error.to_string())
}

/// What the command says, by kind.
pub fn command(failure: &Failure) -> PyErr {
    let message = failure.to_string();
    match failure {
        Failure::Model { error, .. } => model(error),
        Failure::Refused(_) => of_class("ModelError", &message),
        Failure::Usage(_) => usage(message),
        Failure::Simulation(_) => of_class("SimulationError", &message),
        Failure::Statics(_) => of_class("StaticsError", &message),
        Failure::Files(_) => of_class("FilesError", &message),
        Failure::Closed | Failure::Differ(..) => PyRuntimeError::new_err(message),
    }
}

/// A refused model file: the message, and its problems as `(line, key, text)`.
pub fn model(error: &ConfigError) -> PyErr {
    let refused = of_class(
        if matches!(error, ConfigError::Read { .. }) { "FilesError" } else { "ModelError" },
        &error.to_string(),
    );
    let problems: Vec<(usize, String, String)> = error
        .problems()
        .iter()
        .map(|problem| {
            let text = problem.to_string();
            let text = text.split_once(": ").map_or(text.clone(), |(_, rest)| rest.to_owned());
            (problem.line, problem.key.clone(), text)
        })
        .collect();
    let set = Python::attach(|py| refused.value(py).setattr("problems", problems));
    set.err().unwrap_or(refused)
}
