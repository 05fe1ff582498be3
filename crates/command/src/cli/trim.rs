//! `foldwing trim`: values of inputs and parameters for which outputs at rest are what they should be.

use crate::cli::attitude::{Attitude, Turn, Turns};
use crate::cli::settings::{apply_setting, plant_with};
use crate::cli::simulate::unknown;
use crate::cli::{Failure, print, read_model, tell};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};
use foldwing_study::doubts;
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
/// Smallest singular value of the slopes over the largest, above which the free values count as independent: their differences
/// are good to about 1e-7.
const INDEPENDENT: f64 = 1e-6;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::TRIM)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Input or parameter to solve for, or `attitude.roll`, `attitude.pitch`, `attitude.yaw`, which turn the model relative to gravity and
    /// wind, or `turn.rate` of a steady turn to the right; as many as there are targets. Names joined by commas share a value, `-NAME`
    /// takes its negative
    #[arg(long = "solve-for", value_name = "NAME", required = true, value_parser = NonEmptyStringValueParser::new())]
    free: Vec<String>,
    /// Output and its target value at equilibrium, in SI units; may be repeated. The forces and moments on free joints are always
    /// balanced too
    #[arg(long = "target", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    balance: Vec<String>,
    /// Start value of an input or parameter, or of `attitude.roll`, `attitude.pitch`, `attitude.yaw` in rad and
    /// `turn.rate` in rad/s; of those to solve for the initial guess; may be repeated
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

/// An unknown of the trim.
enum Unknown<'a> {
    /// The value of inputs or parameters, of the first one; each takes it with its sign.
    Value { name: String, rows: Vec<(f64, &'a Variable)> },
    /// A turn of the machine against gravity and wind.
    Turn(Turn),
}

impl Unknown<'_> {
    fn name(&self) -> &str {
        match self {
            Self::Value { name, .. } => name,
            Self::Turn(turn) => turn.name(),
        }
    }

    fn unit(&self) -> &str {
        match self {
            Self::Value { rows, .. } => rows[0].1.unit(),
            Self::Turn(turn) => turn.unit(),
        }
    }
}

/// The machine at rest as a function of the free values.
struct Trim<'a> {
    interface: &'a Interface,
    plant: Plant,
    free: Vec<Unknown<'a>>,
    balances: Vec<Balance<'a>>,
    /// Names and units of the loads on free joints, which must vanish.
    loads: Vec<(String, &'static str)>,
    /// Gravity and wind that attitude turns.
    attitude: Attitude,
    /// Turns that are given, or first guesses.
    turns: Turns,
    /// The root turns with the machine.
    turning: bool,
}

/// Finds the trim.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let balances = arguments.balance.iter().map(|text| parsed(text)).collect::<Result<Vec<_>, _>>()?;
    let is_turn = |text: &&String| text.split_once('=').is_some_and(|(name, _)| Turn::named(name).is_some());
    let (turns, settings): (Vec<&String>, Vec<&String>) = arguments.settings.iter().partition(is_turn);
    let settings: Vec<String> = settings.into_iter().cloned().collect();
    let turns = turns.into_iter().map(|text| parsed_as("--set", text)).collect::<Result<Vec<_>, _>>()?;
    let plant = plant_with(machine, &interface, &settings)?;
    let mut trim = Trim::new(&interface, plant, &arguments.free, &balances, &turns)?;
    let (values, left, steps) = trim.find()?;
    doubts::balance(trim.plant.machine()).iter().for_each(|doubt| tell::warning(&doubt.to_string()));
    if arguments.json {
        return print(&format!("{:#}", trim.as_json(&values, steps)));
    }
    print(&trim.text(&values, &left, steps))
}

/// The trim of a plant that is not yet initialised, for programs.
pub(super) fn found(
    interface: &Interface,
    plant: Plant,
    free: &[String],
    balances: &[(String, f64)],
    turns: &[(String, f64)],
) -> Result<serde_json::Value, Failure> {
    let mut trim = Trim::new(interface, plant, free, balances, turns)?;
    let (values, _, steps) = trim.find()?;
    Ok(trim.as_json(&values, steps))
}

/// `NAME=VALUE` of a balance.
fn parsed(text: &str) -> Result<(String, f64), Failure> {
    parsed_as("--target", text)
}

/// `NAME=VALUE` of an option.
fn parsed_as(option: &str, text: &str) -> Result<(String, f64), Failure> {
    let refused = |cause: &str| Failure::Usage(format!("{option} {text}: {cause}"));
    let (name, value) = text.split_once('=').ok_or_else(|| refused("must be NAME=VALUE"))?;
    let value = value.trim().parse().map_err(|_| refused("the value is not a finite number"))?;
    Ok((name.to_owned(), value))
}

