//! Sections and axes from other files: CSV, and files of section programs.

use crate::beamdyn_file;
use crate::renamed;
use crate::section_files::{FileUnits, is_list, is_of_a_program, read_list, read_program};
use crate::station_table::{StationFault, StationTable, fault, without_mark};
use crate::stations::MAXIMUM_STATIONS;
use std::path::Path;

/// Keys of `[section.<name>.along]`.
pub(super) const SECTION_COLUMNS: &[&str] = &[
    "eta",
    "s_m",
    "axial_stiffness_N",
    "torsional_rigidity_N_m2",
    "flap_stiffness_N_m2",
    "edge_stiffness_N_m2",
    "coupling_axial_twist_N_m",
    "coupling_axial_flap_N_m",
    "coupling_axial_edge_N_m",
    "coupling_twist_flap_N_m2",
    "coupling_twist_edge_N_m2",
    "coupling_flap_edge_N_m2",
    "shear_stiffness_y_N",
    "shear_stiffness_z_N",
    "coupling_shear_y_shear_z_N",
    "coupling_shear_y_axial_N",
    "coupling_shear_y_twist_N_m",
    "coupling_shear_y_flap_N_m",
    "coupling_shear_y_edge_N_m",
    "coupling_shear_z_axial_N",
    "coupling_shear_z_twist_N_m",
    "coupling_shear_z_flap_N_m",
    "coupling_shear_z_edge_N_m",
    "tension_centre_y_m",
    "tension_centre_z_m",
    "mass_kg_m",
    "centre_of_mass_y_m",
    "centre_of_mass_z_m",
    "second_moment_yy_kg_m",
    "second_moment_yz_kg_m",
    "second_moment_zz_kg_m",
    "half_width_m",
    "half_height_m",
];

/// Keys of `[body.<name>.axis]`.
pub(super) const AXIS_COLUMNS: &[&str] = &["eta", "s_m", "y_m", "z_m", "twist_deg"];

/// Reads sections along a body: CSV with the keys of `[section.<name>.along]` as column names in the first row, or a file of VABS, BECAS,
/// ANBA4, PreComp, windIO (SONATA, WISDEM) or BeamDyn in SI units, whose 6×6 stiffness is stored as the condensed stiffness with zero
/// shear forces and the shear stiffness, NOTATION eqs. (S9), (S24).
///
/// # Errors
/// Text in none of these formats, rows of different lengths, numbers that are not finite, unknown columns, truncated files, matrices that
/// are impossible for a section.
pub fn read_sections(text: &str) -> Result<StationTable, StationFault> {
    read_sections_in(text, None)
}

/// Like [`read_sections`], for 6×6 matrices in other units.
///
/// # Errors
/// As for [`read_sections`], and units given for a file that states its units: CSV, PreComp.
pub fn read_sections_in(text: &str, units: Option<FileUnits>) -> Result<StationTable, StationFault> {
    let text = without_mark(text);
    if let Some(read) = read_program(text, units) {
        return read;
    }
    if units.is_some() {
        return Err(fault(1, "the columns of CSV state their units; remove file_units"));
    }
    read_columns(text, SECTION_COLUMNS, AXIS_COLUMNS)
}

/// Like [`read_sections_in`], from a file; a CSV file may also name, in its column `section_file`, files of one section each in the same
/// folder.
///
/// # Errors
/// A file that cannot be read, with line 0; otherwise as for [`read_sections_in`].
pub(super) fn read_section_file(path: &Path, units: Option<FileUnits>) -> Result<StationTable, StationFault> {
    let text = std::fs::read_to_string(path).map_err(|reason| fault(0, reason.to_string()))?;
    let text = without_mark(&text);
    if is_list(text) {
        return read_list(text, path.parent().unwrap_or(Path::new("")), units);
    }
    read_sections_in(text, units)
}

/// Sections in a file written by a section program, or in a list of such files; `None` for CSV and for files that cannot be read.
pub(super) fn sections_of_a_program(path: &Path, units: Option<FileUnits>) -> Option<StationTable> {
    let text = std::fs::read_to_string(path).ok()?;
    let text = without_mark(&text);
    if !is_of_a_program(text) && !is_list(text) {
        return None;
    }
    read_section_file(path, units).ok()
}

