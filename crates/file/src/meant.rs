//! Suggestions for misspelt keys and names.

/// Minimum similarity at which a word with a larger edit distance is suggested, such as `aerodynamics` for `aero`, or `body` for
/// `bodies`.
const LIKENESS: f64 = 0.82;
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
}
