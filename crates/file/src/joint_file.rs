//! Joints of the model file: structure and descriptions, as in [`crate::file`]. Keys of prismatic joints are next to those of revolute
//! joints; [`PAIRS`] lists the pairs.

use crate::freedom_file::{RotationFile, TranslationFile};
use foldwing_engine::machine::Travel;
use foldwing_engine::machine::builder::Attitude;
use schemars::JsonSchema;
use serde::Deserialize;

/// Joint that holds the inner end of a body. The keys from `axis` on depend on the joint type.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JointFile {
    /// Joint type.
    #[serde(rename = "type")]
    pub kind: JointType,
    /// Parent: `root` or a body.
    pub parent: String,
    /// Body whose inner end the joint holds.
    pub child: String,
    /// Distance along the parent body from its inner end; default: its outer end. Not with a sliding joint.
    #[schemars(range(min = 0.0))]
    pub parent_position_m: Option<f64>,
    /// Attachment frame on the parent, a rigid body; keys in the parent's frame then refer to this frame.
    pub parent_frame: Option<String>,
    /// Offset from the position on the parent to the body's first frame, in the parent's frame there: a rigid massless
    /// arm. Not with `parent = "root"`.
    pub parent_offset_m: Option<[f64; 3]>,
    /// Position in the root frame if the parent is `root`; default: the origin.
    pub root_position_m: Option<[f64; 3]>,
    /// Rotation vector of the body's first frame in the parent's frame: at angle zero of revolute joints, at any position of
    /// prismatic ones, at the start of universal, ball and free ones.
    #[serde(default)]
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub mount_rotation_deg: [f64; 3],
    /// Hinge axis in the parent's section frame, of any length except zero. Positive angles follow the right-hand rule.
    /// For a prismatic joint the sliding axis; positions are positive in its direction. Required for revolute,
    /// prismatic, cylindrical and universal joints, and for sliding ones with `attitude = "hinge"`.
    pub axis: Option<[f64; 3]>,
    /// Second axis of a universal joint in the body's section frame, not parallel to `axis` at the start.
    pub body_axis: Option<[f64; 3]>,
    /// Angular velocity at the start of the body of a universal, ball or free joint, relative to the parent and
    /// resolved in the parent's section frame (on the root: the root frame), not the body's. Default 0.
    pub start_angular_velocity_deg_s: Option<[f64; 3]>,
    /// Velocity of a free body's inner end at the start, root frame, default 0.
    pub start_velocity_m_s: Option<[f64; 3]>,
    /// Fold angle of a revolute joint at the start, default 0; 0 is deployed.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub start_angle_deg: Option<f64>,
    /// Fold rate of a revolute joint at the start, default 0.
    pub start_rate_deg_s: Option<f64>,
    /// Attitude of the body of a sliding joint, default `section`. With `hinge` and `ball` the body rotates freely on the
    /// body `<joint>_carriage`, which has no mass, by the joint `<joint>_hinge` or `<joint>_ball`; both are added to the
    /// model. The keys of the start of a revolute or ball joint, and `mount_rotation_deg`, then apply to this joint.
    pub attitude: Option<AttitudeFile>,
    /// Position of a prismatic joint at the start, default 0; of a sliding joint the distance along the unstrained parent
    /// from its inner end.
    pub start_position_m: Option<f64>,
    /// Velocity of a prismatic or sliding joint along its axis at the start, default 0.
    pub start_rate_m_s: Option<f64>,
    /// Start value of the release input of a revolute or prismatic joint: false locks it, from the start at its start
    /// angle or position. Default true.
    pub release: Option<bool>,
    /// Motion of the angle of a revolute joint, or of the position of a prismatic one, default `free`.
    pub motion: Option<MotionType>,
    /// Prescribed angle as a polynomial in absolute time: coefficients of 1, t, t², …
    #[schemars(length(min = 1, max = 100))]
    pub polynomial_deg: Option<Vec<f64>>,
    /// Prescribed angle as a smooth curve through `[time_s, angle_deg]`, times ascending. Default, see `table_ends`:
    /// zero rate at the first and the last row, constant outside.
    #[schemars(
        length(min = 2),
        extend("x-allowed" = "at least 2 pairs [time in s, angle in deg] of finite numbers")
    )]
    pub table_s_deg: Option<Vec<[f64; 2]>>,
    /// Prescribed position as a polynomial in absolute time: coefficients of 1, t, t², …
    #[schemars(length(min = 1, max = 100))]
    pub polynomial_m: Option<Vec<f64>>,
    /// Prescribed position as a smooth curve through `[time_s, position_m]`, as `table_s_deg`.
    #[schemars(
        length(min = 2),
        extend("x-allowed" = "at least 2 pairs [time in s, position in m] of finite numbers")
    )]
    pub table_s_m: Option<Vec<[f64; 2]>>,
    /// End conditions of the curve through `table_s_deg` or `table_s_m`, default `rest`.
    pub table_ends: Option<TableEnds>,
    /// Motor of a revolute or prismatic joint; spring towards the start attitude and damper of a universal or ball
    /// joint.
    pub motor: Option<MotorFile>,
    /// Passive spring and damper of a revolute or prismatic joint, in addition to its motor.
    pub spring: Option<SpringFile>,
    /// Generator of a revolute joint.
    pub generator: Option<GeneratorFile>,
    /// Electrical DC motor of a revolute, prismatic or sliding joint, in addition to `motor`.
    pub dc_motor: Option<DcMotorFile>,
    /// Latch of a revolute or prismatic joint.
    pub latch: Option<LatchFile>,
    /// End stops of a revolute or prismatic joint.
    pub end_stops: Option<EndStopsFile>,
    /// Rotation of a cylindrical joint.
    pub rotation: Option<RotationFile>,
    /// Translation of a cylindrical joint.
    pub translation: Option<TranslationFile>,
}

