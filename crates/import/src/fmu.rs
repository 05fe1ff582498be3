//! FMU that is unpacked into a temporary folder.

use crate::description::Description;
use crate::description_file::Root;
use crate::description3::Root3;
use crate::error::{ImportError, of_archive};
use crate::image::check_images;
use crate::slave::Slave;
use crate::slave2::Slave2;
use crate::slave3::Slave3;
use crate::unpack::unpack;
use fmi::fmi2::binding::Fmi2Binding;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi3::Fmi3Model;
use fmi::fmi3::binding::Fmi3Binding;
use fmi::fmi3::import::Fmi3Import;
use fmi::traits::FmiImport;
use quick_xml::escape::escape;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zip::ZipArchive;

/// Member of the archive that identifies an FMU.
const DESCRIPTION: &str = "modelDescription.xml";

/// Maximum size of a description in bytes, sufficient for hundreds of thousands of variables.
const LONGEST_DESCRIPTION: u64 = 1 << 28;

/// A co-simulation FMU whose library is present and can be loaded.
#[derive(Debug)]
pub struct Fmu {
    path: PathBuf,
    description: Description,
    import: Import,
}

/// The folder of the FMU, loaded by the crate `fmi`.
#[derive(Debug)]
enum Import {
    Fmi2(Fmi2Import),
    Fmi3(Fmi3Import),
}

impl Fmu {
    /// Reads the description of an FMU and checks whether it can be run, without unpacking or loading anything.
    ///
    /// # Errors
    /// As for [`Fmu::open`], except errors of the library.
    pub fn describe(path: &Path) -> Result<Description, ImportError> {
        Ok(read(path)?.description)
    }

    /// Unpacks an FMU into a folder, which is removed with this value, and checks its library.
    ///
    /// # Errors
    /// The file cannot be read, is not an FMU, has another version or interface type, or its library for this platform is missing, cannot
    /// be loaded or lacks a function.
    pub fn open(path: &Path, folder: TempDir) -> Result<Self, ImportError> {
        let Archived { mut archive, third, description } = read(path)?;
        unpack(path, &mut archive, folder.path())?;
        let identifier = &description.identifier;
        let import = if third {
            beside_resources(folder.path()).map_err(|source| ImportError::File { path: path.to_owned(), source })?;
            let import = of_fmi3(folder, &description);
            check_library(path, &import, identifier, missing_function_of_fmi3)?;
            Import::Fmi3(import)
        } else {
            let import = of_fmi2(folder, &description);
            check_library(path, &import, identifier, missing_function)?;
            Import::Fmi2(import)
        };
        Ok(Self { path: path.to_owned(), description, import })
    }

    /// Returns the model description.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Returns a new instance; `logging` enables its messages.
    ///
    /// # Errors
    /// [`ImportError::NotInstantiated`]; the FMU's messages state the cause.
    pub fn instantiate(&self, name: &str, logging: bool) -> Result<Slave, ImportError> {
        let visible = false;
        let none = |function| ImportError::NotInstantiated { path: self.path.clone(), function };
        match &self.import {
            Import::Fmi2(import) => {
                let instance = import.instantiate_cs(name, visible, logging);
                Ok(Slave::Fmi2(Slave2::new(instance.map_err(|_| none("fmi2Instantiate"))?)))
            }
            Import::Fmi3(import) => {
                let (event_mode, early_return) = (false, false);
                let instance = import.instantiate_cs(name, visible, logging, event_mode, early_return, &[]);
                let instance = instance.map_err(|_| none("fmi3InstantiateCoSimulation"))?;
                Ok(Slave::Fmi3(Slave3::new(instance, &self.description.variables)))
            }
        }
    }
}

/// An opened archive with its description.
struct Archived {
    archive: ZipArchive<File>,
    /// Whether the version is FMI 3.0.
    third: bool,
    description: Description,
}

/// Opens the archive and reads its description.
fn read(path: &Path) -> Result<Archived, ImportError> {
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
    let text = text.trim_start_matches('\u{feff}');
    let of_text = |error: quick_xml::DeError| not_an_fmu(format!("{DESCRIPTION}: {error}"));
    let root: Root = quick_xml::de::from_str(text).map_err(of_text)?;
    let third = match root.version.as_deref() {
        Some("2.0") => None,
        // versions 3.0.1 and 3.0.2 also write 3.0; later minor versions keep the functions
        Some(version) if is_third(version) => Some(quick_xml::de::from_str::<Root3>(text).map_err(of_text)?),
        Some(found) => return Err(ImportError::Version { path: path.to_owned(), found: found.to_owned() }),
        None => return Err(not_an_fmu(format!("{DESCRIPTION}: no attribute fmiVersion"))),
    };
    if root.co_simulation.is_none() {
        return Err(ImportError::NoCoSimulation { path: path.to_owned() });
    }
    let is_third = third.is_some();
    let description = Description::new(root, third).map_err(|cause| not_an_fmu(format!("{DESCRIPTION}: {cause}")))?;
    Ok(Archived { archive, third: is_third, description })
}

