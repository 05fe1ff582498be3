//! The machine as a hybrid system: continuous states with derivatives, event indicators, transitions. Whoever brings an
//! integrator of his own (Model Exchange, another program's solver, a study) sees the machine through this.

use crate::solve::EquationsOfMotion;
use crate::system::PlantError;
use crate::system::events::settle;
use crate::system::outputs::Outputs;
use crate::system::state::State;
use crate::system::{OutputSet, System};

/// An initialised machine without air, to be integrated from outside.
///
/// Its states are the coordinates that forces may move, then their rates; their number stays the same, whatever is held
/// meanwhile. Coordinates of universal, ball and free joints are redundant parameters: [`Hybrid::complete`] brings them back
/// to their constraints. Between events derivatives are smooth in states and time, but for the limits of motors, which have no
/// indicator.
pub struct Hybrid<'a> {
    system: &'a mut System,
}

/// What a transition books, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jump {
    /// Energy dissipated.
    pub dissipated_j: f64,
    /// Work of the inputs.
    pub work_j: f64,
}

/// Rates of the energy accounts, W.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AccountRates {
    /// Power that damping takes.
    pub dissipated_w: f64,
    /// Power of the inputs.
    pub work_w: f64,
}

/// Why a machine cannot be integrated from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotHybrid {
    /// `Plant::initialize` has not succeeded.
    #[error("the machine is not initialised; initialise it first")]
    Uninitialized,
    /// Panels, strips and wake have states of their own.
    #[error(
        "the machine's air has states that only its own steps advance; leave out [aerodynamics], or step the machine"
    )]
    Air,
}

impl System {
    /// The machine as a hybrid system at the present time. Refused before `Plant::initialize` and in air, whose state only
    /// steps of the machine's own know.
    pub fn hybrid(&mut self) -> Result<Hybrid<'_>, NotHybrid> {
        if !self.state.initialized {
            return Err(NotHybrid::Uninitialized);
        }
        if self.air.is_some() {
            return Err(NotHybrid::Air);
        }
        // crossings that the machine's own steps have found ahead are not the integrator's
        self.state.joints.iter_mut().for_each(|joint| joint.crossed = 0);
        let mut hybrid = Hybrid { system: self };
        hybrid.complete();
        Ok(hybrid)
    }
}

