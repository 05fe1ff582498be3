//! The model file's shape. Doc comments become the descriptions of the JSON schema and of `docs/MODEL_FILE.md`.
//!
//! Ranges that one key states alone stand here as JSON schema keywords (`minimum`, `exclusiveMinimum`, …) and are
//! enforced from there; `x-allowed` overrides the wording of error messages where a range cannot say it.

use crate::config::machine::ElementKind;
use crate::config::run::{ExperimentFile, SolverFile};
use crate::load::LoadFrame;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A Foldwing model: a wing of flexible bodies and fold joints. SI units; angles in degrees where the key says `_deg`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Foldwing model file")]
pub(super) struct ModelFile {
    /// Model name; names the FMU.
    #[schemars(extend("pattern" = "^[A-Za-z_][A-Za-z0-9_]*$"))]
    pub name: String,
    /// One-line description.
    #[serde(default)]
    pub description: String,
    /// Gravity in the root frame.
    #[serde(default)]
    pub gravity_m_s2: [f64; 3],
    /// Cross-sections by name.
    #[schemars(extend("minProperties" = 1, "x-allowed" = "at least one table [section.<name>]"))]
    pub section: IndexMap<String, SectionFile>,
    /// Bodies by name: beams, each held by exactly one joint at its inner end.
    #[schemars(extend("minProperties" = 1, "x-allowed" = "at least one table [body.<name>]"))]
    pub body: IndexMap<String, BodyFile>,
    /// Joints by name; a joint's name is a group of the FMU's variables.
    #[schemars(extend("minProperties" = 1, "x-allowed" = "at least one table [joint.<name>]"))]
    pub joint: IndexMap<String, JointFile>,
    /// Point masses and rigid bodies by name.
    #[serde(default)]
    pub mass: IndexMap<String, MassFile>,
    /// Loads at stations by name: start values of the inputs `load.<body>[station]`, constant unless these are set.
    #[serde(default)]
    pub load: IndexMap<String, LoadFile>,
    /// Strain gauges by name; the FMU's output is `gauge.<name>.strain`.
    #[serde(default)]
    pub gauge: IndexMap<String, GaugeFile>,
    /// Time integration.
    #[serde(default)]
    pub solver: SolverFile,
    /// Default experiment.
    #[serde(default)]
    pub experiment: ExperimentFile,
}

/// Cross-section, constant along a body. `y` runs chordwise, `z` through the thickness.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum SectionFile {
    /// Solid rectangle of one isotropic material.
    Rectangle(SolidSection),
    /// Solid ellipse of one isotropic material.
    Ellipse(SolidSection),
    /// Any section, by its stiffness and inertia: either the four stiffnesses with optional couplings, or
    /// `stiffness_SI`.
    Explicit(Box<ExplicitSection>),
}

/// Solid section of one isotropic material.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SolidSection {
    /// Full width along `y`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub width_m: f64,
    /// Full height along `z`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height_m: f64,
    /// Density.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_kg_m3: f64,
    /// Young's modulus.
    #[serde(rename = "young_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub young_pa: f64,
    /// Shear modulus; instead of `poisson_ratio`. Not needed where `torsional_rigidity_N_m2` is given.
    #[serde(rename = "shear_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub shear_pa: Option<f64>,
    /// Poisson's ratio; instead of `shear_Pa`. Not needed where `torsional_rigidity_N_m2` is given.
    #[schemars(extend("exclusiveMinimum" = -1, "maximum" = 0.5))]
    pub poisson_ratio: Option<f64>,
    /// Torsional rigidity `GJ`, instead of Saint-Venant's value for the outline.
    #[serde(rename = "torsional_rigidity_N_m2")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub torsional_rigidity_n_m2: Option<f64>,
}

