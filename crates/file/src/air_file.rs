//! Air around the machine: the tables `[aerodynamics]`, `[surface.<name>]`, `[control_surface.<name>]` and `[gust.<name>]` of the model
//! file.

use crate::function::FunctionFile;
use crate::rotor_file::{EndRuleFile, PitchRateFile, SpreadFile, TurnsFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Air around the wing. It acts on the surfaces.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct AirFile {
    /// Model of the air; `none` leaves it to loads from outside.
    pub model: AirModelFile,
    /// Density.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_kg_m3: f64,
    /// Velocity of the air relative to the root, root frame: start value of the input `wind.velocity`.
    pub wind_m_s: [f64; 3],
    /// Aerodynamic step; default: the time in which the fastest point of the trailing edge moves by one panel at the
    /// start, due to wind, flight and joints together; with strips, by a quarter of the chord.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step_s: Option<f64>,
    /// Whether the initial flow is fully established, with a straight wake along the relative flow at the trailing
    /// edge; otherwise it sets in at the start. Where wing and air do not move relative to each other there is no such
    /// wake.
    pub steady_initial_flow: bool,
    /// How air and structure agree: `staggered` corrects the loads once per aerodynamic step, for wings much heavier
    /// than the air that they move; if it diverges, the run stops.
    pub coupling: CouplingFile,
    /// Change of the loads, relative to the largest so far, at which the iteration ends; from 1e-5 on also where the next change is
    /// foreseen to be below a fifth of it. Not with `staggered`.
    #[schemars(range(min = 1e-12, max = 1e-1))]
    pub coupling_tolerance: f64,
    /// Maximum number of iterations per aerodynamic step; beyond it the run stops with an error. Not with `staggered`.
    #[schemars(range(min = 1, max = 1000))]
    pub coupling_iterations: usize,
    /// Strips without memory, instead of Wagner's and Küssner's functions.
    pub quasi_steady: bool,
    /// Whether strips carry the apparent mass of the air.
    pub apparent_mass: bool,
    /// Fit to Wagner's and Küssner's functions; strips only.
    pub indicial: IndicialFile,
    /// Loss of lift towards the ends of a wing, with its induced drag: `lifting_line` lays one through all strips. Strips only,
    /// without polars.
    pub tip_loss: TipLossFile,
    /// Normal of a mirror plane through the origin (a tunnel wall, or the other half of an aircraft); lattice, or strips with
    /// a tip loss.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub mirror_normal: Option<[f64; 3]>,
    /// Normal of the ground, from it towards the wing: a second mirror, across `mirror_normal` where there is one. Lattice only, with
    /// `ground_distance_m`.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub ground_normal: Option<[f64; 3]>,
    /// Distance of the root's origin above the ground. Lattice only, needed with `ground_normal`.
    pub ground_distance_m: Option<f64>,
    /// Speed of sound: lift and moments grow by Prandtl and Glauert's rule; default: incompressible air. Strips without polars, and the
    /// lattice.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed_of_sound_m_s: Option<f64>,
    /// Whether the wake moves with its own flow too; otherwise it moves with the wind only. Lattice only.
    pub free_wake: bool,
    /// Rows of panels that the wake keeps, besides that of an established flow; older ones are dropped. Lattice only.
    #[schemars(range(min = 1, max = 10000))]
    pub wake_rows: usize,
    /// Radius of the vortex cores; default: a hundredth of the shortest panel's chord, with a lifting line of the shortest
    /// chord. A free wake moves with cores as wide as its lines lie apart, where that is more. Lattice, or strips with a tip loss.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub core_radius_m: Option<f64>,
    /// Suction at the leading edge. Strips have it by default; the lattice, whose loads are then those of
    /// Kutta–Joukowski's theorem on every bound vortex instead of pressures by Bernoulli's equation, does not.
    pub leading_edge_suction: Option<bool>,
    /// Threads for the influence of the wake; the result does not depend on it. Lattice only.
    #[schemars(range(min = 1, max = 256))]
    pub threads: usize,
    /// Adds an output `aero.circulation.<body>[strip]` for each strip.
    pub report_circulation: bool,
    /// Body that turns with the blades; its inner end is the apex, where the blades' axes meet the shaft. `bem` only, needed there.
    pub hub: Option<String>,
    /// Distance from the apex to the inner ends of the blades. `bem` only, needed there.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub hub_radius_m: Option<f64>,
    /// Direction of the shaft in the hub's frame, downwind, of any length except zero. `bem` only.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub shaft_axis: [f64; 3],
    /// Sense in which the rotor turns for who looks downwind. `bem` only.
    pub rotation_direction: TurnsFile,
    /// What the blades carry at the very tip and hub, where Prandtl's loss is complete. `bem` only.
    pub end_loads: EndRuleFile,
    /// Whether the induction varies over a disc that the wind meets at an angle (Pitt and Peters). `bem` only.
    pub skewed_wake: bool,
    /// Whether the induced velocity follows with the delay of the wake (Øye). `bem` only.
    pub dynamic_inflow: bool,
    /// Time constant with which the induced velocity of each annulus follows that of momentum theory for the load that acts,
    /// without losses and swirl; instead of the momentum balance. At least the aerodynamic step. `bem` only.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inflow_lag_s: Option<f64>,
    /// Blades of the rotor: a multiple of the surfaces, each of which then stands for others that move like it; default: the
    /// surfaces. `bem` only.
    #[schemars(range(min = 1, max = 100))]
    pub blades: Option<usize>,
    /// What sections feel of their turning about the span, as thin aerofoils in quasi-steady flow: the angle of attack of three
    /// quarters of the chord, and a damping moment. `dynamic_stall` has its own. `bem` only.
    pub pitch_rate: PitchRateFile,
    /// How loads between stations follow from those at the stations. `bem` only.
    pub load_interpolation: SpreadFile,
    /// Whether sections stall with delay (Beddoes and Leishman, four states). `bem` only.
    pub dynamic_stall: bool,
    /// Angle of attack of blades that bend in and out of the plane, and state of heavily loaded annuli, as AeroDyn has them; for
    /// comparison. `bem` only.
    pub aerodyn_compatible: bool,
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
        }
    }
}

