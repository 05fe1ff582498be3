//! The joints of the model file: shape and descriptions, as in [`crate::file`]. Keys of prismatic joints stand
//! beside those of revolute ones; [`PAIRS`] says which is which.

use crate::generator::GeneratorFile;
use foldwing_engine::machine::Travel;
use schemars::JsonSchema;
use serde::Deserialize;

/// Joint that holds a body's inner end. The keys from `axis` on depend on the type of the joint.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JointFile {
    /// What the joint allows.
    #[serde(rename = "type")]
    pub kind: JointType,
    /// What the joint is attached to: `root` or a body.
    pub parent: String,
    /// Body whose inner end the joint holds.
    pub child: String,
    /// Distance along the parent body from its inner end; default: its outer end.
    #[schemars(range(min = 0.0))]
    pub parent_position_m: Option<f64>,
    /// Frame of the parent, a rigid body, that the joint holds on to; keys in the parent's frame then refer to this frame.
    pub parent_frame: Option<String>,
    /// From the place on the parent to the body's first frame, in the parent's frame there: a rigid arm without mass. Not with
    /// `parent = "root"`.
    pub parent_offset_m: Option<[f64; 3]>,
    /// Position in the root frame if the parent is `root`; default: the origin.
    pub root_position_m: Option<[f64; 3]>,
    /// Rotation vector of the body's first frame in the parent's frame: at angle zero of revolute joints, at any position of
    /// prismatic ones, at the start of universal, ball and free ones.
    #[serde(default)]
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub mount_rotation_deg: [f64; 3],
    /// Hinge axis in the parent's section frame, of any length except zero. Positive angles follow the right-hand rule. The axis
    /// along which a prismatic joint slides; positive positions lie the way that it points. Revolute, prismatic and universal
    /// joints need it.
    pub axis: Option<[f64; 3]>,
    /// Second axis of a universal joint in the body's section frame, not parallel to `axis` at the start.
    pub body_axis: Option<[f64; 3]>,
    /// Angular velocity of a universal, ball or free joint's body at the start, relative to the parent and resolved in the
    /// parent's section frame (the root frame on the root), not the body's. Default 0.
    pub start_angular_velocity_deg_s: Option<[f64; 3]>,
    /// Velocity of a free body's inner end at the start, root frame, default 0.
    pub start_velocity_m_s: Option<[f64; 3]>,
    /// Fold angle of a revolute joint at the start, default 0; 0 is deployed.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub start_angle_deg: Option<f64>,
    /// Fold rate of a revolute joint at the start, default 0.
    pub start_rate_deg_s: Option<f64>,
    /// Position of a prismatic joint at the start, default 0.
    pub start_position_m: Option<f64>,
    /// Velocity of a prismatic joint along its axis at the start, default 0.
    pub start_rate_m_s: Option<f64>,
    /// Start value of a revolute or prismatic joint's release input: false holds it where it is, at the start at its start
    /// angle or position. Default true.
    pub release: Option<bool>,
    /// How the angle of a revolute joint, or the position of a prismatic one, moves, default `free`.
    pub motion: Option<MotionType>,
    /// Prescribed angle as a polynomial of absolute time: coefficients of 1, t, t², …
    #[schemars(length(min = 1, max = 100))]
    pub polynomial_deg: Option<Vec<f64>>,
    /// Prescribed angle as a smooth curve through `[time_s, angle_deg]`, times ascending. Unless `table_ends` says
    /// otherwise it leaves the first row and reaches the last at rest, and holds them outside.
    #[schemars(
        length(min = 2),
        extend("x-allowed" = "at least 2 pairs [time in s, angle in deg] of finite numbers")
    )]
    pub table_s_deg: Option<Vec<[f64; 2]>>,
    /// Prescribed position as a polynomial of absolute time: coefficients of 1, t, t², …
    #[schemars(length(min = 1, max = 100))]
    pub polynomial_m: Option<Vec<f64>>,
    /// Prescribed position as a smooth curve through `[time_s, position_m]`, as `table_s_deg`.
    #[schemars(
        length(min = 2),
        extend("x-allowed" = "at least 2 pairs [time in s, position in m] of finite numbers")
    )]
    pub table_s_m: Option<Vec<[f64; 2]>>,
    /// How the curve through `table_s_deg` or `table_s_m` starts and ends, default `rest`.
    pub table_ends: Option<TableEnds>,
    /// Motor of a revolute or prismatic joint; spring towards the start attitude and damper of a universal or ball joint.
    pub motor: Option<MotorFile>,
    /// Spring and damper of a revolute or prismatic joint itself, in addition to its motor.
    pub spring: Option<SpringFile>,
    /// Generator of a revolute joint.
    pub generator: Option<GeneratorFile>,
    /// Latch of a revolute or prismatic joint.
    pub latch: Option<LatchFile>,
    /// EndStops of a revolute or prismatic joint.
    pub end_stops: Option<EndStopsFile>,
}

