//! Bodies of the model file: structure and descriptions of beams and rigid bodies, as in [`crate::file`].

use crate::function::FunctionFile;
use crate::stations::AxisAlong;
use foldwing_engine::load::LoadFrame;
use foldwing_engine::machine::ElementKind;
use foldwing_engine::math::strain::STRAINS;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A beam.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyFile {
    /// Number of copies, each with its joint and everything attached to it, spaced evenly about the parent's `x` axis:
    /// names of the copies end in 1, 2, …, as do the names of joints, masses and loads on them. Default: one body, name
    /// unchanged.
    #[schemars(range(min = 1, max = 12))]
    pub count: Option<usize>,
    /// Arc length of the undeformed axis.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: f64,
    /// Name of the cross-section; if the section varies, of the one at the inner end.
    pub section: String,
    /// Name of the cross-section at the outer end: stiffness, inertia and outline are linear between the two.
    pub outer_section: Option<String>,
    /// Factor `λ₂` on the section's width along the body; a number is the factor at the outer end, linear from 1.
    pub width_taper: Option<FunctionFile>,
    /// Factor `λ₃` on the section's height along the body; a number is the factor at the outer end, linear from 1.
    pub height_taper: Option<FunctionFile>,
    /// The sections deform in shear: six strains instead of four. Default false.
    #[serde(default)]
    pub shear: bool,
    /// Kind of strain element.
    #[serde(default)]
    pub element: ElementFile,
    /// Number of elements along the body; a linear element consists of two halves.
    #[schemars(range(min = 1, max = 1000))]
    pub elements: usize,
    /// Natural twist and curvatures `[κx, κy, κz]`, constant along the body: the unloaded shape.
    #[serde(default)]
    pub natural_curvature_1_m: [f64; 3],
    /// Natural twist `κx` along the body; instead of `natural_curvature_1_m`.
    pub twist_1_m: Option<FunctionFile>,
    /// Natural curvature `κy` along the body; positive bends the axis towards `−z`.
    pub curvature_y_1_m: Option<FunctionFile>,
    /// Natural curvature `κz` along the body; positive bends the axis towards `+y`.
    pub curvature_z_1_m: Option<FunctionFile>,
    /// Unloaded axis by points, with the twist of the sections along it; instead of the curvatures above.
    pub axis: Option<AxisAlong>,
    /// File with the axis, relative to the model file: CSV whose columns are named like the keys of `axis`, or a
    /// BeamDyn primary file. Its contents replace this key when the model file is read.
    pub axis_file: Option<String>,
    /// Mass-proportional damping `α`, on motion relative to the root or, outboard of a free joint, to the first frame
    /// of the flying body. Acts on the beam only, unless `damp_attached_masses` is set.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub mass_damping_1_s: f64,
    /// Apply `mass_damping_1_s` also to the masses attached to this body. Default false.
    #[serde(default)]
    pub damp_attached_masses: bool,
    /// Stiffness-proportional damping `β`.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub stiffness_damping_s: f64,
    /// Factors on `stiffness_damping_s` for stretch, twist, curvature about `y` (flapwise) and about `z` (edgewise),
    /// default 1 each.
    #[schemars(inner(range(min = 0.0)))]
    pub stiffness_damping_factors: Option<[f64; STRAINS]>,
    /// Factors on `stiffness_damping_s` for shear along `y` and `z`, for a body with `shear = true`; default 1 each.
    #[schemars(inner(range(min = 0.0)))]
    pub shear_damping_factors: Option<[f64; 2]>,
    /// Damping ratios of the lowest modes of this body, in ascending frequency: clamped at its inner end, with its attached masses, unloaded and
    /// in its natural shape. Modes beyond the list are not damped by them. Up to 12. The forces act on the rates of this body's strains.
    #[serde(default)]
    #[schemars(length(max = 12), inner(range(min = 0.0)))]
    pub modal_damping_ratios: Vec<f64>,
    /// Number of load stations, at the centres of equal segments, default 4.
    #[schemars(range(min = 0, max = 1000))]
    pub load_stations: Option<usize>,
    /// Distances of the load stations from the inner end, ascending; instead of `load_stations`.
    #[schemars(length(max = 1000))]
    pub load_station_positions_m: Option<Vec<f64>>,
    /// Frame of the forces and moments at the stations: `root` (dead loads) or `section` (follower loads).
    #[serde(default)]
    pub load_frame: LoadFrameFile,
}

/// A rigid body: a frame that carries mass, loads and other bodies. Its joint holds it at its frame.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RigidBodyFile {
    /// Mass, default 0: a massless frame, or a body whose masses are tables `[mass.<name>]`.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub mass_kg: f64,
    /// Centre of mass in the body's frame, default: its origin.
    #[serde(default)]
    pub centre_of_mass_m: [f64; 3],
    /// Inertia tensor about the centre of mass, body frame: `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]`, where `Ixy = −∫xy dm`.
    /// Default: a point mass.
    #[serde(default)]
    pub inertia_kg_m2: [f64; 6],
    /// Require only positive principal moments of `inertia_kg_m2`, without the triangle inequality: for inertia about
    /// some axes only, such as a generator rotor about its shaft. Default false.
    #[serde(default)]
    pub allow_nonphysical_inertia: bool,
    /// Attachment frames on the body by name; joints refer to them by `parent_frame`.
    #[serde(default)]
    pub frame: IndexMap<String, FrameFile>,
    /// Frame of the force and moment at the body's only load station, its origin: `root`, or `section` (the body
    /// frame).
    #[serde(default)]
    pub load_frame: LoadFrameFile,
}

/// An attachment frame on a rigid body.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameFile {
    /// Origin in the body's frame.
    pub position_m: [f64; 3],
    /// Rotation vector in the body's frame, default: none.
    #[serde(default)]
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub rotation_deg: [f64; 3],
}

/// Kind of strain element.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum ElementFile {
    /// Linear strain, fourth-order convergence.
    #[default]
    Linear,
    /// Constant strain, second-order convergence.
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
