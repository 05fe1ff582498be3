//! Kinds of counters and durations, and their values.

use foldwing_engine::plant::{Latency, Statistics};

/// A counter of the time integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counter {
    /// Accepted steps.
    Steps,
    /// Rejected steps.
    Rejections,
    /// Steps abandoned for non-convergence of Newton's method.
    Failures,
    /// Newton iterations.
    Iterations,
    /// Factorisations.
    Factorizations,
    /// Events.
    Events,
    /// Stages accepted without convergence.
    Unconverged,
    /// Maximum number of iterations of one stage.
    LargestIterations,
}

/// A duration of communication steps in real-time mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Duration {
    /// Duration of the last step.
    Last,
    /// Median.
    Median,
    /// Duration of the slowest step.
    Slowest,
}

impl Duration {
    /// Current value in s.
    pub(super) fn read_s(self, latency: &Latency) -> f64 {
        match self {
            Self::Last => latency.last_s(),
            Self::Median => latency.quantile_s(0.5),
            Self::Slowest => latency.slowest_s(),
        }
    }
}

impl Counter {
    /// Current count; saturates at the largest Integer.
    pub(super) fn read(self, statistics: &Statistics) -> i32 {
        let count = match self {
            Self::Steps => statistics.steps,
            Self::Rejections => statistics.rejections,
            Self::Failures => statistics.failures,
            Self::Iterations => statistics.iterations,
            Self::Factorizations => statistics.factorizations,
            Self::Events => statistics.events,
            Self::Unconverged => statistics.unconverged,
            Self::LargestIterations => statistics.largest_iterations,
        };
        i32::try_from(count).unwrap_or(i32::MAX)
    }
}
