//! `--compare`: other runs and measurements overlaid on the page of `--view`.

use crate::cli::grid::Grid;
use crate::cli::settings::plant_with;
use crate::cli::{Failure, read_model};
use crate::report::viewer::{Companion, PackedRun, Table, run_of_page};
use foldwing_fmi::interface::Interface;
use foldwing_recording::Run;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Type of a file, determined by its extension.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Model,
    Page,
    Table,
}

fn kind(path: &Path) -> Result<Kind, Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "toml" => Ok(Kind::Model),
        "html" | "htm" => Ok(Kind::Page),
        "csv" => Ok(Kind::Table),
        _ => Err(Failure::Usage(format!(
            "--compare {}: must be a model file (.toml), a page of --view (.html) or a table over time (.csv)",
            path.display()
        ))),
    }
}

/// Returns the number of runs on the page: this one, and one for each model or page to compare.
pub(super) fn runs(paths: &[PathBuf]) -> Result<usize, Failure> {
    paths.iter().try_fold(1, |runs, path| Ok(runs + usize::from(kind(path)? != Kind::Table)))
}

/// Reads the data to overlay; models are simulated with the same communication points.
pub(super) fn companions(paths: &[PathBuf], grid: &Grid, frames: u64) -> Result<Vec<Companion>, Failure> {
    let runs = runs(paths)?;
    paths.iter().map(|path| companion(path, grid, frames, runs)).collect()
}

fn companion(path: &Path, grid: &Grid, frames: u64, runs: usize) -> Result<Companion, Failure> {
    let name = path.display().to_string();
    let unreadable = |error: std::io::Error| Failure::Files(format!("{name}: cannot be read: {error}"));
    let refused = |cause: String| Failure::Refused(format!("{name}: {cause}"));
    let label = path.file_name().map_or_else(|| name.clone(), |file| file.to_string_lossy().into_owned());
    Ok(match kind(path)? {
        Kind::Table => {
            let file = File::open(path).map_err(unreadable)?;
            Companion::Table { label, table: Table::read(file).map_err(refused)? }
        }
        Kind::Page => {
            let text = std::fs::read_to_string(path).map_err(unreadable)?;
            Companion::Run { label, run: run_of_page(&text).map_err(refused)? }
        }
        Kind::Model => Companion::Run { label, run: simulated(path, grid, frames, runs)? },
    })
}

/// Simulates a model with the start values of its file and without input tables.
fn simulated(path: &Path, grid: &Grid, frames: u64, runs: usize) -> Result<PackedRun, Failure> {
    let (machine, _) = read_model(path)?;
    let interface = Interface::new(&machine);
    let plant = plant_with(machine, &interface, &[])?;
    let failed = |error: foldwing_engine::plant::PlantError| {
        Failure::Simulation(format!("--compare {}: {error}", path.display()))
    };
    let mut run = Run::start(plant, interface, *grid, frames).map_err(failed)?;
    while !run.is_finished() {
        run.advance().map_err(failed)?;
    }
    Ok(run.packed(runs))
}
