//! `foldwing linearize`: the matrices `A`, `B`, `C`, `D` of a linear model about a state.

use crate::cli::choice;
use crate::cli::outlets::{Force, Mark, Outlet, Outlets, Quiet};
use crate::cli::progress::Progress;
use crate::cli::settings::plant_with;
use crate::cli::{Failure, read_model, tell};
use crate::report::{linear_json, write_mat, write_npz};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Dropped, Holding, Keep, NoReduction, Plant, PlantError};
use foldwing_fmi::interface::{GUSTS, Interface, LinearModel, Variable};
use std::f64::consts::TAU;
use std::io::{self, Cursor, Write};
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::LINEARIZE)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// State to linearise about: `start`, the initial state of a simulation; `equilibrium`, the static equilibrium with released joints
    /// free, as in `static`; or a time in s up to which the model is simulated
    #[arg(long = "state", value_name = "STATE", default_value = "equilibrium")]
    at: String,
    /// Real inputs, separated by commas; `load.` selects every name with that prefix, `load.*.z` every name that matches [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    inputs: Vec<String>,
    /// Real outputs, selected in the same way [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    outputs: Vec<String>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Include the vortex lattice; the model is then discrete-time, sampled at the aerodynamic step. Inputs may also be the wind, control
    /// surfaces and a gust (`gust.*`)
    #[arg(long)]
    lattice: bool,
    /// Modal truncation to N states: the slowest modes; the static gain of the truncated modes is kept
    #[arg(long, value_name = "N", conflicts_with = "reduce")]
    modes: Option<usize>,
    /// Balanced truncation to N states, with inputs and outputs scaled; prints the error over frequency
    #[arg(long, value_name = "N")]
    reduce: Option<usize>,
    /// With `--reduce`: balance only for frequencies up to this value, and print the largest error in this band
    #[arg(long = "max-frequency", value_name = "HZ", requires = "reduce")]
    up_to: Option<f64>,
    /// File to write: `.json`, `.npz` (NumPy) or `.mat` (MATLAB)
    #[arg(short, long, value_name = "X.json|X.npz|X.mat")]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print the description of the model as JSON for programs: the contents of the `.json` file without the matrices
    #[arg(long)]
    json: bool,
    /// Print no summary
    #[arg(short, long)]
    quiet: bool,
}

/// Writes the linear model.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mark, write): (Mark, Writer) = match arguments.output.extension().and_then(|extension| extension.to_str()) {
        Some("json") => (Mark::LINEAR_JSON, |model, sink| writeln!(sink, "{:#}", linear_json(model))),
        Some("npz") => (Mark::NPZ, write_npz_to),
        Some("mat") => (Mark::MAT, |model, sink| write_mat(model, sink)),
        _ => {
            let output = arguments.output.display();
            return Err(Failure::Usage(format!("--output {output}: the name must end in .json, .npz or .mat")));
        }
    };
    let quiet = Quiet { quiet: arguments.quiet };
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    let place = outlets.place(&arguments.output, mark)?;
    let (machine, _) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let (gusts, names) = gusts_of(&arguments.inputs, &machine, arguments.lattice)?;
    let inputs = match names.is_empty() && !gusts.is_empty() {
        true => Vec::new(),
        false if arguments.lattice => chosen(&names, interface.real_inputs_in_air(), "real input")?,
        false => chosen(&names, interface.real_inputs(), "real input")?,
    };
    let outputs = chosen(&arguments.outputs, interface.real_outputs(), "real output")?;
    let mut plant = plant_with(machine, &interface, &arguments.settings)?;
    let mut progress = Progress::phase("operating point");
    reach("--state", &arguments.at, &mut plant)?;
    progress.part("linear model", None);
    let model = match arguments.lattice {
        true => interface.linearize_lattice(&mut plant, &inputs, &gusts, &outputs),
        false => interface.linearize_in_gusts(&mut plant, &inputs, &gusts, &outputs),
    };
    let model = model.map_err(|error| Failure::Statics(error.to_string()))?;
    let model = match (arguments.modes, arguments.reduce) {
        (Some(order), _) => {
            progress.part("reduction", None);
            fewer(&model, "--modes", order, Keep::Modes, None)?
        }
        (_, Some(order)) => {
            progress.part("reduction", None);
            fewer(&model, "--reduce", order, Keep::Balanced, arguments.up_to)?
        }
        (None, None) => model,
    };
    drop(progress);
    let mut outlet = place.open()?;
    write(&model, &mut outlet).map_err(|error| outlet.failure(&error))?;
    outlet.finish()?;
    if let Some(dropped) = dropped_in_words(&model, arguments.up_to.is_some()) {
        quiet.warning(&dropped);
    }
    if arguments.json {
        let mut value = linear_json(&model);
        if let Some(fields) = value.as_object_mut() {
            ["A", "B", "C", "D"].iter().for_each(|matrix| drop(fields.remove(*matrix)));
        }
        value["name"] = plant.machine().name.as_str().into();
        value["files"] = outlets.files().into();
        return quiet.print(&format!("{value:#}"), &outlets);
    }
    if arguments.quiet {
        return Ok(());
    }
    let in_air = match model.step_s {
        Some(step_s) => format!(", with the vortex lattice, in discrete time with steps of {step_s} s"),
        None => ", with aerodynamics".to_owned(),
    };
    let text = format!(
        "{}: {} states{}, {} inputs, {} outputs{}\n{}",
        plant.machine().name,
        model.states.len(),
        reduction_in_words(&model),
        model.inputs.len(),
        model.outputs.len(),
        if model.without_air {
            ", with constant aerodynamic loads (wind is not an input)"
        } else if plant.machine().air.is_some() {
            &in_air
        } else {
            ""
        },
        model.point
    );
    quiet.print(&text, &outlets)
}

