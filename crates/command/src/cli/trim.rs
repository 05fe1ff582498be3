//! `foldwing trim`: solves for inputs and parameters with which outputs reach target values at equilibrium.

use crate::cli::number::six;
use crate::cli::outlets::Quiet;
use crate::cli::progress::Progress;
use crate::cli::settings::{plant_with, refusal};
use crate::cli::{Failure, print, read_model};
use crate::report::inputs::name_message;
use clap::builder::NonEmptyStringValueParser;
use foldwing_fmi::interface::{Interface, Variable};
use foldwing_study::names::shortened;
use foldwing_study::trim::{
    Balanced, Options, Residual, Solved, Target, TargetError, Trim, TrimError, Turn, solve_watched,
};
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::TRIM)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Input or parameter to solve for, or `attitude.roll`, `attitude.pitch`, `attitude.yaw`, which rotate the model relative to gravity
    /// and wind, or `turn.rate` of a steady turn to the right; as many as there are targets. Names joined by commas share a value; `-NAME`
    /// gets the negative of this value
    #[arg(long = "solve-for", value_name = "NAME", required = true, value_parser = NonEmptyStringValueParser::new())]
    free: Vec<String>,
    /// Output and its target value at equilibrium, in SI units; may be repeated. The forces and moments on free joints are always
    /// balanced too
    #[arg(long = "target", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    balance: Vec<String>,
    /// Start value of an input or parameter, or of `attitude.roll`, `attitude.pitch`, `attitude.yaw` in rad and
    /// `turn.rate` in rad/s; for an unknown, the initial guess; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: Quiet,
}

/// Finds the trim.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let targets = arguments.balance.iter().map(|text| {
        let (output, value) = parsed("--target", text)?;
        Ok(Target { output, value })
    });
    let targets = targets.collect::<Result<_, Failure>>()?;
    let (mut turns, mut settings) = (Vec::new(), Vec::new());
    for text in &arguments.settings {
        match text.split_once('=').and_then(|(name, _)| Turn::named(name)) {
            Some(turn) => turns.push((turn, parsed("--set", text)?.1)),
            None => settings.push(text.clone()),
        }
    }
    let plant = plant_with(machine, &interface, &settings)?;
    let options = Options { solve_for: arguments.free.clone(), targets, turns };
    let found = solve_watched(plant, &options, &mut Progress::phase("equilibria").watch());
    let found = found.map_err(|error| failure(error, &interface))?;
    found.warnings.iter().for_each(|warning| arguments.quiet.warning(&warning.to_string()));
    if arguments.json {
        return print(&format!("{:#}", json!(found)));
    }
    print(&text(&found))
}

/// Parses `NAME=VALUE` as the value of an option.
fn parsed(option: &str, text: &str) -> Result<(String, f64), Failure> {
    let refused = |cause: &str| Failure::Usage(format!("{option} {text}: {cause}"));
    let (name, value) = text.split_once('=').ok_or_else(|| refused("must be NAME=VALUE"))?;
    let value = value.trim().parse().map_err(|_| refused("the value is not a finite number"))?;
    Ok((name.to_owned(), value))
}

/// Returns the result as a text table.
fn text(found: &Trim) -> String {
    let mut text = format!("{}: trim found after {} steps\n", found.machine, found.steps);
    for Solved { name, unit, value } in &found.solved {
        let _ = writeln!(text, "{name} = {} {unit}", six(*value));
    }
    for Balanced { output, unit, value, residual } in &found.balanced {
        let _ = writeln!(text, "{output}: {} {unit}, off by {:.1e}", six(*value), residual.abs());
    }
    for Residual { name, unit, value } in &found.joint_loads {
        let _ = writeln!(text, "{name}: {:.1e} {unit}", value.abs());
    }
    let settings: Vec<String> = found.settings.iter().map(|(name, value)| format!("--set {name}={value:?}")).collect();
    let _ = write!(text, "for other commands: {}", settings.join(" "));
    text
}

/// Converts the error of a trim to a message of the command.
fn failure(error: TrimError, interface: &Interface) -> Failure {
    match error {
        TrimError::Name(error) => Failure::Usage(name_message::<Variable>(&error)),
        TrimError::SolveFor { unknown, error } => Failure::Usage(format!("--solve-for {unknown}: {error}")),
        TrimError::Target { output, error: TargetError::Repeated, .. } => {
            Failure::Usage(format!("--target {output}: {}", TargetError::Repeated))
        }
        TrimError::Target { output, value, error } => Failure::Usage(format!("--target {output}={value}: {error}")),
        TrimError::NotFinite { turn, value } => {
            Failure::Usage(format!("--set {}={value}: the value is not a finite number", turn.name()))
        }
        TrimError::Turn { turn, error } => Failure::Usage(format!("--set {}: {error}", turn.name())),
        TrimError::Count { .. } => Failure::Usage(format!("--solve-for and --target: {error}")),
        TrimError::NothingFree => Failure::Usage(format!("trim: {error}")),
        TrimError::Refused { name, value, error } => {
            let setting = shortened(&format!("{name}={value:?}"));
            let cause = refusal(&error, interface.find(&name), &format!("{value:?}"));
            Failure::Usage(format!("--solve-for {setting}: {cause}"))
        }
        TrimError::NoEquilibrium(error) => Failure::Statics(error.to_string()),
        TrimError::Stopped => Failure::Statics(error.to_string()),
        TrimError::NotConverged { .. } => {
            let text = error.to_string();
            Failure::Statics(text.replace("use other initial guesses, or", "use other initial guesses (--set), or"))
        }
    }
}

#[cfg(test)]
#[path = "trim_tests.rs"]
mod tests;
