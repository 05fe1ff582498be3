//! Lookup of variables by name: suggestions for misspelt names, and selection by lists, patterns and prefixes.

use foldwing_fmi::interface::Variable;
use wildmatch::WildMatch;

/// The first column of every table, which cannot be selected.
const TIME: &str = "time";
/// Maximum number of letters of a name that a message repeats.
const LONGEST_ECHO: usize = 60;
/// Maximum length in bytes of a name for which a similar one is searched: the cost is the product of the lengths.
const LONGEST_MISSPELT: usize = 200;
/// Jaro–Winkler similarity from which on a name is suggested.
const SUGGESTION_SIMILARITY: f64 = 0.75;

/// A name or pattern that no variable has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// No variable has the name.
    #[error("no {expected} is named `{}`{}", shortened(name), suggestion(nearest.as_deref()))]
    Unknown {
        /// The name.
        name: String,
        /// Kind of variable that was expected, such as `real output`.
        expected: &'static str,
        /// The variable with the most similar name, if one is similar.
        nearest: Option<String>,
    },
    /// No variable matches the pattern.
    #[error("no {expected} matches `{pattern}`; the names begin with {}", beginnings.join(", "))]
    NoMatch {
        /// The pattern.
        pattern: String,
        /// Kind of variable that was expected.
        expected: &'static str,
        /// Beginnings of the names of such variables, up to twelve, in alphabetical order.
        beginnings: Vec<String>,
    },
}

impl NameError {
    /// The error for a name that is not in `known`.
    pub fn unknown<'a>(name: &str, expected: &'static str, known: impl IntoIterator<Item = &'a str>) -> Self {
        Self::Unknown { name: name.to_owned(), expected, nearest: nearest(name, known).map(str::to_owned) }
    }
}

fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or(String::new(), |nearest| format!("; did you mean `{nearest}`?"))
}

/// Shortens a text for a message.
pub fn shortened(text: &str) -> String {
    match text.char_indices().nth(LONGEST_ECHO) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// The most similar of the known names; `None` if none is similar.
fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > LONGEST_MISSPELT {
        return None;
    }
    let name = &shortened(name);
    let similar = known.into_iter().map(|candidate| (strsim::jaro_winkler(name, candidate), candidate));
    let similar = similar.filter(|(similarity, _)| *similarity > SUGGESTION_SIMILARITY);
    similar.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}

/// Name of a row of the table of variables.
pub fn of_variable(row: &Variable) -> &str {
    &row.name
}

/// The rows selected by the names, each once, in the order of the names. A name is a whole name, a list with commas, a pattern with `*`
/// and `?`, a prefix that ends with a dot, or the name of a vector, which selects its components.
///
/// # Errors
/// Names and patterns that no row has. `expected` is the kind of variable, for messages.
pub fn choose<'a, T>(
    names: &[String],
    rows: &[&'a T],
    name_of: fn(&T) -> &str,
    expected: &'static str,
) -> Result<Vec<&'a T>, NameError> {
    let mut list: Vec<&'a T> = Vec::new();
    for name in names.iter().flat_map(|list| split(list)) {
        if name == TIME {
            continue;
        }
        let found = matching(name, rows, name_of);
        if found.is_empty() {
            let known = rows.iter().map(|row| name_of(row));
            return Err(match is_pattern(name) {
                true => no_match(name, expected, known),
                false => NameError::unknown(name, expected, known),
            });
        }
        for row in found {
            if !list.iter().any(|taken| name_of(taken) == name_of(row)) {
                list.push(row);
            }
        }
    }
    Ok(list)
}

/// Returns whether a name is a pattern or prefix.
pub fn is_pattern(name: &str) -> bool {
    name.contains(['*', '?']) || name.ends_with('.')
}

fn matching<'a, T>(name: &str, rows: &[&'a T], name_of: fn(&T) -> &str) -> Vec<&'a T> {
    if let Some(row) = rows.iter().find(|row| name_of(row) == name) {
        return vec![*row];
    }
    if !is_pattern(name) {
        let component = |row: &&&T| ["x", "y", "z"].iter().any(|axis| name_of(row) == format!("{name}.{axis}"));
        return rows.iter().filter(component).copied().collect();
    }
    let pattern = WildMatch::new(&if name.ends_with('.') { format!("{name}*") } else { name.to_owned() });
    rows.iter().copied().filter(|row| name_of(row) != TIME && pattern.matches(name_of(row))).collect()
}

fn no_match<'a>(pattern: &str, expected: &'static str, known: impl Iterator<Item = &'a str>) -> NameError {
    let mut beginnings: Vec<&str> = known.map(|name| name.split(['.', '[']).next().unwrap_or(name)).collect();
    beginnings.sort_unstable();
    beginnings.dedup();
    beginnings.truncate(12);
    let beginnings = beginnings.into_iter().map(str::to_owned).collect();
    NameError::NoMatch { pattern: pattern.to_owned(), expected, beginnings }
}

/// Splits a list at its commas; commas inside brackets and parentheses belong to a name (`a[1,2]`, `max(a,b)`).
pub fn split(list: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut begin) = (Vec::new(), 0, 0);
    for (at, letter) in list.char_indices() {
        match letter {
            '[' | '(' => depth += 1,
            ']' | ')' => depth -= 1,
            ',' if depth <= 0 => {
                parts.push(&list[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[begin..]);
    parts.into_iter().map(str::trim).filter(|part| !part.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Row(&'static str);

    fn name_of(row: &Row) -> &str {
        row.0
    }

    /// Lists, patterns and prefixes select each row once and in order; names with brackets and commas are not split.
    #[test]
    fn names_lists_patterns_and_prefixes_choose() {
        let rows = ["fold.angle", "fold.rate", "tip.position.z", "a[1,2]", "a[1,3]", "folder", "time"].map(Row);
        let rows: Vec<&Row> = rows.iter().collect();
        let names = |words: &[&str]| -> Vec<&str> {
            let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
            choose(&words, &rows, name_of, "variable")
                .unwrap_or_else(|error| panic!("{error}"))
                .iter()
                .map(|row| row.0)
                .collect()
        };
        assert_eq!(names(&["tip.position.z, fold.angle"]), ["tip.position.z", "fold.angle"]);
        assert_eq!(names(&["fold.*", "fold.angle"]), ["fold.angle", "fold.rate"]);
        assert_eq!(names(&["fold."]), ["fold.angle", "fold.rate"]);
        assert_eq!(names(&["fold*"]), ["fold.angle", "fold.rate", "folder"]);
        assert_eq!(names(&["a[1,3],time"]), ["a[1,3]"]);
        assert_eq!(names(&["t*"]), ["tip.position.z"], "the time stands first anyway");
        assert_eq!(names(&["a[1,?]"]), ["a[1,2]", "a[1,3]"]);
        assert_eq!(names(&["tip.position"]), ["tip.position.z"], "a vector is its components");
        let refused = |word: &str| choose(&[word.to_owned()], &rows, name_of, "variable").err().expect("refused");
        assert_eq!(
            refused("x.*").to_string(),
            "no variable matches `x.*`; the names begin with a, fold, folder, time, tip"
        );
        assert_eq!(refused("fold.angel").to_string(), "no variable is named `fold.angel`; did you mean `fold.angle`?");
        assert_eq!(refused("quite else").to_string(), "no variable is named `quite else`");
    }
}