/// What a joint allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum JointType {
    /// Nothing.
    Clamped,
    /// Rotation about one axis.
    Revolute,
    /// Translation along one axis.
    Prismatic,
    /// Rotation about two axes, one fixed to each side.
    Universal,
    /// All rotations.
    Ball,
    /// Everything; on the root only.
    Free,
}

impl JointFile {
    /// Whether the keys that turn or those that slide are the joint's.
    pub fn travel(&self) -> Travel {
        self.kind.travel().unwrap_or(Travel::Rotation)
    }
}

impl JointType {
    /// Of joints with one freedom.
    pub fn travel(self) -> Option<Travel> {
        match self {
            Self::Revolute => Some(Travel::Rotation),
            Self::Prismatic => Some(Travel::Translation),
            Self::Clamped | Self::Universal | Self::Ball | Self::Free => None,
        }
    }

    /// Name as the file writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamped => "clamped",
            Self::Revolute => Travel::Rotation.joint_type(),
            Self::Prismatic => Travel::Translation.joint_type(),
            Self::Universal => "universal",
            Self::Ball => "ball",
            Self::Free => "free",
        }
    }
}

/// How a fold angle or a position moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum MotionType {
    /// By its torques or forces.
    Free,
    /// Not at all: held where it starts.
    Locked,
    /// By `polynomial_deg` or `table_s_deg`, or `polynomial_m` or `table_s_m`.
    Prescribed,
}

/// How a table of angles or positions begins and ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum TableEnds {
    /// At rest: the first interval speeds up, the last one brakes; the angle holds outside.
    Rest,
    /// Moving on: without acceleration at the first and the last row, at constant rate outside.
    Extrapolate,
}

