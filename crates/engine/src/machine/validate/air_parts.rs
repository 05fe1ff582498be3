//! Checks of the aerodynamic parts: every surface belongs to one of them.

use crate::machine::fault::Checker;
use crate::machine::validate::names;
use crate::machine::{Air, AirOptions};

/// Checks how the surfaces are divided among the models. Returns false if they are not.
pub(super) fn check(air: &Air, checker: &mut Checker) -> bool {
    let before = checker.faults.len();
    let mut owners = vec![0; air.surfaces.len()];
    for part in &air.parts {
        let bare = part.options.slender_body().is_some();
        if bare && !part.surfaces.is_empty() {
            let found = format!("surfaces {:?}", part.surfaces);
            checker.refuse_state(&["air", "parts"], found, "no surface in a part that is a slender body");
        } else if !bare && part.surfaces.is_empty() || !part.surfaces.is_sorted_by(|a, b| a < b) {
            let allowed = "at least one index of a surface, ascending";
            checker.refuse_state(&["air", "parts"], format!("surfaces {:?}", part.surfaces), allowed);
        }
        for surface in &part.surfaces {
            match owners.get_mut(*surface) {
                Some(owner) => *owner += 1,
                None => {
                    let allowed = format!("one of the {} surfaces, counted from 0", air.surfaces.len());
                    checker.refuse_state(&["air", "parts"], format!("surface {surface}"), allowed);
                }
            }
        }
    }
    if let Some(surface) = owners.iter().position(|owner| *owner != 1) {
        let found = format!("surface {surface} in {} parts", owners[surface]);
        checker.refuse_state(&["air", "parts"], found, "every surface in one part");
    }
    if air.parts.len() > 1 {
        names("air", air.parts.iter().map(|part| part.name.as_str()), checker);
        let lattice = |options: &AirOptions| matches!(options, AirOptions::Lattice(_));
        let strips = |options: &AirOptions| matches!(options, AirOptions::Strips(_));
        let count = |kind: &dyn Fn(&AirOptions) -> bool| air.parts.iter().filter(|part| kind(&part.options)).count();
        if count(&lattice) > 0 || count(&strips) > 1 {
            let allowed =
                "rotors, slender bodies, and strips in one part: a vortex lattice is the only aerodynamic model";
            checker.refuse_state(&["air", "parts"], "a vortex lattice or several parts with strips", allowed);
        }
    }
    checker.faults.len() == before
}
