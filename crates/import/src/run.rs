//! `foldwing run`: simulates an FMU of any tool and writes CSV.

use crate::{
    CallError, Datum, Description, Fault, Fmu, ImportError, Kind, Message, Readout, Severity, Slave, Step, Variable,
    listen,
};
use foldwing_command::cli::Failure;
use foldwing_command::cli::parts::{
    Grid, Leftover, Mark, Outlets, Progress, RunArguments, check_figures, chosen, grid_of, one_standard_output, print,
    read_inputs, six, unknown, write_series,
};
use foldwing_command::report::plots::Series;
use foldwing_command::report::{InputTable, Recorder};
use foldwing_fmi::interface;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::{self, Write};
use std::panic;
use std::time::{Duration, Instant};

/// Maximum number of final values in a summary.
const MAXIMUM_SHOWN: usize = 20;

/// Runs an FMU and writes the CSV; the rows before an error are kept.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    if arguments.variables {
        return print(&listing(&Fmu::describe(&arguments.fmu).map_err(refused)?));
    }
    one_standard_output(arguments.json, arguments.csv.as_deref())?;
    let folder = tempfile::Builder::new().prefix("foldwing-run").tempdir();
    let folder = folder.map_err(|error| Failure::writing("the folder for temporary files", &error))?;
    let _leftover = Leftover::watch(folder.path());
    let fmu = Fmu::open(&arguments.fmu, folder).map_err(refused)?;
    let description = fmu.description();
    let experiment = description.experiment;
    let grid = grid_of(&arguments.grid, experiment.start_s, experiment.stop_s, experiment.step_s)?;
    check_steps(&grid, description)?;
    let tolerance = checked(arguments.tolerance)?;
    let recorded = recorded(&arguments.outputs, description)?;
    let settings = settings(&arguments.settings, description)?;
    let inputs = arguments.inputs.as_ref().map(|path| read_inputs(path, &description.variables)).transpose()?;
    show_messages(arguments.log, &description.model_name);
    let slave = fmu.instantiate(&description.model_name, arguments.log).map_err(refused)?;

    let read = [Some(arguments.fmu.as_path()), arguments.inputs.as_deref()];
    let mut outlets = Outlets::new(arguments.force.force, read.into_iter().flatten());
    let csv = outlets.place_if(arguments.csv.as_deref(), table(&recorded))?.open()?;
    arguments.plot.as_deref().map(|folder| check_figures(folder, &outlets)).transpose()?;
    let series = arguments.plot.as_ref().map(|_| Series::new(recorded.iter().map(|row| named(row)), grid.steps));
    let target = csv.name().to_owned();
    let recorder = Recorder::new(csv, recorded.iter().map(|variable| variable.name.as_str()));
    let writing = |error: io::Error| Failure::writing(&target, &error);
    let readout = Readout::new(recorded.iter().copied());
    let mut run = Run { slave, description, inputs, readout, recorder: recorder.map_err(writing)?, series };
    let clock = Instant::now();
    run.slave.set_up(tolerance, grid.start_s, grid.stop_s).map_err(failed)?;
    run.slave.set(settings).map_err(set_refused)?;
    let outcome = run.through(&grid, &writing);
    if let Err(Failure::Files(_) | Failure::Closed) = outcome {
        return outcome.map(|_| ()); // nothing can be written: an existing file is kept
    }
    let Run { slave, recorder, series, readout, .. } = run;
    recorder.finish().map_err(writing)?.finish()?;
    if let (Some(folder), Some(series)) = (&arguments.plot, &series) {
        let marks = series.marks(|number| matches!(recorded[number].kind, Kind::Boolean));
        let figures = series.figures(&description.model_name, &[], &marks);
        write_series(folder, figures, &arguments.sheets, &mut outlets)?;
    }
    let end_s = outcome?;
    if !arguments.quiet {
        if !arguments.json {
            eprint!("{}", summary(&slave, description, end_s - grid.start_s, clock.elapsed()));
        }
        if arguments.csv.is_none() && arguments.plot.is_none() && !arguments.json {
            eprint!("{}", final_values(&recorded, &readout));
        }
        outlets.report();
    }
    if arguments.json {
        let values = recorded.iter().zip(readout.values());
        let values: serde_json::Map<String, Value> =
            values.map(|(variable, datum)| (variable.name.clone(), as_json(&datum))).collect();
        let value = json!({
            "name": description.model_name,
            "start_s": grid.start_s,
            "stop_s": end_s,
            "elapsed_s": clock.elapsed().as_secs_f64(),
            "warnings": slave.warnings(),
            "final_values": values,
            "files": outlets.files(),
        });
        return print(&format!("{value:#}"));
    }
    Ok(())
}

