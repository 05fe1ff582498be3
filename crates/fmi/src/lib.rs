//! The FMI layer in safe Rust: the variable table of a model, and FMI 2.0 and 3.0 except for their C functions, which are in
//! `crates/fmu`.

pub mod fmi2;
pub mod fmi3;
pub mod instance;
pub mod interface;
