//! Test whether a state is a static equilibrium.

use crate::system::System;

/// Accelerations (rad/s², 1/(m·s²), m/s²) below which only round-off of their solution remains.
const ROUND_OFF: f64 = 1e-9;

impl System {
    /// Whether all rates and accelerations are zero, except currents.
    pub(crate) fn has_no_motion(&self) -> bool {
        let (now, model) = (&self.state.now, &self.equations.model);
        model.is_still(&now.v) && model.is_still(&now.a)
    }

    /// Whether the current state is a static equilibrium: all velocities are zero and the forces balance.
    pub fn is_at_rest(&self) -> bool {
        let now = &self.state.now;
        self.equations.model.is_still(&now.v) && now.a.iter().all(|acceleration| acceleration.abs() <= ROUND_OFF)
    }
}
