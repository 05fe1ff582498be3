//! Polars from files in AeroDyn's airfoil format or CSV.

use crate::station_table::without_mark;
use foldwing_engine::aero::polar::{Polar, PolarRow};
use std::str::SplitWhitespace;

/// Maximum number of rows of a table: a full circle in steps of a thousandth of a degree has 360 001.
const MAXIMUM_ROWS: usize = 400_000;
/// Maximum number of tables in a file.
const MAXIMUM_TABLES: usize = 1000;

/// Table of an airfoil.
#[derive(Debug, Clone, PartialEq)]
pub struct AirfoilTable {
    /// Reynolds number; `None` for CSV.
    pub reynolds: Option<f64>,
    /// Coefficients as functions of the angle of attack.
    pub polar: Polar,
    /// Values of the block on unsteady aerodynamics with AeroDyn's names, as written (angles in degrees); values given as "default" are
    /// omitted.
    pub unsteady: Vec<(String, f64)>,
}

/// Error in a file, with its position.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct PolarFault {
    /// Line numbered from 1; if the file is truncated, one more than the last line.
    pub line: usize,
    /// Present and allowed values, and the remedy.
    pub reason: String,
}

/// Reads a file and detects its format: AeroDyn's contains `NumAlf`, CSV does not.
///
/// # Errors
/// As for [`read_aerodyn`] or [`read_csv`].
pub fn read_polars(text: &str) -> Result<Vec<AirfoilTable>, PolarFault> {
    let text = without_mark(text);
    let aerodyn = text.lines().any(|line| words(line).nth(1).is_some_and(|word| word.eq_ignore_ascii_case("NumAlf")));
    if aerodyn { read_aerodyn(text) } else { read_csv(text).map(|table| vec![table]) }
}

/// Reads a CSV file: a header with the columns `alpha_deg`, `cl`, `cd` and, for moments, `cm` (about the quarter chord), in any order;
/// lines that start with `#` are comments.
///
/// # Errors
/// A missing or repeated column, a line with too few or too many fields, numbers that are not finite, angles that do not ascend or exceed
/// ±180°, or a file without rows.
pub fn read_csv(text: &str) -> Result<AirfoilTable, PolarFault> {
    let mut lines = numbered(text).filter(|(_, line)| !line.trim_start().starts_with('#') && !line.trim().is_empty());
    let (first, header) =
        lines.next().ok_or_else(|| fault(1, "an empty file; a header such as alpha_deg,cl,cd,cm must be first"))?;
    let names: Vec<String> = header.split(',').map(|name| name.trim().trim_matches('"').to_ascii_lowercase()).collect();
    let column = |wanted: &str| {
        let mut found = names.iter().enumerate().filter(|(_, name)| *name == wanted).map(|(index, _)| index);
        let index = found.next();
        match found.next() {
            Some(_) => Err(fault(first, format!("the column {wanted} appears twice; name it once"))),
            None => Ok(index),
        }
    };
    let needed = |wanted: &str| {
        let seen = names.join(", ");
        column(wanted)?
            .ok_or_else(|| fault(first, format!("no column {wanted} among {seen}; needed are alpha_deg, cl and cd")))
    };
    let places = [Some(needed("alpha_deg")?), Some(needed("cl")?), Some(needed("cd")?), column("cm")?];
    let mut rows = Vec::new();
    for (line, text) in lines {
        let fields: Vec<&str> = text.split(',').collect();
        if fields.len() != names.len() {
            let (got, due) = (fields.len(), names.len());
            return Err(fault(line, format!("{got} fields where the header has {due}; a value is missing or extra")));
        }
        let mut values = [0.0; 4];
        for (value, place) in values.iter_mut().zip(places) {
            if let Some(place) = place {
                *value = number(line, &names[place], fields[place].trim())?;
            }
        }
        push(line, values, &mut rows)?;
    }
    if rows.is_empty() {
        return Err(fault(first + 1, "no rows below the header"));
    }
    Ok(AirfoilTable { reynolds: None, polar: Polar { rows }, unsteady: Vec::new() })
}

