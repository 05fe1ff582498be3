//! Results as CSV, inputs over time from CSV, linear models as files, figures of recordings, the page with the animation, VTK
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
mod sample_tests;
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

/// Length in bytes of the widest cell, `-2.2250738585072014e-308`.
const CELL_BYTES: usize = 24;

/// Value as a CSV cell: reals with the shortest text from which the same bits are read back, Booleans as 0 and 1.
pub fn cell(value: &Value) -> String {
    let mut text = [0; CELL_BYTES];
    let end = write_cell(value, &mut text);
    String::from_utf8_lossy(&text[..end]).into_owned()
}

/// Writes a value to the beginning of `text` in the format of [`cell`] and returns its length. The buffer needs
/// [`CELL_BYTES`] bytes.
fn write_cell(value: &Value, text: &mut [u8]) -> usize {
    let mut put = |written: &str| {
        text[..written.len()].copy_from_slice(written.as_bytes());
        written.len()
    };
    match value {
        // exponents instead of many zeros, as in 1e-9 and 1e30
        Value::Real(value) => put(zmij::Buffer::new().format(*value)),
        Value::Integer(value) => put(&value.to_string()),
        Value::Boolean(value) => put(if *value { "1" } else { "0" }),
    }
}
