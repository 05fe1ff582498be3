//! Files of section programs: 6×6 matrices of VABS, BECAS, ANBA4, windIO and BeamDyn, and tables of PreComp, converted to the columns of
//! `[section.<name>.along]`. Each format has a reader for its numbers and an [`Axes`]; `matrices` contains everything common.

mod anba;
mod becas;
mod matrices;
mod precomp;
mod text;
mod vabs;
mod windio;

use crate::beamdyn_file;
use crate::station_table::{StationFault, StationTable, fault, without_mark};
use crate::stations::MAXIMUM_STATIONS;
use matrices::{Axes, BLADE, X_ALONG, Z_ALONG, row, table};
use std::path::Path;
use text::number;

pub use matrices::{FileUnits, condensed_stiffness};
pub(super) use matrices::{Station, Stiffness};
pub(super) use text::Lines;

/// Sections of a file, and the axes of its program.
struct Sections {
    axes: Axes,
    stations: Vec<Station>,
}

/// Programs whose files are recognised by their contents.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Program {
    BeamDyn,
    Vabs,
    Becas,
    Anba,
    WindIo,
    PreComp,
}

/// Returns the program that wrote a text; `None` for CSV.
fn program(text: &str) -> Option<Program> {
    if beamdyn_file::is_beamdyn(text) {
        return Some(Program::BeamDyn);
    }
    if text.trim_start().starts_with('{') || text.contains("Mat Object") {
        return Some(Program::Anba);
    }
    text.lines().map(str::trim).find_map(|line| {
        let starts = |mark: &str| line.get(..mark.len()).is_some_and(|front| front.eq_ignore_ascii_case(mark));
        if starts(vabs::MASS) {
            Some(Program::Vabs)
        } else if starts(becas::STIFFNESS) {
            Some(Program::Becas)
        } else if starts(precomp::MARK) {
            Some(Program::PreComp)
        } else if windio::MARKS.iter().any(|mark| starts(mark)) {
            Some(Program::WindIo)
        } else {
            None
        }
    })
}

/// Returns whether a text contains 6×6 matrices or PreComp output, rather than CSV.
pub(super) fn is_of_a_program(text: &str) -> bool {
    program(text).is_some()
}

fn read(program: Program, text: &str) -> Result<Sections, StationFault> {
    match program {
        Program::BeamDyn => Ok(Sections { axes: BLADE, stations: beamdyn_file::stations(text)? }),
        Program::Vabs => Ok(Sections { axes: X_ALONG, stations: vec![vabs::station(text)?] }),
        Program::Becas => Ok(Sections { axes: Z_ALONG, stations: vec![becas::station(text)?] }),
        Program::Anba => Ok(Sections { axes: Z_ALONG, stations: vec![anba::station(text)?] }),
        Program::WindIo => Ok(Sections { axes: BLADE, stations: windio::stations(text)? }),
        Program::PreComp => Ok(Sections { axes: X_ALONG, stations: precomp::stations(text)? }),
    }
}

/// Sections in a file of a section program as columns of `[section.<name>.along]`; `None` for CSV. A file of a single section gives equal
/// sections at both ends.
///
/// # Errors
/// Truncated files, invalid numbers, matrices that are impossible for a section, or units given for a file that states its units.
pub(super) fn read_program(text: &str, units: Option<FileUnits>) -> Option<Result<StationTable, StationFault>> {
    let program = program(text)?;
    Some(read_of(program, text, units))
}

fn read_of(program: Program, text: &str, units: Option<FileUnits>) -> Result<StationTable, StationFault> {
    if program == Program::PreComp && units.is_some_and(|units| units != FileUnits::MNKg) {
        return Err(fault(1, "PreComp prints SI units; remove file_units"));
    }
    let sections = read(program, text)?;
    let row = |station: &Station| row(&sections.axes, station, units.unwrap_or_default());
    let mut rows = sections.stations.iter().map(row).collect::<Result<Vec<_>, _>>()?;
    if let [only] = sections.stations.as_slice() {
        if only.share.is_some() {
            return Err(fault(only.lines[0], "one station; at least two are needed, from 0 to 1"));
        }
        rows = [0.0, 1.0].map(|share| (share, rows[0].1)).to_vec();
    }
    Ok(table("eta", &rows))
}

/// Returns whether the header of a CSV file has a column with names of section files.
pub(super) fn is_list(text: &str) -> bool {
    header(text).is_some_and(|(_, line)| line.split(',').any(|name| name.trim() == LIST_COLUMN))
}

/// Column with the names of files of one section each.
const LIST_COLUMN: &str = "section_file";

fn header(text: &str) -> Option<(usize, &str)> {
    let mut lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    lines.find(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// Reads the sections in the files named by a CSV file with the columns `eta` or `s_m`, and `section_file`.
///
/// # Errors
/// Other columns, a file that cannot be read or has several sections, and the errors of [`read_program`].
pub(super) fn read_list(text: &str, folder: &Path, units: Option<FileUnits>) -> Result<StationTable, StationFault> {
    let (first, names) = header(text).ok_or_else(|| fault(1, "an empty file"))?;
    let names: Vec<&str> = names.split(',').map(str::trim).collect();
    let place = ["eta", "s_m"].into_iter().find(|place| names == [*place, LIST_COLUMN]);
    let place = place.ok_or_else(|| {
        fault(first, format!("columns {}; needed are eta,{LIST_COLUMN} or s_m,{LIST_COLUMN}", names.join(",")))
    })?;
    let mut rows = Vec::new();
    for (index, text) in text.lines().enumerate().skip(first) {
        let (line, text) = (index + 1, text.trim());
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        let (position, name) =
            text.split_once(',').ok_or_else(|| fault(line, format!("{text:?}; a position and a file are needed")))?;
        let position = number(line, place, position.trim())?;
        let path = folder.join(name.trim());
        let content = std::fs::read_to_string(&path)
            .map_err(|reason| fault(line, format!("{LIST_COLUMN} {}: {reason}", path.display())))?;
        let within = |inner: StationFault| fault(line, format!("{}: {inner}", path.display()));
        let content = without_mark(&content);
        let program = program(content)
            .ok_or_else(|| fault(line, format!("{} is not a file of VABS, BECAS or ANBA4", path.display())))?;
        let sections = read(program, content).map_err(within)?;
        let [only] = sections.stations.as_slice() else {
            let count = sections.stations.len();
            return Err(fault(line, format!("{} has {count} sections; name it as file by itself", path.display())));
        };
        rows.push((position, row(&sections.axes, only, units.unwrap_or_default()).map_err(within)?.1));
        if rows.len() > MAXIMUM_STATIONS {
            return Err(fault(line, format!("more than {MAXIMUM_STATIONS} rows")));
        }
    }
    if rows.len() < 2 {
        return Err(fault(text.lines().count() + 1, "fewer than two rows after the header"));
    }
    Ok(table(place, &rows))
}
