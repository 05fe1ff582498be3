//! Checks of the aerodynamics: its settings, lifting surfaces, polars, gusts, and the size of a lattice.

use crate::aero::AirOptions;
use crate::aero::flow::{Gust, GustShape};
use crate::aero::lattice::{LatticeOptions, LoadRule};
use crate::aero::rotor::bem::RotorOptions;
use crate::aero::rotor::viterna::is_full_circle;
use crate::aero::strip::StripOptions;
use crate::aero::strip::lifting_line::LiftingLineOptions;
use crate::machine::fault::{Checker, Range, array_text, is_finite};
use crate::machine::pose::first_frames;
use crate::machine::validate::{air_parts, names, slender, unit_vector};
use crate::machine::{Air, Body, Coupling, LiftingSurface, Parent};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// Maximum number of panels of a lattice: its matrix then takes 200 MB, and its factorisation half a minute.
const MAXIMUM_PANELS: usize = 5_000;
/// Maximum number of panels of a wake.
const MAXIMUM_WAKE_PANELS: usize = 200_000;
/// Maximum number of strips of a surface, and of panels along its chord.
pub(crate) const MAXIMUM_STRIPS: usize = 1_000;

/// Checks the aerodynamics of the bodies.
pub(super) fn check(air: &Air, bodies: &[Body], checker: &mut Checker) {
    checker.number(&["air", "density_kg_m3"], air.density_kg_m3, Range::Above(0.0));
    checker.array(&["air", "wind_m_s"], air.wind_m_s.as_slice());
    checker.number(&["air", "step_s"], air.step_s, Range::Above(0.0));
    if let Coupling::Iterated { tolerance, most_iterations } = air.coupling {
        checker.number(&["air", "coupling_tolerance"], tolerance, Range::Within(1e-12, 1e-1));
        checker.count(&["air", "coupling_iterations"], most_iterations, 1, 1000);
    }
    if air.surfaces.is_empty() && air.slender_bodies().next().is_none() {
        checker.refuse_state(&["air", "model"], "aerodynamics without a surface", "at least one surface");
        return;
    }
    for (index, surface) in air.surfaces.iter().enumerate() {
        check_surface(index, surface, &air.surfaces, bodies, checker);
    }
    slender::check(air, bodies, checker);
    if air_parts::check(air, checker) {
        for part in &air.parts {
            let surfaces: Vec<LiftingSurface> =
                part.surfaces.iter().map(|surface| air.surfaces[*surface].clone()).collect();
            match &part.options {
                AirOptions::Lattice(options) => {
                    check_lattice(options, &surfaces, checker);
                    check_lattice_profiles(options, &surfaces, bodies, checker);
                }
                AirOptions::Strips(StripOptions { tip_loss: Some(line), .. }) => {
                    check_lifting_line(line, &surfaces, bodies, checker);
                }
                AirOptions::Strips(_) | AirOptions::SlenderBody(_) => {}
                AirOptions::Rotor(options) => check_rotor(options, &surfaces, bodies, checker),
            }
            check_sound(&part.options, &surfaces, bodies, checker);
        }
    }
    check_flaps(air, checker);
    names("gust", air.gusts.iter().map(|gust| gust.name.as_str()), checker);
    for gust in &air.gusts {
        check_gust(gust, checker);
    }
}

fn check_sound(options: &AirOptions, surfaces: &[LiftingSurface], bodies: &[Body], checker: &mut Checker) {
    let sound_m_s = match options {
        AirOptions::Lattice(options) => options.speed_of_sound_m_s,
        AirOptions::Strips(options) => options.speed_of_sound_m_s,
        AirOptions::Rotor(_) | AirOptions::SlenderBody(_) => None,
    };
    let Some(sound_m_s) = sound_m_s else { return };
    checker.number(&["air", "speed_of_sound_m_s"], sound_m_s, Range::Above(0.0));
    let polar = surfaces.iter().find(|surface| surface.profile.polar.is_some());
    if let Some(body) = polar.and_then(|surface| bodies.get(surface.body)) {
        let allowed =
            "either a polar measured at the actual Mach number without speed_of_sound_m_s, or lift_slope_1_rad with it";
        checker.refuse_state(&["surface", body.name.as_str(), "polar"], "a polar with a speed of sound", allowed);
    }
}

