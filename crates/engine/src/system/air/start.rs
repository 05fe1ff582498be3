//! Aerodynamics at the start of a run and when a step is cut.

use crate::aero::established::Established;
use crate::aero::flow::Flow;
use crate::machine;
use crate::solve::EquationsOfMotion;
use crate::system::air::{AirCoupling, AirHistory, Sample, gaps};
use crate::system::state::State;
use crate::system::{PlantError, System};

/// Flow at a time, with the wind and the angular velocity of the root frame at that time.
pub(crate) fn flow<'a>(settings: &'a machine::Air, state: &State, time_s: f64) -> Flow<'a> {
    Flow {
        time_s,
        density_kg_m3: state.applied_parameters.air_density_kg_m3(),
        wind_m_s: state.wind_at_m_s(time_s),
        spin_rad_s: state.spin_at_rad_s(time_s),
        gusts: &settings.gusts,
    }
}

/// Error if the aerodynamic model has no solution.
pub(crate) fn refusal(time_s: f64, cause: impl std::fmt::Display) -> PlantError {
    PlantError::Air { time_s, cause: cause.to_string() }
}

impl System {
    /// Initialises the aerodynamics at the start of the run, with the loads for the current motion. If an aerodynamic state exists since
    /// [`System::start`], strips of a lattice continue from its circulation, eq. (U32), so that a search for an equilibrium stays on one of
    /// several branches.
    pub(crate) fn start_air(&mut self, time_s: f64) -> Result<(), PlantError> {
        let Some(air) = &mut self.air else { return Ok(()) };
        let now = &self.state.now;
        self.equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
        air.observe(&self.equations, now);
        air.deflect(&self.state, time_s)?;
        let mut history = air.blank.clone();
        if let Some(earlier) = &self.state.air {
            history.after.go_on_from(&earlier.after);
        }
        let AirCoupling { model, settings, motions, loads, .. } = &mut **air;
        if let Some(blade) = model.blade_along_shaft(motions) {
            let name = &self.machine.bodies[settings.surfaces[blade].body].name;
            let cause = format!(
                "blade {name} is parallel to the shaft; x of a blade's body points from its root to its tip, across the shaft"
            );
            return Err(refusal(time_s, cause));
        }
        let flow = flow(settings, &self.state, time_s);
        let turning = self.equations.spatial.iter().any(|joint| joint.flies);
        let established = settings.established.then_some(Established { step_s: settings.step_s, turning });
        model
            .start(motions, &flow, established, &mut history.after, loads)
            .map_err(|error| gaps::failure(&self.machine, settings, time_s, error))?;
        if let Some(error) = gaps::crossing(&self.machine, settings, model, time_s) {
            return Err(error);
        }
        air.read(&history.loads);
        let (change_n, size_n) = air.compare();
        if !change_n.is_finite() {
            return Err(refusal(time_s, "the loads are not finite"));
        }
        air.accept();
        history.start_s = time_s;
        history.scale_n = size_n;
        (history.loads.begin_s, history.loads.end_s) = (time_s, time_s);
        air.write(&mut history.loads);
        history.loads.from.clone_from(&history.loads.to);
        history.at_begin.clone_from(&history.loads.to);
        history.before.copy_from(&history.after);
        for (end, motion) in history.end.iter_mut().zip(&air.motions) {
            *end = Sample::steady(motion);
        }
        history.begin.copy_from_slice(&history.end);
        self.state.air = Some(history);
        self.configure();
        Ok(())
    }

    /// Ends the effect of the previous inputs in the current step at the current time, because they change now.
    pub(crate) fn cut_step(&mut self) {
        let time_s = self.state.now.time_s;
        let Some(begin_s) = self.state.air.as_ref().map(|history| history.loads.begin_s) else { return };
        // exact for a wind that varies linearly
        let wind_m_s = self.state.wind_at_m_s(0.5 * (begin_s + time_s));
        let rate_m_s2 = self.state.applied_rates.wind_m_s();
        let Some(AirHistory { loads, carried_m, gain, .. }) = &mut self.state.air else { return };
        if time_s > loads.begin_s && time_s < loads.end_s {
            *carried_m += wind_m_s * (time_s - loads.begin_s);
            *gain = gain.after(time_s - loads.begin_s, rate_m_s2);
            loads.begin_s = time_s;
        }
    }
}
