//! Conversion of materials and sections by shape in the model file to [`Shape`].

use crate::air_file::LeadingEdgeFile;
use crate::checker::Checker;
use crate::file::ModelFile;
use crate::function::{FunctionFile, along_body};
use crate::shape_file::{
    AngleSection, ChannelSection, FrameSection, LaminateSection, MaterialFile, ProfileSection, TubeSection,
};
use crate::shapes::{
    Across, Dimension, FrameDimensions, Material, Ply, ProfileShape, Refused, Shape, naca, named_material,
    names_of_materials, nearest_name,
};
use foldwing_engine::machine::units::shortest;
use indexmap::IndexMap;

/// Materials of the model file by name; `None` after an error.
pub(super) type Materials<'f> = IndexMap<&'f str, Option<Material>>;

/// Assumed Poisson's ratio in the plane perpendicular to the fibres if no shear modulus is stated.
const TRANSVERSE_POISSON_RATIO: f64 = 0.4;

/// Builds the materials of the model file.
pub(super) fn materials<'f>(file: &'f ModelFile, checker: &mut Checker) -> Materials<'f> {
    let built =
        |(name, material): (&'f String, &'f MaterialFile)| (name.as_str(), build_material(name, material, checker));
    file.material.iter().map(built).collect()
}

fn build_material(name: &str, file: &MaterialFile, checker: &mut Checker) -> Option<Material> {
    let at = |key| ["material", name, key];
    let along = file.youngs_modulus_pa;
    let shear_modulus_pa = match (file.shear_modulus_pa, file.poisson_ratio, file.transverse_youngs_modulus_pa) {
        (None, _, Some(_)) => {
            checker.refuse(
                &at("shear_modulus_Pa"),
                "the shear modulus of a unidirectional material in planes that contain the fibres (G12)",
            );
            return None;
        }
        (_, None, Some(_)) => {
            checker.refuse(&at("poisson_ratio"), "the major Poisson's ratio of a unidirectional material (nu12)");
            return None;
        }
        (Some(_), Some(_), None) => {
            let allowed = "either shear_modulus_Pa or poisson_ratio; both only with transverse_youngs_modulus_Pa";
            checker.refuse(&at("poisson_ratio"), allowed);
            return None;
        }
        (Some(shear), _, _) => shear,
        (None, Some(ratio), None) => 0.5 * along / (1.0 + ratio),
        (None, None, None) => {
            checker.refuse(&at("shear_modulus_Pa"), "a finite modulus > 0 Pa, or poisson_ratio");
            return None;
        }
    };
    let across = match (file.transverse_youngs_modulus_pa, file.poisson_ratio) {
        (Some(across), Some(ratio)) => {
            if ratio * ratio * across >= along {
                let found = format!("{} with transverse_youngs_modulus_Pa = {}", shortest(ratio), shortest(across));
                let allowed = "a major Poisson's ratio whose square is less than youngs_modulus_Pa divided by transverse_youngs_modulus_Pa";
                checker.refuse_as(&at("poisson_ratio"), found, allowed);
                return None;
            }
            let default = 0.5 * across / (1.0 + TRANSVERSE_POISSON_RATIO);
            Some(Across {
                youngs_modulus_pa: across,
                poisson_ratio: ratio,
                shear_modulus_pa: file.transverse_shear_modulus_pa.unwrap_or(default),
            })
        }
        _ if file.transverse_shear_modulus_pa.is_some() => {
            checker.refuse(&at("transverse_shear_modulus_Pa"), "this key only with transverse_youngs_modulus_Pa");
            return None;
        }
        _ => None,
    };
    Some(Material { youngs_modulus_pa: along, shear_modulus_pa, density_kg_m3: file.density_kg_m3, across })
}

/// Returns the material with a name, defined in the model file or in the library; an unknown name is an error at
/// `path`.
pub(super) fn material(path: &[&str], name: &str, materials: &Materials, checker: &mut Checker) -> Option<Material> {
    if let Some(own) = materials.get(name) {
        return *own;
    }
    let found = named_material(name);
    if found.is_none() {
        let near = nearest_name(name, materials.keys().copied());
        let library = match near {
            Some(near) => format!("a name of the library in docs/guide/sections.md (did you mean {near:?}?)"),
            None => format!("one of {}", names_of_materials()),
        };
        let allowed = format!("a material: a table [material.<name>] or {library}");
        checker.refuse(path, allowed);
    }
    found
}

