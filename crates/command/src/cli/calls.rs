//! The commands as functions for other programs: the same checks, numbers and texts, without files or printed output.

use crate::cli::Failure;
use crate::cli::branches::BranchTable;
use crate::cli::gradient::Variants;
use crate::cli::grid::{GridArguments, grid_of};
use crate::cli::outlets::{Mark, Outlets};
use crate::cli::sweep::{Experiment, Plan, changed_text, columns, file_path};
use crate::cli::{check, package as packages, shapes, stability, statics};
use crate::packaging::Kinds;
use crate::report::InputTable;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Branch, Holding, LoadPath, ModeShape, Plant, PlantError, Rest, Search, Stability};
use foldwing_fmi::instance::Version;
use foldwing_fmi::interface::{Interface, Variable};
use foldwing_study::campbell::{self, Campbell, CampbellError, over_speed_watched};
use foldwing_study::flutter;
use foldwing_study::periodic;
use foldwing_study::sensitivity::{Gradients, Options};
use foldwing_study::watch::{Watch, unwatched};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Returns the output of `foldwing check`; `list_variables` adds every variable.
pub fn summary(machine: &Machine, file_text: &str, list_variables: bool) -> String {
    check::text(machine, file_text, list_variables)
}

/// Returns the output of `foldwing check --json`.
pub fn summary_json(machine: &Machine, file_text: &str) -> String {
    check::json(machine, file_text)
}

/// Computes the static equilibrium as `foldwing static` does, and describes it as `foldwing static --json` does.
///
/// `arc_length` follows the path of equilibria through limit points; `branch` selects the equilibrium if the one on the path is unstable.
///
/// # Errors
/// [`PlantError::Equilibrium`] if there is no equilibrium.
pub fn rest(plant: &mut Plant, time_s: f64, arc_length: bool, branch: Branch) -> Result<Value, PlantError> {
    let search = Search { path: if arc_length { LoadPath::ArcLength } else { LoadPath::Load }, branch };
    let rest = plant.study().rest(time_s, Holding::AsReleased, search)?;
    statics::rest_json(plant, &rest)
}

/// State about which modes are computed, and how the aerodynamic loads depend on the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModesOf {
    /// Undeformed, without loads, gravity and root motion.
    Undeformed,
    /// Static equilibrium; the loads of strip theory vary with the motion, those of a lattice are held constant.
    Rest,
    /// Static equilibrium; the loads of the vortex lattice vary with the motion.
    RestInLattice,
}

/// Modes of lowest frequency, in the format of `foldwing modes --json`.
///
/// # Errors
/// [`PlantError::Equilibrium`] if there is no equilibrium, [`PlantError::Linearization`] if the modes cannot be computed.
pub fn modes(plant: &mut Plant, time_s: f64, of: ModesOf, count: usize) -> Result<Value, PlantError> {
    let (modes, judged) = modes_of(plant, time_s, of, count)?;
    let mut value = crate::cli::modes::as_json(plant, &modes, of == ModesOf::Undeformed);
    if of == ModesOf::RestInLattice {
        value["without_air"] = false.into();
    }
    if let Some((stability, rest)) = judged {
        value["stability"] = stability::as_json(plant, &stability, rest.departure);
    }
    Ok(value)
}

/// Page with the animated shapes of the same modes, as `foldwing modes --view` writes it.
///
/// # Errors
/// As for [`modes`], and for a model without modes.
pub fn modes_page(plant: &mut Plant, time_s: f64, of: ModesOf, count: usize) -> Result<String, Failure> {
    let (modes, _) = modes_of(plant, time_s, of, count).map_err(|error| Failure::Statics(error.to_string()))?;
    let title = crate::cli::modes::title(plant, of == ModesOf::Undeformed, of == ModesOf::RestInLattice);
    shapes::page(&shapes::of_modes(plant, &modes, format!("modes {title}")))
}

/// Modes; about an equilibrium also its stability and the equilibrium.
type Judged = (Vec<ModeShape>, Option<(Stability, Rest)>);

/// Modes about a state.
fn modes_of(plant: &mut Plant, time_s: f64, of: ModesOf, count: usize) -> Result<Judged, PlantError> {
    if of == ModesOf::Undeformed {
        plant.study().undeformed(time_s)?;
        return Ok((plant.study().bare_modes(count)?, None));
    }
    let rest = plant.study().rest(time_s, Holding::AsReleased, Search::default())?;
    let lattice = of == ModesOf::RestInLattice;
    let (modes, stability) = crate::cli::modes::judged_modes(plant, Some(&rest), count, lattice)?;
    Ok((modes, Some((stability, rest))))
}

/// Page with the animated mode shapes versus wind speed, as `foldwing flutter --view` writes it. Both `plants` are of the same model,
/// with its start values.
///
/// # Errors
/// As for [`flutter::sweep`], and for a model without modes.
pub fn flutter_page([swept, drawn]: [Plant; 2], options: &flutter::Options) -> Result<String, Failure> {
    let seen = shapes::sweep_seen(swept, options, &mut unwatched).map_err(crate::cli::flutter::failure)?;
    let drawn = shapes::of_flutter(drawn, &seen);
    shapes::page(&drawn.map_err(|error| Failure::Statics(error.to_string()))?)
}

