//! Warnings about a valid model file: probable errors of units, and bodies to which beam theory does not apply. They are not errors.
//!
//! The bounds are those of existing materials and structures, with a margin.

use crate::copies::Copies;
use crate::document::{Document, key_text};
use crate::file::{ModelFile, SectionFile};
use crate::section_summary::each_beam;
use crate::sections::Built;
use crate::shape_warnings::{MAXIMUM_OUTLINE_M, shape_warnings};
use crate::shear_share::{is_unstated, neglected_shear, shear_shares};
use crate::station_file::sections_of_a_program;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Young's and shear moduli of solids in Pa: from soft gels to beyond diamond (1.2e12 Pa).
const MODULUS_PA: Range<f64> = 1e5..3e12;
/// Moduli in GPa, by which a wrong unit is recognised: from soft foam (1e-4 GPa) upwards.
const MODULUS_GPA: Range<f64> = 1e-4..3e3;
/// Moduli in MPa, above possible values in GPa: plastics, metals, composites.
const MODULUS_MPA: Range<f64> = 3e3..1e6;
/// Densities of solids in kg/m³: light foams to osmium (22 590).
const DENSITY_KG_M3: Range<f64> = 5.0..25e3;
/// Speed of sound along a bar in m/s, `√(EA/m)`: from rubber (30) to diamond (18 000). Sections given by their properties may be softer
/// along the axis than any material.
const BAR_SPEED_M_S: Range<f64> = 10.0..5e4;
/// Minimum ratio of length to thickness of beams without shear deformation: `docs/guide/theory.md`.
const MINIMUM_SLENDERNESS: f64 = 10.0;
const MINIMUM_SLENDERNESS_WITH_SHEAR: f64 = 1.0;
/// Length of bodies in m beyond that of blades, towers and hulls: probably in another unit.
const MAXIMUM_LENGTH_M: f64 = 300.0;
/// Ratio of length to width or thickness above which one of the lengths is probably in another unit; no real wing exceeds it.
const MAXIMUM_SLENDERNESS: f64 = 1000.0;
/// Ratio of width or thickness to length above which one of them is probably in another unit.
const MAXIMUM_WIDTH: f64 = 3.0;
/// Largest plausible ratio of the masses attached to a body to the mass of the body.
const MAXIMUM_ATTACHED: f64 = 1000.0;
/// Magnitudes of gravity in m/s² on planets and in tests; 0 is also possible.
const GRAVITY_M_S2: Range<f64> = 1.5..100.0;
/// Wind speed in m/s above which compressibility dominates (a Mach number of 0.5).
const WIND_M_S: f64 = 170.0;
/// Largest plausible step in degrees between two rows of a polar with different values; measured polars have steps of 10 or less.
const POLAR_STEP_DEG: f64 = 20.0;
/// Plausible number of rows of the simulation.
const ROWS: Range<f64> = 10.0..1e7;
/// An angle read in rad that is a multiple of this angle in degrees, within [`ROUND_DEG`], was probably given in rad.
const MULTIPLE_DEG: f64 = 5.0;
/// Tolerance in degrees, for an angle in rad with four digits.
const ROUND_DEG: f64 = 6e-3;

/// Warning about a valid value that is probably not the intended one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Line of the key, numbered from 1.
    pub line: usize,
    /// Byte range of the text that is marked by a caret.
    pub span: Range<usize>,
    /// Path of the key, such as `section.spar.youngs_modulus_Pa`.
    pub key: String,
    /// Reason why it is implausible.
    pub reason: String,
    /// Correction of the probable error, or where to find further information.
    pub advice: String,
}

/// Warnings about implausible values in the text of a valid model file for [`crate::parse`], in the order of the file; empty for an
/// invalid text.
pub fn warnings(text: &str) -> Vec<Warning> {
    let (Ok(document), Ok(file)) = (Document::parse(text), toml::from_str::<ModelFile>(text)) else {
        return Vec::new();
    };
    let mut look = Look { document: &document, found: Vec::new() };
    look.materials(&file);
    look.sections(&file);
    look.bodies(&file);
    for (path, reason, advice) in shape_warnings(&document, &file) {
        look.warning(&path.iter().map(String::as_str).collect::<Vec<_>>(), reason, advice);
    }
    look.angles(&file);
    look.surroundings(&file);
    look.rotor(&file);
    look.found.sort_by_key(|warning| warning.span.start);
    look.found
}

