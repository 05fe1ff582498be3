//! Sliding joints as data: the bodies that slide along a beam, and the workspace of their carriages.

use crate::math::strain::SHEARED;
use crate::multibody::node::{ArticulatedInertia, Pair};
use nalgebra::Vector3;

/// A beam with a body that slides along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slide {
    /// Index of the beam.
    pub beam: usize,
    /// Index of the body that slides; its joint has one coordinate, the arc length from the beam's inner end in m.
    pub rider: usize,
}

/// Workspace of one sliding joint at the poses of the last sweep; all vectors in the root frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SlideWork {
    /// Element, or inner half of the pair, that contains the carriage; set from the state.
    pub element: usize,
    /// Vector from the inner node of the element or pair to the carriage, m.
    pub(super) arm: Vector3<f64>,
    /// Position of the carriage in m.
    pub(super) position: Vector3<f64>,
    /// Wrench of the body on the carriage from the last inward sweep: inertia forces minus loads.
    pub(super) wrench: Pair,
    /// Twist of the carriage per rate of each strain of the element or inner half, then of the outer half.
    pub(super) by_strain: [[Pair; SHEARED]; 2],
    /// Twist of the carriage per rate of the arc length.
    pub column: Pair,
    /// Articulated inertia of the body that slides, at the carriage.
    pub inertia: ArticulatedInertia,
}

impl SlideWork {
    /// Workspace of a joint whose carriage is in `element`.
    pub fn new(element: usize) -> Self {
        Self {
            element,
            arm: Vector3::zeros(),
            position: Vector3::zeros(),
            wrench: Pair::ZERO,
            by_strain: [[Pair::ZERO; SHEARED]; 2],
            column: Pair::ZERO,
            inertia: ArticulatedInertia::ZERO,
        }
    }
}
