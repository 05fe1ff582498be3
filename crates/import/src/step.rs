//! Result of a step of a foreign FMU.

/// Result of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// The step was completed.
    Done,
    /// The FMU requested the end of the simulation at this time in s.
    Ended(f64),
}
