//! Builds the bodies of the model file: mesh, sections and initial shape along them, load stations.

use crate::body_file::{BodyFile, RigidBodyFile};
use crate::checker::Checker;
use crate::function::{FunctionFile, along_body};
use crate::sections::{Built, Sections};
use crate::shaped;
use crate::stations::Stations;
use foldwing_engine::beam::axis::NaturalShape;
use foldwing_engine::beam::law::{SectionLaw, SectionStation};
use foldwing_engine::beam::profile::Profile;
use foldwing_engine::beam::section::{Material, Section, Solid};
use foldwing_engine::machine::Body;
use foldwing_engine::machine::builder::BodyBuilder;
use foldwing_engine::machine::units::shortest;
use foldwing_engine::math::strain::{EDGE, FLAP, NAMES, STRAINS, TWIST};
use nalgebra::Matrix3;

/// Builds a body. Invalid parts are replaced by defaults, for example if the section law is `None`.
pub(super) fn build(name: &str, file: &BodyFile, law: Option<SectionLaw>, checker: &mut Checker) -> BodyBuilder {
    if law.is_none() {
        for key in ["section", "width_taper", "height_taper", "outer_section"] {
            checker.stands_in(&["body", name, key]);
        }
    }
    let law = law.unwrap_or_else(|| Solid::rectangle(1.0, 1.0, Material::isotropic(1.0, 0.0, 1.0)).into());
    let mut body = Body::beam(name, file.length_m, law)
        .element(file.element.into())
        .elements(file.elements)
        .mass_damping_1_s(file.mass_damping_1_s)
        .damp_attached_masses(file.damp_attached_masses)
        .stiffness_damping_s(file.stiffness_damping_s)
        .stiffness_damping_factors(file.stiffness_damping_factors.unwrap_or([1.0; STRAINS]))
        .shear_damping_factors(file.shear_damping_factors.unwrap_or([1.0; 2]))
        .modal_damping_ratios(file.modal_damping_ratios.clone())
        .load_frame(file.load_frame.into());
    if file.shear_damping_factors.is_some() && !file.shear {
        checker.refuse(&["body", name, "shear_damping_factors"], "this key only on a body with shear = true");
    }
    if file.axis.is_some() || file.axis_file.is_some() {
        if let Some(shape) = natural_shape(name, file, checker) {
            body = body.natural_shape(shape);
        }
    } else if let Some(curvature_1_m) = natural_curvature(name, file, checker) {
        body = body.natural_curvature_along_1_m(curvature_1_m);
    }
    if let (Some(_), Some(_)) = (&file.load_station_positions_m, file.load_stations) {
        let allowed = "either load_stations or load_station_positions_m, not both";
        checker.refuse(&["body", name, "load_station_positions_m"], allowed);
    }
    match (&file.load_station_positions_m, file.load_stations) {
        (Some(positions_m), _) => body.load_station_positions_m(positions_m.as_slice()),
        (None, Some(count)) => body.load_stations(count),
        (None, None) => body,
    }
}

/// Builds a rigid body.
pub(super) fn build_rigid(name: &str, file: &RigidBodyFile) -> BodyBuilder {
    let body = Body::rigid(name).load_frame(file.load_frame.into());
    if file.mass_kg == 0.0 && file.inertia_kg_m2 == [0.0; 6] {
        return body;
    }
    let [xx, yy, zz, xy, xz, yz] = file.inertia_kg_m2;
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let body = body.inertia(file.mass_kg, file.centre_of_mass_m, tensor);
    if file.allow_nonphysical_inertia { body.allow_nonphysical_inertia() } else { body }
}

/// Section law along the body, with or without shear deformation; `None` after an error.
pub(super) fn section_law(
    name: &str,
    file: &BodyFile,
    sections: &Sections,
    checker: &mut Checker,
) -> Option<SectionLaw> {
    let law = own_law(name, file, sections, checker)?.with_shear(file.shear);
    if law.is_none() {
        let found = format!("true with section {:?}", file.section);
        let allowed = "sections with a shear stiffness: solid ones and shapes whose shear modulus is known, shear_stiffness_N, \
                       stiffness_with_shear_SI, tables with shear_stiffness_y_N and shear_stiffness_z_N, files with 6×6 matrices";
        checker.refuse_as(&["body", name, "shear"], found, allowed);
    }
    law
}

