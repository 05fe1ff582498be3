//! Evaluation at the current instant: accelerations, aerodynamic loads and rates of the lag states from the coordinates, rates, lag states
//! and inputs, instead of the values interpolated over the steps.

use crate::solve::EquationsOfMotion;
use crate::system::air::instant_workspace::ContinuousAir;
use crate::system::events::settle;
use crate::system::{PlantError, System};

impl System {
    /// Elapsed fraction of the current aerodynamic step; 1 at its end.
    pub(crate) fn share_of_air_step(&self) -> f64 {
        let (Some(air), Some(history)) = (&self.air, &self.state.air) else { return 1.0 };
        match history.steps {
            0 => 1.0,
            _ => (1.0 - (history.loads.end_s - self.state.now.time_s) / air.settings.step_s).clamp(0.0, 1.0),
        }
    }

    /// Aerodynamic lag states at the current time in the order of linear models: linear over the aerodynamic step. `None` without lag
    /// states, [`System::air_is_linearised`].
    pub(crate) fn present_lags(&self, gusts: bool) -> Option<Vec<f64>> {
        let (air, history) = (self.air.as_ref()?, self.state.air.as_ref()?);
        let gusts = air.has_gust_lags(gusts);
        let [before, after] = [&history.before, &history.after].map(|states| air.model.lag_values(states, gusts));
        let share = self.share_of_air_step();
        Some(before?.iter().zip(after?).map(|(a, b)| a + (b - a) * share).collect())
    }

    /// Solves for the current accelerations, with the corresponding loads of strips, rotors and slender bodies; loads of lattices are kept
    /// constant, since lattices have no lag states. (Integrators find accelerations only to their tolerance, and interpolate aerodynamic
    /// loads linearly over an aerodynamic step.) `lags` replaces the current lag states.
    ///
    /// Returns the rates of the lag states in their units per s.
    ///
    /// # Errors
    /// If the mass matrix is singular, or if no consistent loads are found.
    pub(crate) fn settle_present(&mut self, lags: Option<&[f64]>) -> Result<Vec<f64>, PlantError> {
        let Self { equations, state, .. } = self;
        let (time_s, now) = (state.now.time_s, &mut state.now);
        // at a kink, a step that ends there uses the values before it
        let begun_s = state.start.time_s;
        equations.branch_s = if time_s > begun_s { 0.5 * (begun_s + time_s) } else { time_s };
        equations.prescribe(time_s, &mut now.q, &mut now.v, &mut now.a);
        equations.project(&mut now.q, &mut now.v, &mut now.a);
        let mut own = match &self.air {
            // its lag states are those of an external integrator
            Some(air) if air.continuous.is_some() => {
                self.hand_air_over();
                if let Some(lags) = lags {
                    self.set_lags(lags);
                }
                self.settle_in_air()?;
                let own = self.air.as_ref().and_then(|air| air.continuous.as_ref());
                return Ok(own.map_or_else(Vec::new, |own| own.lag_rates().to_vec()));
            }
            Some(air) => ContinuousAir::new(&air.model, air.settings.flaps.len(), air.has_gust_lags(false)),
            None => None,
        };
        if let (Some(own), Some(present)) = (&mut own, self.present_lags(false)) {
            own.lags.copy_from_slice(lags.unwrap_or(&present));
            self.settle_with(own)?;
            return Ok(own.lag_rates().to_vec());
        }
        let Self { equations, state, scratch, .. } = self;
        let now = &mut state.now;
        equations.residual(time_s, &now.q, &now.v, &now.a, &mut scratch[0]);
        let jump = settle(equations, &mut scratch[0], now);
        self.accelerations(time_s, jump)?;
        Ok(Vec::new())
    }
}
