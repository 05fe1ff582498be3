//! Warnings about sections given by shape: dimensions in another unit, shear deflection, torsion with restrained warping, and an elastic
//! axis away from the shear centre.

use crate::body_file::BodyFile;
use crate::copies::Copies;
use crate::document::Document;
use crate::file::ModelFile;
use crate::function::FunctionFile;
use crate::section_summary::each_beam;
use crate::sections::Built;
use crate::shapes::{SectionProperties, Shape};
use crate::shear_share::{is_unstated, neglected_shear, shear_over_bending};
use foldwing_engine::machine::units::shortest;

/// Warning: path of its key, reason, advice.
pub(super) type ShapeWarning = (Vec<String>, String, String);

/// Outer dimension of sections in m beyond that of blades, towers and hulls: probably in another unit.
pub(super) const MAXIMUM_OUTLINE_M: f64 = 30.0;
/// Ratio of outer dimension to body length above which one of them is probably in another unit; then the limit of the inverse ratio.
const MAXIMUM_WIDTH: f64 = 3.0;
const MAXIMUM_SLENDERNESS: f64 = 1000.0;
/// Increase of the torsional rigidity by restrained warping at one end above which there is a warning.
const MAXIMUM_WARPING: f64 = 0.1;
/// Distance between shear centre and elastic axis of a surface above which there is a warning, as a fraction of the chord.
const MAXIMUM_OFFSET: f64 = 0.02;

/// Warnings about implausible sections by shape in a valid file.
pub(super) fn shape_warnings(document: &Document, file: &ModelFile) -> Vec<ShapeWarning> {
    let beams = each_beam(document, file, &Copies::default(), |name, body, built, _| {
        let Built::Shape(shape) = built else { return None };
        let stations = shape.stations(body.length_m).ok()?;
        let warnings =
            [size(body, &stations), warping(name, body, &stations), elastic_axis(name, shape, &stations, file)];
        let share = is_unstated(name, body, document).then(|| shear_share(body, &stations)).flatten();
        Some((warnings, share.map(|share| (body.section.clone(), name.to_owned(), share))))
    });
    let (warnings, shares): (Vec<_>, Vec<_>) = beams.into_iter().flatten().unzip();
    let shares: Vec<_> = shares.into_iter().flatten().collect();
    let shear = file.section.keys().filter_map(|section| {
        let bodies: Vec<_> = shares.iter().filter(|share| share.0 == *section).collect();
        let (reason, advice) =
            neglected_shear(&bodies.iter().map(|share| (share.1.as_str(), share.2)).collect::<Vec<_>>())?;
        Some((path(&["section", section]), reason, advice))
    });
    warnings.into_iter().flatten().flatten().chain(shear).collect()
}

fn path(parts: &[&str]) -> Vec<String> {
    parts.iter().map(|part| (*part).to_owned()).collect()
}

/// Formats three digits.
fn short(value: f64) -> String {
    format!("{value:.2e}").parse().map_or_else(|_| shortest(value), shortest)
}

/// Warns about outer dimensions far from the length of the body.
fn size(body: &BodyFile, stations: &[(f64, SectionProperties)]) -> Option<ShapeWarning> {
    let [width, height] = stations[0].1.outline_m?.map(|[low, high]| high - low);
    let largest_m = width.max(height);
    if largest_m > MAXIMUM_WIDTH * body.length_m || largest_m > MAXIMUM_OUTLINE_M {
        let reason = format!("a section of {} m on a body of {} m", short(largest_m), shortest(body.length_m));
        return Some((path(&["section", &body.section]), reason, "millimetres? dimensions are in m".to_owned()));
    }
    (body.length_m > MAXIMUM_SLENDERNESS * largest_m).then(|| {
        let reason = format!("a section of {} m on a body of {} m", short(largest_m), shortest(body.length_m));
        (path(&["section", &body.section]), reason, "all dimensions are in m".to_owned())
    })
}

/// Warns about shear deflection that a body without shear neglects.
fn shear_share(body: &BodyFile, stations: &[(f64, SectionProperties)]) -> Option<f64> {
    let last = stations.last().map(|(_, section)| (body.length_m, section));
    let ends = stations.iter().map(|(s_m, section)| (*s_m, section)).chain(last);
    let rows: Option<Vec<_>> = ends
        .map(|(s_m, section)| {
            let [along_y, along_z] = section.shear_stiffnesses_n?;
            Some((
                body.length_m - s_m,
                [(along_y, section.edge_stiffness_n_m2), (along_z, section.flap_stiffness_n_m2)],
            ))
        })
        .collect();
    Some(shear_over_bending(&rows?).into_iter().fold(0.0, f64::max))
}

/// Warns about open sections: if warping is restrained at the joint, they are stiffer in torsion than the beam model, NOTATION eq.
/// (S23).
fn warping(name: &str, body: &BodyFile, stations: &[(f64, SectionProperties)]) -> Option<ShapeWarning> {
    let section = &stations[0].1;
    let decay = body.length_m * (section.torsional_rigidity_n_m2 / section.warping_stiffness_n_m4).sqrt();
    let share = decay.tanh() / decay;
    let added = share / (1.0 - share);
    (section.warping_stiffness_n_m4 > 0.0 && added > MAXIMUM_WARPING).then(|| {
        let reason = format!(
            "an open section: where its joint restrains warping, body {name} is {} times as stiff in torsion as GJ alone gives",
            short(1.0 + added)
        );
        let advice = "the model assumes free warping; use a closed section if this matters: docs/guide/sections.md".to_owned();
        (path(&["section", &body.section]), reason, advice)
    })
}

/// Warns about a surface whose elastic axis is not at the shear centre of the profile.
fn elastic_axis(
    name: &str,
    shape: &Shape,
    stations: &[(f64, SectionProperties)],
    file: &ModelFile,
) -> Option<ShapeWarning> {
    let fraction = shape.axis_fraction(&stations[0].1)?;
    let (surface, stated) = file.surface.iter().find(|(_, surface)| surface.body == name)?;
    let FunctionFile::Number(stated) = stated.elastic_axis_fraction else { return None };
    ((stated - fraction).abs() > MAXIMUM_OFFSET).then(|| {
        let reason =
            format!("the shear centre of section {:?} is at {} of its chord", file.body[name].section, short(fraction));
        let advice = format!("the beam axis is there: write {}", short(fraction));
        (path(&["surface", surface, "elastic_axis_fraction"]), reason, advice)
    })
}
