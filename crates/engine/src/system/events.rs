//! Discontinuities: initialisation, changed inputs, transitions of forces.

use crate::force::Outcome;
use crate::force::memory::Told;
use crate::multibody::dynamics::Damping;
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Singular, control};
use crate::system::PlantError;
use crate::system::System;
use crate::system::equations::Equations;
use crate::system::failure_memory;
use crate::system::joint_forces;
use crate::system::state::State;
use std::sync::Arc;

/// Maximum length of the first step after a crossing, as a fraction of the step before the crossing.
const STEP_SHARE_AFTER_CROSSING: f64 = 0.1;
/// Limit of the displacement relative to the model's length, or of the rotation of a section in rad, that a jump of the accelerations may
/// cause within an aerodynamic step: a light wing in a suddenly applied wind reaches 1, by the twist of its sections.
const MAXIMUM_LENGTHS: f64 = 100.0;

impl System {
    /// Rolls back to the start of the current step, but keeps the inputs and parameters set by the caller.
    pub(crate) fn go_back_to_begin(&mut self) {
        self.begin.inputs.clone_from(&self.state.inputs);
        self.begin.parameters.clone_from(&self.state.parameters);
        self.state.copy_from(&self.begin);
        self.configure();
    }

    /// Updates the equations to the applied inputs and parameters and to the states of the joints.
    pub(crate) fn configure(&mut self) {
        let State { applied_inputs: inputs, applied_parameters: parameters, joints, air, .. } = &self.state;
        let equations = &mut self.equations;
        equations.course.follow(&self.state);
        equations.root = *inputs.root();
        equations.stations[..equations.load_stations].copy_from_slice(inputs.stations());
        if let Some(loads) = &mut equations.air {
            match air {
                Some(history) => loads.copy_from(&history.loads),
                None => loads.clear(),
            }
        }
        let loads = inputs.stations().iter().chain(self.state.applied_rates.stations());
        equations.loaded = equations.air.is_some() || loads.into_iter().any(|load| !load.is_zero());
        let bodies = equations.model.bodies.iter().zip(parameters.bodies());
        for (damping, (body, parameters)) in equations.damping.iter_mut().zip(bodies) {
            *damping = match body.modal {
                // modal damping ratios apply instead
                Some(_) => Damping::default(),
                None => Damping {
                    mass_1_s: parameters.mass_damping_1_s,
                    stiffness_s: parameters.stiffness_damping_s,
                    strain_inertia_s2: self.exchange.strain_inertia_s2,
                },
            };
        }
        joint_forces::set(&mut equations.forces, inputs, parameters);
        for (joint, memory) in equations.forces.joints_mut().iter_mut().zip(joints) {
            joint.recall(memory);
        }
        equations.seat(joints);
        self.impose_failures();
    }

    /// Whether inputs or parameters differ from those of the current step. Always true for inputs that vary in time: their step ends at the
    /// communication point.
    pub(crate) fn inputs_changed(&self) -> bool {
        let State { inputs, rates, parameters, applied_inputs, applied_rates, applied_parameters, .. } = &self.state;
        inputs != applied_inputs || parameters != applied_parameters || !rates.is_still() || !applied_rates.is_still()
    }

    /// Cuts the integrator's step at the current time and continues with the new inputs and parameters.
    pub(crate) fn apply_inputs(&mut self) -> Result<(), PlantError> {
        let State { start, now, .. } = &mut self.state;
        start.copy_from(now);
        // interpolation errors violate the constraints of the joint parameters
        self.equations.project(&mut start.q, &mut start.v, &mut start.a);
        if let Err(error) = self.equations.close_point(start) {
            return Err(self.not_closed(&self.state.start, &error));
        }
        self.cut_step();
        let machine = Arc::clone(&self.machine);
        self.event(|state, equations| {
            let time_s = state.start.time_s;
            let at_end = time_s >= state.ahead.time_s;
            state.applied_inputs.clone_from(&state.inputs);
            state.applied_rates.clone_from(&state.rates);
            state.applied_from_s = time_s;
            state.applied_parameters.clone_from(&state.parameters);
            let mut outcome = Outcome::default();
            let State { start, joints, failures, inputs, rates, parameters, .. } = state;
            for (i, (forces, memory)) in equations.forces.joints().iter().zip(joints).enumerate() {
                let mut told = Told {
                    time_s,
                    at_end,
                    release: inputs.joints()[i].release.is_on(),
                    latch_enable: inputs.joints()[i].latch_enable.is_on(),
                    command_rad: inputs.joints()[i].command_rad,
                    command_rate_rad_s: rates.joints()[i].command_rad,
                    rate_limit_rad_s: parameters.joints()[i].rate_limit_rad_s,
                };
                failure_memory::tell(&machine.failures, failures, forces.body, memory, &mut told);
                outcome.add(forces.take_inputs(&told, start, memory));
            }
            outcome
        })?;
        self.fail()
    }

