//! Inputs over time from a CSV file: the first column is `time`, the others have names of inputs.

use crate::report::lines::Lines;
use csv::StringRecord;
use foldwing_engine::plant::{GradientError, InputColumn, InputRows};
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};
use foldwing_study::names::{NameError, shortened};
use std::io::{self, Read};

/// Error in an input file, with its location.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InputsError {
    /// The file is not valid CSV: rows of different lengths, bytes that are not UTF-8, a read error.
    #[error("{file}: {cause}")]
    Malformed {
        /// File name given by the caller.
        file: String,
        /// Error of the CSV reader, with its line.
        cause: String,
    },
    /// The file cannot be read.
    #[error("{file}: cannot be read: {cause}")]
    Unreadable {
        /// File name given by the caller.
        file: String,
        /// Error of the operating system.
        cause: String,
    },
    /// The header is invalid.
    #[error("{file}:1: column {column}: {cause}")]
    Header {
        /// File name given by the caller.
        file: String,
        /// Column, counted from 1.
        column: usize,
        /// Cause and allowed values.
        cause: String,
    },
    /// The value of a cell is invalid.
    #[error("{file}:{line}: column {column} ({name}): `{text}` {cause}")]
    Cell {
        /// File name given by the caller.
        file: String,
        /// Line, counted from 1.
        line: u64,
        /// Column, counted from 1.
        column: usize,
        /// Header of the column.
        name: String,
        /// The cell's text.
        text: String,
        /// Cause and allowed values.
        cause: String,
    },
    /// The file has only a header.
    #[error("{file}: no rows below the header; at least one is needed")]
    Empty {
        /// File name given by the caller.
        file: String,
    },
}

/// Properties of a variable needed for a table of inputs.
pub trait Channel {
    /// Command that lists the names, for messages.
    const LISTED_BY: &'static str;
    /// Returns its name.
    fn name(&self) -> &str;
    /// Returns whether it is an input.
    fn is_input(&self) -> bool;
    /// Returns an arbitrary value of the variable's type; `None` for text, which a table cannot contain.
    fn kind(&self) -> Option<Value>;
    /// Returns the smallest and largest allowed values.
    fn range(&self) -> Option<(f64, f64)>;
}

impl Channel for Variable {
    const LISTED_BY: &'static str = "`foldwing check`";

    fn name(&self) -> &str {
        &self.name
    }

    fn is_input(&self) -> bool {
        self.causality == Causality::Input
    }

    fn kind(&self) -> Option<Value> {
        Some(self.value)
    }

    fn range(&self) -> Option<(f64, f64)> {
        self.range
    }
}

/// Column of one input over time.
#[derive(Debug, Clone, PartialEq)]
struct Column {
    /// Index in the list of variables.
    position: usize,
    kind: Value,
    values: Vec<f64>,
}

/// Inputs over time.
#[derive(Debug, Clone, PartialEq)]
pub struct InputTable {
    times_s: Vec<f64>,
    columns: Vec<Column>,
}

impl InputTable {
    /// Reads a table; `file` is its name in errors.
    pub fn read(source: impl Read, file: &str, variables: &[impl Channel]) -> Result<Self, InputsError> {
        let unreadable = |error: io::Error| InputsError::Unreadable { file: file.to_owned(), cause: error.to_string() };
        let lines = Lines::of(source).map_err(unreadable)?;
        let mut reader = lines.reader();
        let malformed =
            |error: csv::Error| InputsError::Malformed { file: file.to_owned(), cause: lines.describe(&error) };
        let header = reader.headers().map_err(malformed)?.clone();
        let mut table = Self { times_s: vec![], columns: columns(&header, file, variables)? };
        for record in reader.into_records() {
            table.push(&record.map_err(malformed)?, &header, (file, &lines), variables)?;
        }
        if table.times_s.is_empty() {
            return Err(InputsError::Empty { file: file.to_owned() });
        }
        Ok(table)
    }