fn check_flaps(air: &Air, checker: &mut Checker) {
    for (index, flap) in air.flaps.iter().enumerate() {
        let place = |key| ["control_surface", flap.name.as_str(), key];
        let Some(surface) = air.surfaces.get(flap.surface) else {
            let allowed = format!("one of the {} surfaces, counted from 0", air.surfaces.len());
            checker.refuse_state(&place("surface"), format!("surface {}", flap.surface), allowed);
            continue;
        };
        let strips = surface.positions_m.len().saturating_sub(1);
        if flap.strips.is_empty() || flap.strips.end > strips {
            let allowed = format!("at least one of the strips from 0 to {strips}");
            checker.refuse_state(&place("strips"), format!("strips {:?}", flap.strips), allowed);
        }
        let meets = |other: &crate::aero::flap::Flap| {
            other.surface == flap.surface
                && other.strips.start < flap.strips.end
                && flap.strips.start < other.strips.end
        };
        if air.flaps[..index].iter().any(meets) {
            checker.refuse_state(
                &place("strips"),
                "a control surface that overlaps another one",
                "control surfaces side by side on a surface",
            );
        }
        if !(flap.hinge_fraction > 0.0 && flap.hinge_fraction < 1.0) {
            checker.refuse(&place("hinge_fraction"), flap.hinge_fraction, "a fraction of the chord > 0 and < 1");
        }
        if flap.downward.abs() != 1.0 {
            checker.refuse(&place("downward"), flap.downward, "1 or -1");
        }
        if !(flap.lower_rad..=flap.upper_rad).contains(&flap.command_rad) || flap.lower_rad >= flap.upper_rad {
            checker.refuse_state(
                &place("command_rad"),
                "limits that exclude the start value",
                "lower_rad <= command_rad <= upper_rad",
            );
        }
    }
}

/// Reports profiles that the lattice does not support with its options.
fn check_lattice_profiles(
    options: &LatticeOptions,
    surfaces: &[LiftingSurface],
    bodies: &[Body],
    checker: &mut Checker,
) {
    let name = |surface: &LiftingSurface| bodies.get(surface.body).map_or("", |body| body.name.as_str());
    for surface in surfaces.iter().filter(|surface| !surface.profile.is_thin()) {
        if options.load_rule == LoadRule::Bernoulli && surface.profile.polar.is_some() {
            let allowed =
                "a polar only with leading_edge_suction = true, because its lift and drag include the suction force";
            checker.refuse_state(&["surface", name(surface), "polar"], "a polar without suction", allowed);
        }
        if options.speed_of_sound_m_s.is_some() && surface.profile.polar.is_none() {
            let allowed = "with speed_of_sound_m_s only a thin plate; for other profile coefficients omit speed_of_sound_m_s and \
                 give the coefficients at the actual Mach number";
            checker.refuse_state(&["surface", name(surface)], "a profile with a speed of sound", allowed);
        }
    }
}

fn check_lattice(options: &LatticeOptions, surfaces: &[LiftingSurface], checker: &mut Checker) {
    let counted = checker.count(&["air", "wake_rows"], options.wake_rows, 1, 10_000);
    checker.count(&["air", "threads"], options.threads, 1, 256);
    checker.number(&["air", "core_radius_m"], options.core_radius_m, Range::Above(0.0));
    if let Some(normal) = &options.mirror_normal {
        unit_vector(&["air", "mirror_normal"], normal, checker);
    }
    if counted {
        let sizes = surfaces.iter().map(|surface| (surface.positions_m.len().saturating_sub(1), surface.chord_panels));
        lattice_size(sizes, options.wake_rows, checker);
    }
}

