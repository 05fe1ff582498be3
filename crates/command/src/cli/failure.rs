//! Failures of commands, and their exit codes.

use foldwing_file::ConfigError;
use std::io;

/// Reason for the failure of a command; each type has its exit code.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The content of a file is rejected.
    #[error("{0}")]
    Refused(String),
    /// A model file is invalid.
    #[error("{error}")]
    Model {
        /// The file's text.
        text: String,
        /// Errors in it.
        error: ConfigError,
    },
    /// The command line is invalid.
    #[error("{0}")]
    Usage(String),
    /// The simulation failed.
    #[error("the simulation failed: {0}")]
    Simulation(String),
    /// A static, modal or linear analysis failed.
    #[error("{0}")]
    Statics(String),
    /// A file could not be read or written.
    #[error("{0}")]
    Files(String),
    /// Two tables differ: number of differing columns, number of all columns.
    #[error("{0} of {1} columns differ by more than the tolerance; --rtol, --atol and --tolerance NAME=X set it")]
    Differ(usize, usize),
    /// Standard output was closed, for example by `head`: not an error.
    #[error("standard output was closed")]
    Closed,
}

impl Failure {
    /// Returns the exit code of the command.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Closed => 0,
            Self::Refused(_) | Self::Model { .. } => 1,
            Self::Usage(_) => 2,
            Self::Simulation(_) | Self::Statics(_) => 3,
            Self::Files(_) => 4,
            Self::Differ(..) => 5,
        }
    }

    /// Returns the failure for an error while writing to `target`.
    pub fn writing(target: &str, error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            Self::Closed
        } else {
            Self::Files(format!("{target}: cannot be written: {error}"))
        }
    }
}
