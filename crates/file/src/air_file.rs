//! Aerodynamics of the machine: the tables `[aerodynamics]`, `[surface.<name>]`, `[control_surface.<name>]` and `[gust.<name>]` of the
//! model file.

use crate::air_part_file::{AirPartFile, IndicialFile, TipLossFile};
use crate::function::FunctionFile;
use crate::rotor_file::{EndRuleFile, PitchRateFile, SpreadFile, TurnsFile};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Aerodynamics. Aerodynamic loads act on lifting surfaces and slender bodies. One model has its keys in this table; several models in one flow have
/// tables `[aerodynamics.<name>]`, and this table has density, wind, step, coupling and initial flow, which are common to all.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub(super) struct AirFile {
    /// Aerodynamic model; `none`: no aerodynamic loads except external ones, applied as inputs.
    pub model: AirModelFile,
    /// Air density.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_kg_m3: f64,
    /// Wind velocity relative to the root, root frame: start value of the input `wind.velocity`.
    pub wind_m_s: [f64; 3],
    /// Aerodynamic step; default: the time in which the fastest point of the trailing edge travels one panel length at
    /// the start, due to wind, flight and joint rates together; with strip theory, a quarter of the chord.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step_s: Option<f64>,
    /// Start from steady flow, with a straight wake along the relative flow at the trailing edge; otherwise
    /// the flow starts impulsively. Without relative motion of wing and air there is no initial wake.
    pub steady_initial_flow: bool,
    /// Fluid–structure coupling: `staggered` corrects the loads once per aerodynamic step, for wings much heavier than
    /// the air that they displace; the run stops if it diverges.
    pub coupling: CouplingFile,
    /// Convergence tolerance of the coupling: change of the loads relative to the largest so far. For values from 1e-5
    /// on the iteration also ends if the predicted next change is below a fifth of it. Not with `staggered`.
    #[schemars(range(min = 1e-12, max = 1e-1))]
    pub coupling_tolerance: f64,
    /// Maximum number of coupling iterations per aerodynamic step; the run stops with an error if it is exceeded. Not
    /// with `staggered`.
    #[schemars(range(min = 1, max = 1000))]
    pub coupling_iterations: usize,
    /// Quasi-steady strip theory, without Wagner's and Küssner's functions.
    pub quasi_steady: bool,
    /// Include the apparent (added) mass of the air; strip theory only.
    pub apparent_mass: bool,
    /// Approximation of Wagner's and Küssner's functions; strip theory only.
    pub indicial: IndicialFile,
    /// Loss of lift towards the wing tips, with induced drag: `lifting_line` uses one lifting line through all strips.
    /// Strip theory only, without polars.
    pub tip_loss: TipLossFile,
    /// Normal of a mirror plane through the origin (a tunnel wall, or the symmetry plane of an aircraft); vortex
    /// lattice, or strip theory with tip loss.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub mirror_normal: Option<[f64; 3]>,
    /// Normal of the ground, pointing to the wing: a second mirror plane, perpendicular to the first if `mirror_normal`
    /// is given. Vortex lattice only, with `ground_distance_m`.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub ground_normal: Option<[f64; 3]>,
    /// Height of the root's origin above the ground. Vortex lattice only, required with `ground_normal`.
    pub ground_distance_m: Option<f64>,
    /// Speed of sound for the Prandtl–Glauert correction of lift and moments; default: incompressible flow. Strip
    /// theory without polars, and vortex lattice.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed_of_sound_m_s: Option<f64>,
    /// Convect the wake with its own induced velocity too (free wake); otherwise with the wind only. Vortex lattice
    /// only.
    pub free_wake: bool,
    /// Maximum number of wake rows, in addition to the wake of the initial established flow; older rows are dropped.
    /// Vortex lattice only.
    #[schemars(range(min = 1, max = 10000))]
    pub wake_rows: usize,
    /// Vortex core radius; default: a hundredth of the chord of the shortest panel, with a lifting line of the shortest
    /// chord. A free wake is convected with cores as wide as the spacing of its lines, where that is larger. Vortex
    /// lattice, or strip theory with tip loss.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub core_radius_m: Option<f64>,
    /// Leading-edge suction. Default: included in strip theory, not in the vortex lattice. The lattice with suction
    /// computes loads by the Kutta–Joukowski theorem on every bound vortex instead of pressures by Bernoulli's
    /// equation.
    pub leading_edge_suction: Option<bool>,
    /// Threads for the induced velocities of the wake; the result does not depend on their number. Vortex lattice only.
    #[schemars(range(min = 1, max = 256))]
    pub threads: usize,
    /// Add an output `aero.circulation.<body>[strip]` for each strip.
    pub report_circulation: bool,
    /// Body that rotates with the blades; its inner end is the apex, where the blade axes meet the shaft. `bem` only,
    /// required there.
    pub hub: Option<String>,
    /// Distance from the apex to the inner ends of the blades. `bem` only, required there.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub hub_radius_m: Option<f64>,
    /// Direction of the shaft in the hub's frame, downwind, of any length except zero. `bem` only.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub shaft_axis: [f64; 3],
    /// Direction of rotation, looking downwind. `bem` only.
    pub rotation_direction: TurnsFile,
    /// Load at the very tip and hub of the blades, where Prandtl's loss is complete. `bem` only.
    pub end_loads: EndRuleFile,
    /// Skewed-wake correction: induction varies over the disc in oblique inflow (Pitt and Peters). `bem` only.
    pub skewed_wake: bool,
    /// Dynamic inflow: the induced velocity lags with the time constants of the wake (Øye). `bem` only.
    pub dynamic_inflow: bool,
    /// Time constant of the first-order lag between the induced velocity of each annulus and the momentum-theory value
    /// for the current load, without losses and swirl; instead of the momentum balance. At least the aerodynamic step.
    /// `bem` only.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inflow_lag_s: Option<f64>,
    /// Number of blades of the rotor: a multiple of the number of surfaces, where each surface then represents several
    /// blades with the same motion; default: the number of surfaces. `bem` only.
    #[schemars(range(min = 1, max = 100))]
    pub blades: Option<usize>,
    /// Effect of the pitch rate of sections about the span, as for thin aerofoils in quasi-steady flow: angle of attack
    /// at three quarters of the chord, and a pitch-damping moment. `dynamic_stall` includes its own. `bem` only.
    pub pitch_rate: PitchRateFile,
    /// Interpolation of the loads between stations. `bem` only.
    pub load_interpolation: SpreadFile,
    /// Dynamic stall (Beddoes and Leishman, four states). `bem` only.
    pub dynamic_stall: bool,
    /// Use AeroDyn's angle of attack for blades that bend in and out of plane, and its state of heavily loaded annuli;
    /// for comparison. `bem` only.
    pub aerodyn_compatible: bool,
    /// Several aerodynamic models in one flow, by name, in place of `model`.
    #[serde(flatten)]
    pub parts: IndexMap<String, AirPartFile>,
}

