//! Sections of the lifting surfaces and hubs in the equations.

use crate::load::LoadFrame;
use crate::machine;
use crate::multibody::Model;

/// Appends the sections of the surfaces and then those of the rotors' hubs to a model, after its load stations.
pub(crate) fn add_sections(machine: &machine::Machine, model: &mut Model) {
    for surface in machine.air.iter().flat_map(|air| &air.surfaces) {
        model.add_stations(surface.body, &surface.positions_m, LoadFrame::Section);
    }
    // the inner end of a hub is the apex of its rotor
    for (_, rotor) in machine.air.iter().flat_map(|air| air.rotors()) {
        model.add_stations(rotor.hub_body, &[0.0], LoadFrame::Section);
    }
}
