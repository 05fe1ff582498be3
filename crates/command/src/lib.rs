//! The command `foldwing`: export of FMUs, simulations, pictures, analyses.

pub mod cli;
pub mod live;
pub mod packaging;
pub mod report;

pub use cli::run;
