//! Gusts of the model file: the tables `[gust.<name>]`.

use crate::air_file::{GustFile, GustShapeFile};
use crate::checker::Checker;
use foldwing_engine::aero::continuous_turbulence::{Component, ContinuousTurbulence, Spectrum};
use foldwing_engine::aero::flow::GustShape;
use foldwing_engine::machine::builder::GustBuilder;
use nalgebra::Vector3;

/// Cosine or sine of an angle below which a velocity counts as perpendicular or parallel to the path of its gust.
const ALIGNED: f64 = 1e-9;

/// Builds a gust; `None` after an error.
pub(super) fn build(
    name: &str,
    gust: &GustFile,
    wind_m_s: &Vector3<f64>,
    checker: &mut Checker,
) -> Option<GustBuilder> {
    if let Some((key, allowed)) = stray(gust) {
        checker.refuse(&["gust", name, key], allowed);
        return None;
    }
    let mut missing = |key: &str, allowed: &str| {
        checker.refuse(&["gust", name, key], allowed);
        None
    };
    let shape = match gust.shape {
        GustShapeFile::SharpEdge => GustShape::SharpEdge,
        GustShapeFile::OneMinusCosine => match gust.length_m {
            Some(length_m) => GustShape::OneMinusCosine { length_m },
            None => return missing("length_m", "a finite length > 0 m"),
        },
        GustShapeFile::Table => match &gust.table {
            Some(rows) => GustShape::Table(rows.as_slice().into()),
            None => return missing("table", "rows [distance behind the gust front in m, fraction of velocity_m_s]"),
        },
        GustShapeFile::Dryden => turbulence(name, gust, Spectrum::Dryden, wind_m_s, checker)?,
        GustShapeFile::VonKarman => turbulence(name, gust, Spectrum::VonKarman, wind_m_s, checker)?,
    };
    let mut built = GustBuilder::new(name, shape, gust.velocity_m_s).origin_m(gust.origin_m).start_s(gust.start_s);
    if let Some(direction) = gust.direction {
        built = built.direction(direction);
    }
    if let Some(speed_m_s) = gust.speed_m_s {
        built = built.speed_m_s(speed_m_s);
    }
    Some(built)
}

/// The first key that does not apply to the shape of the gust, and the allowed alternative.
fn stray(gust: &GustFile) -> Option<(&'static str, &'static str)> {
    let shape = gust.shape;
    let turbulent = matches!(shape, GustShapeFile::Dryden | GustShapeFile::VonKarman);
    let of_turbulence = "this key is only for turbulence (shape = \"dryden\" or \"von_karman\")";
    [
        (
            "length_m",
            gust.length_m.is_some() && shape == GustShapeFile::SharpEdge,
            "no length_m with shape = \"sharp_edge\"",
        ),
        (
            "length_m",
            gust.length_m.is_some() && shape == GustShapeFile::Table,
            "no length_m with shape = \"table\": the distances are in the rows",
        ),
        ("table", gust.table.is_some() && shape != GustShapeFile::Table, "this key only with shape = \"table\""),
        ("scale_m", gust.scale_m.is_some() && !turbulent, of_turbulence),
        ("seed", gust.seed.is_some() && !turbulent, of_turbulence),
        ("resolution_m", gust.resolution_m.is_some() && !turbulent, of_turbulence),
    ]
    .into_iter()
    .find_map(|(key, wrong, allowed)| wrong.then_some((key, allowed)))
}

/// Builds turbulence with a velocity along or across the path of the gust.
fn turbulence(
    name: &str,
    gust: &GustFile,
    spectrum: Spectrum,
    wind_m_s: &Vector3<f64>,
    checker: &mut Checker,
) -> Option<GustShape> {
    let Some(scale_m) = gust.scale_m else {
        checker.refuse(&["gust", name, "scale_m"], "a finite length > 0 m");
        return None;
    };
    let direction = gust.direction.map_or(*wind_m_s, Vector3::from);
    let velocity_m_s = Vector3::from(gust.velocity_m_s);
    let component = match (direction.try_normalize(0.0), velocity_m_s.try_normalize(0.0)) {
        (Some(direction), Some(velocity)) if direction.cross(&velocity).norm() <= ALIGNED => Component::Longitudinal,
        (Some(direction), Some(velocity)) if direction.dot(&velocity).abs() > ALIGNED => {
            let allowed = "a velocity parallel or perpendicular to the direction of travel, because the spectra along and \
                           across it differ; write one gust for each component, with separate seeds";
            checker.refuse(&["gust", name, "velocity_m_s"], allowed);
            return None;
        }
        _ => Component::Transverse,
    };
    let asked = ContinuousTurbulence {
        spectrum,
        component,
        scale_m,
        seed: gust.seed.unwrap_or(0),
        length_m: gust.length_m,
        resolution_m: gust.resolution_m,
    };
    match asked.series() {
        Ok(series) => Some(GustShape::Turbulence(series)),
        Err(cause) => {
            checker.refuse(&["gust", name, cause.field], cause.allowed);
            None
        }
    }
}
