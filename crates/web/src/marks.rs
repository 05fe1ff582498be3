//! Marked parts of a text, with reason and remedy.

use foldwing_file as config;
use serde_json::{Value, json};
use std::ops::Range;

/// Severity of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// The model is rejected.
    Error,
    /// The model runs, but is probably not as intended.
    Warning,
}

/// A marked part of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mark {
    /// Severity.
    pub severity: Severity,
    /// Line, from 1.
    pub line: usize,
    /// Column of the first marked character in its line, from 1.
    pub column: usize,
    /// Marked range in UTF-16 units from the start of the text, as JavaScript counts.
    pub place: Range<usize>,
    /// Key, reason and allowed values.
    pub message: String,
}

impl Mark {
    fn new(severity: Severity, text: &str, (line, span): (usize, &Range<usize>), message: String) -> Self {
        // a span of the parser lies within the text, except at the end of an incomplete file
        let inside = |at: usize| (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
        let [from, to] = [inside(span.start), inside(span.end)];
        let units = |until: usize| text[..until].encode_utf16().count();
        let begin = text[..from].rfind('\n').map_or(0, |at| at + 1);
        let column = text[begin..from].chars().count() + 1;
        Self { severity, line, column, place: units(from)..units(to), message }
    }

    /// The mark as JSON for the page.
    pub fn json(&self) -> Value {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        json!({
            "severity": severity, "line": self.line, "column": self.column, "from": self.place.start,
            "to": self.place.end, "message": self.message,
        })
    }
}

/// Errors of a rejected text.
pub fn marks(text: &str, error: &config::ConfigError) -> Vec<Mark> {
    let mark = |problem: &config::Problem| {
        let shown = problem.to_string();
        // the page shows the line itself
        let message = shown.split_once(": ").map_or(shown.as_str(), |(_, message)| message).to_owned();
        Mark::new(Severity::Error, text, (problem.line, &problem.span), message)
    };
    error.problems().iter().map(mark).collect()
}

/// Warnings about implausible values in the text of a valid model.
pub fn warnings(text: &str) -> Vec<Mark> {
    let mark = |warning: &config::Warning| {
        let message = format!("key '{}': {}; {}", warning.key, warning.reason, warning.advice);
        Mark::new(Severity::Warning, text, (warning.line, &warning.span), message)
    };
    config::warnings(text).iter().map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> Vec<Mark> {
        marks(text, &config::parse(text, "model").expect_err("refused"))
    }

    fn wing() -> String {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/models/folding_wing.toml");
        std::fs::read_to_string(path).unwrap()
    }

    /// A misspelt key is marked in its line and column, with the intended key.
    #[test]
    fn errors_have_line_column_and_cure() {
        let text = wing().replacen("length_m", "lenght_m", 1);
        let at = text.find("lenght_m").unwrap();
        let found = refused(&text);
        let mark = found.iter().find(|mark| mark.message.contains("lenght_m")).unwrap();
        assert_eq!(mark.line, text[..at].matches('\n').count() + 1);
        assert_eq!(mark.column, at - text[..at].rfind('\n').unwrap());
        assert!(mark.message.starts_with("key '"), "{}", mark.message);
        assert!(mark.message.contains("length_m"), "no cure: {}", mark.message);
        assert_eq!((mark.severity, &text[mark.place.clone()]), (Severity::Error, "lenght_m"));
    }

    /// JavaScript counts characters outside the basic multilingual plane twice and all others once,
    /// regardless of their number of bytes.
    #[test]
    fn places_count_as_javascript_does() {
        let before = "# α 🛩 ß\n";
        let text = before.to_owned() + &wing().replacen("length_m", "lenght_m", 1);
        let mark = refused(&text).into_iter().find(|mark| mark.message.contains("lenght_m")).unwrap();
        let units: Vec<u16> = text.encode_utf16().collect();
        assert_eq!(String::from_utf16(&units[mark.place.clone()]).unwrap(), "lenght_m");
        assert_eq!(before.len() - before.encode_utf16().count(), 4, "bytes and units differ");
    }

    /// An incomplete text gives an error within the text.
    #[test]
    fn every_beginning_of_a_model_is_answered() {
        let text = wing();
        for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)).step_by(37) {
            let part = &text[..end];
            let Err(error) = config::parse(part, "model") else { continue };
            let found = marks(part, &error);
            assert!(!found.is_empty(), "{end}");
            for mark in found {
                assert!(
                    mark.place.start <= mark.place.end && mark.place.end <= part.encode_utf16().count(),
                    "{mark:?}"
                );
                assert!(mark.line <= part.matches('\n').count() + 1, "{mark:?}");
            }
        }
    }
}
