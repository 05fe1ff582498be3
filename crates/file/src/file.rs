//! Structure of the model file. The doc comments become the descriptions in the JSON schema and in `docs/MODEL_FILE.md`.
//!
//! Ranges of individual keys are defined here as JSON schema keywords (`minimum`, `exclusiveMinimum`, …), from which they are enforced;
//! `x-allowed` overrides the text of error messages for other conditions.

use crate::air_file::{AirFile, ControlSurfaceFile, GustFile, SurfaceFile};
use crate::body_file::{BodyFile, RigidBodyFile};
use crate::failure_file::FailureFile;
use crate::joint_file::JointFile;
use crate::modal_body::ModalBodyFile;
use crate::no_slip_file::{SkateFile, WheelFile};
use crate::rotor_file::{PolarFile, TowerFile, WindFile};
use crate::run::{SimulationFile, SolverFile};
use crate::section_files::FileUnits;
use crate::shape_file::{
    AngleSection, ChannelSection, FrameSection, LaminateSection, MaterialFile, ProfileSection, TubeSection,
};
use crate::stations::SectionsAlong;
use foldwing_engine::math::strain::{SHEARED, STRAINS};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A Foldwing model: a wing of flexible bodies and fold joints. SI units; angles in degrees if the key ends in `_deg`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(
    title = "Foldwing model file",
    extend("anyOf" = [{ "required": ["section", "body"] }, { "required": ["rigid_body"] }, { "required": ["modal_body"] }])
)]
pub(super) struct ModelFile {
    /// Model name; names the FMU.
    #[schemars(extend("pattern" = "^[A-Za-z_][A-Za-z0-9_]*$"))]
    pub name: String,
    /// One-line description.
    #[serde(default)]
    pub description: String,
    /// Acceleration of gravity, root frame.
    #[serde(default)]
    pub gravity_m_s2: [f64; 3],
    /// Materials of sections by shape, by name.
    #[serde(default)]
    pub material: IndexMap<String, MaterialFile>,
    /// Cross-sections by name.
    #[serde(default)]
    #[schemars(extend("minProperties" = 1, "x-allowed" = "at least one table [section.<name>]"))]
    pub section: IndexMap<String, SectionFile>,
    /// Bodies by name: beams, each held by exactly one joint at its inner end.
    #[serde(default)]
    #[schemars(extend("minProperties" = 1, "x-allowed" = "at least one table [body.<name>]"))]
    pub body: IndexMap<String, BodyFile>,
    /// Rigid bodies by name: frames with mass, each held by exactly one joint. A model of rigid bodies only needs
    /// neither sections nor beams.
    #[serde(default)]
    pub rigid_body: IndexMap<String, RigidBodyFile>,
    /// Modal bodies (deflection by given mode shapes) by name, each held by exactly one joint at its inner end.
    #[serde(default)]
    pub modal_body: IndexMap<String, ModalBodyFile>,
    /// Joints by name; the joint's name prefixes its FMU variables.
    #[schemars(extend("minProperties" = 1, "x-allowed" = "at least one table [joint.<name>]"))]
    pub joint: IndexMap<String, JointFile>,
    /// Ball joints that close kinematic loops, by name; FMU outputs: `loop.<name>.gap` and `loop.<name>.force`.
    #[serde(default, rename = "loop")]
    pub closures: IndexMap<String, LoopFile>,
    /// Skates by name; FMU outputs: `skate.<name>.side_force` and others.
    #[serde(default)]
    pub skate: IndexMap<String, SkateFile>,
    /// Wheels by name; FMU outputs: `wheel.<name>.side_force` and others.
    #[serde(default)]
    pub wheel: IndexMap<String, WheelFile>,
    /// Point masses and rigid bodies by name.
    #[serde(default)]
    pub mass: IndexMap<String, MassFile>,
    /// Loads at stations by name: start values of the inputs `load.<body>[station]`, constant unless these inputs are
    /// set.
    #[serde(default)]
    pub load: IndexMap<String, LoadFile>,
    /// Strain gauges by name; FMU output: `gauge.<name>.strain`.
    #[serde(default)]
    pub gauge: IndexMap<String, GaugeFile>,
    /// Outputs of internal loads by name: `internal_load.<name>.force` and `internal_load.<name>.moment`.
    #[serde(default)]
    pub internal_load: IndexMap<String, InternalLoadFile>,
    /// Failures by name; FMU input: `failure.<name>.trigger`, outputs: `failure.<name>.failed` and
    /// `failure.<name>.time`.
    #[serde(default)]
    pub failure: IndexMap<String, FailureFile>,
    /// Aerodynamics.
    pub aerodynamics: Option<AirFile>,
    /// Lifting surfaces by name, at most one per body.
    #[serde(default)]
    pub surface: IndexMap<String, SurfaceFile>,
    /// Control surfaces by name: flaps, ailerons and elevators of lifting surfaces.
    #[serde(default)]
    pub control_surface: IndexMap<String, ControlSurfaceFile>,
    /// Gusts by name.
    #[serde(default)]
    pub gust: IndexMap<String, GustFile>,
    /// Aerofoil polars of rotor blades by name.
    #[serde(default)]
    pub polar: IndexMap<String, PolarFile>,
    /// Wind field, for a rotor.
    pub wind: Option<WindFile>,
    /// Tower that disturbs the wind, for a rotor.
    pub tower: Option<TowerFile>,
    /// Time integration.
    #[serde(default)]
    pub solver: SolverFile,
    /// Default simulation: times and initial state.
    #[serde(default)]
    pub simulation: SimulationFile,
}

