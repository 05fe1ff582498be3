//! Rotor aerodynamics in code: the hub body, the polars of the blades, the optional effects.

use crate::aero::polar::Polar;
use crate::aero::rotor::bem::{RotorFeatures, RotorOptions};
use crate::aero::rotor::viterna::is_full_circle;
use crate::machine::builder::place::air_place;
use crate::machine::builder::surfaces::SurfaceBuilder;
use crate::machine::fault::{Checker, array_text};
use crate::machine::units::shortest;
use crate::machine::{Body, LiftingSurface};
use nalgebra::Vector3;

/// Settings of rotor aerodynamics, for [`Air::rotor`](crate::machine::Air::rotor). Every surface of the machine, or with
/// [`Air::parts`](crate::machine::Air::parts) every surface on bodies that the hub carries, is a blade of the rotor, with its stations and the polars of its sections ([`SurfaceBuilder::blade`]).
#[derive(Debug, Clone, PartialEq)]
pub struct RotorSettings {
    /// Name of the body that rotates with the blades; its inner end is the apex, where their axes meet the shaft.
    pub hub: String,
    /// Direction of the shaft in the hub's frame, downwind, of any nonzero length.
    pub shaft_axis: Vector3<f64>,
    /// Polars by name, from −180° to 180°.
    pub polars: Vec<(String, Polar)>,
    /// Optional effects.
    pub features: RotorFeatures,
}

impl RotorSettings {
    /// A rotor on the named hub that rotates clockwise about its `x` axis, which points downwind; with tip and hub losses and zero loads at
    /// the ends, without skewed wake, dynamic inflow and dynamic stall.
    pub fn on(hub: impl Into<String>, hub_radius_m: f64) -> Self {
        Self {
            hub: hub.into(),
            shaft_axis: Vector3::x(),
            polars: Vec::new(),
            features: RotorFeatures::of(hub_radius_m),
        }
    }

    /// Options of the aerodynamic model, for surfaces in the order of their bodies; `part`: name of the rotor, empty without one. `None`
    /// after an error.
    pub(super) fn options(
        &self,
        part: &str,
        blades: &[SurfaceBuilder],
        surfaces: &[LiftingSurface],
        bodies: &[Body],
        checker: &mut Checker,
    ) -> Option<RotorOptions> {
        let Some(hub_body) = bodies.iter().position(|body| body.name == self.hub) else {
            checker.unknown_name(
                &air_place(part, "hub"),
                &self.hub,
                "a body",
                bodies.iter().map(|body| body.name.as_str()),
            );
            return None;
        };
        let Some(shaft_axis) = self.shaft_axis.try_normalize(0.0).filter(|unit| unit.norm() > 0.5) else {
            let found = array_text(self.shaft_axis.as_slice());
            checker.refuse(&air_place(part, "shaft_axis"), found, "an array of 3 finite numbers, not all 0");
            return None;
        };
        let machine = surfaces.len();
        if let Some(blades) =
            self.features.blades.filter(|blades| *blades == 0 || blades % machine.max(1) != 0 || *blades > 100)
        {
            let allowed = format!("a multiple of {machine}, the number of blades of the model, up to 100");
            checker.refuse(&air_place(part, "blades"), blades.to_string(), allowed);
            return None;
        }
        if let Some(lag_s) = self.features.inflow_lag_s.filter(|lag_s| !(*lag_s > 0.0 && lag_s.is_finite())) {
            checker.refuse(&air_place(part, "inflow_lag_s"), shortest(lag_s), "a finite time > 0 s");
            return None;
        }
        if !(self.features.hub_radius_m > 0.0 && self.features.hub_radius_m.is_finite()) {
            checker.refuse(
                &air_place(part, "hub_radius_m"),
                shortest(self.features.hub_radius_m),
                "a finite length > 0 m",
            );
            return None;
        }
        for (name, polar) in &self.polars {
            if !is_full_circle(&polar.rows) {
                let ends = polar.rows.first().zip(polar.rows.last());
                let found = ends.map_or_else(
                    || "no rows".to_owned(),
                    |(a, b)| format!("angles from {} to {} rad", shortest(a.angle_rad), shortest(b.angle_rad)),
                );
                let allowed = "a polar from -pi to pi: the flow at a blade can come from any side; viterna::extend adds what is missing";
                checker.refuse_state(&["polar", name, "rows"], found, allowed);
                return None;
            }
        }
        let mut sections = Vec::new();
        for surface in surfaces {
            let name = bodies[surface.body].name.as_str();
            let blade = blades.iter().find(|blade| blade.body == name)?;
            let place = ["surface", name, "polars"];
            let Some((_, names)) = &blade.blade else {
                let allowed = "the places of a blade's sections, with a rotor";
                checker.refuse_state(&["surface", name, "stations_m"], "none", allowed);
                return None;
            };
            if names.len() != surface.positions_m.len() {
                let allowed = format!("the name of one polar for each of the {} stations", surface.positions_m.len());
                checker.refuse_state(&place, format!("{} names", names.len()), allowed);
                return None;
            }
            let mut own = Vec::new();
            for polar in names {
                let Some(index) = self.polars.iter().position(|(name, _)| name == polar) else {
                    let known = self.polars.iter().map(|(name, _)| name.as_str());
                    checker.unknown_name(&place, polar, "a polar", known);
                    return None;
                };
                own.push(index);
            }
            sections.push(own);
        }
        Some(RotorOptions {
            hub_body,
            shaft_axis,
            polars: self.polars.iter().map(|(_, polar)| polar.clone()).collect(),
            sections,
            positions_m: surfaces.iter().map(|surface| surface.positions_m.clone()).collect(),
            lengths_m: surfaces
                .iter()
                .map(|surface| {
                    let own = blades.iter().find(|blade| blade.body == bodies[surface.body].name);
                    own.and_then(|blade| blade.length_m).unwrap_or(bodies[surface.body].length_m)
                })
                .collect(),
            sections_turn: surfaces.iter().map(|surface| bodies[surface.body].sections_turn()).collect(),
            features: self.features.clone(),
        })
    }
}
