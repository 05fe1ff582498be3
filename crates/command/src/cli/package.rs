//! `foldwing package`: an FMU of a model.

use crate::cli::linearize::reach;
use crate::cli::outlets::{Force, Mark, Outlets, Quiet};
use crate::cli::progress::Progress;
use crate::cli::{Failure, print, read_model};
use crate::packaging::{self, CrossCheck, Extras, Kinds, Library, PackageError, Platform, Reference};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::Plant;
use foldwing_fmi::instance::Version;
use foldwing_fmi::interface::{Interface, LinearModel, Variable};
use serde_json::json;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::PACKAGE)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// FMU to write [default: the model's name with .fmu, in this folder]
    #[arg(short, long, value_name = "X.fmu")]
    output: Option<PathBuf>,
    /// Shared library to include in the FMU, as PATH or PLATFORM=PATH, such as linux64=PATH; may be repeated, once for each platform.
    /// Without PLATFORM it is read from the header of the library [default: the library next to this executable]
    #[arg(long = "library", value_name = "[PLATFORM=]PATH")]
    libraries: Vec<OsString>,
    /// Interface types, one or both: co-simulation, where the FMU integrates the equations, and Model Exchange, where the importer
    /// integrates them
    #[arg(long = "interface", value_enum, value_delimiter = ',', default_values_t = [Kind::Cs])]
    kinds: Vec<Kind>,
    /// Version of FMI; with 3, stations and vectors are arrays, latch closings are events, and reference results are omitted
    #[arg(long, value_name = "VERSION", default_value = "2", value_parser = ["2", "3"])]
    fmi: String,
    /// With --fmi 3, use scalar variables with the names of FMI 2.0 instead of arrays, for importers that do not support arrays
    #[arg(long)]
    scalars: bool,
    /// With --interface me, add the work of the inputs and the dissipated energy as continuous states and as outputs. No derivative
    /// depends on them: SciPy's BDF and other integrators that compute the Jacobian by finite differences in every state may fail with them
    #[arg(long)]
    accounts: bool,
    /// Declare outputs that are not Real, such as `fold.latched`, as local variables, for importers that take every output for Real (CasADi)
    #[arg(long)]
    real_outputs_only: bool,
    /// Add the linear model about a state: `start`, a time in s, or `equilibrium`, which is used if no state is given
    #[arg(long, value_name = "STATE", num_args = 0..=1, require_equals = true, default_missing_value = "equilibrium")]
    linear: Option<String>,
    /// Also write a system of this FMU alone (SSP 1.0) with its parameters in files of their own: values (SSV), angles in degrees, and
    /// their mapping onto the variables of the FMU (SSM)
    #[arg(long, value_name = "X.ssp")]
    ssp: Option<PathBuf>,
    /// Omit the reference results; the model is then not simulated
    #[arg(long)]
    no_reference: bool,
    /// Also write the files of the FMI Cross-Check into a folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "no_reference")]
    cross_check: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
    /// Print name, FMI version, interfaces, platforms and the written files as JSON for programs
    #[arg(long)]
    json: bool,
    /// Print modelDescription.xml and write nothing
    #[arg(long, conflicts_with_all = ["output", "libraries", "linear", "ssp", "no_reference", "cross_check", "json"])]
    description_only: bool,
}

/// A kind of FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    /// Co-simulation
    Cs,
    /// Model Exchange
    Me,
}

