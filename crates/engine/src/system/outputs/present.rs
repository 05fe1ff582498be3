//! The motion from which outputs are computed.

use crate::multibody::motion::Motion;
use crate::system::equations::Equations;
use crate::system::state::State;

/// The current motion, from which the files of this folder compute their outputs.
pub(crate) struct Present<'a> {
    /// State of the system; its `now` is the current point.
    pub(super) state: &'a State,
    /// Equations, evaluated by the required sweep.
    pub(super) equations: &'a Equations,
    /// Coordinates, rates, accelerations.
    pub(super) motion: Motion<'a>,
}

impl Present<'_> {
    /// Time in s.
    pub(super) fn time_s(&self) -> f64 {
        self.state.now.time_s
    }
}
