//! Settings of a rotor's air: features, polars, positions.

use crate::aero::polar::Polar;
use crate::aero::rotor::induction::EndRule;
use crate::aero::rotor::tower::Tower;
use crate::aero::rotor::wind::WindField;
use nalgebra::Vector3;

/// Quasi-steady effect of a section's rotation about its span without dynamic stall, eq. (B25).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PitchRate {
    /// None: coefficients of the angle of attack at the quarter chord.
    #[default]
    None,
    /// Relative to the hub: that of pitch and twist. In the air, a rotating coned blade also turns.
    Hub,
    /// In the air.
    Air,
}

/// Loads between the sections of a blade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spread {
    /// Linear between sections, none beyond the first and the last.
    #[default]
    Linear,
    /// Each section carries the load of its cell, which extends halfway to its neighbours and to the ends of the blade.
    Cells,
}

/// Effects included in a rotor's air: set by the builder of the machine, used unchanged by the model.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorFeatures {
    /// Blades of the rotor; a multiple of the machine's, each of which represents others with the same motion. `None`: the machine has all.
    pub blades: Option<usize>,
    /// Whether the rotor turns about its shaft axis by the right-hand rule: clockwise when looking downwind.
    pub clockwise: bool,
    /// Inner radius of the blades in m, for the hub loss.
    pub hub_radius_m: f64,
    /// Prandtl's losses at tip and hub.
    pub losses: [bool; 2],
    /// Loads at nodes with complete loss.
    pub end_loads: EndRule,
    /// Skewed wake, eq. (B15).
    pub skewed_wake: bool,
    /// Lag of the induced velocity behind the momentum balance due to the wake, eqs. (B9) and (B10).
    pub dynamic_inflow: bool,
    /// Time constant in s with which the induced velocity follows the load of the annulus, eq. (B24), instead of the momentum
    /// balance; without losses and swirl. In hover eq. (B29) has it.
    pub inflow_lag_s: Option<f64>,
    /// Dynamic stall of the sections, eqs. (B12)–(B14).
    pub dynamic_stall: bool,
    /// Effect of a section's rotation about its span without dynamic stall, eq. (B25).
    pub pitch_rate: PitchRate,
    /// Interpolation of loads between the sections.
    pub spread: Spread,
    /// Angle of attack of blades that bend in both directions and state of heavily loaded annuli as in AeroDyn, eq. (B23).
    pub aerodyn_compatible: bool,
    /// Tower in the wind.
    pub tower: Option<Tower>,
    /// Field of the wind; without it the input's wind is everywhere.
    pub field: Option<WindField>,
}

impl RotorFeatures {
    /// A rotor that turns clockwise, with an inner radius of the blades in m; both losses, no load at the ends, no skew and no lag of the
    /// wake, no dynamic stall, neither tower nor field.
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
    /// Whether the sections of each blade turn as it bends; otherwise loads between them are applied as forces alone, eq. (B8).
    pub sections_turn: Vec<bool>,
    /// Features common to builder and model file.
    pub features: RotorFeatures,
}
