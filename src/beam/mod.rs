//! Cross-sections and beam elements: constant stiffness and constant inertia.

pub mod element;
pub mod section;
