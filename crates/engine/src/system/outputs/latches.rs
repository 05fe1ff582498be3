//! Outputs of latches that change at events only.

use crate::signal::{Count, Switch};
use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};

/// Outputs of the latch of one revolute or prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LatchOutputs {
    /// Whether the latch is closed.
    pub closed: Switch,
    /// Time of the last closing in s; −1 before the first.
    pub time_s: f64,
    /// Number of closings.
    pub count: Count,
    /// Impulse of a rigid latch's last closing on the outer body in N·m·s; 0 before the first.
    pub impulse_n_m_s: f64,
}

impl LatchOutputs {
    /// Outputs of a latch that has not closed yet.
    pub(crate) const OPEN: Self = Self { closed: Switch::OFF, time_s: -1.0, count: Count::NONE, impulse_n_m_s: 0.0 };
}

/// Writes the states of the latches.
pub(crate) fn fill(outputs: &mut [LatchOutputs], present: &Present) {
    for ((output, joint), state) in outputs.iter_mut().zip(present.equations.forces.joints()).zip(&present.state.joints)
    {
        let latch = &state.latch;
        *output = LatchOutputs {
            closed: joint.is_latched().into(),
            time_s: latch.time_s,
            count: latch.count.into(),
            impulse_n_m_s: latch.impulse_n_m_s,
        };
    }
}