/// Splits the names of inputs into components of a uniform gust and others.
fn gusts_of(names: &[String], machine: &Machine, lattice: bool) -> Result<(Vec<usize>, Vec<String>), Failure> {
    let named = |name: &String| GUSTS.iter().position(|gust| name == gust);
    let mut gusts: Vec<usize> = Vec::new();
    for name in names {
        let all = if name == "gust." || name == "gust.*" { vec![0, 1, 2] } else { named(name).into_iter().collect() };
        gusts.extend(all);
        if gusts.is_empty() || lattice || machine.air.as_ref().is_some_and(|air| air.is_linearised()) {
            continue;
        }
        return Err(Failure::Usage(format!(
            "--inputs {name}: only linear models with strips (aerodynamics.model = \"strip\"), with a rotor, or with a vortex lattice and \
             --lattice have gusts as inputs"
        )));
    }
    gusts.sort_unstable();
    gusts.dedup();
    let others = names.iter().filter(|name| named(name).is_none() && *name != "gust." && *name != "gust.*");
    Ok((gusts, others.cloned().collect()))
}

/// Returns the reduced-order model.
fn fewer(
    model: &LinearModel,
    option: &str,
    order: usize,
    keep: Keep,
    up_to_hz: Option<f64>,
) -> Result<LinearModel, Failure> {
    model.reduced(order, keep, up_to_hz).map_err(|error| match (&error, up_to_hz) {
        (NoReduction::Order { .. }, _) => Failure::Usage(format!("{option} {order}: {error}")),
        (NoReduction::Band, Some(up_to_hz)) => Failure::Usage(format!("--max-frequency {up_to_hz}: {error}")),
        (
            NoReduction::Band
            | NoReduction::Eigenvalues
            | NoReduction::Defective { .. }
            | NoReduction::Grows
            | NoReduction::SampledModes
            | NoReduction::ModalBand
            | NoReduction::Singular,
            _,
        ) => Failure::Statics(format!("{option} {order}: {error}")),
    })
}

/// Describes the error of a reduction; empty if the model is not reduced.
fn reduction_in_words(model: &LinearModel) -> String {
    let Some(reduction) = &model.reduction else { return String::new() };
    let mut parts = vec![reduction.method().to_owned()];
    if reduction.up_to_hz.is_none() {
        parts.push(reduction.error_bound.map_or("a motion that does not decay is omitted".to_owned(), |bound| {
            format!("error bound (H-infinity) {bound:.3e}")
        }));
    }
    if let Some(accuracy) = &reduction.accuracy {
        let (worst, [output, input]) = accuracy.worst();
        let mut text =
            format!("up to {:.4} Hz off by at most {worst:.2e} of each gain's largest value", accuracy.up_to_hz);
        if worst > 0.0 {
            let [to, from] = [&model.outputs[output].name, &model.inputs[input].name];
            text += &format!(", most from {from} to {to} at {:.4} Hz", accuracy.worst_hz);
        }
        parts.push(text);
    }
    format!(" of {} ({})", reduction.whole, parts.join("; "))
}