/// Joint type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum JointType {
    /// No relative motion.
    #[default]
    Clamped,
    /// Rotation about one axis.
    Revolute,
    /// Translation along one axis.
    Prismatic,
    /// Motion along the axis of the parent, a beam that deforms; `attitude` selects that of the child. The keys of
    /// prismatic joints apply, except `axis`.
    Sliding,
    /// Rotation about two axes, one fixed to each body.
    Universal,
    /// Rotation about any axis.
    Ball,
    /// Six degrees of freedom; on the root only.
    Free,
    /// Translation along one axis and rotation about it. The model has the joints `<joint>_translation` and
    /// `<joint>_rotation`, and between them the body `<joint>_carriage` without mass.
    Cylindrical,
}

impl JointFile {
    /// Returns whether the keys of revolute or of prismatic joints apply.
    pub fn travel(&self) -> Travel {
        self.kind.travel().unwrap_or(Travel::Rotation)
    }

    /// Attitude of the body relative to the beam along which it slides.
    pub fn attitude(&self) -> Attitude {
        match self.attitude {
            None | Some(AttitudeFile::Section) => Attitude::Section,
            Some(AttitudeFile::Hinge) => Attitude::hinge(self.axis.unwrap_or_default()),
            Some(AttitudeFile::Ball) => Attitude::Ball,
        }
    }
}

impl JointType {
    /// Type of motion of joints with one degree of freedom.
    pub fn travel(self) -> Option<Travel> {
        match self {
            Self::Revolute => Some(Travel::Rotation),
            Self::Prismatic | Self::Sliding => Some(Travel::Translation),
            Self::Clamped | Self::Universal | Self::Ball | Self::Free | Self::Cylindrical => None,
        }
    }

    /// Name in the model file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamped => "clamped",
            Self::Revolute => Travel::Rotation.joint_type(),
            Self::Prismatic => Travel::Translation.joint_type(),
            Self::Sliding => "sliding",
            Self::Universal => "universal",
            Self::Ball => "ball",
            Self::Free => "free",
            Self::Cylindrical => "cylindrical",
        }
    }
}

/// Attitude of the body of a sliding joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum AttitudeFile {
    /// That of the beam's section, times the mount.
    Section,
    /// Rotation about `axis`.
    Hinge,
    /// Rotation about any axis.
    Ball,
}

/// Motion of a fold angle or a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum MotionType {
    /// Driven by torques or forces.
    Free,
    /// Locked at its start value.
    Locked,
    /// Prescribed by `polynomial_deg` or `table_s_deg`, or `polynomial_m` or `table_s_m`.
    Prescribed,
}