/// Warnings about properties lost when the files named in a model file are embedded: sections of other programs whose 6×6 stiffness
/// includes shear deflection, which a body without shear neglects. `text` is the file as written, and its files are in `folder`.
pub fn warnings_of_files(text: &str, folder: &Path) -> Vec<Warning> {
    let (Ok(document), Ok(file)) = (Document::parse(text), toml::from_str::<ModelFile>(text)) else {
        return Vec::new();
    };
    let mut look = Look { document: &document, found: Vec::new() };
    for (name, section) in &file.section {
        let SectionFile::Table(table) = section else { continue };
        let read = |path: PathBuf| sections_of_a_program(&path, table.file_units);
        let Some(sections) = table.file.as_ref().and_then(|file| read(folder.join(file))) else { continue };
        let shares: Vec<(&str, f64)> = file
            .body
            .iter()
            .filter(|(body, keys)| keys.section == *name && is_unstated(body, keys, &document))
            .filter_map(|(body, keys)| {
                let shares = shear_shares(&sections, keys.length_m)?;
                Some((body.as_str(), shares.into_iter().fold(0.0, f64::max)))
            })
            .collect();
        if let Some((reason, advice)) = neglected_shear(&shares) {
            look.warning(&["section", name, "file"], reason, advice);
        }
    }
    look.found
}

struct Look<'d, 'a> {
    document: &'d Document<'a>,
    found: Vec<Warning>,
}

impl Look<'_, '_> {
    fn warning(&mut self, path: &[&str], reason: String, advice: impl Into<String>) {
        let entry = self.document.find(path);
        let span = entry
            .map_or_else(|| self.document.span_of(path), |entry| self.document.value_span(entry.offset, entry.value));
        let line = self.document.line_of(path);
        self.found.push(Warning { line, span, key: key_text(path), reason, advice: advice.into() });
    }

    fn sections(&mut self, file: &ModelFile) {
        for (name, section) in &file.section {
            match section {
                SectionFile::Rectangle(solid) | SectionFile::Ellipse(solid) => {
                    self.modulus(&["section", name, "youngs_modulus_Pa"], solid.youngs_modulus_pa);
                    self.modulus(&["section", name, "shear_modulus_Pa"], solid.shear_modulus_pa);
                    self.density(&["section", name, "density_kg_m3"], solid.density_kg_m3);
                }
                // materials are named and not checked here
                SectionFile::Tube(_)
                | SectionFile::Box(_)
                | SectionFile::I(_)
                | SectionFile::C(_)
                | SectionFile::Angle(_)
                | SectionFile::Profile(_)
                | SectionFile::Laminate(_) => {}
                SectionFile::Table(_) => {} // the values come from section programs
                SectionFile::Explicit(section) => {
                    let axial_n = section.axial_stiffness_n.or(section.stiffness_si.map(|matrix| matrix[0][0]));
                    let Some(axial_n) = axial_n else { continue };
                    let speed_m_s = (axial_n / section.mass_kg_m).sqrt();
                    if !BAR_SPEED_M_S.contains(&speed_m_s) {
                        let key = if section.stiffness_si.is_some() { "stiffness_SI" } else { "axial_stiffness_N" };
                        let reason = format!(
                            "with mass_kg_m = {} the speed of longitudinal waves is {} m/s",
                            number(section.mass_kg_m),
                            number(speed_m_s)
                        );
                        self.warning(
                            &["section", name, key],
                            reason,
                            "metals and composites have 3000 to 12000 m/s: EA in N, mass in kg/m",
                        );
                    }
                }
            }
        }
    }

    fn materials(&mut self, file: &ModelFile) {
        for (name, material) in &file.material {
            self.modulus(&["material", name, "youngs_modulus_Pa"], Some(material.youngs_modulus_pa));
            self.modulus(&["material", name, "shear_modulus_Pa"], material.shear_modulus_pa);
            self.density(&["material", name, "density_kg_m3"], Some(material.density_kg_m3));
        }
    }

    fn density(&mut self, path: &[&str], density_kg_m3: Option<f64>) {
        let Some(density) = density_kg_m3.filter(|density| !DENSITY_KG_M3.contains(density)) else { return };
        let advice = if density < DENSITY_KG_M3.start && density > 0.01 {
            format!("g/cm3? write {}", number(1e3 * density))
        } else {
            "solids have 5 to 25000 kg/m3".to_owned()
        };
        self.warning(path, format!("no solid has {} kg/m3", number(density)), advice);
    }

    fn modulus(&mut self, path: &[&str], modulus_pa: Option<f64>) {
        let Some(modulus) = modulus_pa.filter(|modulus| !MODULUS_PA.contains(modulus)) else { return };
        let advice = if MODULUS_GPA.contains(&modulus) {
            format!("GPa? write {:e}", modulus * 1e9)
        } else if MODULUS_MPA.contains(&modulus) {
            format!("MPa? write {:e}", modulus * 1e6)
        } else {
            "solids have 1e5 to 1.2e12 Pa".to_owned()
        };
        let than = if modulus < MODULUS_PA.start { "softer than a gel" } else { "stiffer than diamond" };
        self.warning(path, format!("{} Pa is {than}", number(modulus)), advice);
    }

