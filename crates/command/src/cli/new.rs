//! `foldwing new`: a commented model file to start from.

use crate::cli::outlets::{Mark, Outlets};
use crate::cli::{Failure, print};
use foldwing_file as config;
use std::path::{Path, PathBuf};

/// The starter, itself a valid model. [`NAME`] and [`FILE`] are placeholders for the names of the model and of its file.
const STARTER: &str = include_str!("starter.toml");

/// Name of the schema file beside the model, as in the first line of [`STARTER`].
const SCHEMA: &str = "foldwing.schema.json";

/// Beginning of the line of [`STARTER`] with the model's name.
const NAME: &str = "name = \"MyWing\"";

/// Placeholder for the file's name in [`STARTER`].
const FILE: &str = "MODEL";

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::NEW)]
pub struct Arguments {
    /// Model file to write; its name becomes the model's
    model: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Do not write the schema, which lets editors complete and check the file
    #[arg(long)]
    no_schema: bool,
}

/// Writes the starter and, beside it, the schema given in its first line.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &arguments.model;
    let shown = path.display();
    let stem = path.file_stem().filter(|_| !path.to_string_lossy().ends_with(['/', '\\']));
    let Some(name) = stem.map(|stem| identifier(&stem.to_string_lossy())) else {
        return Err(Failure::Usage(format!("{shown}: is not a file name; allowed: a path such as wings/mywing.toml")));
    };
    if path.extension().is_none_or(|extension| extension != "toml") {
        return Err(Failure::Usage(format!(
            "{shown}: a model file ends in .toml; write {}",
            path.with_extension("toml").display()
        )));
    }
    let mut outlets = Outlets::new(arguments.force, []);
    let model = outlets.place(path, Mark::Never)?;
    let own_name = path.file_name().map(Path::new).unwrap_or(path);
    let mut text = STARTER.replace(FILE, &quoted(own_name)).replacen(NAME, &format!("name = \"{name}\""), 1);
    let schema = path.with_file_name(SCHEMA);
    if arguments.no_schema {
        text = text.split_once("\n\n").map_or(text.clone(), |(_, rest)| rest.to_owned());
    }
    // the schema first: if it cannot be written, no model file is left behind
    let mut written = shown.to_string();
    if !arguments.no_schema && !holds(&schema, &config::schema()) {
        let place = outlets.place(&schema, Mark::SCHEMA).map_err(|failure| {
            if let Failure::Files(message) = failure {
                Failure::Files(format!("{message}, --no-schema leaves it as it is"))
            } else {
                failure
            }
        })?;
        place.fill(config::schema().as_bytes())?;
        written = format!("{written} and {}", schema.display());
    }
    model.fill(text.as_bytes())?;
    print(&format!("wrote {written}; type next:\n{}", commands(path)))
}

/// The commands in the head of the starter, for a model at a path.
fn commands(path: &Path) -> String {
    let lines = STARTER.lines().filter_map(|line| line.strip_prefix("#   foldwing "));
    lines.map(|line| format!("  foldwing {}\n", line.replace(FILE, &quoted(path)))).collect()
}

/// Returns whether the file has this text.
fn holds(path: &Path, text: &str) -> bool {
    std::fs::read(path).is_ok_and(|found| found == text.as_bytes())
}

/// A path as a shell argument: quoted if it has spaces, always on one line.
fn quoted(path: &Path) -> String {
    let text: String = path.display().to_string().chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.contains(' ') { format!("\"{text}\"") } else { text }
}

/// Model name: the letters, digits and `_` of the file's name, other characters replaced by `_`, no digit first.
fn identifier(stem: &str) -> String {
    let name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(|first: char| first.is_ascii_digit()) { format!("wing_{name}") } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_become_identifiers() {
        for (stem, name) in [("mywing", "mywing"), ("my wing-2", "my_wing_2"), ("2wings", "wing_2wings"), ("é", "_")] {
            assert_eq!(identifier(stem), name);
        }
    }

    /// Each placeholder occurs where it is expected and nowhere else.
    #[test]
    fn the_starter_has_its_placeholders() {
        assert_eq!(STARTER.matches(&format!("\n{NAME}")).count(), 1);
        assert_eq!(STARTER.matches(FILE).count(), STARTER.matches("foldwing ").count());
        assert!(STARTER.starts_with(&format!("#:schema ./{SCHEMA}\n\n")));
    }

    /// Every key of the starter is explained: by a comment on its line, or by a line above that begins with its name.
    #[test]
    fn every_key_of_the_starter_is_explained() {
        let lines: Vec<&str> = STARTER.lines().collect();
        for (number, line) in lines.iter().enumerate() {
            let code = line.strip_prefix('#').filter(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()));
            let Some((key, value)) = code.unwrap_or(line).split_once(" = ") else { continue };
            if line.starts_with("# ") || !key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
                continue;
            }
            let inside =
                value.split(['{', ',', '}']).filter_map(|part| part.split_once(" = ")).map(|(key, _)| key.trim());
            let keys: Vec<&str> = if value.starts_with('{') { inside.collect() } else { vec![key] };
            for key in keys {
                let above = lines[..number].iter().any(|line| {
                    let words = line.trim_start_matches('#').trim_start();
                    line.starts_with('#') && words.starts_with(&format!("{key}  "))
                        || line.contains(&format!("{key} = ")) && line.contains("  # ")
                });
                assert!(line.contains("  # ") || above, "line {}: {key} is not explained", number + 1);
            }
        }
    }
}
