//! Aeroelastic coupling: machines from model texts, simulated by the plant.
//!
//! Cases are numbered Q-xx.

mod agreement;
mod clock;
mod edges;
mod equilibria;
mod flaps;
mod flutter;
mod frames;
mod goland;
mod handed;
mod identification;
mod lattice_modes;
mod lattice_stability;
mod light_tips;
mod linear_flutter;
mod linear_lattice;
mod linear_response;
mod narrow_gaps;
mod real_time;
mod twist;
pub(crate) mod wings;
