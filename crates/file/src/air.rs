//! Aerodynamics of the model file: the tables `[aerodynamics]`, `[surface.<name>]`, `[control_surface.<name>]` and
//! `[gust.<name>]`.

use crate::air_file::{AirFile, AirModelFile, CouplingFile, LeadingEdgeFile, SurfaceFile};
use crate::air_keys::{LATTICE_KEYS, LATTICE_SURFACE_KEYS, PROFILE_KEYS, SPAN_KEYS, STRIP_KEYS, build};
use crate::air_part_file::TipLossFile;
use crate::air_parts;
use crate::checker::Checker;
use crate::file::ModelFile;
use crate::function::along_body;
use crate::gust;
use crate::rotor;
use foldwing_engine::aero::polar::{Polar, PolarRow};
use foldwing_engine::aero::surface::Profile;
use foldwing_engine::machine::builder::{FlapBuilder, MachineBuilder, SurfaceBuilder};
use foldwing_engine::machine::{Air, LiftingSurface};

/// Adds aerodynamics, surfaces and gusts to a machine. Surfaces on bodies with an invalid section are omitted.
pub(super) fn add(
    file: &ModelFile,
    lawless: &[&str],
    mut machine: MachineBuilder,
    checker: &mut Checker,
) -> MachineBuilder {
    match &file.aerodynamics {
        Some(air) if !air.parts.is_empty() => {
            let built = air_parts::build(air, file, checker).unwrap_or_else(|| {
                checker.stands_in(&["air"]);
                Air::none()
            });
            machine = machine.air(build(built, air));
        }
        Some(air) => {
            refuse_keys_without_effect(air, file, checker);
            let base = match air.model {
                AirModelFile::Uvlm => Air::lattice(),
                AirModelFile::Strip => Air::strips(),
                AirModelFile::None => Air::none(),
                AirModelFile::Bem => rotor::build("", air, file, checker).unwrap_or_else(|| {
                    checker.stands_in(&["air"]);
                    Air::none()
                }),
            };
            machine = machine.air(build(base, air));
        }
        None => {
            let stray = file.surface.keys().next().map(|name| ["surface", name]);
            let stray = stray.or(file.gust.keys().next().map(|name| ["gust", name]));
            let stray = stray.or(file.control_surface.keys().next().map(|name| ["control_surface", name]));
            if let Some(path) = stray {
                checker.refuse_as(&path, "a table without [aerodynamics]", "a model file with [aerodynamics]");
            }
            machine = machine.air(Air::none()); // so that the tables are checked nevertheless
        }
    }
    let parts = file.aerodynamics.as_ref().is_some_and(|air| !air.parts.is_empty());
    let bem = file.aerodynamics.as_ref().is_some_and(|air| air.model == AirModelFile::Bem);
    for (index, (name, surface)) in file.surface.iter().enumerate() {
        let path = ["surface", name, "body"];
        let earlier = file.surface.iter().take(index).find(|(_, other)| other.body == surface.body);
        let built = match earlier {
            Some((other, _)) => {
                checker.refuse(&path, format!("a body without a surface; this one already has {other:?}"));
                None
            }
            None if lawless.contains(&surface.body.as_str()) => None,
            // with several models, a blade is a surface with keys of a blade
            None => {
                let blade = if parts { surface.stations_m.is_some() || surface.polars.is_some() } else { bem };
                build_surface(name, surface, blade, checker)
            }
        };
        match built {
            Some(built) => machine = machine.surface(built),
            None => checker.stands_in(&["air"]),
        }
    }
    for (name, flap) in &file.control_surface {
        let built = FlapBuilder::new(name, &flap.body, [flap.from_m, flap.to_m], flap.hinge_fraction)
            .limits_rad([flap.lower_deg, flap.upper_deg].map(f64::to_radians))
            .command_rad(flap.command_deg.to_radians());
        machine = machine.flap(built);
    }
    let wind_m_s = file.aerodynamics.as_ref().map_or([0.0; 3], |air| air.wind_m_s).into();
    for (name, gust) in &file.gust {
        if let Some(gust) = gust::build(name, gust, &wind_m_s, checker) {
            machine = machine.gust(gust);
        }
    }
    machine
}

