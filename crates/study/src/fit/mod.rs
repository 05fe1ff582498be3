//! Identification: nonlinear least squares with bounds, robust losses, and the covariance of the result.
//!
//! The caller provides the residuals and their Jacobian; the command and the Python package compute them from runs. NOTATION,
//! eqs. (X14) to (X16).

mod loss;
mod search;
#[cfg(test)]
mod tests;
mod uncertainty;

pub use loss::Loss;
pub use search::{Ended, Found, Search, search};
pub use uncertainty::{Uncertainty, uncertainty};

use nalgebra::{DMatrix, DVector};

/// Residuals of a model with adjustable numbers: differences from measurements, divided by their standard deviation or scale.
pub trait Problem {
    /// Reason why there are no residuals at the start of the search, or no Jacobian.
    type Error;

    /// Residuals at a point; `None` if the model has none there, after which the search takes a shorter step.
    ///
    /// # Errors
    /// Reasons to stop the search.
    fn residuals(&mut self, x: &DVector<f64>) -> Result<Option<DVector<f64>>, Self::Error>;

    /// Derivatives of the residuals with respect to the numbers, one row per residual, at a point that has residuals.
    ///
    /// # Errors
    /// Reasons to stop the search.
    fn jacobian(&mut self, x: &DVector<f64>) -> Result<DMatrix<f64>, Self::Error>;
}
