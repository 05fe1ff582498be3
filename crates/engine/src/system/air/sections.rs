//! Sections of the lifting surfaces in the equations.

use crate::aero::AirOptions;
use crate::load::LoadFrame;
use crate::machine;
use crate::multibody::Model;

/// Appends the sections of the surfaces to a model, after its load stations.
pub(crate) fn add_sections(machine: &machine::Machine, model: &mut Model) {
    for surface in machine.air.iter().flat_map(|air| &air.surfaces) {
        model.add_stations(surface.body, &surface.positions_m, LoadFrame::Section);
    }
    if let Some(body) = machine.air.as_ref().and_then(hub) {
        model.add_stations(body, &[0.0], LoadFrame::Section);
    }
}

/// Body whose inner end is the apex of a rotor, if there is one: its section is stored after those of the surfaces.
pub(super) fn hub(air: &machine::Air) -> Option<usize> {
    match &air.options {
        AirOptions::Rotor(options) => Some(options.hub_body),
        AirOptions::Lattice(_) | AirOptions::Strips(_) => None,
    }
}
