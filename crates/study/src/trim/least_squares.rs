//! Scaled residuals of the balances, and the step that reduces them.

use nalgebra::{DMatrix, DVector};

/// Ratio of the smallest to the largest singular value of the Jacobian above which the unknowns count as independent: the differences are
/// accurate to about 1e-7.
const INDEPENDENT: f64 = 1e-6;

/// Largest residual relative to its reference size.
pub fn measure(left: &DVector<f64>, sizes: &DVector<f64>) -> f64 {
    left.iter()
        .zip(sizes.iter())
        .fold(0.0f64, |largest, (left, size)| largest.max(if *size > 0.0 { left.abs() / size } else { 0.0 }))
}

/// Change of the unknowns that minimises the residuals relative to their sizes; `None` if the unknowns are not independent.
pub fn step_towards(slopes: &DMatrix<f64>, left: &DVector<f64>, sizes: &DVector<f64>) -> Option<DVector<f64>> {
    let (mut rows, mut right) = (slopes.clone(), left.clone());
    for (i, size) in sizes.iter().enumerate().filter(|(_, size)| **size > 0.0) {
        rows.row_mut(i).unscale_mut(*size);
        right[i] /= size;
    }
    let change = if rows.is_square() {
        rows.lu().solve(&right)
    } else {
        // columns scaled to equal norms, so that an unknown without effect is detected
        let columns: Vec<f64> = rows.column_iter().map(|column| column.norm()).collect();
        for (mut column, size) in rows.column_iter_mut().zip(&columns) {
            column.unscale_mut(if *size > 0.0 { *size } else { 1.0 });
        }
        let parts = rows.svd(true, true);
        let independent = parts.singular_values.min() > INDEPENDENT * parts.singular_values.max();
        let found = if independent { parts.solve(&right, 0.0).ok() } else { None };
        found.map(|found| DVector::from_iterator(columns.len(), found.iter().zip(&columns).map(|(x, size)| x / size)))
    };
    change.filter(|change| change.iter().all(|x| x.is_finite()))
}
