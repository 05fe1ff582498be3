//! Measurements: columns of a table over time, and single results.

use crate::cli::{Failure, read_bytes, shown};
use crate::report::inputs::{Channel, name_message};
use crate::report::table::Table;
use foldwing_fmi::interface::{Interface, Variable};
use foldwing_study::names::{self, NameError};
use std::path::Path;

/// Measured values with the scales of their residuals.
pub struct Data {
    /// Results of a run, in the syntax of `--of` of `foldwing gradient`.
    pub of: Vec<String>,
    /// Measured values.
    pub values: Vec<f64>,
    /// Standard deviations, or the largest magnitude in the column.
    pub scales: Vec<f64>,
    /// Whether the scales are standard deviations.
    pub has_sigma: bool,
    /// Columns, with the indices of their values; a single result is a column without times.
    pub columns: Vec<Column>,
    /// Stop time of the run in s: the last measured one, unless a result over the whole run is measured.
    pub stop_s: Option<f64>,
}

/// Values of one name.
pub struct Column {
    /// Name of the output or result.
    pub name: String,
    /// Times in s; empty for a single result.
    pub times_s: Vec<f64>,
    /// Index of the first value in [`Data::values`].
    pub first: usize,
}

/// Options of the command line other than the table.
pub struct Given<'a> {
    /// Columns to use; all if empty.
    pub columns: &'a [String],
    /// Single results, `RESULT=VALUE`.
    pub results: &'a [String],
    /// Standard deviations, `VALUE` or `NAME=VALUE`.
    pub sigma: &'a [String],
    /// Start of the run in s.
    pub start_s: f64,
    /// Requested stop in s.
    pub stop_s: Option<f64>,
    /// Stop time of the model file in s.
    pub experiment_stop_s: f64,
}

impl Data {
    /// Reads and checks the measurements.
    pub fn read(path: &Path, given: &Given, interface: &Interface) -> Result<Self, Failure> {
        let file = shown(path);
        let refused = |cause: String| Failure::Refused(format!("{file}: {cause}"));
        let table = Table::read(read_bytes(path)?.as_slice()).map_err(refused)?;
        if let Some(row) = (1..table.times_s.len()).find(|row| table.times_s[*row] <= table.times_s[row - 1]) {
            let time_s = table.times_s[row];
            return Err(refused(format!("column `time`: two rows are at {time_s} s; measured times must increase")));
        }
        let mut data = Self {
            of: vec![],
            values: vec![],
            scales: vec![],
            has_sigma: !given.sigma.is_empty(),
            columns: vec![],
            stop_s: given.stop_s,
        };
        let all: Vec<String> = table.columns.iter().map(|column| column.name().to_owned()).collect();
        let wanted: Vec<&str> = match given.columns.is_empty() {
            true => all.iter().map(String::as_str).collect(),
            false => given.columns.iter().flat_map(|list| names::split(list)).collect(),
        };
        for name in wanted {
            let column = table.column(name).ok_or_else(|| {
                let unknown = NameError::unknown(name, "column", all.iter().map(String::as_str));
                Failure::Usage(format!("--columns {name}: {file}: {unknown}; its columns are {}", all.join(", ")))
            })?;
            if !interface.real_outputs().any(|row| row.name == name) {
                let known = interface.real_outputs().map(|row| row.name.as_str());
                let unknown = name_message::<Variable>(&NameError::unknown(name, "real output", known));
                return Err(refused(format!("column `{name}`: {unknown}; --columns leaves out columns")));
            }
            if let Some(row) = column.values.iter().position(|value| value.is_infinite()) {
                let (value, time_s) = (column.values[row], table.times_s[row]);
                return Err(refused(format!(
                    "column `{name}`, {time_s} s: `{value}` is not finite; leave the cell empty if it was not measured"
                )));
            }
            let rows: Vec<usize> = (0..column.values.len()).filter(|row| !column.values[*row].is_nan()).collect();
            let times_s: Vec<f64> = rows.iter().map(|row| table.times_s[*row]).collect();
            let values: Vec<f64> = rows.iter().map(|row| column.values[*row]).collect();
            data.push(name, times_s, values)?;
        }
        for text in given.results {
            let (name, value) = number(("--value", text), "RESULT=NUMBER")?;
            data.push(name, vec![], vec![value])?;
        }
        data.set_sigma(given.sigma)?;
        data.set_stop(given, &file)?;
        Ok(data)
    }

