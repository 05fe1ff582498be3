//! Several aerodynamic models in the model file: the tables `[aerodynamics.<name>]`.

use crate::air::{self, LATTICE_KEYS, LATTICE_SURFACE_KEYS, PROFILE_KEYS, SPAN_KEYS, STRIP_KEYS};
use crate::air_file::{AirFile, AirModelFile, TipLossFile};
use crate::air_part_file::AirPartModelFile;
use crate::checker::Checker;
use crate::file::ModelFile;
use crate::rotor::{self, air_path};
use foldwing_engine::machine::Air;
use foldwing_engine::machine::builder::AirBuilder;

/// Keys of `[aerodynamics.<name>]` that both strips and lattice have, besides those listed for each.
const WING_KEYS: &[&str] = &["leading_edge_suction", "speed_of_sound_m_s"];

/// Builds the models of all parts; `None` after an error. With `model = "none"` in `[aerodynamics]` they are switched off.
pub(super) fn build(common: &AirFile, file: &ModelFile, checker: &mut Checker) -> Option<AirBuilder> {
    refuse_keys(common, file, checker);
    if common.model == AirModelFile::None && checker.states(&["aerodynamics", "model"]) {
        return Some(Air::none());
    }
    let mut built = Air::parts();
    let mut whole = true;
    for (name, part) in &common.parts {
        let own = part.alone(common);
        let base = match part.model {
            AirPartModelFile::Strip => Some(air::build(Air::strips(), &AirFile { wind_m_s: [0.0; 3], ..own })),
            AirPartModelFile::Bem => rotor::build(name, &own, file, checker),
        };
        match base {
            Some(base) => built = built.part(name, base),
            None => whole = false,
        }
    }
    whole.then_some(built)
}

/// Reports keys without effect: in `[aerodynamics]` those of a single model, in the parts those of other models, in surfaces those of the
/// lattice, and those of a wing in blades and the reverse.
fn refuse_keys(common: &AirFile, file: &ModelFile, checker: &mut Checker) {
    let single = STRIP_KEYS.iter().chain(SPAN_KEYS).chain(LATTICE_KEYS).chain(WING_KEYS).chain(rotor::KEYS);
    for key in single {
        if checker.states(&["aerodynamics", key]) {
            checker.refuse(&["aerodynamics", key], "this key in the tables [aerodynamics.<name>] of the models");
        }
    }
    if common.model != AirModelFile::None {
        let allowed = "no model beside the tables [aerodynamics.<name>], or \"none\" to switch them off";
        checker.refuse(&["aerodynamics", "model"], allowed);
    }
    for (name, part) in &common.parts {
        let mut refuse = |keys: &[&str], allowed: &str| {
            for key in keys {
                if checker.states(&air_path(name, key)) {
                    checker.refuse(&air_path(name, key), allowed);
                }
            }
        };
        match part.model {
            AirPartModelFile::Strip => {
                refuse(rotor::KEYS, "this key only with model = \"bem\"");
                if part.tip_loss != TipLossFile::LiftingLine {
                    refuse(SPAN_KEYS, "this key only with tip_loss = \"lifting_line\"");
                }
            }
            AirPartModelFile::Bem => {
                for keys in [STRIP_KEYS, SPAN_KEYS, WING_KEYS] {
                    refuse(keys, "this key only with model = \"strip\"");
                }
            }
        }
    }
    for (name, surface) in &file.surface {
        let blade = surface.stations_m.is_some() || surface.polars.is_some();
        let wing_keys = PROFILE_KEYS.iter().chain(&["strips"]);
        for key in LATTICE_SURFACE_KEYS.iter().chain(wing_keys.filter(|_| blade)) {
            let path = ["surface", name, key];
            if checker.states(&path) {
                let allowed = match blade {
                    true => "this key not on a blade, which has stations_m and polars",
                    false => "this key only with model = \"uvlm\"",
                };
                checker.refuse(&path, allowed);
            }
        }
        if !blade && checker.states(&["surface", name, "length_m"]) {
            checker.refuse(&["surface", name, "length_m"], "this key only on a blade, with stations_m and polars");
        }
    }
    let rotors = common.parts.values().any(|part| part.model == AirPartModelFile::Bem);
    for key in ["polar", "wind", "tower"].into_iter().filter(|_| !rotors) {
        if checker.states(&[key]) {
            let found = format!("a table [{key}] without a rotor");
            checker.refuse_as(&[key], found, "this table only with model = \"bem\"");
        }
    }
    if common.coupling == crate::air_file::CouplingFile::Staggered {
        for key in ["coupling_tolerance", "coupling_iterations"] {
            if checker.states(&["aerodynamics", key]) {
                checker.refuse(&["aerodynamics", key], "this key only with coupling = \"iterated\"");
            }
        }
    }
}
