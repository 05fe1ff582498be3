//! `foldwing gradient`: derivatives of results of a run with respect to inputs, parameters and keys of the model.

use crate::cli::number::six;
use crate::cli::outlets::{Force, Outlets, Quiet};
use crate::cli::pictures::{SheetArguments, check_figure, write_figure};
use crate::cli::progress::Progress;
use crate::cli::settings::{apply_setting, plant_with};
use crate::cli::simulate::read_inputs;
use crate::cli::sweep::{changed_machine, file_path, number_in_file};
use crate::cli::{Failure, read_model, shown};
use crate::report::InputTable;
use crate::report::figure::{Figure, Heat};
use crate::report::inputs::name_message;
use clap::ValueEnum;
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{InputRows, Parameter, Plant};
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};
use foldwing_study::names;
use foldwing_study::sensitivity::{
    By, Derivatives, Gradients, GradientsError, Mode, Numbers, Options, QuantityError, differentiate,
};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// Step of finite differences between models, relative to the value; for a value of zero, in its SI unit.
const STEP: f64 = 1e-3;
/// Magnitudes below which values are small, and the step for them: steps relative to a small value would be lost in round-off. Inputs of zero
/// are common, and trigonometric functions leave 1e-16 of them; keys of the model file may have small values, such as inertias.
const SMALL_INPUT: (f64, f64) = (0.1, 1e-4);
const SMALL: (f64, f64) = (1e-9, STEP);
/// Name of the figure.
const FIGURE: &str = "gradient";

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::GRADIENT)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Result to differentiate: a real output at the end of the run (NAME) or at a time (NAME@TIME in s), its maximum, its minimum or its
    /// value of largest magnitude, with sign, over the run (max(NAME), min(NAME), peak(NAME)), its mean or root mean square (mean(NAME),
    /// rms(NAME)), JOINT.latch_time, or JOINT.latch_impulse. A vector or pattern selects all its components; may be repeated, or a list
    /// with commas
    #[arg(long = "of", value_name = "RESULT", required = true, value_parser = NonEmptyStringValueParser::new())]
    of: Vec<String>,
    /// Number with respect to which to differentiate: a real input or parameter that is constant during the run, an input of `--inputs` at
    /// the time of a row (NAME@TIME) or of all rows (NAME@*), or a key of the model file (file:body.inner.length_m); may be repeated, or a
    /// list with commas
    #[arg(long = "by", value_name = "NAME", required = true, value_parser = NonEmptyStringValueParser::new())]
    by: Vec<String>,
    /// Stop time in s [default: from the model]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    stop: Option<f64>,
    /// Inputs over time from a CSV file, as for `foldwing simulate`; real inputs are interpolated linearly between rows
    #[arg(long, value_name = "IN.csv")]
    inputs: Option<PathBuf>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Differentiation mode: forward needs one pass per number (`--by`), adjoint one per result (`--of`); auto takes the cheaper
    #[arg(long, value_name = "MODE", value_enum, default_value = "auto")]
    mode: Order,
    /// Folder for a figure: a heat map of the change of each result in % for a change of each number by 1 %
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    sheets: SheetArguments,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Order {
    /// The cheaper of the two
    Auto,
    /// One pass for each number
    Forward,
    /// One pass for each result
    Adjoint,
}

/// Computes and prints the derivatives.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let read = [Some(&arguments.model), arguments.inputs.as_ref()];
    let mut outlets = Outlets::new(arguments.force.force, read.into_iter().flatten().map(PathBuf::as_path));
    if let Some(folder) = &arguments.plot {
        check_figure(folder, FIGURE, &outlets)?;
    }
    let (machine, text) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let table = arguments.inputs.as_ref().map(|path| read_inputs(path, interface.variables())).transpose()?;
    let options = Options {
        inputs: rows(table.as_ref(), &interface)?,
        of: arguments.of.clone(),
        stop_s: arguments.stop,
        mode: match arguments.mode {
            Order::Auto => Mode::Auto,
            Order::Forward => Mode::Forward,
            Order::Adjoint => Mode::Adjoint,
        },
    };
    let model = Variants {
        file: &shown(&arguments.model),
        text: &text,
        machine: Arc::new(machine),
        interface: &interface,
        settings: &arguments.settings,
        table: table.as_ref(),
    };
    let progress = Progress::phase("derivatives");
    let found = model.gradients(&arguments.by, &options)?;
    drop(progress);
    if let Some(folder) = &arguments.plot {
        write_figure(folder, FIGURE, &heat_map(&found), &arguments.sheets, &mut outlets)?;
    }
    let text = match arguments.json {
        true => serde_json::to_string_pretty(&found).map_err(|error| Failure::Refused(error.to_string()))?,
        false => text_of(&found),
    };
    arguments.quiet.print(&text, &outlets)
}

