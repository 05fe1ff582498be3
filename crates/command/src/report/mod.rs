//! Results as CSV, inputs over time from CSV, linear models as files; figures of recordings, the page with the animation, VTK
//! files.

pub mod figure;
pub mod film;
pub mod inputs;
pub mod linear;
pub mod lines;
pub mod mat;
pub mod plots;
pub mod recorder;
#[cfg(test)]
mod samples;
pub mod shapes;
pub mod table;
pub mod viewer;
pub mod vtk;

pub use foldwing_recording::{Recording, acting, number, recording, signals};
pub use inputs::{Channel, InputTable, InputsError};
pub use linear::{linear_json, write_npz};
pub use mat::write_mat;
pub use recorder::Recorder;

use foldwing_fmi::interface::Value;
use std::fmt::Write;

/// A value as a CSV cell: reals with the shortest text that reads back to the same bits, Booleans as 0 and 1.
pub fn cell(value: &Value) -> String {
    let mut text = String::new();
    write_cell(value, &mut text);
    text
}

/// Appends a value to a text in the format of [`cell`].
fn write_cell(value: &Value, text: &mut String) {
    let written = match value {
        Value::Real(value) => {
            // 1e-9 and 1e30, not strings of zeros
            text.push_str(zmij::Buffer::new().format(*value));
            Ok(())
        }
        Value::Integer(value) => write!(text, "{value}"),
        Value::Boolean(value) => write!(text, "{}", u8::from(*value)),
    };
    debug_assert!(written.is_ok(), "writing to a String cannot fail");
}
