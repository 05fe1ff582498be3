//! Beams with shear deformation, from model files: statics, frequencies and large motion against independent solutions, whose numbers are
//! in `tests/reference/shear`. Case numbers SH-xx.

mod motion;
mod section_files;
mod small_motion;
mod statics;

use crate::reference::numbers;
use serde_json::Value;

/// Numbers of `tests/reference/shear/beams.json`.
fn beams() -> Value {
    serde_json::from_str(include_str!("../../reference/shear/beams.json")).expect("valid JSON")
}

/// A matrix of the file as TOML.
fn matrix(value: &Value) -> String {
    let rows: Vec<String> = value.as_array().expect("rows").iter().map(|row| format!("{:?}", numbers(row))).collect();
    format!("[{}]", rows.join(", "))
}
