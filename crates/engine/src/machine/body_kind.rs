//! Kinds of bodies: rigid ones, modal ones and beams.

use crate::machine::Body;

impl Body {
    /// The body has no elements: one frame that carries masses, joints and loads.
    pub fn is_rigid(&self) -> bool {
        self.elements == 0
    }

    /// The body bends in given shapes; its elements are then the cells of their sums.
    pub fn is_modal(&self) -> bool {
        self.section.modal().is_some()
    }

    /// The body is made of strain elements.
    pub fn is_beam(&self) -> bool {
        !self.is_rigid() && !self.is_modal()
    }
}