/// Writes the FMU, or prints its description.
pub fn run(arguments: &Arguments, library: Option<&Path>) -> Result<(), Failure> {
    let (machine, text) = read_model(&arguments.model)?;
    let has = |kind| arguments.kinds.contains(&kind);
    let version = if arguments.fmi == "3" { Version::Fmi3 } else { Version::Fmi2 };
    let kinds = Kinds {
        version,
        co_simulation: has(Kind::Cs),
        model_exchange: has(Kind::Me),
        scalars: arguments.scalars,
        accounts: arguments.accounts,
        real_outputs_only: arguments.real_outputs_only,
    };
    check_kinds(kinds, &machine)?;
    if arguments.cross_check.is_some() && !kinds.co_simulation {
        let cause = "--cross-check: its files are for co-simulation; add cs to --interface";
        return Err(Failure::Usage(cause.to_owned()));
    }
    if arguments.cross_check.is_some() && version == Version::Fmi3 {
        let cause = "--cross-check: its files are for FMI 2.0; leave out --fmi 3";
        return Err(Failure::Usage(cause.to_owned()));
    }
    check_arrays(arguments.ssp.as_deref(), kinds)?;
    if arguments.description_only {
        return print(&kinds.model_description(&machine, &kinds.interface(&machine), &text));
    }
    let output = &arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.fmu", machine.name)));
    check_name(output)?;
    check_system(arguments.ssp.as_deref(), kinds)?;
    let sources = sources(&arguments.libraries, library)?;
    let read = std::iter::once(arguments.model.as_path()).chain(sources.iter().map(|(_, path)| path.as_path()));
    let mut outlets = Outlets::new(arguments.force.force, read);
    let order = Order {
        kinds,
        output,
        ssp: arguments.ssp.as_deref(),
        libraries: &sources,
        linear: arguments.linear.as_deref(),
        without_reference: arguments.no_reference,
        shows_progress: true,
    };
    let Packaged { fmu, extras, libraries } = write(&machine, &text, &order, &mut outlets)?;
    if let (Some(folder), Some(reference)) = (&arguments.cross_check, &extras.reference) {
        let name = output.file_stem().and_then(|stem| stem.to_str()).unwrap_or("model");
        let files = CrossCheck::new(&machine, reference, name);
        for (place, files) in files.submissions(&libraries, &fmu) {
            submit(&folder.join(place), &files, &mut outlets, arguments.quiet.quiet || arguments.json)?;
        }
    }
    if kinds.model_exchange && Plant::new(Arc::new(machine.clone())).system_mut().switch_count() > 0 {
        arguments.quiet.warning(
            "where the thrust coefficient of an annulus reaches 2, steady inflow jumps: near there, integrators of Model Exchange may stop at \
             many events or leave the jump on the wrong side; write dynamic_inflow = true or inflow_lag_s, or compare with co-simulation",
        );
    }
    if arguments.json {
        let summary = json!({
            "name": machine.name,
            "fmi_version": if version == Version::Fmi3 { "3.0" } else { "2.0" },
            "co_simulation": kinds.co_simulation,
            "model_exchange": kinds.model_exchange,
            "platforms": libraries.iter().map(|library| library.platform.to_string()).collect::<Vec<_>>(),
            "files": outlets.files(),
        });
        return arguments.quiet.print(&format!("{summary:#}"), &outlets);
    }
    if !arguments.quiet.quiet {
        outlets.report();
    }
    Ok(())
}

/// Files to write, and contents of the FMU.
pub(super) struct Order<'a> {
    pub kinds: Kinds,
    /// Path of the FMU.
    pub output: &'a Path,
    /// Path of a system of this FMU alone.
    pub ssp: Option<&'a Path>,
    /// Libraries, with their platforms if these were given.
    pub libraries: &'a [(Option<Platform>, PathBuf)],
    /// Point of the linear model.
    pub linear: Option<&'a str>,
    pub without_reference: bool,
    pub shows_progress: bool,
}

/// An FMU that was written, with its contents.
pub(super) struct Packaged {
    pub fmu: Vec<u8>,
    pub extras: Extras,
    pub libraries: Vec<Library>,
}

/// Writes the FMU and the system around it; kinds and names have been checked.
pub(super) fn write(machine: &Machine, text: &str, order: &Order, outlets: &mut Outlets) -> Result<Packaged, Failure> {
    let kinds = order.kinds;
    let place = outlets.place(order.output, Mark::FMU)?;
    let system = order.ssp.map(|ssp| outlets.place(ssp, Mark::SSP)).transpose()?;
    let progress = order.shows_progress.then(|| Progress::phase("reference results and linear model"));
    let extras = Extras {
        kinds,
        // the tables have one column per scalar variable of FMI 2.0
        reference: (!order.without_reference && kinds.version == Version::Fmi2)
            .then(|| reference(machine))
            .transpose()?,
        linear: order.linear.map(|at| linear(machine, at)).transpose()?,
    };
    drop(progress);
    let mut libraries = Vec::new();
    for (platform, path) in order.libraries {
        libraries.extend(Library::read(path, *platform).map_err(failure)?);
    }
    let fmu = packaging::package(machine, text, &extras, &libraries).map_err(failure)?;
    place.fill_durably(&fmu)?;
    if let Some(system) = system {
        let interface = kinds.interface(machine);
        system.fill_durably(&packaging::ssp::system(machine, interface.variables(), kinds, fmu.clone()))?;
    }
    Ok(Packaged { fmu, extras, libraries })
}

