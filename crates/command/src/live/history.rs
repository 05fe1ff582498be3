//! Stored states of a simulation to which it can be rolled back: a bounded ring buffer.

use crate::live::pull::Held;
use foldwing_engine::plant::Snapshot;
use std::collections::VecDeque;

/// Maximum number of states: one minute of frames.
const MOST: usize = 1800;

/// Maximum total size of the states in bytes.
const MOST_BYTES: usize = 256 << 20;

/// Number of states between two measurements of their size, which grows with the wakes.
const BETWEEN_SIZES: usize = 128;

/// Stored state of a machine.
#[derive(Clone)]
pub(super) struct State {
    /// State of the plant.
    pub snapshot: Snapshot,
    /// Station and its force without the pull, if a pull was active.
    pub held: Option<Held>,
}

/// Stored states of all machines of a simulation at one time.
#[derive(Clone)]
pub(super) struct Moment {
    /// Time in s.
    pub time_s: f64,
    /// States in the order of the machines.
    pub states: Vec<State>,
}

/// Stored states in order of time.
pub(super) struct History {
    ring: VecDeque<Moment>,
    /// Maximum number of states for the available memory.
    most: usize,
    until_size: usize,
}

impl History {
    /// Creates a history with one state.
    pub fn new(first: Moment) -> Self {
        let mut history = Self { ring: VecDeque::new(), most: MOST, until_size: 0 };
        history.push(first);
        history
    }

    /// Adds the current state and removes the oldest ones beyond the limit; a state of the same time is replaced.
    pub fn push(&mut self, moment: Moment) {
        if self.until_size == 0 {
            let size = |state: &State| postcard::to_stdvec(&state.snapshot).map_or(1, |bytes| bytes.len());
            let bytes: usize = moment.states.iter().map(size).sum();
            self.most = (MOST_BYTES / bytes.max(1)).clamp(2, MOST);
            self.until_size = BETWEEN_SIZES;
        }
        self.until_size -= 1;
        if self.ring.back().is_some_and(|last| last.time_s >= moment.time_s) {
            self.ring.pop_back();
        }
        self.ring.push_back(moment);
        while self.ring.len() > self.most {
            self.ring.pop_front();
        }
    }

    /// Earliest time available, in s.
    pub fn oldest_s(&self) -> f64 {
        self.ring.front().map_or(0.0, |moment| moment.time_s)
    }

    /// Removes the states after `time_s` and returns the last remaining one; for earlier times than the history, the
    /// oldest one.
    pub fn back_to(&mut self, time_s: f64) -> Option<&Moment> {
        // pages return times with single precision
        let slack_s = 1e-6 * time_s.abs().max(1e-3);
        while self.ring.len() > 1 && self.ring.back().is_some_and(|last| last.time_s > time_s + slack_s) {
            self.ring.pop_back();
        }
        self.ring.back()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::tests::started;
    use foldwing_engine::plant::Plant;

    fn moment(plant: &Plant, time_s: f64) -> Moment {
        Moment { time_s, states: vec![State { snapshot: plant.snapshot(), held: None }] }
    }

    /// The buffer is bounded; rolling back finds the last state up to a time and removes later ones.
    #[test]
    fn moments_are_bounded_and_forgotten() {
        let (_, plant) = started("folding_wing");
        let mut history = History::new(moment(&plant, 0.0));
        (1..MOST + 10).for_each(|i| history.push(moment(&plant, i as f64)));
        assert_eq!((history.ring.len(), history.oldest_s()), (MOST, 10.0));
        assert_eq!(history.back_to(100.5).unwrap().time_s, 100.0);
        // a page returns times with single precision
        history.push(moment(&plant, 100.1));
        assert_eq!(history.back_to(f64::from(100.1_f32)).unwrap().time_s, 100.1);
        assert_eq!(history.back_to(-5.0).unwrap().time_s, 10.0);
        assert_eq!(history.ring.len(), 1);
        history.push(moment(&plant, 10.0));
        assert_eq!(history.ring.len(), 1, "the same time twice");
    }
}
