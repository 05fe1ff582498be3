//! `foldwing completions`: script for the shell completion of commands, options and files.

use crate::cli::{Failure, print};
use clap_complete::Shell;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::COMPLETIONS)]
pub struct Arguments {
    /// Shell to complete for
    shell: Shell,
}

/// Prints the script.
pub fn run(arguments: &Arguments, mut command: clap::Command) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "foldwing", &mut script);
    print(&String::from_utf8_lossy(&script))
}
