//! `foldwing fit`: identifies parameters of a model from measurements.

mod data;
mod output;
mod trials;

use crate::cli::gradient::rows;
use crate::cli::outlets::{Force, Mark, Outlets, Quiet};
use crate::cli::pictures::{SheetArguments, check_figure, check_figures, write_figure, write_series};
use crate::cli::progress::Progress;
use crate::cli::simulate::read_inputs;
use crate::cli::{Failure, read_model};
use clap::builder::NonEmptyStringValueParser;
use data::{Data, Given, number};
use foldwing_fmi::interface::Interface;
use foldwing_study::fit::{Loss, Search, search, uncertainty};
use foldwing_study::names;
use nalgebra::DVector;
use output::{Identified, figures, scatter, text_of};
use std::path::PathBuf;
use trials::Trials;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::FIT)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Measurements: CSV with a column `time` in s and columns with names of real outputs; cells without a measurement are empty
    data: PathBuf,
    /// Number to identify: a real input or parameter that is constant during the run, or a key of the model file
    /// (file:body.inner.length_m); may be repeated, or a list with commas
    #[arg(long = "by", value_name = "NAME", required = true, value_parser = NonEmptyStringValueParser::new())]
    by: Vec<String>,
    /// Bounds of a number; one of them may be omitted [default: the range of the variable or key]; may be repeated
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = NonEmptyStringValueParser::new())]
    bounds: Vec<String>,
    /// Initial value of a number in the search [default: from the model]; may be repeated
    #[arg(long, value_name = "NAME=NUMBER", value_parser = NonEmptyStringValueParser::new())]
    start: Vec<String>,
    /// Columns to use [default: all]; may be repeated, or a list with commas
    #[arg(long, value_name = "NAME", value_parser = NonEmptyStringValueParser::new())]
    columns: Vec<String>,
    /// Measured value of a single result, named as in `foldwing gradient --of`, such as fold.latch_time=0.122; may be repeated
    #[arg(long, value_name = "RESULT=NUMBER", value_parser = NonEmptyStringValueParser::new())]
    value: Vec<String>,
    /// Standard deviation of the measurement noise, for all measurements or for one name; may be repeated. Without this option residuals
    /// are scaled by the largest magnitude in their column, and the noise is estimated
    #[arg(long, value_name = "[NAME=]NUMBER", value_parser = NonEmptyStringValueParser::new())]
    sigma: Vec<String>,
    /// Loss function of the residuals; all but `linear` reduce the influence of outliers
    #[arg(long, value_name = "LOSS", default_value = "linear", value_parser = Loss::ALL.map(|(_, name)| name))]
    loss: String,
    /// Maximum number of simulations in the search
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    max_runs: u32,
    /// Stop time in s [default: the last measured time; with --value from the model]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    stop: Option<f64>,
    /// Inputs over time from a CSV file, as for `foldwing simulate`; real inputs are interpolated linearly between rows
    #[arg(long, value_name = "IN.csv")]
    inputs: Option<PathBuf>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Model file to write, with the identified values of keys (file:...)
    #[arg(short, long, value_name = "OUT.toml")]
    output: Option<PathBuf>,
    /// Folder for figures: computed against measured values before and after the fit, and each column over time
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