/// Builder of the shapes in the model file.
pub(super) struct Builder<'b, 'd, 'a> {
    /// Name of the section.
    pub name: &'b str,
    pub materials: &'b Materials<'b>,
    pub checker: &'b mut Checker<'d, 'a>,
}

impl Builder<'_, '_, '_> {
    fn dimension(&mut self, key: &'static str, function: &FunctionFile) -> Option<Dimension> {
        let profile = along_body(&["section", self.name, key], function, self.checker)?;
        Some(Dimension { key, profile })
    }

    fn material(&mut self, name: &str) -> Option<Material> {
        material(&["section", self.name, "material"], name, self.materials, self.checker)
    }

    /// Builds a round tube.
    pub fn tube(&mut self, file: &TubeSection) -> Option<Shape> {
        let (diameter, wall) = (self.dimension("diameter_m", &file.diameter_m), self.dimension("wall_m", &file.wall_m));
        let material = self.material(&file.material);
        Some(Shape::Tube([diameter?, wall?], material?))
    }

    /// Returns the dimensions and material of a box or an I-beam.
    pub fn frame(&mut self, file: &FrameSection) -> Option<(FrameDimensions, Material)> {
        let outer = [
            self.dimension("width_m", &file.width_m),
            self.dimension("height_m", &file.height_m),
            self.dimension("wall_m", &file.wall_m),
        ];
        let web = file.web_wall_m.as_ref().map(|web| self.dimension("web_wall_m", web));
        let material = self.material(&file.material);
        let [width, height, wall] = outer;
        let web = match web {
            Some(web) => Some(web?),
            None => None,
        };
        Some((FrameDimensions { outer: [width?, height?, wall?], web }, material?))
    }

    /// Builds a channel.
    pub fn channel(&mut self, file: &ChannelSection) -> Option<Shape> {
        let frame = FrameSection {
            width_m: file.width_m.clone(),
            height_m: file.height_m.clone(),
            wall_m: file.wall_m.clone(),
            web_wall_m: file.web_wall_m.clone(),
            material: file.material.clone(),
        };
        let (frame, material) = self.frame(&frame)?;
        Some(Shape::C(frame, side(file.open_side), material))
    }

    /// Builds an angle.
    pub fn angle(&mut self, file: &AngleSection) -> Option<Shape> {
        let dimensions = [
            self.dimension("width_m", &file.width_m),
            self.dimension("height_m", &file.height_m),
            self.dimension("wall_m", &file.wall_m),
        ];
        let material = self.material(&file.material);
        let [width, height, wall] = dimensions;
        Some(Shape::Angle([width?, height?, wall?], material?))
    }

    /// Builds a thin-walled profile.
    pub fn profile(&mut self, file: &ProfileSection) -> Option<Shape> {
        let (chord, skin) =
            (self.dimension("chord_m", &file.chord_m), self.dimension("skin_wall_m", &file.skin_wall_m));
        let material = self.material(&file.material);
        let outline = match (&file.aerofoil, &file.outline) {
            (Some(aerofoil), None) => {
                let outline = naca(aerofoil);
                if outline.is_none() {
                    let allowed = "a four-digit NACA aerofoil such as \"naca2412\"; give the points of any other aerofoil as outline";
                    self.checker.refuse(&["section", self.name, "aerofoil"], allowed);
                }
                outline.map(|outline| (outline, "aerofoil"))
            }
            (None, Some(outline)) => Some((outline.clone(), "outline")),
            (Some(_), Some(_)) => {
                self.checker.refuse(&["section", self.name, "outline"], "either aerofoil or outline, not both");
                None
            }
            (None, None) => {
                let allowed = "a four-digit NACA aerofoil such as \"naca2412\", or outline instead";
                self.checker.refuse(&["section", self.name, "aerofoil"], allowed);
                None
            }
        };
        let spars: Vec<_> = file
            .spar
            .iter()
            .map(|(name, spar)| {
                let path = ["section", self.name, "spar", name];
                let wall = along_body(&[&path[..], &["wall_m"]].concat(), &spar.wall_m, self.checker);
                let own = spar.material.as_ref().map_or(material, |own| {
                    self::material(&[&path[..], &["material"]].concat(), own, self.materials, self.checker)
                });
                Some((name.clone(), spar.position, Dimension { key: "wall_m", profile: wall? }, own?))
            })
            .collect();
        let (outline, outline_key) = outline?;
        Some(Shape::Profile(Box::new(ProfileShape {
            chord: chord?,
            skin: skin?,
            outline,
            outline_key,
            material: material?,
            spars: spars.into_iter().collect::<Option<_>>()?,
            side: side(file.leading_edge),
        })))
    }

    /// Builds a strip of plies.
    pub fn laminate(&mut self, file: &LaminateSection) -> Option<Shape> {
        let width = self.dimension("width_m", &file.width_m);
        let count = file.layup_deg.len();
        let at = |key| ["section", self.name, key];
        let one_each = |key: &str, length: usize, checker: &mut Checker| {
            if length != count {
                let found = format!("an array of {length}");
                checker.refuse_as(
                    &["section", self.name, key],
                    found,
                    format!("an array of {count}, one for each ply in layup_deg"),
                );
            }
            length == count
        };
        let thicknesses_m = match (file.ply_thickness_m, &file.ply_thicknesses_m) {
            (Some(thickness_m), None) => Some(vec![thickness_m; count]),
            (None, Some(own)) => {
                let thin = own.iter().find(|thickness_m| **thickness_m <= 0.0);
                if let Some(thin) = thin {
                    self.checker.refuse_as(&at("ply_thicknesses_m"), shortest(*thin), "finite lengths > 0 m");
                }
                (one_each("ply_thicknesses_m", own.len(), self.checker) && thin.is_none()).then(|| own.clone())
            }
            (Some(_), Some(_)) => {
                self.checker.refuse(&at("ply_thicknesses_m"), "either ply_thickness_m or ply_thicknesses_m, not both");
                None
            }
            (None, None) => {
                self.checker.refuse(&at("ply_thickness_m"), "a finite length > 0 m, or ply_thicknesses_m instead");
                None
            }
        };
        let materials = match (&file.material, &file.ply_materials) {
            (Some(name), None) => self.material(name).map(|material| vec![material; count]),
            (None, Some(names)) if one_each("ply_materials", names.len(), self.checker) => {
                let path = ["section", self.name, "ply_materials"];
                names.iter().map(|name| material(&path, name, self.materials, self.checker)).collect()
            }
            (None, Some(_)) => None,
            (Some(_), Some(_)) => {
                self.checker.refuse(&at("ply_materials"), "either material or ply_materials, not both");
                None
            }
            (None, None) => {
                self.checker.refuse(&at("material"), "a material, or ply_materials instead");
                None
            }
        };
        let ply = |((angle_deg, thickness_m), material): ((&f64, f64), Material)| Ply {
            angle_rad: angle_deg.to_radians(),
            thickness_m,
            material,
        };
        let mut plies: Vec<Ply> = file.layup_deg.iter().zip(thicknesses_m?).zip(materials?).map(ply).collect();
        if file.symmetric {
            plies.extend(plies.clone().iter().rev());
        }
        Some(Shape::Laminate(width?, plies))
    }
}

