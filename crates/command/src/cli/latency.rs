//! `foldwing latency`: time per communication step under a turbulent load.

use crate::cli::outlets::Quiet;
use crate::cli::settings::read_plant;
use crate::cli::{Failure, print};
use clap::builder::NonEmptyStringValueParser;
use foldwing_study::latency::{Latency, LatencyError, Options, measure};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::LATENCY)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Number of communication steps to measure
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    steps: u32,
    /// Communication step in s
    #[arg(long, default_value_t = 1e-3, value_name = "S", allow_negative_numbers = true)]
    step: f64,
    /// Standard deviation in N of the turbulent force on each load station, along z of its load frame
    #[arg(long, default_value_t = 0.1, value_name = "N", allow_negative_numbers = true)]
    turbulence: f64,
    /// Correlation time of the turbulence in s
    #[arg(long, default_value_t = 0.02, value_name = "S", allow_negative_numbers = true)]
    correlation: f64,
    /// Seed of the turbulence: the same seed gives the same forces on every computer
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Start every step at its wall-clock time, as a real-time loop does: the run then takes as long as the simulated time
    #[arg(long)]
    paced: bool,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    _quiet: Quiet,
}

/// Upper limits of the histogram's bins in µs.
const CLASSES_US: [f64; 11] = [10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4, f64::INFINITY];

/// Measures and prints the latency.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let options = Options {
        steps: arguments.steps as usize,
        step_s: arguments.step,
        turbulence_n: arguments.turbulence,
        correlation_s: arguments.correlation,
        seed: arguments.seed,
        paced: arguments.paced,
    };
    options.check().map_err(failure)?;
    let plant = read_plant(&arguments.model, &arguments.settings)?;
    let Latency { wall, processor, statistics, late } = measure(plant, &options).map_err(failure)?;
    let clocks = [Clock::new(wall), Clock::new(processor)];
    if arguments.json {
        let value = json!({
            "steps": arguments.steps,
            "step_s": arguments.step,
            "late_steps": late,
            "wall_time": clocks[0].json(),
            "processor_time": clocks[1].json(),
            "solver": {
                "steps": statistics.steps,
                "rejections": statistics.rejections,
                "failures": statistics.failures,
                "iterations": statistics.iterations,
                "largest_iterations": statistics.largest_iterations,
                "unconverged_stages": statistics.unconverged,
                "events": statistics.events,
            },
        });
        return print(&format!("{value:#}"));
    }
    let mut text = format!(
        "{} steps of {} s; {} internal steps, {} repeated, {} iterations, at most {} in a stage, {} stages \
         unconverged, {} events; {late} steps took longer than their simulated time\n",
        arguments.steps,
        arguments.step,
        statistics.steps,
        statistics.rejections + statistics.failures,
        statistics.iterations,
        statistics.largest_iterations,
        statistics.unconverged,
        statistics.events
    );
    table(&mut text, &clocks);
    print(&text)
}

/// Converts the error of a measurement to a message of the command.
fn failure(error: LatencyError) -> Failure {
    let text = error.to_string();
    match error {
        LatencyError::Step { .. } => Failure::Usage(text.replacen("step_s", "--step", 1)),
        LatencyError::Turbulence { .. } => Failure::Usage(text.replacen("turbulence_n", "--turbulence", 1)),
        LatencyError::Correlation { .. } => Failure::Usage(text.replacen("correlation_s", "--correlation", 1)),
        LatencyError::Plant(_) => Failure::Simulation(text),
    }
}

/// Quantiles of the step times, with their JSON keys and the fractions of the steps.
const QUANTILES: [(&str, &str, f64); 4] = [
    ("median", "median_us", 0.5),
    ("99 %", "p99_us", 0.99),
    ("99.9 %", "p99_9_us", 0.999),
    ("slowest", "slowest_us", 1.0),
];

/// Step times measured by one clock, ascending, in µs; empty where the system has no such clock.
struct Clock(Vec<f64>);

impl Clock {
    fn new(times: Vec<Duration>) -> Self {
        let mut times_us: Vec<f64> = times.iter().map(|time| 1e6 * time.as_secs_f64()).collect();
        times_us.sort_unstable_by(f64::total_cmp);
        Self(times_us)
    }

    /// Time in µs that this fraction of the steps does not exceed.
    fn quantile_us(&self, share: f64) -> Option<f64> {
        let place = (share * self.0.len() as f64).ceil() as usize;
        self.0.get(place.clamp(1, self.0.len().max(1)) - 1).copied()
    }

    /// Number of steps in each bin of the histogram.
    fn classes(&self) -> [usize; CLASSES_US.len()] {
        let up_to = CLASSES_US.map(|bound_us| self.0.partition_point(|time_us| *time_us <= bound_us));
        std::array::from_fn(|i| up_to[i] - if i > 0 { up_to[i - 1] } else { 0 })
    }

    /// Quantiles and histogram; null without the clock.
    fn json(&self) -> Value {
        if self.0.is_empty() {
            return Value::Null;
        }
        let mut value = json!({});
        for (_, key, share) in QUANTILES {
            value[key] = json!(self.quantile_us(share));
        }
        let classes = CLASSES_US.iter().zip(self.classes());
        let class = |(bound_us, steps): (&f64, usize)| json!({ "up_to_us": bound_us.is_finite().then_some(bound_us), "steps": steps });
        value["histogram"] = classes.map(class).collect();
        value
    }
}

/// Appends quantiles and histogram of both clocks.
fn table(text: &mut String, clocks: &[Clock; 2]) {
    let mut line = |name: &str, [wall, processor]: [String; 2]| {
        // writing to a String cannot fail
        let _ = writeln!(text, "{name:>12} {wall:>12} {processor:>14}");
    };
    line("us", ["wall time", "processor time"].map(str::to_owned));
    for (name, _, share) in QUANTILES {
        let us = |clock: &Clock| clock.quantile_us(share).map_or("-".to_owned(), |us| format!("{us:.1}"));
        line(name, [us(&clocks[0]), us(&clocks[1])]);
    }
    line("steps up to", [String::new(), String::new()]);
    let classes = [clocks[0].classes(), clocks[1].classes()];
    for (i, bound_us) in CLASSES_US.iter().enumerate() {
        let name = if bound_us.is_finite() { format!("{bound_us} us") } else { "more".to_owned() };
        line(&name, [classes[0][i].to_string(), classes[1][i].to_string()]);
    }
}
