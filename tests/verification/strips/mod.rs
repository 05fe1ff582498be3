//! Strip theory against classical thin-aerofoil theory, and the invariances that every aerodynamic model must have.

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