    fn bodies(&mut self, file: &ModelFile) {
        for (name, body) in &file.body {
            if body.length_m > MAXIMUM_LENGTH_M {
                let reason = format!("a body of {} m", number(body.length_m));
                let advice = format!("millimetres? write {}, and all other lengths in m", number(1e-3 * body.length_m));
                self.warning(&["body", name, "length_m"], reason, advice);
                continue;
            }
            let outline = match file.section.get(&body.section) {
                Some(SectionFile::Rectangle(solid) | SectionFile::Ellipse(solid)) => {
                    Some((["width_m", "height_m"], solid.width_m, solid.height_m, 1.0))
                }
                Some(SectionFile::Explicit(section)) => section
                    .half_width_m
                    .zip(section.half_height_m)
                    .map(|(width, height)| (["half_width_m", "half_height_m"], 2.0 * width, 2.0 * height, 0.5)),
                // checked by their shear deflection
                Some(
                    SectionFile::Tube(_)
                    | SectionFile::Box(_)
                    | SectionFile::I(_)
                    | SectionFile::C(_)
                    | SectionFile::Angle(_)
                    | SectionFile::Profile(_)
                    | SectionFile::Laminate(_)
                    | SectionFile::Table(_),
                )
                | None => None,
            };
            let Some((keys, width_m, height_m, share)) = outline else { continue };
            let (length_m, thickness_m) = (body.length_m, width_m.min(height_m));
            let slender = |length_m: f64, thickness_m: f64| {
                (MINIMUM_SLENDERNESS..MAXIMUM_SLENDERNESS).contains(&(length_m / thickness_m))
            };
            let too_large =
                [width_m, height_m].into_iter().zip(keys).find(|(size_m, _)| *size_m > MAXIMUM_WIDTH * length_m);
            if let Some((size_m, key)) = too_large {
                let reason = format!("{} m on a body of {} m", number(size_m), number(length_m));
                let advice = format!("millimetres? write {}", number(1e-3 * share * size_m));
                self.warning(&["section", &body.section, key], reason, advice);
            } else if length_m > MAXIMUM_SLENDERNESS * width_m.max(height_m) {
                let reason = format!(
                    "{} m long, but {} m wide and {} m thick",
                    number(length_m),
                    number(width_m),
                    number(height_m)
                );
                let millimetres = slender(1e-3 * length_m, thickness_m);
                let advice = if millimetres {
                    format!("millimetres? write {}", number(1e-3 * length_m))
                } else {
                    format!("compare with width and height of section {:?}: all are in m", body.section)
                };
                self.warning(&["body", name, "length_m"], reason, advice);
            } else if let Some((size_m, key)) =
                [width_m, height_m].into_iter().zip(keys).find(|(size_m, _)| *size_m > MAXIMUM_OUTLINE_M)
            {
                let reason = format!("a section of {} m", number(size_m));
                let advice = format!("millimetres? write {}", number(1e-3 * share * size_m));
                self.warning(&["section", &body.section, key], reason, advice);
            } else if length_m < MINIMUM_SLENDERNESS_WITH_SHEAR * thickness_m {
                let reason = format!("{} m long and {} m thick: no beam", number(length_m), number(thickness_m));
                self.warning(&["body", name, "length_m"], reason, "a rigid body may be sufficient");
            } else if length_m < MINIMUM_SLENDERNESS * thickness_m && is_unstated(name, body, self.document) {
                let thick = "without shear = true the beam neglects shear deflection, which counts in bodies shorter than ten times their thickness";
                let reason = format!("{} m long and {} m thick, {thick}", number(length_m), number(thickness_m));
                let advice = "shear = true on the body includes it, shear = false neglects it without this warning; \
                              a rigid body may be sufficient";
                self.warning(&["body", name, "length_m"], reason, advice);
            }
        }
        let own_masses_kg: BTreeMap<String, f64> =
            each_beam(self.document, file, &Copies::default(), |name, body, built, law| {
                let is_table = matches!(built, Built::Table(_));
                (!is_table).then(|| (name.to_owned(), law.mass_kg(body.length_m)))
            })
            .into_iter()
            .flatten()
            .collect();
        for (name, mass) in &file.mass {
            let Some(own_kg) = own_masses_kg.get(&mass.body).copied() else { continue };
            if mass.mass_kg > MAXIMUM_ATTACHED * own_kg {
                let reason = format!("{} kg on a body of {} kg", number(mass.mass_kg), number(own_kg));
                self.warning(
                    &["mass", name, "mass_kg"],
                    reason,
                    format!("grams? write {}", number(1e-3 * mass.mass_kg)),
                );
            }
        }
    }

