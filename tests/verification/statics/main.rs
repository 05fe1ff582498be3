//! Statics, modes and linearisation against theory and independent solutions, from model files. Case numbers S-xx.

mod equilibrium;
mod linear;
mod machines;
mod modes;
#[path = "../reference.rs"]
mod reference;
mod ritz;
#[path = "../rod.rs"]
mod rod;
mod stability;
mod tangent;