/// Motor: its torque on the outer body about the hinge is `−(k (θ − θ_cmd) + c θ̇ + T)`, limited; the force of a prismatic
/// joint's motor likewise, by the keys in m and N. Universal and ball joints have `k` and `c` only: per axis, or about the
/// rotation vector from the start attitude.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MotorFile {
    /// Stiffness `k`.
    #[serde(default, rename = "stiffness_N_m_rad")]
    #[schemars(range(min = 0.0))]
    pub stiffness_n_m_rad: f64,
    /// Damping `c`.
    #[serde(default, rename = "damping_N_m_s_rad")]
    #[schemars(range(min = 0.0))]
    pub damping_n_m_s_rad: f64,
    /// Constant torque `T`, towards negative angles.
    #[serde(default, rename = "constant_torque_N_m")]
    pub constant_torque_n_m: f64,
    /// Maximum magnitude of the motor torque `−(k (θ − θ_cmd) + c θ̇ + T)`, default unlimited. It limits neither the
    /// joint's spring nor the latch nor the external torque.
    #[serde(rename = "torque_limit_N_m")]
    #[schemars(range(min = 0.0))]
    pub torque_limit_n_m: Option<f64>,
    /// Maximum slew rate of the commanded angle, default unlimited.
    #[schemars(range(min = 0.0))]
    pub rate_limit_deg_s: Option<f64>,
    /// Moment of inertia that turns with the joint's angle only: for a motor with gear, the rotor's inertia times the
    /// square of the gear ratio. It has neither mass nor gyroscopic moment. Default 0.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub inertia_kg_m2: f64,
    /// Gear ratio of a revolute joint's motor: turns of its rotor per turn of the joint, negative where it turns the other way. The
    /// rotor then also feels the turn of the joint's parent about the axis, and reacts on it: `inertia_kg_m2` over the ratio couples the
    /// two. Default: so large a ratio that it does not matter.
    #[schemars(extend("x-allowed" = "a finite ratio other than 0"))]
    pub gear_ratio: Option<f64>,
    /// Start value of the commanded (neutral) angle `θ_cmd`.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub command_deg: f64,
    /// Stiffness `k` of a prismatic joint's motor.
    #[serde(default, rename = "stiffness_N_m")]
    #[schemars(range(min = 0.0))]
    pub stiffness_n_m: f64,
    /// Damping `c` of a prismatic joint's motor.
    #[serde(default, rename = "damping_N_s_m")]
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: f64,
    /// Constant force of a prismatic joint's motor, towards negative positions.
    #[serde(default, rename = "constant_force_N")]
    pub constant_force_n: f64,
    /// Maximum magnitude of the motor force of a prismatic joint, default unlimited; see `torque_limit_N_m`.
    #[serde(rename = "force_limit_N")]
    #[schemars(range(min = 0.0))]
    pub force_limit_n: Option<f64>,
    /// Maximum slew rate of the commanded position, default unlimited.
    #[schemars(range(min = 0.0))]
    pub rate_limit_m_s: Option<f64>,
    /// Mass that moves with a prismatic joint's position only: for a spindle, the rotor's inertia times the square of its
    /// turn per way. It has no weight. Default 0.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub mass_kg: f64,
    /// Start value of the commanded (neutral) position.
    #[serde(default)]
    pub command_m: f64,
}

/// Spring and damper of a revolute joint itself: their torque on the outer body about the hinge is
/// `−(k (θ − θ_0) + c θ̇)`; of a prismatic joint their force, by the keys in m and N. It is not limited.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SpringFile {
    /// Stiffness `k`.
    #[serde(default, rename = "stiffness_N_m_rad")]
    #[schemars(range(min = 0.0))]
    pub stiffness_n_m_rad: f64,
    /// Damping `c`.
    #[serde(default, rename = "damping_N_m_s_rad")]
    #[schemars(range(min = 0.0))]
    pub damping_n_m_s_rad: f64,
    /// Angle `θ_0` at which the spring is slack.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rest_angle_deg: f64,
    /// Stiffness `k` of a prismatic joint's spring.
    #[serde(default, rename = "stiffness_N_m")]
    #[schemars(range(min = 0.0))]
    pub stiffness_n_m: f64,
    /// Damping `c` of a prismatic joint's damper.
    #[serde(default, rename = "damping_N_s_m")]
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: f64,
    /// Position at which the spring of a prismatic joint is slack.
    #[serde(default)]
    pub rest_position_m: f64,
}

/// What a closed latch does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LatchType {
    /// A stiff spring about `angle_deg` or `position_m`.
    #[default]
    Elastic,
    /// No spring: an impulse stops the joint, and a reaction holds it at the angle or position at which it was caught.
    Rigid,
}