    /// Warns about angles that are round numbers if they are read in rad.
    fn angles(&mut self, file: &ModelFile) {
        for (name, joint) in &file.joint {
            let latch = joint.latch.as_ref().map(|latch| latch.angle_deg);
            let rotation = joint.rotation.as_ref();
            let own_latch = rotation.and_then(|own| own.latch.as_ref()).map(|latch| latch.angle_deg);
            let angles: [(&[&str], Option<f64>); 4] = [
                (&["joint", name, "start_angle_deg"], joint.start_angle_deg),
                (&["joint", name, "latch", "angle_deg"], latch),
                (&["joint", name, "rotation", "start_angle_deg"], rotation.and_then(|own| own.start_angle_deg)),
                (&["joint", name, "rotation", "latch", "angle_deg"], own_latch),
            ];
            for (path, angle) in angles {
                let Some(angle) = angle.filter(|angle| angle.fract() != 0.0) else { continue };
                let meant_deg = (angle.to_degrees() / MULTIPLE_DEG).round() * MULTIPLE_DEG;
                // few digits are not conclusive: 0.5 rad is as close to 30 deg as to 28.65 deg
                let close = (angle.to_degrees() - meant_deg).abs() < ROUND_DEG && meant_deg != 0.0;
                if close && meant_deg.abs() <= 360.0 {
                    let reason = format!("{angle} rad would be {} deg", number(meant_deg));
                    self.warning(path, reason, format!("rad? write {}", number(meant_deg)));
                }
            }
        }
    }

    /// Warns about gaps in polars, and about winds that end before the run does.
    fn rotor(&mut self, file: &ModelFile) {
        for (name, polar) in &file.polar {
            let rows = polar.rows.iter().flatten().collect::<Vec<_>>();
            let hole = rows.windows(2).find(|pair| {
                let differ = (1..4).any(|k| pair[0][k] != pair[1][k]);
                differ && pair[1][0] - pair[0][0] > POLAR_STEP_DEG
            });
            if let Some([from, to]) = hole {
                let reason = format!("no row between {} and {} deg", number(from[0]), number(to[0]));
                let advice = "the coefficients are interpolated linearly; add the missing rows";
                self.warning(&["polar", name, if polar.file.is_some() { "file" } else { "rows" }], reason, advice);
            }
        }
        let table = file.wind.as_ref().and_then(|wind| wind.table.as_deref()).unwrap_or_default();
        let stop_s = file.simulation.stop_time_s;
        // a single row is a steady wind
        if let Some(end_s) = table.last().map(|row| row[0]).filter(|end_s| table.len() > 1 && *end_s < stop_s) {
            let reason = format!("the wind ends at {} s, the run at {} s", number(end_s), number(stop_s));
            self.warning(&["wind", "table"], reason, "the last row applies after that; is the table incomplete?");
        }
    }

    fn surroundings(&mut self, file: &ModelFile) {
        let magnitude = |vector: &[f64; 3]| vector.iter().map(|part| part * part).sum::<f64>().sqrt();
        let gravity = magnitude(&file.gravity_m_s2);
        if gravity > 0.0 && !GRAVITY_M_S2.contains(&gravity) {
            let advice =
                if gravity < GRAVITY_M_S2.start { "multiples of g? 1 g is 9.80665" } else { "mm/s2? write 9.80665" };
            self.warning(&["gravity_m_s2"], format!("gravity of {} m/s2", number(gravity)), advice);
        }
        if let Some(air) = &file.aerodynamics {
            let wind = magnitude(&air.wind_m_s);
            if wind > WIND_M_S && air.speed_of_sound_m_s.is_none() {
                let reason = format!(
                    "at {} m/s the compressibility of air matters; speed_of_sound_m_s includes it",
                    number(wind)
                );
                self.warning(
                    &["aerodynamics", "wind_m_s"],
                    reason,
                    format!("km/h? that is {} m/s", number(wind / 3.6)),
                );
            }
        }
        let run = &file.simulation;
        let rows = (run.stop_time_s - run.start_time_s) / run.step_s;
        if !ROWS.contains(&rows) {
            let key = if self.document.find(&["simulation", "step_s"]).is_some() { "step_s" } else { "stop_time_s" };
            let reason = format!("a run of {} rows", number(rows.ceil()));
            let advice = if rows < 1.0 || key == "step_s" && rows < ROWS.start {
                format!("milliseconds? write {}", number(1e-3 * run.step_s))
            } else {
                "step_s is the time between two rows, stop_time_s the end of the run".to_owned()
            };
            self.warning(&["simulation", key], reason, advice);
        }
    }
}

/// Formats a number with at most four digits.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) { format!("{rounded:e}") } else { rounded.to_string() }
}

#[cfg(test)]
#[path = "warnings_tests.rs"]
mod tests;
