//! `foldwing package`: an FMU of a model.

use crate::cli::linearize::reach;
use crate::cli::{Failure, print, read_model};
use foldwing::config::Machine;
use foldwing::interface::{Interface, LinearModel, Variable, guid};
use foldwing::packaging::{self, Extras, PackageError, Reference};
use foldwing::plant::Plant;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// FMU to write
    #[arg(short, long, value_name = "X.fmu", required_unless_present = "description_only")]
    output: Option<PathBuf>,
    /// Shared library to put into the FMU [default: the one beside this executable]
    #[arg(long, value_name = "PATH")]
    library: Option<PathBuf>,
    /// Put the linear model about a state into the FMU: `start`, a time in s, or the equilibrium
    #[arg(long, value_name = "STATE", num_args = 0..=1, require_equals = true, default_missing_value = "equilibrium")]
    linear: Option<String>,
    /// Leave the reference results out: the default experiment is not simulated
    #[arg(long)]
    no_reference: bool,
    /// Also write the files of the FMI Cross-Check below a folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "no_reference")]
    cross_check: Option<PathBuf>,
    /// Print modelDescription.xml and write nothing
    #[arg(long, conflicts_with_all = ["output", "library", "linear", "no_reference", "cross_check"])]
    description_only: bool,
}

/// Writes the FMU, or prints its description.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, text) = read_model(&arguments.model)?;
    let Some(output) = &arguments.output else {
        let interface = Interface::new(&machine);
        let variables = interface.variables();
        return print(&packaging::model_description(&machine, variables, &guid(&text, variables)));
    };
    let library = match &arguments.library {
        Some(path) => path.clone(),
        None => library_beside_executable()?,
    };
    let extras = Extras {
        reference: (!arguments.no_reference).then(|| reference(&machine)).transpose()?,
        linear: arguments.linear.as_ref().map(|at| linear(&machine, at)).transpose()?,
    };
    packaging::package(&machine, &text, &extras, &library, output).map_err(failure)?;
    if let (Some(folder), Some(reference)) = (&arguments.cross_check, &extras.reference) {
        for written in packaging::cross_check(&machine, reference, output, folder).map_err(failure)? {
            print(&format!("cross-check files in {}", written.display()))?;
        }
    }
    Ok(())
}

fn failure(error: PackageError) -> Failure {
    match error {
        PackageError::NotALibrary { .. } => Failure::Refused(error.to_string()),
        PackageError::Library { .. } | PackageError::Write { .. } => Failure::Files(error.to_string()),
    }
}

fn reference(machine: &Machine) -> Result<Reference, Failure> {
    Reference::simulate(machine).map_err(|error| {
        Failure::Simulation(format!(
            "{error}; it was the default experiment, whose result goes into the FMU: mend the model or its [experiment], or \
             package with --no-reference"
        ))
    })
}

/// The linear model between all real inputs and outputs.
fn linear(machine: &Machine, at: &str) -> Result<LinearModel, Failure> {
    let interface = Interface::new(machine);
    let mut plant = Plant::new(Arc::new(machine.clone()));
    reach("--linear", at, &mut plant)?;
    let (inputs, outputs): (Vec<&Variable>, Vec<&Variable>) =
        (interface.real_inputs().collect(), interface.real_outputs().collect());
    interface.linearize(&mut plant, &inputs, &outputs).map_err(|error| Failure::Statics(error.to_string()))
}

fn library_beside_executable() -> Result<PathBuf, Failure> {
    let executable = std::env::current_exe()
        .map_err(|error| Failure::Files(format!("this executable's own path is unknown ({error}); give --library")))?;
    let library = executable.with_file_name(format!("{DLL_PREFIX}foldwing{DLL_SUFFIX}"));
    if library.is_file() {
        Ok(library)
    } else {
        Err(Failure::Files(format!("{}: no library beside this executable; give --library", library.display())))
    }
}
