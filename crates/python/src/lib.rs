//! Native part of the Python package `foldwing`: handles for machines, simulations and linear models, NumPy arrays as arguments and
//! results.
//!
//! It contains no physics, and no state except the handles. Users import `python/foldwing`, which has the public names, units and plots.
//! Every run releases the interpreter, and checks for Ctrl-C ten times a second.

mod fit;
mod input_table;
mod linear;
mod model;
mod object;
mod progress;
mod refusal;
mod simulation;
mod sweep;
mod variables;

use foldwing_command::cli::{Camera, Failure, FilmSettings, film_of_page};
use progress::Progress;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;

/// Runs the command `foldwing` with these arguments, the program's name first; returns its exit code.
#[pyfunction]
fn run_command(py: Python<'_>, arguments: Vec<OsString>, library: Option<PathBuf>) -> u8 {
    py.detach(|| foldwing_command::cli::run_as(arguments, library.as_deref()))
}

/// The JSON schema of model files.
#[pyfunction]
fn schema() -> String {
    foldwing_file::schema()
}

/// Writes a page with an animation; a file not written by Foldwing is overwritten only with `force`.
#[pyfunction]
fn write_page(page: &str, output: PathBuf, force: bool) -> PyResult<()> {
    foldwing_command::cli::write_page(page, &output, force).map_err(|failure| refusal::command(&failure))
}

/// Writes a video of the run in a page; a file not written by Foldwing is overwritten only with `force`. Returns the output of `foldwing
/// render --json`.
#[pyfunction]
#[pyo3(signature = (page, output, size, fps, speed, camera, span, force, progress))]
#[allow(clippy::too_many_arguments, reason = "the arguments of the method in Python")]
fn film(
    py: Python<'_>,
    page: &str,
    output: PathBuf,
    size: Option<[u32; 2]>,
    fps: Option<f64>,
    speed: Option<f64>,
    camera: Vec<String>,
    span: [Option<f64>; 2],
    force: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let word = |word: &String| Camera::of(word).map_err(|failure| refusal::command(&failure));
    let camera = camera.iter().map(word).collect::<PyResult<_>>()?;
    let settings = FilmSettings { size, frames_per_s: fps, speed, camera, span_s: span };
    let (mut progress, mut raised) = (Progress::new(progress), None);
    let drawn = |done: usize, total: usize| {
        progress.at(done as f64 / total as f64).map_err(|error| {
            raised = Some(error);
            Failure::Closed
        })
    };
    let film = py.detach(|| film_of_page(page, &output, &settings, force, drawn));
    if let Some(error) = raised {
        return Err(error);
    }
    object::of(py, &film.map_err(|failure| refusal::command(&failure))?)
}

/// Contents of `foldwing._native`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<input_table::InputTable>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<simulation::State>()?;
    module.add_class::<linear::LinearModel>()?;
    module.add_function(wrap_pyfunction!(fit::least_squares, module)?)?;
    module.add_function(wrap_pyfunction!(linear::reduced, module)?)?;
    module.add_function(wrap_pyfunction!(linear::discretized, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(run_command, module)?)?;
    module.add_function(wrap_pyfunction!(write_page, module)?)?;
    module.add_function(wrap_pyfunction!(film, module)?)?;
    module.add_function(wrap_pyfunction!(schema, module)?)
}
