//! Recordings of a run for pictures: scalars over time, frames with the whole model, events, and all of these packed for the viewer page.
//!
//! The command records runs for `--view`, `--plot`, `--vtk`, videos and live simulations; the documentation's pages record them in the
//! browser.

pub mod acting;
pub mod csv_row;
pub mod fan;
pub mod grid;
pub mod outlines;
pub mod packed;
pub mod recording;
pub mod run;
pub mod signals;
pub mod turbine;

pub use csv_row::{CsvRow, cell};
pub use fan::{Fan, FanRun};
pub use grid::Grid;
pub use recording::Recording;
pub use run::Run;

use foldwing_fmi::interface::{Value, Variable};

/// A value as a number: Booleans are 0 and 1.
pub fn number(value: &Value) -> f64 {
    match value {
        Value::Real(value) => *value,
        Value::Integer(value) => f64::from(*value),
        Value::Boolean(value) => f64::from(u8::from(*value)),
    }
}

/// Returns names and units of variables.
pub fn columns<'v>(variables: impl IntoIterator<Item = &'v Variable>) -> Vec<(String, String)> {
    variables.into_iter().map(|variable| (variable.name.clone(), variable.unit().to_owned())).collect()
}
