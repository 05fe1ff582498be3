//! What the air of a rotor is told: features, polars, places.

use crate::aero::polar::Polar;
use crate::aero::rotor::induction::EndRule;
use crate::aero::rotor::tower::Tower;
use crate::aero::rotor::wind::WindField;
use nalgebra::Vector3;

/// Turning of a section about its span that a section without dynamic stall feels, quasi-steadily, eq. (B25).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PitchRate {
    /// None: coefficients of the angle of attack at the quarter chord.
    #[default]
    None,
    /// Against the hub: that of pitch and twist. A coned blade that goes round turns in the air besides.
    Hub,
    /// In the air.
    Air,
}

/// Loads between the sections of a blade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spread {
    /// In straight lines between sections, none beyond the first and the last.
    #[default]
    Linear,
    /// Each section carries the load of its cell, which reaches half way to its neighbours and to the ends of the blade.
    Cells,
}

/// What the air of a rotor takes into account: stated by whoever builds the machine, used as it is by the model.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorFeatures {
    /// Blades of the rotor; a multiple of the machine's, each of which stands for others that move like it. `None`: the machine has all.
    pub blades: Option<usize>,
    /// Whether the rotor turns about its shaft axis by the right hand: clockwise for who looks downwind.
    pub clockwise: bool,
    /// Radius in m at which the blades begin, for the hub loss.
    pub hub_radius_m: f64,
    /// Prandtl's losses at tip and hub.
    pub losses: [bool; 2],
    /// Loads where the loss is complete.
    pub end_loads: EndRule,
    /// Whether the wake leans with the wind, eq. (B15).
    pub skewed_wake: bool,
    /// Whether the induced velocity lags behind the momentum balance as the wake does, eqs. (B9) and (B10).
    pub dynamic_inflow: bool,
    /// Time constant in s with which the induced velocity follows the load of the annulus, eq. (B24), instead of the momentum
    /// balance; without losses and swirl. In hover eq. (B29) has it.
    pub inflow_lag_s: Option<f64>,
    /// Whether sections have dynamic stall, eqs. (B12)–(B14).
    pub dynamic_stall: bool,
    /// What a section without dynamic stall feels of its turning about its span, eq. (B25).
    pub pitch_rate: PitchRate,
    /// How loads between sections follow from those at the sections.
    pub spread: Spread,
    /// Angle of attack of blades that bend both ways and state of heavily loaded annuli as AeroDyn has them, eq. (B23).
    pub aerodyn_compatible: bool,
    /// Tower that the wind goes around.
    pub tower: Option<Tower>,
    /// Field of the wind; without it the input's wind is everywhere.
    pub field: Option<WindField>,
}

impl RotorFeatures {
    /// A rotor that turns clockwise, whose blades begin at a radius in m; both losses, no load at the ends, no wake that leans or
    /// lags, no dynamic stall, neither tower nor field.
    pub fn of(hub_radius_m: f64) -> Self {
        Self {
            blades: None,
            clockwise: true,
            hub_radius_m,
            losses: [true; 2],
            end_loads: EndRule::ZeroLoad,
            skewed_wake: false,
            dynamic_inflow: false,
            inflow_lag_s: None,
            dynamic_stall: false,
            pitch_rate: PitchRate::None,
            spread: Spread::Linear,
            aerodyn_compatible: false,
            tower: None,
            field: None,
        }
    }
}

/// Settings of a rotor's air.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorOptions {
    /// Index into the machine's bodies of the one that turns with the blades.
    pub hub_body: usize,
    /// Unit vector along the shaft in the hub's frame, pointing downwind.
    pub shaft_axis: Vector3<f64>,
    /// Polars, −180° to 180°.
    pub polars: Vec<Polar>,
    /// Index of the polar of each section, surface by surface.
    pub sections: Vec<Vec<usize>>,
    /// Distances of the sections from the root of the blade in m, surface by surface.
    pub positions_m: Vec<Vec<f64>>,
    /// Lengths of the blades in m.
    pub lengths_m: Vec<f64>,
    /// Whether the sections of each blade turn as it bends; those that do not take loads between them as forces alone, eq. (B8).
    pub sections_turn: Vec<bool>,
    /// What code and file say alike.
    pub features: RotorFeatures,
}