    /// Creates a table from columns given by a program: a name and its values at `times_s`, Booleans as 0 and 1.
    ///
    /// # Errors
    /// Names that are not inputs or occur twice, descending times, columns of different lengths, values that are not finite, out of range
    /// or not of the input's type. Errors state the name and the row, numbered from 0.
    pub fn of_columns(
        times_s: Vec<f64>,
        given: Vec<(String, Vec<f64>)>,
        variables: &[impl Channel],
    ) -> Result<Self, String> {
        if times_s.is_empty() {
            return Err("inputs: no rows; at least one is needed".to_owned());
        }
        if let Some(row) = times_s.iter().position(|time_s| !time_s.is_finite()) {
            return Err(format!("inputs: time in row {row} is not a finite number"));
        }
        for row in 1..times_s.len() {
            check_order(&times_s[..row], times_s[row])
                .map_err(|cause| format!("inputs: time {} s in row {row} {cause}", times_s[row]))?;
        }
        let mut columns: Vec<Column> = Vec::with_capacity(given.len());
        for (name, values) in given {
            let bad = |cause: String| format!("inputs: {name}: {cause}");
            let (position, kind) = input(&name, variables).map_err(|cause| format!("inputs: {cause}"))?;
            if columns.iter().any(|column| column.position == position) {
                return Err(bad("appears twice".to_owned()));
            }
            if values.len() != times_s.len() {
                return Err(bad(format!("{} values for {} times", values.len(), times_s.len())));
            }
            let range = variables[position].range();
            for (row, value) in values.iter().enumerate() {
                let cause = match kind {
                    _ if !value.is_finite() => "is not a finite number".to_owned(),
                    Value::Boolean(_) if ![0.0, 1.0].contains(value) => {
                        "is not a Boolean; allowed are 0 and 1".to_owned()
                    }
                    Value::Integer(_) if value.fract() != 0.0 || value.abs() > f64::from(i32::MAX) => {
                        "is not a whole number".to_owned()
                    }
                    Value::Real(_) | Value::Integer(_) | Value::Boolean(_) => match range {
                        Some((smallest, largest)) if !(smallest..=largest).contains(value) => {
                            format!("is out of range; allowed is {smallest:?} to {largest:?}")
                        }
                        _ => continue,
                    },
                };
                return Err(bad(format!("`{value:?}` in row {row} {cause}")));
            }
            columns.push(Column { position, kind, values });
        }
        Ok(Self { times_s, columns })
    }

    fn push(
        &mut self,
        record: &StringRecord,
        header: &StringRecord,
        (file, lines): (&str, &Lines),
        variables: &[impl Channel],
    ) -> Result<(), InputsError> {
        let bad = |column: usize, cause: String| InputsError::Cell {
            file: file.to_owned(),
            line: lines.number(record.position()),
            column: column + 1,
            name: shortened(&header[column]),
            text: shortened(&record[column]),
            cause,
        };
        let time_s = real(&record[0]).map_err(|cause| bad(0, cause))?;
        check_order(&self.times_s, time_s).map_err(|cause| bad(0, cause))?;
        self.times_s.push(time_s);
        for (i, column) in self.columns.iter_mut().enumerate() {
            let range = variables[column.position].range();
            column.values.push(value(&record[i + 1], column.kind, range).map_err(|cause| bad(i + 1, cause))?);
        }
        Ok(())
    }

    /// Values of all columns at a time, with their indices in the list of variables. Reals are interpolated linearly between rows, others
    /// are held from their row on; all are constant before the first row and after the last. Two rows at the same time are a jump: the
    /// interpolation before it ends at the first, and the second is valid from there on.
    pub fn at(&self, time_s: f64) -> impl Iterator<Item = (usize, Value)> + '_ {
        let next = self.times_s.partition_point(|t| *t <= time_s);
        self.columns.iter().map(move |column| {
            let held = column.values[next.saturating_sub(1)];
            let value = match column.kind {
                Value::Real(_) => Value::Real(self.interpolate(column, next, time_s)),
                Value::Integer(_) => Value::Integer(held as i32),
                Value::Boolean(_) => Value::Boolean(held != 0.0),
            };
            (column.position, value)
        })
    }

    /// Times of the rows in s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Names and values of the inputs of a model; reals are interpolated linearly.
    pub fn columns<'a>(&'a self, interface: &'a Interface) -> impl Iterator<Item = (&'a Variable, &'a [f64])> {
        self.columns.iter().map(|column| (&interface.variables()[column.position], column.values.as_slice()))
    }

    /// Returns the rows in the form of the engine.
    ///
    /// # Errors
    /// None for a table that was read with the variables of `interface`.
    pub fn rows(&self, interface: &Interface) -> Result<InputRows, GradientError> {
        let column = |(variable, values): (&Variable, &[f64])| {
            let index = interface.input_index(variable.value_reference)?;
            Some(InputColumn { index, held: !matches!(variable.value, Value::Real(_)), values: values.to_vec() })
        };
        InputRows::new(self.times_s.clone(), self.columns(interface).filter_map(column).collect())
    }

    fn interpolate(&self, column: &Column, next: usize, time_s: f64) -> f64 {
        if next == 0 {
            return column.values[0];
        }
        let before = column.values[next - 1];
        let Some(after) = column.values.get(next) else { return before };
        let share = (time_s - self.times_s[next - 1]) / (self.times_s[next] - self.times_s[next - 1]);
        let change = after - before;
        // the difference of two huge numbers of opposite sign may overflow
        if change.is_finite() { before + share * change } else { (1.0 - share) * before + share * after }
    }
}

