//! Sections of the lifting surfaces and hubs in the equations.

use crate::load::LoadFrame;
use crate::machine;
use crate::multibody::Model;

/// Appends the sections of the surfaces and then, in the order of the aerodynamic models, those of rotors' hubs and slender bodies to a
/// model, after its load stations.
pub(crate) fn add_sections(machine: &machine::Machine, model: &mut Model) {
    for surface in machine.air.iter().flat_map(|air| &air.surfaces) {
        model.add_stations(surface.body, &surface.positions_m, LoadFrame::Section);
    }
    for part in machine.air.iter().flat_map(|air| &air.parts) {
        // the inner end of a hub is the apex of its rotor
        if let Some(rotor) = part.options.rotor() {
            model.add_stations(rotor.hub_body, &[0.0], LoadFrame::Section);
        }
        if let Some(body) = part.options.slender_body() {
            model.add_stations(body.body, &body.stations_m(), LoadFrame::Section);
        }
    }
}