/// Reports keys that the aerodynamic model does not use. With the model "none" all keys are accepted, because aerodynamics
/// is only switched off.
fn refuse_keys_without_effect(air: &AirFile, file: &ModelFile, checker: &mut Checker) {
    let (keys, surface_keys, model) = match air.model {
        AirModelFile::None => return,
        AirModelFile::Uvlm => (STRIP_KEYS, [].as_slice(), "strip"),
        AirModelFile::Strip => (LATTICE_KEYS, LATTICE_SURFACE_KEYS, "uvlm"),
        AirModelFile::Bem => (LATTICE_KEYS, LATTICE_SURFACE_KEYS, "uvlm"),
    };
    let allowed = format!("this key only with model = {model:?}");
    let spans = air.model == AirModelFile::Strip && air.tip_loss == TipLossFile::LiftingLine;
    if !spans && air.model == AirModelFile::Strip {
        for key in SPAN_KEYS.iter().filter(|key| checker.states(&["aerodynamics", key])).collect::<Vec<_>>() {
            let allowed = "this key only with model = \"uvlm\", or with tip_loss = \"lifting_line\"";
            checker.refuse(&["aerodynamics", key], allowed);
            checker.stands_in(&["air", key]);
        }
    }
    if spans {
        for path in file.surface.keys().map(|name| ["surface", name, "polar"]) {
            if checker.states(&path) {
                let allowed = "this key only without tip_loss; a lifting line needs lift_slope_1_rad";
                checker.refuse(&path, allowed);
            }
        }
    }
    for key in keys.iter().filter(|key| checker.states(&["aerodynamics", key])).collect::<Vec<_>>() {
        checker.refuse(&["aerodynamics", key], allowed.as_str());
        checker.stands_in(&["air", key]);
    }
    for path in file.surface.keys().flat_map(|name| surface_keys.iter().map(move |key| ["surface", name, key])) {
        if checker.states(&path) {
            checker.refuse(&path, allowed.as_str());
        }
    }
    refuse_rotor_keys(air, file, checker);
    if air.ground_normal.is_some() != air.ground_distance_m.is_some() {
        let [given, missing] = match air.ground_normal {
            Some(_) => ["ground_normal", "ground_distance_m"],
            None => ["ground_distance_m", "ground_normal"],
        };
        checker.refuse(&["aerodynamics", missing], format!("this key with {given}: the ground needs both"));
    }
    if air.coupling == CouplingFile::Staggered {
        for key in ["coupling_tolerance", "coupling_iterations"] {
            if checker.states(&["aerodynamics", key]) {
                checker.refuse(&["aerodynamics", key], "this key only with coupling = \"iterated\"");
            }
        }
    }
}

/// Reports keys of a rotor in a model without one, and in a model with one, keys that its blades do not use.
fn refuse_rotor_keys(air: &AirFile, file: &ModelFile, checker: &mut Checker) {
    let surfaces = |keys: &'static [&'static str]| {
        file.surface.keys().flat_map(move |name| keys.iter().map(move |key| ["surface", name, key]))
    };
    if air.model == AirModelFile::Bem {
        for key in STRIP_KEYS.iter().chain(SPAN_KEYS).chain(&[
            "leading_edge_suction",
            "report_circulation",
            "speed_of_sound_m_s",
        ]) {
            if checker.states(&["aerodynamics", key]) {
                checker.refuse(&["aerodynamics", key], "this key only with model = \"strip\" or \"uvlm\"");
            }
        }
        for path in surfaces(PROFILE_KEYS).chain(surfaces(&["strips"])) {
            if checker.states(&path) {
                checker.refuse(&path, "this key not with model = \"bem\", whose blades have stations_m and polars");
            }
        }
        return;
    }
    let allowed = "this key only with model = \"bem\"";
    for key in rotor::KEYS {
        if checker.states(&["aerodynamics", key]) {
            checker.refuse(&["aerodynamics", key], allowed);
        }
    }
    for path in surfaces(rotor::SURFACE_KEYS) {
        if checker.states(&path) {
            checker.refuse(&path, allowed);
        }
    }
    for key in ["polar", "wind", "tower"] {
        if checker.states(&[key]) {
            checker.refuse_as(
                &[key],
                format!("a table [{key}] without a rotor"),
                "this table only with model = \"bem\"",
            );
        }
    }
}

