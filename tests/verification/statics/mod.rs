//! Statics, modes and linearisation against theory and independent solutions, from model files. Case numbers S-xx.

mod equilibrium;
mod linear;
pub mod machines;
mod modes;
mod ritz;
mod stability;
mod tangent;
