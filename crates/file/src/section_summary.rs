//! Sections along the beams of a valid model, with their properties.

use crate::body::section_law;
use crate::body_file::BodyFile;
use crate::checker::Checker;
use crate::copies::{self, Copies};
use crate::document::Document;
use crate::file::ModelFile;
use crate::sections::{self, Built, Sections};
use crate::shaped;
use crate::shapes::{SectionProperties, Shape};
use foldwing_engine::beam::law::SectionLaw;
use serde::Serialize;

/// Sections of a beam.
#[derive(Debug, Clone, Serialize)]
pub struct BodySections {
    /// Name of the body.
    pub body: String,
    /// Sections at both ends, and at every row of a table or of a varying dimension; a single section if it is uniform.
    pub sections: Vec<SectionAt>,
}

/// Section at a position of a beam.
#[derive(Debug, Clone, Serialize)]
pub struct SectionAt {
    /// Distance from the body's inner end in m.
    pub s_m: f64,
    /// Properties of the section.
    #[serde(flatten)]
    pub properties: SectionProperties,
}

/// Properties of the sections of all beams in the text of a model file for [`crate::parse`], in the order of the file; empty for an invalid
/// text.
pub fn section_properties(text: &str) -> Vec<BodySections> {
    let (Ok(document), Ok(mut file)) = (Document::parse(text), toml::from_str::<ModelFile>(text)) else {
        return Vec::new();
    };
    let copies = copies::expand(&mut file);
    let on_bodies = |name: &str, body: &BodyFile, built: &Built, law: &SectionLaw| BodySections {
        body: name.to_owned(),
        sections: places(law, built, body.length_m)
            .into_iter()
            .filter_map(|s_m| Some(SectionAt { s_m, properties: properties(built, law, s_m)? }))
            .collect(),
    };
    each_beam(&document, &file, &copies, on_bodies)
}

/// Calls a function for every beam of a valid file that has a section, with its name, its keys, the section at its inner end, and its
/// section law.
pub(super) fn each_beam<R>(
    document: &Document,
    file: &ModelFile,
    copies: &Copies,
    see: impl Fn(&str, &BodyFile, &Built, &SectionLaw) -> R,
) -> Vec<R> {
    let mut checker = Checker::new(document, &copies.names);
    let materials = shaped::materials(file, &mut checker);
    let build = |(name, section)| (String::as_str(name), sections::build(name, section, &materials, &mut checker));
    let sections: Sections = file.section.iter().map(build).collect();
    let beams = file.body.iter().filter_map(|(name, body)| {
        let law = section_law(name, body, &sections, &mut checker)?;
        let built = sections.get(body.section.as_str())?.as_ref()?;
        Some(see(name, body, built, &law))
    });
    beams.collect()
}

/// Positions that show how a section varies: ends and kinks.
fn places(law: &SectionLaw, built: &Built, length_m: f64) -> Vec<f64> {
    if law.is_uniform() {
        return vec![0.0];
    }
    let kinks = match built {
        Built::Shape(shape) if !shape.is_constant() => shape.kinks_m(),
        Built::Shape(_) | Built::Solid(_) | Built::Explicit(_) | Built::Table(_) => law.kinks_m(),
    };
    let mut places: Vec<f64> = kinks.into_iter().filter(|s| *s > 0.0 && *s < length_m).collect();
    places.extend([0.0, length_m]);
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| *a - *b < 1e-9 * length_m);
    places
}

/// Properties at a position, computed from the shape if it is known, otherwise from stiffness and inertia.
fn properties(built: &Built, law: &SectionLaw, s_m: f64) -> Option<SectionProperties> {
    let shape = match (built, law) {
        (Built::Shape(shape), SectionLaw::Uniform(_)) => Some(shape.at(s_m).ok()?),
        (Built::Shape(shape), SectionLaw::Table(_)) if !shape.is_constant() => Some(shape.at(s_m).ok()?),
        (Built::Shape(_), _) | (Built::Explicit(_) | Built::Table(_), _) => None,
        (Built::Solid(_), law) => law.solid_at(s_m).and_then(|solid| Shape::solid(&solid)),
    };
    Some(shape.unwrap_or_else(|| SectionProperties::of(&law.at(s_m))))
}
