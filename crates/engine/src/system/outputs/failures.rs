//! Outputs of failures: whether and when they occurred.

use crate::signal::Switch;
use crate::system::failure_memory::FailureMemory;
use crate::system::outputs::Present;
use bytemuck::{Pod, Zeroable};

/// Outputs of one failure.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FailureOutputs {
    /// Whether the failure has occurred.
    pub failed: Switch,
    /// Time in s at which it occurred; −1 before.
    pub time_s: f64,
}

impl FailureOutputs {
    /// Outputs of a failure that has not occurred.
    pub(crate) const NONE: Self = Self { failed: Switch::OFF, time_s: -1.0 };
}

/// Writes the states of the failures.
pub(crate) fn fill(outputs: &mut [FailureOutputs], present: &Present) {
    for (output, memory) in outputs.iter_mut().zip(&present.state.failures) {
        let FailureMemory { failed_s, .. } = memory;
        *output = FailureOutputs { failed: failed_s.is_some().into(), time_s: failed_s.unwrap_or(-1.0) };
    }
}