/// Reads the axis of a body: CSV with the keys of `[body.<name>.axis]` as column names in the first row, or BeamDyn's primary file.
///
/// # Errors
/// As for [`read_sections`].
pub fn read_axis(text: &str) -> Result<StationTable, StationFault> {
    let text = without_mark(text);
    match beamdyn_file::is_beamdyn(text) {
        true => beamdyn_file::read_key_points(text),
        false => read_columns(text, AXIS_COLUMNS, SECTION_COLUMNS),
    }
}

/// Reads the columns in `own`; those in `other` are left to another reader of the same file.
fn read_columns(text: &str, own: &[&str], other: &[&str]) -> Result<StationTable, StationFault> {
    let mut rows = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    let mut rows = rows.by_ref().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let (line, header) = rows.next().ok_or_else(|| fault(1, "an empty file"))?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    for (index, name) in names.iter().enumerate() {
        if !own.contains(name) && !other.contains(name) {
            let reason = match renamed::key(&["section".to_owned(), (*name).to_owned()]) {
                Some(new) => format!("the column {name} is now called {new}"),
                None => format!("no column is called {name:?}; known are {}", own.join(", ")),
            };
            return Err(fault(line, reason));
        }
        if names[..index].contains(name) {
            return Err(fault(line, format!("the column {name} appears twice")));
        }
    }
    let mut columns = vec![Vec::new(); names.len()];
    let mut count = 0;
    for (line, row) in rows {
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        if fields.len() != names.len() {
            return Err(fault(line, format!("{} fields where the header has {}", fields.len(), names.len())));
        }
        for ((column, field), name) in columns.iter_mut().zip(&fields).zip(&names) {
            let value: Option<f64> = field.parse().ok().filter(|value: &f64| value.is_finite());
            column.push(value.ok_or_else(|| fault(line, format!("{name} is {field:?}; a finite number is needed")))?);
        }
        count += 1;
        if count > MAXIMUM_STATIONS {
            return Err(fault(line, format!("more than {MAXIMUM_STATIONS} rows")));
        }
    }
    if count < 2 {
        return Err(fault(text.lines().count() + 1, "fewer than two rows after the header"));
    }
    let kept = names.iter().zip(columns).filter(|(name, _)| own.contains(name));
    let (names, columns) = kept.map(|(name, column)| ((*name).to_owned(), column)).unzip();
    Ok(StationTable { names, columns })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_serves_sections_and_axis() {
        let text = "# source\neta, mass_kg_m, twist_deg\n0, 10, -13.3\n\n1, 2, 0\n";
        let sections = read_sections(text).unwrap();
        assert_eq!(sections.names, ["eta", "mass_kg_m"]);
        assert_eq!(sections.column("mass_kg_m"), Some([10.0, 2.0].as_slice()));
        let axis = read_axis(text).unwrap();
        assert_eq!(axis.text("axis"), "axis = { eta = [0.0, 1.0], twist_deg = [-13.3, 0.0] }");
    }

    /// Comments, which may name the source, and the byte order mark of a spreadsheet do not change the result.
    #[test]
    fn comments_and_the_byte_order_mark_change_nothing() {
        let plain = "eta,mass_kg_m\n0,10\n1,2\n";
        let expected = read_sections(plain).unwrap();
        for front in ["# from the BeamDyn file of the blade\n", "\u{feff}", "\u{feff}# BeamDyn\n"] {
            assert_eq!(read_sections(&format!("{front}{plain}")).as_ref(), Ok(&expected), "{front:?}");
            assert_eq!(read_axis(&format!("{front}eta,twist_deg\n0,1\n1,2\n")).unwrap().names, ["eta", "twist_deg"]);
        }
    }

    #[test]
    fn faulty_files_are_refused_by_line_and_name() {
        for (text, line, reason) in [
            ("", 1, "an empty file"),
            ("share,mass_kg_m\n0,1\n1,1\n", 1, "the column share is now called eta"),
            ("eta,mas_kg_m\n0,1\n1,1\n", 1, "no column is called \"mas_kg_m\""),
            ("eta,eta\n0,1\n1,1\n", 1, "the column eta appears twice"),
            ("eta,mass_kg_m\n0,1\n1\n", 3, "1 fields where the header has 2"),
            ("eta,mass_kg_m\n0,1\n1,\n", 3, "mass_kg_m is \"\""),
            ("eta,mass_kg_m\n0,1\n1,inf\n", 3, "mass_kg_m is \"inf\""),
            ("eta,mass_kg_m\n0,1\n", 3, "fewer than two rows"),
        ] {
            let fault = read_sections(text).unwrap_err();
            assert!(fault.line == line && fault.reason.starts_with(reason), "{fault}");
        }
    }
}
