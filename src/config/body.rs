//! Bodies of the file: mesh, sections and natural shape along them, load stations.

use crate::beam::law::{NaturalStrain, SectionLaw};
use crate::beam::profile::Profile;
use crate::config::function::{FunctionFile, along_body};
use crate::config::schema::shortest;
use crate::config::sections::{Built, Sections, is_sound};
use crate::config::validate::Checker;
use crate::load::{LoadFrame, Wrench};
use crate::machine::{AttachedMass, Body, ElementKind, Joint};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A beam.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyFile {
    /// Arc length of the undeformed axis.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: f64,
    /// Name of the cross-section, at the inner end where it varies.
    pub section: String,
    /// Name of the cross-section at the outer end: stiffness, inertia and outline are linear between the two.
    pub outer_section: Option<String>,
    /// Factor `λ₂` of the section's width along the body; a number is the factor at the outer end, linear from 1.
    pub width_taper: Option<FunctionFile>,
    /// Factor `λ₃` of the section's height along the body; a number is the factor at the outer end, linear from 1.
    pub height_taper: Option<FunctionFile>,
    /// Kind of strain element.
    #[serde(default)]
    pub element: ElementFile,
    /// Number of elements along the body; a linear element is one pair of halves.
    #[schemars(range(min = 1, max = 1000))]
    pub elements: usize,
    /// Natural twist and curvatures `[κx, κy, κz]`, constant along the body: the shape without loads.
    #[serde(default)]
    pub natural_curvature_1_m: [f64; 3],
    /// Natural twist `κx` along the body; instead of `natural_curvature_1_m`.
    pub twist_1_m: Option<FunctionFile>,
    /// Natural curvature `κy` along the body; positive bends the axis towards `−z`.
    pub curvature_y_1_m: Option<FunctionFile>,
    /// Natural curvature `κz` along the body; positive bends the axis towards `+y`.
    pub curvature_z_1_m: Option<FunctionFile>,
    /// Mass-proportional damping `α`, on motion relative to the root or, behind a free joint, to the first frame of the
    /// body that flies. Acts on the beam only, unless `damp_attached_masses` is set.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub mass_damping_1_s: f64,
    /// `mass_damping_1_s` acts on this body's attached masses too. Default false.
    #[serde(default)]
    pub damp_attached_masses: bool,
    /// Stiffness-proportional damping `β`.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub stiffness_damping_s: f64,
    /// Number of load stations at the centres of equal strips, default 4.
    #[schemars(range(min = 0, max = 1000))]
    pub load_stations: Option<usize>,
    /// Distances of the load stations from the inner end, ascending; instead of `load_stations`.
    #[schemars(length(max = 1000))]
    pub load_station_positions_m: Option<Vec<f64>>,
    /// Frame of the forces and moments at the stations: `root` (dead loads) or `section` (follower loads).
    #[serde(default)]
    pub load_frame: LoadFrameFile,
}

/// Kind of strain element.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum ElementFile {
    /// Linear strain: fourth order.
    #[default]
    Linear,
    /// Constant strain: second order.
    Constant,
}

impl From<ElementFile> for ElementKind {
    fn from(kind: ElementFile) -> Self {
        match kind {
            ElementFile::Linear => Self::Linear,
            ElementFile::Constant => Self::Constant,
        }
    }
}

/// Frame of station loads.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LoadFrameFile {
    /// Root frame: a dead load.
    #[default]
    Root,
    /// Section frame: a follower load.
    Section,
}

impl From<LoadFrameFile> for LoadFrame {
    fn from(frame: LoadFrameFile) -> Self {
        match frame {
            LoadFrameFile::Root => Self::Root,
            LoadFrameFile::Section => Self::Section,
        }
    }
}

/// Load stations of a body that says nothing about them.
const DEFAULT_STATIONS: usize = 4;

/// Builds a body; `None` if a problem was found.
pub(super) fn build(
    name: &str,
    file: &BodyFile,
    sections: &Sections,
    masses: Vec<AttachedMass>,
    joint: Option<Joint>,
    checker: &mut Checker,
) -> Option<Body> {
    if name == "root" {
        let allowed = "another name: \"root\" is what the wing is fixed to";
        checker.refuse_as(&["body", name], "the name \"root\"", allowed);
    }
    let section = section_law(name, file, sections, checker);
    let natural_strain = natural_strain(name, file, checker);
    let station_positions_m = stations(name, file, checker);
    Some(Body {
        name: name.to_owned(),
        length_m: file.length_m,
        section: section?,
        element: file.element.into(),
        elements: file.elements,
        natural_strain: natural_strain?,
        mass_damping_1_s: file.mass_damping_1_s,
        damp_attached_masses: file.damp_attached_masses,
        stiffness_damping_s: file.stiffness_damping_s,
        station_loads: vec![Wrench::default(); station_positions_m.len()],
        station_positions_m,
        load_frame: file.load_frame.into(),
        masses,
        joint: joint?,
    })
}

