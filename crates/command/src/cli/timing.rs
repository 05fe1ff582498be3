//! `foldwing simulate --profile`: computing time of a run, as JSON.

use foldwing_engine::plant::Statistics;
use foldwing_study::latency::processor_time;
use serde_json::json;
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// Clocks of one run. Wall time is split into initialisation, steps and output rows; processor time is measured only in total, since
/// reading it costs as much as a row.
pub(super) struct Timing {
    started: Instant,
    processor_start: Option<Duration>,
    processor: Option<Duration>,
    initialized: Duration,
    steps: Duration,
    rows: Duration,
    communication_steps: u64,
}

impl Timing {
    /// Starts the clocks.
    pub(super) fn start() -> Self {
        let zero = Duration::ZERO;
        let processor_start = processor_time();
        Self {
            started: Instant::now(),
            processor_start,
            processor: None,
            initialized: zero,
            steps: zero,
            rows: zero,
            communication_steps: 0,
        }
    }

    /// Marks the end of the initialisation.
    pub(super) fn initialized(&mut self) {
        self.initialized = self.started.elapsed();
    }

    /// Adds a communication step and the writing of its row.
    pub(super) fn stepped(&mut self, begin: Instant, end: Instant) {
        self.steps += end - begin;
        self.rows += end.elapsed();
        self.communication_steps += 1;
    }

    /// Marks the end of the run.
    pub(super) fn finish(&mut self) {
        self.processor = self.processor_start.zip(processor_time()).map(|(begin, end)| end - begin);
    }

    /// Writes all measurements, times in s.
    pub(super) fn write(&self, statistics: &Statistics, simulated_s: f64, mut sink: impl Write) -> io::Result<()> {
        let steps_s = self.steps.as_secs_f64();
        let per = |count: u64| if count == 0 { None } else { Some(1e6 * steps_s / count as f64) };
        let figures = json!({
            "simulated_s": simulated_s,
            "processor_s": self.processor.map(|time| time.as_secs_f64()),
            "initialization_s": self.initialized.as_secs_f64(),
            "steps_s": steps_s,
            "rows_s": self.rows.as_secs_f64(),
            "communication_steps": self.communication_steps,
            "steps": statistics.steps,
            "rejections": statistics.rejections,
            "failures": statistics.failures,
            "iterations": statistics.iterations,
            "trial_iterations": statistics.trial_iterations,
            "factorizations": statistics.factorizations,
            "events": statistics.events,
            "air_solutions": statistics.air_solutions,
            "longest_row_panels": statistics.longest_row_panels,
            "step_us": per(statistics.steps),
            "iteration_us": per(statistics.iterations + statistics.trial_iterations),
        });
        serde_json::to_writer_pretty(&mut sink, &figures)?;
        writeln!(sink)
    }
}
