//! `foldwing compare`: comparison of two tables over time, column by column.

use crate::cli::choice::chosen;
use crate::cli::{Failure, print, read_bytes, shown};
use crate::report::Channel;
use crate::report::table::{Column, Table};
use foldwing_study::names::is_pattern;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::COMPARE)]
pub struct Arguments {
    /// Reference table (CSV with a column `time`); the tables are compared at the times of its rows
    reference: PathBuf,
    /// Table to compare, interpolated linearly between its rows
    other: PathBuf,
    /// Allowed difference, relative to the largest magnitude in the reference column
    #[arg(long, value_name = "X", default_value = "1e-6", allow_negative_numbers = true)]
    rtol: f64,
    /// Additional allowed difference, in the unit of the column
    #[arg(long, value_name = "X", default_value = "1e-12", allow_negative_numbers = true)]
    atol: f64,
    /// Allowed difference of columns in their unit, instead of --rtol and --atol: a name or pattern, `=` and a number; may be repeated, the
    /// last match applies
    #[arg(long, value_name = "NAME=X")]
    tolerance: Vec<String>,
    /// Columns to compare: names or patterns, separated by commas; may be repeated [default: all columns that both tables have]
    #[arg(long = "variables", value_name = "NAME")]
    outputs: Vec<String>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    /// Print nothing; the exit code is the result
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// The comparison of one column.
#[derive(Serialize)]
struct Verdict {
    name: String,
    /// Largest difference, in the column's unit.
    largest: f64,
    /// Time of the largest difference, in s.
    at_s: f64,
    /// Root mean square of the difference.
    rms: f64,
    allowed: f64,
    agrees: bool,
}

/// Compares two tables; differences beyond the tolerance fail with an exit code of their own.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let paths = [arguments.reference.as_path(), arguments.other.as_path()];
    crate::cli::simulate::one_standard_input(paths.map(Some))?;
    for (option, value) in [("--rtol", arguments.rtol), ("--atol", arguments.atol)] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(Failure::Usage(format!("{option} {value}: must be a finite number; allowed: 0 or more")));
        }
    }
    let tolerances = arguments.tolerance.iter().map(|text| tolerance(text)).collect::<Result<Vec<_>, _>>()?;
    let [reference, other] = [read(paths[0])?, read(paths[1])?];
    let both: Vec<&Column> = reference.columns.iter().filter(|column| other.column(column.name()).is_some()).collect();
    let missing = |table: &Table, than: &Table| -> Vec<String> {
        let lacks = |column: &&Column| than.column(column.name()).is_none();
        table.columns.iter().filter(lacks).map(|column| column.name().to_owned()).collect()
    };
    let columns = match arguments.outputs.is_empty() {
        true => both,
        false => chosen(&arguments.outputs, &both, "column of both tables")?,
    };
    if columns.is_empty() {
        let names = |table: &Table| table.columns.iter().take(6).map(Column::name).collect::<Vec<_>>().join(", ");
        return Err(Failure::Refused(format!(
            "{} and {} have no column in common; the first has {}, the second {}",
            shown(paths[0]),
            shown(paths[1]),
            names(&reference),
            names(&other)
        )));
    }
    for (text, pattern, _) in &tolerances {
        chosen(std::slice::from_ref(pattern), &columns, "column of both tables").map_err(|failure| {
            if let Failure::Usage(message) = failure {
                Failure::Usage(format!("--tolerance {text}: {message}"))
            } else {
                failure
            }
        })?;
    }
    let begin_s = reference.times_s[0].max(other.times_s[0]);
    let last = |table: &Table| table.times_s[table.times_s.len() - 1];
    let end_s = last(&reference).min(last(&other));
    if end_s < begin_s {
        return Err(Failure::Refused(format!(
            "{} ends at {} s, before {} begins at {begin_s} s; the tables must overlap in time",
            shown(paths[usize::from(last(&other) < last(&reference))]),
            end_s,
            shown(paths[usize::from(last(&other) >= last(&reference))])
        )));
    }
    if !reference.times_s.iter().any(|time_s| (begin_s..=end_s).contains(time_s)) {
        return Err(Failure::Refused(format!(
            "{} has no row from {begin_s} s to {end_s} s, the time that both tables cover; name the table with more rows first",
            shown(paths[0])
        )));
    }
    let verdicts: Vec<Verdict> = columns
        .iter()
        .map(|column| verdict(column, &reference, &other, [begin_s, end_s], arguments, &tolerances))
        .collect();
    let differ = verdicts.iter().filter(|verdict| !verdict.agrees).count();
    let alone = [missing(&reference, &other), missing(&other, &reference)];
    if arguments.json {
        print(&format!(
            "{:#}",
            serde_json::json!({
                "agree": differ == 0, "from_s": begin_s, "to_s": end_s, "columns": verdicts,
                "only_in_first": alone[0], "only_in_second": alone[1],
            })
        ))?;
    } else if !arguments.quiet {
        print(&text(&verdicts, [begin_s, end_s], &alone))?;
    }
    if differ == 0 { Ok(()) } else { Err(Failure::Differ(differ, verdicts.len())) }
}