/// Reads AeroDyn's airfoil file (AirfoilInfo v1.01): `NumTabs` tables of `NumAlf` rows each; lines that start with `!` are comments.
/// Coordinates, interpolation order and boundary-layer file are ignored.
///
/// # Errors
/// A table without `Re`, `InclUAdata` or `NumAlf`, fewer rows than `NumAlf`, rows with fewer than three columns or with a varying number
/// of columns, and the errors of [`read_csv`] in rows.
pub fn read_aerodyn(text: &str) -> Result<Vec<AirfoilTable>, PolarFault> {
    let mut lines = numbered(text).filter(|(_, line)| !line.trim_start().starts_with('!') && !line.trim().is_empty());
    let end = text.lines().count() + 1;
    let mut expect = |label: &str| -> Result<(usize, String), PolarFault> {
        for (line, text) in lines.by_ref() {
            let mut words = words(text);
            let (value, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
            if name.eq_ignore_ascii_case(label) {
                return Ok((line, value.trim_matches('"').to_owned()));
            }
            if label.is_empty() {
                return Ok((line, text.to_owned()));
            }
        }
        Err(fault(end, format!("the file ends before {}", if label.is_empty() { "its rows do" } else { label })))
    };
    let (line, count) = expect("NumTabs")?;
    let tables = whole(line, "NumTabs", &count, MAXIMUM_TABLES)?;
    let mut read = Vec::with_capacity(tables);
    for _ in 0..tables {
        let (line, value) = expect("Re")?;
        let reynolds = 1e6 * number(line, "Re", &value)?;
        let (line, value) = expect("InclUAdata")?;
        let unsteady = match value.to_ascii_lowercase().as_str() {
            "true" | "t" | ".true." => {
                let mut block = Vec::new();
                let count = loop {
                    let (line, text) = expect("")?;
                    let mut words = words(&text);
                    let (value, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
                    if name.eq_ignore_ascii_case("NumAlf") {
                        break (line, value.to_owned());
                    }
                    if !value.trim_matches('"').eq_ignore_ascii_case("default") {
                        block.push((name.to_owned(), number(line, name, value)?));
                    }
                };
                (block, count)
            }
            "false" | "f" | ".false." => (Vec::new(), expect("NumAlf")?),
            other => return Err(fault(line, format!("InclUAdata is {other:?}; True or False"))),
        };
        let (unsteady, (line, count)) = unsteady;
        let count = whole(line, "NumAlf", &count, MAXIMUM_ROWS)?;
        let mut rows = Vec::with_capacity(count);
        let mut columns = None;
        for _ in 0..count {
            let (line, text) = expect("")?;
            let fields: Vec<&str> = words(&text).take_while(|word| !word.starts_with('!')).collect();
            let due = *columns.get_or_insert(fields.len());
            if fields.len() != due || due < 3 {
                let got = fields.len();
                let reason = format!(
                    "{got} columns where {} are needed: angle, lift, drag and, if all rows have it, moment; NumAlf announces {count} rows",
                    due.max(3)
                );
                return Err(fault(line, reason));
            }
            let mut values = [0.0; 4];
            for ((value, field), name) in values.iter_mut().zip(&fields).zip(["Alpha", "Cl", "Cd", "Cm"]) {
                *value = number(line, name, field)?;
            }
            push(line, values, &mut rows)?;
        }
        read.push(AirfoilTable { reynolds: Some(reynolds), polar: Polar { rows }, unsteady });
    }
    Ok(read)
}

fn numbered(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().map(|(index, line)| (index + 1, line))
}

fn words(line: &str) -> SplitWhitespace<'_> {
    line.split_whitespace()
}

fn fault(line: usize, reason: impl Into<String>) -> PolarFault {
    PolarFault { line, reason: reason.into() }
}

fn number(line: usize, name: &str, text: &str) -> Result<f64, PolarFault> {
    let value: Option<f64> = text.trim_matches('"').replace(['d', 'D'], "e").parse().ok();
    value.filter(|value| value.is_finite()).ok_or_else(|| {
        fault(line, format!("{name} is {text:?}; a finite number is needed; values must not be missing"))
    })
}

fn whole(line: usize, name: &str, text: &str, most: usize) -> Result<usize, PolarFault> {
    let value: Option<usize> = text.parse().ok();
    value
        .filter(|value| (1..=most).contains(value))
        .ok_or_else(|| fault(line, format!("{name} is {text:?}; a whole number from 1 to {most} is needed")))
}

/// Adds a row: angle in degrees, lift, drag, moment.
fn push(line: usize, [angle_deg, lift, drag, moment]: [f64; 4], rows: &mut Vec<PolarRow>) -> Result<(), PolarFault> {
    if angle_deg.abs() > 180.0 {
        return Err(fault(line, format!("an angle of {angle_deg} deg; -180 to 180 are allowed")));
    }
    let angle_rad = angle_deg.to_radians();
    if let Some(last) = rows.last().filter(|last: &&PolarRow| last.angle_rad >= angle_rad) {
        let earlier = last.angle_rad.to_degrees();
        return Err(fault(
            line,
            format!("an angle of {angle_deg} deg after {earlier} deg; angles must ascend: sort the rows"),
        ));
    }
    if rows.len() >= MAXIMUM_ROWS {
        return Err(fault(line, format!("more than {MAXIMUM_ROWS} rows")));
    }
    rows.push(PolarRow { angle_rad, lift, drag, moment });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const AERODYN: &str = "! comment\n\"DEFAULT\" InterpOrd ! x\n1 NonDimArea\n0 NumCoords\n\"unused\" BL_file\n2 NumTabs\n\
        ! ---\n0.75 Re ! millions\n0 UserProp\nTrue InclUAdata\n-4.2 alpha0 ! deg\n6.2047 C_nalpha\n\"DEFAULT\" UACutout\n3 NumAlf ! rows\n\
        ! Alpha Cl Cd Cm\n-180.0 0.0 0.02 0.0\n0.0 0.5 0.01 -0.1\n1.8E+02 0.0 0.02 0.0 ! end\n\
        1.5 Re\n0 UserProp\nFalse InclUAdata\n2 NumAlf\n-180 0 0.02\n180 0 0.02\n";

    #[test]
    fn aerodyn_tables_are_read_with_their_unsteady_block() {
        let tables = read_polars(AERODYN).unwrap();
        assert_eq!(tables.len(), 2);
        assert_eq!((tables[0].reynolds, tables[1].reynolds), (Some(0.75e6), Some(1.5e6)));
        assert_eq!(tables[0].unsteady, [("alpha0".to_owned(), -4.2), ("C_nalpha".to_owned(), 6.2047)]);
        let row = tables[0].polar.rows[1];
        assert_eq!((row.angle_rad, row.lift, row.drag, row.moment), (0.0, 0.5, 0.01, -0.1));
        assert_eq!(tables[0].polar.rows[2].angle_rad, std::f64::consts::PI);
        assert_eq!((tables[1].polar.rows.len(), tables[1].polar.rows[0].moment), (2, 0.0));
    }

    #[test]
    fn csv_takes_columns_by_name() {
        let table = read_polars("# source\ncd,alpha_deg,cl\n0.01,-5,-0.2\n\n0.02,5,0.9\n").unwrap().remove(0);
        let row = table.polar.rows[1];
        assert_eq!((row.lift, row.drag, row.moment), (0.9, 0.02, 0.0));
        // the byte order mark that spreadsheets write is not part of the first name
        let marked = read_polars("\u{feff}alpha_deg,cl,cd\n-5,-0.2,0.01\n5,0.9,0.02\n").unwrap().remove(0);
        assert_eq!(marked.polar.rows[1], row);
    }

    /// Every error states the line and the name of the value.
    #[test]
    fn faulty_files_are_refused_by_line_and_name() {
        let csv = |rows: &str| format!("alpha_deg,cl,cd,cm\n{rows}");
        for (text, line, names) in [
            (String::new(), 1, "empty file"),
            ("alpha_deg,cl\n0,1\n".into(), 1, "no column cd"),
            ("alpha_deg,cl,cl,cd\n0,1,1,1\n".into(), 1, "cl appears twice"),
            (csv(""), 2, "no rows"),
            (csv("0,1,0.1,0\n1,,0.1,0\n"), 3, "cl is \"\""),
            (csv("0,1,0.1,0\n1,1,0.1\n"), 3, "3 fields where the header has 4"),
            (csv("0,1,NaN,0\n"), 2, "cd is \"NaN\""),
            (csv("0,1,inf,0\n"), 2, "cd is \"inf\""),
            (csv("0,1,0.1,0\n0,1,0.1,0\n"), 3, "must ascend"),
            (csv("5,1,0.1,0\n2,1,0.1,0\n"), 3, "an angle of 2 deg after 5"),
            (csv("190,1,0.1,0\n"), 2, "190 deg"),
            (AERODYN.replace("0.0 0.5 0.01 -0.1", "0.0 0.5 0.01"), 17, "3 columns where 4"),
            (AERODYN.replace("0.0 0.5 0.01 -0.1\n", ""), 17, "ends before|columns"),
            (AERODYN.replace("3 NumAlf", "9 NumAlf"), 18, "NumAlf announces 9"),
            (AERODYN.replace("180 0 0.02\n", ""), 22, "columns|ends before its rows"),
            (AERODYN.replace("-4.2 alpha0", "none alpha0"), 11, "alpha0 is \"none\""),
            (AERODYN.replace("True Incl", "Maybe Incl"), 10, "True or False"),
            (AERODYN.replace("0.75 Re", "0.75 Reynolds"), 23, "NumAlf|Re"),
            (AERODYN.replace("2 NumTabs", "0 NumTabs"), 6, "NumTabs is \"0\""),
        ] {
            let fault = read_polars(&text).expect_err(&text);
            assert!(names.split('|').any(|name| fault.reason.contains(name)), "{fault} does not name {names}");
            let near = names.contains('|') || fault.line.abs_diff(line) == 0 || names.contains("announces");
            assert!(near, "{fault}, expected line {line}");
        }
    }
}
