//! Sums of multipliers from the end of a run back to its start.

use crate::gradient::integrand::Mean;
use crate::gradient::variation::Variation;

/// Multipliers at the end of an aerodynamic step.
pub(super) struct OnEnd {
    /// Of the motion.
    pub motion: Variation,
    /// Of the memory of the air.
    pub memory: Vec<f64>,
}

/// Sums of the multipliers of a run, from its end back to the start.
pub(super) struct Sums {
    /// Slopes with respect to the parameters, if they are computed.
    pub gradient: Option<Vec<f64>>,
    /// Multipliers of the loads of the air in the present aerodynamic step; empty without air.
    pub loads: Vec<f64>,
    /// The mean over the run that is the result.
    pub mean: Option<Mean>,
}
