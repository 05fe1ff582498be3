//! Beams with shear deformation, from model files: statics, frequencies and large motion against independent solutions, whose numbers are
//! in `tests/reference/shear`. Case numbers SH-xx.

mod motion;
mod random_machines;
mod section_files;
mod small_motion;
mod spinning;
mod statics;

use crate::reference::numbers;
use nalgebra::Matrix6;
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

/// A 6×6 matrix as TOML.
fn matrix_of(value: &Matrix6<f64>) -> String {
    let rows: Vec<String> = value.row_iter().map(|row| format!("{:?}", row.iter().collect::<Vec<_>>())).collect();
    format!("[{}]", rows.join(", "))
}

/// Numbers with two digits.
fn short(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.1e}")).collect::<Vec<_>>().join(" ")
}
