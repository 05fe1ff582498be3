//! Arguments of `foldwing run`, the same in every build, and its error in a build without the crate `foldwing-import`.

use crate::cli::Failure;
use crate::cli::grid::GridArguments;
use crate::cli::outlets::Force;
use crate::cli::pictures::SheetArguments;
use clap::builder::NonEmptyStringValueParser;
use std::path::PathBuf;

/// Runs an FMU as the arguments request.
pub type RunFmu = fn(&Arguments) -> Result<(), Failure>;

/// Returns an error that names the build that runs FMUs.
pub fn unavailable(_: &Arguments) -> Result<(), Failure> {
    Err(Failure::Usage(
        "run: this build cannot run FMUs; `make runner` (or `cargo build --release --features import`, with libclang) \
         makes one that can"
            .to_owned(),
    ))
}

/// Arguments of `foldwing run`.
#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::RUN)]
pub struct Arguments {
    /// FMU: FMI 2.0 or 3.0, co-simulation
    pub fmu: PathBuf,
    /// CSV file to write; `-` is standard output
    #[arg(long, value_name = "OUT.csv")]
    pub csv: Option<PathBuf>,
    /// List the variables with type, unit and start value without running
    #[arg(long = "list-variables")]
    pub variables: bool,
    /// Inputs over time: CSV with a column `time` and columns named after inputs; values are taken at the start of each step, with real
    /// inputs interpolated linearly between rows and others held
    #[arg(long, alias = "input", value_name = "IN.csv")]
    pub inputs: Option<PathBuf>,
    /// Start value: a number, optionally with one of the variable's units after a space ("x=90 deg"), an item of an enumeration or a
    /// string; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    pub settings: Vec<String>,
    /// Start, end and communication step
    #[command(flatten)]
    pub grid: GridArguments,
    /// Relative tolerance of the FMU's solver [default: from the FMU]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Variables to write: names or patterns (`fold.*`), separated by commas; may be repeated [default: all outputs]
    #[arg(long = "variables", value_name = "NAME")]
    pub outputs: Vec<String>,
    /// Folder for figures of the variables over time, one per unit, with marks where Boolean variables change
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Format of the figures
    #[command(flatten)]
    pub sheets: SheetArguments,
    /// Whether existing files may be overwritten
    #[command(flatten)]
    pub force: Force,
    /// Show all messages of the FMU; warnings and errors are always shown
    #[arg(long)]
    pub log: bool,
    /// Print the summary as JSON on standard output, for programs: end of the run, warnings, final values, written files
    #[arg(long)]
    pub json: bool,
    /// Print no summary
    #[arg(short, long)]
    pub quiet: bool,
}
