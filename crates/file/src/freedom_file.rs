//! Tables of the degrees of freedom of a cylindrical joint: structure and descriptions, as in [`crate::file`]. Each is built as a joint of
//! its own, with the keys of a revolute or prismatic joint.

use crate::joint_file::{
    DcMotorFile, EndStopsFile, GeneratorFile, JointFile, JointType, LatchFile, MotionType, MotorFile, SpringFile,
    TableEnds,
};
use foldwing_engine::machine::Travel;
use foldwing_engine::machine::builder::{CYLINDRICAL, Freedom, carriage};
use schemars::JsonSchema;
use serde::Deserialize;

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

/// Keys of a joint that its degrees of freedom have in common; all others are in their tables.
const COMMON: &[&str] =
    &["type", "parent", "child", "parent_position_m", "parent_frame", "parent_offset_m", "root_position_m", "axis"];

/// Whether a key of a part of a joint is one of the whole joint.
pub(super) fn is_common(key: &str) -> bool {
    COMMON.contains(&key) || key.starts_with("mount")
}

impl JointType {
    /// Degrees of freedom with a table each.
    pub fn freedoms(self) -> &'static [Freedom] {
        match self {
            Self::Cylindrical => CYLINDRICAL,
            Self::Clamped
            | Self::Revolute
            | Self::Prismatic
            | Self::Sliding
            | Self::Universal
            | Self::Ball
            | Self::Free => &[],
        }
    }
}

impl JointFile {
    /// Names of the parts that the model has in place of this joint, with their paths in the file below `joint`; none if it is a single
    /// joint.
    pub fn parts(&self, name: &str, original: &str) -> Vec<(String, String)> {
        let along = self.attitude().parts(name).into_iter().flatten().map(|part| (part, original.to_owned()));
        let chain = self.kind.freedoms().iter();
        let chain = chain.map(|own| (own.joint(name), format!("{original}.{}", own.name)));
        let between = (1..self.kind.freedoms().len()).map(|next| (carriage(name, next - 1), original.to_owned()));
        along.chain(chain).chain(between).collect()
    }

    /// The table of a degree of freedom as a joint of its own, whose mount and parent are not used.
    pub fn freedom(&self, travel: Travel) -> JointFile {
        match travel {
            Travel::Rotation => {
                let own = self.rotation.clone().unwrap_or_default();
                JointFile {
                    kind: JointType::Revolute,
                    start_angle_deg: own.start_angle_deg,
                    start_rate_deg_s: own.start_rate_deg_s,
                    release: own.release,
                    motion: own.motion,
                    polynomial_deg: own.polynomial_deg,
                    table_s_deg: own.table_s_deg,
                    table_ends: own.table_ends,
                    motor: own.motor,
                    spring: own.spring,
                    generator: own.generator,
                    dc_motor: own.dc_motor,
                    latch: own.latch,
                    end_stops: own.end_stops,
                    ..JointFile::default()
                }
            }
            Travel::Translation => {
                let own = self.translation.clone().unwrap_or_default();
                JointFile {
                    kind: JointType::Prismatic,
                    start_position_m: own.start_position_m,
                    start_rate_m_s: own.start_rate_m_s,
                    release: own.release,
                    motion: own.motion,
                    polynomial_m: own.polynomial_m,
                    table_s_m: own.table_s_m,
                    table_ends: own.table_ends,
                    motor: own.motor,
                    spring: own.spring,
                    dc_motor: own.dc_motor,
                    latch: own.latch,
                    end_stops: own.end_stops,
                    ..JointFile::default()
                }
            }
        }
    }
}