/// Cross-section. `y` is chordwise, `z` through the thickness.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum SectionFile {
    /// Solid rectangle of one material.
    Rectangle(SolidSection),
    /// Solid ellipse of one material.
    Ellipse(SolidSection),
    /// Round tube.
    Tube(TubeSection),
    /// Rectangular box of thin walls.
    Box(FrameSection),
    /// I-beam with equal flanges along `y` and a web along `z`.
    #[serde(rename = "I")]
    I(FrameSection),
    /// Channel with a web along `z` and equal flanges along `y`. The beam axis is its shear centre, outside the channel behind the web.
    #[serde(rename = "C")]
    C(ChannelSection),
    /// Angle of two legs of one thickness, sharp-edged. The beam axis is its shear centre, where the middles of the legs meet.
    Angle(AngleSection),
    /// Thin-walled profile: the skin of an aerofoil with spars, of any number of cells. The beam axis is its shear centre.
    Profile(Box<ProfileSection>),
    /// Flat strip of plies, by classical lamination theory. The beam axis is its middle.
    Laminate(Box<LaminateSection>),
    /// Any section, by stiffness and inertia: either the four stiffnesses with optional couplings, or `stiffness_SI`.
    Explicit(Box<ExplicitSection>),
    /// Stiffness and inertia at stations along a body, with linear interpolation. Needs `along` or `file`.
    Table(Box<TableSection>),
}

/// Solid section of one material.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SolidSection {
    /// Full width along `y`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub width_m: f64,
    /// Full height along `z`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height_m: f64,
    /// Name of the material, of a table `[material.<name>]` or of the library; instead of density and moduli.
    pub material: Option<String>,
    /// Density. Required without `material`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_kg_m3: Option<f64>,
    /// Young's modulus. Required without `material`.
    #[serde(rename = "youngs_modulus_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub youngs_modulus_pa: Option<f64>,
    /// Shear modulus; instead of `poisson_ratio`. Not needed if `torsional_rigidity_N_m2` is given.
    #[serde(rename = "shear_modulus_Pa")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub shear_modulus_pa: Option<f64>,
    /// Poisson's ratio; instead of `shear_modulus_Pa`. Not needed if `torsional_rigidity_N_m2` is given.
    #[schemars(extend("exclusiveMinimum" = -1, "maximum" = 0.5))]
    pub poisson_ratio: Option<f64>,
    /// Torsional rigidity `GJ`, instead of Saint-Venant's value for the outline.
    #[serde(rename = "torsional_rigidity_N_m2")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub torsional_rigidity_n_m2: Option<f64>,
}

