//! `foldwing trim`: values of inputs and parameters for which outputs at rest are what they should be.

use crate::cli::settings::{apply_setting, plant_with};
use crate::cli::simulate::unknown;
use crate::cli::{Failure, print, read_model};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::{Holding, Plant};
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};
use nalgebra::{DMatrix, DVector};
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

/// Step of the differences over the size of an unknown, or in its SI unit where that is smaller.
const STEP: f64 = 1e-4;
/// What may be left of a balance, over its size.
const TOLERANCE: f64 = 1e-9;
/// Newton steps.
const MAXIMUM_STEPS: usize = 40;
/// Halvings of a step that does not lead nearer.
const MAXIMUM_HALVINGS: usize = 12;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::TRIM)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Input or parameter whose value is sought; as many as there are balances
    #[arg(long, value_name = "NAME", required = true, value_parser = NonEmptyStringValueParser::new())]
    free: Vec<String>,
    /// Output and the value that it shall have at rest, in SI units; may be repeated
    #[arg(long, value_name = "NAME=VALUE", required = true, value_parser = NonEmptyStringValueParser::new())]
    balance: Vec<String>,
    /// Start value of an input or parameter; of those that are free the first guess; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
}

/// An output with the value that it shall have.
struct Balance<'a> {
    row: &'a Variable,
    target: f64,
}

/// The machine at rest as a function of the free values.
struct Trim<'a> {
    interface: &'a Interface,
    plant: Plant,
    free: Vec<&'a Variable>,
    balances: Vec<Balance<'a>>,
}

/// Finds the trim.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let balances = arguments.balance.iter().map(|text| parsed(text)).collect::<Result<Vec<_>, _>>()?;
    let plant = plant_with(machine, &interface, &arguments.settings)?;
    let mut trim = Trim::new(&interface, plant, &arguments.free, &balances)?;
    let (values, left, steps) = trim.find()?;
    if arguments.json {
        return print(&format!("{:#}", trim.as_json(&values, steps)));
    }
    let mut text = format!("{} in trim after {steps} steps\n", trim.plant.machine().name);
    for (row, value) in trim.free.iter().zip(values.iter()) {
        let _ = writeln!(text, "{} = {value:?} {}", row.name, row.unit());
    }
    for ((own, value), left) in trim.balances.iter().zip(trim.outputs().iter()).zip(left.iter()) {
        let _ = writeln!(text, "{}: {value:.9e} {}, off by {:.1e}", own.row.name, own.row.unit(), left.abs());
    }
    let settings: Vec<String> =
        trim.free.iter().zip(values.iter()).map(|(row, value)| format!("--set {}={value:?}", row.name)).collect();
    let _ = write!(text, "for other commands: {}", settings.join(" "));
    print(&text)
}

/// The trim of a plant that is not yet initialised, for programs.
pub(super) fn found(
    interface: &Interface,
    plant: Plant,
    free: &[String],
    balances: &[(String, f64)],
) -> Result<serde_json::Value, Failure> {
    let mut trim = Trim::new(interface, plant, free, balances)?;
    let (values, _, steps) = trim.find()?;
    Ok(trim.as_json(&values, steps))
}

/// `NAME=VALUE` of a balance.
fn parsed(text: &str) -> Result<(String, f64), Failure> {
    let refused = |cause: &str| Failure::Usage(format!("--balance {text}: {cause}"));
    let (name, value) = text.split_once('=').ok_or_else(|| refused("must be NAME=VALUE"))?;
    let value = value.trim().parse().map_err(|_| refused("the value is not a finite number"))?;
    Ok((name.to_owned(), value))
}

/// A real input or parameter.
fn free_row<'a>(name: &str, interface: &'a Interface) -> Result<&'a Variable, Failure> {
    let row = interface.find(name).ok_or_else(|| unknown(name, "input or parameter", interface.variables()))?;
    let changes = matches!(row.causality, Causality::Input | Causality::Parameter);
    if changes && matches!(row.value, Value::Real(_)) {
        return Ok(row);
    }
    Err(Failure::Usage(format!("--free {name}: is not a real input or parameter; only their values can be sought")))
}

/// A real output with the value that it shall have.
fn balance<'a>((name, target): &(String, f64), interface: &'a Interface) -> Result<Balance<'a>, Failure> {
    let refused = |cause: &str| Failure::Usage(format!("--balance {name}={target}: {cause}"));
    let row = interface.find(name).ok_or_else(|| unknown(name, "output", interface.variables()))?;
    if row.causality != Causality::Output || !matches!(row.value, Value::Real(_)) {
        return Err(refused("is not a real output"));
    }
    if !target.is_finite() {
        return Err(refused("the value is not a finite number"));
    }
    Ok(Balance { row, target: *target })
}

