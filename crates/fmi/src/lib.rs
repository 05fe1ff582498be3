//! A machine as FMI sees it, in safe Rust: the table of its variables, and FMI 2.0 and 3.0 but for their C functions, which
//! stand in `crates/fmu`.

pub mod fmi2;
pub mod fmi3;
pub mod instance;
pub mod interface;
