//! Instantaneous stop of a joint by a lock, brake or rigid latch: an impulse and the energy it dissipates, NOTATION eq. (A6).

use crate::force::joint::JointForces;
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Singular};
use crate::system::System;
use crate::system::equations::Equations;
use crate::system::state::State;

/// Impulse and energy that stop a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Stop {
    /// Impulse on the outer body in the direction of `+θ` in N·m·s.
    pub impulse_n_m_s: f64,
    /// Dissipated kinetic energy in J.
    pub energy_j: f64,
}

/// Factor in 1/s by which a jump of the rates is converted to accelerations, which are then far above the actual ones.
pub(crate) const JUMP_1_S: f64 = 1e6;
/// Inertia of a loop's penalty in an impulse, relative to the model's mass: the rate of its gap jumps by a millionth of the other rates,
/// and its impulse is accurate to 1e-10.
const LOOP_INERTIA: f64 = 1e6;

/// Energies of stopping joints.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Stopped {
    /// Dissipated kinetic energy in J.
    pub lost_j: f64,
    /// Work in J done at prescribed joints to keep their rates.
    pub work_j: f64,
}

impl System {
    /// Stops the joints that move at `start` and are held in the new state.
    ///
    /// Overwrites `before` and `scratch[1]`. Allocates nothing.
    pub(crate) fn stop_held_joints(&mut self) -> Result<Stopped, Singular> {
        let stops = |plant: &Self, i: usize| {
            let forces = &plant.equations.forces.joints()[i];
            forces.is_held_in(&plant.state.joints[i]) && !forces.held
        };
        let joints = 0..self.state.joints.len();
        if !joints.clone().any(|i| stops(self, i)) {
            return Ok(Stopped::default());
        }
        self.state.before.copy_from(&self.state.start);
        self.join_loops();
        let mut outcome = Ok(0.0);
        for i in joints {
            if let (Ok(lost_j), true) = (&mut outcome, stops(self, i)) {
                match self.equations.stop(i, &mut self.state.start, &mut self.scratch[1]) {
                    Ok(stop) => *lost_j += stop.energy_j,
                    Err(singular) => outcome = Err(singular),
                }
            }
        }
        let jumps = matches!(outcome, Ok(lost_j) if lost_j > 0.0);
        if jumps && self.equations.forces.joints().iter().any(JointForces::keeps_impulses) {
            self.find_impulses();
        }
        self.part_loops();
        // without loops and prescribed joints the losses of the individual stops add up to the total
        let others = !self.machine.closures.is_empty()
            || self.equations.forces.joints().iter().any(|joint| joint.law().is_some());
        if jumps && others {
            return Ok(self.account_for_jump());
        }
        outcome.map(|lost_j| Stopped { lost_j, work_j: 0.0 })
    }

    /// Replaces loops by ideal joints for an impulse, during which the springs of their penalties have no effect.
    pub(crate) fn join_loops(&mut self) {
        if !self.equations.model.closures.is_empty() {
            let inertia_kg = LOOP_INERTIA * self.mass_kg();
            // open loops have no stiffness
            for closure in
                self.equations.model.closures.iter_mut().filter(|closure| closure.penalty.stiffness_n_m > 0.0)
            {
                closure.penalty.inertia_kg += inertia_kg;
            }
        }
    }

    /// Restores the penalties of the loops.
    pub(crate) fn part_loops(&mut self) {
        let described = self.machine.closures.iter().filter(|closure| !closure.rigid);
        for (closure, described) in self.equations.model.closures.iter_mut().zip(described) {
            closure.penalty.inertia_kg = described.inertia_kg;
        }
        self.weaken_loops();
    }

    /// Computes the impulses of the forces that store them (rigid latches that close now): their rows of `M Δv`, NOTATION eq. (A7). Latches
    /// that close at the same instant share the impulse, so the impulses of the individual stops cannot be used.
    fn find_impulses(&mut self) {
        for sign in [-1.0, 1.0] {
            self.residual_of_jump(sign > 0.0);
            let State { start, joints, .. } = &mut self.state;
            for (forces, memory) in self.equations.forces.joints().iter().zip(joints) {
                if let Some(impulse_n_m_s) = forces.impulse_n_m_s(start.time_s, memory) {
                    *impulse_n_m_s += sign / JUMP_1_S * forces.holding_n_m;
                }
            }
        }
    }

    /// Energies of the jump of the rates from `before` to `start`, from all rows of `M Δv`, including those of loops that are not quite
    /// closed, and the work of prescribed joints.
    fn account_for_jump(&mut self) -> Stopped {
        let mut stopped = Stopped::default();
        for sign in [-1.0, 1.0] {
            self.residual_of_jump(sign > 0.0);
            let (before, start) = (&self.state.before, &self.state.start);
            let share_s = sign / JUMP_1_S;
            for joint in self.equations.forces.joints().iter().filter(|joint| joint.held) {
                let c = joint.coordinate;
                if joint.law().is_some() {
                    stopped.work_j += share_s * joint.holding_n_m * start.v[c];
                }
                self.scratch[1][c] = if joint.law().is_some() { 0.0 } else { joint.holding_n_m };
            }
            let mean = before.v.iter().zip(&start.v).map(|(from, to)| 0.5 * (from + to));
            stopped.lost_j -= share_s * self.scratch[1].iter().zip(mean).map(|(row, rate)| row * rate).sum::<f64>();
        }
        stopped
    }

    /// Computes the residual in `scratch[1]` at the configuration and the rates of `before`, with the jump of the rates times [`JUMP_1_S`]
    /// as accelerations, or with zero accelerations.
    fn residual_of_jump(&mut self, jump: bool) {
        let State { before, start, .. } = &mut self.state;
        let scale_1_s = if jump { JUMP_1_S } else { 0.0 };
        let rates = before.v.iter().zip(&start.v);
        before.a.iter_mut().zip(rates).for_each(|(a, (from, to))| *a = scale_1_s * (to - from));
        self.equations.residual(start.time_s, &before.q, &before.v, &before.a, &mut self.scratch[1]);
    }
}

impl Equations {
    /// Stops a revolute joint at the configuration of the last residual: its rate becomes zero, all other rates follow through the mass
    /// matrix, and the joint is held afterwards.
    ///
    /// Joints that are already held remain stopped, so that joints stopped in sequence end as if stopped simultaneously. `scratch` has one
    /// entry per coordinate. Allocates nothing.
    pub fn stop(&mut self, joint: usize, point: &mut Point, scratch: &mut [f64]) -> Result<Stop, Singular> {
        let JointForces { coordinate: c, body, .. } = self.forces.joints()[joint];
        let rate_rad_s = point.v[c];
        let mut stop = Stop::default();
        if rate_rad_s != 0.0 {
            self.factorize(1.0, 0.0, 0.0)?;
            scratch.fill(0.0);
            scratch[c] = 1.0;
            self.solve(scratch);
            stop.impulse_n_m_s = -rate_rad_s / scratch[c];
            stop.energy_j = -0.5 * stop.impulse_n_m_s * rate_rad_s;
            for (v, per_impulse) in point.v.iter_mut().zip(scratch.iter()) {
                *v += stop.impulse_n_m_s * per_impulse;
            }
            point.v[c] = 0.0;
        }
        self.forces.joints_mut()[joint].held = true;
        self.tangents[body].free = false;
        Ok(stop)
    }
}