/// Value as JSON; numbers that are not finite are null.
fn as_json(datum: &Datum) -> Value {
    match datum {
        Datum::Number(interface::Value::Real(value)) => json!(value),
        Datum::Number(interface::Value::Integer(value)) => json!(value),
        Datum::Number(interface::Value::Boolean(value)) => json!(value),
        Datum::Whole(_) | Datum::Text(_) => json!(datum.to_string()),
    }
}

/// Final values of the recorded variables, one per line, for a run without an output file.
fn final_values(recorded: &[&Variable], readout: &Readout) -> String {
    let mut text = String::new();
    for (variable, datum) in recorded.iter().zip(readout.values()).take(MAXIMUM_SHOWN) {
        let shown = match datum {
            Datum::Number(interface::Value::Real(value)) => six(value),
            Datum::Number(interface::Value::Integer(_) | interface::Value::Boolean(_))
            | Datum::Whole(_)
            | Datum::Text(_) => datum.to_string(),
        };
        let _ = writeln!(text, "{} = {shown}{}", variable.name, variable.unit_after_number());
    }
    if recorded.len() > MAXIMUM_SHOWN {
        let _ = writeln!(text, "and {} more variables; --csv OUT.csv writes all", recorded.len() - MAXIMUM_SHOWN);
    }
    text
}

/// Writes the messages of FMUs to standard error; with `everything`, also informational ones.
fn show_messages(everything: bool, model_name: &str) {
    let model_name = model_name.to_owned();
    listen(move |Message { instance, severity, text }| {
        let instance = instance.as_ref().unwrap_or(&model_name);
        let word = match severity {
            Severity::Note if !everything => return,
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Discard => "discard",
            Severity::Error => "error",
        };
        eprintln!("{instance}: {word}: {text}");
    });
    // the crate that imports FMUs panics on an undefined status; `Slave::call` catches the panic and returns an error, so that the message
    // of the panic is suppressed
    let default = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let payload = info.payload();
        let text = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
        if !text.is_some_and(|text| text.contains("Invalid status")) {
            default(info);
        }
    }));
}

fn refused(error: ImportError) -> Failure {
    match error {
        ImportError::File { .. } => Failure::Files(error.to_string()),
        ImportError::NotAnFmu { .. }
        | ImportError::Version { .. }
        | ImportError::NoCoSimulation { .. }
        | ImportError::NoLibrary { .. }
        | ImportError::Library { .. }
        | ImportError::NoFunction { .. }
        | ImportError::NotInstantiated { .. } => Failure::Refused(error.to_string()),
    }
}

fn failed(error: CallError) -> Failure {
    Failure::Simulation(error.to_string())
}

/// Converts the error of a call: a rejected value is an error of the caller, anything else a failure of the simulation.
fn set_refused(error: CallError) -> Failure {
    if error.fault == Fault::Discard { Failure::Refused(error.to_string()) } else { failed(error) }
}

/// Checks that the last step is not shorter if the FMU only accepts equal steps.
fn check_steps(grid: &Grid, description: &Description) -> Result<(), Failure> {
    let whole_s = grid.start_s + grid.steps as f64 * grid.step_s;
    if description.varies_step || (whole_s - grid.stop_s).abs() <= 1e-9 * grid.step_s.max(grid.stop_s.abs()) {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "--stop {}: the FMU only takes equal steps (canHandleVariableCommunicationStepSize), and {} s is not a whole number \
         of steps of {} s",
        grid.stop_s,
        grid.stop_s - grid.start_s,
        grid.step_s
    )))
}

fn checked(tolerance: Option<f64>) -> Result<Option<f64>, Failure> {
    match tolerance {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(Failure::Usage(format!("--tolerance {value}: must be positive")))
        }
        tolerance => Ok(tolerance),
    }
}

/// Variables to write: the named ones, or all outputs without names.
fn recorded<'a>(names: &[String], description: &'a Description) -> Result<Vec<&'a Variable>, Failure> {
    let variables = &description.variables;
    let readable: Vec<&Variable> = variables.iter().filter(|variable| variable.kind != Kind::Opaque).collect();
    if names.is_empty() {
        return Ok(readable.into_iter().filter(|variable| variable.causality == "output").collect());
    }
    chosen(names, &readable, "variable")
}

/// Mark of a CSV of these variables. A table with only inputs has none, since the user may have written it for a run.
fn table(recorded: &[&Variable]) -> Mark {
    if recorded.iter().all(|variable| variable.causality == "input") {
        return Mark::Never;
    }
    Mark::table(std::iter::once("time").chain(recorded.iter().map(|variable| variable.name.as_str())))
}

