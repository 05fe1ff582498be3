//! Errors of a table of operating points, and of one of its points.

use crate::names::NameError;
use crate::operating_points::options::Unknown;
use crate::values::{SettingError, Target};
use foldwing_engine::plant::PlantError;

/// A list among the options.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum List {
    /// Wind speeds in m/s.
    WindMS,
    /// Rotor speeds in rpm.
    SpeedRpm,
    /// Pitch angles in degrees.
    PitchDeg,
}

impl List {
    /// Name of the option: `wind_m_s`, `speed_rpm` or `pitch_deg`.
    pub fn name(self) -> &'static str {
        match self {
            Self::WindMS => "wind_m_s",
            Self::SpeedRpm => "speed_rpm",
            Self::PitchDeg => "pitch_deg",
        }
    }
}

/// Error of a table of operating points.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PointsError {
    /// A list without values.
    #[error("{}: has no value", list.name())]
    Empty {
        /// The list.
        list: List,
    },
    /// A value that is not finite.
    #[error("{} {value}: must be finite numbers", list.name())]
    NotFinite {
        /// Its list.
        list: List,
        /// The value.
        value: f64,
    },
    /// A negative wind speed.
    #[error("wind_m_s {value}: must not be negative; the wind of the model gives the direction")]
    NegativeWind {
        /// The speed in m/s.
        value: f64,
    },
    /// A tip speed ratio that is not finite and positive.
    #[error("tip_speed_ratio {ratio}: must be a finite number > 0")]
    TipSpeedRatio {
        /// The ratio.
        ratio: f64,
    },
    /// Several speeds together with a tip speed ratio.
    #[error("speed_rpm: with tip_speed_ratio only one value is allowed, the maximum speed")]
    SeveralSpeeds,
    /// A tip speed ratio without the aerodynamics of a rotor, which has a radius.
    #[error("tip_speed_ratio: needs rotor aerodynamics (aerodynamics.model = \"bem\"); give speed_rpm")]
    NoRadius,
    /// More points than [`MAXIMUM_POINTS`](crate::operating_points::MAXIMUM_POINTS).
    #[error("{count} points exceed the maximum of {most}")]
    TooMany {
        /// Number of points.
        count: usize,
        /// Number allowed.
        most: usize,
    },
    /// Lists that are combined value by value have different lengths.
    #[error(
        "paired: {} has {count} values and another list {longest}; paired lists need the same length, or one value",
        list.name()
    )]
    Unpaired {
        /// The shorter list.
        list: List,
        /// Its number of values.
        count: usize,
        /// Number of values of the longest.
        longest: usize,
    },
    /// A tolerance that is not between 0 and 1.
    #[error("tolerance {tolerance}: must lie between 0 and 1")]
    Tolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// A range whose ends are not two different finite numbers.
    #[error("search {}={from}:{to}: must be two different finite numbers", unknown.name(), from = unknown.range()[0], to = unknown.range()[1])]
    Range {
        /// The unknown with its range.
        unknown: Unknown,
    },
    /// A target that is not finite.
    #[error("target {}={}: must be a finite number in SI units", target.output, target.value)]
    TargetNotFinite {
        /// The target.
        target: Target,
    },
    /// A target for a name that is not a real output.
    #[error("target {}={}: is not a real output", target.output, target.value)]
    NotAnOutput {
        /// The target.
        target: Target,
    },
    /// The unknown of the search is also given as an option.
    #[error("{} is the unknown, so omit its values", unknown.name())]
    SoughtAndGiven {
        /// The unknown.
        unknown: Unknown,
    },
    /// The model has no aerodynamics.
    #[error(
        "{machine}: has no aerodynamics; operating points need [aerodynamics] with model = \"bem\" or \"strip\" and \
         the blades' surfaces"
    )]
    NoAir {
        /// Name of the model.
        machine: String,
    },
    /// The wind has no direction.
    #[error(
        "{machine}: the model has no wind, so its direction is undefined; set aerodynamics.wind_m_s, or a start value \
         of wind.velocity"
    )]
    NoWind {
        /// Name of the model.
        machine: String,
    },
    /// No joints pitch the blades.
    #[error(
        "{machine}: no revolute joints connect the blades to the hub, so the pitch cannot be set; name the pitch \
         joints in pitch_joints"
    )]
    NoPitchJoints {
        /// Name of the model.
        machine: String,
    },
    /// A name of a pitch joint that is not a revolute joint.
    #[error("pitch_joints: the model has no revolute joint {joint:?}")]
    PitchJoint {
        /// The name.
        joint: String,
    },
    /// A pitch joint has neither motor nor lock.
    #[error(
        "the joint {joint}: no motor holds its pitch angle; add a motor with a stiffness, or write motion = \"locked\""
    )]
    LoosePitch {
        /// Name of the joint.
        joint: String,
    },
    /// A name or pattern that no variable has.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A start value that is rejected.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// There is no state at any point; the reason is that at the first point.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The watch of [`tabulate_watched`](crate::operating_points::tabulate_watched) stopped the table.
    #[error("the table was stopped")]
    Stopped,
}

/// Reason why a point has no state.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PointError {
    /// The model has no shaft, or its motion is not periodic.
    #[error("no operating point: {cause}")]
    NoTurn {
        /// The reason.
        cause: String,
    },
    /// The model has no steady state.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// The output is above its target in the whole range.
    #[error(
        "target {output}={target}: {output} is above the target everywhere from {from} to {to}, by {excess:.6e} at the \
         end; extend the range"
    )]
    AboveTarget {
        /// Name of the output.
        output: String,
        /// Its target in SI units.
        target: f64,
        /// Start of the range, in deg or rpm.
        from: f64,
        /// End of the range, in deg or rpm.
        to: f64,
        /// Distance above the target at the end, in SI units.
        excess: f64,
    },
    /// The search ended without a state at which the output meets its target.
    #[error("target {output}={target}: no value was found that reaches the target")]
    NotHeld {
        /// Name of the output.
        output: String,
        /// Its target in SI units.
        target: f64,
    },
}