/// The section along the body: uniform, tapered, or between two named ones.
pub(super) fn section_law(
    name: &str,
    file: &BodyFile,
    sections: &Sections,
    checker: &mut Checker,
) -> Option<SectionLaw> {
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
    if let Some(outer) = outer {
        let [inner, outer] = [inner, outer?].map(Built::section);
        return Some(SectionLaw::Between { inner, outer, length_m: file.length_m });
    }
    match (inner, tapered) {
        (Built::Solid(solid), _) => {
            let law = SectionLaw::Tapered { solid: *solid, width: width?, height: height? };
            let sound = law.samples_m(file.length_m).iter().all(|s| is_sound(&law.at(*s)));
            if !sound {
                let allowed = "factors that leave mass, inertia and stiffness positive, finite numbers in SI";
                let key = tapered.map_or("section", |(key, _)| key);
                checker.refuse_as(&["body", name, key], "a section of such dimensions", allowed);
            }
            sound.then_some(law)
        }
        (Built::Explicit { section, .. }, None) => Some(section.clone().into()),
        (Built::Explicit { .. }, Some((key, _))) => {
            let allowed = "a body whose section is a rectangle or an ellipse; other sections vary by outer_section";
            checker.refuse(&["body", name, key], allowed);
            None
        }
    }
}

/// A factor along the body; 1 where the file says nothing.
fn taper_law(
    name: &str,
    file: &BodyFile,
    key: &str,
    taper: Option<&FunctionFile>,
    checker: &mut Checker,
) -> Option<Profile> {
    let length_m = file.length_m;
    let profile = match taper {
        None => Profile::constant(1.0),
        Some(FunctionFile::Number(outer)) => Profile::linear(1.0, *outer, length_m),
        Some(taper) => along_body(&["body", name, key], taper, length_m, checker)?,
    };
    let least = profile.samples_m(length_m).into_iter().map(|s| profile.at(s)).fold(f64::INFINITY, f64::min);
    if least > 0.0 {
        return Some(profile);
    }
    match taper {
        Some(FunctionFile::Number(_)) => checker.refuse(&["body", name, key], "a finite factor > 0"),
        _ => checker.refuse_as(
            &["body", name, key],
            format!("a factor that falls to {} on the body", shortest(least)),
            "a factor > 0 all along the body",
        ),
    }
    None
}

/// Natural strain along the body.
fn natural_strain(name: &str, file: &BodyFile, checker: &mut Checker) -> Option<NaturalStrain> {
    let functions = [
        ("twist_1_m", &file.twist_1_m),
        ("curvature_y_1_m", &file.curvature_y_1_m),
        ("curvature_z_1_m", &file.curvature_z_1_m),
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
            *profile = along_body(&["body", name, key], function, file.length_m, checker);
        }
    }
    let [Some(twist), Some(y), Some(z)] = profiles else { return None };
    let strain = NaturalStrain([Profile::constant(0.0), twist, y, z]);
    let key = stated.map_or("natural_curvature_1_m", |(key, _)| key);
    check_curvature(&["body", name, key], file, &strain, checker);
    Some(strain)
}

/// An element's rotation must stay below π, where its rotation vector is unique.
fn check_curvature(path: &[&str], file: &BodyFile, strain: &NaturalStrain, checker: &mut Checker) {
    let limit = PI * file.elements as f64 / file.length_m;
    let size = |s: f64| Vector3::from_fn(|i, _| strain.0[i + 1].at(s)).norm();
    let samples = strain.0.iter().flat_map(|profile| profile.samples_m(file.length_m));
    let (largest, place) = samples.map(|s| (size(s), s)).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    if largest < limit {
        return;
    }
    let allowed = format!("curvatures of a magnitude < {limit:.4} 1/m: half a turn per element");
    if strain.0.iter().all(Profile::is_constant) {
        checker.refuse(path, allowed);
    } else {
        checker.refuse_as(path, format!("a curvature of {largest:.4} 1/m at {} m", shortest(place)), allowed);
    }
}

/// Distances of the load stations from the inner end in m.
fn stations(name: &str, file: &BodyFile, checker: &mut Checker) -> Vec<f64> {
    let path = ["body", name, "load_station_positions_m"];
    match (&file.load_station_positions_m, file.load_stations) {
        (Some(positions), count) => {
            if count.is_some() {
                checker.refuse(&path, "either load_stations or load_station_positions_m, not both");
            }
            let ascending = positions.windows(2).all(|pair| pair[0] < pair[1]);
            let on_body = positions.iter().all(|position| (0.0..=file.length_m).contains(position));
            if !(ascending && on_body) {
                let length = shortest(file.length_m);
                checker.refuse(&path, format!("ascending lengths from 0 to {length} m, the length of the body"));
            }
            positions.clone()
        }
        (None, count) => {
            let count = count.unwrap_or(DEFAULT_STATIONS);
            (0..count).map(|i| file.length_m * (i as f64 + 0.5) / count as f64).collect()
        }
    }
}