/// Builds a surface, of a rotor's `blade` or of a wing; `None` after an error.
fn build_surface(name: &str, surface: &SurfaceFile, blade: bool, checker: &mut Checker) -> Option<SurfaceBuilder> {
    let strips = match surface.strips {
        Some(strips) => strips,
        None if blade => 1,
        None => {
            checker.refuse(&["surface", name, "strips"], "a whole number from 1 to 1000");
            return None;
        }
    };
    let polar = match &surface.polar {
        Some(rows) if !blade => Some(polar(name, rows, checker)?),
        _ => None,
    };
    let mut built = LiftingSurface::on(&surface.body, strips)
        .chord_panels(surface.chord_panels)
        .elastic_axis_fraction(along_body(
            &["surface", name, "elastic_axis_fraction"],
            &surface.elastic_axis_fraction,
            checker,
        )?)
        .lift_slope_1_rad(along_body(&["surface", name, "lift_slope_1_rad"], &surface.lift_slope_1_rad, checker)?)
        .profile(Profile {
            zero_lift_angle_rad: surface.zero_lift_angle_deg.to_radians(),
            moment_coefficient: surface.moment_coefficient,
            drag_coefficient: surface.drag_coefficient,
            polar,
            ..Profile::THIN
        });
    if let Some(chord) = &surface.chord_m {
        built = built.chord_m(along_body(&["surface", name, "chord_m"], chord, checker)?);
    }
    if let Some(incidence) = &surface.incidence_deg {
        built = built.incidence_deg(along_body(&["surface", name, "incidence_deg"], incidence, checker)?);
    }
    if let Some(flare) = &surface.flare_deg {
        built = built.flare_deg(along_body(&["surface", name, "flare_deg"], flare, checker)?);
    }
    if blade {
        match (&surface.stations_m, &surface.polars) {
            (Some(stations_m), Some(polars)) => built = built.blade(stations_m.clone(), polars.clone()),
            (None, _) => {
                checker.refuse(&["surface", name, "stations_m"], "at least 2 ascending positions in m along the blade");
                return None;
            }
            (_, None) => {
                checker.refuse(&["surface", name, "polars"], "the name of a polar for each station");
                return None;
            }
        }
    }
    if let Some(length_m) = surface.length_m {
        built = built.length_m(length_m);
    }
    Some(match surface.leading_edge {
        LeadingEdgeFile::Plus => built,
        LeadingEdgeFile::Minus => built.leading_edge_minus_y(),
    })
}

/// Polar of a profile.
fn polar(name: &str, rows: &[[f64; 4]], checker: &mut Checker) -> Option<Polar> {
    let ascending = rows.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    if !ascending || rows.iter().any(|row| row[0].abs() > 180.0) {
        let allowed =
            "rows [angle of attack in deg, lift, drag, moment coefficient] with angles ascending from -180 to 180";
        checker.refuse(&["surface", name, "polar"], allowed);
        return None;
    }
    let row = |row: &[f64; 4]| PolarRow { angle_rad: row[0].to_radians(), lift: row[1], drag: row[2], moment: row[3] };
    Some(Polar { rows: rows.iter().map(row).collect() })
}
