//! Curved, twisted and tapered blades: Migliaccio, Ruta, Bennati and Barsotti, *Beam-like models for the analyses of
//! curved, twisted and tapered HAWT blades in large displacements* ("the paper" here), against boundary-value
//! solutions written for these tests.

mod blade;
mod boundary_value;
mod elements;
mod product;
mod sets;
mod stations;
