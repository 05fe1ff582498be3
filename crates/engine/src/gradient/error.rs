//! Reasons for which a run has no gradient.

use crate::system::PlantError;

/// Reason why a run has no gradient.
#[derive(Debug, thiserror::Error)]
pub enum GradientError {
    /// A part of the model has no exact derivative yet.
    #[error("gradients do not cover {part} ({place}); remove it, or use finite differences")]
    NotCovered {
        /// Kind of part, in words.
        part: &'static str,
        /// Its name.
        place: String,
    },
    /// A result, or a start of the run, without an exact derivative; another choice has one.
    #[error("gradients do not cover {part}; {remedy}")]
    OtherChoice {
        /// Kind of result or start, in words.
        part: &'static str,
        /// The other choice, as an instruction.
        remedy: String,
    },
    /// A crossing that the motion only touches: its instant has no derivative.
    #[error(
        "joint {joint} reaches its latch, end stop or bound at {time_s} s with a rate of only {closing_1_s:.1e} rad/s (or \
         m/s), less than a millionth of its largest rate: the time of contact has no derivative; change the model so \
         that the joint reaches it faster or not at all"
    )]
    Grazing {
        /// Joint.
        joint: String,
        /// Time in s.
        time_s: f64,
        /// Rate at which the indicator falls.
        closing_1_s: f64,
    },
    /// A point of the run in a kink of a force: its derivatives to both sides differ.
    #[error(
        "joint {joint}, at {time_s} s: {kink}, where the two one-sided derivatives differ; change one of these values by \
         a small amount"
    )]
    Kink {
        /// Joint.
        joint: String,
        /// Kink, in words.
        kink: &'static str,
        /// Time in s.
        time_s: f64,
    },
    /// A section of a blade or a strip at a corner of its aerodynamics.
    #[error(
        "{body}, at {time_s} s: a section is exactly at {at}, where the two one-sided derivatives differ; change wind, attitude or \
         aerodynamic step by a small amount"
    )]
    Corner {
        /// Body of the section.
        body: String,
        /// The corner, in words.
        at: &'static str,
        /// Time in s.
        time_s: f64,
    },
    /// Two crossings at one instant.
    #[error(
        "{first} and {second} have events at the same time, {time_s} s: a parameter changes the order of the \
         events, so the two one-sided derivatives differ; separate the events by a small asymmetry"
    )]
    Simultaneous {
        /// One joint.
        first: String,
        /// The other, or the same.
        second: String,
        /// Time in s.
        time_s: f64,
    },
    /// Inputs over time that are not possible.
    #[error("inputs over time: {cause}")]
    Inputs {
        /// Cause, in words.
        cause: String,
    },
    /// A requested time that is not after the one before it.
    #[error("the requested times must increase from the current time, {from_s} s, on; {time_s} s does not")]
    Times {
        /// Time before it in s.
        from_s: f64,
        /// Time requested in s.
        time_s: f64,
    },
    /// A neighbouring model has other coordinates or starts in another state.
    #[error(
        "a small change of parameter {parameter} changes {what}, so the derivative is not defined; choose another \
         value, or another parameter"
    )]
    Structure {
        /// Name of the parameter.
        parameter: String,
        /// Change, in words.
        what: &'static str,
    },
    /// A result that this run does not have.
    #[error("the run has no {what}; use a later stop time, or choose another result")]
    Absent {
        /// Result, in words.
        what: String,
    },
    /// A run along the steps of a tape that does not take them.
    #[error("from {time_s} s on the run has other steps than the tape: {what}; choose a smaller change of the model")]
    Apart {
        /// End of the step in s.
        time_s: f64,
        /// Difference, in words.
        what: &'static str,
    },
    /// A linear system without a solution to round-off.
    #[error(
        "the iteration for the linear equations of the step to {time_s} s converges too slowly (relative residual \
         {left:.1e}); use a smaller solver.tolerance or solver.max_step"
    )]
    NotSolved {
        /// End of the step in s.
        time_s: f64,
        /// Size of the last correction relative to the solution.
        left: f64,
    },
    /// The run itself failed.
    #[error(transparent)]
    Run(#[from] PlantError),
}