/// Section by its stiffness and inertia, about the beam axis.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ExplicitSection {
    /// Axial stiffness `EA`.
    #[serde(rename = "axial_stiffness_N")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub axial_stiffness_n: Option<f64>,
    /// Torsional rigidity `GJ`.
    #[serde(rename = "torsional_rigidity_N_m2")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub torsional_rigidity_n_m2: Option<f64>,
    /// Bending stiffness `EI_y` about `y` (flap).
    #[serde(rename = "flap_stiffness_N_m2")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub flap_stiffness_n_m2: Option<f64>,
    /// Bending stiffness `EI_z` about `z` (lag).
    #[serde(rename = "lag_stiffness_N_m2")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub lag_stiffness_n_m2: Option<f64>,
    /// Coupling of stretch and twist, default 0.
    #[serde(rename = "coupling_axial_twist_N_m")]
    pub coupling_axial_twist_n_m: Option<f64>,
    /// Coupling of stretch and curvature about `y`, default 0.
    #[serde(rename = "coupling_axial_flap_N_m")]
    pub coupling_axial_flap_n_m: Option<f64>,
    /// Coupling of stretch and curvature about `z`, default 0.
    #[serde(rename = "coupling_axial_lag_N_m")]
    pub coupling_axial_lag_n_m: Option<f64>,
    /// Coupling of twist and curvature about `y` (bend–twist), default 0.
    #[serde(rename = "coupling_twist_flap_N_m2")]
    pub coupling_twist_flap_n_m2: Option<f64>,
    /// Coupling of twist and curvature about `z`, default 0.
    #[serde(rename = "coupling_twist_lag_N_m2")]
    pub coupling_twist_lag_n_m2: Option<f64>,
    /// Coupling of the two curvatures, default 0.
    #[serde(rename = "coupling_flap_lag_N_m2")]
    pub coupling_flap_lag_n_m2: Option<f64>,
    /// Full stiffness of the strains `(εx, κx, κy, κz)` in N, N·m and N·m², symmetric and positive definite; instead
    /// of the four stiffnesses and the couplings.
    #[serde(rename = "stiffness_SI")]
    #[schemars(extend("x-allowed" = "a 4 x 4 matrix of finite numbers in N, N·m and N·m²"))]
    pub stiffness_si: Option<[[f64; 4]; 4]>,
    /// Mass per length.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg_m: f64,
    /// Centre of mass `[y, z]` from the beam axis.
    #[serde(default)]
    pub centre_of_mass_m: [f64; 2],
    /// Second moments of mass per length about the centre of mass: `[∫ρy² dA, ∫ρyz dA, ∫ρz² dA]`.
    pub second_moments_kg_m: [f64; 3],
    /// Largest `|y|` of the outline; gauges need it.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_width_m: Option<f64>,
    /// Largest `|z|` of the outline; gauges need it.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_height_m: Option<f64>,
}

/// A beam.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyFile {
    /// Arc length of the undeformed axis.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: f64,
    /// Name of the cross-section.
    pub section: String,
    /// Kind of strain element.
    #[serde(default)]
    pub element: ElementFile,
    /// Number of elements along the body; a linear element is one pair of halves.
    #[schemars(range(min = 1, max = 1000))]
    pub elements: usize,
    /// Natural twist and curvatures `[κx, κy, κz]`: the shape without loads.
    #[serde(default)]
    pub natural_curvature_1_m: [f64; 3],
    /// Mass-proportional damping `α`; acts on the beam only, not on attached masses.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub mass_damping_1_s: f64,
    /// Stiffness-proportional damping `β`.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub stiffness_damping_s: f64,
    /// Number of load stations at the centres of equal strips, default 4.
    #[schemars(range(min = 0, max = 1000))]
    pub load_stations: Option<usize>,
    /// Distances of the load stations from the inner end, ascending; instead of `load_stations`.
    #[schemars(length(max = 1000))]
    pub load_station_positions_m: Option<Vec<f64>>,
    /// Frame of the forces and moments at the stations: `root` (dead loads) or `section` (follower loads).
    #[serde(default)]
    pub load_frame: LoadFrameFile,
}

/// Kind of strain element.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum ElementFile {
    /// Linear strain: fourth order.
    #[default]
    Linear,
    /// Constant strain: second order.
    Constant,
}

impl From<ElementFile> for ElementKind {
    fn from(kind: ElementFile) -> Self {
        match kind {
            ElementFile::Linear => Self::Linear,
            ElementFile::Constant => Self::Constant,
        }
    }
}

/// Frame of station loads.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LoadFrameFile {
    /// Root frame: a dead load.
    #[default]
    Root,
    /// Section frame: a follower load.
    Section,
}

impl From<LoadFrameFile> for LoadFrame {
    fn from(frame: LoadFrameFile) -> Self {
        match frame {
            LoadFrameFile::Root => Self::Root,
            LoadFrameFile::Section => Self::Section,
        }
    }
}

