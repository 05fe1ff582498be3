//! The stopper of a joint.

use crate::force::Outcome;
use crate::force::memory::{JointMemory, Told};

/// Holds a joint where it is until it is released; what stops when it closes loses its energy, NOTATION eq. (A6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Brake;

impl Brake {
    /// Whether it holds the joint.
    pub fn holds(self, memory: &JointMemory) -> bool {
        !memory.released
    }

    /// Opens or closes.
    pub fn take_inputs(self, told: &Told, memory: &mut JointMemory) -> Outcome {
        let changed = told.release != memory.released;
        memory.released = told.release;
        Outcome { events: u64::from(changed), ..Outcome::default() }
    }
}
