//! Errors of foreign FMUs: reasons why an FMU cannot be run, and the statuses of its functions.

use std::io;
use std::path::{Path, PathBuf};
use zip::result::ZipError;

/// Error of an FMU that cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file cannot be read or unpacked.
    #[error("{path}: cannot be read: {source}", path = path.display())]
    File {
        /// The FMU.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is not an archive with a description.
    #[error("{path}: not an FMU: {cause}", path = path.display())]
    NotAnFmu {
        /// The file.
        path: PathBuf,
        /// The missing or damaged part.
        cause: String,
    },
    /// The version of the standard is not supported.
    #[error("{path}: FMI {found}; only FMI 2.0 and FMI 3.0 can be run", path = path.display())]
    Version {
        /// The FMU.
        path: PathBuf,
        /// `fmiVersion` of the description.
        found: String,
    },
    /// The FMU is for Model Exchange only.
    #[error("{path}: for model exchange only; only co-simulation can be run", path = path.display())]
    NoCoSimulation {
        /// The FMU.
        path: PathBuf,
    },
    /// There is no library for this platform.
    #[error("{path}: no library for this platform, `{expected}`; the FMU has {found}", path = path.display())]
    NoLibrary {
        /// The FMU.
        path: PathBuf,
        /// Path inside the archive.
        expected: String,
        /// Folders in `binaries`, or a text if there are none.
        found: String,
    },
    /// The library cannot be loaded.
    #[error("{path}: `{library}` cannot be loaded: {cause}", path = path.display())]
    Library {
        /// The FMU.
        path: PathBuf,
        /// Path inside the archive.
        library: String,
        /// Error of the loader.
        cause: String,
    },
    /// The library lacks a function required for co-simulation.
    #[error("{path}: `{library}` does not export the function {function}", path = path.display())]
    NoFunction {
        /// The FMU.
        path: PathBuf,
        /// Path inside the archive.
        library: String,
        /// Name in the standard.
        function: &'static str,
    },
    /// The FMU returned no instance.
    #[error("{path}: {function} returned no instance", path = path.display())]
    NotInstantiated {
        /// The FMU.
        path: PathBuf,
        /// Name in the standard.
        function: &'static str,
    },
}

/// Status of a function other than `fmi2OK` or `fmi2Warning`, or the corresponding one of FMI 3.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The call was rejected and changed nothing.
    Discard,
    /// The call failed; the instance can only be reset or freed.
    Error,
    /// All instances of the FMU are unusable and may not even be freed.
    Fatal,
    /// A step of FMI 3.0 returned early without permission.
    Early,
    /// A status that cannot be handled: `fmi2Pending`, since steps are never asynchronous here, or one that the standard does not
    /// define.
    Other,
}

/// A call with an error status.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{call}: the FMU returned {answer}", answer = fault.name(&call[..4]))]
pub struct CallError {
    /// Function and the purpose of the call.
    pub call: String,
    /// Status that it returned.
    pub fault: Fault,
}

impl Fault {
    /// Name of the status in the standard, with the prefix `fmi2` or `fmi3`.
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

/// Error of reading an archive.
pub(super) fn of_archive(path: &Path, error: ZipError) -> ImportError {
    #[allow(clippy::wildcard_enum_match_arm, reason = "an enum of the crate `zip`, which says that it may grow")]
    match error {
        ZipError::Io(source) => ImportError::File { path: path.to_owned(), source },
        error => ImportError::NotAnFmu { path: path.to_owned(), cause: error.to_string() },
    }
}