/// Parses `NAME=VALUE` of each setting.
fn settings<'a>(settings: &[String], description: &'a Description) -> Result<Vec<(&'a Variable, Datum)>, Failure> {
    let apply = |setting: &String| {
        let refused = |cause: &str| Failure::Usage(format!("--set {setting}: {cause}"));
        let (name, text) = setting.split_once('=').ok_or_else(|| refused("must be NAME=VALUE"))?;
        let variable =
            description.find(name).ok_or_else(|| unknown(name, "input or parameter", &description.variables))?;
        if !variable.settable {
            return Err(refused(&format!("`{name}` cannot be set, it is computed ({})", variable.causality)));
        }
        Ok((variable, variable.parse(text).map_err(|cause| refused(&cause))?))
    };
    settings.iter().map(apply).collect()
}

/// Name and unit of a variable.
fn named(variable: &Variable) -> (&str, &str) {
    (&variable.name, variable.unit.as_ref().map_or("", |unit| unit.name.as_str()))
}

/// Simulation of one FMU.
struct Run<'a, W: Write> {
    slave: Slave,
    description: &'a Description,
    inputs: Option<InputTable>,
    readout: Readout,
    recorder: Recorder<W>,
    /// Recorded variables for figures, if requested.
    series: Option<Series>,
}

impl<W: Write> Run<'_, W> {
    /// Simulates from initialisation to the last row; returns the time reached.
    fn through(&mut self, grid: &Grid, writing: &impl Fn(io::Error) -> Failure) -> Result<f64, Failure> {
        self.slave.enter_initialization().map_err(failed)?;
        self.feed(grid.start_s)?;
        self.slave.exit_initialization().map_err(failed)?;
        self.record(grid.start_s, writing)?;
        let mut progress = Progress::of("time", grid.steps);
        for point in 1..=grid.steps {
            let (from_s, to_s) = (grid.time_s(point - 1), grid.time_s(point));
            self.feed(from_s)?;
            if let Step::Ended(time_s) = self.slave.step(from_s, to_s - from_s).map_err(failed)? {
                self.record(time_s, writing)?;
                eprintln!("{}: the FMU ended the simulation at {time_s} s", self.description.model_name);
                return Ok(time_s);
            }
            self.record(to_s, writing)?;
            progress.at(point);
        }
        Ok(grid.stop_s)
    }

    /// Sets the inputs of the step that starts at `time_s`.
    fn feed(&mut self, time_s: f64) -> Result<(), Failure> {
        let Some(table) = &self.inputs else { return Ok(()) };
        let variables = &self.description.variables;
        let values = table.at(time_s).map(|(position, value)| (&variables[position], Datum::Number(value)));
        self.slave.set(values).map_err(set_refused)
    }

    fn record(&mut self, time_s: f64, writing: &impl Fn(io::Error) -> Failure) -> Result<(), Failure> {
        self.slave.read(&mut self.readout).map_err(failed)?;
        if let Some(series) = &mut self.series {
            series.include(time_s, self.readout.values().map(|datum| datum.real()));
        }
        self.recorder.record_cells(time_s, self.readout.values().map(|datum| datum.to_string())).map_err(writing)
    }
}

/// Lists the variables, one per line.
fn listing(description: &Description) -> String {
    let mut text = String::new();
    for variable in &description.variables {
        let kind = match &variable.kind {
            Kind::Real | Kind::Integer | Kind::Opaque if let Some(element) = variable.element => {
                format!("{:?}", element.native)
            }
            Kind::Real => "Real".to_owned(),
            Kind::Integer => "Integer".to_owned(),
            Kind::Boolean => "Boolean".to_owned(),
            Kind::String => "String".to_owned(),
            Kind::Opaque => "Binary".to_owned(),
            Kind::Enumeration(words) => {
                let words: Vec<&str> = words.iter().map(|(word, _)| word.as_str()).collect();
                format!("Enumeration of {}", words.join(", "))
            }
        };
        let start = variable.start.as_ref().map(|start| format!(" = {start}")).unwrap_or_default();
        let unit = variable.unit_after_number();
        // writing to a String cannot fail
        let _ = writeln!(text, "{} {}: {kind}{start}{unit}", variable.causality, variable.name);
    }
    text
}

/// Summary in one line.
fn summary(slave: &Slave, description: &Description, simulated_s: f64, elapsed: Duration) -> String {
    let warnings = match slave.warnings() {
        0 => String::new(),
        1 => ", 1 warning".to_owned(),
        count => format!(", {count} warnings"),
    };
    let (name, elapsed_s) = (&description.model_name, elapsed.as_secs_f64());
    format!("{name}: {simulated_s:.6} s simulated in {elapsed_s:.4} s{warnings}\n")
}
