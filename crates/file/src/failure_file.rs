//! Failures in the model file: structure and descriptions, as in [`crate::file`].

use schemars::JsonSchema;
use serde::Deserialize;

/// A failure. Failures are permanent. Triggers: the input `failure.<name>.trigger`, `at_time_s`, `after` and `when`,
/// whichever comes first. The keys from `joint` on depend on the kind.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FailureFile {
    /// Kind of failure.
    pub kind: FailureKind,
    /// Joint that is affected; for all kinds except `loop_break` and `stiffness_loss`.
    pub joint: Option<String>,
    /// Loop that fails.
    #[serde(rename = "loop")]
    pub closure: Option<String>,
    /// Beam that loses stiffness.
    pub body: Option<String>,
    /// Time of the trigger.
    pub at_time_s: Option<f64>,
    /// Failure that triggers this one.
    pub after: Option<String>,
    /// Joint motion that triggers the failure.
    pub when: Option<WhenFile>,
    /// Delay from the trigger to the failure, default 0: for example the time to detect another failure.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub delay_s: f64,
    /// Remaining fraction of stiffness and damping. For `spring_break` and `loop_break`, default 0. For
    /// `stiffness_loss` it is required and must be at least 1e-6.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub remaining_fraction: Option<f64>,
    /// Final neutral angle of a motor runaway.
    pub to_deg: Option<f64>,
    /// Rate of the neutral angle in a motor runaway.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate_deg_s: Option<f64>,
    /// Final neutral position of a prismatic joint's motor runaway.
    pub to_m: Option<f64>,
    /// Rate of the neutral position in a prismatic joint's motor runaway.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate_m_s: Option<f64>,
    /// Torque of the fully applied brake, opposing the rate of its joint.
    #[serde(rename = "torque_N_m")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub torque_n_m: Option<f64>,
    /// Force of the fully applied brake, opposing the velocity of its prismatic joint.
    #[serde(rename = "force_N")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub force_n: Option<f64>,
    /// Time over which the brake torque rises from 0, default 0.
    #[schemars(range(min = 0.0))]
    pub ramp_s: Option<f64>,
    /// Slip rate of a brake: below this rate the torque decreases with the rate, so that a braked joint creeps to a
    /// standstill. Default 0.5.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub slip_deg_s: Option<f64>,
    /// Slip velocity of a prismatic joint's brake, default 1e-3; see `slip_deg_s`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub slip_m_s: Option<f64>,
}

/// Kind of failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum FailureKind {
    /// The motor torque is zero; the motor inertia remains.
    MotorLoss,
    /// The joint is locked in its current position.
    MotorJam,
    /// The neutral angle moves to `to_deg` at `rate_deg_s`, or the neutral position to `to_m` at `rate_m_s`, regardless
    /// of the command.
    MotorRunaway,
    /// The latch opens and cannot close again.
    LatchBreak,
    /// The latch cannot close; if it is already closed, it stays closed until it is opened.
    LatchNoCapture,
    /// The lock releases the joint and cannot lock it again, like a restraining link that opens.
    LockRelease,
    /// The spring and damper of the joint, also of a universal or ball joint, are reduced to `remaining_fraction`.
    SpringBreak,
    /// The penalty stiffness and damping of the loop are reduced to `remaining_fraction`.
    LoopBreak,
    /// The stiffness of the beam is reduced to `remaining_fraction`.
    StiffnessLoss,
    /// A brake is applied.
    BrakeApplied,
}

/// A threshold of a joint's motion, one of the keys after `joint`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WhenFile {
    /// Revolute or prismatic joint with free motion.
    pub joint: String,
    /// Triggers when the angle rises above this value.
    pub angle_above_deg: Option<f64>,
    /// Triggers when the angle falls below this value.
    pub angle_below_deg: Option<f64>,
    /// Triggers when the rate rises above this value.
    pub rate_above_deg_s: Option<f64>,
    /// Triggers when the rate falls below this value.
    pub rate_below_deg_s: Option<f64>,
    /// Triggers when the position rises above this value.
    pub position_above_m: Option<f64>,
    /// Triggers when the position falls below this value.
    pub position_below_m: Option<f64>,
    /// Triggers when the velocity rises above this value.
    pub rate_above_m_s: Option<f64>,
    /// Triggers when the velocity falls below this value.
    pub rate_below_m_s: Option<f64>,
}
