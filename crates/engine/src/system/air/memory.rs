//! Aerodynamic quantities carried from one step to the next, as states of a periodic motion, NOTATION eq. (L32).

use crate::aero::memory::Measure;
use crate::aero::{AirModel, AirState};
use crate::load::Wrench;
use crate::system::air::start::flow;
use crate::system::air::{AirCoupling, AirHistory, Sample, gaps};
use crate::system::{PlantError, System};

impl AirCoupling {
    /// Quantities other than the motion of the sections on which later loads depend, in a fixed order: lag states of the effects in use,
    /// and for strips also the velocities from which eq. (Q4) continues. All other quantities follow from these and from the motion
    /// ([`System::refresh_air`]).
    pub fn memories<'h>(&self, history: &'h mut AirHistory) -> Vec<(Measure, &'h mut f64)> {
        let AirHistory { after, end, .. } = history;
        let mut list: Vec<(Measure, &'h mut f64)> = Vec::new();
        let mut samples: Vec<Option<&'h mut Sample>> = end.iter_mut().map(Some).collect();
        for ((model, sections), state) in self.model.each().zip(&mut after.0) {
            match (model, state) {
                (AirModel::Rotor(rotor), AirState::Rotor(state)) => rotor.memories(state, &mut list),
                (AirModel::Strips(strips), AirState::Strips(state)) => {
                    let own = sections.iter().filter_map(|section| samples[*section].take());
                    for Sample { motion, mean_m_s, mean_rad_s } in own {
                        let velocities = motion.velocity_m_s.iter_mut().chain(mean_m_s.iter_mut());
                        list.extend(velocities.map(|velocity| (Measure::Velocity, velocity)));
                        let rates = motion.spin_rad_s.iter_mut().chain(mean_rad_s.iter_mut());
                        list.extend(rates.map(|rate| (Measure::Rate, rate)));
                    }
                    list.extend(strips.memories(state).map(|lag| (Measure::Velocity, lag)));
                }
                (AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_), _) => {}
            }
        }
        list
    }
}

impl System {
    /// Makes the aerodynamics at the current time consistent with the motion and with its [`AirCoupling::memories`], both of which may have
    /// been changed: positions and attitudes of the sections, their relative velocities, and the circulatory loads at the start of the next
    /// step.
    ///
    /// # Errors
    /// If the aerodynamic model has no solution.
    pub(crate) fn refresh_air(&mut self, time_s: f64) -> Result<(), PlantError> {
        let Self { air: Some(air), state, equations, machine, .. } = self else { return Ok(()) };
        let air = &mut **air;
        air.observe(equations, &state.now);
        air.deflect(state, time_s)?;
        let AirCoupling { model, settings, motions, loads, .. } = air;
        let flow = flow(settings, state, time_s);
        let Some(history) = &mut state.air else { return Ok(()) };
        for ((motion, end), &instant) in motions.iter_mut().zip(&mut history.end).zip(model.instants()) {
            if instant {
                *end = Sample::steady(motion);
            } else {
                (end.motion.position_m, end.motion.rotation) = (motion.position_m, motion.rotation);
            }
            *motion = end.motion;
        }
        let AirHistory { before, after, loads: acting, at_begin, .. } = history;
        before.copy_from(after);
        // a step of zero length leaves the lag states unchanged
        model
            .solve(before, motions, &flow, 0.0, after, loads)
            .map_err(|error| gaps::failure(machine, settings, time_s, error))?;
        for (((motion, load), to), earlier) in motions.iter().zip(&loads.circulatory).zip(&mut acting.to).zip(at_begin)
        {
            let turned = motion.rotation.transpose();
            let now = Wrench { force_n: turned * load.force_n, moment_n_m: turned * load.moment_n_m };
            // keeps the difference by which the prediction of the next step extrapolates the current loads
            earlier.force_n += now.force_n - to.force_n;
            earlier.moment_n_m += now.moment_n_m - to.moment_n_m;
            *to = now;
        }
        self.configure();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::beam::profile::Profile as Along;
    use crate::beam::section::{Material, Solid};
    use crate::machine::{Air, Body, Joint, LiftingSurface, Machine, Motor};
    use crate::run::Plant;
    use std::sync::Arc;

    /// A pitching rigid wing with strip theory, after some steps.
    fn pitching() -> Plant {
        let drive = Motor { stiffness_n_m_rad: 5.0, damping_n_m_s_rad: 0.01, ..Motor::default() };
        let hinge = Joint::revolute("pitch", [1.0, 0.0, 0.0]).start_rate_rad_s(2.0).motor(drive);
        let material = Material { youngs_modulus_pa: 7e10, shear_modulus_pa: 3e10, density_kg_m3: 500.0 };
        let section = Solid::rectangle(0.3, 0.02, material);
        let machine = Machine::builder("Pitching")
            .body(Body::beam("wing", 1.0, section).elements(1), hinge)
            .air(Air::strips().density_kg_m3(1.2).wind_m_s([0.0, -15.0, 0.5]).step_s(0.005))
            .surface(LiftingSurface::on("wing", 2).chord_m(Along::constant(0.3)))
            .step_s(0.005)
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        for step in 1..=8 {
            plant.step(0.005 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
        }
        plant
    }

    /// Changed values of the memories at the current time persist when the aerodynamics is made consistent with them, and affect the
    /// following steps. Unchanged values have no effect.
    #[test]
    fn moved_memories_stay_and_act() {
        // values before and after the aerodynamics has been made consistent, and the angle some steps later
        let moved = |by: f64| {
            let mut plant = pitching();
            let time_s = plant.time_s();
            let system = plant.system_mut();
            let (Some(air), Some(history)) = (&system.air, &mut system.state.air) else { panic!("has air") };
            let set: Vec<f64> = air
                .memories(history)
                .into_iter()
                .map(|(_, value)| {
                    *value += by;
                    *value
                })
                .collect();
            system.refresh_air(time_s).unwrap_or_else(|error| panic!("{error}"));
            let (Some(air), Some(history)) = (&system.air, &mut system.state.air) else { panic!("has air") };
            let kept: Vec<f64> = air.memories(history).into_iter().map(|(_, value)| *value).collect();
            assert!(!set.is_empty());
            assert!(set == kept, "{by}: {set:?} has become {kept:?}");
            for step in 1..=4 {
                plant.step(time_s + 0.005 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
            }
            plant.outputs().joints()[0].angle_rad
        };
        let mut plant = pitching();
        let time_s = plant.time_s();
        for step in 1..=4 {
            plant.step(time_s + 0.005 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
        }
        let alone = plant.outputs().joints()[0].angle_rad;
        let [unmoved, acted] = [0.0, 0.5].map(moved);
        // the coupling in the previous step converged only to its tolerance
        assert!((unmoved - alone).abs() < 1e-6, "{unmoved} for {alone}");
        assert!((acted - unmoved).abs() > 1e-3, "{acted} for {unmoved}");
    }
}
