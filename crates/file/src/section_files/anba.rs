//! Output of ANBA4 about the origin of its mesh: the JSON of its command line, or the two matrices printed by its solver, stiffness
//! first.

use super::matrices::{Station, Stiffness};
use super::text::Lines;
use crate::station_table::{StationFault, fault};
use nalgebra::Matrix6;
use serde_json::Value;

/// Line that precedes a printed matrix.
const PRINTED: &str = "Mat Object";

/// Reads the section.
pub(super) fn station(text: &str) -> Result<Station, StationFault> {
    let [(line, stiffness), (inertia_line, inertia)] =
        if text.trim_start().starts_with('{') { of_json(text) } else { printed(text) }?;
    Ok(Station { share: None, lines: [line, inertia_line], stiffness: Stiffness::Whole(stiffness), inertia })
}

fn of_json(text: &str) -> Result<[(usize, Matrix6<f64>); 2], StationFault> {
    let value: Value =
        serde_json::from_str(text).map_err(|reason| fault(reason.line(), format!("no valid JSON: {reason}")))?;
    let matrix = |names: [&str; 2]| {
        let found = names.into_iter().find_map(|name| Some((name, value.get(name)?)));
        let (name, rows) = found.ok_or_else(|| fault(1, format!("no key {:?} or {:?}", names[0], names[1])))?;
        let at = text.find(&format!("\"{name}\"")).unwrap_or_default();
        let line = text[..at].matches('\n').count() + 1;
        let rows = rows.get("data").unwrap_or(rows);
        let entry = |row: usize, column: usize| rows.get(row)?.get(column)?.as_f64();
        let square = rows.as_array().is_some_and(|rows| {
            rows.len() == 6 && rows.iter().all(|row| row.as_array().is_some_and(|row| row.len() == 6))
        });
        let mut matrix = Matrix6::zeros();
        for (row, column) in (0..6).flat_map(|row| (0..6).map(move |column| (row, column))) {
            matrix[(row, column)] = entry(row, column).filter(|_| square).ok_or_else(|| {
                let place = format!("row {}, column {}", row + 1, column + 1);
                fault(line, format!("{name} has no number in {place}; six rows of six numbers are needed"))
            })?;
        }
        Ok((line, matrix))
    };
    Ok([matrix(["stiffness", "stiffness_matrix"])?, matrix(["mass", "mass_matrix"])?])
}

fn printed(text: &str) -> Result<[(usize, Matrix6<f64>); 2], StationFault> {
    let mut lines = Lines::of(text);
    let mut next = |due: &str| {
        loop {
            let (_, line) = lines.next(due)?;
            if line.trim_start().starts_with(PRINTED) {
                lines.next(due)?; // line with the type of the matrix
                return lines.matrix::<6>(due);
            }
        }
    };
    Ok([next("the stiffness")?, next("the mass matrix")?])
}
