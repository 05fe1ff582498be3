//! `--start`, `--stop`, `--step`: communication points of a run.

use crate::cli::Failure;

#[derive(Clone, clap::Args)]
pub(super) struct GridArguments {
    /// Communication step in s [default: the model's]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Start time in s [default: the model's]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    start: Option<f64>,
    /// Stop time in s [default: the model's]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    stop: Option<f64>,
}

impl GridArguments {
    /// Times given by a program, in s.
    pub(super) fn of(start: Option<f64>, stop: Option<f64>, step: Option<f64>) -> Self {
        Self { step, start, stop }
    }

    /// Start, stop and step in s, if given.
    pub(super) fn given(&self) -> [Option<f64>; 3] {
        [self.start, self.stop, self.step]
    }
}

/// Communication points.
pub(super) struct Grid {
    pub start_s: f64,
    pub stop_s: f64,
    pub step_s: f64,
    pub steps: u64,
}

impl Grid {
    /// Maximum number of rows of a run: a larger number is surely a mistake.
    const MAXIMUM_STEPS: f64 = 1e9;

    /// Grid of the command line arguments; missing values are those of the default experiment.
    pub fn new(
        arguments: &GridArguments,
        default_start_s: f64,
        default_stop_s: f64,
        default_step_s: f64,
    ) -> Result<Self, Failure> {
        let start_s = finite("--start", arguments.start, default_start_s)?;
        // A start given alone shifts the simulation; it does not shorten it.
        let stop_s = finite("--stop", arguments.stop, start_s + (default_stop_s - default_start_s))?;
        let step_s = finite("--step", arguments.step, default_step_s)?;
        if step_s <= 0.0 {
            return Err(Failure::Usage(format!("--step {step_s}: the step must be positive")));
        }
        if stop_s <= start_s {
            return Err(Failure::Usage(format!("--stop {stop_s}: must be after the start time, {start_s} s")));
        }
        let steps = ((stop_s - start_s) / step_s - 1e-9).ceil().max(1.0);
        if steps > Self::MAXIMUM_STEPS {
            return Err(Failure::Usage(format!(
                "--step {step_s}: {steps:.0} rows are more than {:.0}",
                Self::MAXIMUM_STEPS
            )));
        }
        Ok(Self { start_s, stop_s, step_s, steps: steps as u64 })
    }

    /// Time of a communication point; the last one is exactly the stop time.
    pub fn time_s(&self, point: u64) -> f64 {
        if point == self.steps { self.stop_s } else { self.start_s + point as f64 * self.step_s }
    }
}

fn finite(option: &str, given: Option<f64>, default: f64) -> Result<f64, Failure> {
    match given {
        Some(value) if !value.is_finite() => Err(Failure::Usage(format!("{option} {value}: must be a finite number"))),
        Some(value) => Ok(value),
        None => Ok(default),
    }
}
