//! Failures: their triggers and effects. A failure replaces inputs and parameters of the forces on a joint, or reduces a stiffness; its
//! events, impulses and energy accounts are treated like those of other events, NOTATION eq. (A10).

use crate::force::Outcome;
use crate::force::memory::Told;
use crate::machine::Machine;
use crate::machine::failure::{Effect, Failure};
use crate::solve::EquationsOfMotion;
use crate::system::equations::Equations;
use crate::system::failure_memory::{FailureMemory, bring_about, next_s, tell};
use crate::system::state::State;
use crate::system::{PlantError, System};
use std::sync::Arc;

impl System {
    /// Performs the failures that are due at `start`, including those that they trigger.
    pub(crate) fn fail(&mut self) -> Result<(), PlantError> {
        if self.state.failures.is_empty() {
            return Ok(());
        }
        let machine = Arc::clone(&self.machine);
        // the impulse of a failure may trigger another
        for _ in 0..=machine.failures.len() {
            if !self.bring_failures_about(&machine) {
                break;
            }
            self.event(|state, equations| change(&machine, state, equations))?;
            for (forces, memory) in self.equations.forces.joints().iter().zip(&mut self.state.joints) {
                forces.mark_overdue(&self.state.start, memory);
            }
            if self.state.joints.iter().any(|joint| joint.crossed != 0) {
                self.make_transitions()?;
            }
        }
        self.equations.failure_s = next_s(&machine.failures, &self.state.failures);
        Ok(())
    }

    /// Triggers the failures at `start`, and returns whether one occurs.
    fn bring_failures_about(&mut self, machine: &Machine) -> bool {
        let State { start, joints, failures, applied_inputs, .. } = &mut self.state;
        let forces = self.equations.forces.joints();
        let tripped = |index: usize| {
            machine.failures[index].when.is_some()
                && forces.iter().zip(joints.iter()).any(|(joint, memory)| joint.has_tripped(index, memory))
        };
        let on = |index: usize| applied_inputs.failures()[index].is_on();
        bring_about(&machine.failures, failures, start.time_s, on, tripped)
    }

    /// Applies the failures that have occurred to the equations. Allocates nothing.
    pub(crate) fn impose_failures(&mut self) {
        if self.machine.failures.is_empty() {
            return;
        }
        let (failures, memories) = (&self.machine.failures, &self.state.failures);
        let equations = &mut self.equations;
        equations.failure_s = next_s(failures, memories);
        // bounds that are already exceeded at `start`
        let waits = |index: usize| failures[index].when.is_some() && memories[index].brought_s.is_none();
        let tripped = equations.forces.joints().iter().zip(&self.state.joints);
        if tripped.clone().any(|(joint, memory)| (0..memories.len()).any(|i| waits(i) && joint.has_tripped(i, memory)))
        {
            equations.failure_s = f64::NEG_INFINITY;
        }
        for joint in equations.forces.joints_mut() {
            for brake in joint.slipping_brakes_mut() {
                brake.from_s = memories.get(brake.failure).and_then(|m| m.failed_s).unwrap_or(f64::INFINITY);
            }
            if let Some(motor) = joint.motor_mut() {
                motor.deaf = false;
            }
        }
        let weakened = !equations.sound.is_empty();
        if weakened {
            for (element, sound) in equations.model.elements.iter_mut().zip(&equations.sound) {
                element.elastic.clone_from(&sound.elastic);
                if let (Some(own), Some(sound)) = (&mut element.sheared, &sound.sheared) {
                    own.clone_from(sound);
                }
            }
        }
        for (failure, _) in failures.iter().zip(memories).filter(|(_, memory)| memory.has_failed()) {
            impose(&failure.effect, equations);
        }
        self.weaken_loops();
    }

    /// Scales the penalties of closed loops by the product of the remaining stiffness fractions of all failures that have occurred.
    pub(crate) fn weaken_loops(&mut self) {
        let (failures, memories) = (&self.machine.failures, &self.state.failures);
        let left = |failure: &Failure, memory: &FailureMemory| match failure.effect {
            Effect::LoopBreak { closure, remaining } => {
                Some((closure, if memory.has_failed() { remaining } else { 1.0 }))
            }
            Effect::MotorLoss { .. }
            | Effect::MotorJam { .. }
            | Effect::MotorRunaway { .. }
            | Effect::LatchBreak { .. }
            | Effect::LatchNoCapture { .. }
            | Effect::LockRelease { .. }
            | Effect::SpringBreak { .. }
            | Effect::StiffnessLoss { .. }
            | Effect::BrakeApplied { .. } => None,
        };
        for (failure, memory) in failures.iter().zip(memories) {
            let Some((closure, _)) = left(failure, memory) else { continue };
            let described = &self.machine.closures[closure];
            let of_loop = failures.iter().zip(memories).filter_map(|(failure, memory)| left(failure, memory));
            let share: f64 = of_loop.filter(|&(of, _)| of == closure).map(|(_, share)| share).product();
            let earlier = self.machine.closures[..closure].iter().filter(|closure| !closure.rigid).count();
            let penalty = &mut self.equations.model.closures[earlier].penalty;
            penalty.inertia_kg = share * described.inertia_kg;
            penalty.damping_n_s_m = share * described.damping_n_s_m;
            penalty.stiffness_n_m = share * described.stiffness_n_m;
        }
    }
}

