//! Why a foreign FMU cannot be run, and what its functions answered.

use std::io;
use std::path::PathBuf;

/// Why an FMU cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file cannot be read, or not be unpacked.
    #[error("{path}: cannot be read: {source}", path = path.display())]
    File {
        /// The FMU.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Neither archive nor description.
    #[error("{path}: not an FMU: {cause}", path = path.display())]
    NotAnFmu {
        /// The file.
        path: PathBuf,
        /// What is missing or damaged.
        cause: String,
    },
    /// Another version of the standard.
    #[error("{path}: FMI {found}; only FMI 2.0 and FMI 3.0 can be run", path = path.display())]
    Version {
        /// The FMU.
        path: PathBuf,
        /// `fmiVersion` of the description.
        found: String,
    },
    /// Model exchange only.
    #[error("{path}: for model exchange only; only co-simulation can be run", path = path.display())]
    NoCoSimulation {
        /// The FMU.
        path: PathBuf,
    },
    /// No library for this platform.
    #[error("{path}: no library for this platform, `{expected}`; the FMU has {found}", path = path.display())]
    NoLibrary {
        /// The FMU.
        path: PathBuf,
        /// Path inside the archive.
        expected: String,
        /// Folders of `binaries`, or a word for none.
        found: String,
    },
    /// The library cannot be loaded.
    #[error("{path}: `{library}` cannot be loaded: {cause}", path = path.display())]
    Library {
        /// The FMU.
        path: PathBuf,
        /// Path inside the archive.
        library: String,
        /// What the loader says.
        cause: String,
    },
    /// The library lacks a function that co-simulation needs.
    #[error("{path}: `{library}` does not export the function {function}", path = path.display())]
    NoFunction {
        /// The FMU.
        path: PathBuf,
        /// Path inside the archive.
        library: String,
        /// Name of the standard.
        function: &'static str,
    },
    /// The FMU gave no instance.
    #[error("{path}: {function} returned no instance", path = path.display())]
    NotInstantiated {
        /// The FMU.
        path: PathBuf,
        /// Name of the standard.
        function: &'static str,
    },
}

/// What a function answered instead of `fmi2OK` or `fmi2Warning`, or the same of FMI 3.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Refused, nothing changed.
    Discard,
    /// Failed; the instance can only be reset or freed.
    Error,
    /// Every instance of the FMU is lost; not even freeing is allowed.
    Fatal,
    /// A step of FMI 3.0 that ended before its end, without having been allowed to.
    Early,
    /// No status that can be handled: `fmi2Pending`, for steps are never asynchronous here, or none of the standard.
    Other,
}

/// A call that an FMU refused or failed in.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{call}: the FMU returned {answer}", answer = fault.name(&call[..4]))]
pub struct CallError {
    /// Function, and what it was called for.
    pub call: String,
    /// Its answer.
    pub fault: Fault,
}

impl Fault {
    /// Name in the version of the standard whose names begin with `prefix`, `fmi2` or `fmi3`.
    pub fn name(self, prefix: &str) -> String {
        match self {
            Self::Discard => format!("{prefix}Discard"),
            Self::Error => format!("{prefix}Error"),
            Self::Fatal => format!("{prefix}Fatal"),
            Self::Early => format!("{prefix}OK with earlyReturn"),
            Self::Other if prefix == "fmi3" => "a status that FMI does not define".to_owned(),
            Self::Other => "fmi2Pending, which is not supported, or a status that FMI does not define".to_owned(),
        }
    }
}
