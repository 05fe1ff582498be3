//! Direct feedthrough of inputs to outputs between steps.
//!
//! With frozen states (coordinates, rates, locks, latches, aerodynamic loads), an input set since the last step changes accelerations,
//! forces and potentials, NOTATION eq. (L14). Co-simulation masters need these outputs to solve algebraic loops.

use crate::solve::EquationsOfMotion;
use crate::system::System;
use crate::system::events::{settle, subtract_rest};
use crate::system::magnitude::inputs_are_moderate;
use crate::system::outputs::OutputSet;
use crate::system::state::State;

impl System {
    /// Evaluates outputs at the current time with the newly set inputs, if these differ from the inputs at the end of the last step.
    /// Returns false if they do not differ, or if the result is not finite. Allocates nothing.
    pub(crate) fn evaluate_with_set_inputs(&mut self, wanted: OutputSet) -> bool {
        let state = &self.state;
        if state.has_arrived_inputs() || !inputs_are_moderate(&state.inputs) {
            return false;
        }
        self.begin.now.clone_from(&self.state.now);
        let now = &self.state.now;
        let time_s = now.time_s;
        self.equations.branch_s = time_s;
        self.equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
        let before = self.equations.potentials(time_s, &now.q);
        self.impose_set_inputs();
        let ([old, new], now) = (&mut self.scratch, &mut self.state.now);
        self.equations.residual(time_s, &now.q, &now.v, &now.a, new);
        let after = self.equations.potentials(time_s, &now.q);
        subtract_rest(&self.equations, new, old);
        let settled = matches!(settle(&mut self.equations, new, now), Ok(jump) if jump.is_finite());
        if settled {
            // a jump of a potential is booked as work of the input
            self.state.now.work += after.total() - before.total();
            self.evaluate_some(wanted);
        }
        self.state.now.clone_from(&self.begin.now);
        self.configure();
        settled
    }

    /// Sets the equations to the current time with the newly set inputs, and with the parameters and switches of the last step; neutral
    /// angles jump with their commands unless a rate limit is active.
    fn impose_set_inputs(&mut self) {
        let State { inputs, applied_inputs, applied_from_s, now, .. } = &mut self.state;
        let from_s = std::mem::replace(applied_from_s, now.time_s);
        std::mem::swap(inputs, applied_inputs);
        self.configure();
        let State { inputs, applied_inputs, applied_from_s, applied_parameters, now, .. } = &mut self.state;
        std::mem::swap(inputs, applied_inputs);
        *applied_from_s = from_s;
        self.equations.command(now.time_s, inputs, applied_parameters);
    }
}

impl State {
    /// Whether the set inputs equal those at the end of the current step.
    fn has_arrived_inputs(&self) -> bool {
        let elapsed_s = self.now.time_s - self.applied_from_s;
        let applied = self.applied_inputs.values().iter().zip(self.applied_rates.values());
        let still = self.applied_rates.is_still();
        let arrived = applied.map(|(value, rate)| if still { *value } else { value + rate * elapsed_s });
        self.inputs.values().iter().copied().eq(arrived)
    }
}
