//! `elastic_properties` of a blade in a windIO file (YAML), and `six_x_six` of the first windIO version, as written by SONATA and WISDEM:
//! stiffness and inertia about the reference axis, in BeamDyn's axes. Only keys and bracketed lists of numbers are read.

use super::matrices::{BLADE, Station, Stiffness, slice_inertia};
use super::text::number;
use crate::station_table::{StationFault, fault};
use crate::stations::MAXIMUM_STATIONS;
use nalgebra::Matrix6;

/// Keys that precede the section data.
pub(super) const MARKS: [&str; 3] = ["elastic_properties:", "elastic_properties_mb:", "six_x_six:"];

/// List of numbers: its line and its rows; a flat list is one row.
type List = (usize, Vec<Vec<f64>>);

/// Lists of numbers of the blade, identified by their key and the key of their table.
struct Lists(Vec<([String; 2], List)>);

impl Lists {
    fn find(&self, tables: &[&str], key: &str) -> Option<&List> {
        let found = self.0.iter().find(|([table, name], _)| tables.contains(&table.as_str()) && name == key);
        found.map(|(_, list)| list)
    }

    fn flat(&self, tables: &[&str], key: &str, count: usize) -> Result<(usize, &[f64]), StationFault> {
        let list = self.find(tables, key);
        let (line, rows) = list.ok_or_else(|| fault(1, format!("no list {key} in {}", tables.join(" or "))))?;
        let values = match rows.as_slice() {
            [only] => only,
            _ => return Err(fault(*line, format!("{key} is not a flat list of numbers"))),
        };
        if count > 0 && values.len() != count {
            return Err(fault(*line, format!("{key} has {} numbers where its grid has {count}", values.len())));
        }
        Ok((*line, values))
    }
}

const STIFFNESS: [&str; 2] = ["stiffness_matrix", "stiff_matrix"];
const INERTIA: [&str; 1] = ["inertia_matrix"];

/// Reads the sections.
pub(super) fn stations(text: &str) -> Result<Vec<Station>, StationFault> {
    let lists = lists(text)?;
    let (line, grid) = lists.flat(&STIFFNESS, "grid", 0)?;
    let (inertia_line, inertia_grid) = lists.flat(&INERTIA, "grid", 0)?;
    let rises = grid.windows(2).all(|pair| pair[0] < pair[1]);
    if !(2..=MAXIMUM_STATIONS).contains(&grid.len()) || !rises {
        return Err(fault(
            line,
            format!("a grid of {} positions; needed are 2 to {MAXIMUM_STATIONS} that ascend from 0 to 1", grid.len()),
        ));
    }
    if grid != inertia_grid {
        return Err(fault(inertia_line, "the grids of stiffness and inertia differ; interpolate one of them first"));
    }
    let stiffness = upper_triangles(&lists, &STIFFNESS, grid.len())?;
    let inertia = match lists.find(&INERTIA, "mass") {
        Some(_) => slices(&lists, grid.len())?,
        None => upper_triangles(&lists, &INERTIA, grid.len())?,
    };
    let station = |((share, stiffness), inertia): ((&f64, Matrix6<f64>), Matrix6<f64>)| Station {
        share: Some(*share),
        lines: [line, inertia_line],
        stiffness: Stiffness::Whole(stiffness),
        inertia,
    };
    Ok(grid.iter().zip(stiffness).zip(inertia).map(station).collect())
}

/// Row and column indices of the upper triangle, row by row.
fn places() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|row| (row..6).map(move |column| (row, column)))
}

/// Symmetric matrices given by 21 numbers per station in `values`, or by lists `K11` to `K66`.
fn upper_triangles(lists: &Lists, tables: &[&str], count: usize) -> Result<Vec<Matrix6<f64>>, StationFault> {
    let mut matrices = vec![Matrix6::zeros(); count];
    let values = lists.find(tables, "values");
    for (index, (row, column)) in places().enumerate() {
        let named = match values {
            Some(_) => None,
            None => Some(lists.flat(tables, &format!("K{}{}", row + 1, column + 1), count)?.1),
        };
        for (station, matrix) in matrices.iter_mut().enumerate() {
            let value = match (named, values) {
                (Some(list), _) => list[station],
                (None, Some((line, rows))) => {
                    let row = rows.get(station).filter(|row| row.len() == 21 && rows.len() == count);
                    *row.and_then(|row| row.get(index)).ok_or_else(|| {
                        fault(
                            *line,
                            format!("values of station {}: {count} rows of 21 numbers are needed", station + 1),
                        )
                    })?
                }
                (None, None) => 0.0,
            };
            (matrix[(row, column)], matrix[(column, row)]) = (value, value);
        }
    }
    Ok(matrices)
}

