//! A machine as FMI sees it, in safe Rust: the table of its variables, and FMI 2.0 co-simulation but for its C
//! functions, which stand in `crates/fmu`.

pub mod fmi2;
pub mod interface;
