//! Variants of a sweep: a grid of `--vary`, or the rows of `--samples`.

use crate::cli::Failure;
use crate::cli::choice::unknown;
use crate::report::lines::Lines;
use foldwing_fmi::interface::Interface;
use std::collections::HashSet;
use std::fs::File;
use std::path::Path;

/// Maximum number of variants of a sweep; a larger grid is probably unintended.
const MAXIMUM_VARIANTS: usize = 1_000_000;
/// Prefix of keys of the model file; variable names contain no colon.
const FILE_PREFIX: &str = "file:";

/// Keys, and their values as text for every variant.
pub(in crate::cli) struct Plan {
    /// File of the samples, or for a grid the option that defines it.
    file: Result<String, &'static str>,
    keys: Vec<String>,
    values: Values,
}

enum Values {
    /// Values of each key; the variants are all combinations.
    Grid(Vec<Vec<String>>),
    /// Values of all keys for each variant.
    Rows(Vec<Vec<String>>),
}

impl Plan {
    /// Grid of all combinations of `KEY=FROM:TO:COUNT` and `KEY=A,B,…`, given by an option.
    pub fn grid(option: &'static str, varied: &[String], interface: &Interface) -> Result<Self, Failure> {
        let (mut keys, mut axes, mut count) = (Vec::new(), Vec::new(), 1usize);
        for text in varied {
            let refused = |cause: String| Failure::Usage(format!("{option} {text}: {cause}"));
            let (key, values) = text
                .split_once('=')
                .filter(|(key, _)| !key.is_empty())
                .ok_or_else(|| refused("must be KEY=FROM:TO:COUNT or KEY=A,B,…".to_owned()))?;
            let values = axis(values).map_err(refused)?;
            count = count.saturating_mul(values.len());
            if count > MAXIMUM_VARIANTS {
                return Err(refused(format!("makes the grid larger than the {MAXIMUM_VARIANTS} variants allowed")));
            }
            keys.push(key.to_owned());
            axes.push(values);
        }
        check_keys(&keys, option, interface)?;
        Ok(Self { file: Err(option), keys, values: Values::Grid(axes) })
    }

    /// Reads the rows of a CSV file whose header has the keys.
    pub fn samples(path: &Path, interface: &Interface) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let file = File::open(path).map_err(|error| Failure::Files(format!("{name}: cannot be read: {error}")))?;
        let lines = Lines::of(file).map_err(|error| Failure::Files(format!("{name}: cannot be read: {error}")))?;
        let mut reader = lines.reader();
        let malformed = |error: csv::Error| Failure::Refused(format!("{name}: {}", lines.describe(&error)));
        let keys: Vec<String> = reader.headers().map_err(malformed)?.iter().map(str::to_owned).collect();
        check_keys(&keys, &format!("{name}:1"), interface)?;
        let mut rows = Vec::new();
        for record in reader.into_records() {
            let record = record.map_err(malformed)?;
            let line = || lines.number(record.position());
            if let Some(column) = record.iter().position(|cell| cell.is_empty() || cell.contains(char::is_control)) {
                let key = &keys[column];
                return Err(Failure::Refused(format!(
                    "{name}:{}: column {} ({key}): must be a value on one line, not {:?}",
                    line(),
                    column + 1,
                    &record[column]
                )));
            }
            if rows.len() == MAXIMUM_VARIANTS {
                return Err(Failure::Refused(format!(
                    "{name}:{}: more than the {MAXIMUM_VARIANTS} variants allowed",
                    line()
                )));
            }
            rows.push(record.iter().map(str::to_owned).collect());
        }
        if rows.is_empty() {
            return Err(Failure::Refused(format!("{name}: no rows below the header; at least one is needed")));
        }
        Ok(Self { file: Ok(name), keys, values: Values::Rows(rows) })
    }

    /// Rows of values given by a program, one per variant; messages start with `place`.
    pub fn rows(
        place: &str,
        keys: Vec<String>,
        rows: Vec<Vec<String>>,
        interface: &Interface,
    ) -> Result<Self, Failure> {
        check_keys(&keys, place, interface)?;
        if rows.is_empty() || rows.len() > MAXIMUM_VARIANTS {
            let count = rows.len();
            return Err(Failure::Usage(format!("{place}: {count} variants; allowed are 1 to {MAXIMUM_VARIANTS}")));
        }
        if let Some(index) = rows.iter().position(|row| row.len() != keys.len()) {
            let (given, wanted) = (rows[index].len(), keys.len());
            return Err(Failure::Usage(format!("{place}: variant {index}: {given} values for {wanted} keys")));
        }
        Ok(Self { file: Ok(place.to_owned()), keys, values: Values::Rows(rows) })
    }

    /// Keys as given by the user.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// Source of the values of a variant, for messages.
    pub fn place(&self, index: usize) -> String {
        self.file.as_ref().map_or_else(|option| (*option).to_owned(), |file| format!("{file}: variant {index}:"))
    }

    /// Number of variants.
    pub fn count(&self) -> usize {
        match &self.values {
            Values::Grid(axes) => axes.iter().map(Vec::len).product(),
            Values::Rows(rows) => rows.len(),
        }
    }

    /// Values of a variant, in the order of the keys; in a grid the last key varies fastest.
    pub fn variant(&self, index: usize) -> Vec<&str> {
        match &self.values {
            Values::Rows(rows) => rows[index].iter().map(String::as_str).collect(),
            Values::Grid(axes) => {
                let mut left = index;
                let mut values: Vec<&str> = axes
                    .iter()
                    .rev()
                    .map(|axis| {
                        let value = axis[left % axis.len()].as_str();
                        left /= axis.len();
                        value
                    })
                    .collect();
                values.reverse();
                values
            }
        }
    }

    /// All values in one text, by which sweeps are distinguished.
    pub fn values_text(&self) -> String {
        let (kind, lists) = match &self.values {
            Values::Grid(axes) => ("grid", axes),
            Values::Rows(rows) => ("rows", rows),
        };
        lists.iter().fold(kind.to_owned(), |text, list| text + "\n" + &list.join("\u{1f}"))
    }
}

