//! An FMU, unpacked into a folder that goes with it.

use crate::import::description::Description;
use crate::import::description_file::Root;
use crate::import::error::ImportError;
use crate::import::image::check_images;
use crate::import::slave::Slave;
use crate::import::unpack::unpack;
use fmi::fmi2::binding::Fmi2Binding;
use fmi::fmi2::import::Fmi2Import;
use fmi::traits::FmiImport;
use quick_xml::escape::escape;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zip::ZipArchive;
use zip::result::ZipError;

/// The member that makes an archive an FMU.
const DESCRIPTION: &str = "modelDescription.xml";

/// Bytes of a description that are read: hundreds of thousands of variables.
const LONGEST_DESCRIPTION: u64 = 1 << 28;

/// An FMI 2.0 co-simulation FMU whose library is there and loads.
#[derive(Debug)]
pub struct Fmu {
    path: PathBuf,
    description: Description,
    import: Fmi2Import,
}

impl Fmu {
    /// Description of an FMU, and whether it can be run at all; nothing is unpacked or loaded.
    ///
    /// # Errors
    /// All but those of [`Fmu::open`] about the library.
    pub fn describe(path: &Path) -> Result<Description, ImportError> {
        Ok(read(path)?.1)
    }

    /// Unpacks an FMU into a folder, which goes with it, and looks for its library.
    ///
    /// # Errors
    /// A file that cannot be read, is no FMU, is of another version or kind, or has no library for this platform, one
    /// that does not load, or one that lacks a function.
    pub fn open(path: &Path, folder: TempDir) -> Result<Self, ImportError> {
        let (mut archive, description) = read(path)?;
        unpack(path, &mut archive, folder.path())?;
        let import = import(folder, &description);
        check_library(path, &import, &description.identifier)?;
        Ok(Self { path: path.to_owned(), description, import })
    }

    /// What it says of itself.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// A new instance; `logging` switches its messages on.
    ///
    /// # Errors
    /// [`ImportError::NotInstantiated`]; why is told in the FMU's messages.
    pub fn instantiate(&self, name: &str, logging: bool) -> Result<Slave, ImportError> {
        let visible = false;
        let instance = self.import.instantiate_cs(name, visible, logging);
        let instance = instance.map_err(|_| ImportError::NotInstantiated { path: self.path.clone() })?;
        Ok(Slave::new(instance))
    }
}

/// The archive and its description.
fn read(path: &Path) -> Result<(ZipArchive<File>, Description), ImportError> {
    let failed = |source: io::Error| ImportError::File { path: path.to_owned(), source };
    let not_an_fmu = |cause: String| ImportError::NotAnFmu { path: path.to_owned(), cause };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(not_an_fmu("a folder".to_owned()));
    }
    let mut archive = ZipArchive::new(file).map_err(|error| of_archive(path, error))?;
    let mut text = String::new();
    let member = archive.by_name(DESCRIPTION).map_err(|_| not_an_fmu(format!("no {DESCRIPTION} in the archive")))?;
    if member.size() > LONGEST_DESCRIPTION {
        return Err(not_an_fmu(format!(
            "{DESCRIPTION}: {} bytes; at most {LONGEST_DESCRIPTION} are read",
            member.size()
        )));
    }
    let read = member.take(LONGEST_DESCRIPTION).read_to_string(&mut text);
    read.map_err(|error| not_an_fmu(format!("{DESCRIPTION}: {error}")))?;
    let root: Root = quick_xml::de::from_str(text.trim_start_matches('\u{feff}'))
        .map_err(|error| not_an_fmu(format!("{DESCRIPTION}: {error}")))?;
    match root.version.as_deref() {
        Some("2.0") => {}
        Some(found) => return Err(ImportError::Version { path: path.to_owned(), found: found.to_owned() }),
        None => return Err(not_an_fmu(format!("{DESCRIPTION}: no attribute fmiVersion"))),
    }
    if root.co_simulation.is_none() {
        return Err(ImportError::NoCoSimulation { path: path.to_owned() });
    }
    let description = Description::new(root).map_err(|cause| not_an_fmu(format!("{DESCRIPTION}: {cause}")))?;
    Ok((archive, description))
}

pub(super) fn of_archive(path: &Path, error: ZipError) -> ImportError {
    match error {
        ZipError::Io(source) => ImportError::File { path: path.to_owned(), source },
        error => ImportError::NotAnFmu { path: path.to_owned(), cause: error.to_string() },
    }
}

/// Hands the folder to the crate `fmi` with as much of the description as it needs to instantiate: its own reader
/// refuses attributes that the standard allows.
fn import(folder: TempDir, description: &Description) -> Fmi2Import {
    let [name, guid, identifier] = [&description.model_name, &description.guid, &description.identifier].map(escape);
    let text = format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" guid=\"{guid}\"><CoSimulation \
         modelIdentifier=\"{identifier}\"/></fmiModelDescription>"
    );
    Fmi2Import::new(folder, &text).expect("three texts in attributes, escaped")
}

/// Refuses what would otherwise stop the program in the middle of a run.
fn check_library(path: &Path, import: &Fmi2Import, identifier: &str) -> Result<(), ImportError> {
    let library = import.shared_lib_path(identifier).map(|path| path.display().to_string());
    let library = library.unwrap_or_else(|error| error.to_string());
    let file = import.archive_path().join(&library);
    if !file.is_file() {
        let found = platforms(&import.archive_path().join("binaries"));
        return Err(ImportError::NoLibrary { path: path.to_owned(), expected: library, found });
    }
    let cut = |(file, cause)| ImportError::Library { path: path.to_owned(), library: file, cause };
    check_images(file.parent().unwrap_or(&file)).map_err(cut)?;
    match import.binding(identifier) {
        Ok(binding) => match missing_function(&binding) {
            Some(function) => Err(ImportError::NoFunction { path: path.to_owned(), library, function }),
            None => Ok(()),
        },
        Err(error) => Err(ImportError::Library { path: path.to_owned(), library, cause: error.to_string() }),
    }
}

/// Folders of `binaries` by name.
fn platforms(binaries: &Path) -> String {
    let entries = fs::read_dir(binaries).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    if names.is_empty() { "no libraries at all".to_owned() } else { names.join(", ") }
}

/// The first function that runs need and the library lacks: the bindings would panic in its place.
fn missing_function(binding: &Fmi2Binding) -> Option<&'static str> {
    macro_rules! first_missing {
        ($($function:ident),* $(,)?) => { [$((binding.$function.is_err(), stringify!($function))),*] };
    }
    first_missing![
        fmi2Instantiate,
        fmi2FreeInstance,
        fmi2SetupExperiment,
        fmi2EnterInitializationMode,
        fmi2ExitInitializationMode,
        fmi2Terminate,
        fmi2GetReal,
        fmi2GetInteger,
        fmi2GetBoolean,
        fmi2GetString,
        fmi2SetReal,
        fmi2SetInteger,
        fmi2SetBoolean,
        fmi2SetString,
        fmi2DoStep,
        fmi2GetRealStatus,
        fmi2GetBooleanStatus,
    ]
    .into_iter()
    .find_map(|(missing, function)| missing.then_some(function))
}