/// Section by stiffness and inertia, about the beam axis.
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
    /// Flapwise bending stiffness `EI_y`, about `y`.
    #[serde(rename = "flap_stiffness_N_m2")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub flap_stiffness_n_m2: Option<f64>,
    /// Edgewise bending stiffness `EI_z`, about `z`.
    #[serde(rename = "edge_stiffness_N_m2")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub edge_stiffness_n_m2: Option<f64>,
    /// Coupling of stretch and twist, default 0.
    #[serde(rename = "coupling_axial_twist_N_m")]
    pub coupling_axial_twist_n_m: Option<f64>,
    /// Coupling of stretch and curvature about `y`, default 0.
    #[serde(rename = "coupling_axial_flap_N_m")]
    pub coupling_axial_flap_n_m: Option<f64>,
    /// Coupling of stretch and curvature about `z`, default 0.
    #[serde(rename = "coupling_axial_edge_N_m")]
    pub coupling_axial_edge_n_m: Option<f64>,
    /// Coupling of twist and curvature about `y` (bend–twist), default 0.
    #[serde(rename = "coupling_twist_flap_N_m2")]
    pub coupling_twist_flap_n_m2: Option<f64>,
    /// Coupling of twist and curvature about `z`, default 0.
    #[serde(rename = "coupling_twist_edge_N_m2")]
    pub coupling_twist_edge_n_m2: Option<f64>,
    /// Coupling of the two curvatures, default 0.
    #[serde(rename = "coupling_flap_edge_N_m2")]
    pub coupling_flap_edge_n_m2: Option<f64>,
    /// Full stiffness matrix for the strains `(εx, κx, κy, κz)` in N, N·m and N·m², symmetric and positive definite;
    /// instead of the four stiffnesses and the couplings.
    #[serde(rename = "stiffness_SI")]
    #[schemars(extend("x-allowed" = "a 4 x 4 matrix of finite numbers in N, N·m and N·m²"))]
    pub stiffness_si: Option<[[f64; STRAINS]; STRAINS]>,
    /// Full stiffness matrix with shear, for `(εx, γy, γz, κx, κy, κz)` in N, N·m and N·m², symmetric and positive definite; instead of all
    /// other stiffnesses. Bodies without `shear = true` take its condensation, the stiffness without shear forces.
    #[serde(rename = "stiffness_with_shear_SI")]
    #[schemars(extend("x-allowed" = "a 6 x 6 matrix of finite numbers in N, N·m and N·m²"))]
    pub stiffness_with_shear_si: Option<[[f64; SHEARED]; SHEARED]>,
    /// Shear stiffness `[GAy, GAz]` along `y` and `z`, uncoupled; for bodies with `shear = true`.
    #[serde(rename = "shear_stiffness_N")]
    #[schemars(extend("x-allowed" = "an array of 2 stiffnesses > 0 N"))]
    pub shear_stiffness_n: Option<[f64; 2]>,
    /// Mass per length.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg_m: f64,
    /// Centre of mass `[y, z]` from the beam axis.
    #[serde(default)]
    pub centre_of_mass_m: [f64; 2],
    /// Second moments of mass per length about the centre of mass: `[∫ρy² dA, ∫ρyz dA, ∫ρz² dA]`.
    pub second_moments_kg_m: [f64; 3],
    /// Largest `|y|` of the outline; required by strain gauges.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_width_m: Option<f64>,
    /// Largest `|z|` of the outline; required by strain gauges.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_height_m: Option<f64>,
}

/// Sections along a body.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TableSection {
    /// File with these properties, relative to the model file: CSV whose columns are named like the keys of `along`; a file of BeamDyn,
    /// VABS, BECAS, ANBA4, PreComp or windIO (SONATA, WISDEM); or CSV with columns `eta` or `s_m` and `section_file`, names of such files of
    /// one section each. Its contents replace this key when the model file is read, so an FMU needs no other file.
    pub file: Option<String>,
    /// Units of the 6×6 matrices in `file`, which most programs do not write: `m_N_kg` (default), `mm_N_t` or `inch_lbf` (mass in
    /// lbf·s²/inch).
    pub file_units: Option<FileUnits>,
    /// Properties at the stations.
    pub along: Option<SectionsAlong>,
}

