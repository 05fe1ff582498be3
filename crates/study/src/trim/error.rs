//! Errors of a trim.

use crate::names::NameError;
use crate::trim::attitude::{Turn, TurnError};
use crate::warnings::Warning;
use foldwing_engine::plant::PlantError;
use foldwing_fmi::interface::AccessError;
use std::fmt;

/// Error of a trim.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrimError {
    /// A name that no variable has.
    #[error(transparent)]
    Name(#[from] NameError),
    /// An unknown that is not allowed.
    #[error("solve_for {unknown}: {error}")]
    SolveFor {
        /// Its name.
        unknown: String,
        /// The error in it.
        error: UnknownError,
    },
    /// A target that is not allowed.
    #[error("targets {output}={value}: {error}")]
    Target {
        /// Name of the output.
        output: String,
        /// Its target in SI units.
        value: f64,
        /// The error in it.
        error: TargetError,
    },
    /// A start value of the attitude or of the turn that is not finite.
    #[error("turns {}={value}: the value is not a finite number", turn.name())]
    NotFinite {
        /// The angle, or the rate.
        turn: Turn,
        /// Its value.
        value: f64,
    },
    /// A start value of the attitude or of the turn for a model that has none.
    #[error("turns {}: {error}", turn.name())]
    Turn {
        /// The angle, or the rate.
        turn: Turn,
        /// Reason why the model has none.
        error: TurnError,
    },
    /// More targets than unknowns, or more unknowns than targets and loads on free joints.
    #[error("{unknowns} unknowns for {targets} targets; {}", needed(*targets, *joint_loads))]
    Count {
        /// Number of unknowns.
        unknowns: usize,
        /// Number of targets.
        targets: usize,
        /// Number of components of loads on free joints, which are balanced too.
        joint_loads: usize,
    },
    /// No unknowns.
    #[error("there is no unknown; name an input or parameter, and a target")]
    NothingFree,
    /// The model rejects a value of an unknown within the iteration.
    #[error("solve_for {name}={value:?}: {error}")]
    Refused {
        /// Name of the input or parameter.
        name: String,
        /// The value, in its SI unit.
        value: f64,
        /// The reason.
        error: AccessError,
    },
    /// There is no equilibrium at values within the iteration.
    #[error(transparent)]
    NoEquilibrium(#[from] PlantError),
    /// The watch of [`solve_watched`](crate::trim::solve_watched) stopped the iteration.
    #[error("the trim was stopped")]
    Stopped,
    /// The iteration did not converge.
    #[error(
        "no trim: {cause}; residuals: {}; use other initial guesses, or other unknowns{}",
        list(residuals),
        listed(warnings)
    )]
    NotConverged {
        /// The reason.
        cause: Cause,
        /// Distance of each output from its target, and loads on free joints, in the last equilibrium.
        residuals: Vec<Residual>,
        /// Warnings about the joints of that equilibrium: open latches, hinges that rotated by more than half a
        /// revolution.
        warnings: Vec<Warning>,
    },
}

/// The error in an unknown.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UnknownError {
    /// Neither a real input nor a real parameter.
    #[error("is not a real input or parameter; only these can be unknowns")]
    NotSettable,
    /// Names that share a value have different units.
    #[error("inputs with different units cannot share a value")]
    MixedUnits,
    /// An unknown is named twice.
    #[error("is named twice; name each value once")]
    Repeated,
    /// The model has no such attitude or turn.
    #[error(transparent)]
    Turn(#[from] TurnError),
}

/// The error in a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TargetError {
    /// The name is not that of a real output.
    #[error("is not a real output")]
    NotAnOutput,
    /// The value is not finite.
    #[error("the value is not a finite number")]
    NotFinite,
    /// The output is named twice.
    #[error("is named twice; name each value once")]
    Repeated,
}

/// Reason why the iteration stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The outputs do not change independently with the unknowns.
    Dependent,
    /// No step along Newton's direction reduces the residuals.
    NoDescent,
    /// The maximum number of steps was reached.
    Steps,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Dependent => "the targets do not depend independently on the unknowns",
            Self::NoDescent => "no step reduces the residuals",
            Self::Steps => "the iteration does not converge",
        })
    }
}

/// Distance of an output from its target, or a component of the load on a free joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Residual {
    /// Name of the output, or of the joint with the component: `flight: force x`.
    pub name: String,
    /// Unit of the value.
    pub unit: &'static str,
    /// The residual.
    pub value: f64,
}

fn needed(targets: usize, joint_loads: usize) -> String {
    match joint_loads {
        0 => "equal numbers are needed".to_owned(),
        loads => format!("{} to {} unknowns are needed", targets.max(1), targets + loads),
    }
}

fn list(residuals: &[Residual]) -> String {
    let entry = |Residual { name, unit, value }: &Residual| format!("{name} {value:+.3e} {unit}");
    residuals.iter().map(entry).collect::<Vec<_>>().join(", ")
}

fn listed(warnings: &[Warning]) -> String {
    warnings.iter().map(|warning| format!("\nlast equilibrium: {warning}")).collect()
}
