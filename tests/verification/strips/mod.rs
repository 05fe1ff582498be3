//! Strip theory against the classical theory of thin aerofoils, and the invariances that any air must have.

mod allocation;
mod flaps;
mod goland;
mod invariance;
mod plate;
mod section_flutter;
mod short_element;
mod sideslip;
pub(crate) mod theory;
mod theory_checks;
mod tip_loss;
pub(crate) mod unsteady;
