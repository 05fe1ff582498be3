//! Tables of a joint's degree of freedom: structure and descriptions, as in [`crate::file`]. Revolute, prismatic and sliding joints have them
//! in their own table, cylindrical joints in a table for each degree of freedom.

use schemars::JsonSchema;
use serde::Deserialize;

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
/// `[joint.<name>.motor]`, 1 if it has none. For a prismatic or sliding joint the motor has a force of the same form, without a gear
/// ratio.
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

/// Rotation of a cylindrical joint: the joint `<joint>_rotation` of the model, with the keys of revolute joints; its tables `motor`,
/// `spring`, `generator`, `dc_motor`, `latch` and `end_stops` are those of `[joint.<name>]`.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotationFile {
    /// Angle at the start, default 0.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub start_angle_deg: Option<f64>,
    /// Rate at the start, default 0.
    pub start_rate_deg_s: Option<f64>,
    /// Start value of the release input: false locks the angle, from the start at its start value. Default true.
    pub release: Option<bool>,
    /// Motion of the angle, default `free`.
    pub motion: Option<MotionType>,
    /// Prescribed angle as a polynomial in absolute time: coefficients of 1, t, t², …
    #[schemars(length(min = 1, max = 100))]
    pub polynomial_deg: Option<Vec<f64>>,
    /// Prescribed angle as a smooth curve through `[time_s, angle_deg]`, as in `[joint.<name>]`.
    #[schemars(
        length(min = 2),
        extend("x-allowed" = "at least 2 pairs [time in s, angle in deg] of finite numbers")
    )]
    pub table_s_deg: Option<Vec<[f64; 2]>>,
    /// End conditions of the curve through `table_s_deg`, default `rest`.
    pub table_ends: Option<TableEnds>,
    /// Motor.
    pub motor: Option<MotorFile>,
    /// Passive spring and damper, in addition to the motor.
    pub spring: Option<SpringFile>,
    /// Generator.
    pub generator: Option<GeneratorFile>,
    /// Electrical DC motor, in addition to `motor`.
    pub dc_motor: Option<DcMotorFile>,
    /// Latch.
    pub latch: Option<LatchFile>,
    /// End stops.
    pub end_stops: Option<EndStopsFile>,
}

/// Translation of a cylindrical joint: the joint `<joint>_translation` of the model, with the keys of prismatic joints; its tables `motor`,
/// `spring`, `dc_motor`, `latch` and `end_stops` are those of `[joint.<name>]`.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TranslationFile {
    /// Position at the start, default 0.
    pub start_position_m: Option<f64>,
    /// Velocity along the axis at the start, default 0.
    pub start_rate_m_s: Option<f64>,
    /// Start value of the release input: false locks the position, from the start at its start value. Default true.
    pub release: Option<bool>,
    /// Motion of the position, default `free`.
    pub motion: Option<MotionType>,
    /// Prescribed position as a polynomial in absolute time: coefficients of 1, t, t², …
    #[schemars(length(min = 1, max = 100))]
    pub polynomial_m: Option<Vec<f64>>,
    /// Prescribed position as a smooth curve through `[time_s, position_m]`, as in `[joint.<name>]`.
    #[schemars(
        length(min = 2),
        extend("x-allowed" = "at least 2 pairs [time in s, position in m] of finite numbers")
    )]
    pub table_s_m: Option<Vec<[f64; 2]>>,
    /// End conditions of the curve through `table_s_m`, default `rest`.
    pub table_ends: Option<TableEnds>,
    /// Motor.
    pub motor: Option<MotorFile>,
    /// Passive spring and damper, in addition to the motor.
    pub spring: Option<SpringFile>,
    /// Electrical DC motor, in addition to `motor`.
    pub dc_motor: Option<DcMotorFile>,
    /// Latch.
    pub latch: Option<LatchFile>,
    /// End stops.
    pub end_stops: Option<EndStopsFile>,
}
