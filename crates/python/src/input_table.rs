//! Inputs over time as columns of arrays.

use crate::model::Model;
use crate::refusal;
use foldwing_command::report;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

/// Inputs over time, as the command reads them from CSV: reals are interpolated linearly between rows, other
/// values are held.
#[pyclass(frozen, module = "foldwing._native")]
pub struct InputTable {
    pub table: report::InputTable,
}

#[pymethods]
impl InputTable {
    /// Columns by name, each as long as `times_s`.
    #[new]
    fn new(
        model: &Model,
        times_s: PyReadonlyArray1<'_, f64>,
        columns: Vec<(String, PyReadonlyArray1<'_, f64>)>,
    ) -> PyResult<Self> {
        let columns: Vec<(String, Vec<f64>)> =
            columns.into_iter().map(|(name, values)| (name, values.as_array().to_vec())).collect();
        let table =
            report::InputTable::of_columns(times_s.as_array().to_vec(), columns, model.shared.interface.variables())
                .map_err(refusal::usage)?;
        Ok(Self { table })
    }
}
