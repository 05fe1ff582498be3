//! Embedding of polars, sections and axes of other files in the text of the model file, so that the model in an FMU needs no other file.

use crate::base64;
use crate::bladed_summary::read_bladed_summary;
use crate::error::{Fault, Problem};
use crate::polar_file::read_polars;
use crate::section_files::FileUnits;
use crate::station_file::{read_axis, read_section_file};
use crate::wind_file::{BladedSettings, is_bladed, read_field, read_wind_table};
use foldwing_engine::aero::rotor::wind::TableRow;
use indexmap::IndexMap;
use serde::Deserialize;
use std::fmt::Write;
use std::path::Path;
use toml::Spanned;

/// Keys used here; all others are left to later passes.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Wanted {
    polar: IndexMap<String, WantedFile>,
    section: IndexMap<String, WantedSection>,
    body: IndexMap<String, WantedAxis>,
    wind: WantedWind,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct WantedWind {
    table_file: Option<Spanned<String>>,
    field_file: Option<Spanned<String>>,
    reference_length_m: Option<f64>,
    reference_height_m: Option<f64>,
    field_centre_height_m: Option<f64>,
    field_from: Option<String>,
}

impl WantedWind {
    /// Settings of a full-field wind file of Bladed.
    fn bladed(&self) -> BladedSettings {
        BladedSettings {
            middle_height_m: self.field_centre_height_m.or(self.reference_height_m).unwrap_or(0.0),
            from_port: self.field_from.as_deref() != Some("starboard"),
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct WantedFile {
    file: Option<Spanned<String>>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct WantedSection {
    file: Option<Spanned<String>>,
    file_units: Option<FileUnits>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct WantedAxis {
    axis_file: Option<Spanned<String>>,
}

/// Converts a file to the text of the key that replaces it; the error states the required contents of the file.
type Reader = Box<dyn Fn(&Path) -> Result<String, String>>;

/// Returns the text with `file = "…"` of every polar, section and axis replaced by the contents of the file, on the same line, so that line
/// numbers are unchanged. Files are searched in `folder`. A text that is not a model is returned unchanged: later passes report the errors.
///
/// # Errors
/// A file that cannot be read or has invalid contents; reported at the line of its key.
pub(super) fn with_files(text: String, folder: &Path) -> Result<String, Vec<Problem>> {
    let Ok(wanted) = toml::from_str::<Wanted>(&text) else { return Ok(text) };
    let polars =
        wanted.polar.into_iter().map(|(name, file)| ("polar", name, "file", file.file, Box::new(rows) as Reader));
    let sections = wanted.section.into_iter().map(|(name, section)| {
        let read: Reader = Box::new(move |path| along(path, section.file_units));
        ("section", name, "file", section.file, read)
    });
    let axes = wanted
        .body
        .into_iter()
        .map(|(name, file)| ("body", name, "axis_file", file.axis_file, Box::new(axis) as Reader));
    let settings = wanted.wind.bladed();
    let WantedWind { table_file, field_file, reference_length_m, .. } = wanted.wind;
    // a table without its length is reported by a later pass
    let table: Reader =
        Box::new(move |path| wind_table(path, reference_length_m.filter(|length| *length > 0.0).unwrap_or(1.0)));
    let field: Reader = Box::new(move |path| wind_field(path, settings));
    let wind = [("table_file", table_file, table), ("field_file", field_file, field)];
    let wind = wind.into_iter().map(|(key, file, read)| ("wind", String::new(), key, file, read));
    let mut places = Vec::new();
    let mut problems = Vec::new();
    for (table, name, key, file, read) in polars.chain(sections).chain(axes).chain(wind) {
        let Some(file) = file else { continue };
        let span = file.span();
        let start = text[..span.start].rfind(key).unwrap_or(span.start);
        match read(&folder.join(file.get_ref())) {
            Ok(rows) => places.push((start..span.end, rows)),
            Err(reason) => problems.push(Problem {
                line: text[..span.start].matches('\n').count() + 1,
                fault: Fault::NotAllowed { value: text[span.clone()].to_owned(), allowed: reason },
                span,
                key: [table, &name, key].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("."),
            }),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    places.sort_by_key(|(span, _)| span.start);
    let mut whole = text;
    for (span, rows) in places.into_iter().rev() {
        whole.replace_range(span, &rows);
    }
    Ok(whole)
}

/// Text `along = { … }` for a file of sections.
fn along(path: &Path, units: Option<FileUnits>) -> Result<String, String> {
    let shown = path.display();
    let table = read_section_file(path, units).map_err(|fault| match fault.line {
        0 => format!("a readable file of sections ({shown}: {})", fault.reason),
        _ => {
            format!("sections as CSV or in a file of VABS, BECAS, ANBA4, PreComp, windIO or BeamDyn ({shown}: {fault})")
        }
    })?;
    Ok(table.text("along"))
}

/// Text `table = [[…], …]` for a table of wind over time.
fn wind_table(path: &Path, reference_length_m: f64) -> Result<String, String> {
    let text = std::fs::read_to_string(path)
        .map_err(|reason| format!("a readable table of wind ({}: {reason})", path.display()))?;
    let table = read_wind_table(&text, reference_length_m).map_err(|fault| {
        format!("a table in the columns of AeroDyn's uniform wind files ({}: {fault})", path.display())
    })?;
    let row = |row: &TableRow| {
        // the angle in degrees as written in the file, without the round-off of the conversion from radians
        let direction_deg = (row.direction_rad.to_degrees() * 1e9).round() / 1e9;
        let shears = [row.horizontal_shear, row.power_exponent, row.vertical_shear, row.gust_m_s];
        let values = [row.time_s, row.speed_m_s, direction_deg, row.vertical_m_s].into_iter().chain(shears);
        format!("[{}]", values.map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", "))
    };
    Ok(format!("table = [{}]", table.rows.iter().map(row).collect::<Vec<_>>().join(", ")))
}

/// Text `field = "…"` for a full-field wind file of TurbSim or Bladed; the summary of a Bladed field, `.sum`, must agree with its settings.
fn wind_field(path: &Path, settings: BladedSettings) -> Result<String, String> {
    let shown = path.display();
    let bytes = std::fs::read(path)
        .map_err(|reason| format!("a readable wind field of TurbSim or Bladed ({shown}: {reason})"))?;
    read_field(&bytes, settings)
        .map_err(|fault| format!("a complete wind field of TurbSim (.bts) or Bladed (.wnd) ({shown}: {fault})"))?;
    let summary = path.with_extension("sum");
    if is_bladed(&bytes) && summary.is_file() {
        let text =
            std::fs::read(&summary).map_err(|reason| format!("a .sum file ({}: {reason})", summary.display()))?;
        let read = read_bladed_summary(&String::from_utf8_lossy(&text))
            .map_err(|fault| format!("a .sum file as TurbSim writes it ({}: {fault})", summary.display()))?;
        if let Some(cause) = read.contradiction(&settings) {
            return Err(format!("settings that agree with the .sum file of the field ({shown}: {cause})"));
        }
    }
    Ok(format!("field = \"{}\"", base64::encoded(&bytes)))
}

/// Text `axis = { … }` for a file of an axis.
fn axis(path: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(path)
        .map_err(|reason| format!("a readable file of an axis ({}: {reason})", path.display()))?;
    let table = read_axis(&text)
        .map_err(|fault| format!("an axis as CSV or in BeamDyn's primary file ({}: {fault})", path.display()))?;
    Ok(table.text("axis"))
}

/// Text `rows = [[…], …]` for the first table of a file; the error states the required contents of the file.
fn rows(path: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(path)
        .map_err(|reason| format!("a readable polar file ({}: {reason})", path.display()))?;
    let tables = read_polars(&text)
        .map_err(|fault| format!("a polar in AeroDyn's format or CSV ({}: {fault})", path.display()))?;
    let mut rows = "rows = [".to_owned();
    for (index, row) in tables[0].polar.rows.iter().enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        let angle_deg = row.angle_rad.to_degrees();
        // the angle in degrees as written in the file, without the round-off of the conversion from radians
        let rounded = (angle_deg * 1e9).round() / 1e9;
        write!(rows, "{comma}[{rounded:?}, {:?}, {:?}, {:?}]", row.lift, row.drag, row.moment)
            .map_err(|error| error.to_string())?;
    }
    rows.push(']');
    Ok(rows)
}
