//! Results as CSV, inputs over time from CSV, linear models as files; recordings of a run, their figures, the page that
//! plays them, VTK files.

pub mod figure;
pub mod inputs;
pub mod linear;
pub mod mat;
pub mod plots;
pub mod recorder;
pub mod recording;
pub mod viewer;
pub mod vtk;

pub use inputs::{Channel, InputTable, InputsError};
pub use linear::{linear_json, write_npz};
pub use mat::write_mat;
pub use recorder::Recorder;
pub use recording::Recording;

use foldwing_fmi::interface::Value;

/// A value as a number: Booleans are 0 and 1.
pub fn number(value: &Value) -> f64 {
    match value {
        Value::Real(value) => *value,
        Value::Integer(value) => f64::from(*value),
        Value::Boolean(value) => f64::from(u8::from(*value)),
    }
}

/// A value as a CSV cell: reals with the shortest text that reads back to the same bits, Booleans as 0 and 1.
pub fn cell(value: &Value) -> String {
    match value {
        Value::Real(value) => format!("{value:?}"), // 1e-9 and 1e30, not strings of zeros
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => u8::from(*value).to_string(),
    }
}