impl Default for AirFile {
    fn default() -> Self {
        Self {
            model: AirModelFile::None,
            density_kg_m3: 1.225,
            wind_m_s: [0.0; 3],
            step_s: None,
            steady_initial_flow: true,
            coupling: CouplingFile::Iterated,
            coupling_tolerance: 1e-4,
            coupling_iterations: 50,
            quasi_steady: false,
            apparent_mass: true,
            indicial: IndicialFile::Jones,
            tip_loss: TipLossFile::None,
            mirror_normal: None,
            ground_normal: None,
            ground_distance_m: None,
            speed_of_sound_m_s: None,
            free_wake: false,
            wake_rows: 100,
            core_radius_m: None,
            leading_edge_suction: None,
            threads: 1,
            report_circulation: false,
            hub: None,
            hub_radius_m: None,
            shaft_axis: [1.0, 0.0, 0.0],
            rotation_direction: TurnsFile::Clockwise,
            end_loads: EndRuleFile::Zero,
            skewed_wake: false,
            dynamic_inflow: false,
            inflow_lag_s: None,
            blades: None,
            pitch_rate: PitchRateFile::None,
            load_interpolation: SpreadFile::Linear,
            dynamic_stall: false,
            aerodyn_compatible: false,
            parts: IndexMap::new(),
        }
    }
}