fn read(path: &Path) -> Result<Table, Failure> {
    let bytes = read_bytes(path)?;
    Table::read(bytes.as_slice()).map_err(|cause| Failure::Refused(format!("{}: {cause}", shown(path))))
}

/// Parses `NAME=X` into text, pattern and number.
fn tolerance(text: &str) -> Result<(String, String, f64), Failure> {
    let parsed = text.rsplit_once('=').and_then(|(name, number)| {
        let value: f64 = number.trim().parse().ok()?;
        (value.is_finite() && value >= 0.0 && !name.is_empty()).then(|| (text.to_owned(), name.to_owned(), value))
    });
    parsed.ok_or_else(|| {
        Failure::Usage(format!(
            "--tolerance {text}: must be NAME=X; allowed: a column and a number of 0 or more, such as fold.angle=1e-3"
        ))
    })
}

fn verdict(
    column: &Column,
    reference: &Table,
    other: &Table,
    [begin_s, end_s]: [f64; 2],
    arguments: &Arguments,
    tolerances: &[(String, String, f64)],
) -> Verdict {
    let name = column.name().to_owned();
    let beside = other.column(&name).unwrap_or(column);
    let (mut largest, mut at_s, mut squares, mut count, mut magnitude) = (0.0f64, begin_s, 0.0, 0u32, 0.0f64);
    for (row, time_s) in reference.times_s.iter().enumerate() {
        let value = column.values[row];
        if !(begin_s..=end_s).contains(time_s) || value.is_nan() {
            continue;
        }
        let Some(compared) = other.at(beside, *time_s) else { continue };
        let difference = (value - compared).abs();
        magnitude = magnitude.max(value.abs());
        squares += difference * difference;
        count += 1;
        // NaN never agrees with any value
        if difference > largest || difference.is_nan() {
            (largest, at_s) = (difference, *time_s);
        }
    }
    let own = tolerances.iter().rfind(|(_, pattern, _)| {
        *pattern == name || is_pattern(pattern) && chosen(std::slice::from_ref(pattern), &[column], "").is_ok()
    });
    let allowed = own.map_or(arguments.atol + arguments.rtol * magnitude, |(.., value)| *value);
    let rms = (squares / f64::from(count.max(1))).sqrt();
    Verdict { name, largest, at_s, rms, allowed, agrees: count > 0 && largest <= allowed }
}

/// Table of the columns, those with the largest difference relative to the tolerance first.
fn text(verdicts: &[Verdict], [begin_s, end_s]: [f64; 2], alone: &[Vec<String>; 2]) -> String {
    let mut rows: Vec<&Verdict> = verdicts.iter().collect();
    let ratio = |verdict: &Verdict| verdict.largest / verdict.allowed.max(f64::MIN_POSITIVE);
    rows.sort_by(|a, b| ratio(b).total_cmp(&ratio(a)));
    let width = rows.iter().map(|verdict| verdict.name.len()).max().unwrap_or(0).max(6);
    let mut text =
        format!("{:width$}  {:>11}  {:>10}  {:>11}  {:>11}\n", "column", "largest", "at s", "rms", "allowed");
    for verdict in rows {
        let mark = if verdict.agrees { "" } else { "  DIFFERS" };
        let _ = writeln!(
            text,
            "{:width$}  {:11.3e}  {:10.6}  {:11.3e}  {:11.3e}{mark}",
            verdict.name, verdict.largest, verdict.at_s, verdict.rms, verdict.allowed
        );
    }
    for (names, place) in alone.iter().zip(["first", "second"]) {
        if !names.is_empty() {
            let _ = writeln!(text, "only in the {place} table: {}", names.join(", "));
        }
    }
    let differ = verdicts.iter().filter(|verdict| !verdict.agrees).count();
    let _ = writeln!(text, "{} columns from {begin_s} s to {end_s} s: {differ} differ", verdicts.len());
    text
}