/// Section law along the body: uniform, tapered, or between two named sections; `None` after an error.
fn own_law(name: &str, file: &BodyFile, sections: &Sections, checker: &mut Checker) -> Option<SectionLaw> {
    let mut named = |key: &str, section: &str| {
        let found = sections.get(section);
        if found.is_none() {
            checker.unknown_name(&["body", name, key], section, "a section", sections.keys().copied());
        }
        found.and_then(Option::as_ref)
    };
    let inner = named("section", &file.section);
    let outer = file.outer_section.as_ref().map(|section| named("outer_section", section));
    let tapers = [("width_taper", &file.width_taper), ("height_taper", &file.height_taper)];
    let [width, height] = tapers.map(|(key, taper)| taper_law(name, file, key, taper.as_ref(), checker));
    let tapered = tapers.iter().find(|(_, taper)| taper.is_some());
    if let (Some((key, _)), true) = (tapered, outer.is_some()) {
        checker.refuse(&["body", name, key], "either outer_section or width_taper and height_taper, not both");
        return None;
    }
    let inner = inner?;
    if let (Built::Table(_), Some((key, _))) = (inner, tapered) {
        checker.refuse(
            &["body", name, key],
            "a body whose section is not a table; a table gives the properties at each station",
        );
        return None;
    }
    let is_table = |built: &Built| matches!(built, Built::Table(_));
    if let Some(outer) = &outer
        && (is_table(inner) || outer.is_some_and(is_table))
    {
        checker.refuse(&["body", name, "outer_section"], "sections that are not tables; a table covers the whole body");
        return None;
    }
    if let Built::Table(stations) = inner {
        return table_law(name, file, stations, checker);
    }
    if let Some(outer) = outer {
        let outer = outer?;
        for (key, section, built) in
            [("section", Some(&file.section), inner), ("outer_section", file.outer_section.as_ref(), outer)]
        {
            if let (Built::Shape(shape), Some(section)) = (built, section)
                && !shape.is_constant()
            {
                let found = format!("section {section:?}, whose dimensions vary along the body");
                checker.refuse_as(
                    &["body", name, key],
                    found,
                    "sections of constant dimensions, if the body has an outer_section",
                );
                return None;
            }
        }
        let (inner, outer) = (inner.section()?, outer.section()?);
        return Some(SectionLaw::between(inner, outer, file.length_m));
    }
    match (inner, tapered) {
        (Built::Solid(solid), _) => Some(SectionLaw::Tapered { solid: *solid, width: width?, height: height? }),
        (Built::Explicit(section), None) => Some(section.clone().into()),
        (Built::Explicit(_), Some((key, _))) => {
            let allowed = "a body whose section is a rectangle or an ellipse; other sections vary by outer_section";
            checker.refuse(&["body", name, key], allowed);
            None
        }
        (Built::Shape(shape), None) => shape
            .law(file.length_m)
            .inspect_err(|refused| shaped::refuse(&file.section, Some(name), refused, checker))
            .ok(),
        (Built::Shape(_), Some((key, _))) => {
            let allowed = "a body whose section is a rectangle or an ellipse; the dimensions of other shapes vary by \
                           { table = [[s, value], …] } in the section";
            checker.refuse(&["body", name, key], allowed);
            None
        }
        (Built::Table(_), _) => None, // handled above
    }
}

/// Section law from a table whose sections are placed on a body from end to end.
fn table_law(name: &str, file: &BodyFile, stations: &Stations, checker: &mut Checker) -> Option<SectionLaw> {
    let positions_m = match stations.places.on_body(file.length_m) {
        Ok(positions_m) => positions_m,
        Err(last_m) => {
            let allowed = format!("{} m, the last station of section {:?}", shortest(last_m), file.section);
            checker.refuse(&["body", name, "length_m"], allowed);
            return None;
        }
    };
    let station = |(position_m, section): (f64, &Section)| SectionStation { position_m, section: section.clone() };
    Some(SectionLaw::Table(positions_m.into_iter().zip(&stations.sections).map(station).collect()))
}

/// Unloaded shape given by the axis in the file; `None` after an error.
fn natural_shape(name: &str, file: &BodyFile, checker: &mut Checker) -> Option<NaturalShape> {
    let rivals = ["natural_curvature_1_m", "twist_1_m", "curvature_y_1_m", "curvature_z_1_m"];
    if let Some(key) = rivals.into_iter().find(|key| checker.states(&["body", name, key])) {
        checker.refuse(&["body", name, key], "either an axis or curvatures, not both");
        return None;
    }
    let axis = match (&file.axis, &file.axis_file) {
        (Some(axis), None) => axis,
        (Some(_), Some(_)) => {
            checker.refuse(&["body", name, "axis_file"], "either axis or axis_file, not both");
            return None;
        }
        _ => {
            let allowed = "a file name, if the model itself is read from a file; a model given as text must have axis";
            checker.refuse(&["body", name, "axis_file"], allowed);
            return None;
        }
    };
    let axis = axis.on_body(name, file.length_m, checker)?;
    match axis.natural_shape() {
        Ok(shape) => Some(shape),
        Err(steep) => {
            let found = format!("an axis with no extent along x at {} m", shortest(steep.position_m));
            let allowed =
                "points no further apart than the arc length between them, and an axis at less than 90 deg from x";
            checker.refuse_as(&["body", name, "axis"], found, allowed);
            None
        }
    }
}

/// Factor as a function along the body; 1 by default.
fn taper_law(
    name: &str,
    file: &BodyFile,
    key: &str,
    taper: Option<&FunctionFile>,
    checker: &mut Checker,
) -> Option<Profile> {
    match taper {
        None => Some(Profile::constant(1.0)),
        Some(FunctionFile::Number(outer)) => Some(Profile::linear(1.0, *outer, file.length_m)),
        Some(taper) => along_body(&["body", name, key], taper, checker),
    }
}

/// Initial twist and curvatures along the body; `None` after an error.
fn natural_curvature(name: &str, file: &BodyFile, checker: &mut Checker) -> Option<[Profile; 3]> {
    let functions = [
        (NAMES[TWIST].key, &file.twist_1_m),
        (NAMES[FLAP].key, &file.curvature_y_1_m),
        (NAMES[EDGE].key, &file.curvature_z_1_m),
    ];
    let stated = functions.iter().find(|(_, function)| function.is_some());
    if let (Some((key, _)), true) = (stated, checker.states(&["body", name, "natural_curvature_1_m"])) {
        let allowed = "either natural_curvature_1_m or twist_1_m, curvature_y_1_m and curvature_z_1_m, not both";
        checker.refuse(&["body", name, key], allowed);
        return None;
    }
    let mut profiles = file.natural_curvature_1_m.map(|curvature| Some(Profile::constant(curvature)));
    for (profile, (key, function)) in profiles.iter_mut().zip(functions) {
        if let Some(function) = function {
            *profile = along_body(&["body", name, key], function, checker);
        }
    }
    let [Some(twist), Some(y), Some(z)] = profiles else { return None };
    Some([twist, y, z])
}
