//! Curved, twisted and tapered blades: Migliaccio, Ruta, Bennati and Barsotti, *Beam-like models for the analyses of
//! curved, twisted and tapered HAWT blades in large displacements* ("the paper" here), against boundary-value
//! solutions written for these tests.

mod boundary_value;
mod blade;
mod elements;
mod sets;
#[path = "../statics.rs"]
#[allow(dead_code)]
mod statics;