/// Aerodynamic model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum AirModelFile {
    /// Unsteady vortex lattice.
    Uvlm,
    /// Strip theory.
    Strip,
    /// Blade-element momentum theory: every surface is a blade of one rotor.
    Bem,
    /// None: air loads are applied from outside.
    None,
}

/// Coupling of air loads and structure at the end of an aerodynamic step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum CouplingFile {
    /// Iteration to convergence.
    Iterated,
    /// Prediction and one correction.
    Staggered,
}

/// Lifting surface of a body.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceFile {
    /// Body that carries the surface.
    pub body: String,
    /// Chord along the body; default: the width of its section.
    pub chord_m: Option<FunctionFile>,
    /// Position of the beam axis on the chord, from the leading edge, as a fraction of the chord from -10 to 10, along
    /// the body.
    #[serde(default = "middle")]
    pub elastic_axis_fraction: FunctionFile,
    /// Side of the section on which the leading edge lies.
    #[serde(default)]
    pub leading_edge: LeadingEdgeFile,
    /// Incidence of the chord relative to the section along the body; positive raises the leading edge towards `+z`.
    pub incidence_deg: Option<FunctionFile>,
    /// Flare: angle from -75 to 75 deg between the chordwise lines of the lattice and the chord, along the body;
    /// positive moves the leading edge outboard along the body. At a flared hinge use the flare angle of the hinge, so
    /// that both panel edges lie on the hinge. Vortex lattice only.
    pub flare_deg: Option<FunctionFile>,
    /// Number of strips, or of lattice panels, along the span. Required except for a blade, which has `stations_m`.
    #[schemars(range(min = 1, max = 1000))]
    pub strips: Option<usize>,
    /// Length of a blade on a rigid body, along the body's x axis from its origin. `bem` only, required there on rigid
    /// bodies.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: Option<f64>,
    /// Aerodynamic nodes along a blade, from the body's inner end; loads are interpolated between them. `bem` only,
    /// required there.
    #[schemars(length(min = 2, max = 1000))]
    pub stations_m: Option<Vec<f64>>,
    /// Names of the polars at the stations, one each. `bem` only, required there.
    #[schemars(length(min = 2, max = 1000))]
    pub polars: Option<Vec<String>>,
    /// Number of lattice panels along the chord. Vortex lattice only.
    #[serde(default = "four")]
    #[schemars(range(min = 1, max = 1000))]
    pub chord_panels: usize,
    /// Lift-curve slope of the aerofoil along the body, 0 or more; evaluated at the middle of each strip.
    #[serde(default = "thin")]
    pub lift_slope_1_rad: FunctionFile,
    /// Zero-lift angle of attack, from the chord line; negative where the aerofoil is cambered towards the section's
    /// `+z`.
    #[serde(default)]
    pub zero_lift_angle_deg: f64,
    /// Moment coefficient about the quarter chord, nose up: towards the section's `+z`.
    #[serde(default)]
    pub moment_coefficient: f64,
    /// Drag coefficient of the aerofoil.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub drag_coefficient: f64,
    /// Polar of the aerofoil, instead of the coefficients above: rows of angle of attack in degrees, lift, drag and
    /// moment coefficient about the quarter chord, linear between rows; positive towards the section's `+z`. The vortex
    /// lattice uses the effective angle of attack, including the velocity it induces, and requires
    /// `leading_edge_suction`.
    #[schemars(
        length(min = 1, max = 1000),
        extend("x-allowed" = "at least 1 row [angle of attack in deg, lift, drag, moment coefficient]")
    )]
    pub polar: Option<Vec<[f64; 4]>>,
}

fn middle() -> FunctionFile {
    FunctionFile::Number(0.5)
}