/// End conditions of a table of angles or positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum TableEnds {
    /// Zero rate at both ends: accelerates in the first interval, decelerates in the last; constant outside.
    Rest,
    /// Zero acceleration at the first and the last row, constant rate outside.
    Extrapolate,
}

/// Motor: its torque on the outer body about the hinge is `−(k (θ − θ_cmd) + c θ̇ + T)`, limited; a prismatic joint's
/// motor has a force of the same form, by the keys in m and N. Universal and ball joints have `k` and `c` only: per
/// axis, or about the rotation vector from the start attitude.
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
    /// Maximum magnitude of the motor torque `−(k (θ − θ_cmd) + c θ̇ + T)`, default unlimited. The joint's spring, the
    /// latch and the external torque are not limited.
    #[serde(rename = "torque_limit_N_m")]
    #[schemars(range(min = 0.0))]
    pub torque_limit_n_m: Option<f64>,
    /// Maximum slew rate of the commanded angle, default unlimited.
    #[schemars(range(min = 0.0))]
    pub rate_limit_deg_s: Option<f64>,
    /// Moment of inertia on the joint's angle only: for a geared motor, the rotor's inertia times the square of the
    /// gear ratio. It adds neither mass nor gyroscopic moment. Default 0.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub inertia_kg_m2: f64,
    /// Gear ratio of a revolute joint's motor: rotor revolutions per joint revolution, negative for opposite rotation.
    /// Rotation of the joint's parent about the axis then also accelerates the rotor, which reacts on the parent: the
    /// coupling inertia is `inertia_kg_m2` over the ratio. Default: an infinite ratio (no coupling).
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
    /// Mass on a prismatic joint's position only: for a lead screw, the rotor's inertia times (2π/lead)². It has no
    /// weight. Default 0.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub mass_kg: f64,
    /// Start value of the commanded (neutral) position.
    #[serde(default)]
    pub command_m: f64,
}

/// Passive spring and damper of a revolute joint: torque `−(k (θ − θ_0) + c θ̇)` on the outer body about the hinge; for
/// a prismatic joint a force, by the keys in m and N. Not limited.
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
    /// Angle `θ_0` of zero spring torque.
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
    /// Position of zero spring force of a prismatic joint.
    #[serde(default)]
    pub rest_position_m: f64,
}

/// Type of a latch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LatchType {
    /// A stiff spring about `angle_deg` or `position_m`.
    #[default]
    Elastic,
    /// Without spring: an impulse stops the joint, and a reaction holds it at the angle or position at which it
    /// latched.
    Rigid,
}

/// Latch: closes as soon as it is enabled and the angle is within `capture_deg` of `angle_deg`, or the position within
/// `capture_m` of `position_m`, from either side, at any rate.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LatchFile {
    /// Type of the latch, default `elastic`.
    #[serde(default)]
    pub kind: LatchType,
    /// Angle at which the latch closes.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub angle_deg: f64,
    /// Ratio of the closed joint's stiffness to that of motor and spring together, `k`: the latch adds `(ratio − 1) k`.
    /// Elastic latches only.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub stiffness_ratio: Option<f64>,
    /// Stiffness that the latch adds; instead of `stiffness_ratio`.
    #[serde(rename = "stiffness_N_m_rad")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m_rad: Option<f64>,
    /// Half-width of the capture window, default 1e-6 rad: a latch with a wider window closes that far from its angle.
    /// With an elastic latch the wing then oscillates about the latch angle; a rigid latch holds the angle at which it
    /// closed.
    #[schemars(range(min = 0.0, max = 360.0))]
    pub capture_deg: Option<f64>,
    /// Position at which the latch of a prismatic joint closes.
    #[serde(default)]
    pub position_m: f64,
    /// Stiffness that the latch of a prismatic joint adds; instead of `stiffness_ratio`.
    #[serde(rename = "stiffness_N_m")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m: Option<f64>,
    /// Half-width of the capture window of a prismatic joint's latch, default 1e-6 m; see `capture_deg`.
    #[schemars(range(min = 0.0))]
    pub capture_m: Option<f64>,
    /// Closed at the start at any angle or position. Elastic latches only: a rigid latch is closed at the start if it
    /// is enabled and `start_angle_deg` or `start_position_m` lies in its capture window.
    #[serde(default)]
    pub initially_closed: bool,
    /// Start value of the enable input.
    #[serde(default = "yes")]
    pub enable: bool,
}