impl Hybrid<'_> {
    /// Number of continuous states.
    pub fn states(&self) -> usize {
        2 * self.coordinates().count()
    }

    /// Coordinates that are states: all but those that are prescribed or locked for good.
    fn coordinates(&self) -> impl Iterator<Item = usize> {
        let forces = &self.system.equations.forces;
        let given = move |c: usize| forces.joints().iter().any(|joint| joint.coordinate == c && !joint.driven);
        (0..self.system.coordinates()).filter(move |&c| !given(c))
    }

    /// Present time in s.
    pub fn time_s(&self) -> f64 {
        self.system.state.now.time_s
    }

    /// Copies the present states. `states` has [`Hybrid::states`] entries.
    pub fn read(&self, states: &mut [f64]) {
        let now = &self.system.state.now;
        self.copy_to(states, &now.q, &now.v);
    }

    fn copy_to(&self, states: &mut [f64], of_coordinates: &[f64], of_rates: &[f64]) {
        let (first, second) = states.split_at_mut(states.len() / 2);
        for (i, c) in self.coordinates().enumerate() {
            (first[i], second[i]) = (of_coordinates[c], of_rates[c]);
        }
    }

    /// Goes to a time with its states. Allocates nothing, as the rest of this.
    pub fn set(&mut self, time_s: f64, states: &[f64]) {
        let mut now = std::mem::take(&mut self.system.state.now);
        let (first, second) = states.split_at(states.len() / 2);
        for (i, c) in self.coordinates().enumerate() {
            (now.q[c], now.v[c]) = (first[i], second[i]);
        }
        now.time_s = time_s;
        let equations = &mut self.system.equations;
        equations.branch_s = time_s;
        now.a.fill(0.0);
        now.auxiliary.fill(0.0);
        equations.prescribe(time_s, &mut now.q, &mut now.v, &mut now.a);
        equations.project(&mut now.q, &mut now.v, &mut now.a);
        self.system.state.now = now;
        self.system.forget_outputs();
    }

    /// Derivatives of the states at the present, in O(n) by the mass matrix, with the rates of the energy accounts.
    pub fn derivatives(&mut self, derivatives: &mut [f64]) -> Result<AccountRates, PlantError> {
        let System { equations, state, scratch, .. } = &mut *self.system;
        let now = &mut state.now;
        equations.residual(now.time_s, &now.q, &now.v, &now.a, &mut scratch[0]);
        let jump = settle(equations, &mut scratch[0], now);
        self.system.accelerations(self.time_s(), jump)?;
        let now = &self.system.state.now;
        self.copy_to(derivatives, &now.v, &now.a);
        Ok(AccountRates { dissipated_w: now.powers.dissipated, work_w: now.powers.work })
    }

    /// Number of event indicators.
    pub fn indicators(&self) -> usize {
        self.system.equations.forces.indicators().count()
    }

    /// Event indicators at the present, in rad or m: an event where one falls through zero. Those that nothing can cross are
    /// 1.
    pub fn read_indicators(&self, indicators: &mut [f64]) {
        let State { start, now, joints, .. } = &self.system.state;
        let forces = &self.system.equations.forces;
        for (value, indicator) in indicators.iter_mut().zip(forces.indicators()) {
            let armed = forces.is_armed(indicator, start, joints);
            *value = if armed { forces.distance(indicator, start, now, joints).0 } else { 1.0 };
        }
    }

    /// Next time event after the present in s: end of a slew, knot of a prescribed motion.
    pub fn next_kink_s(&self) -> f64 {
        self.system.equations.next_kink_s(self.time_s())
    }

    /// Ends a step of the integrator at the present: redundant parameters are back on their constraints, motions of indicators
    /// count from here.
    pub fn complete(&mut self) {
        let State { before, start, ahead, now, .. } = &mut self.system.state;
        [before, start, ahead].into_iter().for_each(|point| point.copy_from(now));
        self.system.remember_attitudes();
    }

    /// Makes the transitions at the present of the indicators that the caller has found crossed, passes a kink that lies here,
    /// and follows inputs and parameters that have changed. The states may jump: read them again.
    pub fn transition(&mut self, crossed: &[usize]) -> Result<Jump, PlantError> {
        let system = &mut *self.system;
        for joint in &mut system.state.joints {
            joint.crossed = 0;
        }
        for &number in crossed {
            if let Some(indicator) = system.equations.forces.indicators().nth(number) {
                system.state.joints[indicator.joint].crossed |= 1 << indicator.number;
            }
        }
        let before = (system.state.now.dissipated, system.state.now.work);
        self.complete();
        let system = &mut *self.system;
        system.begin.copy_from(&system.state);
        let changed = system.inputs_changed();
        let outcome = if changed { system.apply_inputs() } else { Ok(()) }.and_then(|()| system.apply_events());
        if let Err(error) = outcome {
            system.go_back_to_begin();
            return Err(error);
        }
        let State { start, now, .. } = &mut system.state;
        now.copy_from(start);
        let jump = Jump { dissipated_j: now.dissipated - before.0, work_j: now.work - before.1 };
        system.forget_outputs();
        Ok(jump)
    }

    /// Outputs at the present; derivatives must have been asked for.
    pub fn outputs(&mut self) -> &Outputs {
        self.system.provide(OutputSet::ALL);
        &self.system.outputs
    }

    /// The system, for its inputs and parameters.
    pub fn system_mut(&mut self) -> &mut System {
        self.system
    }
}
