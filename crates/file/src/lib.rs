//! Reader of the model file: TOML is converted to a [`Machine`], every number is checked, and every error is reported with its line.
//!
//! There are three passes. The text is parsed to a tree in which every key and value has its position (`document`). The tree is
//! compared with the JSON schema derived from the serde structs (`structure`): unknown and missing keys, types, ranges. Conditions on
//! several keys are checked last (`validate` and related modules): the tree of bodies, references, positions, definiteness. Each pass
//! reports all its errors at once.

mod air;
mod air_file;
mod air_keys;
mod air_part_file;
mod air_parts;
mod attachments;
mod base64;
mod beamdyn_file;
mod bladed_summary;
mod body;
mod body_file;
mod checker;
mod copies;
mod dc_motor;
mod document;
mod embedded;
mod error;
mod failure_file;
mod failures;
mod file;
mod freedom_file;
mod freedoms;
mod function;
mod generator;
mod gust;
mod joint_file;
mod joints;
mod json;
mod letters;
mod loops;
mod meant;
mod modal_body;
mod no_slip_file;
mod no_slips;
mod polar_file;
mod reference;
mod renamed;
mod rotor;
mod rotor_file;
mod run;
mod schema;
mod section_files;
mod section_summary;
mod sections;
mod shape_file;
mod shape_warnings;
mod shaped;
pub mod shapes;
mod shear_share;
mod station_file;
mod station_table;
mod stations;
mod structure;
mod validate;
mod warnings;
mod wind_file;

pub use bladed_summary::{BladedSummary, read_bladed_summary};
pub use error::{ConfigError, Fault, Problem};
pub use polar_file::{AirfoilTable, PolarFault, read_aerodyn, read_csv, read_polars};
pub use reference::reference;
pub use schema::schema;
pub use section_files::{FileUnits, condensed_stiffness};
pub use section_summary::{BodySections, SectionAt, section_properties};
pub use station_file::{read_axis, read_sections, read_sections_in};
pub use station_table::{StationFault, StationTable};
pub use warnings::{Warning, warnings, warnings_of_files};
pub use wind_file::{BladedSettings, WindFault, read_bladed, read_field, read_turbsim, read_wind_table, write_turbsim};

use document::Document;
use file::ModelFile;
use foldwing_engine::machine::Machine;
use std::path::Path;

/// Reads a model from the text of a model file. `file_name` is used only in error messages.
///
/// # Errors
/// [`ConfigError::Refused`] with all errors: syntax first, then keys, types and ranges, then conditions on several keys.
pub fn parse(text: &str, file_name: &str) -> Result<Machine, ConfigError> {
    build(text).map_err(|problems| ConfigError::Refused { file: file_name.to_owned(), problems })
}

/// Reads a model file and returns the machine and the file's text with the contents of other files embedded; this text is stored in the
/// resources of an FMU.
///
/// # Errors
/// [`ConfigError::Read`] if the file cannot be read or is not UTF-8; otherwise as [`parse`].
pub fn read(path: impl AsRef<Path>) -> Result<(Machine, String), ConfigError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => {
            let folder = path.parent().unwrap_or(Path::new(""));
            let text = with_files(text, folder, &file)?;
            Ok((parse(&text, &file)?, text))
        }
        Err(source) => Err(ConfigError::Read { file, source }),
    }
}

/// Returns the text of a model file with the contents of the files that it names (polars, sections, axes) embedded; files are searched
/// in `folder`, and line numbers are unchanged.
///
/// # Errors
/// [`ConfigError::Refused`] if a file cannot be read or has invalid contents, at the line of its key.
pub fn with_files(text: String, folder: &Path, file_name: &str) -> Result<String, ConfigError> {
    embedded::with_files(text, folder).map_err(|problems| ConfigError::Refused { file: file_name.to_owned(), problems })
}

/// Returns the text of a model file with the keys of a JSON object, in the same order.
///
/// # Errors
/// A text that is not JSON, is not an object, or contains `null`, which model files do not support; the message states the position.
pub fn text_of_json(json: &str) -> Result<String, String> {
    let tree: toml::Table = serde_json::from_str(json).map_err(|error| error.to_string())?;
    toml::to_string(&tree).map_err(|error| error.to_string())
}

fn build(text: &str) -> Result<Machine, Vec<Problem>> {
    let document = Document::parse(text)?;
    letters::check(&document)?;
    structure::check(&document)?;
    let mut file: ModelFile = toml::from_str(text).map_err(|error| vec![document.syntax_problem(&error)])?;
    let copies = copies::expand(&mut file);
    validate::machine(&file, &document, &copies)
}
