//! Local variables: counters of the time integration and, in real-time mode, durations of its steps.

use crate::interface::table::{Place, Table, Text, Type};
use foldwing_engine::machine::Machine;
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

/// Name, counter and meaning.
const COUNTERS: &[(&str, Counter, &str)] = &[
    ("steps", Counter::Steps, "accepted internal steps"),
    ("rejections", Counter::Rejections, "internal steps rejected by the error estimate"),
    ("failures", Counter::Failures, "internal steps abandoned for non-convergence of the Newton iteration"),
    ("iterations", Counter::Iterations, "Newton iterations"),
    ("factorizations", Counter::Factorizations, "factorisations of the equations of motion"),
    ("events", Counter::Events, "events: joint releases, latch closings and openings, end-stop contacts"),
];

/// Counters of real-time mode only.
const REAL_TIME_COUNTERS: &[(&str, Counter, &str)] = &[
    ("unconverged", Counter::Unconverged, "stages accepted without convergence"),
    ("iterations_max", Counter::LargestIterations, "maximum number of Newton iterations in one stage"),
];

/// Name, duration and meaning in real-time mode.
const DURATIONS: &[(&str, Duration, &str)] = &[
    ("step_time", Duration::Last, "wall time of the last communication step, without reading outputs"),
    (
        "step_time_median",
        Duration::Median,
        "median wall time of the communication steps since initialisation, within 4.5 %",
    ),
    ("step_time_max", Duration::Slowest, "wall time of the slowest communication step since initialisation"),
];

/// Adds the rows.
pub(super) fn locals(table: &mut Table, machine: &Machine) {
    let in_real_time = machine.solver.most_iterations.is_some();
    let counters = if in_real_time { REAL_TIME_COUNTERS } else { &[] };
    for &(name, counter, meaning) in COUNTERS.iter().chain(counters) {
        let text = Text::new(format!("solver.{name}"), format!("{meaning} since initialisation"));
        table.local(Place::Local(counter), Type::Integer, text);
    }
    for &(name, duration, meaning) in if in_real_time { DURATIONS } else { &[] } {
        let text = Text::new(format!("solver.{name}"), meaning);
        table.local(Place::Duration(duration), Type::Real("Time"), text);
    }
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