/// Page with the animated Floquet modes, as `foldwing periodic --view` writes it.
///
/// # Errors
/// As for [`periodic::find`], and for a motion without modes.
pub fn periodic_page(machine: &Machine, options: &periodic::Options) -> Result<String, Failure> {
    let found = periodic::find(machine, options).map_err(crate::cli::periodic::failure)?;
    shapes::page(&shapes::of_periodic(machine, options, &found)?)
}

/// Contents and path of an FMU.
#[derive(Debug, Clone, Default)]
pub struct Packaging {
    /// Path of the FMU.
    pub output: PathBuf,
    /// Path of a system of this FMU alone (SSP 1.0).
    pub ssp: Option<PathBuf>,
    /// Model file, which is never overwritten.
    pub model: Option<PathBuf>,
    /// Shared libraries, one per platform; the platform is read from the library.
    pub libraries: Vec<PathBuf>,
    /// Point about which to add a linear model: `start`, `equilibrium`, or a time in s.
    pub linear: Option<String>,
    /// FMI version, interface types, and whether vectors are split into scalars.
    pub kinds: Kinds,
    /// Omit the reference results.
    pub without_reference: bool,
    /// Overwrite a file that Foldwing did not write.
    pub force: bool,
}

/// Version of FMI (2 or 3), interface types, and choices of the variables of an FMU: scalars, energy accounts, Real outputs only.
pub fn kinds(
    fmi: u8,
    [co_simulation, model_exchange]: [bool; 2],
    [scalars, accounts, real_outputs_only]: [bool; 3],
) -> Kinds {
    let version = if fmi == 3 { Version::Fmi3 } else { Version::Fmi2 };
    Kinds { version, co_simulation, model_exchange, scalars, accounts, real_outputs_only }
}

/// Writes the same FMU, and the same system of it, as `foldwing package`, byte for byte.
///
/// # Errors
/// As for the command: invalid names, libraries or files, and a default simulation that fails.
pub fn package(machine: &Machine, text: &str, packaging: &Packaging) -> Result<(), Failure> {
    packages::check_kinds(packaging.kinds, machine)?;
    packages::check_name(&packaging.output)?;
    packages::check_system(packaging.ssp.as_deref(), packaging.kinds)?;
    let libraries: Vec<_> = packaging.libraries.iter().map(|path| (None, path.clone())).collect();
    let read = packaging.model.iter().chain(&packaging.libraries).map(PathBuf::as_path);
    let order = packages::Order {
        kinds: packaging.kinds,
        output: &packaging.output,
        ssp: packaging.ssp.as_deref(),
        libraries: &libraries,
        linear: packaging.linear.as_deref(),
        without_reference: packaging.without_reference,
        shows_progress: false,
    };
    packages::write(machine, text, &order, &mut Outlets::new(packaging.force, read)).map(drop)
}

/// Modes of a rotor over its speed, in the format of `foldwing modes --vary rotor_speed_rpm=… --json`.
///
/// # Errors
/// As for [`over_speed_watched`].
pub fn campbell(
    machine: impl Into<Arc<Machine>>,
    options: &campbell::Options,
    watch: &mut Watch<'_>,
) -> Result<Value, CampbellError> {
    let Campbell { machine, branches, ended, .. } = over_speed_watched(machine, options, watch)?;
    let table = BranchTable { quantity: crate::cli::campbell::KEY, unit: "", branches: &branches };
    Ok(table.json(&machine, ended.map(|(value, error)| (value, error.to_string()))))
}

/// Writes a page with an animation; a file that Foldwing did not write is overwritten only with `force`.
///
/// # Errors
/// The file cannot be written, or exists and was not written by Foldwing.
pub fn write_page(page: &str, output: &Path, force: bool) -> Result<(), Failure> {
    Outlets::new(force, []).place(output, Mark::PAGE)?.fill(page.as_bytes())
}

/// Communication points of a run, in s; `None` takes the value of the model file.
///
/// # Errors
/// Times that are not finite or in the wrong order, or too many points.
pub fn points(
    machine: &Machine,
    start_s: Option<f64>,
    stop_s: Option<f64>,
    step_s: Option<f64>,
) -> Result<Vec<f64>, Failure> {
    let experiment = &machine.experiment;
    let arguments = GridArguments::of(start_s, stop_s, step_s);
    let grid = grid_of(&arguments, experiment.start_time_s, experiment.stop_time_s, experiment.step_s)?;
    Ok((0..=grid.steps).map(|point| grid.time_s(point)).collect())
}

/// Selects variables by full names, or by prefixes that end with a dot.
///
/// # Errors
/// Names without a match, with the closest existing name; `what` describes the variables in the message.
pub fn chosen<'a>(
    names: &[String],
    rows: impl Iterator<Item = &'a Variable>,
    what: &'static str,
) -> Result<Vec<&'a Variable>, Failure> {
    crate::cli::linearize::chosen(names, rows, what)
}