/// Applies the effect of a failure that has occurred to the equations.
fn impose(effect: &Effect, equations: &mut Equations) {
    match *effect {
        Effect::MotorLoss { body } => {
            let Some(joint) = joint_on(equations, body) else { return };
            if let Some(motor) = joint.motor_mut() {
                motor.drive.stiffness_n_m_rad = 0.0;
                motor.drive.damping_n_m_s_rad = 0.0;
                motor.drive.constant_torque_n_m = 0.0;
            }
            if let Some(generator) = joint.generator_mut() {
                generator.connected = false;
            }
        }
        Effect::MotorRunaway { body, .. } => {
            if let Some(motor) = joint_on(equations, body).and_then(|joint| joint.motor_mut()) {
                motor.deaf = true;
            }
        }
        Effect::SpringBreak { body, remaining } => {
            if let Some(spring) = joint_on(equations, body).and_then(|joint| joint.spring_mut()) {
                spring.stiffness_n_m_rad *= remaining;
                spring.damping_n_m_s_rad *= remaining;
            }
            let spatial = equations.forces.spatial_mut().iter_mut().find(|joint| joint.body == body);
            if let Some(spring) = spatial.and_then(|joint| joint.attitude_mut()) {
                spring.stiffness_n_m_rad *= remaining;
                spring.damping_n_m_s_rad *= remaining;
            }
        }
        Effect::StiffnessLoss { body, remaining } => {
            let described = &equations.model.bodies[body];
            let own = described.first_element..described.first_element + described.elements;
            for element in &mut equations.model.elements[own] {
                element.elastic.scale(remaining);
                if let Some(elastic) = &mut element.sheared {
                    elastic.scale(remaining);
                }
            }
        }
        // applied through inputs and parameters, or for all brakes and loops together
        Effect::MotorJam { .. }
        | Effect::LatchBreak { .. }
        | Effect::LatchNoCapture { .. }
        | Effect::LockRelease { .. }
        | Effect::LoopBreak { .. }
        | Effect::BrakeApplied { .. } => {}
    }
}

fn joint_on(equations: &mut Equations, body: usize) -> Option<&mut crate::force::joint::JointForces> {
    equations.forces.joints_mut().iter_mut().find(|joint| joint.body == body)
}

/// Performs the transitions of the joints on which a failure occurs at `start`.
fn change(machine: &Machine, state: &mut State, equations: &Equations) -> Outcome {
    let time_s = state.start.time_s;
    let fails_now = |memory: &FailureMemory| memory.failed_s == Some(time_s);
    let count = state.failures.iter().filter(|memory| fails_now(memory)).count();
    let mut outcome = Outcome { events: count as u64, failed: true, ..Outcome::default() };
    let elapsed_s = time_s - state.applied_from_s;
    let State { start, joints, failures, applied_inputs, applied_rates, applied_parameters, .. } = state;
    for (i, (forces, memory)) in equations.forces.joints().iter().zip(joints).enumerate() {
        let fails = |(failure, memory): (&Failure, &FailureMemory)| {
            fails_now(memory) && failure.effect.joint_of() == Some(forces.body)
        };
        if !machine.failures.iter().zip(failures.iter()).any(fails) {
            continue;
        }
        let (inputs, rates) = (&applied_inputs.joints()[i], &applied_rates.joints()[i]);
        let mut told = Told {
            time_s,
            at_end: false,
            release: inputs.release.is_on(),
            latch_enable: inputs.latch_enable.is_on(),
            command_rad: inputs.command_rad + rates.command_rad * elapsed_s,
            command_rate_rad_s: rates.command_rad,
            rate_limit_rad_s: applied_parameters.joints()[i].rate_limit_rad_s,
        };
        tell(&machine.failures, failures, forces.body, memory, &mut told);
        outcome.add(forces.take_inputs(&told, start, memory));
    }
    outcome
}

impl Equations {
    /// Kinetic energy of the penalties of closed loops at the motion of the last sweep, in J.
    pub(crate) fn loop_kinetic_j(&self) -> f64 {
        self.model.closures.iter().map(|closure| closure.energy_j(&self.work).0).sum()
    }

    /// Kinetic energy of [`Self::loop_kinetic_j`] at a given motion, in J.
    pub(crate) fn loop_kinetic_at_j(&mut self, time_s: f64, [q, v, a]: [&[f64]; 3], scratch: &mut [f64]) -> f64 {
        if self.model.closures.is_empty() {
            return 0.0;
        }
        self.residual(time_s, q, v, a, scratch);
        self.loop_kinetic_j()
    }
}
