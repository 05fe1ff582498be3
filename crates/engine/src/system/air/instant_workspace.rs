//! Workspace for the loads of the aerodynamic models at an instant.

use crate::aero::strip::continuous::LOAD_ROWS;
use crate::aero::strip::instant::SectionAcceleration;
use crate::aero::{AirModels, Stack};
use crate::solve::acceleration::Anderson;
use nalgebra::Vector3;

/// Workspace for the loads of the aerodynamic models at an instant, with their lag states.
pub(crate) struct ContinuousAir {
    /// Whether gusts have separate lag states.
    pub gusts: bool,
    /// Lag states, those of strips in m/s, in the order of linear models.
    pub lags: Vec<f64>,
    pub(super) stack: Stack,
    pub(super) accelerations: Vec<SectionAcceleration>,
    pub(super) answer: Vec<f64>,
    pub(super) guess: Vec<f64>,
    pub(super) residual: Vec<f64>,
    pub(super) anderson: Anderson,
    /// Second derivatives of the control surface angles in rad/s²: an external integrator does not provide them.
    pub(super) flap_rad_s2: Vec<f64>,
}

impl ContinuousAir {
    /// Workspace for models that have a response at an instant, with `flaps` control surfaces; `None` with a lattice.
    pub fn new(model: &AirModels, flaps: usize, gusts: bool) -> Option<Self> {
        let stack = model.stack(gusts)?;
        let sections = model.sections();
        let loads = LOAD_ROWS * sections;
        Some(Self {
            gusts,
            lags: vec![0.0; stack.lags()],
            accelerations: vec![[Vector3::zeros(); 2]; sections],
            answer: vec![0.0; stack.rows()],
            stack,
            guess: vec![0.0; loads],
            residual: vec![0.0; loads],
            anderson: Anderson::new(loads),
            flap_rad_s2: vec![0.0; flaps],
        })
    }

    /// Rates of the lag states in their units per s, from the last solution for the accelerations.
    pub fn lag_rates(&self) -> &[f64] {
        &self.answer[self.guess.len()..][..self.lags.len()]
    }

    /// Magnitudes in N of the change from the guess to the result and of the result; moments are divided by `length_m`.
    pub(super) fn compare(&mut self, length_m: f64) -> (f64, f64) {
        let (mut change_n, mut size_n) = (0.0_f64, 0.0_f64);
        for (row, (residual, (answer, guess))) in
            self.residual.iter_mut().zip(self.answer.iter().zip(&self.guess)).enumerate()
        {
            let share = if row % LOAD_ROWS < 3 { 1.0 } else { 1.0 / length_m };
            *residual = answer - guess;
            change_n = change_n.max(residual.abs() * share);
            size_n = size_n.max(answer.abs() * share);
        }
        // `max` drops NaN: check for it explicitly
        let sound = self.residual.iter().all(|entry| entry.is_finite());
        (if sound { change_n } else { f64::NAN }, size_n)
    }
}
