//! Monitor of a joint's motion for a failure: an indicator that falls through zero when the motion passes a bound.

use crate::force::latch::CROSSING_S;
use crate::force::memory::JointMemory;
use crate::force::{Moving, Outcome, Place};

/// A bound on the motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Body of the joint.
    pub body: usize,
    /// Bounded quantity.
    pub quantity: Quantity,
    /// Value of the bound, in rad or rad/s, m or m/s.
    pub value: f64,
    /// Side of the bound on which the failure occurs.
    pub side: BoundSide,
}

/// Quantity with a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Angle or position.
    Angle,
    /// Rate of the angle or position.
    Rate,
}

/// Side of a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundSide {
    /// Failure for larger values.
    Above,
    /// Failure for smaller values.
    Below,
}

impl Bound {
    /// Distance to the bound; negative beyond it.
    pub fn left(&self, angle_rad: impl FnOnce() -> f64, rate_rad_s: impl FnOnce() -> f64) -> f64 {
        let value = match self.quantity {
            Quantity::Angle => angle_rad(),
            Quantity::Rate => rate_rad_s(),
        };
        match self.side {
            BoundSide::Above => self.value - value,
            BoundSide::Below => value - self.value,
        }
    }
}

/// Monitor of one bound on the motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watch {
    /// The bound.
    pub bound: Bound,
    /// Number of the bound among those on the joint.
    pub number: u32,
    /// Index of the failure that the bound triggers.
    pub failure: usize,
}

impl Watch {
    /// Whether the bound has been passed.
    pub fn has_tripped(&self, memory: &JointMemory) -> bool {
        memory.tripped & (1 << self.number) != 0
    }

    /// Distance to the bound, in rad or rad/s.
    pub fn distance_rad(&self, place: &impl Place) -> f64 {
        self.bound.left(|| place.angle_rad(), || place.rate_rad_s())
    }

    /// Whether the motion may still pass the bound.
    pub fn is_armed(&self, start: &Moving, memory: &JointMemory) -> bool {
        !self.has_tripped(memory) && self.distance_rad(start) > 0.0
    }

    /// Rate at which the distance decreases.
    pub fn closing_rad_s(&self, at: &Moving) -> f64 {
        match self.bound.quantity {
            Quantity::Angle => at.rate_rad_s.abs(),
            Quantity::Rate => at.acceleration_rad_s2.abs(),
        }
    }

    /// Whether the motion is already beyond the bound by more than the accuracy of locating crossings.
    pub fn is_overdue(&self, at: &Moving, memory: &JointMemory) -> bool {
        !self.has_tripped(memory) && self.distance_rad(at) < -2.0 * CROSSING_S * self.closing_rad_s(at)
    }

    /// Records that the bound has been passed.
    pub fn transition(&self, memory: &mut JointMemory) -> Outcome {
        memory.tripped |= 1 << self.number;
        Outcome::default()
    }

    /// Records a bound that is already passed at the start.
    pub fn begin(&self, start: &Moving, memory: &mut JointMemory) {
        if self.distance_rad(start) <= 0.0 {
            self.transition(memory);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn way_left_falls_towards_the_bound_from_its_own_side() {
        let watch =
            |quantity, side| Watch { bound: Bound { body: 0, quantity, value: 2.0, side }, number: 0, failure: 0 };
        let at = Moving { angle_rad: 1.5, rate_rad_s: -3.0, acceleration_rad_s2: 7.0 };
        assert_eq!(watch(Quantity::Angle, BoundSide::Above).distance_rad(&at), 0.5);
        assert_eq!(watch(Quantity::Angle, BoundSide::Below).distance_rad(&at), -0.5);
        assert_eq!(watch(Quantity::Rate, BoundSide::Below).distance_rad(&at), -5.0);
        assert_eq!(watch(Quantity::Rate, BoundSide::Above).closing_rad_s(&at), 7.0);
        assert_eq!(watch(Quantity::Angle, BoundSide::Above).closing_rad_s(&at), 3.0);
    }
}
