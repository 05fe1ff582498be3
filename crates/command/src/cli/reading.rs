//! Models and files that commands read, and text on standard output.

use crate::cli::Failure;
use crate::cli::tell;
use foldwing_engine::machine::Machine;
use foldwing_file as config;
use std::io::{self, Read, Write};
use std::path::Path;

/// Writes text to standard output, with a final line feed.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    writeln!(out, "{}", text.trim_end())
        .and_then(|()| out.flush())
        .map_err(|error| Failure::writing("standard output", &error))
}

/// Reads a model and its text.
pub(super) fn read_model(path: &Path) -> Result<(Machine, String), Failure> {
    let shown = shown(path);
    let bytes = read_bytes(path)?;
    if bytes.starts_with(b"PK\x03\x04") {
        return Err(Failure::Refused(format!(
            "{shown}: is a ZIP archive such as an FMU, not a model file; `foldwing run` runs FMUs"
        )));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let line = error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
        Failure::Refused(format!("{shown}:{}: a model file is UTF-8 text; this line is not", line + 1))
    })?;
    // standard input has an empty parent: paths are relative to the working directory
    let folder = path.parent().unwrap_or(Path::new(""));
    let lost = config::warnings_of_files(&text, folder);
    let text = match config::with_files(text.clone(), folder, &shown) {
        Ok(text) => text,
        Err(error) => return Err(Failure::Model { text, error }),
    };
    match config::parse(&text, &shown) {
        Ok(machine) => {
            lost.iter()
                .chain(&config::warnings(&text))
                .for_each(|warning| tell::warning_about_key(&shown, &text, warning));
            Ok((machine, text))
        }
        Err(error) => Err(Failure::Model { text, error }),
    }
}

/// Name of a file in messages; `-` is standard input.
pub(super) fn shown(path: &Path) -> String {
    if path == Path::new("-") { "<standard input>".to_owned() } else { path.display().to_string() }
}

/// Reads a whole file, or standard input if the path is `-`.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = match path == Path::new("-") {
        true => io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes),
        false => std::fs::read(path),
    };
    read.map_err(|error| Failure::Files(format!("{}: cannot be read: {error}", shown(path))))
}