/// Identifies the parameters, prints them and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let read = [Some(&arguments.model), Some(&arguments.data), arguments.inputs.as_ref()];
    let mut outlets = Outlets::new(arguments.force.force, read.into_iter().flatten().map(PathBuf::as_path));
    let (machine, text) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let table = arguments.inputs.as_ref().map(|path| read_inputs(path, interface.variables())).transpose()?;
    let given = Given {
        columns: &arguments.columns,
        results: &arguments.value,
        sigma: &arguments.sigma,
        start_s: machine.experiment.start_time_s,
        stop_s: arguments.stop,
        experiment_stop_s: machine.experiment.stop_time_s,
    };
    let data = Data::read(&arguments.data, &given, &interface)?;
    let by: Vec<&str> = arguments.by.iter().flat_map(|list| names::split(list)).collect();
    let keys = by.iter().any(|name| name.starts_with("file:"));
    if let Some(path) = arguments.output.as_ref().filter(|_| !keys) {
        return Err(Failure::Usage(format!(
            "-o {}: none of the numbers of --by is a key of the model file (file:...); the result gives them as --set \
             options for other commands",
            path.display()
        )));
    }
    let place = outlets.place_if(arguments.output.as_deref(), Mark::Never)?;
    if let Some(folder) = &arguments.plot {
        check_figures(folder, &outlets)?;
        check_figure(folder, "fit", &outlets)?;
    }
    let progress = Progress::phase("fit");
    let inputs = rows(table.as_ref(), &interface)?;
    let mut trials = Trials::new(
        (&arguments.model, &text),
        (machine, &interface),
        (&arguments.settings, table.as_ref(), inputs),
        &data,
        &by,
    )?;
    let first = starts(arguments, &trials)?;
    if data.values.len() < first.len() {
        return Err(Failure::Usage(format!(
            "--by: {} measurements cannot determine {} numbers; give more rows, or fewer numbers",
            data.values.len(),
            first.len()
        )));
    }
    let bounds = bounds(arguments, &trials, &first)?;
    let loss = Loss::named(&arguments.loss).unwrap_or_default();
    let before = trials.results(&first)?;
    let from = Search { first: first.clone(), bounds, loss, max_runs: arguments.max_runs as usize };
    let found = search(&mut trials, &from)?;
    let Some(found) = found else {
        return Err(Failure::Statics("the run at the start of the search has no results".to_owned()));
    };
    drop(progress);
    let own = uncertainty(&found.x, &found.residuals, &found.jacobian, data.has_sigma);
    let after: Vec<f64> =
        (0..data.values.len()).map(|i| data.values[i] + data.scales[i] * found.residuals[i]).collect();
    let result = Identified::new(&trials, &data, (&first, &found, &own), (&before, &after));
    if arguments.output.is_some() {
        place.fill(trials.text_at(&found.x)?.as_bytes())?;
    }
    if let Some(folder) = &arguments.plot {
        write_series(folder, figures(&result), &arguments.sheets, &mut outlets)?;
        write_figure(folder, "fit", &scatter(&result), &arguments.sheets, &mut outlets)?;
    }
    if !result.converged {
        arguments.quiet.warning(&format!("the search has not converged: {}; --max-runs allows more", result.ended));
    }
    let text = match arguments.json {
        true => serde_json::to_string_pretty(&result).map_err(|error| Failure::Refused(error.to_string()))?,
        false => text_of(&result, &trials.settings_at(&found.x)),
    };
    arguments.quiet.print(&text, &outlets)
}

/// Start values of the search.
fn starts(arguments: &Arguments, trials: &Trials) -> Result<DVector<f64>, Failure> {
    let mut first = trials.own();
    for text in &arguments.start {
        let (name, value) = number(("--start", text), "NAME=NUMBER")?;
        first[trials.place("--start", name)?] = value;
    }
    Ok(first)
}

/// Bounds of the parameters: those of the options, limited by those of the variables.
fn bounds(arguments: &Arguments, trials: &Trials, first: &DVector<f64>) -> Result<Vec<[f64; 2]>, Failure> {
    let mut bounds = trials.allowed();
    for text in &arguments.bounds {
        let refused = |cause: String| Failure::Usage(format!("--bounds {text}: {cause}"));
        let form = || refused("must be NAME=LOW:HIGH, of which one number may be missing".to_owned());
        let (name, range) = text.rsplit_once('=').ok_or_else(form)?;
        let (low, high) = range.split_once(':').ok_or_else(form)?;
        let end = |text: &str, none: f64| match text.trim() {
            "" => Ok(none),
            text => text.parse().ok().filter(|end: &f64| !end.is_nan()).ok_or_else(form),
        };
        let (low, high) = (end(low, f64::NEG_INFINITY)?, end(high, f64::INFINITY)?);
        if low >= high {
            return Err(refused("the lower bound must be below the upper one".to_owned()));
        }
        let place = trials.place("--bounds", name.trim())?;
        if !(low..=high).contains(&first[place]) {
            return Err(refused(format!("the start {:?} is outside; --start sets it", first[place])));
        }
        bounds[place] = [bounds[place][0].max(low), bounds[place][1].min(high)];
    }
    // a start value that the model does not allow is reported as an error of its run
    Ok(bounds.into_iter().zip(first.iter()).map(|([low, high], x)| [low.min(*x), high.max(*x)]).collect())
}
