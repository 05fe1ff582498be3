//! `foldwing gradient`: derivatives of results of a run by numbers of the model.

use crate::cli::number::six;
use crate::cli::settings::{apply_setting, plant_with};
use crate::cli::sweep::{changed_machine, file_path, number_in_file};
use crate::cli::{Failure, print, read_model, shown};
use crate::report::inputs::name_message;
use clap::ValueEnum;
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Parameter, Plant};
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};
use foldwing_study::names;
use foldwing_study::sensitivity::{
    Derivatives, Gradients, GradientsError, Mode, Number, Options, QuantityError, differentiate,
};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// Step of differences over machines, as a share of the number; its SI unit stands for zero.
const STEP: f64 = 1e-3;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::GRADIENT)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Result to differentiate: a real output at the end of the run (NAME) or at a time (NAME@TIME in s), its largest, least or
    /// absolutely largest value over the run (max(NAME), min(NAME), peak(NAME)), or JOINT.latch_time. Vectors and patterns stand for their
    /// components; may be repeated, or a list with commas
    #[arg(long = "of", value_name = "RESULT", required = true, value_parser = NonEmptyStringValueParser::new())]
    of: Vec<String>,
    /// Number by which to differentiate: a real input or parameter, constant during the run, or a key of the model file
    /// (file:body.inner.length_m); may be repeated, or a list with commas
    #[arg(long = "by", value_name = "NAME", required = true, value_parser = NonEmptyStringValueParser::new())]
    by: Vec<String>,
    /// Stop time in s [default: the model's]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    stop: Option<f64>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Order of the multiplication: forward costs one pass for each number, adjoint one for each result
    #[arg(long, value_name = "MODE", value_enum, default_value = "auto")]
    mode: Order,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Order {
    /// The cheaper one
    Auto,
    /// One pass for each number
    Forward,
    /// One pass for each result
    Adjoint,
}

/// Computes and prints the derivatives.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, text) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let options = Options {
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
    };
    let found = model.gradients(&arguments.by, &options)?;
    if arguments.json {
        let json = serde_json::to_string_pretty(&found);
        return print(&json.map_err(|error| Failure::Refused(error.to_string()))?);
    }
    print(&text_of(&found))
}

/// A model whose numbers are varied.
pub(super) struct Variants<'a> {
    /// Name of the model file, for messages.
    pub file: &'a str,
    /// Its text.
    pub text: &'a str,
    /// Its machine.
    pub machine: Arc<Machine>,
    /// The machine's variables.
    pub interface: &'a Interface,
    /// `NAME=VALUE` of start values common to all variants.
    pub settings: &'a [String],
}

impl Variants<'_> {
    /// The derivatives by the numbers of `by`.
    pub fn gradients(&self, by: &[String], options: &Options) -> Result<Gradients, Failure> {
        let plant = plant_with(Arc::clone(&self.machine), self.interface, self.settings)?;
        let mut numbers = Vec::new();
        for name in self.names(by)? {
            numbers.push(self.number(&name, &plant)?);
        }
        differentiate(plant, numbers, options).map_err(failure)
    }

    /// The names of a list, with those that patterns and vectors stand for.
    fn names(&self, by: &[String]) -> Result<Vec<String>, Failure> {
        let settable = |row: &&Variable| {
            matches!(row.causality, Causality::Input | Causality::Parameter) && matches!(row.value, Value::Real(_))
        };
        let rows: Vec<&Variable> = self.interface.variables().iter().filter(settable).collect();
        let mut list: Vec<String> = Vec::new();
        for name in by.iter().flat_map(|list| names::split(list)) {
            let found = match file_path(name) {
                Some(_) => vec![name.to_owned()],
                None => names::choose(&[name.to_owned()], &rows, names::of_variable, "real input or parameter")
                    .map_err(|error| Failure::Usage(format!("--by {name}: {}", name_message::<Variable>(&error))))?
                    .into_iter()
                    .map(|row| row.name.clone())
                    .collect(),
            };
            for name in found {
                if list.contains(&name) {
                    return Err(Failure::Usage(format!("--by {name}: is named twice")));
                }
                list.push(name);
            }
        }
        Ok(list)
    }

    /// A number with the machines beside the present one.
    fn number(&self, name: &str, plant: &Plant) -> Result<Number, Failure> {
        if name.starts_with("solver.") || name.starts_with("file:solver.") {
            return Err(refused(
                name,
                "is a setting of the integrator: the steps of the run are those of the derivative",
            ));
        }
        let (value, unit) = match (file_path(name), self.interface.find(name)) {
            (Some(path), _) => (number_in_file(self.text, &path).map_err(|cause| refused(name, &cause))?, ""),
            (None, Some(row)) => match self.interface.get(plant, plant.outputs(), row.value_reference) {
                Some(Value::Real(value)) => (value, row.unit()),
                Some(Value::Integer(_) | Value::Boolean(_)) | None => {
                    return Err(refused(name, "is not a real number"));
                }
            },
            (None, None) => return Err(refused(name, "is no input or parameter")),
        };
        let step = if value == 0.0 { STEP } else { STEP * value.abs() };
        let parameter = Parameter::new(name, value, step, |value| self.plant(name, value))?;
        Ok(Number { name: name.to_owned(), value, unit, parameter })
    }

    /// The plant for another value of a number.
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

fn refused(name: &str, cause: &str) -> Failure {
    Failure::Usage(format!("--by {name}: {cause}"))
}

/// The error of a gradient in the words of the command.
fn failure(error: GradientsError) -> Failure {
    match error {
        GradientsError::Quantity { of, error } => {
            let cause = match &error {
                QuantityError::Name(error) => name_message::<Variable>(error),
                QuantityError::Time(_) | QuantityError::Outside { .. } | QuantityError::Corner { .. } => {
                    error.to_string()
                }
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

/// The table for people.
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