/// Checks that an FMU of this type can be made from the model.
pub(super) fn check_kinds(kinds: Kinds, machine: &Machine) -> Result<(), Failure> {
    if kinds.scalars && kinds.version == Version::Fmi2 {
        let cause = "--scalars: FMI 2.0 has no other variables; leave it out, or add --fmi 3";
        return Err(Failure::Usage(cause.to_owned()));
    }
    if kinds.accounts && !kinds.model_exchange {
        let cause = "--accounts: co-simulation always has them; omit the option, or package Model Exchange alone";
        return Err(Failure::Usage(cause.to_owned()));
    }
    kinds.check(machine).map_err(|error| Failure::Refused(format!("--interface me: {error}")))
}

/// Checks the file extension, which importers rely on.
pub(super) fn check_name(output: &Path) -> Result<(), Failure> {
    if output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu")) {
        return Ok(());
    }
    let shown = output.display();
    Err(Failure::Usage(format!("{shown}: the name of an FMU must end in .fmu; write {shown}.fmu")))
}

/// Checks that a system, if there is one, has no arrays.
fn check_arrays(ssp: Option<&Path>, kinds: Kinds) -> Result<(), Failure> {
    match ssp {
        Some(ssp) if kinds.version == Version::Fmi3 && !kinds.scalars => Err(Failure::Usage(format!(
            "--ssp {}: SSP 1.0 has no arrays; add --scalars, or leave out --fmi 3",
            ssp.display()
        ))),
        _ => Ok(()),
    }
}

/// Checks a system, if there is one: no arrays, and the file extension.
pub(super) fn check_system(ssp: Option<&Path>, kinds: Kinds) -> Result<(), Failure> {
    check_arrays(ssp, kinds)?;
    let Some(output) = ssp else { return Ok(()) };
    if output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ssp")) {
        return Ok(());
    }
    let shown = output.display();
    Err(Failure::Usage(format!("{shown}: the name of an SSP must end in .ssp; write {shown}.ssp")))
}

/// Writes the cross-check files of one platform, and prints their folder unless `silent`.
fn submit(folder: &Path, files: &[(String, &[u8])], outlets: &mut Outlets, silent: bool) -> Result<(), Failure> {
    for (name, bytes) in files {
        let mark = if name.ends_with(".fmu") { Mark::FMU } else { Mark::first_line(bytes) };
        outlets.place(&folder.join(name), mark)?.fill(bytes)?;
    }
    if silent { Ok(()) } else { print(&format!("cross-check files in {}", folder.display())) }
}

fn failure(error: PackageError) -> Failure {
    match error {
        PackageError::NotALibrary { .. } => Failure::Refused(error.to_string()),
        PackageError::Twice { .. } => Failure::Usage(error.to_string()),
        PackageError::Library { .. } => Failure::Files(error.to_string()),
    }
}

/// Paths of the libraries, each with its platform if given.
fn sources(arguments: &[OsString], library: Option<&Path>) -> Result<Vec<(Option<Platform>, PathBuf)>, Failure> {
    if arguments.is_empty() {
        let library = library.map_or_else(library_beside_executable, |library| Ok(library.to_owned()))?;
        return Ok(vec![(None, library)]);
    }
    arguments.iter().map(|argument| place(argument)).collect()
}

/// Splits `PLATFORM=PATH`. A path may itself contain `=`: the part before it is a platform unless it contains a path separator or the
/// whole argument is an existing file.
fn place(argument: &OsStr) -> Result<(Option<Platform>, PathBuf), Failure> {
    let whole = || (None, PathBuf::from(argument));
    let Some((name, path)) = argument.to_str().and_then(|text| text.split_once('=')) else { return Ok(whole()) };
    match Platform::named(name) {
        Ok(platform) => Ok((Some(platform), path.into())),
        Err(_) if name.contains(['/', '\\']) || Path::new(argument).is_file() => Ok(whole()),
        Err(error) => Err(Failure::Usage(format!("--library {name}={path}: {error}"))),
    }
}

fn reference(machine: &Machine) -> Result<Reference, Failure> {
    Reference::simulate(machine).map_err(|error| {
        Failure::Simulation(format!(
            "{error}; the default experiment, whose result is stored in the FMU, failed: fix the model or its [simulation], or \
             package with --no-reference"
        ))
    })
}

/// Returns the linear model from all real inputs to all real outputs.
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
    let library = executable.with_file_name(format!("{DLL_PREFIX}foldwing_fmu{DLL_SUFFIX}"));
    if library.is_file() {
        Ok(library)
    } else {
        Err(Failure::Files(format!("{}: no library next to this executable; give --library", library.display())))
    }
}