fn four() -> usize {
    4
}

fn thin() -> FunctionFile {
    FunctionFile::Number(TAU)
}

/// Side of the section on which the leading edge lies.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
pub(super) enum LeadingEdgeFile {
    /// Towards the section's `+y`.
    #[default]
    #[serde(rename = "+y")]
    Plus,
    /// Towards the section's `−y`.
    #[serde(rename = "-y")]
    Minus,
}

/// Control surface: the rear part of a lifting surface between two spanwise positions, which rotates about a hinge. FMU
/// inputs: `aero.control_surface.<name>.angle_command` and `aero.control_surface.<name>.angle_command_rate`; outputs:
/// `aero.control_surface.<name>.angle`, `aero.control_surface.<name>.rate` and
/// `aero.control_surface.<name>.hinge_moment`. Strip theory and vortex lattice only.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ControlSurfaceFile {
    /// Body whose lifting surface carries it.
    pub body: String,
    /// Distance of its inboard end from the body's inner end. Strips end where control surfaces end.
    pub from_m: f64,
    /// Distance of its outboard end from the body's inner end.
    pub to_m: f64,
    /// Position of the hinge on the chord, from the leading edge, as a fraction of the chord between 0 and 1. In the
    /// vortex lattice it lies on a line between panels: the fraction times `chord_panels` is a whole number.
    pub hinge_fraction: f64,
    /// Angle at the start, and start value of the input; positive angles move the trailing edge towards the section's
    /// `−z`.
    #[serde(default)]
    pub command_deg: f64,
    /// Smallest angle. Commands below it are rejected.
    #[serde(default = "minus_thirty")]
    #[schemars(range(min = -60.0, max = 60.0))]
    pub lower_deg: f64,
    /// Largest angle. Commands above it are rejected.
    #[serde(default = "thirty")]
    #[schemars(range(min = -60.0, max = 60.0))]
    pub upper_deg: f64,
}

fn minus_thirty() -> f64 {
    -30.0
}

fn thirty() -> f64 {
    30.0
}

/// A frozen gust that travels through the air.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GustFile {
    /// Velocity profile as a function of the distance behind the gust front.
    pub shape: GustShapeFile,
    /// Maximum added velocity, root frame. For turbulence: its standard deviation, parallel or perpendicular to the
    /// gust's direction of travel. For a table: the velocity that a fraction of 1 represents.
    pub velocity_m_s: [f64; 3],
    /// Length of a `one_minus_cosine`; for turbulence, the distance after which it repeats, default: 256 scales.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: Option<f64>,
    /// Rows `[distance behind the front, fraction of velocity_m_s]` with ascending distances, linear between them; zero
    /// before the first row, the last fraction after the last row. `table` only.
    pub table: Option<Vec<[f64; 2]>>,
    /// Length scale of the turbulence. Turbulence only, required there.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale_m: Option<f64>,
    /// Random seed: the same seed gives the same turbulence; default: 0.
    pub seed: Option<u64>,
    /// Spacing of the points at which turbulence is computed; waves shorter than four spacings are omitted. Default: a
    /// 256th of the scale.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub resolution_m: Option<f64>,
    /// Direction of travel, root frame, of any length except zero; default: the direction of `wind_m_s`.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub direction: Option<[f64; 3]>,
    /// Speed of travel; default: the magnitude of `wind_m_s`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed_m_s: Option<f64>,
    /// Position of the front at `start_s`.
    #[serde(default)]
    pub origin_m: [f64; 3],
    /// Time at which the front passes `origin_m`.
    #[serde(default)]
    pub start_s: f64,
}

/// Shape of a gust.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum GustShapeFile {
    /// Full velocity behind the front.
    SharpEdge,
    /// `(1 − cos)/2` over `length_m`.
    OneMinusCosine,
    /// Table over the distance behind the front.
    Table,
    /// Continuous turbulence with the Dryden spectrum.
    Dryden,
    /// Continuous turbulence with the von Kármán spectrum.
    VonKarman,
}
