//! Covariance and directions that are not determined.

use nalgebra::{DMatrix, DVector};

/// Singular value of the scaled Jacobian, relative to the largest, below which its direction is lost in round-off of the run and of its
/// derivatives.
const SINGULAR: f64 = 1e-6;

/// Uncertainty of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Standard deviation of the residuals: 1 if they are scaled by that of the noise, otherwise estimated; NaN without degrees of
    /// freedom.
    pub noise: f64,
    /// Covariance, eq. (X16); NaN if a direction is not determined.
    pub covariance: DMatrix<f64>,
    /// Directions that the residuals do not determine: unit vectors of the numbers relative to their magnitudes.
    pub undetermined: Vec<DVector<f64>>,
}

impl Uncertainty {
    /// Standard errors of the numbers.
    pub fn standard_errors(&self) -> DVector<f64> {
        self.covariance.diagonal().map(f64::sqrt)
    }
}

/// Uncertainty of numbers `x` from residuals and their Jacobian there; `is_noise_known` if the residuals at the true numbers have a
/// standard deviation of 1.
pub fn uncertainty(
    x: &DVector<f64>,
    residuals: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    is_noise_known: bool,
) -> Uncertainty {
    let (count, rows) = (x.len(), residuals.len());
    let sizes = x.map(|x| if x == 0.0 { 1.0 } else { x.abs() });
    let noise = match rows.checked_sub(count) {
        _ if is_noise_known => 1.0,
        None | Some(0) => f64::NAN,
        Some(degrees) => (residuals.norm_squared() / degrees as f64).sqrt(),
    };
    // rows of zeros if there are fewer measurements than numbers, so that all directions have a singular value
    let scaled =
        DMatrix::from_fn(rows.max(count), count, |i, j| if i < rows { jacobian[(i, j)] * sizes[j] } else { 0.0 });
    let parts = scaled.svd(false, true);
    let directions = parts.v_t.expect("computed above");
    let largest = parts.singular_values.max();
    let weak = |value: f64| value.is_nan() || value <= SINGULAR * largest;
    let undetermined: Vec<DVector<f64>> =
        (0..count).filter(|row| weak(parts.singular_values[*row])).map(|row| directions.row(row).transpose()).collect();
    let covariance = if undetermined.is_empty() {
        let inverse = DMatrix::from_diagonal(&parts.singular_values.map(|value| (noise / value).powi(2)));
        let relative = directions.transpose() * inverse * &directions;
        relative.component_mul(&(&sizes * sizes.transpose()))
    } else {
        DMatrix::from_element(count, count, f64::NAN)
    };
    Uncertainty { noise, covariance, undetermined }
}
