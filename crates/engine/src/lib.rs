//! Flexible machines with joints: the equations of geometrically nonlinear, strain-based beams and rigid bodies in a tree, forces,
//! aerodynamics, and their integration in time.
//!
//! `docs/NOTATION.md` numbers the equations that the code cites. This crate is independent of files, clocks and FMI. A [`machine::Machine`]
//! is built by its [builder](machine::Machine::builder); a [`plant::Plant`] runs it.

pub mod math;

pub mod beam;
pub mod load;

pub mod multibody;

pub mod force;

pub mod aero;

pub mod solve;

pub mod machine;

pub mod signal;

pub mod system;

pub mod study;

pub mod gradient;

pub mod run;

pub mod plant;
