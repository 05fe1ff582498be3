//! Text of the model file as a tree in which every key and value has its position.

use crate::error::{Fault, Problem};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Maximum number of characters of a value that is quoted in a message.
const LONGEST_VALUE: usize = 60;

/// Parsed text. Keys are looked up by path; lines are numbered from 1.
pub(super) struct Document<'a> {
    text: &'a str,
    /// Byte offset of the beginning of each line.
    lines: Vec<usize>,
    root: DeTable<'a>,
}

/// Key and value in a [`Document`].
#[derive(Clone, Copy)]
pub(super) struct Entry<'t, 'a> {
    /// Byte offset of the key.
    pub offset: usize,
    /// Value of the key.
    pub value: &'t Spanned<DeValue<'a>>,
}

impl<'a> Document<'a> {
    /// Parses TOML.
    ///
    /// # Errors
    /// A problem with the parser's message.
    pub fn parse(text: &'a str) -> Result<Self, Vec<Problem>> {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let mut document = Self { text, lines, root: DeTable::new() };
        match DeTable::parse(text) {
            Ok(root) => document.root = root.into_inner(),
            Err(error) => return Err(vec![document.syntax_problem(&error)]),
        }
        Ok(document)
    }

    /// Table of the whole file.
    pub fn root(&self) -> &DeTable<'a> {
        &self.root
    }

    /// Line number at a byte offset.
    pub fn line(&self, offset: usize) -> usize {
        self.lines.partition_point(|start| *start <= offset).max(1)
    }

    /// Converts an error of the parser to a problem.
    pub fn syntax_problem(&self, error: &toml::de::Error) -> Problem {
        let mut message = error.message().lines().collect::<Vec<_>>().join(", ");
        let mut span = error.span().unwrap_or(0..0);
        let line = self.line(span.start);
        let hint = hint(self.text, line, &message);
        if hint.starts_with(COMMA) {
            span = self.value_on(line).unwrap_or(span);
        }
        message += &hint;
        Problem { line, span, key: String::new(), fault: Fault::Syntax { message } }
    }

    /// Byte range of the value after the `=` in a line.
    fn value_on(&self, line: usize) -> Option<Range<usize>> {
        let begin = *self.lines.get(line - 1)?;
        let code = self.text[begin..].lines().next()?.split('#').next()?;
        let value = code.split_once('=')?.1;
        let start = begin + code.len() - value.trim_start().len();
        Some(start..start + value.trim().len())
    }

    /// Key and value at a path.
    pub fn find(&self, path: &[&str]) -> Option<Entry<'_, 'a>> {
        let (first, rest) = path.split_first()?;
        let mut entry = find_in(&self.root, first)?;
        for key in rest {
            entry = find_in(entry.value.get_ref().as_table()?, key)?;
        }
        Some(entry)
    }

    /// Line of a key, or of the innermost enclosing table that is written in the file.
    pub fn line_of(&self, path: &[&str]) -> usize {
        (1..=path.len()).rev().find_map(|n| self.find(&path[..n])).map_or(1, |entry| self.line(entry.offset))
    }

    /// Text of a value as quoted in a message.
    pub fn value_text(&self, value: &Spanned<DeValue<'a>>) -> String {
        match value.get_ref() {
            DeValue::Table(table) if table.is_empty() => "an empty table".to_owned(),
            DeValue::Table(_) => "a table".to_owned(),
            DeValue::Array(array) if array.iter().any(|item| item.get_ref().is_table()) => {
                "an array of tables".to_owned()
            }
            DeValue::String(_)
            | DeValue::Integer(_)
            | DeValue::Float(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Array(_) => shorten(self.text.get(value.span()).unwrap_or_default()),
        }
    }

    /// Error for an invalid or missing value at `path`.
    pub fn refusal(&self, path: &[&str], allowed: String) -> Problem {
        let (fault, span) = match self.find(path) {
            Some(entry) => {
                let fault = Fault::NotAllowed { value: self.value_text(entry.value), allowed };
                (fault, self.value_span(entry.offset, entry.value))
            }
            None => (Fault::MissingKey { allowed }, self.span_of(path)),
        };
        Problem { line: self.line_of(path), span, key: key_text(path), fault }
    }

    /// Byte range of a key, or of the innermost enclosing table that is written in the file.
    pub fn span_of(&self, path: &[&str]) -> Range<usize> {
        let entry = (1..=path.len()).rev().find_map(|n| self.find(&path[..n]));
        entry.map_or(0..0, |entry| self.key_span(entry.offset))
    }

    /// Byte range of the key that starts at `offset`, including its quotes.
    pub fn key_span(&self, offset: usize) -> Range<usize> {
        let rest = self.text.get(offset..).unwrap_or_default();
        let bare = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
        let length = match rest.chars().next() {
            Some(quote @ ('"' | '\'')) => rest[1..].find([quote, '\n']).map_or(rest.len(), |end| end + 2),
            Some(letter) if bare(letter) => rest.find(|letter| !bare(letter)).unwrap_or(rest.len()),
            _ => 0,
        };
        offset..(offset + length).min(self.text.len())
    }

    /// Byte range of a value whose key starts at `offset`; for a table, which may have many lines, that of its key.
    pub fn value_span(&self, offset: usize, value: &Spanned<DeValue<'a>>) -> Range<usize> {
        let own = value.span();
        if value.get_ref().is_table() || own.is_empty() { self.key_span(offset) } else { own }
    }
}