impl<'a> Trim<'a> {
    /// The problem: `free` are names, `balances` names with targets, as many of one as of the other.
    fn new(
        interface: &'a Interface,
        plant: Plant,
        free: &[String],
        balances: &[(String, f64)],
    ) -> Result<Self, Failure> {
        let free = free.iter().map(|name| free_row(name, interface)).collect::<Result<Vec<_>, _>>()?;
        let balances = balances.iter().map(|own| balance(own, interface)).collect::<Result<Vec<_>, _>>()?;
        if free.len() != balances.len() {
            return Err(Failure::Usage(format!(
                "--free and --balance: {} free values for {} balances; as many of one as of the other are needed",
                free.len(),
                balances.len()
            )));
        }
        if free.is_empty() {
            return Err(Failure::Usage(
                "trim: nothing is free; name an input or parameter, and the output that it balances".to_owned(),
            ));
        }
        Ok(Self { interface, plant, free, balances })
    }

    /// The result for programs.
    fn as_json(&self, values: &DVector<f64>, steps: usize) -> serde_json::Value {
        let free: serde_json::Map<_, _> =
            self.free.iter().zip(values.iter()).map(|(row, value)| (row.name.clone(), json!(value))).collect();
        let outputs = self.outputs();
        let balances: serde_json::Map<_, _> =
            self.balances.iter().zip(outputs.iter()).map(|(own, value)| (own.row.name.clone(), json!(value))).collect();
        json!({ "name": self.plant.machine().name, "free": free, "balances": balances, "steps": steps })
    }

    /// Free values, what is left of the balances, and steps: Newton's iteration, with shorter steps where it does not lead
    /// nearer, NOTATION eq. (Q7).
    fn find(&mut self) -> Result<(DVector<f64>, DVector<f64>, usize), Failure> {
        let count = self.free.len();
        let mut values = DVector::from_iterator(count, self.free.iter().map(|row| self.value(row)));
        let mut left = self.left(&values)?;
        let mut sizes = DVector::from_iterator(
            count,
            self.balances.iter().zip(left.iter()).map(|(own, left)| own.target.abs().max(left.abs())),
        );
        let measure = |left: &DVector<f64>, sizes: &DVector<f64>| {
            left.iter()
                .zip(sizes.iter())
                .fold(0.0f64, |most, (left, size)| most.max(if *size > 0.0 { left.abs() / size } else { 0.0 }))
        };
        for steps in 0..MAXIMUM_STEPS {
            if measure(&left, &sizes) <= TOLERANCE {
                // the machine stands at these values
                self.left(&values)?;
                return Ok((values, left, steps));
            }
            let mut slopes = DMatrix::zeros(count, count);
            for i in 0..count {
                let step = STEP * values[i].abs().max(1.0);
                let [above, below] = [1.0, -1.0].map(|sign| {
                    let mut beside = values.clone();
                    beside[i] += sign * step;
                    self.left(&beside)
                });
                slopes.set_column(i, &((above? - below?) / (2.0 * step)));
            }
            // of a balance that is zero in the beginning, what the free values move
            for (i, size) in sizes.iter_mut().enumerate() {
                let moved = (0..count).map(|j| slopes[(i, j)].abs() * values[j].abs().max(1.0)).fold(0.0, f64::max);
                *size = size.max(1e-3 * moved);
            }
            let change = slopes.lu().solve(&left).filter(|change| change.iter().all(|x| x.is_finite()));
            let Some(change) = change else {
                return Err(self.failed("the balances do not change independently with the free values", &left));
            };
            let (before, mut share) = (measure(&left, &sizes), 1.0);
            let nearer = (0..=MAXIMUM_HALVINGS).find_map(|_| {
                let beside = &values - &change * share;
                share *= 0.5;
                let found = self.left(&beside).ok()?;
                (measure(&found, &sizes) < before).then_some((beside, found))
            });
            let Some(found) = nearer else {
                return Err(self.failed("no step leads nearer", &left));
            };
            (values, left) = found;
        }
        Err(self.failed("the iteration does not end", &left))
    }

    fn failed(&self, cause: &str, left: &DVector<f64>) -> Failure {
        let list: Vec<String> = self
            .balances
            .iter()
            .zip(left.iter())
            .map(|(own, left)| format!("{} {left:+.3e} {}", own.row.name, own.row.unit()))
            .collect();
        Failure::Statics(format!(
            "no trim: {cause}; left of the balances: {}; give other first guesses with --set, or other free values",
            list.join(", ")
        ))
    }

    /// The machine at rest for free values; what is left of the balances.
    fn left(&mut self, values: &DVector<f64>) -> Result<DVector<f64>, Failure> {
        for (row, value) in self.free.iter().zip(values.iter()) {
            apply_setting("--free", &format!("{}={value:?}", row.name), self.interface, &mut self.plant)?;
        }
        let time_s = self.plant.machine().experiment.start_time_s;
        let rest = self.plant.study().equilibrium(time_s, Holding::AsReleased);
        rest.map_err(|error| Failure::Statics(error.to_string()))?;
        let targets = DVector::from_iterator(self.balances.len(), self.balances.iter().map(|own| own.target));
        Ok(self.outputs() - targets)
    }

    /// Outputs of the balances.
    fn outputs(&self) -> DVector<f64> {
        DVector::from_iterator(self.balances.len(), self.balances.iter().map(|own| self.value(own.row)))
    }

    fn value(&self, row: &Variable) -> f64 {
        match self.interface.get(&self.plant, self.plant.outputs(), row.value_reference) {
            Some(Value::Real(value)) => value,
            _ => 0.0,
        }
    }
}
