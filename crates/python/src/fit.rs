//! Least squares with Python functions.

use foldwing_study::fit::{self, Loss, Problem, Search};
use nalgebra::{DMatrix, DVector};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Residuals and Jacobian as functions of an array.
struct Functions<'py> {
    py: Python<'py>,
    residuals: Bound<'py, PyAny>,
    jacobian: Bound<'py, PyAny>,
}

impl<'py> Functions<'py> {
    fn array(&self, x: &DVector<f64>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(self.py, x.as_slice())
    }
}

impl Problem for Functions<'_> {
    type Error = PyErr;

    fn residuals(&mut self, x: &DVector<f64>) -> PyResult<Option<DVector<f64>>> {
        let found = self.residuals.call1((self.array(x),))?;
        if found.is_none() {
            return Ok(None);
        }
        let found: PyReadonlyArray1<'_, f64> = found.extract()?;
        Ok(Some(DVector::from_iterator(found.len(), found.as_array().iter().copied())))
    }

    fn jacobian(&mut self, x: &DVector<f64>) -> PyResult<DMatrix<f64>> {
        let found: PyReadonlyArray2<'_, f64> = self.jacobian.call1((self.array(x),))?.extract()?;
        let (rows, columns) = found.as_array().dim();
        Ok(DMatrix::from_row_iterator(rows, columns, found.as_array().iter().copied()))
    }
}

/// Least squares by `foldwing_study::fit`: numbers, residuals, runs, outcome, and the uncertainty of the numbers, under the names of the
/// library. `residuals` returns an array, or `None` if there are none at a point; `jacobian` returns an array with a row for each
/// residual.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "as many as in Python")]
pub fn least_squares<'py>(
    py: Python<'py>,
    residuals: Bound<'py, PyAny>,
    jacobian: Bound<'py, PyAny>,
    first: Vec<f64>,
    bounds: Vec<[f64; 2]>,
    loss: &str,
    max_runs: usize,
    is_noise_known: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let loss = Loss::named(loss).ok_or_else(|| PyValueError::new_err(loss.to_owned()))?;
    let mut problem = Functions { py, residuals, jacobian };
    let search = Search { first: DVector::from_vec(first), bounds, loss, max_runs };
    let found = fit::search(&mut problem, &search)?;
    let found = found.ok_or_else(|| PyValueError::new_err("there are no residuals at the start"))?;
    let own = fit::uncertainty(&found.x, &found.residuals, &found.jacobian, is_noise_known);
    let rows = |matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
        matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
    };
    let result = PyDict::new(py);
    result.set_item("x", found.x.as_slice().to_vec())?;
    result.set_item("residuals", found.residuals.as_slice().to_vec())?;
    result.set_item("runs", found.runs)?;
    result.set_item("converged", found.ended.converged())?;
    result.set_item("message", found.ended.to_string())?;
    result.set_item("noise", own.noise)?;
    result.set_item("covariance", rows(&own.covariance))?;
    let undetermined: Vec<Vec<f64>> = own.undetermined.iter().map(|row| row.as_slice().to_vec()).collect();
    result.set_item("undetermined", undetermined)?;
    Ok(result)
}