/// Describes the modes omitted by a reduction below the upper end of the measured band, with a remedy, which is a different one if the
/// reduction is already for a band. `None` if no mode is omitted.
fn dropped_in_words(model: &LinearModel, for_a_band: bool) -> Option<String> {
    let accuracy = model.reduction.as_ref()?.accuracy.as_ref().filter(|accuracy| !accuracy.dropped.is_empty())?;
    let of = |mode: &Dropped| {
        format!("{:.4} Hz ({:.0} % of the largest gain)", mode.eigenvalue_1_s.norm() / TAU, 100.0 * mode.share)
    };
    let shown: Vec<String> = accuracy.dropped.iter().take(3).map(of).collect();
    let rest = accuracy.dropped.len() - shown.len();
    let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    let (shown, up_to_hz) = (shown.join(", "), accuracy.up_to_hz);
    Some(match for_a_band {
        true => format!(
            "the reduced model omits modes at {shown}{rest}, below {up_to_hz:.4} Hz; keep more states, or select fewer \
             inputs and outputs"
        ),
        false => format!(
            "the reduced model omits modes at {shown}{rest}, below {up_to_hz:.4} Hz; balance for a frequency band \
             (--max-frequency HZ), keep more states, or select fewer inputs and outputs"
        ),
    })
}

/// Variables selected by the names; all without names.
pub(super) fn chosen<'a>(
    names: &[String],
    rows: impl Iterator<Item = &'a Variable>,
    what: &'static str,
) -> Result<Vec<&'a Variable>, Failure> {
    let rows: Vec<&Variable> = rows.collect();
    if names.is_empty() {
        return Ok(rows);
    }
    if let Some(name) = names.iter().find(|name| name.starts_with("wind.")) {
        let named = rows.iter().any(|row| row.name.starts_with(name.trim_end_matches(['*', '.'])));
        if !named {
            return Err(Failure::Usage(format!(
                "--inputs {name}: without --lattice the linear model of a vortex lattice holds the aerodynamic loads \
                 constant; choose other inputs, add --lattice, or use strips (aerodynamics.model = \"strip\")"
            )));
        }
    }
    choice::chosen(names, &rows, what)
}

/// Moves the plant to the requested state: `start`, `equilibrium` or a time in s.
pub(super) fn reach(option: &str, at: &str, plant: &mut Plant) -> Result<(), Failure> {
    let (start_s, stop_s) = (plant.machine().experiment.start_time_s, plant.machine().experiment.stop_time_s);
    let statics = |error: PlantError| Failure::Statics(error.to_string());
    match at {
        "start" => plant.initialize(start_s).map_err(statics),
        "equilibrium" => plant.study().equilibrium(start_s, Holding::AsReleased).map(|_| ()).map_err(statics),
        time => {
            let time_s: f64 = time
                .parse()
                .ok()
                .filter(|time_s: &f64| time_s.is_finite() && *time_s >= start_s)
                .ok_or_else(|| {
                    Failure::Usage(format!(
                        "{option} {time}: must be start, equilibrium or a time from {start_s} s, the start of the simulation"
                    ))
                })?;
            if time_s > stop_s {
                tell::note(&format!(
                    "{option} {time} lies after the end of the simulation, {stop_s} s; the simulation is extended to this time"
                ));
            }
            plant.initialize(start_s).map_err(statics)?;
            if time_s > start_s {
                plant.step(time_s).map_err(|error| Failure::Simulation(error.to_string()))?;
            }
            Ok(())
        }
    }
}

/// Function that writes a linear model in one of the formats.
type Writer = fn(&LinearModel, &mut Outlet) -> io::Result<()>;

/// Writes a NumPy archive, first to memory, because an archive needs a seekable sink.
fn write_npz_to(model: &LinearModel, sink: &mut Outlet) -> io::Result<()> {
    let mut archive = Cursor::new(Vec::new());
    write_npz(model, &mut archive)?;
    sink.write_all(&archive.into_inner())
}