/// Joint that holds a body's inner end. The keys from `axis` on belong to revolute joints.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JointFile {
    /// What the joint allows.
    #[serde(rename = "type")]
    pub kind: JointType,
    /// What the joint holds on to: `root` or a body.
    pub parent: String,
    /// Body whose inner end the joint holds.
    pub child: String,
    /// Distance along the parent body from its inner end, default its outer end.
    #[schemars(range(min = 0.0))]
    pub parent_position_m: Option<f64>,
    /// Position in the root frame where the parent is `root`, default the origin.
    pub root_position_m: Option<[f64; 3]>,
    /// Rotation vector of the body's first frame in the parent's frame at angle zero.
    #[serde(default)]
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub mount_rotation_deg: [f64; 3],
    /// Hinge axis in the parent's section frame, of any length but zero. Positive angles by the right hand.
    pub axis: Option<[f64; 3]>,
    /// Fold angle at the start, default 0; 0 is deployed.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub start_angle_deg: Option<f64>,
    /// Fold rate at the start, default 0.
    pub start_rate_deg_s: Option<f64>,
    /// Start value of the release input: false holds the joint at its start angle until released. Default true.
    pub release: Option<bool>,
    /// How the angle moves, default `free`.
    pub motion: Option<MotionType>,
    /// Prescribed angle as a polynomial of absolute time: coefficients of 1, t, t², …
    #[schemars(length(min = 1, max = 100))]
    pub polynomial_deg: Option<Vec<f64>>,
    /// Prescribed angle as a smooth curve through `[time_s, angle_deg]`, times ascending; constant outside.
    #[schemars(
        length(min = 2),
        extend("x-allowed" = "at least 2 pairs [time in s, angle in deg] of finite numbers")
    )]
    pub table_s_deg: Option<Vec<[f64; 2]>>,
    /// Spring, damper and motor.
    pub drive: Option<DriveFile>,
    /// Latch.
    pub latch: Option<LatchFile>,
}

/// What a joint allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum JointType {
    /// Nothing.
    Clamped,
    /// Rotation about one axis.
    Revolute,
}

/// How a fold angle moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum MotionType {
    /// By its torques.
    Free,
    /// Not at all: held at the start angle.
    Locked,
    /// By `polynomial_deg` or `table_s_deg`.
    Prescribed,
}

/// Drive: the torque on the outer body about the hinge is `−(k (θ − θ_cmd) + c θ̇ + T)`, limited.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DriveFile {
    /// Spring stiffness `k`.
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
    /// Largest magnitude of the drive torque, default unlimited.
    #[serde(rename = "torque_limit_N_m")]
    #[schemars(range(min = 0.0))]
    pub torque_limit_n_m: Option<f64>,
    /// Largest slew of the commanded angle, default unlimited.
    #[schemars(range(min = 0.0))]
    pub rate_limit_deg_s: Option<f64>,
    /// Start value of the commanded (neutral) angle `θ_cmd`.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub command_deg: f64,
}

/// Latch: closes when the angle reaches `angle_deg` from the folded side.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LatchFile {
    /// Angle at which it closes.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub angle_deg: f64,
    /// Stiffness of the closed joint over the drive's `k`: the latch adds `(ratio − 1) k`.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub stiffness_ratio: Option<f64>,
    /// Stiffness that the latch adds; instead of `stiffness_ratio`.
    #[serde(rename = "stiffness_N_m_rad")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m_rad: Option<f64>,
    /// Half-width of the window in which enabling closes it at once.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 360.0))]
    pub capture_deg: f64,
    /// Closed at the start.
    #[serde(default)]
    pub initially_closed: bool,
    /// Start value of the enable input.
    #[serde(default = "yes")]
    pub enable: bool,
}

fn yes() -> bool {
    true
}

/// A point mass or rigid body fixed to a section.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MassFile {
    /// Body that carries it.
    pub body: String,
    /// Distance from the body's inner end.
    #[schemars(range(min = 0.0))]
    pub position_m: f64,
    /// Mass.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg: f64,
    /// Centre of gravity from the axis, section frame.
    #[serde(default)]
    pub offset_m: [f64; 3],
    /// Inertia tensor about the centre of gravity, section frame: `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]`, where
    /// `Ixy = −∫xy dm`. Default: a point.
    #[serde(default)]
    pub inertia_kg_m2: [f64; 6],
}

/// Force and moment at a load station from the start on; several loads at one station add up.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadFile {
    /// Body that carries it.
    pub body: String,
    /// Number of the load station on that body, from 1 at its inner end.
    #[schemars(range(min = 1, max = 1000))]
    pub station: usize,
    /// Force in the body's `load_frame`.
    #[serde(default, rename = "force_N")]
    pub force_n: [f64; 3],
    /// Moment in the body's `load_frame`.
    #[serde(default, rename = "moment_N_m")]
    pub moment_n_m: [f64; 3],
}

/// A strain gauge: axial strain at a point of a section.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GaugeFile {
    /// Body that carries it.
    pub body: String,
    /// Distance from the body's inner end.
    #[schemars(range(min = 0.0))]
    pub position_m: f64,
    /// Chordwise coordinate.
    #[serde(default)]
    pub y_m: f64,
    /// Thickness coordinate, default the upper face `+h/2`.
    pub z_m: Option<f64>,
}