/// A real input or parameter, several that share a value, or a turn.
fn unknown_of<'a>(name: &str, interface: &'a Interface) -> Result<Unknown<'a>, Failure> {
    if let Some(turn) = Turn::named(name) {
        return Ok(Unknown::Turn(turn));
    }
    let refused = |cause: &str| Failure::Usage(format!("--solve-for {name}: {cause}"));
    let signed = |part: &str| {
        let (sign, part) = part.strip_prefix('-').map_or((1.0, part), |part| (-1.0, part));
        let row = interface.find(part).ok_or_else(|| unknown(part, "input or parameter", interface.variables()))?;
        let changes = matches!(row.causality, Causality::Input | Causality::Parameter);
        if changes && matches!(row.value, Value::Real(_)) {
            return Ok((sign, row));
        }
        Err(refused("is not a real input or parameter; only their values can be sought"))
    };
    let rows = name.split(',').map(|part| signed(part.trim())).collect::<Result<Vec<_>, _>>()?;
    if rows.iter().any(|(_, row)| row.unit() != rows[0].1.unit()) {
        return Err(refused("inputs with different units cannot share a value"));
    }
    Ok(Unknown::Value { name: name.to_owned(), rows })
}

/// Refuses values and outputs that are named twice: one of them would have no effect, or two would work against each other.
fn refuse_repeated(free: &[Unknown], balances: &[Balance]) -> Result<(), Failure> {
    let twice = |option: &str, name: &str| {
        Err(Failure::Usage(format!("--{option} {name}: is named twice; name each value once")))
    };
    let (mut rows, mut turns) = (Vec::new(), Vec::new());
    for unknown in free {
        match unknown {
            Unknown::Value { rows: own, .. } => {
                for (_, row) in own {
                    if rows.contains(&row.value_reference) {
                        return twice("solve-for", &row.name);
                    }
                    rows.push(row.value_reference);
                }
            }
            Unknown::Turn(turn) => {
                if turns.contains(turn) {
                    return twice("solve-for", turn.name());
                }
                turns.push(*turn);
            }
        }
    }
    let mut outputs = Vec::new();
    for Balance { row, .. } in balances {
        if outputs.contains(&row.value_reference) {
            return twice("target", &row.name);
        }
        outputs.push(row.value_reference);
    }
    Ok(())
}

