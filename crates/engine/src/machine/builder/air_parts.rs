//! Several aerodynamic models in code: equivalents of the tables `[aerodynamics.<name>]` of the model file.

use crate::machine::builder::air::{AirBuilder, Model};
use crate::machine::builder::flap::FlapBuilder;
use crate::machine::builder::place::air_place;
use crate::machine::builder::surfaces::Draft;
use crate::machine::fault::Checker;
use crate::machine::units::quoted;
use crate::machine::validate::names;
use crate::machine::{Air, Body, Parent};

impl Air {
    /// Several aerodynamic models in one flow, each on its own bodies: [`AirBuilder::part`] adds them. Density, wind, step, coupling,
    /// initial flow and gusts are common to all.
    pub fn parts() -> AirBuilder {
        Self::builder(Model::Parts)
    }
}

impl AirBuilder {
    /// Adds a model by name, an identifier, to [`Air::parts`]: any number of rotors ([`Air::rotor`]), whose surfaces are those on bodies
    /// that their hubs carry, any number of slender bodies ([`Air::slender_body`]), and at most one of strips ([`Air::strips`]), with all
    /// other surfaces.
    pub fn part(mut self, name: impl Into<String>, part: Self) -> Self {
        self.parts.push((name.into(), part));
        self
    }
}

/// Checks the models of parts. Returns false after an error.
pub(super) fn check(air: &AirBuilder, checker: &mut Checker) -> bool {
    let before = checker.faults.len();
    names("air", air.parts.iter().map(|(name, _)| name.as_str()), checker);
    if air.parts.is_empty() {
        checker.refuse_state(&["air"], "no part", "at least one rotor or slender body, or strips");
    }
    let mut strips = None;
    for (name, part) in &air.parts {
        let place = air_place(name, "model");
        match part.model {
            Model::Rotor | Model::SlenderBody => {}
            Model::Strips => {
                if let Some(other) = strips.replace(name) {
                    let found = format!("strips beside the strips of {other}");
                    let allowed = "one part with strips, which has all surfaces that belong to no rotor";
                    checker.refuse_state(&place, found, allowed);
                }
            }
            Model::Lattice | Model::Parts | Model::None => {
                let allowed = "strips, rotors or slender bodies: a vortex lattice is the only aerodynamic model, because its wake would \
                               have to meet the other surfaces";
                checker.refuse_state(&place, "a vortex lattice or no model in a part", allowed);
            }
        }
        if part.states_common_settings() {
            let found = "density, wind, step, coupling, initial flow or circulation outputs in a part";
            checker.refuse_state(&["air", name], found, "these settings for all parts together");
        }
    }
    let field = air.parts.iter().filter_map(|(_, part)| part.rotor.as_ref());
    let mut fields = field.map(|rotor| (&rotor.features.field, &rotor.features.tower));
    let first = fields.next();
    let uniform = first.is_none_or(|(field, tower)| field.is_none() && tower.is_none());
    if fields.any(|other| Some(other) != first) {
        checker.refuse_state(
            &["wind"],
            "rotors in different wind fields or behind different towers",
            "one wind for all",
        );
    } else if (strips.is_some() || air.has_slender_body()) && !uniform {
        let allowed =
            "a uniform wind with gusts: strips and slender bodies do not use the wind field and the tower of rotors";
        checker.refuse_state(&["wind"], "a wind field or a tower with strips or slender bodies beside rotors", allowed);
    }
    checker.faults.len() == before
}

/// Whether a hub carries a body, or is it.
fn carries(hub: usize, body: usize, bodies: &[Body]) -> bool {
    let mut at = body;
    while at != hub {
        match bodies[at].joint.parent {
            Parent::Body { index, .. } if index < at => at = index,
            Parent::Root { .. } | Parent::Body { .. } => return false,
        }
    }
    true
}

/// Divides the surfaces among the models: those on bodies that a hub carries are blades of its rotor, all others have strips; slender bodies
/// have none. `None` after an error.
pub(super) fn share<'b>(
    named: &[(&str, &AirBuilder)],
    drafts: Vec<Draft<'b>>,
    flaps: &[FlapBuilder],
    bodies: &[Body],
    checker: &mut Checker,
) -> Option<Vec<Vec<Draft<'b>>>> {
    if let [(_, AirBuilder { slender: None, .. })] = named {
        return Some(vec![drafts]);
    }
    let mut hubs = Vec::new();
    for (name, part) in named {
        let Some(rotor) = &part.rotor else {
            hubs.push(None);
            continue;
        };
        let Some(hub) = bodies.iter().position(|body| body.name == rotor.hub) else {
            let known = bodies.iter().map(|body| body.name.as_str());
            checker.unknown_name(&air_place(name, "hub"), &rotor.hub, "a body", known);
            return None;
        };
        hubs.push(Some(hub));
    }
    for (own, hub) in hubs.iter().enumerate() {
        let on = |other: &Option<usize>| hub.zip(*other).is_some_and(|(hub, other)| carries(other, hub, bodies));
        if let Some(other) = (0..hubs.len()).find(|other| *other != own && on(&hubs[*other])) {
            let found = format!("a hub that the hub of {} carries", named[other].0);
            let allowed = "hubs on different shafts: every body belongs to one rotor at most";
            checker.refuse_state(&air_place(named[own].0, "hub"), found, allowed);
            return None;
        }
    }
    let strips = named.iter().position(|(_, part)| part.rotor.is_none() && part.slender.is_none());
    let mut shares: Vec<Vec<Draft>> = named.iter().map(|_| Vec::new()).collect();
    for draft in drafts {
        let body = draft.surface.body.as_str();
        let rotor = hubs.iter().position(|hub| hub.is_some_and(|hub| carries(hub, draft.body, bodies)));
        let Some(part) = rotor.or(strips) else {
            let rotors: Vec<&str> =
                named.iter().filter(|(_, part)| part.rotor.is_some()).map(|(name, _)| *name).collect();
            let allowed = match rotors.as_slice() {
                [] => "a table [aerodynamics.<name>] with strips beside the slender bodies".to_owned(),
                _ => format!(
                    "a surface on a body that one of the hubs of {} carries, or a part with strips",
                    quoted(&rotors)
                ),
            };
            checker.refuse_state(&["surface", body, "body"], "a surface that belongs to no part", allowed);
            return None;
        };
        if rotor.is_none() && draft.surface.blade.is_some() {
            let allowed = "stations_m and polars only on bodies that the hub of a rotor carries";
            checker.refuse_state(&["surface", body, "stations_m"], "a blade without a rotor", allowed);
            return None;
        }
        if let Some(flap) = flaps.iter().find(|flap| rotor.is_some() && flap.is_on(body)) {
            let allowed = "no control surfaces on a rotor; they need strips or a lattice";
            let place = ["control_surface", flap.name.as_str()];
            checker.refuse_state(&place, "a control surface on a rotor's blade", allowed);
            return None;
        }
        shares[part].push(draft);
    }
    let bare = |(part, own): (&(&str, &AirBuilder), &Vec<Draft>)| own.is_empty() && part.1.slender.is_none();
    if let Some(empty) = named.iter().zip(&shares).position(bare) {
        checker.refuse_state(
            &["air", named[empty].0],
            "a part without a surface",
            "at least one surface on its bodies",
        );
        return None;
    }
    Some(shares)
}
