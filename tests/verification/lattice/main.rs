//! Unsteady vortex lattice against theory and an independent lattice (`docs/VALIDATION.md`, U-01 and on).

mod allocation;
mod fold;
mod frames;
mod properties;
#[path = "../reference.rs"]
mod reference_file;
mod steady;
#[path = "../strips/theory.rs"]
#[allow(dead_code, reason = "the strips use all of it")]
mod theory;
mod unsteady;
mod wing;
