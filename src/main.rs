//! The command `foldwing`: models to FMUs, simulations, checks.

#![forbid(unsafe_code)]

use std::process::ExitCode;

#[cfg(feature = "import")]
fn main() -> ExitCode {
    foldwing_import::command()
}

#[cfg(not(feature = "import"))]
fn main() -> ExitCode {
    foldwing_command::run()
}
