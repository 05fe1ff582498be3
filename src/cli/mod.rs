//! The command line: arguments, exit codes, and one module per command.

mod air_summary;
mod check;
mod grid;
mod joint_size;
mod latency;
mod lattice;
mod linearize;
mod modes;
mod new;
mod package;
mod pictures;
mod processor_time;
mod progress;
#[cfg(feature = "import")]
mod run;
#[cfg(not(feature = "import"))]
#[path = "run_without_import.rs"]
mod run;
mod settings;
mod simulate;
mod statics;
mod strains;
mod sweep;
mod timing;

use clap::{Parser, Subcommand};
use foldwing::config::{self, Machine};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// What `--help` says below the options.
const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  the content of a file was refused: model, inputs, library or FMU
  2  the command line was refused
  3  the simulation failed, the rows up to that time are in the CSV; or there is no equilibrium or linear model
  4  a file could not be read or written";

/// Name of the build: version, commit if it was built from a repository, target.
fn version() -> &'static str {
    if env!("FOLDWING_COMMIT").is_empty() {
        concat!(env!("CARGO_PKG_VERSION"), " (", env!("FOLDWING_TARGET"), ")")
    } else {
        concat!(env!("CARGO_PKG_VERSION"), " (", env!("FOLDWING_COMMIT"), ", ", env!("FOLDWING_TARGET"), ")")
    }
}

/// Flexible folding wings from short model files: FMUs, simulations, checks.
#[derive(Parser)]
#[command(name = "foldwing", version = version(), after_help = EXIT_CODES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a commented model file to start from
    New(new::Arguments),
    /// Make an FMU of a model
    Package(package::Arguments),
    /// Simulate a model and write its outputs as CSV
    Simulate(simulate::Arguments),
    /// Simulate many variants of a model, and write a row for each
    Sweep(sweep::Arguments),
    /// Measure how long single steps take under a turbulent load
    Latency(latency::Arguments),
    /// Run an FMU of any tool (FMI 2.0 co-simulation) and write its outputs as CSV
    Run(run::Arguments),
    /// Say what was understood of a model
    Check(check::Arguments),
    /// Bring a model to rest under its loads and print its shape
    Static(statics::Arguments),
    /// Print natural frequencies and damping
    Modes(modes::Arguments),
    /// Write the linear model between inputs and outputs
    Linearize(linearize::Arguments),
    /// Print the JSON schema of model files, for editors that complete them
    Schema,
}

/// Why a command stops; each kind has its exit code.
#[derive(Debug, thiserror::Error)]
enum Failure {
    /// The content of a file was refused.
    #[error("{0}")]
    Refused(String),
    /// The command line asks for something that does not exist.
    #[error("{0}")]
    Usage(String),
    /// The simulation gave up.
    #[error("the simulation failed: {0}")]
    Simulation(String),
    /// Statics, modes or linearisation gave up.
    #[error("{0}")]
    Statics(String),
    /// A file could not be read or written.
    #[error("{0}")]
    Files(String),
    /// Standard output was closed, as `head` does: nothing is wrong.
    #[error("standard output was closed")]
    Closed,
}

impl Failure {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Closed => 0,
            Self::Refused(_) => 1,
            Self::Usage(_) => 2,
            Self::Simulation(_) | Self::Statics(_) => 3,
            Self::Files(_) => 4,
        }
    }

    /// A failed write to `target`.
    fn writing(target: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::Closed,
            _ => Self::Files(format!("{target}: cannot be written: {error}")),
        }
    }
}

/// Runs the command that the arguments name.
pub fn run() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::New(arguments) => new::run(&arguments),
        Command::Package(arguments) => package::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Latency(arguments) => latency::run(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Static(arguments) => statics::run(&arguments),
        Command::Modes(arguments) => modes::run(&arguments),
        Command::Linearize(arguments) => linearize::run(&arguments),
        Command::Schema => print(&config::schema()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !matches!(failure, Failure::Closed) {
                eprintln!("foldwing: {failure}");
            }
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Writes text to standard output, with a final line feed.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    writeln!(out, "{}", text.trim_end())
        .and_then(|()| out.flush())
        .map_err(|error| Failure::writing("standard output", &error))
}

/// A model and its text.
fn read_model(path: &Path) -> Result<(Machine, String), Failure> {
    let bytes =
        std::fs::read(path).map_err(|error| Failure::Files(format!("{}: cannot be read: {error}", path.display())))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let line = error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
        Failure::Refused(format!("{}:{}: a model file is UTF-8 text; this line is not", path.display(), line + 1))
    })?;
    let machine =
        config::parse(&text, &path.display().to_string()).map_err(|error| Failure::Refused(error.to_string()))?;
    Ok((machine, text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    /// The argument definitions are consistent, and `--help` documents every exit code.
    #[test]
    fn command_line_is_consistent() {
        Arguments::command().debug_assert();
        for code in 0..=4 {
            assert!(EXIT_CODES.contains(&format!("\n  {code}  ")), "exit code {code}");
        }
    }
}
