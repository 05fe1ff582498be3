//! Time integration of second-order equations of motion (one trait, two families of methods), and their equilibria, modes and linear
//! models.

pub mod acceleration;
pub mod arc_length;
pub(crate) mod complex_factors;
pub mod continuation;
pub(crate) mod contour;
pub mod control;
pub mod eigen;
pub mod equilibrium;
pub mod explicit;
pub mod floquet;
pub mod generalized_alpha;
pub mod held;
pub mod krylov;
pub mod lagged;
pub mod linearize;
pub mod modes;
pub mod multiblade;
pub mod newton;
pub mod point;
pub mod reduction;
pub mod reduction_accuracy;
pub mod reduction_band;
pub mod reduction_sampled;
pub mod resolvent;
pub mod runge_kutta;
pub mod settle;
pub mod stepper;
pub mod tableau;
pub mod tracking;

/// Equations of motion `residual(t, q, q̇, q̈) = 0`, with a solver for their Newton matrix.
///
/// All vectors have [`EquationsOfMotion::coordinates`] entries. No function may allocate.
pub trait EquationsOfMotion {
    /// Number of coordinates.
    fn coordinates(&self) -> usize;

    /// Overwrites the coordinates with prescribed motion.
    fn prescribe(&self, time_s: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]);

    /// Projects coordinates, with their rates and accelerations, onto their constraints. Called at the ends of steps.
    fn project(&self, q: &mut [f64], v: &mut [f64], a: &mut [f64]);

    /// Projects a state onto the constraints of closed loops with the last factors, after [`EquationsOfMotion::project`] at the ends of
    /// steps. Returns whether there are constraints of either kind: powers must then be computed again.
    ///
    /// # Errors
    /// If the loops cannot be closed.
    fn close(&mut self, _q: &mut [f64], _v: &mut [f64], _a: &mut [f64]) -> Result<bool, Open> {
        Ok(false)
    }

    /// Residual at a state; entries of held and prescribed coordinates are zero.
    fn residual(&mut self, time_s: f64, q: &[f64], v: &[f64], a: &[f64], residual: &mut [f64]);

    /// Selects the smooth pieces of forces with kinks according to a state. Residuals and tangents then use these pieces until
    /// [`EquationsOfMotion::move_pieces`] or [`EquationsOfMotion::drop_pieces`], NOTATION eq. (T12).
    fn take_pieces(&mut self, _time_s: f64, _q: &[f64], _v: &[f64]) {}

    /// Changes the pieces of forces with kinks, or only the piece of the first such force, towards those of a state. Returns whether any
    /// has changed: residual and factors are then out of date.
    fn move_pieces(&mut self, _time_s: f64, _q: &[f64], _v: &[f64], _only_first: bool) -> bool {
        false
    }

    /// Ends the selection of pieces: forces with kinks depend on the state again.
    fn drop_pieces(&mut self) {}

    /// Factorises `mass·M + damping·C + stiffness·K` at the configuration of the last residual.
    ///
    /// `damping` in s, `stiffness` in s². Returns an error if a pivot is not positive: a shorter step may help.
    fn factorize(&mut self, mass: f64, damping: f64, stiffness: f64) -> Result<(), Singular>;

    /// Solves in place with the last factorisation; returns the kinematic norm of the solution.
    fn solve(&mut self, x: &mut [f64]) -> f64;

    /// Kinematic norm of a change of coordinates at the configuration of the last residual: largest displacement divided by the model's
    /// length, or rotation in rad.
    fn norm(&mut self, change: &[f64]) -> f64;

    /// Power of the inputs and of damping in W. The arguments are the state of the last residual, with the last Newton correction added.
    fn powers(&mut self, time_s: f64, q: &[f64], v: &[f64], a: &[f64]) -> Powers;
}

/// Rates of the energy accounts in W.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Powers {
    /// Work of the inputs.
    pub work: f64,
    /// Power dissipated by damping.
    pub dissipated: f64,
}

/// The constraints are not met at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Open {
    /// Rigid loops are not closed.
    #[error(
        "rigid loops stay open by {gap:.1e} of the model's length: prescribed motions, locks or the lengths of the bodies contradict them; \
         release a joint of the loop, or give it stiffness_N_m in place of rigid = true"
    )]
    Gap {
        /// Largest gap relative to the machine's length.
        gap: f64,
    },
    /// Skates or wheels slip, or have left their planes.
    #[error(
        "a skate or a wheel slips by {slip:.1e} of its speed, or is off its plane by this share of the model's length: prescribed motions, \
         locks or other constraints contradict it; release a joint, or write hold_normal = false, or rolling = false on a wheel"
    )]
    Slip {
        /// Largest rate of slip relative to the speed of the point of contact, or distance from the plane relative to the machine's length.
        slip: f64,
    },
}

/// The Newton matrix cannot be factorised at this iterate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the Newton matrix has no positive pivot at coordinate {coordinate}")]
pub struct Singular {
    /// Coordinate of the pivot that is not positive.
    pub coordinate: usize,
}

#[cfg(test)]
mod test_oscillator;
