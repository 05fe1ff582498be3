//! `--plot`, `--view` and `--vtk`: pictures of a run.

use crate::cli::Failure;
use foldwing::interface::{Value, Variable};
use foldwing::plant::Plant;
use foldwing::report::Recording;
use foldwing::report::plots::{self, Column};
use foldwing::report::{viewer, vtk};
use std::fs;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct PictureArguments {
    /// Folder for figures as SVG and PNG: fold angles, strains, tip paths, shapes, energies, and the variables of
    /// `--output`
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Page that plays the motion in a browser; one file, no network
    #[arg(long, value_name = "OUT.html")]
    pub view: Option<PathBuf>,
    /// Folder for VTK files of wing and wake over time, for ParaView
    #[arg(long, value_name = "DIR")]
    pub vtk: Option<PathBuf>,
}

/// The pictures in the making.
pub struct Pictures<'a> {
    wanted: &'a PictureArguments,
    /// Variables that were named, with their values so far.
    columns: Vec<Column>,
    recording: Option<Recording>,
    steps: u64,
}

impl<'a> Pictures<'a> {
    /// Pictures of a run of so many steps; `named` are the variables that the caller chose. Makes the folders, so that a
    /// bad place is refused before the run.
    pub fn new(wanted: &'a PictureArguments, steps: u64, named: &[&Variable]) -> Result<Self, Failure> {
        for folder in [&wanted.plot, &wanted.vtk].into_iter().flatten() {
            fs::create_dir_all(folder).map_err(|error| Failure::writing(&folder.display().to_string(), &error))?;
        }
        let column = |variable: &&Variable| Column {
            name: variable.name.clone(),
            unit: variable.unit().to_owned(),
            values: Vec::new(),
        };
        let columns = if wanted.plot.is_some() { named.iter().map(column).collect() } else { Vec::new() };
        Ok(Self { wanted, columns, recording: None, steps })
    }

    fn any(&self) -> bool {
        self.wanted.plot.is_some() || self.wanted.view.is_some() || self.wanted.vtk.is_some()
    }

    /// Takes the plant at one of the `steps + 1` points of the run; `value` reads the variable of a column.
    pub fn include(&mut self, plant: &Plant, value: impl Fn(usize) -> Value) {
        if !self.any() {
            return;
        }
        let recording = self.recording.get_or_insert_with(|| Recording::new(plant, self.steps));
        recording.include(plant);
        if recording.has_point() {
            for (i, column) in self.columns.iter_mut().enumerate() {
                column.values.push(match value(i) {
                    Value::Real(value) => value,
                    Value::Integer(value) => f64::from(value),
                    Value::Boolean(value) => f64::from(u8::from(value)),
                });
            }
        }
    }

    /// Writes what was asked for, up to where the run has come.
    pub fn write(&self) -> Result<(), Failure> {
        let Some(recording) = &self.recording else { return Ok(()) };
        if let Some(folder) = &self.wanted.plot {
            self.write_plots(folder, recording)?;
        }
        if let Some(path) = &self.wanted.view {
            let failed = |error| Failure::writing(&path.display().to_string(), &error);
            fs::write(path, viewer::page(recording)).map_err(failed)?;
        }
        if let Some(folder) = &self.wanted.vtk {
            vtk::write(folder, recording).map_err(|error| Failure::writing(&folder.display().to_string(), &error))?;
        }
        Ok(())
    }

    fn write_plots(&self, folder: &Path, recording: &Recording) -> Result<(), Failure> {
        let failed = |error| Failure::Files(format!("{}: {error}", folder.display()));
        for (stem, figure) in plots::figures(recording) {
            plots::write(folder, stem, &figure).map_err(failed)?;
        }
        let chosen = plots::columns(&recording.scene.name, &recording.history.time_s, &self.columns);
        for (i, figure) in chosen.iter().enumerate() {
            plots::write(folder, &format!("outputs_{}", i + 1), figure).map_err(failed)?;
        }
        Ok(())
    }
}
