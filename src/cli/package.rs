//! `foldwing package`: an FMU of a model.

use crate::cli::{Failure, print, read_model};
use foldwing::interface::{Interface, guid};
use foldwing::packaging::{self, PackageError};
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::PathBuf;

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
    /// Print modelDescription.xml and write nothing
    #[arg(long, conflicts_with_all = ["output", "library"])]
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
    packaging::package(&machine, &text, &library, output).map_err(|error| match error {
        PackageError::NotALibrary { .. } => Failure::Refused(error.to_string()),
        PackageError::Library { .. } | PackageError::Write { .. } => Failure::Files(error.to_string()),
    })
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