fn side(edge: LeadingEdgeFile) -> f64 {
    match edge {
        LeadingEdgeFile::Plus => 1.0,
        LeadingEdgeFile::Minus => -1.0,
    }
}

/// Reports dimensions for which there is no section; `body` is the body along which they vary, if any.
pub(super) fn refuse(name: &str, body: Option<&str>, refused: &Refused, checker: &mut Checker) {
    let path: Vec<&str> = ["section", name].into_iter().chain(refused.key.iter().map(String::as_str)).collect();
    let place = body.map(|body| format!(" at s = {} m of body {body:?}", shortest(refused.position_m)));
    match (&refused.found, refused.value, place) {
        (Some(found), _, place) => {
            checker.refuse_as(&path, found.clone() + &place.unwrap_or_default(), &refused.allowed)
        }
        (None, Some(value), Some(place)) => checker.refuse_as(&path, shortest(value) + &place, &refused.allowed),
        // a default, such as that of web_wall_m, is not in the file
        (None, Some(value), None) if !checker.states(&path) => {
            checker.refuse_as(&path, shortest(value), &refused.allowed)
        }
        (None, _, _) => checker.refuse(&path, &refused.allowed),
    }
}

#[cfg(test)]
#[path = "shaped_tests.rs"]
mod tests;
