//! `foldwing latency`: time per communication step under a turbulent load.
//!
//! Two clocks: the wall clock, which a real-time loop depends on and other programs disturb, and the processor time of the thread, which
//! they disturb less.

use crate::cli::processor_time::processor_time;
use crate::cli::settings::read_plant;
use crate::cli::{Failure, print};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::Plant;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::{Duration, Instant};

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
    for (option, value, zero) in [
        ("--step", arguments.step, false),
        ("--turbulence", arguments.turbulence, true),
        ("--correlation", arguments.correlation, false),
    ] {
        if !(value.is_finite() && (value > 0.0 || zero && value == 0.0)) {
            let allowed = if zero { "at least 0" } else { "positive" };
            return Err(Failure::Usage(format!("{option} {value}: must be a finite number and {allowed}")));
        }
    }
    let mut plant = read_plant(&arguments.model, &arguments.settings)?;
    let failed = |error: foldwing_engine::plant::PlantError| Failure::Simulation(error.to_string());
    let start_s = plant.machine().experiment.start_time_s;
    plant.initialize(start_s).map_err(failed)?;

    let steps = arguments.steps as usize;
    let mut turbulence = Turbulence::new(arguments, plant.inputs().stations().len());
    let (mut wall, mut processor) = (Vec::with_capacity(steps), Vec::with_capacity(steps));
    let began = Instant::now();
    for step in 1..=steps {
        if arguments.paced {
            let due = Duration::from_secs_f64((step - 1) as f64 * arguments.step);
            std::thread::sleep(due.saturating_sub(began.elapsed()));
        }
        turbulence.shake(&mut plant);
        let end_s = start_s + step as f64 * arguments.step;
        let (begin, begin_processor) = (Instant::now(), processor_time());
        let outcome = plant.step(end_s);
        let end_processor = processor_time();
        wall.push(begin.elapsed());
        processor.extend(begin_processor.zip(end_processor).map(|(begin, end)| end.saturating_sub(begin)));
        outcome.map_err(failed)?;
    }
    let statistics = plant.statistics();
    let late = wall.iter().filter(|time| time.as_secs_f64() > arguments.step).count();
    let mut text = format!(
        "{steps} steps of {} s; {} internal steps, {} repeated, {} iterations, at most {} in a stage, {} stages \
         unconverged, {} events; {late} steps took longer than they simulate\n",
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

/// Independent first-order filtered noise on every load station: variance and correlation time do not depend on the step.
struct Turbulence {
    forces_n: Vec<f64>,
    kept: f64,
    added_n: f64,
    seed: u64,
}

impl Turbulence {
    fn new(arguments: &Arguments, stations: usize) -> Self {
        let kept = (-arguments.step / arguments.correlation).exp();
        let added_n = arguments.turbulence * (1.0 - kept * kept).sqrt();
        Self { forces_n: vec![0.0; stations], kept, added_n, seed: arguments.seed }
    }

    /// Sets the forces of the next step.
    fn shake(&mut self, plant: &mut Plant) {
        for station in 0..self.forces_n.len() {
            let noise = self.normal();
            let force_n = self.kept * self.forces_n[station] + self.added_n * noise;
            self.forces_n[station] = force_n;
            plant.inputs_mut().stations_mut()[station].force_n.z = force_n;
        }
    }

    /// Approximately normal random number: the sum of twelve uniform numbers minus six, variance 1, within ±6.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// Uniform random number in [0, 1), by SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, 2014).
    fn uniform(&mut self) -> f64 {
        self.seed = self.seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.seed;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean 0, variance 1 within four standard errors of 1e5 samples, and equal seeds give equal numbers.
    #[test]
    fn noise_is_seeded_and_has_unit_variance() {
        let of = |seed| Turbulence { forces_n: vec![], kept: 0.0, added_n: 1.0, seed };
        let (mut one, mut same) = (of(7), of(7));
        let samples: Vec<f64> = (0..100_000).map(|_| one.normal()).collect();
        let mean = samples.iter().sum::<f64>() / 1e5;
        let variance = samples.iter().map(|x| x * x).sum::<f64>() / 1e5;
        assert!(mean.abs() < 4.0 / 1e5f64.sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / 1e5f64).sqrt(), "{variance}");
        assert_eq!(same.normal().to_bits(), samples[0].to_bits());
    }
}