fn check_rotor(options: &RotorOptions, surfaces: &[LiftingSurface], bodies: &[Body], checker: &mut Checker) {
    if options.hub_body >= bodies.len() {
        let allowed = format!("one of the {} bodies, counted from 0", bodies.len());
        checker.refuse_state(&["air", "hub"], format!("body {}", options.hub_body), allowed);
    }
    unit_vector(&["air", "shaft_axis"], &options.shaft_axis, checker);
    checker.number(&["air", "hub_radius_m"], options.features.hub_radius_m, Range::Above(0.0));
    let sizes = |count: usize| surfaces.get(count).map(|surface| surface.positions_m.len());
    let fits = options.sections.len() == surfaces.len()
        && options.positions_m.iter().zip(surfaces).all(|(own, surface)| *own == surface.positions_m)
        && options.positions_m.len() == surfaces.len()
        && options.lengths_m.len() == surfaces.len()
        && options.sections_turn.len() == surfaces.len()
        && options
            .sections_turn
            .iter()
            .zip(surfaces)
            .all(|(turn, surface)| bodies.get(surface.body).is_none_or(|body| *turn == body.sections_turn()))
        && options.sections.iter().enumerate().all(|(blade, polars)| {
            Some(polars.len()) == sizes(blade) && polars.iter().all(|polar| *polar < options.polars.len())
        });
    if !fits {
        let allowed = "for every section of every surface its place and the index of its polar";
        checker.refuse_state(&["surface"], "blade sections that do not match the surfaces", allowed);
    }
    if let Some(polar) = options.polars.iter().position(|polar| !is_full_circle(&polar.rows)) {
        checker.refuse_state(&["polar"], format!("polar {polar}"), "polars from -pi to pi");
    }
    if options.hub_body < bodies.len() && surfaces.iter().all(|surface| surface.body < bodies.len()) {
        check_blades(options, surfaces, bodies, checker);
    }
}

/// Allowed deviation in rad of a blade from its azimuth about the shaft: the blades of real rotors are set to within a degree.
const PLACE_RAD: f64 = 5.0 * PI / 180.0;

/// Reports a rotor with a missing blade or a blade without a surface: momentum balances apply to annuli of equal blades with even spacing.
fn check_blades(options: &RotorOptions, surfaces: &[LiftingSurface], bodies: &[Body], checker: &mut Checker) {
    let turns = |body: usize| {
        let mut at = body;
        while at != options.hub_body {
            match bodies[at].joint.parent {
                Parent::Body { index, .. } if index < at => at = index,
                Parent::Root { .. } | Parent::Body { .. } => return false,
            }
        }
        true
    };
    // for example the wings of an aircraft, or a second rotor
    if let Some(other) = surfaces.iter().find(|surface| surface.body < bodies.len() && !turns(surface.body)) {
        let found =
            format!("{}, which is not attached to the hub {}", bodies[other.body].name, bodies[options.hub_body].name);
        let allowed = "only surfaces on bodies that the hub carries; another rotor, or strips on a wing, is a part of its own, \
                       [aerodynamics.<name>]";
        checker.refuse_state(&["surface"], found, allowed);
        return;
    }
    let has_surface = |body: usize| surfaces.iter().any(|surface| surface.body == body);
    let alike = |a: &Body, b: &Body| a.length_m == b.length_m && a.elements == b.elements && a.section == b.section;
    let bare = (0..bodies.len()).filter(|&body| !has_surface(body) && bodies[body].length_m > 0.0 && turns(body));
    for body in bare {
        if let Some(surface) = surfaces.iter().find(|surface| alike(&bodies[surface.body], &bodies[body])) {
            let (name, blade) = (&bodies[body].name, &bodies[surface.body].name);
            let allowed = "a surface on every blade of a rotor; body = \"blade\" denotes all copies of a blade";
            checker.refuse_state(&["surface"], format!("{name}, a blade like {blade}, without a surface"), allowed);
            return;
        }
    }
    let frames = first_frames(bodies, |joint| joint.start_angle_rad);
    let axis = frames[options.hub_body].attitude * options.shaft_axis;
    let across = |surface: &LiftingSurface| {
        let along: Vector3<f64> = frames[surface.body].attitude.column(0).into();
        along - axis * along.dot(&axis)
    };
    let Some(first) = surfaces.first() else { return };
    let zero = across(first);
    let mut angles: Vec<(f64, usize)> = surfaces
        .iter()
        .map(|surface| {
            let own = across(surface);
            let angle_rad = axis.dot(&zero.cross(&own)).atan2(zero.dot(&own)).rem_euclid(TAU);
            (if TAU - angle_rad < PLACE_RAD { 0.0 } else { angle_rad }, surface.body)
        })
        .collect();
    angles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let apart_rad = TAU / angles.len() as f64;
    let off =
        angles.iter().enumerate().find(|(k, (angle_rad, _))| (angle_rad - *k as f64 * apart_rad).abs() > PLACE_RAD);
    if let Some((_, (angle_rad, body))) = off {
        let (name, first) = (&bodies[*body].name, &bodies[first.body].name);
        let found = format!("{name} {:.1} deg from {first} about the shaft", angle_rad.to_degrees());
        let allowed = format!(
            "blades evenly spaced about the shaft, {:.1} deg apart for {} blades: is one missing, or is an angle wrong?",
            apart_rad.to_degrees(),
            angles.len()
        );
        checker.refuse_state(&["surface"], found, allowed);
    }
}

