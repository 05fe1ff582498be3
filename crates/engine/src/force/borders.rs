//! Borders of the elements along which a sliding joint moves: the crossing of a border is an event, NOTATION eq. (J15).

use crate::force::latch::CROSSING_S;
use crate::force::memory::{JointMemory, Told};
use crate::force::{Moving, Outcome, Place};

/// Arc lengths in m at which the elements, or pairs, of a beam start, and its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Borders {
    borders_m: Vec<f64>,
}

impl Borders {
    /// Borders in ascending order: at least the two ends of the beam.
    pub fn new(borders_m: Vec<f64>) -> Self {
        Self { borders_m }
    }

    /// Number of the last element.
    pub fn last(&self) -> usize {
        self.elements() - 1
    }

    /// Number of elements.
    fn elements(&self) -> usize {
        self.borders_m.len() - 1
    }

    /// Element at a position that moves with the rate `rate_m_s`: at a border, the element into which it moves; at rest, the outboard one.
    pub fn element_at(&self, position_m: f64, rate_m_s: f64) -> usize {
        let inside = &self.borders_m[1..self.elements()];
        inside.partition_point(|border| if rate_m_s < 0.0 { *border < position_m } else { *border <= position_m })
    }

    /// Whether a position is on the beam, to within the accuracy of locating crossings.
    pub fn contains(&self, position_m: f64) -> bool {
        let length_m = self.borders_m[self.elements()];
        let near = 1e-12 * length_m;
        (-near..=length_m + near).contains(&position_m)
    }

    /// Sets the element at the start.
    pub fn begin(&self, start: &Moving, memory: &mut JointMemory) {
        memory.element = self.element_at(start.angle_rad, start.rate_rad_s);
    }

    /// Distance in m to the inner (0) or outer (1) border of the current element.
    pub fn distance_m(&self, indicator: usize, place: &impl Place, memory: &JointMemory) -> f64 {
        let element = memory.element.min(self.last());
        match indicator {
            0 => place.angle_rad() - self.borders_m[element],
            _ => self.borders_m[element + 1] - place.angle_rad(),
        }
    }

    /// Whether a border was passed by more than the accuracy of locating crossings.
    pub fn is_overdue(&self, indicator: usize, at: &Moving, memory: &JointMemory) -> bool {
        let closing_m_s = if indicator == 0 { -at.rate_rad_s } else { at.rate_rad_s };
        closing_m_s > 0.0 && self.distance_m(indicator, at, memory) < -2.0 * CROSSING_S * closing_m_s
    }

    /// Moves to the element beyond the border; an end of the beam is passed without a change.
    pub fn transition(&self, indicator: usize, memory: &mut JointMemory) -> Outcome {
        match indicator {
            0 => memory.element = memory.element.saturating_sub(1),
            _ => memory.element = (memory.element + 1).min(self.last()),
        }
        Outcome { events: 1, ..Outcome::default() }
    }

    /// Performs the transitions due at the end of the current step, if the step ends now.
    pub fn take_inputs(&self, told: &Told, crossed: u32, memory: &mut JointMemory) -> Outcome {
        let mut outcome = Outcome::default();
        for indicator in (0..2).filter(|i| told.at_end && crossed & (1 << i) != 0) {
            outcome.add(self.transition(indicator, memory));
        }
        outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A position on a border belongs to the element into which it moves.
    #[test]
    fn element_of_a_position() {
        let borders = Borders::new(vec![0.0, 0.25, 0.5, 1.0]);
        let at = |position_m, rate_m_s| borders.element_at(position_m, rate_m_s);
        assert_eq!([at(0.0, 0.0), at(0.0, -1.0), at(0.1, 1.0), at(0.3, -1.0), at(0.9, 1.0)], [0, 0, 0, 1, 2]);
        assert_eq!([at(0.25, 0.0), at(0.25, 1.0), at(0.25, -1.0), at(1.0, 1.0), at(1.0, -1.0)], [1, 1, 0, 2, 2]);
        assert!(borders.contains(0.0) && borders.contains(1.0) && !borders.contains(1.001) && !borders.contains(-1e-6));
    }
}
