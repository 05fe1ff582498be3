//! Files that the rules of the FMI Cross-Check (version 4.1) require from an exporting tool, generated from a finished
//! FMU.

use crate::packaging::xml::real;
use crate::packaging::{Library, Reference, VERSION};
use foldwing_engine::machine::Machine;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Contribution of one platform to the cross-check: its folder, and its files by name.
pub type Submission<'a> = (PathBuf, Vec<(String, &'a [u8])>);

/// Text files of the cross-check, identical for all platforms.
pub struct CrossCheck {
    name: String,
    texts: [(String, String); 4],
}

impl CrossCheck {
    /// Creates inputs, reference result, options and a page for a model with the name `name`, which is the FMU's file
    /// name.
    pub fn new(machine: &Machine, reference: &Reference, name: &str) -> Self {
        // use the experiment with inputs, which shows whether an importer reads them correctly
        let [_, experiment] = &reference.experiments;
        let texts = [
            (format!("{name}_ref.csv"), experiment.result.clone()),
            (format!("{name}_in.csv"), experiment.stimuli.clone().unwrap_or_default()),
            (format!("{name}_ref.opt"), options(machine, reference)),
            ("README.md".to_owned(), readme(machine, name)),
        ];
        Self { name: name.to_owned(), texts }
    }

    /// Folder `fmus/2.0/cs/<platform>/Foldwing/<version>/<model>/` with its files, for each platform of the FMU `fmu`.
    pub fn submissions<'a>(&'a self, libraries: &[Library], fmu: &'a [u8]) -> Vec<Submission<'a>> {
        let platforms: BTreeSet<&str> = libraries.iter().map(|library| library.platform.folder).collect();
        let folder = |platform| ["fmus/2.0/cs", platform, "Foldwing", VERSION, &self.name].iter().collect();
        let files = || {
            let texts = self.texts.iter().map(|(name, text)| (name.clone(), text.as_bytes()));
            std::iter::once((format!("{}.fmu", self.name), fmu)).chain(texts).collect()
        };
        platforms.into_iter().map(|platform| (folder(platform), files())).collect()
    }
}

/// Options in the format that the rules require.
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
