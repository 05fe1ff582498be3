//! Errors of a model file: file, line, key, value and allowed values.

use std::fmt;
use std::ops::Range;

/// Error of a model file.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// File name given by the caller.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The text is not a valid model. Displayed with one problem per line, each as `file:line: …`.
    #[error("{}", lines(file, problems))]
    Refused {
        /// File name given by the caller.
        file: String,
        /// Every problem found, in the order of the file; never empty.
        problems: Vec<Problem>,
    },
}

impl ConfigError {
    /// Errors in the text; empty if the file could not be read.
    pub fn problems(&self) -> &[Problem] {
        match self {
            Self::Read { .. } => &[],
            Self::Refused { problems, .. } => problems,
        }
    }
}

fn lines(file: &str, problems: &[Problem]) -> String {
    problems.iter().map(|problem| format!("{file}:{problem}")).collect::<Vec<_>>().join("\n")
}

/// Error in a model file. Displayed as `line: key '…': …`, to be appended to the file's name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Line of the key or value, numbered from 1.
    pub line: usize,
    /// Byte range marked by a caret: the key, or its invalid value.
    pub span: Range<usize>,
    /// Path of the key, such as `body.inner.length_m`; empty for the file as a whole and for syntax errors.
    pub key: String,
    /// Type of the error.
    pub fault: Fault,
}

/// Type of the error of a [`Problem`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// The text is not valid TOML.
    Syntax {
        /// The parser's message.
        message: String,
    },
    /// The table has no such key.
    UnknownKey {
        /// Suggested replacement, if a similar key exists.
        suggestion: Option<String>,
        /// Keys of the table.
        allowed: Vec<String>,
    },
    /// The key was renamed after version 0.1.0.
    RenamedKey {
        /// Present name.
        new: String,
    },
    /// Further errors are not listed.
    Further {
        /// Their number.
        count: usize,
    },
    /// A required key is missing.
    MissingKey {
        /// Allowed values.
        allowed: String,
    },
    /// The value is not allowed.
    NotAllowed {
        /// Value as written, shortened; or a description of the table.
        value: String,
        /// Allowed values, with their unit.
        allowed: String,
    },
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, key, fault, .. } = self;
        write!(f, "{line}: ")?;
        match fault {
            Fault::Syntax { message } => write!(f, "not valid TOML: {message}"),
            Fault::UnknownKey { suggestion, allowed } => {
                write!(f, "key '{key}' is unknown; ")?;
                if let Some(suggestion) = suggestion {
                    write!(f, "{suggestion}; ")?;
                }
                write!(f, "allowed keys: {}", allowed.join(", "))
            }
            Fault::RenamedKey { new } => write!(f, "key '{key}' is now called '{new}'"),
            Fault::Further { count } => write!(f, "and {count} further problems after this line"),
            Fault::MissingKey { allowed } => write!(f, "key '{key}' is missing; allowed: {allowed}"),
            Fault::NotAllowed { value, allowed } => {
                write!(f, "key '{key}': {value} is not allowed; allowed: {allowed}")
            }
        }
    }
}
