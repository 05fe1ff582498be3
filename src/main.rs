//! The command `foldwing`: models to FMUs, simulations, checks.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    foldwing_command::run()
}