/// Figure of the change of each result in % for a 1 % change of each quantity; empty for results or quantities of zero.
fn heat_map(found: &Gradients) -> Figure {
    let relative = |number: &By, result: &Derivatives, derivative: f64| match (number.value, result.value) {
        (0.0, _) | (_, 0.0) => f64::NAN,
        (number, result) => derivative * number / result.abs(),
    };
    let row = |(place, number): (usize, &By)| -> Vec<f64> {
        found.of.iter().map(|result| relative(number, result, result.derivatives[place])).collect()
    };
    let heat = Heat {
        rows: found.by.iter().map(|number| number.name.clone()).collect(),
        columns: found.of.iter().map(|result| result.name.clone()).collect(),
        values: found.by.iter().enumerate().map(row).collect(),
        unit: "change in % for 1 %".to_owned(),
    };
    Figure { title: format!("{}: which number moves what", found.name), heat: Some(heat), ..Figure::default() }
}

/// Model whose inputs, parameters and keys are varied.
pub(super) struct Variants<'a> {
    /// Name of the model file, for messages.
    pub file: &'a str,
    /// Text of the model file.
    pub text: &'a str,
    /// Machine of the model file.
    pub machine: Arc<Machine>,
    /// The model's variables.
    pub interface: &'a Interface,
    /// `NAME=VALUE` of start values common to all variants.
    pub settings: &'a [String],
    /// Inputs over time.
    pub table: Option<&'a InputTable>,
}

/// Quantity with respect to which results are differentiated.
enum Wanted {
    /// An input or parameter that is constant during the run, or a key of the model file.
    Constant(String),
    /// Rows of a column of the table of inputs.
    Rows { column: usize, rows: Vec<usize> },
}

/// Rows of a table in the form of the engine; empty for constant inputs.
pub(super) fn rows(table: Option<&InputTable>, interface: &Interface) -> Result<InputRows, Failure> {
    let rows = table.map(|table| table.rows(interface)).transpose();
    Ok(rows.map_err(|error| Failure::Refused(error.to_string()))?.unwrap_or_default())
}

