//! Construction of the aerodynamics on valid bodies.

use crate::aero::AirOptions;
use crate::aero::flow::Gust;
use crate::machine::builder::air::{AirBuilder, Model};
use crate::machine::builder::air_parts;
use crate::machine::builder::flap::{self, FlapBuilder};
use crate::machine::builder::gust::GustBuilder;
use crate::machine::builder::place::air_place;
use crate::machine::builder::surfaces::{SurfaceBuilder, draft, place_all};
use crate::machine::edges::fastest_m_s;
use crate::machine::fault::Checker;
use crate::machine::units::shortest;
use crate::machine::validate::air::lattice_size;
use crate::machine::{Air, AirPart, Body, LiftingSurface};

/// Builds the aerodynamics around valid bodies; `None` without aerodynamics, or after errors that leave nothing to build. Bodies with
/// errors (not in `stand`) are only looked up by name.
pub(super) fn build(
    air: Option<&AirBuilder>,
    (surfaces, flaps): (&[SurfaceBuilder], &[FlapBuilder]),
    gusts: &[GustBuilder],
    bodies: &[Body],
    stand: bool,
    start_time_s: f64,
    checker: &mut Checker,
) -> Option<Air> {
    let Some(air) = air else {
        let stray = surfaces.first().map(|surface| ["surface", surface.body.as_str()]);
        let stray = stray.or(gusts.first().map(|gust| ["gust", gust.name.as_str()]));
        let stray = stray.or(flaps.first().map(|flap| ["control_surface", flap.name.as_str()]));
        if let Some(place) = stray {
            checker.refuse_state(
                &place,
                "a surface, gust or control surface without aerodynamics",
                "a model with aerodynamics",
            );
        }
        return None;
    };
    let drafts: Option<Vec<_>> = {
        let drafts: Vec<Option<_>> =
            surfaces.iter().enumerate().map(|(index, _)| draft(index, surfaces, bodies, checker)).collect();
        drafts.into_iter().collect()
    };
    let gusts: Vec<Option<Gust>> = gusts.iter().map(|gust| gust.build(&air.wind_m_s, checker)).collect();
    let whole = air.model == Model::Rotor || flap::check(flaps, surfaces, bodies, air.model == Model::Lattice, checker);
    if air.model == Model::None {
        return None;
    }
    if let (Model::Rotor, Some(flap)) = (air.model, flaps.first()) {
        let allowed = "no control surfaces on a rotor; they need strips or a lattice";
        checker.refuse_state(&["control_surface", flap.name.as_str()], "a control surface on a rotor's blade", allowed);
        return None;
    }
    if surfaces.is_empty() && !air.has_slender_body() {
        let allowed = "at least one surface";
        checker.refuse_state(&["air", "model"], "aerodynamics without a surface", allowed);
        return None;
    }
    let named = air.named();
    if air.model == Model::Parts && !air_parts::check(air, checker) {
        return None;
    }
    let mirrors: Vec<_> = named.iter().map(|(name, part)| part.mirror(name, checker)).collect::<Option<_>>()?;
    let ground = air.ground_plane(mirrors.first().copied().flatten(), checker)?;
    let drafts = drafts?;
    if !whole {
        return None;
    }
    let gusts = gusts.into_iter().collect::<Option<Vec<_>>>()?;
    if !stand {
        return None;
    }
    let lattice = air.model == Model::Lattice;
    if lattice {
        let sizes = drafts.iter().map(|draft| (draft.surface.strips, draft.surface.chord_panels));
        if !lattice_size(sizes, air.wake_rows, checker) {
            return None;
        }
    }
    let builders = surfaces;
    let shares = air_parts::share(&named, drafts, flaps, bodies, checker)?;
    let mut placed = Vec::new();
    for (((_, part), drafts), mirror) in named.iter().zip(&shares).zip(&mirrors) {
        placed.push(place_all(drafts, flaps, (lattice, lattice || part.tip_loss), bodies, *mirror, checker)?);
    }
    let mut surfaces: Vec<LiftingSurface> = placed.iter().flatten().cloned().collect();
    surfaces.sort_by_key(|surface| surface.body);
    let smallest_m = surfaces
        .iter()
        .flat_map(|surface| surface.chords.iter().map(|chord| chord.length_m() / surface.chord_panels as f64))
        .fold(f64::INFINITY, f64::min);
    let step_s = match air.step_s {
        Some(step_s) => step_s,
        None => match fastest_m_s(&surfaces, bodies, air.wind_m_s, start_time_s) {
            Some(speed_m_s) => smallest_m / speed_m_s,
            None => {
                let allowed = match surfaces.is_empty() {
                    true => "a finite time > 0 s: it has no default without a surface",
                    false => {
                        "a finite time > 0 s: it has no default if the wing does not move relative to the air at the start"
                    }
                };
                checker.refuse(&["air", "step_s"], "none", allowed);
                return None;
            }
        },
    };
    let mut parts = Vec::new();
    for (((name, part), own), mirror) in named.iter().zip(&placed).zip(mirrors) {
        let options = if lattice {
            AirOptions::Lattice(part.lattice_options(smallest_m, (mirror, ground)))
        } else if let Some(rotor) = &part.rotor {
            if let Some(lag_s) = rotor.features.inflow_lag_s.filter(|lag_s| *lag_s < step_s) {
                let allowed = format!("a finite time >= {} s, the aerodynamic step", shortest(step_s));
                checker.refuse(&air_place(name, "inflow_lag_s"), shortest(lag_s), allowed);
                return None;
            }
            AirOptions::Rotor(Box::new(rotor.options(name, builders, own, bodies, checker)?))
        } else if let Some(slender) = &part.slender {
            AirOptions::SlenderBody(Box::new(slender.options(name, part.apparent_mass, bodies, checker)?))
        } else {
            AirOptions::Strips(part.strip_options(own, mirror))
        };
        let is_own = |index: &usize| own.iter().any(|surface| surface.body == surfaces[*index].body);
        let indices = (0..surfaces.len()).filter(is_own).collect();
        parts.push(AirPart { name: (*name).to_owned(), options, surfaces: indices });
    }
    Some(Air {
        parts,
        density_kg_m3: air.density_kg_m3,
        wind_m_s: air.wind_m_s,
        step_s,
        coupling: air.coupling,
        established: air.established,
        reports_circulation: air.reports_circulation,
        flaps: flap::build(flaps, builders, &surfaces, bodies),
        surfaces,
        gusts,
    })
}
