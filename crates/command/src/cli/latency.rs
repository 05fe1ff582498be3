//! `foldwing latency`: time per communication step under a turbulent load.

use crate::cli::settings::read_plant;
use crate::cli::{Failure, print};
use clap::builder::NonEmptyStringValueParser;
use foldwing_study::latency::{Latency, LatencyError, Options, measure};
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
    /// Seed of the turbulence: the same seed gives the same forces everywhere
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Start every step at its wall time, as a real-time loop does: the run then takes as long as the simulated time
    #[arg(long)]
    paced: bool,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
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
    let mut text = format!(
        "{} steps of {} s; {} internal steps, {} repeated, {} iterations, at most {} in a stage, {} stages \
         unconverged, {} events; {late} steps took longer than they simulate\n",
        arguments.steps,
        arguments.step,
        statistics.steps,
        statistics.rejections + statistics.failures,
        statistics.iterations,
        statistics.largest_iterations,
        statistics.unconverged,
        statistics.events
    );
    table(&mut text, wall, processor);
    print(&text)
}

/// The error of a measurement in the words of the command.
fn failure(error: LatencyError) -> Failure {
    let text = error.to_string();
    match error {
        LatencyError::Step { .. } => Failure::Usage(text.replacen("step_s", "--step", 1)),
        LatencyError::Turbulence { .. } => Failure::Usage(text.replacen("turbulence_n", "--turbulence", 1)),
        LatencyError::Correlation { .. } => Failure::Usage(text.replacen("correlation_s", "--correlation", 1)),
        LatencyError::Plant(_) => Failure::Simulation(text),
    }
}

/// Appends quantiles and histogram of both clocks.
fn table(text: &mut String, mut wall: Vec<Duration>, mut processor: Vec<Duration>) {
    wall.sort_unstable();
    processor.sort_unstable();
    let us = |times: &[Duration], share: f64| {
        let place = (share * times.len() as f64).ceil() as usize;
        times
            .get(place.clamp(1, times.len().max(1)) - 1)
            .map_or("-".to_owned(), |time| format!("{:.1}", 1e6 * time.as_secs_f64()))
    };
    let mut line = |name: &str, wall: String, processor: String| {
        // writing to a String cannot fail
        let _ = writeln!(text, "{name:>12} {wall:>12} {processor:>14}");
    };
    line("us", "wall time".to_owned(), "processor time".to_owned());
    for (name, share) in [("median", 0.5), ("99 %", 0.99), ("99.9 %", 0.999), ("slowest", 1.0)] {
        line(name, us(&wall, share), us(&processor, share));
    }
    line("steps up to", String::new(), String::new());
    let mut from = [0, 0];
    for bound_us in CLASSES_US {
        let up_to = [&wall, &processor].map(|times| times.partition_point(|time| 1e6 * time.as_secs_f64() <= bound_us));
        let name = if bound_us.is_finite() { format!("{bound_us} us") } else { "more".to_owned() };
        line(&name, (up_to[0] - from[0]).to_string(), (up_to[1] - from[1]).to_string());
        from = up_to;
    }
}
