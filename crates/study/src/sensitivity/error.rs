//! Errors of the gradient of a run.

use crate::names::NameError;
use foldwing_engine::plant::{GradientError, PlantError};

/// Error in the name of a result of a run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum QuantityError {
    /// No real output has the name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The text after `@` is not a time.
    #[error("`{0}` is not a time in s; write NAME@TIME, such as tip.position.z@0.3")]
    Time(String),
    /// A time that is not within the run.
    #[error("the time {time_s} s is not within the run, {start_s} to {stop_s} s")]
    Outside {
        /// The time in s.
        time_s: f64,
        /// Start of the run in s.
        start_s: f64,
        /// Stop of the run in s.
        stop_s: f64,
    },
    /// The largest value lies at a jump or a kink of the output, where it has no derivative.
    #[error(
        "its largest value, at {time_s} s, is at a jump or a kink of the output, where no derivative exists; request \
         the output at a time (NAME@TIME) instead"
    )]
    Corner {
        /// Time of this value in s.
        time_s: f64,
    },
    /// The output is zero all over the run: its root mean square has a kink there.
    #[error("it is zero throughout the run, where a root mean square has no derivative; request the mean instead")]
    Zero,
}

/// Error of the gradient of a run.
#[derive(Debug, thiserror::Error)]
pub enum GradientsError {
    /// A result that the run does not have.
    #[error("{of}: {error}")]
    Quantity {
        /// The text.
        of: String,
        /// Error in its name.
        error: QuantityError,
    },
    /// No results are requested.
    #[error("there is no result to differentiate; name an output or a latch time")]
    NoResult,
    /// The run does not end after its start.
    #[error("the stop time {stop_s} s is not after the start time {start_s} s")]
    Stop {
        /// Start in s.
        start_s: f64,
        /// Stop in s.
        stop_s: f64,
    },
    /// The engine cannot differentiate the run.
    #[error(transparent)]
    Gradient(#[from] GradientError),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] PlantError),
}
