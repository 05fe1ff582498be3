//! Checks of bodies: mesh, section and natural shape along them, load stations, masses.

use crate::beam::law::{NaturalStrain, SectionLaw, SectionStation};
use crate::beam::profile::Profile;
use crate::beam::section::Section;
use crate::machine::fault::{Checker, Range, array_text, is_finite};
use crate::machine::units::shortest;
use crate::machine::validate::MAXIMUM_STATIONS_OF_BODY;
use crate::machine::validate::modal;
use crate::machine::validate::profile::{least_of, profile};
use crate::machine::validate::section::{
    asymmetry, has_second_moments, is_not_negative, is_positive_definite, is_rigid_body, is_sound,
};
use crate::machine::{AttachedMass, Body, ElementKind};
use crate::math::strain::{CURVATURES, NAMES, SHEARED, STRAINS, STRETCH, TWIST, joined_words};
use crate::multibody::mode_damping::MAXIMUM_DAMPED_MODES;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Maximum number of sections along one body.
pub(crate) const MAXIMUM_SECTION_STATIONS: usize = 1000;

/// Checks a body without its joint.
pub(super) fn check(body: &Body, checker: &mut Checker) {
    let name = body.name.as_str();
    if name == "root" {
        let allowed = "another name: \"root\" is reserved for the frame that carries the wing";
        checker.refuse_state(&["body", name], "the name \"root\"", allowed);
    }
    if body.is_rigid() {
        rigid(body, checker);
        return;
    }
    let long = checker.number(&["body", name, "length_m"], body.length_m, Range::Above(0.0));
    let meshed = checker.count(&["body", name, "elements"], body.elements, 1, 1000);
    checker.number(&["body", name, "mass_damping_1_s"], body.mass_damping_1_s, Range::AtLeast(0.0));
    checker.number(&["body", name, "stiffness_damping_s"], body.stiffness_damping_s, Range::AtLeast(0.0));
    let shares = body.stiffness_damping_factors.as_slice();
    if !shares.iter().all(|share| is_finite(*share) && *share >= 0.0) {
        let allowed = format!("{} finite factors >= 0, of {}", shares.len(), joined_words());
        checker.refuse(&["body", name, "stiffness_damping_factors"], array_text(shares), allowed);
    }
    let shares = &body.shear_damping_factors;
    if !shares.iter().all(|share| is_finite(*share) && *share >= 0.0) {
        let allowed = "2 finite factors >= 0, for shear in y and in z";
        checker.refuse(&["body", name, "shear_damping_factors"], array_text(shares), allowed);
    }
    let ratios = &body.modal_damping_ratios;
    let strains = if body.has_shear() { SHEARED } else { STRAINS };
    // the number of elements is checked elsewhere and may be absurd here
    let parts = body.elements.saturating_mul(if body.element == ElementKind::Linear { 2 } else { 1 });
    let most = if body.is_modal() { 0 } else { MAXIMUM_DAMPED_MODES.min(parts.saturating_mul(strains)) };
    if ratios.len() > most || !ratios.iter().all(|ratio| is_finite(*ratio) && *ratio >= 0.0) {
        let allowed =
            format!("up to {most} finite ratios >= 0: one per strain of a beam, no more than {MAXIMUM_DAMPED_MODES}");
        checker.refuse(&["body", name, "modal_damping_ratios"], array_text(ratios), allowed);
    }
    if !long {
        return; // a rigid body has no further attachments to check
    }
    if let Some(law) = body.section.modal() {
        modal::check(body, law, checker);
        stations(body, checker);
        for mass in &body.masses {
            attached_mass(mass, body, checker);
        }
        return;
    }
    section_law(body, checker);
    natural_strain(body, meshed, checker);
    stations(body, checker);
    for mass in &body.masses {
        attached_mass(mass, body, checker);
    }
}

/// Checks a body without elements, whose masses and loads act on its frame.
fn rigid(body: &Body, checker: &mut Checker) {
    let name = body.name.as_str();
    if body.length_m != 0.0 {
        // probably intended as a beam, with the number of elements missing
        checker.count(&["body", name, "elements"], body.elements, 1, 1000);
        return;
    }
    for (key, value) in [("mass_damping_1_s", body.mass_damping_1_s), ("stiffness_damping_s", body.stiffness_damping_s)]
    {
        if value != 0.0 {
            checker.refuse(&["body", name, key], shortest(value), "0 on a rigid body, which does not bend");
        }
    }
    if !body.modal_damping_ratios.is_empty() {
        let allowed = "no ratios on a rigid body, which does not bend";
        checker.refuse(&["body", name, "modal_damping_ratios"], array_text(&body.modal_damping_ratios), allowed);
    }
    stations(body, checker);
    for mass in &body.masses {
        attached_mass(mass, body, checker);
    }
}

