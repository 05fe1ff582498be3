//! Values set by an external integrator, and quantities that follow from them.

use serde::{Deserialize, Serialize};

/// Options of an external integrator.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Manner {
    /// The energy accounts are not states.
    pub(super) without_accounts: bool,
    /// `1/ω_c²` of the frequency limit in s², eq. (D21); 0 without a limit, and while the model is integrated by its own solver.
    pub(super) strain_inertia_s2: f64,
}

/// Values set by an external integrator.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Outside {
    /// Time in s.
    pub(super) time_s: f64,
    /// Time of the last event or of the start in s: the earliest time that the integrator may set.
    pub(super) event_s: f64,
    /// Moving coordinates, their rates, lag states of strips, energy accounts.
    pub(super) states: Vec<f64>,
    /// Whether the integrator is in Event Mode, before the transitions of the crossed indicators.
    pub(super) entered: bool,
}

/// Implemented by hand, because a derived `clone_from` allocates, and events copy the state.
impl Clone for Outside {
    fn clone(&self) -> Self {
        Self { states: self.states.clone(), ..*self }
    }

    fn clone_from(&mut self, source: &Self) {
        (self.time_s, self.event_s, self.entered) = (source.time_s, source.event_s, source.entered);
        self.states.clone_from(&source.states);
    }
}

impl Outside {
    /// Whether these values can have been set in a run of a model with this number of states.
    pub fn fits(&self, initialized: bool, states: usize) -> bool {
        initialized && self.states.len() == states
    }
}

/// Quantities computed from the set states, if they have been evaluated.
#[derive(Debug, Clone, Default)]
pub(super) struct Told {
    /// Whether the current point and the derivatives correspond to the set states.
    pub(super) found: bool,
    pub(super) derivatives: Vec<f64>,
    pub(super) indicators: Vec<f64>,
    /// Violation of the constraints by the redundant parameters.
    pub(super) drift: f64,
    /// Indicators crossed in the event.
    pub(super) crossed: Vec<usize>,
}

impl Told {
    /// Allocates memory for these numbers of states and indicators.
    pub fn make_room(&mut self, states: usize, indicators: usize) {
        self.derivatives.resize(states, 0.0);
        self.indicators.resize(indicators, 1.0);
        self.crossed.clear();
        self.crossed.reserve(indicators);
    }

    /// Marks the quantities as out of date, because states, time or inputs have changed.
    pub fn forget(&mut self) {
        self.found = false;
    }
}