/// Computes derivatives of results of a run like `foldwing gradient`; `machine` and `interface` are built from the model file `text`,
/// `settings` are `NAME=VALUE` texts, and `table` holds inputs over time.
///
/// # Errors
/// As for the command.
pub fn gradients(
    (file, text): (&str, &str),
    (machine, interface): (Arc<Machine>, &Interface),
    settings: &[String],
    by: &[String],
    (table, mut options): (Option<&InputTable>, Options),
) -> Result<Gradients, Failure> {
    options.inputs = crate::cli::gradient::rows(table, interface)?;
    Variants { file, text, machine, interface, settings, table }.gradients(by, &options)
}

/// Returns the text of a model file with some keys (`file:body.inner.length_m`) set to other values, given as TOML text.
///
/// # Errors
/// Keys that a model file does not have, and parts of a path that are not tables.
pub fn text_with_values(text: &str, values: &[(String, String)]) -> Result<String, Failure> {
    let path = |key: &str| file_path(key).map(|path| path.iter().map(|part| (*part).to_owned()).collect::<Vec<_>>());
    let mut changes = Vec::new();
    for (key, value) in values {
        let path = path(key).ok_or_else(|| {
            Failure::Usage(format!(
                "values: {key} is not a key of the model file; write keys such as file:body.inner.length_m"
            ))
        })?;
        changes.push((path, value.as_str()));
    }
    let changes: Vec<(Vec<&str>, &str)> =
        changes.iter().map(|(path, value)| (path.iter().map(String::as_str).collect(), *value)).collect();
    changed_text(text, "values:", &changes)
}

/// Variants of a model, which run like those of `foldwing sweep`.
pub struct SweepPlan {
    file: String,
    machine: Arc<Machine>,
    interface: Arc<Interface>,
    text: String,
    plan: Plan,
    inputs: Option<InputTable>,
    grid: GridArguments,
    outputs: Vec<String>,
    settings: Vec<String>,
    columns: Vec<String>,
}

/// Settings common to all variants of a sweep.
#[derive(Debug, Clone, Default)]
pub struct SweepRun {
    /// Start, stop and step in s; `None` takes the value of the model file.
    pub times_s: [Option<f64>; 3],
    /// Inputs over time.
    pub inputs: Option<InputTable>,
    /// Variables whose final values are recorded.
    pub outputs: Vec<String>,
    /// Start values, in the format of `--set`.
    pub settings: Vec<String>,
}

impl SweepPlan {
    /// Returns variants of the model with the file text `text`, of which `machine` and `interface` are built. `keys` are start values of
    /// inputs and parameters, or keys of the model file such as `file:body.inner.length_m`; each row has their values for one variant.
    ///
    /// # Errors
    /// As for the command before its first run.
    pub fn new(
        (file, text): (&str, &str),
        (machine, interface): (Arc<Machine>, Arc<Interface>),
        keys: Vec<String>,
        rows: Vec<Vec<String>>,
        run: SweepRun,
    ) -> Result<Self, Failure> {
        let plan = Plan::rows("sweep", keys, rows, &interface)?;
        for name in &run.outputs {
            interface.find(name).ok_or_else(|| crate::cli::choice::unknown(name, "variable", interface.variables()))?;
        }
        let [start, stop, step] = run.times_s;
        points(&machine, start, stop, step)?;
        let columns = columns(&plan, &run.outputs, &machine)?;
        let sweep = Self {
            file: file.to_owned(),
            machine,
            interface,
            text: text.to_owned(),
            plan,
            inputs: run.inputs,
            grid: GridArguments::of(start, stop, step),
            outputs: run.outputs,
            settings: run.settings,
            columns,
        };
        sweep.experiment().check_values()?;
        Ok(sweep)
    }

    /// Names of the columns of the result table.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of variants.
    pub fn count(&self) -> usize {
        self.plan.count()
    }

    /// Runs a variant and returns its row as text cells. Errors are returned in the message column.
    pub fn run(&self, index: usize) -> Vec<String> {
        std::iter::once(index.to_string()).chain(self.experiment().run(index, None)).collect()
    }

    /// Returns the plant of a variant with its start values, not yet initialised.
    ///
    /// # Errors
    /// Values that the model rejects.
    pub fn plant(&self, index: usize) -> Result<Plant, Failure> {
        Ok(self.experiment().prepare(index, &self.plan.variant(index))?.0)
    }

    fn experiment(&self) -> Experiment<'_> {
        Experiment {
            file: self.file.clone(),
            machine: Arc::clone(&self.machine),
            interface: Arc::clone(&self.interface),
            text: &self.text,
            plan: &self.plan,
            settings: &self.settings,
            inputs: self.inputs.as_ref(),
            grid: &self.grid,
            outputs: &self.outputs,
        }
    }
}