/// Whether the section of a body has no errors, so that checks that depend on it are possible.
pub(crate) fn section_stands(name: &str, checker: &Checker) -> bool {
    let keys = ["section", "outer_section", "width_taper", "height_taper"];
    let fell = |place: &[String]| place[0] == "body" && place[1] == name && keys.contains(&place[2].as_str());
    !checker.faults.iter().any(|fault| fault.place.0.len() > 2 && fell(&fault.place.0))
}

/// Checks the section along the body.
fn section_law(body: &Body, checker: &mut Checker) {
    let (name, length_m) = (body.name.as_str(), body.length_m);
    match &body.section {
        SectionLaw::Uniform(section) => explicit(&["body", name, "section"], section, checker),
        SectionLaw::Table(stations) => table(name, stations, length_m, checker),
        // checked separately
        SectionLaw::Modal(_) => {}
        SectionLaw::Tapered { width, height, .. } => {
            let tapers = [("width_taper", width), ("height_taper", height)];
            for (key, taper) in tapers {
                let place = ["body", name, key];
                if !profile(&place, taper, length_m, checker) {
                    return;
                }
                let least = least_of(taper, length_m);
                if least.is_nan() || least <= 0.0 {
                    checker.refuse_state(
                        &place,
                        format!("a factor that falls to {} on the body", shortest(least)),
                        "a factor > 0 all along the body",
                    );
                    return;
                }
            }
            let law = &body.section;
            if !law.samples_m(length_m).iter().all(|s| is_sound(&law.at(*s))) {
                let allowed = "factors that leave mass, inertia and stiffness positive, finite numbers in SI";
                checker.refuse_state(&["body", name, "section"], "a section of such dimensions", allowed);
            }
        }
    }
}

/// Checks a section given by its stiffness and inertia.
fn explicit(place: &[&str], section: &Section, checker: &mut Checker) {
    if let Some((i, j)) = asymmetry(&section.stiffness) {
        let (lower, upper) = (section.stiffness[(i, j)], section.stiffness[(j, i)]);
        let found =
            format!("{lower} in row {}, column {} and {upper} in row {}, column {}", i + 1, j + 1, j + 1, i + 1);
        checker.refuse_state(&[place, &["stiffness"]].concat(), found, "a symmetric matrix");
    } else if !is_sound(section) {
        let allowed = "mass, inertia and stiffness that are positive, finite numbers in SI";
        checker.refuse_state(place, "a section of such properties", allowed);
    } else if !is_positive_definite(&section.stiffness) {
        let allowed = "a symmetric positive definite matrix";
        let found = "a matrix that is not positive definite";
        checker.refuse_state(&[place, &["stiffness"]].concat(), found, allowed);
    } else if section.shear.is_some_and(|whole| asymmetry(&whole).is_some() || !is_positive_definite(&whole)) {
        let found = "a stiffness with shear that is not symmetric and positive definite";
        checker.refuse_state(&[place, &["shear"]].concat(), found, "a symmetric positive definite matrix");
    } else if !has_second_moments(section) {
        let allowed =
            "[yy, yz, zz] in kg·m with yy >= 0, zz >= 0, yy + zz > 0 and yz² <= yy zz about the centre of mass";
        checker.refuse(&[place, &["second_moment_kg_m"]].concat(), array_text(&section.second_moment_kg_m), allowed);
    }
    let outline = [section.half_width_m, section.half_height_m];
    if !outline.iter().all(|half| (0.0..=f64::MAX).contains(half)) {
        let allowed = "half width and half height >= 0 m, 0 where the outline is not known";
        checker.refuse(&[place, &["half_width_m"]].concat(), array_text(&outline), allowed);
    }
}

/// Checks sections at stations, which must extend from end to end. With two stations, the outer one is that of `outer_section`.
fn table(name: &str, stations: &[SectionStation], length_m: f64, checker: &mut Checker) {
    let positions_m: Vec<f64> = stations.iter().map(|station| station.position_m).collect();
    let ascending = positions_m.windows(2).all(|pair| pair[0] < pair[1]);
    let ends = positions_m.first() == Some(&0.0) && positions_m.last() == Some(&length_m) && positions_m.len() > 1;
    if !(ascending && ends && positions_m.len() <= MAXIMUM_SECTION_STATIONS) {
        let allowed = format!(
            "2 to {MAXIMUM_SECTION_STATIONS} positions that ascend from 0 to {} m, the length of the body",
            shortest(length_m)
        );
        checker.refuse(&["body", name, "section", "position_m"], array_text(&positions_m), allowed);
        return;
    }
    let sheared = stations.iter().filter(|station| station.section.shear.is_some()).count();
    if sheared != 0 && sheared != stations.len() {
        let found = format!("{sheared} of {} sections with shear", stations.len());
        checker.refuse_state(&["body", name, "section"], found, "shear in all sections of a table or in none");
        return;
    }
    for (index, station) in stations.iter().enumerate() {
        let found = checker.faults.len();
        let key = if stations.len() == 2 && index == 1 { "outer_section" } else { "section" };
        explicit(&["body", name, key], &station.section, checker);
        if checker.faults.len() > found {
            return; // already reported
        }
    }
}