/// Model of the air.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum AirModelFile {
    /// Unsteady vortex lattice.
    Uvlm,
    /// Strip theory.
    Strip,
    /// Blade-element momentum theory: every surface is a blade of one rotor.
    Bem,
    /// None: loads come from outside.
    None,
}

/// How air and structure agree on the loads at the end of an aerodynamic step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum CouplingFile {
    /// By iteration, until they change no more.
    Iterated,
    /// By prediction and one correction.
    Staggered,
}

/// Fit to the functions of Wagner and Küssner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum IndicialFile {
    /// R. T. Jones: two and three terms, lift within 1.5 % and 4 % of the exact frequency response.
    Jones,
    /// Five terms each, within 0.06 % and 0.7 %: flutter of slender wings; a little slower.
    Fine,
}

/// Loss of lift towards the ends of a wing of strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum TipLossFile {
    /// None: every strip is one of an endless wing.
    None,
    /// That of a lifting line through all strips as they stand.
    LiftingLine,
}

/// Lifting surface of a body.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceFile {
    /// Body that carries it.
    pub body: String,
    /// Chord along the body; default: the width of its section.
    pub chord_m: Option<FunctionFile>,
    /// Position of the beam's axis on the chord, from the leading edge, as a fraction of the chord from -10 to 10,
    /// along the body.
    #[serde(default = "middle")]
    pub elastic_axis_fraction: FunctionFile,
    /// Side of the section on which the leading edge lies.
    #[serde(default)]
    pub leading_edge: LeadingEdgeFile,
    /// Incidence of the chord relative to the section along the body; positive raises the leading edge towards `+z`.
    pub incidence_deg: Option<FunctionFile>,
    /// Angle from -75 to 75 deg between the lattice's lines along the chord and the chord, along the body; positive puts the leading
    /// edge further along the body. At a flared hinge it is the flare, so that both edges lie on the hinge. Lattice only.
    pub flare_deg: Option<FunctionFile>,
    /// Strips along the span; panels of the lattice along the span. Needed but for a blade, which has `stations_m`.
    #[schemars(range(min = 1, max = 1000))]
    pub strips: Option<usize>,
    /// Length of a blade on a rigid body, along the body's x axis from its origin. `bem` only, needed there on rigid bodies.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: Option<f64>,
    /// Places along a blade, from the body's inner end, where the air is looked at; loads go in straight lines between them.
    /// `bem` only, needed there.
    #[schemars(length(min = 2, max = 1000))]
    pub stations_m: Option<Vec<f64>>,
    /// Names of the polars at the stations, one each. `bem` only, needed there.
    #[schemars(length(min = 2, max = 1000))]
    pub polars: Option<Vec<String>>,
    /// Panels of the lattice along the chord; lattice only.
    #[serde(default = "four")]
    #[schemars(range(min = 1, max = 1000))]
    pub chord_panels: usize,
    /// Lift slope of the profile along the body, 0 or more; each strip takes that of its middle.
    #[serde(default = "thin")]
    pub lift_slope_1_rad: FunctionFile,
    /// Angle of attack of zero lift, from the chord line; negative where the profile is cambered towards the section's `+z`.
    #[serde(default)]
    pub zero_lift_angle_deg: f64,
    /// Moment coefficient about the quarter chord, nose up: towards the section's `+z`.
    #[serde(default)]
    pub moment_coefficient: f64,
    /// Drag coefficient of the profile.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub drag_coefficient: f64,
    /// Polar of the profile, instead of the coefficients above: rows of angle of attack in degrees, lift, drag and
    /// moment coefficient about the quarter chord, linear between rows; positive towards the section's `+z`. In a lattice it is
    /// entered with the angle after what the lattice induces, and needs `leading_edge_suction`.
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