/// A real output with the value that it shall have.
fn balance<'a>((name, target): &(String, f64), interface: &'a Interface) -> Result<Balance<'a>, Failure> {
    let refused = |cause: &str| Failure::Usage(format!("--target {name}={target}: {cause}"));
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
    /// The problem: `free` are names, `balances` names with targets, as many of one as of the other. Machines with free
    /// joints can have more free values, up to six for each of these joints.
    fn new(
        interface: &'a Interface,
        plant: Plant,
        free: &[String],
        balances: &[(String, f64)],
        turns: &[(String, f64)],
    ) -> Result<Self, Failure> {
        let free = free.iter().map(|name| unknown_of(name, interface)).collect::<Result<Vec<_>, _>>()?;
        let balances = balances.iter().map(|own| balance(own, interface)).collect::<Result<Vec<_>, _>>()?;
        let loads: Vec<_> = plant.flying_joints().iter().flat_map(|joint| loads_on(joint)).collect();
        if free.len() < balances.len() || free.len() > balances.len() + loads.len() {
            let needed = match loads.len() {
                0 => "as many of one as of the other are needed".to_owned(),
                loads => format!("from {} to {} free values are needed", balances.len().max(1), balances.len() + loads),
            };
            return Err(Failure::Usage(format!(
                "--solve-for and --target: {} free values for {} balances; {needed}",
                free.len(),
                balances.len()
            )));
        }
        refuse_repeated(&free, &balances)?;
        if free.is_empty() {
            return Err(Failure::Usage(
                "trim: nothing is free; name an input or parameter, and the output that it balances".to_owned(),
            ));
        }
        let attitude = Attitude::of(&plant);
        let mut given: Turns = [0.0; 4];
        let mut turning = false;
        for (name, value) in turns {
            let Some(turn) = Turn::named(name).filter(|_| value.is_finite()) else {
                return Err(Failure::Usage(format!("--set {name}={value}: the value is not a finite number")));
            };
            attitude.check("--set", turn)?;
            given[turn as usize] = *value;
            turning |= turn == Turn::Rate;
        }
        for unknown in &free {
            if let Unknown::Turn(turn) = unknown {
                attitude.check("--solve-for", *turn)?;
                turning |= *turn == Turn::Rate;
            }
        }
        Ok(Self { interface, plant, free, balances, loads, attitude, turns: given, turning })
    }

    /// The result for people.
    fn text(&self, values: &DVector<f64>, left: &DVector<f64>, steps: usize) -> String {
        let mut text = format!("{} in trim after {steps} steps\n", self.plant.machine().name);
        for (free, value) in self.free.iter().zip(values.iter()) {
            let _ = writeln!(text, "{} = {value:?} {}", free.name(), free.unit());
        }
        for ((own, value), left) in self.balances.iter().zip(self.outputs()).zip(left.iter()) {
            let _ = writeln!(text, "{}: {value:.9e} {}, off by {:.1e}", own.row.name, own.row.unit(), left.abs());
        }
        for ((name, unit), left) in self.loads.iter().zip(left.iter().skip(self.balances.len())) {
            let _ = writeln!(text, "{name}: {:.1e} {unit}", left.abs());
        }
        let settings: Vec<String> =
            self.settings(values).iter().map(|(name, value)| format!("--set {name}={value:?}")).collect();
        let _ = write!(text, "for other commands: {}", settings.join(" "));
        text
    }

    /// The result for programs.
    fn as_json(&self, values: &DVector<f64>, steps: usize) -> serde_json::Value {
        let free: serde_json::Map<_, _> =
            self.free.iter().zip(values.iter()).map(|(free, value)| (free.name().to_owned(), json!(value))).collect();
        let outputs = self.outputs();
        let balances: serde_json::Map<_, _> =
            self.balances.iter().zip(outputs.iter()).map(|(own, value)| (own.row.name.clone(), json!(value))).collect();
        let settings: serde_json::Map<_, _> =
            self.settings(values).into_iter().map(|(name, value)| (name, json!(value))).collect();
        json!({
            "name": self.plant.machine().name, "free": free, "balances": balances, "settings": settings, "steps": steps,
            "doubts": doubts::balance(self.plant.machine()),
        })
    }

    /// Start values of inputs and parameters that put the machine into the state of the free values.
    fn settings(&self, values: &DVector<f64>) -> Vec<(String, f64)> {
        let mut list = Vec::new();
        let mut attitude = self.attitude.clone();
        let (mut turns, mut sought) = (self.turns, Vec::new());
        for (free, &value) in self.free.iter().zip(values.iter()) {
            match free {
                Unknown::Value { rows, .. } => {
                    for (sign, row) in rows {
                        if attitude.take(&row.name, sign * value) {
                            sought.push(row.name.as_str());
                        } else {
                            list.push((row.name.clone(), sign * value));
                        }
                    }
                }
                Unknown::Turn(turn) => turns[*turn as usize] = value,
            }
        }
        let turned = turns != [0.0; 4] || self.free.iter().any(|free| matches!(free, Unknown::Turn(_)));
        let all = attitude.turned(turns, self.turning);
        list.extend(all.into_iter().filter(|(name, _)| turned || sought.contains(&name.as_str())));
        list
    }

    /// Free values, what is left of the balances, and steps: Newton's iteration, with shorter steps where it does not lead
    /// nearer, NOTATION eq. (Q7); with more balances than free values, as the loads of a flight that is symmetric, by least
    /// squares.
    fn find(&mut self) -> Result<(DVector<f64>, DVector<f64>, usize), Failure> {
        let count = self.free.len();
        let mut values = DVector::from_iterator(count, self.free.iter().map(|free| self.value_of(free)));
        let mut left = self.left(&values)?;
        let rows = left.len();
        let mut sizes = self.sizes(&left);
        for steps in 0..MAXIMUM_STEPS {
            if measure(&left, &sizes) <= TOLERANCE {
                // the machine stands at these values
                self.left(&values)?;
                return Ok((values, left, steps));
            }
            let mut slopes = DMatrix::zeros(rows, count);
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
            for (i, size) in sizes.iter_mut().enumerate().take(self.balances.len()) {
                let moved = (0..count).map(|j| slopes[(i, j)].abs() * values[j].abs().max(1.0)).fold(0.0, f64::max);
                *size = size.max(1e-3 * moved);
            }
            let Some(change) = step_towards(&slopes, &left, &sizes) else {
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
                return Err(self.failed("no step reduces what is left", &left));
            };
            (values, left) = found;
        }
        Err(self.failed("the iteration does not end", &left))
    }

    /// Reference size of each balance: its target or its first distance; for loads on free joints the weight or the largest load.
    fn sizes(&mut self, left: &DVector<f64>) -> DVector<f64> {
        let study = self.plant.study();
        let (size_n, length_m) = (study.flight_scale_n(), study.flight_length_m());
        let balances = self.balances.iter().zip(left.iter()).map(|(own, left)| own.target.abs().max(left.abs()));
        let loads = (0..self.loads.len()).map(|i| if i % 6 < 3 { size_n } else { size_n * length_m });
        DVector::from_iterator(left.len(), balances.chain(loads))
    }

    fn failed(&self, cause: &str, left: &DVector<f64>) -> Failure {
        let outputs = self.balances.iter().map(|own| (own.row.name.as_str(), own.row.unit()));
        let loads = self.loads.iter().map(|(name, unit)| (name.as_str(), *unit));
        let list: Vec<String> = outputs
            .chain(loads)
            .zip(left.iter())
            .map(|((name, unit), left)| format!("{name} {left:+.3e} {unit}"))
            .collect();
        Failure::Statics(format!(
            "no trim: {cause}; left of the balances: {}; give other first guesses with --set, or other free values",
            list.join(", ")
        ))
    }

    /// The machine at rest for free values; what is left of the balances, and the loads on free joints.
    fn left(&mut self, values: &DVector<f64>) -> Result<DVector<f64>, Failure> {
        for (name, value) in self.settings(values) {
            apply_setting("--solve-for", &format!("{name}={value:?}"), self.interface, &mut self.plant)?;
        }
        let time_s = self.plant.machine().experiment.start_time_s;
        let rest = self.plant.study().rest_held_in_flight(time_s);
        let loads = rest.map_err(|error| Failure::Statics(error.to_string()))?;
        let outputs = self.outputs();
        let balances = self.balances.iter().zip(outputs.iter()).map(|(own, value)| value - own.target);
        let loads = loads
            .iter()
            .flat_map(|load| load.force_n.iter().chain(load.moment_n_m.iter()).copied().collect::<Vec<_>>());
        Ok(DVector::from_vec(balances.chain(loads).collect()))
    }

    /// Outputs of the balances.
    fn outputs(&self) -> Vec<f64> {
        self.balances.iter().map(|own| self.value(own.row)).collect()
    }

    /// First guess of an unknown.
    fn value_of(&self, free: &Unknown) -> f64 {
        match free {
            Unknown::Value { rows, .. } => rows[0].0 * self.value(rows[0].1),
            Unknown::Turn(turn) => self.turns[*turn as usize],
        }
    }

    fn value(&self, row: &Variable) -> f64 {
        match self.interface.get(&self.plant, self.plant.outputs(), row.value_reference) {
            Some(Value::Real(value)) => value,
            _ => 0.0,
        }
    }
}

