//! Characters that are not allowed in texts of a model, because XML cannot contain them, even though TOML can write them as escapes such
//! as `\u0001`.

use crate::document::{Document, key_text};
use crate::error::{Fault, Problem};
use crate::structure::MAXIMUM_PROBLEMS;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Maximum depth of nested tables: no known key is that deep, and unknown keys are reported by the next pass.
const DEEPEST: usize = 16;

/// Allowed characters, for the message.
const ALLOWED: &str = "text without control characters except line feeds and tabs";

/// Checks every text of the file.
///
/// # Errors
/// All texts with such characters, in the order of the file.
pub(super) fn check(document: &Document) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    table(document.root(), &mut Vec::new(), document, &mut problems);
    problems.sort_by_key(|problem| problem.line);
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// Returns whether the character is not allowed in XML or is another control character.
fn refused(letter: char) -> bool {
    letter.is_control() && !matches!(letter, '\n' | '\r' | '\t') || matches!(letter, '\u{fffe}' | '\u{ffff}')
}

fn table(inside: &DeTable, path: &mut Vec<String>, document: &Document, problems: &mut Vec<Problem>) {
    if path.len() > DEEPEST || problems.len() >= MAXIMUM_PROBLEMS {
        return;
    }
    for (key, entry) in inside {
        path.push(key.get_ref().to_string());
        value(entry, key.span().start, path, document, problems);
        path.pop();
    }
}

fn value(
    entry: &Spanned<DeValue>,
    offset: usize,
    path: &mut Vec<String>,
    document: &Document,
    problems: &mut Vec<Problem>,
) {
    match entry.get_ref() {
        DeValue::Table(inside) => table(inside, path, document, problems),
        DeValue::Array(items) => items.iter().for_each(|item| value(item, offset, path, document, problems)),
        DeValue::String(text) => {
            if let Some(letter) = text.chars().find(|letter| refused(*letter)) {
                let value = format!("a text with the control character U+{:04X}", u32::from(letter));
                let fault = Fault::NotAllowed { value, allowed: ALLOWED.to_owned() };
                let span = document.value_span(offset, entry);
                problems.push(Problem { line: document.line(offset), span, key: key_text(path), fault });
            }
        }
        DeValue::Integer(_) | DeValue::Float(_) | DeValue::Boolean(_) | DeValue::Datetime(_) => {}
    }
}