/// Flap: the rear part of a lifting surface between two places, which turns about a hinge. The FMU's inputs are
/// `aero.control_surface.<name>.angle_command` and `aero.control_surface.<name>.angle_command_rate`, its outputs `aero.control_surface.<name>.angle`, `aero.control_surface.<name>.rate` and
/// `aero.control_surface.<name>.hinge_moment`. Strips and lattice only.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ControlSurfaceFile {
    /// Body on whose surface it lies.
    pub body: String,
    /// Distance from the body's inner end at which it begins. Strips end where flaps end.
    pub from_m: f64,
    /// Distance from the body's inner end at which it ends.
    pub to_m: f64,
    /// Place of the hinge on the chord, from the leading edge, as a fraction of the chord between 0 and 1. In a lattice it lies
    /// on a line between panels: times `chord_panels` it is a whole number.
    pub hinge_fraction: f64,
    /// Angle at the start, and start value of the input; positive angles move the trailing edge towards the section's `−z`.
    #[serde(default)]
    pub command_deg: f64,
    /// Smallest angle. A command beyond it is refused.
    #[serde(default = "minus_thirty")]
    #[schemars(range(min = -60.0, max = 60.0))]
    pub lower_deg: f64,
    /// Largest angle. A command beyond it is refused.
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
    /// Shape behind the front.
    pub shape: GustShapeFile,
    /// Maximum added velocity, root frame; of turbulence its standard deviation, along or across the way of the gust; of a table
    /// what a share of 1 stands for.
    pub velocity_m_s: [f64; 3],
    /// Length of a `one_minus_cosine`; of turbulence the distance after which it repeats, default: 256 scales.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: Option<f64>,
    /// Rows `[distance behind the front, share of velocity_m_s]` with ascending distances, linear between them; zero before the
    /// first, the last share from there on. `table` only.
    pub table: Option<Vec<[f64; 2]>>,
    /// Scale of turbulence, which its large eddies have. Turbulence only, needed there.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale_m: Option<f64>,
    /// The same seed gives the same turbulence; default: 0.
    pub seed: Option<u64>,
    /// Distance of the points at which turbulence is worked out; waves shorter than four of these are left out. Default: a 256th
    /// of the scale.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub resolution_m: Option<f64>,
    /// Direction of travel, root frame, of any length except zero; default: that of `wind_m_s`.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub direction: Option<[f64; 3]>,
    /// Speed of travel; default: that of `wind_m_s`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed_m_s: Option<f64>,
    /// Position of its front at `start_s`.
    #[serde(default)]
    pub origin_m: [f64; 3],
    /// Time at which its front passes `origin_m`.
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
    /// By a table over the distance behind the front.
    Table,
    /// Continuous turbulence with Dryden's spectrum.
    Dryden,
    /// Continuous turbulence with von Kármán's spectrum.
    VonKarman,
}
