//! The measurement, and the load that excites the model.

use crate::latency::processor_time::processor_time;
use foldwing_engine::plant::{Plant, PlantError, Statistics};
use std::time::{Duration, Instant};

/// Options of [`measure`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Number of communication steps.
    pub steps: usize,
    /// Communication step in s.
    pub step_s: f64,
    /// Standard deviation in N of the turbulent force on each load station, along z of its load frame.
    pub turbulence_n: f64,
    /// Correlation time of the turbulence in s.
    pub correlation_s: f64,
    /// Seed of the turbulence: the same seed gives the same forces on every platform.
    pub seed: u64,
    /// Start every step at its wall-clock time, as a real-time loop does: the measurement then takes as long as the simulated
    /// time.
    pub paced: bool,
}

impl Default for Options {
    /// 100,000 steps of 1 ms under 0.1 N with a correlation time of 20 ms.
    fn default() -> Self {
        Self { steps: 100_000, step_s: 1e-3, turbulence_n: 0.1, correlation_s: 0.02, seed: 1, paced: false }
    }
}

/// Times of single communication steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Latency {
    /// Wall-clock time of each step, in their order.
    pub wall: Vec<Duration>,
    /// Processor time of the thread in each step, in their order; empty if the system has no such clock.
    pub processor: Vec<Duration>,
    /// Work of the solver over all steps.
    pub statistics: Statistics,
    /// Number of steps that took longer than they simulate.
    pub late: usize,
}

/// Error of a latency measurement.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LatencyError {
    /// A communication step that is not finite and positive.
    #[error("step_s {value}: must be a finite number and positive")]
    Step {
        /// The step in s.
        value: f64,
    },
    /// A standard deviation that is not finite, or negative.
    #[error("turbulence_n {value}: must be a finite number and at least 0")]
    Turbulence {
        /// The standard deviation in N.
        value: f64,
    },
    /// A correlation time that is not finite and positive.
    #[error("correlation_s {value}: must be a finite number and positive")]
    Correlation {
        /// The time in s.
        value: f64,
    },
    /// The simulation failed.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

impl Options {
    /// Rejects values that are not allowed.
    ///
    /// # Errors
    /// Steps and correlation times that are not finite and positive, standard deviations that are not finite or negative.
    pub fn check(&self) -> Result<(), LatencyError> {
        let Self { step_s, turbulence_n, correlation_s, .. } = *self;
        if !(step_s.is_finite() && step_s > 0.0) {
            return Err(LatencyError::Step { value: step_s });
        }
        if !(turbulence_n.is_finite() && turbulence_n >= 0.0) {
            return Err(LatencyError::Turbulence { value: turbulence_n });
        }
        if !(correlation_s.is_finite() && correlation_s > 0.0) {
            return Err(LatencyError::Correlation { value: correlation_s });
        }
        Ok(())
    }
}

/// Measures how long single communication steps take while a turbulent load shakes the model.
///
/// Two clocks are read: the wall clock, on which a real-time loop depends and which other programs disturb, and the processor
/// time of the thread, which they disturb less. `plant` has its start values and is not yet initialised.
///
/// # Errors
/// Options that are not allowed ([`Options::check`]), and a step that fails.
pub fn measure(mut plant: Plant, options: &Options) -> Result<Latency, LatencyError> {
    options.check()?;
    let start_s = plant.machine().experiment.start_time_s;
    plant.initialize(start_s)?;
    let mut turbulence = Turbulence::new(options, plant.inputs().stations().len());
    let (mut wall, mut processor) = (Vec::with_capacity(options.steps), Vec::with_capacity(options.steps));
    let began = Instant::now();
    for step in 1..=options.steps {
        if options.paced {
            let due = Duration::from_secs_f64((step - 1) as f64 * options.step_s);
            std::thread::sleep(due.saturating_sub(began.elapsed()));
        }
        turbulence.shake(&mut plant);
        let end_s = start_s + step as f64 * options.step_s;
        let (begin, begin_processor) = (Instant::now(), processor_time());
        let outcome = plant.step(end_s);
        let end_processor = processor_time();
        wall.push(begin.elapsed());
        processor.extend(begin_processor.zip(end_processor).map(|(begin, end)| end.saturating_sub(begin)));
        outcome?;
    }
    let late = wall.iter().filter(|time| time.as_secs_f64() > options.step_s).count();
    Ok(Latency { wall, processor, statistics: plant.statistics(), late })
}

/// Independent first-order filtered noise on every load station: variance and correlation time do not depend on the step.
struct Turbulence {
    forces_n: Vec<f64>,
    kept: f64,
    added_n: f64,
    seed: u64,
}

impl Turbulence {
    fn new(options: &Options, stations: usize) -> Self {
        let kept = (-options.step_s / options.correlation_s).exp();
        let added_n = options.turbulence_n * (1.0 - kept * kept).sqrt();
        Self { forces_n: vec![0.0; stations], kept, added_n, seed: options.seed }
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
