//! Errors of a model file: file, line, key, value and allowed values.

use std::fmt;
use std::ops::Range;

/// Error of a model file.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// File as the caller named it.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The text is not a model. Displays one problem per line, each as `file:line: …`.
    #[error("{}", lines(file, problems))]
    Refused {
        /// File as the caller named it.
        file: String,
        /// Every problem found, in the order of the file; never empty.
        problems: Vec<Problem>,
    },
}

impl ConfigError {
    /// The errors in the text; empty if the file could not be read.
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

/// One error. Displays as `line: key '…': …`, to follow the file's name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Line of the key or value, from 1.
    pub line: usize,
    /// Bytes of the text marked by a caret: the key, or its invalid value.
    pub span: Range<usize>,
    /// Path of the key, e.g. `body.inner.length_m`; empty for the file as a whole and for syntax.
    pub key: String,
    /// Kind of the error.
    pub fault: Fault,
}

/// Kind of a [`Problem`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// Not TOML.
    Syntax {
        /// The parser's message.
        message: String,
    },
    /// No such key in this table.
    UnknownKey {
        /// Suggested replacement, if there is a similar key.
        suggestion: Option<String>,
        /// Keys of this table.
        allowed: Vec<String>,
    },
    /// A key of 0.1.0 whose name has changed.
    RenamedKey {
        /// The name of today.
        new: String,
    },
    /// Number of further errors that are not listed.
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
        /// The value as written, shortened; or a description of the table.
        value: String,
        /// Allowed values, with the unit.
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