    fn push(&mut self, name: &str, times_s: Vec<f64>, values: Vec<f64>) -> Result<(), Failure> {
        if self.columns.iter().any(|column| column.name == name) {
            return Err(Failure::Usage(format!("{name}: its measurements are given twice")));
        }
        let largest = values.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        self.scales.extend(values.iter().map(|_| if largest == 0.0 { 1.0 } else { largest }));
        match times_s.is_empty() {
            true => self.of.extend(values.iter().map(|_| name.to_owned())),
            false => self.of.extend(times_s.iter().map(|time_s| format!("{name}@{time_s:?}"))),
        }
        self.columns.push(Column { name: name.to_owned(), times_s, first: self.values.len() });
        self.values.extend(values);
        Ok(())
    }

    /// Indices of a column's values.
    pub fn places(&self, column: &Column) -> std::ops::Range<usize> {
        let later = self.columns.iter().map(|other| other.first).filter(|first| *first > column.first);
        column.first..later.min().unwrap_or(self.values.len())
    }

    /// Sets standard deviations, given for all names or for each; an error if a name has no measurements, or measurements
    /// have none.
    fn set_sigma(&mut self, given: &[String]) -> Result<(), Failure> {
        let places: Vec<_> = self.columns.iter().map(|column| (column.name.clone(), self.places(column))).collect();
        let mut missing = vec![self.has_sigma; places.len()];
        for text in given {
            let refused = |cause: &str| Failure::Usage(format!("--sigma {text}: {cause}"));
            let (name, value) = match text.contains('=') {
                true => number(("--sigma", text), "NAME=NUMBER").map(|(name, value)| (Some(name), value))?,
                false => (None, text.trim().parse().map_err(|_| refused("must be NUMBER or NAME=NUMBER"))?),
            };
            if !(value > 0.0 && value.is_finite()) {
                return Err(refused("a standard deviation is a positive number in SI units"));
            }
            if let Some(name) = name.filter(|name| !places.iter().any(|(own, _)| own == name)) {
                let known: Vec<&str> = places.iter().map(|(own, _)| own.as_str()).collect();
                return Err(refused(&format!("{name} is not measured; measured are {}", known.join(", "))));
            }
            for ((own, places), missing) in places.iter().zip(&mut missing) {
                if name.is_none_or(|name| name == own) {
                    places.clone().for_each(|place| self.scales[place] = value);
                    *missing = false;
                }
            }
        }
        match places.iter().zip(&missing).find(|(_, missing)| **missing) {
            Some(((name, _), _)) => Err(Failure::Usage(format!(
                "--sigma: {name} has none; give --sigma {name}=NUMBER, or one NUMBER for all"
            ))),
            None => Ok(()),
        }
    }

    /// Sets the stop time; an error if measured times are outside the run.
    fn set_stop(&mut self, given: &Given, file: &str) -> Result<(), Failure> {
        let times =
            || self.columns.iter().flat_map(|column| column.times_s.iter().map(move |time_s| (*time_s, column)));
        let last_s = times().map(|(time_s, _)| time_s).fold(f64::NEG_INFINITY, f64::max);
        let single = self.columns.iter().any(|column| column.times_s.is_empty());
        let stop_s = given.stop_s.unwrap_or(if single { given.experiment_stop_s } else { last_s });
        let start_s = given.start_s;
        if let Some((time_s, column)) = times().find(|(time_s, _)| !(start_s..=stop_s).contains(time_s)) {
            let name = &column.name;
            return Err(Failure::Refused(format!(
                "{file}: column `{name}`: the measured time {time_s} s is not within the run, {start_s} to {stop_s} s; --stop sets its end"
            )));
        }
        self.stop_s = Some(stop_s);
        Ok(())
    }
}

/// Parses `NAME=NUMBER` as the value of an option.
pub fn number<'a>((option, text): (&str, &'a str), form: &str) -> Result<(&'a str, f64), Failure> {
    let refused = |cause: &str| Failure::Usage(format!("{option} {text}: {cause}"));
    let (name, value) = text.rsplit_once('=').ok_or_else(|| refused(&format!("must be {form}")))?;
    let value: f64 = value.trim().parse().map_err(|_| refused(&format!("must be {form}")))?;
    if !value.is_finite() {
        return Err(refused("the number is not finite"));
    }
    Ok((name.trim(), value))
}
