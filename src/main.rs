//! The command `foldwing`: models to FMUs, simulations, checks.

#![forbid(unsafe_code)]

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
