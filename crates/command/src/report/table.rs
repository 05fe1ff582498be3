//! Tables over time for comparisons: CSV with a column `time`.

use crate::report::inputs::Channel;
use crate::report::lines::Lines;
use foldwing_fmi::interface::Value;
use std::io::Read;

/// Values over time in full precision; empty cells are NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Times in s, ascending.
    pub times_s: Vec<f64>,
    /// Other columns, in the order of the file.
    pub columns: Vec<Column>,
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    name: String,
    /// One value for each time.
    pub values: Vec<f64>,
}

impl Channel for Column {
    const LISTED_BY: &'static str = "the first line of the tables";

    fn name(&self) -> &str {
        &self.name
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

impl Table {
    /// Reads CSV with an ascending column `time` in s; lines that start with `#` are comments; Booleans are 0 and 1.
    ///
    /// # Errors
    /// The cause, with line and column.
    pub fn read(source: impl Read) -> Result<Self, String> {
        let lines = Lines::of(source).map_err(|error| error.to_string())?;
        let mut reader = lines.reader();
        let header = reader.headers().map_err(|error| lines.describe(&error))?.clone();
        let header: Vec<&str> = header.iter().map(|name| name.trim_start_matches('\u{feff}')).collect();
        let Some(time) = header.iter().position(|name| *name == "time") else {
            let semicolon = header.len() == 1 && header[0].contains(';');
            let cure = if semicolon { "; columns are separated by commas here, not by `;`" } else { "" };
            return Err(format!(
                "line 1: there is no column `time` (s); the columns are {}{cure}",
                header.iter().take(6).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
            ));
        };
        let names: Vec<&str> = header.iter().enumerate().filter(|(i, _)| *i != time).map(|(_, name)| *name).collect();
        if names.is_empty() {
            return Err("line 1: there is only the column `time`; a column per variable is needed".to_owned());
        }
        if let Some(twice) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
            return Err(format!("line 1: there are two columns `{}`", twice.1));
        }
        let column = |name: &&str| Column { name: (*name).to_owned(), values: Vec::new() };
        let mut table = Self { times_s: Vec::new(), columns: names.iter().map(column).collect() };
        for record in reader.records() {
            let record = record.map_err(|error| lines.describe(&error))?;
            let line = || lines.number(record.position());
            let number = |column: usize| -> Result<f64, String> {
                let text = &record[column];
                match text {
                    "" if column != time => return Ok(f64::NAN),
                    "true" => return Ok(1.0),
                    "false" => return Ok(0.0),
                    _ => {}
                }
                text.parse().map_err(|_| {
                    let comma = if text.contains(',') { "; decimals are written with a point" } else { "" };
                    format!("line {}, column `{}`: `{text}` is not a number{comma}", line(), header[column])
                })
            };
            let time_s = number(time)?;
            let last = table.times_s.last().copied().unwrap_or(f64::NEG_INFINITY);
            if !time_s.is_finite() || time_s < last {
                return Err(format!("line {}, column `time`: {time_s} after {last}; times must ascend", line()));
            }
            table.times_s.push(time_s);
            let others = (0..header.len()).filter(|column| *column != time);
            for (place, column) in others.zip(&mut table.columns) {
                column.values.push(number(place)?);
            }
        }
        if table.times_s.is_empty() {
            return Err("there are no rows below the header".to_owned());
        }
        Ok(table)
    }

    /// Returns the column with a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Value of a column at a time, interpolated linearly between rows; of several rows at the same time, the first is used. `None`
    /// outside the table and next to empty cells.
    pub fn at(&self, column: &Column, time_s: f64) -> Option<f64> {
        let next = self.times_s.partition_point(|row_s| *row_s < time_s);
        let value = |row: usize| column.values.get(row).copied().filter(|value| !value.is_nan());
        if *self.times_s.get(next)? == time_s {
            return value(next);
        }
        let before = next.checked_sub(1)?;
        let share = (time_s - self.times_s[before]) / (self.times_s[next] - self.times_s[before]);
        let (from, to) = (value(before)?, value(next)?);
        Some(from + share * (to - from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error for a cell that is not a number, or for a descending time, states its column and line, where comments and empty lines
    /// are counted.
    #[test]
    fn every_cell_is_refused_at_its_line_and_column() {
        let lines = ["# a run", "time,x,y", "0,1,2", "# a comment", "1,,true", "", "2,5,6", "3,7,8"];
        let columns = ["time", "x", "y"];
        let read = |lines: &[String]| Table::read(lines.join("\n").as_bytes());
        let plain = lines.map(str::to_owned);
        let table = read(&plain).unwrap_or_else(|cause| panic!("{cause}"));
        assert_eq!((table.times_s.len(), table.columns[1].values[1]), (4, 1.0));
        for at in [2, 4, 6, 7] {
            for (column, name) in columns.iter().enumerate() {
                let mut cells: Vec<&str> = lines[at].split(',').collect();
                cells[column] = "7.x";
                let mut lines = plain.clone();
                lines[at] = cells.join(",");
                let due = format!("line {}, column `{name}`: `7.x` is not a number", at + 1);
                assert_eq!(read(&lines), Err(due));
            }
            if at > 2 {
                let mut lines = plain.clone();
                lines[at] = lines[at].replacen(|first: char| first.is_ascii_digit(), "-1", 1);
                let cause = read(&lines).expect_err("descending");
                assert!(cause.starts_with(&format!("line {}, column `time`: -1 after", at + 1)), "{cause}");
            }
        }
    }
}
