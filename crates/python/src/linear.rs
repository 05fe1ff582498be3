//! Linear models as arrays.

use crate::refusal;
use crate::simulation::Simulation;
use foldwing_command::cli;
use foldwing_command::report::linear_json;
use foldwing_engine::plant::{Keep, NoReduction, Reduced, StateSpace, sampled};
use foldwing_fmi::interface::{self, reduce_any};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

/// `δẋ = A δx + B δu`, `δy = C δx + D δu` about a state.
#[pyclass(frozen, module = "foldwing._native")]
pub struct LinearModel {
    model: interface::LinearModel,
}

#[pymethods]
impl LinearModel {
    /// Linear model about the current state of a simulation, between the real inputs and outputs selected by names and prefixes, with the
    /// components `gusts` of a gust as further inputs; with `lattice`, in discrete time with the vortex lattice.
    #[new]
    fn new(
        py: Python<'_>,
        mut simulation: PyRefMut<'_, Simulation>,
        inputs: Vec<String>,
        outputs: Vec<String>,
        lattice: bool,
        gusts: Vec<usize>,
    ) -> PyResult<Self> {
        let (plant, shared) = simulation.parts();
        let failed = |failure: cli::Failure| refusal::command(&failure);
        if !gusts.is_empty() && !lattice && !shared.machine.air.as_ref().is_some_and(|air| air.is_linearised()) {
            return Err(refusal::usage(
                "inputs: only linear models with strips (aerodynamics.model = \"strip\"), with a rotor, or with a vortex lattice and \
                 lattice=True have gusts as inputs",
            ));
        }
        let inputs = match (inputs.is_empty() && !gusts.is_empty(), lattice) {
            (true, _) => Ok(Vec::new()),
            (false, true) => cli::chosen(&inputs, shared.interface.real_inputs_in_air(), "real input"),
            (false, false) => cli::chosen(&inputs, shared.interface.real_inputs(), "real input"),
        }
        .map_err(failed)?;
        let outputs = cli::chosen(&outputs, shared.interface.real_outputs(), "real output").map_err(failed)?;
        let model = py
            .detach(|| match lattice {
                true => shared.interface.linearize_lattice(plant, &inputs, &gusts, &outputs),
                false => shared.interface.linearize_in_gusts(plant, &inputs, &gusts, &outputs),
            })
            .map_err(|error| refusal::statics(&error))?;
        Ok(Self { model })
    }

    /// `A`, `B`, `C`, `D`.
    fn matrices<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyArray2<f64>>; 4]> {
        let of = &self.model.matrices;
        Ok([array(py, &of.a)?, array(py, &of.b)?, array(py, &of.c)?, array(py, &of.d)?])
    }

    /// States, inputs, outputs (name, unit, value) and the operating point, as in `foldwing linearize -o x.json` without the matrices.
    fn describe(&self) -> String {
        let mut described = interface::LinearModel {
            matrices: StateSpace {
                a: DMatrix::zeros(0, 0),
                b: DMatrix::zeros(0, 0),
                c: DMatrix::zeros(0, 0),
                d: DMatrix::zeros(0, 0),
            },
            ..self.model.clone()
        };
        described.without_air = self.model.without_air;
        linear_json(&described).to_string()
    }

    /// Description of the operating point.
    fn about(&self) -> String {
        self.model.point.to_string()
    }
}

/// `A`, `B`, `C`, `D`, the error bound, and Hankel singular values of a reduced model.
type Reduction<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Option<f64>,
    Vec<f64>,
    Option<Measured<'py>>,
);

/// Upper end of the frequency band in Hz, relative errors (outputs, inputs), eigenvalues in 1/s of omitted modes and their relative
/// gains.
type Measured<'py> = (f64, Bound<'py, PyArray2<f64>>, Vec<[f64; 2]>, Vec<f64>);

/// Reduces a model to `order` states: the slowest modes, or a balanced truncation.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "arguments of a function in Python")]
pub fn reduced<'py>(
    py: Python<'py>,
    a: PyReadonlyArray2<'py, f64>,
    b: PyReadonlyArray2<'py, f64>,
    c: PyReadonlyArray2<'py, f64>,
    d: PyReadonlyArray2<'py, f64>,
    order: usize,
    modal: bool,
    dt: Option<f64>,
    up_to_hz: Option<f64>,
) -> PyResult<Reduction<'py>> {
    let model = StateSpace { a: matrix(&a), b: matrix(&b), c: matrix(&c), d: matrix(&d) };
    let keep = if modal { Keep::Modes } else { Keep::Balanced };
    let found = py.detach(|| reduce_any(&model, order, keep, up_to_hz, dt));
    let Reduced { model, error_bound, accuracy, hankel } = found.map_err(|error| refused(&error))?;
    let [a, b, c, d] = [array(py, &model.a)?, array(py, &model.b)?, array(py, &model.c)?, array(py, &model.d)?];
    let accuracy = match accuracy {
        Some(accuracy) => {
            let values = accuracy.dropped.iter().map(|mode| [mode.eigenvalue_1_s.re, mode.eigenvalue_1_s.im]).collect();
            let shares = accuracy.dropped.iter().map(|mode| mode.share).collect();
            Some((accuracy.up_to_hz, array(py, &accuracy.error)?, values, shares))
        }
        None => None,
    };
    Ok((a, b, c, d, error_bound, hankel, accuracy))
}

/// `A` and `B` for a sampling time of `dt` s with inputs held constant in between.
#[pyfunction]
pub fn discretized<'py>(
    py: Python<'py>,
    a: PyReadonlyArray2<'py, f64>,
    b: PyReadonlyArray2<'py, f64>,
    dt: f64,
) -> PyResult<[Bound<'py, PyArray2<f64>>; 2]> {
    let (a, b) = (matrix(&a), matrix(&b));
    let model = StateSpace { c: DMatrix::zeros(0, a.ncols()), d: DMatrix::zeros(0, b.ncols()), a, b };
    let (a, b) = py.detach(|| sampled(&model, dt)).map_err(|error| refused(&error))?;
    Ok([array(py, &a)?, array(py, &b)?])
}

fn refused(error: &NoReduction) -> PyErr {
    match error {
        NoReduction::Order { .. } | NoReduction::Band => refusal::usage(error.to_string()),
        NoReduction::Eigenvalues
        | NoReduction::Defective { .. }
        | NoReduction::Grows
        | NoReduction::SampledModes
        | NoReduction::ModalBand
        | NoReduction::Singular => refusal::no_linear_model(error.to_string()),
    }
}

fn matrix(array: &PyReadonlyArray2<'_, f64>) -> DMatrix<f64> {
    let array = array.as_array();
    DMatrix::from_fn(array.nrows(), array.ncols(), |i, j| array[[i, j]])
}

/// Converts a matrix to an array of shape (rows, columns).
pub fn array<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let values: Vec<f64> = matrix.transpose().as_slice().to_vec();
    PyArray1::from_vec(py, values).reshape([matrix.nrows(), matrix.ncols()])
}