/// Beginning of the hint on decimal commas.
const COMMA: &str = "; a decimal comma?";

/// Suggestion for a line that is not valid TOML; empty if there is none.
fn hint(text: &str, line: usize, message: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let Some(written) = lines.get(line - 1).map(|line| line.split('#').next().unwrap_or_default().trim()) else {
        return String::new();
    };
    if message.starts_with("duplicate key") {
        return first_of(&lines[..line - 1], written);
    }
    match written.split_once('=').and_then(|(_, value)| value.trim().split_once(',')) {
        Some((whole, part)) if is_digits(whole.trim_start_matches(['+', '-'])) && is_digits(part) => {
            format!("{COMMA} write {whole}.{part}")
        }
        _ if message.contains("quoted") => String::new(), // the parser's message already contains it
        _ => match written.split_once('=').map(|(_, value)| value.trim()) {
            Some(word) if is_word(word) => format!("; text must be in quotes: write {word:?}"),
            _ => String::new(),
        },
    }
}

/// Returns whether a text is a bare word that is not a keyword of TOML.
fn is_word(text: &str) -> bool {
    text.starts_with(char::is_alphabetic)
        && text.chars().all(|letter| letter.is_alphanumeric() || letter == '_')
        && !["true", "false", "inf", "nan"].contains(&text)
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Describes the first occurrence of the table or key that the line `written` repeats.
fn first_of(before: &[&str], written: &str) -> String {
    let code = |line: &str| line.split('#').next().unwrap_or_default().trim().to_owned();
    let key = |line: &str| line.split('=').next().unwrap_or_default().trim().to_owned();
    let found = if written.starts_with('[') {
        before.iter().position(|line| code(line) == written)
    } else {
        // keys of the same table, which follow its last header
        let begin = before.iter().rposition(|line| line.trim_start().starts_with('[')).map_or(0, |at| at + 1);
        before[begin..].iter().position(|line| key(line) == key(written)).map(|at| begin + at)
    };
    let what = shorten(&key(written));
    found.map_or(format!(": {what}"), |at| format!(": {what}, already on line {}", at + 1))
}

fn find_in<'t, 'a>(table: &'t DeTable<'a>, key: &str) -> Option<Entry<'t, 'a>> {
    let (key, value) = table.get_key_value(key)?;
    Some(Entry { offset: key.span().start, value })
}

/// Path in TOML notation: bare keys where possible, others in quotes.
pub(super) fn key_text<S: AsRef<str>>(path: &[S]) -> String {
    let parts: Vec<String> = path
        .iter()
        .map(|part| {
            let part = part.as_ref();
            let bare = !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
            if bare { part.to_owned() } else { format!("{:?}", shorten(part)) }
        })
        .collect();
    parts.join(".")
}

/// Shortens a text to one line of at most [`LONGEST_VALUE`] characters.
fn shorten(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "name = 'a'\n[body.inner]\nlength_m = 1.5\n[body.outer.x]\n";

    #[test]
    fn keys_know_their_line() {
        let document = Document::parse(TEXT).unwrap();
        assert_eq!(document.line_of(&["name"]), 1);
        assert_eq!(document.line_of(&["body", "inner"]), 2);
        assert_eq!(document.line_of(&["body", "inner", "length_m"]), 3);
        assert_eq!(document.line_of(&["body", "inner", "elements"]), 2, "a missing key stands at its table");
        assert_eq!(document.line_of(&["body", "outer", "x"]), 4);
        assert_eq!(document.line_of(&["gauge"]), 1);
    }

    #[test]
    fn long_values_are_cut_between_characters() {
        assert_eq!(shorten(&"é".repeat(80)), format!("{}…", "é".repeat(60)));
        assert_eq!(shorten("[1,\n   2]"), "[1, 2]");
    }
}
