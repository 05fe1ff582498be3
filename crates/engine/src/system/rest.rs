//! Whether the present state is one of rest.

use crate::system::System;

/// Accelerations (rad/s², 1/(m·s²), m/s²) below which only round-off of the solution for them is left.
const ROUND_OFF: f64 = 1e-9;

impl System {
    /// True where nothing moves and nothing begins to: the forces balance, and what is found about this state is about an
    /// equilibrium.
    pub fn is_at_rest(&self) -> bool {
        let now = &self.state.now;
        now.v.iter().all(|rate| *rate == 0.0) && now.a.iter().all(|acceleration| acceleration.abs() <= ROUND_OFF)
    }
}