    /// Performs the events at the end of a step: transitions of the forces whose indicators have been crossed, and the kink at the end of
    /// the step.
    pub(crate) fn apply_events(&mut self) -> Result<(), PlantError> {
        for (forces, memory) in self.equations.forces.joints().iter().zip(&mut self.state.joints) {
            forces.mark_overdue(&self.state.start, memory);
        }
        if self.state.joints.iter().any(|joint| joint.crossed != 0) {
            self.state.step_s *= STEP_SHARE_AFTER_CROSSING;
        } else if !self.equations.kink_at(self.state.start.time_s) {
            return Ok(());
        }
        self.make_transitions()?;
        // an impulse changes the rates of other joints, and thereby the state of their forces
        for (forces, memory) in self.equations.forces.joints().iter().zip(&mut self.state.joints) {
            forces.mark_overdue(&self.state.start, memory);
        }
        if self.state.joints.iter().any(|joint| joint.crossed != 0) {
            self.make_transitions()?;
        }
        self.fail()
    }

    pub(crate) fn make_transitions(&mut self) -> Result<(), PlantError> {
        self.event(|state, equations| {
            let mut outcome = Outcome::default();
            for (forces, memory) in equations.forces.joints().iter().zip(&mut state.joints) {
                outcome.add(forces.make_transitions(&state.start, memory));
            }
            outcome
        })
    }

    /// Changes the equations at `start` as [`System::discontinuity`] does, and shortens the next step by the jump.
    pub(crate) fn event(&mut self, change: impl FnOnce(&mut State, &Equations) -> Outcome) -> Result<(), PlantError> {
        let jump = self.discontinuity(change)?;
        // after an impulse, the accelerations are computed with the rates before it: the stiffest modes ring, but without large
        // displacements, however large the accelerations are
        if !jump.by_impulse {
            self.refuse_leap(Place::Start, jump.norm_1_s2)?;
        }
        self.restrain_step(jump.norm_1_s2);
        Ok(())
    }

    /// Returns an error, with the probable input as the cause, if the accelerations are too large for an aerodynamic step: within the step
    /// they would move a part of the wing by many times its length. Displacements of stiff modes are limited by their springs and dampers,
    /// however large the accelerations are, so the displacement in an implicit step is decisive.
    pub(crate) fn refuse_leap(&mut self, at: Place, jump_norm_1_s2: f64) -> Result<(), PlantError> {
        let Some(air) = &self.machine.air else { return Ok(()) };
        let step_s = air.step_s;
        let lengths = |norm_1_s2: f64| 0.5 * norm_1_s2 * step_s * step_s;
        let point = match at {
            Place::Now => &self.state.now,
            Place::Start => &self.state.start,
        };
        let time_s = point.time_s;
        if lengths(jump_norm_1_s2) <= MAXIMUM_LENGTHS {
            return Ok(());
        }
        let [residual, still] = &mut self.scratch;
        still.fill(0.0);
        self.equations.residual(time_s, &point.q, &point.v, still, residual);
        let free = jump_norm_1_s2;
        let held = match self.equations.factorize(1.0, step_s, step_s * step_s) {
            Ok(()) => self.equations.solve(residual),
            Err(_) => free,
        };
        self.equations.factorize(1.0, 0.0, 0.0).map_err(|singular| self.no_accelerations(time_s, singular))?;
        let lengths = lengths(held.min(free));
        if lengths <= MAXIMUM_LENGTHS {
            return Ok(());
        }
        Err(PlantError::Leap { time_s, lengths, step_s, cause: self.largest_input() })
    }

    /// Changes the equations at `start` and solves again for the accelerations; the current step then has zero length.
    ///
    /// `change` returns the energy that it dissipates and counts its events; the remainder of the jump of the potentials is booked as work.
    /// Joints that are held after the change stop instantaneously, eq. (A6), and the energy lost is booked as dissipated. The accelerations
    /// change by the solution for the change of the residual, so that interpolation errors in stiff modes are not multiplied by the
    /// stiffness.
    pub(crate) fn discontinuity(
        &mut self,
        change: impl FnOnce(&mut State, &Equations) -> Outcome,
    ) -> Result<Jump, PlantError> {
        let old = &mut self.scratch[0];
        let start = &self.state.start;
        let time_s = start.time_s;
        self.equations.residual(time_s, &start.q, &start.v, &start.a, old);
        let before = self.equations.potentials(time_s, &start.q).total();
        let Outcome { mut dissipated_j, events, failed } = change(&mut self.state, &self.equations);
        self.state.statistics.events += events;
        let crossed = self.cross_borders().map_err(|singular| self.no_accelerations(time_s, singular))?;
        let mut stopped = self.stop_held_joints().map_err(|singular| self.no_accelerations(time_s, singular))?;
        stopped.lost_j += crossed.lost_j;
        stopped.work_j += crossed.work_j;
        self.refuse_off_beam(&self.state.start)?;
        let of_loops_j = if failed {
            let start = &self.state.start;
            self.equations.loop_kinetic_at_j(time_s, [&start.q, &start.v, &start.a], &mut self.scratch[1])
        } else {
            0.0
        };
        self.configure();
        self.equations.branch_s = time_s;

        let [old, new_residual] = &mut self.scratch;
        let start = &mut self.state.start;
        self.equations.prescribe(time_s, &mut start.q, &mut start.v, &mut start.a);
        self.equations.residual(time_s, &start.q, &start.v, &start.a, new_residual);
        let after = self.equations.potentials(time_s, &start.q).total();
        subtract_rest(&self.equations, new_residual, old);
        if failed {
            // a failure does no work: the energy stored in springs and loops is dissipated
            dissipated_j += (before - after - dissipated_j).max(0.0);
            stopped.lost_j += of_loops_j - self.equations.loop_kinetic_j();
        }
        let jump = settle(&mut self.equations, new_residual, start);
        let jump = self.accelerations(time_s, jump)?;
        let start = &mut self.state.start;
        start.dissipated += dissipated_j + stopped.lost_j;
        start.work += after - before + dissipated_j + stopped.work_j;
        let State { before, start, ahead, .. } = &mut self.state;
        ahead.copy_from(start);
        before.copy_from(start);
        Ok(Jump { norm_1_s2: jump, by_impulse: stopped.lost_j > 0.0 })
    }

