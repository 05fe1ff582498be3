//! Settings of the rotor aerodynamics: features, polars, positions.

use crate::aero::polar::Polar;
use crate::aero::rotor::induction::EndRule;
use crate::aero::rotor::tower::Tower;
use crate::aero::rotor::wind::WindField;
use nalgebra::Vector3;

/// Quasi-steady effect of a section's rotation about its span without dynamic stall, eq. (B25).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PitchRate {
    /// No effect: the coefficients are those for the angle of attack at the quarter chord.
    #[default]
    None,
    /// Pitch rate relative to the hub: due to pitch and twist only.
    Hub,
    /// Pitch rate relative to the air, which includes the rotation of a coned blade with the rotor.
    Air,
}

/// Distribution of the loads between the sections of a blade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spread {
    /// Linear between sections, no load beyond the first and the last.
    #[default]
    Linear,
    /// Each section carries the load of its cell, which extends halfway to its neighbours and to the ends of the blade.
    Cells,
}

/// Effects included in the rotor aerodynamics: set by the builder of the machine, used unchanged by the model.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorFeatures {
    /// Number of blades of the rotor, a multiple of the blades in the model: each represents others with the same motion. `None`: all are
    /// in it.
    pub blades: Option<usize>,
    /// Whether the rotor turns about its shaft axis by the right-hand rule: clockwise when looking downwind.
    pub clockwise: bool,
    /// Inner radius of the blades in m, for the hub loss.
    pub hub_radius_m: f64,
    /// Whether Prandtl's losses apply at the tip and at the hub.
    pub losses: [bool; 2],
    /// Rule for the loads at nodes with complete loss.
    pub end_loads: EndRule,
    /// Whether the wake is skewed in oblique wind, eq. (B15).
    pub skewed_wake: bool,
    /// Whether the induced velocity lags behind the momentum balance, as the wake develops, eqs. (B9) and (B10).
    pub dynamic_inflow: bool,
    /// Time constant in s with which the induced velocity follows the load of the annulus, eq. (B24), instead of the momentum balance;
    /// without losses and swirl. Its value in hover is eq. (B29).
    pub inflow_lag_s: Option<f64>,
    /// Whether the sections have dynamic stall, eqs. (B12)–(B14).
    pub dynamic_stall: bool,
    /// Effect of a section's rotation about its span without dynamic stall, eq. (B25).
    pub pitch_rate: PitchRate,
    /// Interpolation of loads between the sections.
    pub spread: Spread,
    /// Whether the angle of attack of blades that bend in both directions and the state of heavily loaded annuli are as in AeroDyn, eq.
    /// (B23).
    pub aerodyn_compatible: bool,
    /// Tower that disturbs the wind.
    pub tower: Option<Tower>,
    /// Wind field; without it the input's wind is uniform.
    pub field: Option<WindField>,
}

impl RotorFeatures {
    /// Features of a clockwise rotor with a given inner radius of its blades in m: tip and hub loss, no load at the ends; no skew and no
    /// lag of the wake, no dynamic stall, neither tower nor field.
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

/// Settings of the rotor aerodynamics.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorOptions {
    /// Index of the model's body that rotates with the blades.
    pub hub_body: usize,
    /// Unit vector along the shaft in the hub's frame, pointing downwind.
    pub shaft_axis: Vector3<f64>,
    /// Polars from −180° to 180°.
    pub polars: Vec<Polar>,
    /// Indices of the polars of the sections, surface by surface.
    pub sections: Vec<Vec<usize>>,
    /// Distances of the sections from the root of the blade in m, surface by surface.
    pub positions_m: Vec<Vec<f64>>,
    /// Lengths of the blades in m.
    pub lengths_m: Vec<f64>,
    /// Whether the sections of each blade rotate as it bends; otherwise loads between them are applied as forces alone, eq. (B8).
    pub sections_turn: Vec<bool>,
    /// Features that are common to the builder and the model file.
    pub features: RotorFeatures,
}
