//! Checks against overflow: a check of the inputs replaces a check of all outputs.

use crate::signal::{Inputs, JointParameters, Parameters};
use crate::solve::point::Point;
use crate::system::System;
use crate::system::model_magnitude::{all_within, within};
use crate::system::state::State;

/// Largest magnitude in SI units of coordinates, their derivatives, inputs and parameters for which no output overflows, in a model with
/// moderate parameters: outputs are products of at most ten of them.
const LARGEST: f64 = 1e20;
/// Largest magnitude of the energy accounts.
const LARGEST_ACCOUNT: f64 = 1e200;

impl System {
    /// Whether all outputs at the current time are certain to be finite, by the magnitudes of the quantities that they depend on; always
    /// false for models with aerodynamics.
    pub(crate) fn is_moderate(&self) -> bool {
        self.air.is_none() && self.rest_is_moderate() && coordinates_are_moderate(&self.state.now)
    }

    /// Like [`Self::is_moderate`], for the current time and all times until the end of the integrator's step, without the aerodynamic
    /// loads, which are checked in the step.
    pub(crate) fn stays_moderate(&self) -> bool {
        let State { now, ahead, .. } = &self.state;
        self.rest_is_moderate() && [now, ahead].into_iter().all(coordinates_are_moderate)
    }

    /// Whether all quantities except the coordinates are moderate.
    fn rest_is_moderate(&self) -> bool {
        let state = &self.state;
        self.model_is_moderate
            && state.joints.iter().all(|joint| {
                let slew = &joint.slew;
                [slew.from_rad, slew.target_rad, slew.target_rate_rad_s, slew.start_s]
                    .into_iter()
                    .all(|value| within(value, LARGEST))
            })
            && [&state.applied_inputs, &state.applied_rates].into_iter().all(inputs_are_moderate)
            && parameters_are_moderate(&state.applied_parameters)
    }
}

fn coordinates_are_moderate(at: &Point) -> bool {
    at.q.iter().chain(&at.v).chain(&at.a).all(|&value| within(value, LARGEST))
        && [at.work, at.dissipated].into_iter().all(|account| within(account, LARGEST_ACCOUNT))
}

/// Whether the inputs are too small to make an output overflow.
pub(crate) fn inputs_are_moderate(inputs: &Inputs) -> bool {
    all_within(inputs.values(), LARGEST)
}

fn parameters_are_moderate(parameters: &Parameters) -> bool {
    // limits may be infinite: they can only reduce the torque
    let joint = |joint: &JointParameters| {
        let others = [JointParameters { torque_limit_n_m: 0.0, rate_limit_rad_s: 0.0, ..*joint }];
        all_within(bytemuck::cast_slice(&others), LARGEST)
    };
    parameters.joints().iter().all(joint)
        && all_within(bytemuck::cast_slice(parameters.spatial()), LARGEST)
        && all_within(bytemuck::cast_slice(parameters.bodies()), LARGEST)
}