/// End stops of a joint's travel: a unilateral stiff spring and damper beyond either end, which push the joint back and
/// never pull it. At least one end is required.
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
    /// Damping beyond an end. Default 0: fully elastic rebound.
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

/// Keys of the tables `motor`, `spring`, `dc_motor`, `latch` and `end_stops` of a revolute joint, with the corresponding keys of a prismatic joint.
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
    ("dc_motor", "torque_constant_N_m_A", "force_constant_N_A"),
    ("latch", "angle_deg", "position_m"),
    ("latch", "stiffness_N_m_rad", "stiffness_N_m"),
    ("latch", "capture_deg", "capture_m"),
    ("end_stops", "lower_deg", "lower_m"),
    ("end_stops", "upper_deg", "upper_m"),
    ("end_stops", "stiffness_N_m_rad", "stiffness_N_m"),
    ("end_stops", "damping_N_m_s_rad", "damping_N_s_m"),
];

/// Generator on the high-speed shaft of a revolute joint's motor: torque as a function of speed. Speeds refer to the
/// high-speed shaft: the joint rate times `gear_ratio` of `[joint.<name>.motor]`; torque against the motion is
/// positive.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GeneratorFile {
    /// Rows `[speed in rpm, torque in N·m]`, speeds ascending, linear between rows.
    #[serde(rename = "table_rpm_N_m")]
    #[schemars(length(min = 1, max = 1000), extend("x-allowed" = "1 to 1000 rows [speed in rpm, torque in N·m] of finite numbers, speeds ascending"))]
    pub table_rpm_n_m: Vec<[f64; 2]>,
    /// Torque over the square of the speed below the first row, in N·m/rpm²; default: the torque of the first row.
    #[serde(rename = "quadratic_gain_N_m_rpm2")]
    #[schemars(range(min = 0.0))]
    pub quadratic_gain_n_m_rpm2: Option<f64>,
    /// Quantity that is constant above the last row, default `constant_torque`.
    #[serde(default)]
    pub above_table: AboveTableFile,
    /// Ratio of electrical to mechanical power, default 1.
    #[serde(default = "whole")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub efficiency: f64,
    /// Start value of the input `<joint>.generator_on`: false disconnects it. Default true.
    #[serde(default = "yes")]
    pub on: bool,
}

/// Electrical DC motor with permanent magnets: the armature current `i` follows from the input `<joint>.voltage` `u`,
/// `L di/dt + R i + K N θ̇ = u`, and the torque on the outer body about the hinge is `K N i`, with the gear ratio `N` of
/// `[joint.<name>.motor]`, 1 if it has none. A prismatic joint's motor has a force of the same form, without a ratio.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DcMotorFile {
    /// Resistance `R` of the armature.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub resistance_ohm: f64,
    /// Inductance `L` of the armature.
    #[serde(rename = "inductance_H")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inductance_h: f64,
    /// Torque `K` per current on the motor's shaft, equal to the voltage per speed in V·s/rad. Required for revolute joints.
    #[serde(rename = "torque_constant_N_m_A")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub torque_constant_n_m_a: Option<f64>,
    /// Force per current of a prismatic or sliding joint's motor, equal to the voltage per velocity in V·s/m. Required for
    /// these joints.
    #[serde(rename = "force_constant_N_A")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub force_constant_n_a: Option<f64>,
    /// Start value of the input `<joint>.voltage`, default 0.
    #[serde(default, rename = "voltage_V")]
    pub voltage_v: f64,
    /// Current at the start, default 0. A start in equilibrium has the current `u/R`.
    #[serde(default, rename = "start_current_A")]
    pub start_current_a: f64,
}

/// Quantity that is constant above the table of a generator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum AboveTableFile {
    /// The torque of the last row.
    #[default]
    ConstantTorque,
    /// The power of the last row.
    ConstantPower,
}

fn whole() -> f64 {
    1.0
}

pub(super) fn yes() -> bool {
    true
}
