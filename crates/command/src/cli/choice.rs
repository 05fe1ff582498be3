//! `--variables` and similar options: variables selected by names, lists with commas, patterns with `*` and `?`, prefixes with a dot at
//! the end, vectors as their components.

use crate::cli::Failure;
use crate::cli::simulate::unknown;
use crate::report::Channel;
use wildmatch::WildMatch;

/// The first column of every table, which need not be selected.
const TIME: &str = "time";

/// Returns the rows selected by the names, each once, in the order of the names.
///
/// # Errors
/// Names and patterns without a match, with suggestions; `what` describes the rows.
pub(super) fn chosen<'a, C: Channel>(names: &[String], rows: &[&'a C], what: &str) -> Result<Vec<&'a C>, Failure> {
    let mut list: Vec<&'a C> = Vec::new();
    for name in names.iter().flat_map(|list| split(list)) {
        if name == TIME {
            continue;
        }
        let found = matching(name, rows);
        if found.is_empty() {
            let rows = rows.iter().copied();
            return Err(if is_pattern(name) {
                let known: Vec<&str> = rows.map(C::name).collect();
                Failure::Usage(nothing_matches(name, what, &known))
            } else {
                unknown(name, what, rows)
            });
        }
        for row in found {
            if !list.iter().any(|taken| taken.name() == row.name()) {
                list.push(row);
            }
        }
    }
    Ok(list)
}

/// Returns whether a name is a pattern or prefix.
pub(super) fn is_pattern(name: &str) -> bool {
    name.contains(['*', '?']) || name.ends_with('.')
}

fn matching<'a, C: Channel>(name: &str, rows: &[&'a C]) -> Vec<&'a C> {
    if let Some(row) = rows.iter().find(|row| row.name() == name) {
        return vec![*row];
    }
    if !is_pattern(name) {
        // a vector selects its components
        let component = |row: &&&C| ["x", "y", "z"].iter().any(|axis| row.name() == format!("{name}.{axis}"));
        return rows.iter().filter(component).copied().collect();
    }
    let pattern = WildMatch::new(&if name.ends_with('.') { format!("{name}*") } else { name.to_owned() });
    rows.iter().copied().filter(|row| row.name() != TIME && pattern.matches(row.name())).collect()
}

/// Error text for a pattern without a match, with the beginnings of the names.
fn nothing_matches(pattern: &str, what: &str, known: &[&str]) -> String {
    let mut groups: Vec<&str> = known.iter().map(|name| name.split(['.', '[']).next().unwrap_or(name)).collect();
    groups.dedup();
    groups.sort_unstable();
    groups.dedup();
    groups.truncate(12);
    format!("no {what} matches `{pattern}`; their names begin with {}", groups.join(", "))
}

/// Splits a list at its commas; commas inside brackets belong to a name (`a[1,2]`).
fn split(list: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut begin) = (Vec::new(), 0, 0);
    for (at, letter) in list.char_indices() {
        match letter {
            '[' => depth += 1,
            ']' => depth -= 1,
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
    use foldwing_fmi::interface::Value;

    struct Row(&'static str);

    impl Channel for Row {
        const LISTED_BY: &'static str = "`x`";

        fn name(&self) -> &str {
            self.0
        }

        fn is_input(&self) -> bool {
            false
        }

        fn kind(&self) -> Option<Value> {
            None
        }

        fn range(&self) -> Option<(f64, f64)> {
            None
        }
    }

    /// Lists, patterns and prefixes choose each row once and in order; names with brackets and commas stay whole.
    #[test]
    fn names_lists_patterns_and_prefixes_choose() {
        let rows = ["fold.angle", "fold.rate", "tip.position.z", "a[1,2]", "a[1,3]", "folder", "time"].map(Row);
        let rows: Vec<&Row> = rows.iter().collect();
        let names = |words: &[&str]| -> Vec<&str> {
            let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
            chosen(&words, &rows, "variable")
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
        let refused = |word: &str| match chosen(&[word.to_owned()], &rows, "variable") {
            Err(Failure::Usage(message)) => message,
            _ => panic!("{word} is taken"),
        };
        assert_eq!(refused("x.*"), "no variable matches `x.*`; their names begin with a, fold, folder, time, tip");
        assert!(refused("fold.angel").contains("fold.angle"));
    }
}
