//! The command `foldwing`: models to FMUs, simulations, pictures, checks.

pub mod cli;
#[cfg(feature = "import")]
pub mod import;
pub mod packaging;
pub mod report;

pub use cli::run;