/// Returns whether this is a released version of FMI 3: `3.0`, `3.1`, but not `3.0-beta.2`.
fn is_third(version: &str) -> bool {
    version.strip_prefix("3.").is_some_and(|minor| minor.split('.').all(|part| part.parse::<u32>().is_ok()))
}

/// The crate passes the path of the resources without the trailing separator that the standard requires, and some FMUs append the name of a
/// file directly. This makes the files available next to the folder, too.
fn beside_resources(folder: &Path) -> io::Result<()> {
    fn link(from: &Path, to: &Path) -> io::Result<()> {
        if from.is_dir() {
            fs::create_dir_all(to)?;
            let mut entries = fs::read_dir(from)?;
            return entries
                .try_for_each(|entry| entry.and_then(|entry| link(&entry.path(), &to.join(entry.file_name()))));
        }
        fs::hard_link(from, to).or_else(|_| fs::copy(from, to).map(|_| ()))
    }
    let resources = folder.join("resources");
    if !resources.is_dir() {
        return fs::create_dir_all(&resources);
    }
    for entry in fs::read_dir(&resources)? {
        let entry = entry?;
        let mut beside = resources.clone().into_os_string();
        beside.push(entry.file_name());
        link(&entry.path(), Path::new(&beside))?;
    }
    Ok(())
}

/// Passes the folder to the crate `fmi` with a minimal description, sufficient to instantiate the FMU, because the crate's own parser
/// rejects attributes that the standard allows.
fn of_fmi2(folder: TempDir, description: &Description) -> Fmi2Import {
    let [name, guid, identifier] = [&description.model_name, &description.guid, &description.identifier].map(escape);
    let text = format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" guid=\"{guid}\"><CoSimulation \
         modelIdentifier=\"{identifier}\"/></fmiModelDescription>"
    );
    Fmi2Import::new(folder, &text).expect("three texts in attributes, escaped")
}

/// Like [`of_fmi2`], for FMI 3.0.
fn of_fmi3(folder: TempDir, description: &Description) -> Fmi3Import {
    let [name, token, identifier] = [&description.model_name, &description.guid, &description.identifier].map(escape);
    let text = format!(
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" instantiationToken=\"{token}\"><CoSimulation \
         modelIdentifier=\"{identifier}\"/><ModelVariables/><ModelStructure/></fmiModelDescription>"
    );
    Fmi3Import::new(folder, &text).expect("three texts in attributes, escaped")
}

/// Returns an error for libraries that would otherwise abort the program during a run.
fn check_library<I: FmiImport>(
    path: &Path,
    import: &I,
    identifier: &str,
    missing_function: fn(&I::Binding) -> Option<&'static str>,
) -> Result<(), ImportError> {
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

/// Names of the folders in `binaries`.
fn platforms(binaries: &Path) -> String {
    let entries = fs::read_dir(binaries).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    if names.is_empty() { "no libraries at all".to_owned() } else { names.join(", ") }
}

/// Returns the first required function that the library lacks; the bindings would panic when calling it.
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

/// Like [`missing_function`], for FMI 3.0.
fn missing_function_of_fmi3(binding: &Fmi3Binding) -> Option<&'static str> {
    macro_rules! first_missing {
        ($($function:ident),* $(,)?) => { [$((binding.$function.is_err(), stringify!($function))),*] };
    }
    first_missing![
        fmi3InstantiateCoSimulation,
        fmi3FreeInstance,
        fmi3EnterInitializationMode,
        fmi3ExitInitializationMode,
        fmi3Terminate,
        fmi3DoStep,
        fmi3GetFloat32,
        fmi3GetFloat64,
        fmi3GetInt8,
        fmi3GetUInt8,
        fmi3GetInt16,
        fmi3GetUInt16,
        fmi3GetInt32,
        fmi3GetUInt32,
        fmi3GetInt64,
        fmi3GetUInt64,
        fmi3GetBoolean,
        fmi3GetString,
        fmi3SetFloat32,
        fmi3SetFloat64,
        fmi3SetInt8,
        fmi3SetUInt8,
        fmi3SetInt16,
        fmi3SetUInt16,
        fmi3SetInt32,
        fmi3SetUInt32,
        fmi3SetInt64,
        fmi3SetUInt64,
        fmi3SetBoolean,
        fmi3SetString,
    ]
    .into_iter()
    .find_map(|(missing, function)| missing.then_some(function))
}
