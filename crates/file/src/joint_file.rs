//! Joints of the model file: structure and descriptions, as in [`crate::file`]. Keys of prismatic joints are next to those of revolute
//! joints; [`PAIRS`] lists the pairs.

use crate::freedom_file::{
    DcMotorFile, EndStopsFile, GeneratorFile, LatchFile, MotionType, MotorFile, RotationFile, SpringFile, TableEnds,
    TranslationFile,
};
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