/// Checks the natural strain along the body. The rotation of an element must stay below π, the limit for a unique rotation vector.
fn natural_strain(body: &Body, meshed: bool, checker: &mut Checker) {
    let (name, length_m, strain) = (body.name.as_str(), body.length_m, &body.natural_strain);
    let mut sound = true;
    for (called, component) in NAMES.iter().zip(&strain.0) {
        sound &= profile(&["body", name, called.key], component, length_m, checker);
    }
    if !(sound && meshed) {
        return;
    }
    let stretch = least_of(&strain.0[STRETCH], length_m);
    if stretch.is_nan() || stretch <= -1.0 {
        let allowed = "a stretch > -1 all along the body";
        checker.refuse_state(
            &["body", name, NAMES[STRETCH].key],
            format!("a stretch of {}", shortest(stretch)),
            allowed,
        );
    }
    let limit = PI * body.elements as f64 / length_m;
    let (largest, place_m) = largest_curvature(strain, length_m);
    if largest < limit {
        return;
    }
    let place = ["body", name, "natural_strain"];
    let allowed = format!("curvatures of a magnitude < {limit:.4} 1/m, which is half a revolution per element");
    if strain.0.iter().all(Profile::is_constant) {
        let values: Vec<f64> = strain.0[CURVATURES].iter().map(|curvature| curvature.at(0.0)).collect();
        checker.refuse(&place, array_text(&values), allowed);
    } else {
        let found = format!("a curvature of {largest:.4} 1/m at {} m", shortest(place_m));
        checker.refuse_state(&place, found, allowed);
    }
}

/// Largest curvature along a body in 1/m and its position in m.
fn largest_curvature(strain: &NaturalStrain, length_m: f64) -> (f64, f64) {
    let size = |s: f64| Vector3::from_fn(|i, _| strain.0[TWIST + i].at(s)).norm();
    let samples = strain.0.iter().flat_map(|profile| profile.samples_m(length_m));
    samples.map(|s| (size(s), s)).fold((0.0, 0.0), |a, b| if b.0 > a.0 || b.0.is_nan() { b } else { a })
}

fn stations(body: &Body, checker: &mut Checker) {
    let (name, positions_m) = (body.name.as_str(), &body.station_positions_m);
    let place = ["body", name, "station_positions_m"];
    let ascending = positions_m.windows(2).all(|pair| pair[0] < pair[1]);
    let on_body = positions_m.iter().all(|position| (0.0..=body.length_m).contains(position));
    if positions_m.len() > MAXIMUM_STATIONS_OF_BODY {
        let allowed = format!("at most {MAXIMUM_STATIONS_OF_BODY} load stations on a body");
        checker.refuse_state(&place, format!("{} load stations", positions_m.len()), allowed);
    } else if !(ascending && on_body) {
        let length = shortest(body.length_m);
        let allowed = format!("ascending lengths from 0 to {length} m, the length of the body");
        checker.refuse(&place, array_text(positions_m), allowed);
    }
    if body.station_loads.len() > positions_m.len() {
        let allowed = format!("at most {}, one per load station", positions_m.len());
        let found = format!("{} loads", body.station_loads.len());
        checker.refuse_state(&["body", name, "station_loads"], found, allowed);
    }
    for load in &body.station_loads {
        checker.array(&["body", name, "station_loads", "force_n"], load.force_n.as_slice());
        checker.array(&["body", name, "station_loads", "moment_n_m"], load.moment_n_m.as_slice());
    }
}

fn attached_mass(mass: &AttachedMass, body: &Body, checker: &mut Checker) {
    let name = mass.name.as_str();
    checker.on_body(&["mass", name, "position_m"], mass.position_m, body.length_m);
    // an inertia about one axis may belong to a body whose mass is not modelled
    let least = if mass.allow_nonphysical_inertia { Range::AtLeast(0.0) } else { Range::Above(0.0) };
    checker.number(&["mass", name, "mass_kg"], mass.mass_kg, least);
    checker.array(&["mass", name, "offset_m"], mass.offset_m.as_slice());
    let tensor = &mass.inertia_kg_m2;
    let symmetric = (tensor - tensor.transpose()).amax() <= 1e-9 * tensor.amax();
    let possible = if mass.allow_nonphysical_inertia { is_not_negative(tensor) } else { is_rigid_body(tensor) };
    if !(tensor.iter().copied().all(is_finite) && symmetric && possible) {
        let parts = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|place| tensor[place]);
        let allowed = match mass.allow_nonphysical_inertia {
            true => "[Ixx, Iyy, Izz, Ixy, Ixz, Iyz] in kg·m² with principal moments >= 0",
            false => {
                "[Ixx, Iyy, Izz, Ixy, Ixz, Iyz] in kg·m² with principal moments >= 0, none larger than the sum of the \
                 other two"
            }
        };
        checker.refuse(&["mass", name, "inertia_kg_m2"], array_text(&parts), allowed);
    }
}
