//! Strips, rotors and slender bodies in a hybrid system: loads and rates of the lag states at an instant, with apparent mass proportional
//! to the accelerations, NOTATION eqs. (W13), (W15), (W21) and (W24).

use crate::aero::AirModels;
use crate::aero::strip::continuous::LOAD_ROWS;
use crate::aero::strip::instant::Instant;
use crate::load::Wrench;
use crate::multibody::motion::Motion;
use crate::multibody::station;
use crate::solve::EquationsOfMotion;
use crate::system::air::instant_workspace::ContinuousAir;
use crate::system::air::start::{flow, refusal};
use crate::system::air::{AirCoupling, AirHistory, Gain, Sample, gaps};
use crate::system::events::settle_by;
use crate::system::{PlantError, System};
use nalgebra::Vector3;
use std::borrow::Cow;

/// Maximum number of corrections of the accelerations for the apparent mass.
const MAXIMUM_CORRECTIONS: usize = 100;
/// Convergence threshold of the loads: change relative to the largest load, at the level of round-off.
const AGREED: f64 = 1e-12;
/// Convergence threshold of the accelerations relative to their round-off: if the air is light or slow compared with the structure, the
/// aerodynamic loads vanish in the round-off of the structural loads.
const AGREED_NOISES: f64 = 4.0;

/// Section wrenches from their rows.
pub(crate) fn write(rows: &[f64], loads: &mut [Wrench]) {
    for (load, row) in loads.iter_mut().zip(rows.chunks_exact(LOAD_ROWS)) {
        load.force_n.copy_from_slice(&row[..3]);
        load.moment_n_m.copy_from_slice(&row[3..]);
    }
}

impl System {
    /// Whether the machine has no aerodynamics, or an aerodynamic model that can be part of a hybrid system.
    pub(crate) fn air_is_continuous(&self) -> bool {
        self.air.as_ref().is_none_or(|air| air.continuous.is_some())
    }

    /// Number of aerodynamic lag states in a hybrid system.
    pub(crate) fn lag_count(&self) -> usize {
        self.air.as_ref().and_then(|air| air.continuous.as_ref()).map_or(0, |continuous| continuous.lags.len())
    }

    /// A lag state at the current time in its unit, and its rate per s, from the internal integrator: linear over the aerodynamic step.
    pub(crate) fn own_lag(&self, lag: usize) -> [f64; 2] {
        let (Some(air), Some(history)) = (&self.air, &self.state.air) else { return [0.0; 2] };
        let AirCoupling { model, continuous: Some(continuous), settings, .. } = &**air else { return [0.0; 2] };
        let [before, after] =
            [&history.before, &history.after].map(|states| model.lag_value(states, &continuous.stack, lag));
        if history.steps == 0 {
            return [after, 0.0];
        }
        let share = (1.0 - (history.loads.end_s - self.state.now.time_s) / settings.step_s).clamp(0.0, 1.0);
        [before + (after - before) * share, (after - before) / settings.step_s]
    }

    /// Takes over the lag states of the internal integrator at the current time. The state then stores the current values, for later calls,
    /// instead of those at the end of an unfinished aerodynamic step.
    pub(crate) fn hand_air_over(&mut self) {
        for lag in 0..self.lag_count() {
            let [own, _] = self.own_lag(lag);
            if let Some(continuous) = self.air.as_mut().and_then(|air| air.continuous.as_mut()) {
                continuous.lags[lag] = own;
            }
        }
        self.remember_lags();
        let time_s = self.state.now.time_s;
        if let Some(history) = &mut self.state.air {
            (history.loads.begin_s, history.loads.end_s) = (time_s, time_s);
            self.configure();
        }
    }

    /// Sets lag states from an external integrator: the state stores them, whether or not their rates are evaluated.
    pub(crate) fn set_lags(&mut self, lags: &[f64]) {
        if let Some(own) = self.air.as_mut().and_then(|air| air.continuous.as_mut()) {
            own.lags.copy_from_slice(lags);
        }
        self.remember_lags();
    }

    /// Stores the lag states in the state.
    fn remember_lags(&mut self) {
        let Some(air) = &self.air else { return };
        let AirCoupling { model, continuous: Some(own), .. } = &**air else { return };
        if let Some(history) = &mut self.state.air {
            for states in [&mut history.before, &mut history.after] {
                model.set_lags(&own.lags, &own.stack, states);
            }
        }
    }

