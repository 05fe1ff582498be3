//! One of several aerodynamic models: the tables `[aerodynamics.<name>]` of the model file.

use crate::rotor_file::{EndRuleFile, PitchRateFile, SpreadFile, TurnsFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One of several aerodynamic models in one flow: any number of rotors and slender bodies, and strips on all other surfaces. No model induces
/// velocities at the surfaces of another: the slipstream of a propeller does not reach the wing, nor does the flow around a fuselage.
/// Periodic motions and gradients are not supported, with rotors neither are flutter speeds. Outputs of a rotor:
/// `rotor.<name>.thrust` and others.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AirPartFile {
    /// Aerodynamic model.
    pub model: AirPartModelFile,
    /// Quasi-steady strip theory, without Wagner's and Küssner's functions. `strip` only.
    #[serde(default)]
    pub quasi_steady: bool,
    /// Include the apparent (added) mass of the air. `strip` and `slender_body` only.
    #[serde(default = "yes")]
    pub apparent_mass: bool,
    /// Approximation of Wagner's and Küssner's functions. `strip` only.
    #[serde(default = "jones")]
    pub indicial: IndicialFile,
    /// Loss of lift towards the wing tips, with induced drag. `strip` only, without polars.
    #[serde(default = "no_loss")]
    pub tip_loss: TipLossFile,
    /// Normal of a mirror plane through the origin. `strip` only, with tip loss.
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub mirror_normal: Option<[f64; 3]>,
    /// Vortex core radius of the lifting line; default: a hundredth of the shortest chord. `strip` only, with tip loss.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub core_radius_m: Option<f64>,
    /// Leading-edge suction; default: included. `strip` only.
    pub leading_edge_suction: Option<bool>,
    /// Speed of sound for the Prandtl–Glauert correction of lift and moments; default: incompressible flow. `strip` only, without polars.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed_of_sound_m_s: Option<f64>,
    /// Body that rotates with the blades; its inner end is the apex, where the blade axes meet the shaft. Surfaces on bodies that it
    /// carries are the blades of this rotor. `bem` only, required there.
    pub hub: Option<String>,
    /// Distance from the apex to the inner ends of the blades. `bem` only, required there.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub hub_radius_m: Option<f64>,
    /// Direction of the shaft in the hub's frame, downwind, of any length except zero. `bem` only.
    #[serde(default = "along_x")]
    #[schemars(extend("x-allowed" = "an array of 3 finite numbers, not all 0"))]
    pub shaft_axis: [f64; 3],
    /// Direction of rotation, looking downwind. `bem` only.
    #[serde(default = "clockwise")]
    pub rotation_direction: TurnsFile,
    /// Load at the very tip and hub of the blades, where Prandtl's loss is complete. `bem` only.
    #[serde(default = "zero")]
    pub end_loads: EndRuleFile,
    /// Skewed-wake correction: induction varies over the disc in oblique inflow (Pitt and Peters). `bem` only.
    #[serde(default)]
    pub skewed_wake: bool,
    /// Dynamic inflow: the induced velocity lags with the time constants of the wake (Øye). `bem` only.
    #[serde(default)]
    pub dynamic_inflow: bool,
    /// Time constant of the first-order lag between the induced velocity of each annulus and the momentum-theory value for the current
    /// load, without losses and swirl; instead of the momentum balance. At least the aerodynamic step. `bem` only.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inflow_lag_s: Option<f64>,
    /// Number of blades of the rotor: a multiple of the number of its surfaces; default: that number. `bem` only.
    #[schemars(range(min = 1, max = 100))]
    pub blades: Option<usize>,
    /// Effect of the pitch rate of sections about the span. `bem` only.
    #[serde(default = "no_rate")]
    pub pitch_rate: PitchRateFile,
    /// Interpolation of the loads between stations. `bem` only.
    #[serde(default = "straight")]
    pub load_interpolation: SpreadFile,
    /// Dynamic stall (Beddoes and Leishman, four states). `bem` only.
    #[serde(default)]
    pub dynamic_stall: bool,
    /// Use AeroDyn's angle of attack for blades that bend in and out of plane, and its state of heavily loaded annuli. `bem` only.
    #[serde(default)]
    pub aerodyn_compatible: bool,
    /// Body without a lifting surface whose loads are those of a slender body of circular cross-section: a fuselage, a nacelle, a boom.
    /// `slender_body` only, required there.
    pub body: Option<String>,
    /// Rows of position along the body's x axis and radius, with ascending positions, linear between rows. Positions on a rigid body are
    /// relative to its frame, those on others from 0 to its length; either end may be the nose. An end with a radius is open: air that
    /// leaves the body there takes its momentum with it. `slender_body` only, required there.
    #[schemars(
        length(min = 2, max = 1000),
        extend("x-allowed" = "at least 2 rows [position in m, radius in m] with ascending positions and radii >= 0")
    )]
    pub radius_m: Option<Vec<[f64; 2]>>,
    /// Number of parts along the body, at least one for each interval of `radius_m`; default: 8, or the number of intervals if that is
    /// larger. `slender_body` only.
    #[schemars(range(min = 1, max = 1000))]
    pub segments: Option<usize>,
    /// Drag coefficient in the flow across the body, referred to its diameter (Allen and Perkins); 1.2 for a long cylinder at a subcritical
    /// Reynolds number. `slender_body` only.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub cross_flow_drag_coefficient: f64,
    /// Drag coefficient in the flow along the body, referred to its largest cross-section. `slender_body` only.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub axial_drag_coefficient: f64,
}

/// Aerodynamic model of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum AirPartModelFile {
    /// Strip theory for all surfaces that belong to no rotor; one part.
    Strip,
    /// Blade-element momentum theory for one rotor.
    Bem,
    /// Slender-body theory for one body.
    #[serde(rename = "slender_body")]
    SlenderBody,
}

fn yes() -> bool {
    true
}

fn jones() -> IndicialFile {
    IndicialFile::Jones
}

fn no_loss() -> TipLossFile {
    TipLossFile::None
}

fn along_x() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}

fn clockwise() -> TurnsFile {
    TurnsFile::Clockwise
}

fn zero() -> EndRuleFile {
    EndRuleFile::Zero
}

fn no_rate() -> PitchRateFile {
    PitchRateFile::None
}

fn straight() -> SpreadFile {
    SpreadFile::Linear
}

/// Approximation of the functions of Wagner and Küssner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum IndicialFile {
    /// R. T. Jones: two and three terms, lift within 1.5 % and 4 % of the exact frequency response.
    Jones,
    /// Five terms each, within 0.06 % and 0.7 %: for flutter of slender wings; slightly slower.
    Fine,
}

/// Loss of lift towards the tips of a wing in strip theory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum TipLossFile {
    /// None: every strip is two-dimensional.
    None,
    /// Lifting line through all strips in their current positions.
    LiftingLine,
}