fn check_lifting_line(line: &LiftingLineOptions, surfaces: &[LiftingSurface], bodies: &[Body], checker: &mut Checker) {
    checker.number(&["air", "core_radius_m"], line.core_radius_m, Range::Above(0.0));
    if let Some(normal) = &line.mirror_normal {
        unit_vector(&["air", "mirror_normal"], normal, checker);
    }
    let strips: usize = surfaces.iter().map(|surface| surface.positions_m.len().saturating_sub(1)).sum();
    if strips > MAXIMUM_STRIPS {
        let allowed = format!("at most {MAXIMUM_STRIPS} strips of all surfaces together with a tip loss");
        checker.refuse_state(&["surface"], format!("{strips} strips with a tip loss"), allowed);
    }
    let polar = surfaces.iter().find(|surface| surface.profile.polar.is_some());
    if let Some(body) = polar.and_then(|surface| bodies.get(surface.body)) {
        let allowed = "lift_slope_1_rad with a tip loss, because the lifting line needs a lift that is linear in the \
                       downwash; or strips without tip loss";
        checker.refuse_state(&["surface", body.name.as_str(), "polar"], "a polar with a tip loss", allowed);
    }
}

/// Reports lattices that need too much memory or time, by the strips and chord panels of their surfaces.
pub(crate) fn lattice_size(
    surfaces: impl Iterator<Item = (usize, usize)>,
    wake_rows: usize,
    checker: &mut Checker,
) -> bool {
    let (mut panels, mut strips) = (0_usize, 0_usize);
    for (own, along_chord) in surfaces {
        panels = panels.saturating_add(own.saturating_mul(along_chord));
        strips = strips.saturating_add(own);
    }
    let wake_panels = wake_rows.saturating_mul(strips);
    if panels > MAXIMUM_PANELS {
        let allowed = format!("at most {MAXIMUM_PANELS} panels: strips times chord_panels, of all surfaces together");
        checker.refuse_state(&["surface"], format!("a lattice of {panels} panels"), allowed);
    } else if wake_panels > MAXIMUM_WAKE_PANELS {
        let allowed = format!("at most {MAXIMUM_WAKE_PANELS} panels: wake_rows times the strips of all surfaces");
        checker.refuse_state(&["air", "wake_rows"], format!("a wake of {wake_panels} panels"), allowed);
    } else {
        return true;
    }
    false
}

fn check_surface(
    index: usize,
    surface: &LiftingSurface,
    surfaces: &[LiftingSurface],
    bodies: &[Body],
    checker: &mut Checker,
) {
    let Some(body) = bodies.get(surface.body) else {
        let allowed = format!("one of the {} bodies, counted from 0", bodies.len());
        checker.refuse_state(&["surface"], format!("a surface on body {}", surface.body), allowed);
        return;
    };
    let name = body.name.as_str();
    if surfaces[..index].iter().any(|other| other.body == surface.body) {
        checker.refuse(&["surface", name, "body"], format!("{name:?}"), "a body without a surface");
    }
    if index > 0 && surfaces[index - 1].body > surface.body {
        let allowed = "surfaces in the order of their bodies";
        checker.refuse_state(&["surface", name], "a surface behind that of a later body", allowed);
    }
    if let Some(half) = surface.other_half.filter(|half| !surfaces.iter().any(|other| other.body == *half)) {
        let allowed = "a body with a surface";
        checker.refuse_state(&["surface", name, "other_half"], format!("body {half}"), allowed);
    }
    let positions_m = &surface.positions_m;
    let strips = positions_m.len().saturating_sub(1);
    checker.count(&["surface", name, "strips"], strips, 1, MAXIMUM_STRIPS);
    checker.count(&["surface", name, "chord_panels"], surface.chord_panels, 1, MAXIMUM_STRIPS);
    let ascending = positions_m.windows(2).all(|pair| pair[0] < pair[1]);
    // a rigid body has no length; its chords are measured from its frame
    let length_m = if body.is_rigid() { f64::INFINITY } else { body.length_m };
    let on_body = positions_m.iter().all(|s| (0.0..=length_m * (1.0 + 1e-12)).contains(s));
    if !(ascending && on_body) {
        let allowed = format!("ascending lengths from 0 to {} m, the length of the body", body.length_m);
        checker.refuse(&["surface", name, "positions_m"], array_text(positions_m), allowed);
    }
    let lengths: Vec<f64> = surface.chords.iter().map(|chord| chord.length_m()).collect();
    if lengths.len() != positions_m.len() || !lengths.iter().all(|length| *length > 0.0 && is_finite(*length)) {
        let allowed = "a chord of finite length > 0 m at every edge of the strips";
        checker.refuse(&["surface", name, "chords"], array_text(&lengths), allowed);
    }
    check_profile(name, surface, checker);
}