/// Latch: closes as soon as it is enabled and the angle is within `capture_deg` of `angle_deg`, or the position within
/// `capture_m` of `position_m`, from either side, moving or at rest.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LatchFile {
    /// What it does when closed, default `elastic`.
    #[serde(default)]
    pub kind: LatchType,
    /// Angle at which it closes.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub angle_deg: f64,
    /// Stiffness of the closed joint over that of motor and spring together, `k`: the latch adds `(ratio − 1) k`. Of
    /// elastic latches.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub stiffness_ratio: Option<f64>,
    /// Stiffness that the latch adds; instead of `stiffness_ratio`.
    #[serde(rename = "stiffness_N_m_rad")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m_rad: Option<f64>,
    /// Half-width of the window that catches the joint, default 1e-6 rad: a wider one closes the latch that far from
    /// its angle. An elastic latch then lets the wing swing about its angle, a rigid one holds it where it was caught.
    #[schemars(range(min = 0.0, max = 360.0))]
    pub capture_deg: Option<f64>,
    /// Position at which the latch of a prismatic joint closes.
    #[serde(default)]
    pub position_m: f64,
    /// Stiffness that the latch of a prismatic joint adds; instead of `stiffness_ratio`.
    #[serde(rename = "stiffness_N_m")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m: Option<f64>,
    /// Half-width of the window of a prismatic joint's latch, default 1e-6 m; see `capture_deg`.
    #[schemars(range(min = 0.0))]
    pub capture_m: Option<f64>,
    /// Closed at the start wherever the joint is. Of elastic latches: a rigid one is closed at the start where it is
    /// enabled and `start_angle_deg` or `start_position_m` lies in its window.
    #[serde(default)]
    pub initially_closed: bool,
    /// Start value of the enable input.
    #[serde(default = "yes")]
    pub enable: bool,
}

/// EndStops at the ends of a joint's travel: a stiff spring and a damper that act beyond either end, push the joint back and never
/// pull it. At least one end is needed.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EndStopsFile {
    /// Lower end, none by default.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub lower_deg: Option<f64>,
    /// Upper end, none by default; above `lower_deg`.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub upper_deg: Option<f64>,
    /// Stiffness beyond an end.
    #[serde(rename = "stiffness_N_m_rad")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m_rad: Option<f64>,
    /// Damping beyond an end. Default 0: the joint rebounds with the speed with which it has come.
    #[serde(default, rename = "damping_N_m_s_rad")]
    #[schemars(range(min = 0.0))]
    pub damping_n_m_s_rad: f64,
    /// Lower end of a prismatic joint's travel, none by default.
    pub lower_m: Option<f64>,
    /// Upper end of a prismatic joint's travel, none by default; above `lower_m`.
    pub upper_m: Option<f64>,
    /// Stiffness beyond an end of a prismatic joint's travel.
    #[serde(rename = "stiffness_N_m")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m: Option<f64>,
    /// Damping beyond an end of a prismatic joint's travel; see `damping_N_m_s_rad`.
    #[serde(default, rename = "damping_N_s_m")]
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: f64,
}

/// Keys of a revolute joint's tables `motor`, `spring`, `latch` and `end_stops`, and those that a prismatic joint has in their place.
pub(super) const PAIRS: &[(&str, &str, &str)] = &[
    ("motor", "stiffness_N_m_rad", "stiffness_N_m"),
    ("motor", "damping_N_m_s_rad", "damping_N_s_m"),
    ("motor", "constant_torque_N_m", "constant_force_N"),
    ("motor", "torque_limit_N_m", "force_limit_N"),
    ("motor", "rate_limit_deg_s", "rate_limit_m_s"),
    ("motor", "inertia_kg_m2", "mass_kg"),
    ("motor", "command_deg", "command_m"),
    ("spring", "stiffness_N_m_rad", "stiffness_N_m"),
    ("spring", "damping_N_m_s_rad", "damping_N_s_m"),
    ("spring", "rest_angle_deg", "rest_position_m"),
    ("latch", "angle_deg", "position_m"),
    ("latch", "stiffness_N_m_rad", "stiffness_N_m"),
    ("latch", "capture_deg", "capture_m"),
    ("end_stops", "lower_deg", "lower_m"),
    ("end_stops", "upper_deg", "upper_m"),
    ("end_stops", "stiffness_N_m_rad", "stiffness_N_m"),
    ("end_stops", "damping_N_m_s_rad", "damping_N_s_m"),
];

pub(super) fn yes() -> bool {
    true
}
