//! Test whether a state is a static equilibrium.

use crate::system::System;

/// Accelerations (rad/s², 1/(m·s²), m/s²) below which only round-off of their solution remains.
const ROUND_OFF: f64 = 1e-9;

impl System {
    /// Whether the current state is a static equilibrium: all velocities are zero and the forces balance.
    pub fn is_at_rest(&self) -> bool {
        let now = &self.state.now;
        let tree = self.equations.model.tree_coordinates();
        self.equations.model.is_still(&now.v)
            && now.a.iter().take(tree).all(|acceleration| acceleration.abs() <= ROUND_OFF)
    }

    /// Reason why there are linear models about states of rest only; `None` if there is none.
    pub(crate) fn only_at_rest(&self) -> Option<String> {
        if !self.equations.spatial.is_empty() {
            return Some("models with universal, ball or free joints are linearised at rest only".to_owned());
        }
        let closure = self.machine.closures.iter().find(|closure| closure.rigid)?;
        Some(format!(
            "models with rigid loops are linearised at rest only; use the equilibrium, or give the loop {:?} stiffness_N_m in place of \
             rigid = true",
            closure.name
        ))
    }

    /// Whether all velocities and accelerations are exactly zero; currents may flow, and forces of constraints act.
    pub(crate) fn stands_still(&self) -> bool {
        let (now, model) = (&self.state.now, &self.equations.model);
        model.is_still(&now.v) && model.is_still(&now.a[..model.tree_coordinates()])
    }
}
