//! Workspace for strip theory in a hybrid system.

use crate::aero::strip::continuous::LOAD_ROWS;
use crate::aero::strip::instant::SectionAcceleration;
use crate::aero::{AirModel, AirModels};
use crate::solve::acceleration::Anderson;
use nalgebra::Vector3;

/// Workspace for the loads of strip theory at an instant, with their lag states.
pub(crate) struct ContinuousAir {
    /// Whether gusts have separate lag states.
    pub gusts: bool,
    /// Lag states in m/s, in the order of [`Strips::lags`].
    pub lags_m_s: Vec<f64>,
    pub(super) accelerations: Vec<SectionAcceleration>,
    pub(super) answer: Vec<f64>,
    pub(super) guess: Vec<f64>,
    pub(super) residual: Vec<f64>,
    pub(super) anderson: Anderson,
    /// Second derivatives of the control surface angles in rad/s²: an external integrator does not provide them.
    pub(super) flap_rad_s2: Vec<f64>,
}

impl ContinuousAir {
    /// Workspace for strips on all surfaces, which have a continuous-time form; `None` for other models.
    pub fn new(model: &AirModels, sections: usize, gusts: bool) -> Option<Self> {
        let Some(AirModel::Strips(strips)) = model.only() else { return None };
        let loads = LOAD_ROWS * sections;
        Some(Self {
            gusts,
            lags_m_s: vec![0.0; strips.lag_count(gusts)],
            accelerations: vec![[Vector3::zeros(); 2]; sections],
            answer: vec![0.0; strips.rows(sections, gusts)],
            guess: vec![0.0; loads],
            residual: vec![0.0; loads],
            anderson: Anderson::new(loads),
            flap_rad_s2: vec![0.0; strips.flap_count()],
        })
    }

    /// Rates of the lag states in m/s², from the last solution for the accelerations.
    pub fn lag_rates_m_s2(&self) -> &[f64] {
        &self.answer[self.guess.len()..][..self.lags_m_s.len()]
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
