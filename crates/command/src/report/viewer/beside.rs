//! Data to compare with a run: tables (CSV) of measurements or of another run, and pages of other runs.

use crate::report::inputs::Channel;
use crate::report::table;
use foldwing_recording::packed::{FORMAT, PackedRun, encoded, stays_in_script};
use std::io::Read;

/// Data to compare with a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Companion {
    /// Another run.
    Run {
        /// Label in the page.
        label: String,
        /// The run.
        run: PackedRun,
    },
    /// Values over time.
    Table {
        /// Label in the page.
        label: String,
        /// Its columns, the first of which is the time in s.
        table: Table,
    },
}

/// Values over time; empty cells are NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Names of the columns without the time.
    pub names: Vec<String>,
    /// Rows: time in s, then the values.
    pub rows: Vec<f32>,
    /// Rows of the file.
    pub count: usize,
}

/// Maximum number of values of a table in a page; longer ones are thinned at equal intervals.
const MAXIMUM_NUMBERS: usize = 300_000;

impl Table {
    /// Reads CSV with an ascending column `time` in s; lines that start with `#` are comments.
    ///
    /// # Errors
    /// Cause with line and column.
    pub fn read(source: impl Read) -> Result<Self, String> {
        let table = table::Table::read(source)?;
        let names: Vec<String> = table.columns.iter().map(|column| column.name().to_owned()).collect();
        let mut rows = Vec::with_capacity(table.times_s.len() * (names.len() + 1));
        for (row, time_s) in table.times_s.iter().enumerate() {
            rows.push(*time_s as f32);
            rows.extend(table.columns.iter().map(|column| column.values[row] as f32));
        }
        let (width, count) = (names.len() + 1, rows.len() / (names.len() + 1));
        let keep = count.min((MAXIMUM_NUMBERS / width).max(2));
        if keep < count {
            let row = |i: usize| (count - 1) * i / (keep - 1);
            rows = (0..keep).flat_map(|i| rows[width * row(i)..width * (row(i) + 1)].to_vec()).collect();
        }
        Ok(Self { names, rows, count })
    }

    /// Number of rows kept.
    pub fn kept(&self) -> usize {
        self.rows.len() / (self.names.len() + 1)
    }

    /// The rows as text.
    pub(super) fn numbers(&self) -> String {
        encoded(&self.rows)
    }
}

/// Returns the run in the text of a page written by [`super::page`]: the first, if it has several.
///
/// # Errors
/// The text is not such a page.
pub fn run_of_page(text: &str) -> Result<PackedRun, String> {
    let between = |begin: &str| -> Option<&str> {
        let rest = &text[text.find(begin)? + begin.len()..];
        Some(&rest[..rest.find("</script>")?])
    };
    let generated = text.contains("<meta name=\"generator\" content=\"foldwing\">");
    let found = between(super::RUN_BEGINS).zip(between(super::NUMBERS_BEGIN));
    let Some((description, numbers)) = found.filter(|_| generated) else {
        return Err("is not a page written by foldwing simulate --view of this version; write it again".to_owned());
    };
    if text.contains(super::MODES_BEGIN) {
        return Err("is a page of mode shapes, which contains no simulation; name a page of foldwing simulate --view"
            .to_owned());
    }
    let read = serde_json::from_str::<serde_json::Value>(description).ok();
    if read.and_then(|read| read["format"].as_u64()) != Some(FORMAT) {
        return Err("was written by another version of foldwing; write the page again".to_owned());
    }
    // text for another page must not end its element or match a placeholder of the page
    let is_number = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '/' | '=');
    if !stays_in_script(description) || !numbers.chars().all(is_number) {
        return Err("is not a page written by foldwing simulate --view of this version; write it again".to_owned());
    }
    Ok(PackedRun { description: description.to_owned(), numbers: numbers.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_or_refused_with_line_and_column() {
        let read = |text: &str| Table::read(text.as_bytes());
        let table = read("# measured\nforce, time ,a\n1,0,2\n,0.5,4\n").unwrap();
        assert_eq!(
            (table.names.as_slice(), table.count, table.kept()),
            (&["force".to_owned(), "a".to_owned()][..], 2, 2)
        );
        assert_eq!((table.rows[..4].to_vec(), table.rows[4].is_nan()), (vec![0.0, 1.0, 2.0, 0.5], true));
        for (text, needed) in [
            ("t,a\n0,1\n", "there is no column `time` (s); the columns are `t`, `a`"),
            ("time\n0\n", "only the column `time`"),
            ("time,a,a\n0,1,2\n", "two columns `a`"),
            ("time,a\n0,1\n0.1,x\n", "line 3, column `a`: `x` is not a number"),
            ("time,a\n0,\"1,5\"\n", "decimals are written with a point"),
            ("time,a\n1,1\n0,1\n", "line 3, column `time`: 0 after 1; times must ascend"),
            ("time,a\n0,1,2\n", "line 2: 3 columns where the header has 2"),
            ("time,a\n", "no rows"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(needed), "{text:?}: {message}");
        }
    }

    /// A long table is thinned to the bound and keeps both ends.
    #[test]
    fn long_tables_are_thinned() {
        let text: String = (0..400_000).fold("time,a\n".to_owned(), |text, i| text + &format!("{i},1\n"));
        let table = Table::read(text.as_bytes()).unwrap();
        assert_eq!((table.count, table.kept()), (400_000, MAXIMUM_NUMBERS / 2));
        assert_eq!((table.rows[0], table.rows[table.rows.len() - 2]), (0.0, 399_999.0));
    }
}