/// Names of the loads on a free joint, with their units.
fn loads_on(joint: &str) -> impl Iterator<Item = (String, &'static str)> {
    let named =
        |part: &'static str, unit: &'static str| ["x", "y", "z"].map(|axis| (format!("{joint}: {part} {axis}"), unit));
    named("force", "N").into_iter().chain(named("moment", "N.m"))
}

/// Largest balance over its size.
fn measure(left: &DVector<f64>, sizes: &DVector<f64>) -> f64 {
    left.iter()
        .zip(sizes.iter())
        .fold(0.0f64, |largest, (left, size)| largest.max(if *size > 0.0 { left.abs() / size } else { 0.0 }))
}

/// Change of the free values that minimises the balances relative to their sizes; `None` if the free values are not independent.
fn step_towards(slopes: &DMatrix<f64>, left: &DVector<f64>, sizes: &DVector<f64>) -> Option<DVector<f64>> {
    let (mut rows, mut right) = (slopes.clone(), left.clone());
    for (i, size) in sizes.iter().enumerate().filter(|(_, size)| **size > 0.0) {
        rows.row_mut(i).unscale_mut(*size);
        right[i] /= size;
    }
    let change = if rows.is_square() {
        rows.lu().solve(&right)
    } else {
        // columns of one size, so that a value without effect shows
        let columns: Vec<f64> = rows.column_iter().map(|column| column.norm()).collect();
        for (mut column, size) in rows.column_iter_mut().zip(&columns) {
            column.unscale_mut(if *size > 0.0 { *size } else { 1.0 });
        }
        let parts = rows.svd(true, true);
        let independent = parts.singular_values.min() > INDEPENDENT * parts.singular_values.max();
        let found = if independent { parts.solve(&right, 0.0).ok() } else { None };
        found.map(|found| DVector::from_iterator(columns.len(), found.iter().zip(&columns).map(|(x, size)| x / size)))
    };
    change.filter(|change| change.iter().all(|x| x.is_finite()))
}

#[cfg(test)]
#[path = "trim_tests.rs"]
mod tests;
