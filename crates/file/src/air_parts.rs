//! Several aerodynamic models in the model file: the tables `[aerodynamics.<name>]`.

use crate::air_file::{AirFile, AirModelFile, CouplingFile};
use crate::air_keys::{self, LATTICE_KEYS, LATTICE_SURFACE_KEYS, PROFILE_KEYS, SPAN_KEYS, STRIP_KEYS};
use crate::air_part_file::{AirPartFile, AirPartModelFile, TipLossFile};
use crate::checker::Checker;
use crate::file::ModelFile;
use crate::rotor::{self, air_path};
use foldwing_engine::machine::Air;
use foldwing_engine::machine::builder::{AirBuilder, SlenderBodySettings};

/// Keys of `[aerodynamics.<name>]` that both strips and lattice have, besides those listed for each.
const WING_KEYS: &[&str] = &["leading_edge_suction", "speed_of_sound_m_s"];
/// Keys of `[aerodynamics.<name>]` that only slender bodies have.
const SLENDER_KEYS: &[&str] =
    &["body", "radius_m", "segments", "cross_flow_drag_coefficient", "axial_drag_coefficient"];

/// Builds the models of all parts; `None` after an error. With `model = "none"` in `[aerodynamics]` they are switched off.
pub(super) fn build(common: &AirFile, file: &ModelFile, checker: &mut Checker) -> Option<AirBuilder> {
    refuse_keys(common, file, checker);
    if common.model == AirModelFile::None && checker.states(&["aerodynamics", "model"]) {
        return Some(Air::none());
    }
    let mut built = Air::parts();
    let mut whole = true;
    for (name, part) in &common.parts {
        let own = alone(part, common);
        let base = match part.model {
            AirPartModelFile::Strip => Some(air_keys::build(Air::strips(), &AirFile { wind_m_s: [0.0; 3], ..own })),
            AirPartModelFile::Bem => rotor::build(name, &own, file, checker),
            AirPartModelFile::SlenderBody => slender_body(name, part, checker),
        };
        match base {
            Some(base) => built = built.part(name, base),
            None => whole = false,
        }
    }
    whole.then_some(built)
}

/// Builds a slender body; `None` after an error.
fn slender_body(name: &str, part: &AirPartFile, checker: &mut Checker) -> Option<AirBuilder> {
    if part.body.is_none() {
        checker.refuse(&air_path(name, "body"), "the body whose cross-sections radius_m describes");
    }
    if part.radius_m.is_none() {
        let allowed = "at least 2 rows [position in m, radius in m] with ascending positions and radii >= 0, not all 0";
        checker.refuse(&air_path(name, "radius_m"), allowed);
    }
    let settings = SlenderBodySettings {
        segments: part.segments,
        cross_flow_drag_coefficient: part.cross_flow_drag_coefficient,
        axial_drag_coefficient: part.axial_drag_coefficient,
        ..SlenderBodySettings::on(part.body.clone()?, part.radius_m.clone()?)
    };
    Some(Air::slender_body(settings).apparent_mass(part.apparent_mass))
}

/// The part as the only model of a machine, with the wind of all.
fn alone(part: &AirPartFile, common: &AirFile) -> AirFile {
    AirFile {
        model: match part.model {
            AirPartModelFile::Strip => AirModelFile::Strip,
            AirPartModelFile::Bem => AirModelFile::Bem,
            AirPartModelFile::SlenderBody => AirModelFile::None,
        },
        wind_m_s: common.wind_m_s,
        quasi_steady: part.quasi_steady,
        apparent_mass: part.apparent_mass,
        indicial: part.indicial,
        tip_loss: part.tip_loss,
        mirror_normal: part.mirror_normal,
        core_radius_m: part.core_radius_m,
        leading_edge_suction: part.leading_edge_suction,
        speed_of_sound_m_s: part.speed_of_sound_m_s,
        hub: part.hub.clone(),
        hub_radius_m: part.hub_radius_m,
        shaft_axis: part.shaft_axis,
        rotation_direction: part.rotation_direction,
        end_loads: part.end_loads,
        skewed_wake: part.skewed_wake,
        dynamic_inflow: part.dynamic_inflow,
        inflow_lag_s: part.inflow_lag_s,
        blades: part.blades,
        pitch_rate: part.pitch_rate,
        load_interpolation: part.load_interpolation,
        dynamic_stall: part.dynamic_stall,
        aerodyn_compatible: part.aerodyn_compatible,
        ..AirFile::default()
    }
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
                refuse(SLENDER_KEYS, "this key only with model = \"slender_body\"");
                if part.tip_loss != TipLossFile::LiftingLine {
                    refuse(SPAN_KEYS, "this key only with tip_loss = \"lifting_line\"");
                }
            }
            AirPartModelFile::Bem => {
                for keys in [STRIP_KEYS, SPAN_KEYS, WING_KEYS] {
                    refuse(keys, "this key only with model = \"strip\"");
                }
                refuse(SLENDER_KEYS, "this key only with model = \"slender_body\"");
            }
            AirPartModelFile::SlenderBody => {
                refuse(rotor::KEYS, "this key only with model = \"bem\"");
                let own: Vec<&str> = STRIP_KEYS.iter().copied().filter(|key| *key != "apparent_mass").collect();
                for keys in [&own, SPAN_KEYS, WING_KEYS] {
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
    if common.coupling == CouplingFile::Staggered {
        for key in ["coupling_tolerance", "coupling_iterations"] {
            if checker.states(&["aerodynamics", key]) {
                checker.refuse(&["aerodynamics", key], "this key only with coupling = \"iterated\"");
            }
        }
    }
}