    /// Solves for the current accelerations under the loads of all models, [`System::settle_with`], as an external integrator
    /// needs them: steps can continue from here.
    pub(crate) fn settle_in_air(&mut self) -> Result<(), PlantError> {
        let Some(mut own) = self.air.as_mut().and_then(|air| air.continuous.take()) else { return Ok(()) };
        let time_s = self.state.now.time_s;
        if let Some(history) = &mut self.state.air {
            (history.loads.begin_s, history.loads.end_s) = (time_s, time_s);
        }
        let settled = self.settle_with(&mut own);
        let Self { state, air, .. } = self;
        if let (Some(air), Some(history), Ok(())) = (air.as_mut(), &mut state.air, &settled) {
            for (end, motion) in history.end.iter_mut().zip(&air.motions) {
                *end = Sample::steady(motion);
            }
            history.begin.copy_from_slice(&history.end);
            history.start_s = time_s;
            history.at_begin.copy_from_slice(&history.loads.to);
            (history.carried_m, history.gain, history.steps) = (Vector3::zeros(), Gain::default(), 0);
        }
        if let Some(air) = air {
            air.continuous = Some(own);
        }
        settled
    }

    /// Solves for the current accelerations under aerodynamic loads, with these loads and the rates of the lag states: `M a + r(L) = 0` and
    /// `L = L(a)`, eq. (W15). The equations must have been updated to the prescribed motions and projected. Allocates nothing.
    pub(super) fn settle_with(&mut self, own: &mut ContinuousAir) -> Result<(), PlantError> {
        let Self { equations, state, scratch, air, machine, .. } = self;
        let (time_s, none) = (state.now.time_s, Ok(()));
        let Some(air) = air else { return none };
        air.deflect(state, time_s)?;
        let AirCoupling { model, motions, settings, length_m, deflections, .. } = &mut **air;
        own.guess.fill(0.0);
        own.anderson.restart();
        let mut found = false;
        for correction in 0..MAXIMUM_CORRECTIONS {
            let now = &state.now;
            equations.residual(time_s, &now.q, &now.v, &now.a, &mut scratch[0]);
            let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
            let places = &equations.model.stations[equations.load_stations..];
            for ((observed, acceleration), place) in motions.iter_mut().zip(&mut own.accelerations).zip(places) {
                let section = station::accelerated(&equations.model, &equations.work, motion, place);
                *observed = section.motion;
                *acceleration = [section.acceleration_m_s2, section.spin_rate_rad_s2];
            }
            let at = Instant {
                motions: Cow::Borrowed(motions),
                accelerations: Cow::Borrowed(&own.accelerations),
                flow: flow(settings, state, time_s),
                gust_m_s: Vector3::zeros(),
                lags: Cow::Borrowed(&own.lags),
                flaps: Cow::Borrowed(deflections),
                flap_rad_s2: Cow::Borrowed(&own.flap_rad_s2),
            };
            model.respond(&at, &mut own.stack, &mut own.answer);
            let (change_n, size_n) = own.compare(*length_m);
            if !change_n.is_finite() {
                return Err(refusal(time_s, "the loads are not finite"));
            }
            // the first guess is arbitrary: its loads and accelerations are not consistent
            found = correction > 0 && change_n <= AGREED * size_n;
            if found {
                break;
            }
            // the residual of accelerations that satisfy these loads is round-off
            let noise_1_s2 = if correction > 0 { equations.solve(&mut scratch[0]) } else { 0.0 };
            if correction == 0 {
                let loads = own.guess.len();
                own.guess.copy_from_slice(&own.answer[..loads]);
            } else {
                own.anderson.next(&mut own.guess, &own.residual);
            }
            let Some(history) = &mut state.air else { return none };
            write(&own.guess, &mut history.loads.to);
            history.loads.from.copy_from_slice(&history.loads.to);
            history.loads.impulsive.fill(Wrench::default());
            history.scale_n = history.scale_n.max(size_n);
            if let Some(loads) = &mut equations.air {
                loads.copy_from(&history.loads);
            }
            let now = &mut state.now;
            equations.residual(time_s, &now.q, &now.v, &now.a, &mut scratch[0]);
            let jump = match correction {
                0 => equations.factorize(1.0, 0.0, 0.0).map(|()| settle_by(equations, &mut scratch[0], now)),
                _ => Ok(settle_by(equations, &mut scratch[0], now)),
            };
            match jump {
                Ok(jump) if jump.is_finite() => found = correction > 0 && jump <= AGREED_NOISES * noise_1_s2,
                _ => return self.accelerations(time_s, jump).map(|_| ()),
            }
            if found {
                break;
            }
        }
        if let Some(failure) = model.invalid() {
            return Err(gaps::failure(machine, settings, time_s, failure));
        }
        if !found {
            let cause = format!(
                "accelerations and apparent mass did not converge in {MAXIMUM_CORRECTIONS} corrections; if the \
                 apparent mass is large compared with the mass of the structure, write apparent_mass = false"
            );
            return Err(PlantError::Surroundings { time_s, cause });
        }
        if let Some(history) = &mut state.air {
            remember(model, own, history);
        }
        none
    }
}

/// Stores the last response in the states at both ends of the step.
fn remember(model: &AirModels, own: &ContinuousAir, history: &mut AirHistory) {
    for states in [&mut history.before, &mut history.after] {
        model.remember(&own.lags, &own.stack, states);
    }
}