/// Path of a key of the model file; `None` for the name of a variable.
pub(in crate::cli) fn file_path(key: &str) -> Option<Vec<&str>> {
    key.strip_prefix(FILE_PREFIX).map(|path| path.split('.').collect())
}

/// Checks that every key is unique, and is the name of a variable or starts with [`FILE_PREFIX`].
fn check_keys(keys: &[String], place: &str, interface: &Interface) -> Result<(), Failure> {
    let mut seen = HashSet::new();
    for key in keys {
        if !seen.insert(key) {
            return Err(Failure::Usage(format!("{place}: the key {key} is given twice")));
        }
        if let Some(path) = file_path(key) {
            if path.iter().any(|part| part.is_empty()) {
                return Err(Failure::Usage(format!(
                    "{place}: {key} is not a key of the model file; write keys such as file:body.inner.length_m"
                )));
            }
        } else if interface.find(key).is_none() {
            let Failure::Usage(message) = unknown(key, "input or parameter", interface.variables()) else { continue };
            return Err(Failure::Usage(format!("{place}: {message}; keys of the model file begin with {FILE_PREFIX}")));
        }
    }
    Ok(())
}

/// Parses the values of one key: `FROM:TO:COUNT` or `A,B,…`.
pub(in crate::cli) fn axis(text: &str) -> Result<Vec<String>, String> {
    if let [from, to, count] = text.split(':').collect::<Vec<_>>()[..] {
        return range(from, to, count);
    }
    if text.contains(':') {
        return Err(format!("`{text}` is not a range; ranges are FROM:TO:COUNT, such as 0:1:11"));
    }
    let values: Vec<String> = text.split(',').map(|value| value.trim().to_owned()).collect();
    if values.iter().any(|value| value.is_empty() || value.contains(char::is_control)) {
        return Err("a value is missing; values are separated by single commas".to_owned());
    }
    Ok(values)
}

/// `count` equally spaced values from `from` to `to`, both included; whole numbers stay whole.
fn range(from: &str, to: &str, count: &str) -> Result<Vec<String>, String> {
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a finite number")),
    };
    let (first, last) = (number(from)?, number(to)?);
    let count: usize = match count.trim().parse() {
        Ok(count) if (2..=MAXIMUM_VARIANTS).contains(&count) => count,
        _ => return Err(format!("`{count}` is not a number of values; allowed is 2 to {MAXIMUM_VARIANTS}")),
    };
    let whole = [from, to].iter().all(|text| text.trim().parse::<i32>().is_ok());
    let value = |i: usize| {
        let share = i as f64 / (count - 1) as f64;
        // the ends are exact, without rounding
        if i == 0 {
            first
        } else if i + 1 == count {
            last
        } else {
            first + (last - first) * share
        }
    };
    let values: Vec<f64> = (0..count).map(value).collect();
    let whole = whole && values.iter().all(|value| value.fract() == 0.0);
    Ok(values.iter().map(|value| if whole { format!("{value:.0}") } else { format!("{value:?}") }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranges include both ends exactly, and whole numbers stay whole, as required by integer keys.
    #[test]
    fn ranges_include_their_ends() {
        assert_eq!(axis("0.1:0.7:4").unwrap().first().unwrap(), "0.1");
        assert_eq!(axis("0.1:0.7:4").unwrap().last().unwrap(), "0.7");
        assert_eq!(axis("2:8:4").unwrap(), ["2", "4", "6", "8"]);
        assert_eq!(axis("2:3:3").unwrap(), ["2.0", "2.5", "3.0"]);
        assert_eq!(axis("1, true ,x").unwrap(), ["1", "true", "x"]);
        for (text, message) in [("1:2", "FROM:TO:COUNT"), ("1:2:1", "`1`"), ("1:x:3", "`x`"), ("1,,2", "missing")] {
            assert!(axis(text).unwrap_err().contains(message), "{text}");
        }
    }

    /// In a grid the last key varies fastest, and every combination occurs once.
    #[test]
    fn grids_have_every_combination_once() {
        let axes = vec![vec!["a".to_owned(), "b".to_owned()], vec!["1".to_owned(), "2".to_owned(), "3".to_owned()]];
        let plan = Plan { file: Err("--vary"), keys: vec!["x".to_owned(), "y".to_owned()], values: Values::Grid(axes) };
        let all: Vec<String> = (0..plan.count()).map(|index| plan.variant(index).concat()).collect();
        assert_eq!(all, ["a1", "a2", "a3", "b1", "b2", "b3"]);
    }
}
