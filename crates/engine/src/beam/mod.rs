//! Cross-sections and beam elements: constant stiffness and inertia, variation along a body, strain recovery.

pub mod axis;
pub mod element;
pub mod law;
pub mod modal;
pub(crate) mod modal_mass;
pub mod profile;
pub mod recovery;
pub mod section;
pub(crate) mod small_turn;
