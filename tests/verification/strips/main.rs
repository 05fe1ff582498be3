//! Strip theory against the classical theory of thin aerofoils, and the invariances that any air must have.

mod allocation;
mod goland;
mod invariance;
mod plate;
#[path = "../reference.rs"]
mod reference_file;
mod section_flutter;
mod theory;
mod theory_checks;
mod unsteady;