    /// Returns the jump of accelerations just solved for, or an error if there is none.
    pub(crate) fn accelerations(&self, time_s: f64, jump: Result<f64, Singular>) -> Result<f64, PlantError> {
        let cause = match jump {
            Ok(jump) if jump.is_finite() => return Ok(jump),
            Ok(_) => format!("the accelerations are not finite; {}", self.largest_input()),
            Err(singular) => return Err(self.no_accelerations(time_s, singular)),
        };
        Err(PlantError::Initialization { time_s, cause })
    }

    fn no_accelerations(&self, time_s: f64, singular: Singular) -> PlantError {
        let place = self.place_of(singular.coordinate);
        let cause = if self.is_joint(singular.coordinate) {
            format!(
                "the mass matrix has no positive pivot at {place}: the carried bodies have no inertia along or about \
                 one of this joint's axes"
            )
        } else {
            format!("the mass matrix has no positive pivot at {place}")
        };
        PlantError::Initialization { time_s, cause }
    }

    /// Shortens the next step after a jump of the accelerations.
    pub(crate) fn restrain_step(&mut self, jump_norm_1_s2: f64) {
        let parameters = &self.state.applied_parameters;
        let (min_step_s, max_step_s) = (parameters.solver().min_step_s, parameters.solver().max_step_s);
        let short_s = control::after_jump(jump_norm_1_s2, parameters.solver().tolerance);
        self.state.step_s = self.state.step_s.min(short_s).max(min_step_s).min(max_step_s);
        if let Some(history) = &mut self.state.air
            && short_s < max_step_s
        {
            let bound_s = if history.after_jump_s > 0.0 { history.after_jump_s } else { f64::INFINITY };
            history.after_jump_s = bound_s.min(short_s.max(min_step_s));
        }
    }
}

/// Point of the system's state.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// The point of the outputs.
    Now,
    /// The point at the start of the next step.
    Start,
}

/// Jump of the accelerations at a discontinuity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jump {
    /// Kinematic norm of the jump in 1/s².
    pub(crate) norm_1_s2: f64,
    /// Whether a moving joint was stopped, which changed the rates too.
    pub(crate) by_impulse: bool,
}

/// Subtracts the residual before an event from that behind it: the rest of Newton's iteration does not change accelerations. With redundant
/// parameters it is the rest of their projection, (J6), and the accelerations behind an event are those of the equations.
pub(crate) fn subtract_rest(equations: &Equations, new: &mut [f64], old: &[f64]) {
    if equations.spatial.is_empty() {
        new.iter_mut().zip(old).for_each(|(new, old)| *new -= old);
    }
}

/// Subtracts the solution of the mass matrix for `residual` from the accelerations of `point`; returns the kinematic norm of the jump in
/// 1/s². `point` is unchanged if the norm is not finite.
pub(crate) fn settle(equations: &mut Equations, residual: &mut [f64], point: &mut Point) -> Result<f64, Singular> {
    equations.factorize(1.0, 0.0, 0.0)?;
    Ok(settle_by(equations, residual, point))
}

/// Like [`settle`], with the factors of the mass matrix that the equations already hold.
pub(crate) fn settle_by(equations: &mut Equations, residual: &mut [f64], point: &mut Point) -> f64 {
    let jump = equations.solve(residual);
    if !jump.is_finite() {
        return jump;
    }
    for (i, step) in residual.iter().enumerate() {
        point.a[i] -= step;
        point.auxiliary[i] -= step;
    }
    for joint in equations.forces.joints().iter().filter(|joint| joint.held) {
        point.auxiliary[joint.coordinate] = point.a[joint.coordinate];
    }
    point.powers = equations.powers(point.time_s, &point.q, &point.v, &point.a);
    jump
}