/// Inertia given by mass, centre and moments about the reference axis: `i_edge` about `x`, `i_flap` about `y`, `i_cp = ∫ρxy dA`.
fn slices(lists: &Lists, count: usize) -> Result<Vec<Matrix6<f64>>, StationFault> {
    let list = |key: &str| lists.flat(&INERTIA, key, count).map(|(_, values)| values);
    let (mass, x, y) = (list("mass")?, list("cm_x")?, list("cm_y")?);
    let (edge, flap, polar, product) = (list("i_edge")?, list("i_flap")?, list("i_plr")?, list("i_cp")?);
    Ok((0..count)
        .map(|i| {
            // our (x, y, z) of the slice are (z, −y, x) of the file
            let slice = slice_inertia([mass[i], -y[i], x[i], edge[i], -product[i], flap[i]]);
            let mut inertia = BLADE.back(&slice);
            inertia[(5, 5)] = polar[i];
            inertia
        })
        .collect())
}

/// Reads the lists of the first blade, or of the whole file if there is no blade; tables are distinguished by indentation.
fn lists(text: &str) -> Result<Lists, StationFault> {
    let mut found = Lists(Vec::new());
    let mut path: Vec<(usize, String)> = Vec::new();
    let in_blade = text.lines().any(|line| line.trim_end() == "    blade:" || line.trim() == "blade:");
    let mut lines = text.lines().enumerate();
    while let Some((index, whole)) = lines.next() {
        let content = whole.split(" #").next().unwrap_or_default();
        let trimmed = content.trim();
        let Some((key, value)) = trimmed.split_once(':').filter(|_| !trimmed.starts_with(['#', '-'])) else { continue };
        let indent = content.len() - content.trim_start().len();
        path.retain(|(outer, _)| *outer < indent);
        let table = path.last().map(|(_, name)| name.clone()).unwrap_or_default();
        let wanted = STIFFNESS.contains(&table.as_str()) || INERTIA.contains(&table.as_str());
        let wanted = wanted && (!in_blade || path.iter().any(|(_, name)| name == "blade"));
        if wanted {
            let mut list = value.trim().to_owned();
            let depth = |list: &str| list.matches('[').count() as i64 - list.matches(']').count() as i64;
            while depth(&list) > 0 {
                let (_, more) = lines
                    .next()
                    .ok_or_else(|| fault(index + 1, format!("truncated: the file ends before the end of {key}")))?;
                list += " ";
                list += more.trim();
            }
            if !list.starts_with('[') {
                return Err(fault(index + 1, format!("{key} is {list:?}; a list of numbers in brackets is needed")));
            }
            found.0.push(([table, key.trim().to_owned()], (index + 1, rows(index + 1, key, &list)?)));
        }
        path.push((indent, key.trim().to_owned()));
    }
    Ok(found)
}

/// Parses `[1, 2]` or `[[1, 2], [3, 4]]`.
fn rows(line: usize, key: &str, list: &str) -> Result<Vec<Vec<f64>>, StationFault> {
    let inner = list.trim().strip_prefix('[').and_then(|list| list.strip_suffix(']'));
    let inner = inner.ok_or_else(|| fault(line, format!("{key} has no list of numbers in brackets")))?;
    let row = |text: &str| -> Result<Vec<f64>, StationFault> {
        let words = text.split(',').map(str::trim).filter(|word| !word.is_empty());
        words.map(|word| number(line, key, word)).collect()
    };
    if !inner.contains('[') {
        return Ok(vec![row(inner)?]);
    }
    inner
        .split(']')
        .filter(|part| part.contains('['))
        .map(|part| row(part.split('[').nth(1).unwrap_or_default()))
        .collect()
}
