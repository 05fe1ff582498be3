//! Evaluation at the current instant: accelerations, aerodynamic loads and rates of the lag states from the coordinates, rates, lag states
//! and inputs, instead of the values interpolated over the steps.

use crate::aero::rotor::loads::RotorLoads;
use crate::aero::strip::continuous::LOAD_ROWS;
use crate::aero::strip::instant::Instant;
use crate::aero::{AirModel, AirState};
use crate::load::Wrench;
use crate::multibody::kinematics::Motion;
use crate::multibody::station;
use crate::solve::EquationsOfMotion;
use crate::system::air::continuous::write;
use crate::system::air::slopes::Continuous;
use crate::system::air::start::flow;
use crate::system::air::{AirCoupling, StepLoads};
use crate::system::events::settle;
use crate::system::{PlantError, System};
use nalgebra::Vector3;
use std::borrow::Cow;

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
        let [before, after] = [&history.before, &history.after].map(|state| Continuous::lags(&air.model, state, gusts));
        let share = self.share_of_air_step();
        Some(before?.iter().zip(after?).map(|(a, b)| a + (b - a) * share).collect())
    }

    /// Solves for the current accelerations, with the corresponding loads of strips and rotors; loads of lattices are kept constant, since
    /// lattices have no lag states. (Integrators find accelerations only to their tolerance, and interpolate aerodynamic loads linearly
    /// over an aerodynamic step.) `lags` replaces the current lag states.
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
        let rates = match self.air.as_ref().map(|air| air.model.only()) {
            Some(None | Some(AirModel::SlenderBody(_))) => return Err(self.several_airs()),
            Some(Some(AirModel::Strips(_))) => {
                self.hand_air_over();
                let own = self.air.as_ref().and_then(|air| air.continuous.as_ref());
                let own = own.map_or_else(Vec::new, |own| own.lags_m_s.clone());
                self.set_lags(lags.unwrap_or(&own));
                self.settle_in_air()?;
                let own = self.air.as_ref().and_then(|air| air.continuous.as_ref());
                return Ok(own.map_or_else(Vec::new, |own| own.lag_rates_m_s2().to_vec()));
            }
            Some(Some(AirModel::Rotor(_))) => self.load_rotor(lags),
            Some(Some(AirModel::Lattice(_))) | None => Vec::new(),
        };
        let Self { equations, state, scratch, .. } = self;
        let now = &mut state.now;
        equations.residual(time_s, &now.q, &now.v, &now.a, &mut scratch[0]);
        let jump = settle(equations, &mut scratch[0], now);
        self.accelerations(time_s, jump)?;
        Ok(rates)
    }

    /// Sets the loads of a rotor for the current motion: without apparent mass, accelerations have no effect.
    fn load_rotor(&mut self, lags: Option<&[f64]>) -> Vec<f64> {
        let present = self.present_lags(false).unwrap_or_default();
        let Self { equations, state, scratch, air, .. } = self;
        let time_s = state.now.time_s;
        let now = &state.now;
        equations.residual(time_s, &now.q, &now.v, &now.a, &mut scratch[0]);
        let Some(air) = air else { return Vec::new() };
        let AirCoupling { model, motions, settings, .. } = &mut **air;
        let Some(AirModel::Rotor(rotor)) = model.only_mut() else { return Vec::new() };
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        for (observed, place) in motions.iter_mut().zip(&equations.model.stations[equations.load_stations..]) {
            *observed = station::accelerated(&equations.model, &equations.work, motion, place).motion;
        }
        let at = Instant {
            motions: Cow::Borrowed(motions),
            accelerations: Cow::Owned(vec![[Vector3::zeros(); 2]; motions.len()]),
            flow: flow(settings, state, time_s),
            gust_m_s: Vector3::zeros(),
            lags: Cow::Borrowed(lags.unwrap_or(&present)),
            flaps: Cow::Borrowed(&[]),
            flap_rad_s2: Cow::Borrowed(&[]),
        };
        let answer = rotor.answer(&at);
        let (loads, rest) = answer.split_at(LOAD_ROWS * motions.len());
        let (rates, own) = rest.split_at(rest.len() - size_of::<RotorLoads>() / size_of::<f64>());
        let Some(history) = &mut state.air else { return Vec::new() };
        let StepLoads { from, to, impulsive, .. } = &mut history.loads;
        write(loads, to);
        from.copy_from_slice(to);
        impulsive.fill(Wrench::default());
        for side in [&mut history.before, &mut history.after] {
            if let Some(AirState::Rotor(side)) = side.only_mut() {
                bytemuck::cast_slice_mut(std::slice::from_mut(&mut side.loads)).copy_from_slice(own);
            }
        }
        if let Some(loads) = &mut equations.air {
            loads.copy_from(&history.loads);
        }
        rates.to_vec()
    }
}