impl Variants<'_> {
    /// Computes the derivatives with respect to the quantities in `by`.
    pub fn gradients(&self, by: &[String], options: &Options) -> Result<Gradients, Failure> {
        let plant = plant_with(Arc::clone(&self.machine), self.interface, self.settings)?;
        let mut numbers = Vec::new();
        for wanted in self.wanted(by)? {
            numbers.push(match wanted {
                Wanted::Constant(name) => self.number(&name, &plant)?,
                Wanted::Rows { column, rows } => self.rows(column, rows)?,
            });
        }
        differentiate(plant, numbers, options).map_err(failure)
    }

    /// Quantities of a list, with patterns and vectors expanded.
    fn wanted(&self, by: &[String]) -> Result<Vec<Wanted>, Failure> {
        let settable = |row: &&Variable| {
            matches!(row.causality, Causality::Input | Causality::Parameter) && matches!(row.value, Value::Real(_))
        };
        let rows: Vec<&Variable> = self.interface.variables().iter().filter(settable).collect();
        let mut list: Vec<Wanted> = Vec::new();
        for name in by.iter().flat_map(|list| names::split(list)) {
            if let Some((input, at)) = name.split_once('@').filter(|_| file_path(name).is_none()) {
                self.push_rows(&mut list, (name, input, at))?;
                continue;
            }
            let found = match file_path(name) {
                Some(_) => vec![name.to_owned()],
                None => names::choose(&[name.to_owned()], &rows, names::of_variable, "real input or parameter")
                    .map_err(|error| Failure::Usage(format!("--by {name}: {}", name_message::<Variable>(&error))))?
                    .into_iter()
                    .map(|row| row.name.clone())
                    .collect(),
            };
            for name in found {
                if list.iter().any(|other| matches!(other, Wanted::Constant(other) if *other == name)) {
                    return Err(refused(&name, "is named twice"));
                }
                if self.columns().any(|(row, _)| row.name == name) {
                    return Err(refused(
                        &name,
                        "varies over time; name the time of a row (NAME@0.1), or all rows (NAME@*)",
                    ));
                }
                list.push(Wanted::Constant(name));
            }
        }
        Ok(list)
    }

    /// Names and values of the inputs over time.
    fn columns(&self) -> impl Iterator<Item = (&Variable, &[f64])> {
        self.table.into_iter().flat_map(|table| table.columns(self.interface))
    }

    /// Adds the rows of `NAME@TIME` or `NAME@*`; successive rows of one input share their models.
    fn push_rows(&self, list: &mut Vec<Wanted>, (name, input, at): (&str, &str, &str)) -> Result<(), Failure> {
        let refuse = |cause: &str| Err(refused(name, cause));
        let Some(table) = self.table else {
            return refuse("is a value at a time, and all inputs are constant; give them over time with --inputs");
        };
        let Some((column, (row, _))) = self.columns().enumerate().find(|(_, (row, _))| row.name == input) else {
            let known: Vec<&str> = self.columns().map(|(row, _)| row.name.as_str()).collect();
            return refuse(&format!("{input} is not among the inputs over time, {}", known.join(", ")));
        };
        if !matches!(row.value, Value::Real(_)) {
            return refuse("is not a real number");
        }
        let found = self.rows_at(table.times_s(), at).map_err(|cause| refused(name, &cause))?;
        let taken = |row: usize| {
            list.iter().any(
                |other| matches!(other, Wanted::Rows { column: other, rows } if *other == column && rows.contains(&row)),
            )
        };
        if found.iter().any(|row| taken(*row)) {
            return refuse("is named twice");
        }
        match list.last_mut() {
            Some(Wanted::Rows { column: last, rows }) if *last == column => rows.extend(found),
            _ => list.push(Wanted::Rows { column, rows: found }),
        }
        Ok(())
    }

    /// Rows selected by the text after `@`: `*`, or a time, followed by `-` or `+` for the first or second of two rows at that time.
    fn rows_at(&self, times_s: &[f64], at: &str) -> Result<Vec<usize>, String> {
        if at == "*" {
            return Ok((0..times_s.len()).collect());
        }
        let (number, side) = match at.strip_suffix(['-', '+']) {
            Some(number) => (number, at.chars().last()),
            None => (at, None),
        };
        let time_s: f64 =
            number.trim().parse().map_err(|_| format!("{at} is neither a time in s nor * for all rows"))?;
        let rows: Vec<usize> = (0..times_s.len()).filter(|row| times_s[*row] == time_s).collect();
        match (rows.as_slice(), side) {
            ([row], None) | ([row, _], Some('-')) | ([_, row], Some('+')) => Ok(vec![*row]),
            ([], _) => {
                let near = times_s.iter().min_by(|a, b| (*a - time_s).abs().total_cmp(&(*b - time_s).abs()));
                Err(format!("no row is at {time_s} s; the nearest is at {} s", near.copied().unwrap_or(f64::NAN)))
            }
            ([_], _) => Err(format!("one row is at {time_s} s; leave out the sign after it")),
            (_, _) => Err(format!(
                "two rows are at {time_s} s, a jump; {time_s}- is the value before it and {time_s}+ the value after it"
            )),
        }
    }

    /// Rows of an input over time, and the models with perturbed values for finite differences.
    fn rows(&self, column: usize, rows: Vec<usize>) -> Result<Numbers, Failure> {
        let times_s = self.table.map_or(&[][..], InputTable::times_s);
        let Some((variable, values)) = self.columns().nth(column) else {
            return Err(Failure::Refused(format!("inputs: there is no column {column}")));
        };
        let at = |row: usize| {
            let side = match (row > 0 && times_s[row - 1] == times_s[row], times_s.get(row + 1) == times_s.get(row)) {
                (true, _) => "+",
                (false, true) => "-",
                (false, false) => "",
            };
            format!("{}@{:?}{side}", variable.name, times_s[row])
        };
        let by = rows.iter().map(|row| By { name: at(*row), value: values[*row], unit: variable.unit() }).collect();
        let largest = values.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        let step = if largest == 0.0 { STEP } else { (STEP * largest).max(SMALL_INPUT.1) };
        let plant = || plant_with(Arc::clone(&self.machine), self.interface, self.settings);
        Ok(Numbers { by, parameter: Parameter::of_rows(&variable.name, (column, rows), step, plant)? })
    }

    /// Quantity, and the models with perturbed values for finite differences.
    fn number(&self, name: &str, plant: &Plant) -> Result<Numbers, Failure> {
        if let Some(cause) = setting(name) {
            return Err(refused(name, cause));
        }
        let (value, unit, small) = match (file_path(name), self.interface.find(name)) {
            (Some(path), _) => (number_in_file(self.text, &path).map_err(|cause| refused(name, &cause))?, "", SMALL),
            (None, Some(row)) => match self.interface.get(plant, plant.outputs(), row.value_reference) {
                Some(Value::Real(value)) => {
                    (value, row.unit(), if row.causality == Causality::Input { SMALL_INPUT } else { SMALL })
                }
                Some(Value::Integer(_) | Value::Boolean(_)) | None => {
                    return Err(refused(name, "is not a real number"));
                }
            },
            (None, None) => return Err(refused(name, "is not an input or parameter")),
        };
        let with = |step: f64| Parameter::new(name, value, step, |value| self.plant(name, value));
        let parameter = match value.abs() {
            0.0 => with(STEP)?,
            // a number that may only change by shares of itself
            size if size < small.0 => with(small.1).or_else(|_| with(STEP * size))?,
            size => with(STEP * size)?,
        };
        Ok(Numbers { by: vec![By { name: name.to_owned(), value, unit }], parameter })
    }

    /// The plant for another value of a quantity.
    fn plant(&self, name: &str, value: f64) -> Result<Plant, Failure> {
        let text = format!("{value:?}");
        match file_path(name) {
            Some(path) => {
                let machine = changed_machine((self.file, self.text), "--by", &[(path, &text)])?;
                let interface = Interface::new(&machine);
                plant_with(machine, &interface, self.settings)
            }
            None => {
                let mut plant = plant_with(Arc::clone(&self.machine), self.interface, self.settings)?;
                apply_setting("--by", &format!("{name}={text}"), self.interface, &mut plant)?;
                Ok(plant)
            }
        }
    }
}

