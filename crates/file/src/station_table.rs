//! Table of numbers at stations along a body, as read from a file, and the error of such a file.

use std::fmt::Write;

/// Error in a file of stations.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct StationFault {
    /// Line, numbered from 1.
    pub line: usize,
    /// Cause of the error.
    pub reason: String,
}

/// Table of numbers in named columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationTable {
    /// Names of the columns, which are keys of the model file.
    pub names: Vec<String>,
    /// Values of each column.
    pub columns: Vec<Vec<f64>>,
}

impl StationTable {
    /// Returns a column by its name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|known| known == name)?;
        self.columns.get(index).map(Vec::as_slice)
    }

    /// Formats the table as `key = { name = [...], … }`, one line of TOML.
    pub(super) fn text(&self, key: &str) -> String {
        let mut text = format!("{key} = {{ ");
        for (index, (name, column)) in self.names.iter().zip(&self.columns).enumerate() {
            let comma = if index == 0 { "" } else { ", " };
            let numbers: Vec<String> = column.iter().map(|value| format!("{value:?}")).collect();
            // writing to a String cannot fail
            let _ = write!(text, "{comma}{name} = [{}]", numbers.join(", "));
        }
        text + " }"
    }
}

/// Returns the text without the byte order mark that some programs write at its beginning.
pub(super) fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

pub(super) fn fault(line: usize, reason: impl Into<String>) -> StationFault {
    StationFault { line, reason: reason.into() }
}
