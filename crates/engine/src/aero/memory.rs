//! Lag states of the aerodynamics as states of a periodic motion.

use crate::aero::strip::{StripHistory, StripOptions, StripState, Strips};

/// Unit of a lag state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Measure {
    /// Velocity in m/s.
    Velocity,
    /// Rate in rad/s.
    Rate,
    /// Angle in rad, or a dimensionless number.
    Number,
}

impl Strips {
    /// Lag states of the options in use, in m/s: those of the downwash due to motion and wind, and with a lifting line those of the induced
    /// downwash. Without gusts the gust lags change only through the latter.
    pub(crate) fn memories<'s>(&self, state: &'s mut StripState) -> impl Iterator<Item = &'s mut f64> + use<'s> {
        let StripOptions { unsteady, fit, tip_loss, .. } = self.options;
        let motion = if unsteady { fit.wagner().terms } else { 0 };
        let line = if unsteady && tip_loss.is_some() { fit.kuessner().terms } else { 0 };
        state.strips.iter_mut().flat_map(move |StripHistory { motion: lag, gust, .. }| {
            lag.followers_m_s[..motion].iter_mut().chain(&mut gust.followers_m_s[..line])
        })
    }
}