/// Checks that a time does not precede the previous ones; two rows may have the same time, at a jump.
fn check_order(times_s: &[f64], next_s: f64) -> Result<(), String> {
    match *times_s {
        [.., last_s] if next_s < last_s => Err(format!(
            "is before the previous row ({last_s} s); times must ascend, and two rows at one time make a jump"
        )),
        [.., first_s, last_s] if next_s == last_s && first_s == last_s => {
            Err("is the time of three rows; a jump has two rows, with the values before and after it".to_owned())
        }
        [..] => Ok(()),
    }
}

/// Columns of a header, without values.
fn columns(header: &StringRecord, file: &str, variables: &[impl Channel]) -> Result<Vec<Column>, InputsError> {
    let bad = |column: usize, cause: String| InputsError::Header { file: file.to_owned(), column: column + 1, cause };
    if header.get(0) != Some("time") {
        let found = header.get(0).unwrap_or_default();
        if header.len() == 1 && found.contains(';') {
            return Err(bad(0, "columns are separated by `;`; write `,`, and a decimal point in numbers".to_owned()));
        }
        return Err(bad(0, format!("`{}`: the first column must be named `time` (s)", shortened(found))));
    }
    let mut columns: Vec<Column> = vec![];
    for (i, name) in header.iter().enumerate().skip(1) {
        let (position, kind) = input(name, variables).map_err(|cause| bad(i, cause))?;
        if columns.iter().any(|column| column.position == position) {
            return Err(bad(i, format!("`{name}` appears twice")));
        }
        columns.push(Column { position, kind, values: vec![] });
    }
    Ok(columns)
}

/// Index of the input with a name, and any value of its type.
fn input<C: Channel>(name: &str, variables: &[C]) -> Result<(usize, Value), String> {
    let found = variables.iter().enumerate().find(|(_, variable)| variable.name() == name);
    match found {
        Some((position, variable)) if variable.is_input() => match variable.kind() {
            Some(kind) => Ok((position, kind)),
            None => Err(format!("`{name}` is a text, which a table cannot contain")),
        },
        Some(_) => Err(format!("`{name}` is not an input")),
        None => Err(unknown_name(name, "input", variables.iter().filter(|variable| variable.is_input()))),
    }
}

/// Message about an unknown name, with the most similar known name, if any.
pub fn unknown_name<'a, C: Channel + 'a>(name: &str, what: &'static str, known: impl Iterator<Item = &'a C>) -> String {
    name_message::<C>(&NameError::unknown(name, what, known.map(C::name)))
}

/// Message about a name; if no known name is similar, it states the command that lists the names.
pub fn name_message<C: Channel>(error: &NameError) -> String {
    match error {
        NameError::Unknown { nearest: None, .. } => format!("{error}; {} lists the names", C::LISTED_BY),
        NameError::Unknown { .. } | NameError::NoMatch { .. } => error.to_string(),
    }
}

/// Value of a cell, checked against the type and range of its input.
fn value(text: &str, kind: Value, range: Option<(f64, f64)>) -> Result<f64, String> {
    let value = match kind {
        Value::Real(_) => real(text)?,
        Value::Integer(_) => text.parse::<i32>().map(f64::from).map_err(|_| "is not a whole number".to_owned())?,
        Value::Boolean(_) => match text {
            "1" | "true" => 1.0,
            "0" | "false" => 0.0,
            _ => return Err("is not a Boolean; allowed are 0, 1, false and true".to_owned()),
        },
    };
    match range {
        Some((smallest, largest)) if !(smallest..=largest).contains(&value) => {
            Err(format!("is out of range; allowed is {smallest:?} to {largest:?}"))
        }
        _ => Ok(value),
    }
}

fn real(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("is not a finite number".to_owned()),
    }
}

#[cfg(test)]
#[path = "inputs_tests.rs"]
mod tests;