fn check_profile(name: &str, surface: &LiftingSurface, checker: &mut Checker) {
    let profile = &surface.profile;
    let place = |key| ["surface", name, key];
    checker.number(&place("lift_slope_1_rad"), profile.lift_slope_1_rad, Range::AtLeast(0.0));
    let slopes = &profile.lift_slopes_1_rad;
    let strips = surface.positions_m.len().saturating_sub(1);
    let counted = slopes.is_empty() || slopes.len() == strips;
    if !counted || slopes.iter().any(|slope| !(*slope >= 0.0 && is_finite(*slope))) {
        let allowed = "a finite slope >= 0 for every strip";
        checker.refuse(&place("lift_slope_1_rad"), array_text(slopes), allowed);
    }
    checker.number(&place("drag_coefficient"), profile.drag_coefficient, Range::AtLeast(0.0));
    checker.number(&place("moment_coefficient"), profile.moment_coefficient, Range::Finite);
    checker.number(&place("zero_lift_angle_rad"), profile.zero_lift_angle_rad, Range::Finite);
    let Some(polar) = &profile.polar else { return };
    let rows = &polar.rows;
    let numbers = rows.iter().flat_map(|row| [row.angle_rad, row.lift, row.drag, row.moment]);
    let finite = (1..=1000).contains(&rows.len()) && numbers.into_iter().all(is_finite);
    let ascending = rows.windows(2).all(|pair| pair[0].angle_rad < pair[1].angle_rad);
    if !(finite && ascending && rows.iter().all(|row| row.angle_rad.abs() <= PI)) {
        let allowed = "1 to 1000 rows (angle of attack in rad, lift, drag, moment coefficient) of finite numbers with angles \
                       ascending from -pi to pi";
        let angles: Vec<f64> = rows.iter().map(|row| row.angle_rad).collect();
        checker.refuse(&place("polar"), format!("angles {}", array_text(&angles)), allowed);
    }
}

fn check_gust(gust: &Gust, checker: &mut Checker) {
    let place = |key| ["gust", gust.name.as_str(), key];
    unit_vector(&place("direction"), &gust.direction, checker);
    checker.array(&place("velocity_m_s"), gust.velocity_m_s.as_slice());
    checker.array(&place("origin_m"), gust.origin_m.as_slice());
    checker.number(&place("start_s"), gust.start_s, Range::Finite);
    checker.number(&place("speed_m_s"), gust.speed_m_s, Range::Above(0.0));
    match &gust.shape {
        GustShape::SharpEdge => {}
        GustShape::OneMinusCosine { length_m } => {
            checker.number(&place("length_m"), *length_m, Range::Above(0.0));
        }
        GustShape::Table(rows) => {
            let finite = (1..=100_000).contains(&rows.len()) && rows.iter().flatten().copied().all(is_finite);
            if !(finite && rows.windows(2).all(|pair| pair[0][0] < pair[1][0])) {
                let distances: Vec<f64> = rows.iter().map(|row| row[0]).collect();
                let allowed = "1 to 100000 rows [distance in m, fraction] of finite numbers with ascending distances";
                checker.refuse(&place("table"), format!("distances {}", array_text(&distances)), allowed);
            }
        }
        GustShape::Turbulence(series) => {
            checker.number(&place("resolution_m"), series.spacing_m, Range::Above(0.0));
            checker.array(&place("values"), &[series.begin_m]);
            if series.values.len() < 4 || !series.values.iter().copied().all(is_finite) {
                let count = format!("{} values", series.values.len());
                checker.refuse(&place("values"), count, "at least 4 finite numbers");
            }
        }
    }
}
