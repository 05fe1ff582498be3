//! Releasable lock of a joint.

use crate::force::Outcome;
use crate::force::memory::{JointMemory, Told};

/// Holds a joint at its position until it is released; the kinetic energy lost when it engages is dissipated, NOTATION eq. (A6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Brake;

impl Brake {
    /// Whether the lock holds the joint.
    pub fn holds(self, memory: &JointMemory) -> bool {
        !memory.released
    }

    /// Releases or engages the lock.
    pub fn take_inputs(self, told: &Told, memory: &mut JointMemory) -> Outcome {
        let changed = told.release != memory.released;
        memory.released = told.release;
        Outcome { events: u64::from(changed), ..Outcome::default() }
    }
}
