//! Suggestions for misspelt or misplaced keys and names.

use crate::schema::{Node, properties, tagged};

/// Minimum similarity at which a word with a larger edit distance is suggested, such as `aerodynamics` for `aero`, or `body` for
/// `bodies`.
const LIKENESS: f64 = 0.82;
/// Maximum number of tables named in a message.
const MAXIMUM_HOMES: usize = 4;

/// Returns the candidate with the smallest edit distance to `word`, if this is small enough; otherwise the most similar one, if it is
/// very similar. Case is ignored, and swapping adjacent letters counts as one edit.
pub(super) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let word = word.to_lowercase();
    let letters = word.chars().count();
    let limit = (letters / 3).max(2);
    let edits =
        candidates.iter().map(|candidate| (strsim::damerau_levenshtein(&word, &candidate.to_lowercase()), *candidate));
    let near = edits.filter(|(edits, candidate)| *edits <= limit && *edits < candidate.chars().count().min(letters));
    let alike = || {
        let scored =
            candidates.iter().map(|candidate| (strsim::jaro_winkler(&word, &candidate.to_lowercase()), *candidate));
        scored.filter(|(score, _)| *score >= LIKENESS && letters > 2).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    near.min_by_key(|(edits, _)| *edits).map(|(_, found)| found).or_else(|| alike().map(|(_, found)| found))
}

/// Returns ` (did you mean "x"?)` if there is a similar candidate, otherwise an empty text.
pub(super) fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, candidates).map_or(String::new(), |near| format!(" (did you mean {near:?}?)"))
}

/// Tables that have a key, in the notation of the file, such as `[joint.<name>.motor]`; empty if there are none or many.
pub(super) fn homes(top: Node, key: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut look = |title: String, schema: Node| {
        if properties(schema).any(|(known, _)| known == key) {
            found.push(title);
        }
    };
    look("the top of the file, before the first table".to_owned(), top);
    for (name, property) in properties(top) {
        match property.child("additionalProperties").resolve() {
            inner if inner.is_table() => visit(&format!("[{name}.<name>]"), inner, &mut look),
            _ => visit(&format!("[{name}]"), property.resolve(), &mut look),
        }
    }
    if found.len() > MAXIMUM_HOMES { Vec::new() } else { found }
}

/// Calls `look` for a table, its variants and the tables inside it.
fn visit<'s>(title: &str, schema: Node<'s>, look: &mut impl FnMut(String, Node<'s>)) {
    match tagged(schema) {
        Some((tag, variants)) => {
            variants.into_iter().for_each(|(name, variant)| look(format!("{title} with {tag} = {name:?}"), variant));
        }
        None => look(title.to_owned(), schema),
    }
    for (key, property) in properties(schema).filter(|(_, property)| property.resolve()["type"] == "object") {
        visit(&format!("{}.{key}]", title.trim_end_matches(']')), property.resolve(), look);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swapped_letters_are_one_edit() {
        assert_eq!(nearest("Lenght_m", ["length_m", "section"]), Some("length_m"));
        assert_eq!(nearest("YOUNG_PA", ["youngs_modulus_Pa"]), Some("youngs_modulus_Pa"));
        assert_eq!(nearest("bal", ["clamped", "ball"]), Some("ball"));
    }

    #[test]
    fn beginnings_and_plurals_are_known() {
        assert_eq!(nearest("aero", ["section", "aerodynamics"]), Some("aerodynamics"));
        assert_eq!(nearest("bodies", ["section", "body", "joint"]), Some("body"));
        assert_eq!(nearest("rect", ["rectangle", "ellipse"]), Some("rectangle"));
    }

    #[test]
    fn nearest_offers_nothing_for_a_stranger() {
        assert_eq!(nearest("temperature", ["length_m", "section"]), None);
        assert_eq!(nearest("x", ["y_m", "z_m", "a"]), None);
        assert_eq!(nearest("", ["a", "root"]), None);
    }

    #[test]
    fn keys_have_homes() {
        let tree = crate::schema::tree();
        let homes = |key: &str| homes(Node::root(&tree), key);
        assert_eq!(homes("capture_deg"), ["[joint.<name>.latch]"]);
        assert_eq!(homes("latch"), ["[joint.<name>]"]);
        assert_eq!(homes("gravity_m_s2"), ["the top of the file, before the first table"]);
        assert_eq!(homes("mass_kg_m"), ["[section.<name>] with shape = \"explicit\"", "[modal_body.<name>]"]);
        assert!(homes("body").is_empty(), "gauges, masses, loads, surfaces and the top have it");
    }
}
