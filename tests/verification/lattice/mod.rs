//! Unsteady vortex lattice against theory and an independent lattice (`docs/VALIDATION.md`, U-01 and on).

mod allocation;
mod flaps;
mod fold;
mod frames;
mod linear;
mod profiles;
mod properties;
mod steady;
mod surroundings;
mod unsteady;
pub(crate) mod wing;
