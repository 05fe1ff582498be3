//! Foldwing: a flexible folding wing as an FMU.
//!
//! A short model file becomes an FMI 2.0 co-simulation FMU of a geometrically nonlinear, strain-based
//! beam multibody wing with fold joints, drives and latches. `docs/ARCHITECTURE.md` maps the modules,
//! `docs/NOTATION.md` numbers the equations that the code cites.

#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod math;

pub mod beam;
pub mod load;

pub mod multibody;

pub mod actuation;

pub mod aero;

pub mod solve;

pub mod machine;

pub mod plant;

pub mod config;

pub mod interface;

pub mod fmi2;

pub mod packaging;

pub mod report;

#[cfg(feature = "import")]
pub mod import;
