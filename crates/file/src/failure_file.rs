//! The failures of the model file: shape and descriptions, as in [`crate::file`].

use schemars::JsonSchema;
use serde::Deserialize;

/// A failure: happens once, and nothing repairs it. Its input `failure.<name>.trigger` brings it about; so do `at_time_s`, `after`
/// and `when`, whichever comes first. The keys from `joint` on depend on the kind.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FailureFile {
    /// What fails.
    pub kind: FailureKind,
    /// Joint on which something fails; of all kinds except `loop_break` and `stiffness_loss`.
    pub joint: Option<String>,
    /// Loop that opens.
    #[serde(rename = "loop")]
    pub closure: Option<String>,
    /// Beam that weakens.
    pub body: Option<String>,
    /// Time that brings it about.
    pub at_time_s: Option<f64>,
    /// Another failure that brings it about.
    pub after: Option<String>,
    /// Motion of a joint that brings it about.
    pub when: Option<WhenFile>,
    /// Time from what brings it about until it happens, default 0: detection of another failure, for example.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub delay_s: f64,
    /// Share of stiffness and damping that remains. Of `spring_break` and `loop_break`, default 0: none; `stiffness_loss` needs it, and
    /// at least 1e-6 of a body's stiffness remains.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub remaining_fraction: Option<f64>,
    /// Neutral angle at which a motor that runs away ends.
    pub to_deg: Option<f64>,
    /// Rate of the neutral angle of a motor that runs away.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate_deg_s: Option<f64>,
    /// Neutral position at which the motor of a prismatic joint ends that runs away.
    pub to_m: Option<f64>,
    /// Rate of the neutral position of a prismatic joint's motor that runs away.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate_m_s: Option<f64>,
    /// Torque of a brake that is fully on, against the rate of its joint.
    #[serde(rename = "torque_N_m")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub torque_n_m: Option<f64>,
    /// Force of a brake that is fully on, against the velocity of its prismatic joint.
    #[serde(rename = "force_N")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub force_n: Option<f64>,
    /// Time over which the torque of a brake grows from 0, default 0.
    #[schemars(range(min = 0.0))]
    pub ramp_s: Option<f64>,
    /// Rate beyond which a brake slips: below it its torque falls with the rate, so that a braked joint creeps to rest.
    /// Default 0.5.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub slip_deg_s: Option<f64>,
    /// Velocity beyond which the brake of a prismatic joint slips, default 1e-3; see `slip_deg_s`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub slip_m_s: Option<f64>,
}

/// What fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum FailureKind {
    /// The motor gives no torque any more; its inertia stays.
    MotorLoss,
    /// The joint is held where it is.
    MotorJam,
    /// The neutral angle goes to `to_deg` at `rate_deg_s`, or the neutral position to `to_m` at `rate_m_s`, whatever is commanded.
    MotorRunaway,
    /// The latch opens and does not close again.
    LatchBreak,
    /// The latch does not close; where it is closed already, it stays so until it is opened.
    LatchNoCapture,
    /// The stopper lets go and does not hold the joint again: a link that held it opens.
    LockRelease,
    /// Spring and damper of the joint, or of a universal or ball joint, keep `remaining_fraction`.
    SpringBreak,
    /// The loop keeps `remaining_fraction` of its penalty.
    LoopBreak,
    /// The stiffness of the beam falls to `remaining_fraction`.
    StiffnessLoss,
    /// A brake comes on.
    BrakeApplied,
}

/// A bound on the motion of a joint, one of the keys behind `joint`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WhenFile {
    /// Joint, revolute or prismatic and free.
    pub joint: String,
    /// The angle rises above.
    pub angle_above_deg: Option<f64>,
    /// The angle falls below.
    pub angle_below_deg: Option<f64>,
    /// The rate rises above.
    pub rate_above_deg_s: Option<f64>,
    /// The rate falls below.
    pub rate_below_deg_s: Option<f64>,
    /// The position rises above.
    pub position_above_m: Option<f64>,
    /// The position falls below.
    pub position_below_m: Option<f64>,
    /// The velocity rises above.
    pub rate_above_m_s: Option<f64>,
    /// The velocity falls below.
    pub rate_below_m_s: Option<f64>,
}