/// Loop closure: connects two points, of two bodies or of a body and the root, by the penalty force `m g̈ + c ġ + k g` on the gap `g` between them,
/// as a ball joint; with `rigid = true` by constraint forces, without a gap. Two loop closures on one axis form a hinge. A stiffer spring gives a smaller gap.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LoopFile {
    /// The two bodies; `"root"` in place of one is a point fixed in the root frame, which moves with the root.
    #[schemars(extend("x-allowed" = "an array of 2 names of bodies, or of a body and \"root\""))]
    pub bodies: [String; 2],
    /// Distances of the sections from the inner ends of the bodies, 0 for the root; default: the outer ends.
    #[schemars(inner(range(min = 0.0)))]
    pub positions_m: Option<[f64; 2]>,
    /// Offsets of the points from the beam axes, section frames; for the root its position in the root frame. The points coincide at the
    /// start.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "an array of 2 arrays of 3 finite lengths in m"))]
    pub offsets_m: [[f64; 3]; 2],
    /// Whether the points coincide to round-off, by constraint forces in place of the penalty. There is no Model Exchange and no gradient
    /// with such a loop; linear models are about states of rest.
    #[serde(default)]
    pub rigid: bool,
    /// Penalty stiffness `k`: the gap is the force divided by `k`. Required, except with `rigid = true`.
    #[serde(default, rename = "stiffness_N_m")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness_n_m: Option<f64>,
    /// Penalty damping `c`.
    #[serde(default, rename = "damping_N_s_m")]
    #[schemars(range(min = 0.0))]
    pub damping_n_s_m: f64,
    /// Penalty inertia `m`: acts on the gap only and adds no mass to the model.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub inertia_kg: f64,
}

/// A point mass or rigid body fixed to a section.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MassFile {
    /// Body that carries the mass.
    pub body: String,
    /// Distance from the body's inner end.
    #[schemars(range(min = 0.0))]
    pub position_m: f64,
    /// Mass.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_kg: f64,
    /// Centre of gravity relative to the axis, section frame.
    #[serde(default)]
    pub offset_m: [f64; 3],
    /// Inertia tensor about the centre of gravity, section frame: `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]`, where
    /// `Ixy = −∫xy dm`. Default: a point mass.
    #[serde(default)]
    pub inertia_kg_m2: [f64; 6],
}

/// Force and moment at a load station, applied from the start; several loads at one station add up.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadFile {
    /// Body on which the load acts.
    pub body: String,
    /// Number of the load station on that body, counted from 1 at its inner end.
    #[schemars(range(min = 1, max = 1000))]
    pub station: usize,
    /// Force in the body's `load_frame`.
    #[serde(default, rename = "force_N")]
    pub force_n: [f64; 3],
    /// Moment in the body's `load_frame`.
    #[serde(default, rename = "moment_N_m")]
    pub moment_n_m: [f64; 3],
}

/// A strain gauge: fibre strain at a point of a section, zero when the body is unstrained.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GaugeFile {
    /// Body that carries the gauge.
    pub body: String,
    /// Distance from the body's inner end.
    #[schemars(range(min = 0.0))]
    pub position_m: f64,
    /// Chordwise coordinate.
    #[serde(default)]
    pub y_m: f64,
    /// Thickness coordinate; default: the upper face, `+h/2`.
    pub z_m: Option<f64>,
    /// Direction of the fibre in the section frame, of any length except zero; default: along the axis. Other
    /// directions need a rectangle or an ellipse with known Poisson's ratio.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub direction: Option<[f64; 3]>,
}

/// Output of the internal loads of a beam at a section: force and moment exerted by the outboard part on the inboard
/// part, in the section's frame (x along the axis: tension is positive).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct InternalLoadFile {
    /// Beam in which the loads are evaluated.
    pub body: String,
    /// Distance from the body's inner end.
    #[schemars(range(min = 0.0))]
    pub position_m: f64,
    /// Side of the cut, relevant if something is attached at this position (the load of a station, a mass, a joint, a
    /// loop): `inboard` cuts inboard of it, so that the output includes its load; `outboard` cuts outboard of it.
    #[serde(default)]
    pub side: SectionSideFile,
}

/// Side of a cut.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum SectionSideFile {
    /// Towards the inner end.
    #[default]
    Inboard,
    /// Towards the outer end.
    Outboard,
}
