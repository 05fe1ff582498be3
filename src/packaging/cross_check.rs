//! The files that the rules of the FMI Cross-Check (version 4.1) ask of an exporting tool, made from a finished FMU.

use crate::config::Machine;
use crate::packaging::xml::real;
use crate::packaging::{PackageError, Reference, VERSION};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use zip::ZipArchive;

/// Writes `fmus/2.0/cs/<platform>/Foldwing/<version>/<model>/` with FMU, inputs, reference result and options below
/// `folder`, once for each platform that the FMU has a library for. The model's name is that of the FMU's file.
///
/// Returns the folders written.
pub fn cross_check(
    machine: &Machine,
    reference: &Reference,
    fmu: &Path,
    folder: &Path,
) -> Result<Vec<PathBuf>, PackageError> {
    let failed = |path: &Path, source: std::io::Error| PackageError::Write { path: path.to_owned(), source };
    let name = fmu.file_stem().and_then(|stem| stem.to_str()).unwrap_or("model").to_owned();
    let platforms = platforms(fmu).map_err(|source| failed(fmu, source))?;
    // the one with inputs: an importer that reads them wrongly is found out
    let [_, experiment] = &reference.experiments;
    let files = [
        (format!("{name}_ref.csv"), experiment.result.clone()),
        (format!("{name}_in.csv"), experiment.stimuli.clone().unwrap_or_default()),
        (format!("{name}_ref.opt"), options(machine, reference)),
        ("README.md".to_owned(), readme(machine, &name)),
    ];
    let mut written = Vec::new();
    for platform in platforms {
        let target = folder.join("fmus/2.0/cs").join(&platform).join("Foldwing").join(VERSION).join(&name);
        fs::create_dir_all(&target).map_err(|source| failed(&target, source))?;
        let copy = target.join(format!("{name}.fmu"));
        fs::copy(fmu, &copy).map_err(|source| failed(&copy, source))?;
        for (file, text) in &files {
            let path = target.join(file);
            fs::write(&path, text).map_err(|source| failed(&path, source))?;
        }
        written.push(target);
    }
    Ok(written)
}

/// Platforms that an FMU has libraries for.
fn platforms(fmu: &Path) -> std::io::Result<BTreeSet<String>> {
    let archive = ZipArchive::new(File::open(fmu)?)?;
    Ok(archive
        .file_names()
        .filter_map(|name| {
            let name = name.ok()?;
            let (platform, _) = name.strip_prefix("binaries/")?.split_once('/')?;
            Some(platform.to_owned())
        })
        .collect())
}

/// Options in the rules' own form.
fn options(machine: &Machine, reference: &Reference) -> String {
    let experiment = &machine.experiment;
    [
        ("StartTime", experiment.start_time_s),
        ("StopTime", experiment.stop_time_s),
        ("StepSize", reference.step_s),
        ("RelTol", machine.solver.tolerance),
        ("OutputIntervalLength", reference.step_s),
    ]
    .map(|(name, value)| format!("{name}, {}\n", real(value)))
    .concat()
}

fn readme(machine: &Machine, name: &str) -> String {
    format!(
        "# {name}\n\n{}\n\n- FMI 2.0 co-simulation, made by foldwing {VERSION}; no licence check, no further files needed.\n\
         - `{name}_in.csv` moves inputs in triangles: the root accelerates and the outermost station is loaded. Inputs are \
         taken at the beginning of each communication step and held during it.\n\
         - `{name}_ref.csv` was computed by `foldwing package` with the communication step of `{name}_ref.opt`. FMPy repeats \
         it with `simulate_fmu(..., output_interval=StepSize, input=...)`.\n",
        machine.description
    )
}
