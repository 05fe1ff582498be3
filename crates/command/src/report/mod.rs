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

pub use foldwing_recording::{Recording, acting, cell, number, recording, signals};
pub use inputs::{Channel, InputTable, InputsError};
pub use linear::{linear_json, write_npz};
pub use mat::write_mat;
pub use recorder::Recorder;
