//! The command `foldwing`: models to FMUs, simulations, checks.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