/// Reason why a quantity is no parameter: settings of a computation.
fn setting(name: &str) -> Option<&'static str> {
    let path = name.strip_prefix("file:").unwrap_or(name);
    if path.starts_with("solver.") {
        return Some("is a setting of the integrator: derivatives are computed for fixed time steps");
    }
    if path.starts_with("simulation.") {
        return Some("is a setting of the run: use the rate of the result, or the time of a row of --inputs");
    }
    let last = path.rsplit('.').next().unwrap_or_default();
    let of_coupling = path.starts_with("aerodynamics.") && matches!(last, "coupling_tolerance" | "coupling_iterations");
    of_coupling.then_some("is a setting of the coupling: derivatives are those of its solution")
}

fn refused(name: &str, cause: &str) -> Failure {
    Failure::Usage(format!("--by {name}: {cause}"))
}

/// Converts the error of a gradient to a message of the command.
fn failure(error: GradientsError) -> Failure {
    match error {
        GradientsError::Quantity { of, error } => {
            let cause = match &error {
                QuantityError::Name(error) => name_message::<Variable>(error),
                QuantityError::Time(_)
                | QuantityError::Outside { .. }
                | QuantityError::Corner { .. }
                | QuantityError::Zero => error.to_string(),
            };
            Failure::Usage(format!("--of {of}: {cause}"))
        }
        GradientsError::NoResult => Failure::Usage(format!("--of: {error}")),
        GradientsError::Stop { stop_s, start_s } => {
            Failure::Usage(format!("--stop {stop_s}: must be after the start time, {start_s} s"))
        }
        GradientsError::Gradient(error) => Failure::Statics(error.to_string()),
        GradientsError::Run(error) => Failure::Simulation(error.to_string()),
    }
}

/// Returns the result as a text table.
fn text_of(found: &Gradients) -> String {
    let mode = match found.mode {
        Mode::Adjoint => "adjoint",
        Mode::Forward | Mode::Auto => "forward",
    };
    let Gradients { name, start_s, stop_s, steps, by, of, .. } = found;
    let mut text =
        format!("{name}: derivatives of the run from {} to {} s, {steps} steps, {mode}\n", six(*start_s), six(*stop_s));
    let width = by.iter().map(|number| number.name.len()).chain([4]).max().unwrap_or(0);
    for Derivatives { name, time_s, value, unit, derivatives } in of {
        let _ = writeln!(text, "{name} = {}{} at {} s", six(*value), spaced(unit), six(*time_s));
        let _ = writeln!(text, "  {:<width$}  {:>14}  {:>14}  {:>14}", "by", "value", "derivative", "per 1 %");
        for (number, derivative) in by.iter().zip(derivatives) {
            let per_cent = 0.01 * number.value * derivative;
            let _ = writeln!(
                text,
                "  {:<width$}  {:>14}  {:>14}  {:>14}",
                number.name,
                format!("{}{}", six(number.value), spaced(number.unit)),
                six(*derivative),
                six(per_cent)
            );
        }
    }
    text
}

fn spaced(unit: &str) -> String {
    if unit.is_empty() || unit == "1" { String::new() } else { format!(" {unit}") }
}
