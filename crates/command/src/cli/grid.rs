//! `--start`, `--stop`, `--step`: communication points of a run.

use crate::cli::Failure;
pub use foldwing_recording::Grid;

#[derive(Clone, clap::Args)]
pub struct GridArguments {
    /// Communication step in s [default: from the model]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Start time in s [default: from the model]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    start: Option<f64>,
    /// Stop time in s [default: from the model]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    stop: Option<f64>,
}

impl GridArguments {
    /// Grid arguments for times in s given by a program.
    pub(super) fn of(start: Option<f64>, stop: Option<f64>, step: Option<f64>) -> Self {
        Self { step, start, stop }
    }

    /// Start, stop and step in s, if given.
    pub(super) fn given(&self) -> [Option<f64>; 3] {
        [self.start, self.stop, self.step]
    }
}

/// Maximum number of rows of a run; a larger number is probably unintended.
const MAXIMUM_STEPS: u64 = 1_000_000_000;

/// Communication points of the command line arguments; missing values are taken from `[simulation]`.
pub fn grid_of(
    arguments: &GridArguments,
    default_start_s: f64,
    default_stop_s: f64,
    default_step_s: f64,
) -> Result<Grid, Failure> {
    let start_s = finite("--start", arguments.start, default_start_s)?;
    // `--start` alone shifts the simulation without shortening it.
    let stop_s = finite("--stop", arguments.stop, start_s + (default_stop_s - default_start_s))?;
    let step_s = finite("--step", arguments.step, default_step_s)?;
    if step_s <= 0.0 {
        return Err(Failure::Usage(format!("--step {step_s}: the step must be positive")));
    }
    if stop_s <= start_s {
        return Err(Failure::Usage(format!("--stop {stop_s}: must be after the start time, {start_s} s")));
    }
    let grid = Grid::new(start_s, stop_s, step_s);
    if grid.steps > MAXIMUM_STEPS {
        return Err(Failure::Usage(format!(
            "--step {step_s}: {} rows exceed the maximum of {MAXIMUM_STEPS}",
            grid.steps
        )));
    }
    Ok(grid)
}

fn finite(option: &str, given: Option<f64>, default: f64) -> Result<f64, Failure> {
    match given {
        Some(value) if !value.is_finite() => Err(Failure::Usage(format!("{option} {value}: must be a finite number"))),
        Some(value) => Ok(value),
        None => Ok(default),
    }
}
