//! Library of materials by name, each with its source.

use crate::meant::nearest;

/// Material of sections by shape; the axial direction is that of the fibres or the grain, if there are any.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus in Pa, along the fibres.
    pub youngs_modulus_pa: f64,
    /// Shear modulus in Pa, in planes that contain the fibres.
    pub shear_modulus_pa: f64,
    /// Density in kg/m³.
    pub density_kg_m3: f64,
    /// Properties perpendicular to the fibres; `None` for isotropic materials.
    pub across: Option<Across>,
}

/// Properties of a unidirectional material perpendicular to its fibres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Across {
    /// Young's modulus perpendicular to the fibres in Pa.
    pub youngs_modulus_pa: f64,
    /// Major Poisson's ratio: transverse contraction divided by extension along the fibres.
    pub poisson_ratio: f64,
    /// Shear modulus in the plane perpendicular to the fibres in Pa.
    pub shear_modulus_pa: f64,
}

impl Material {
    /// Poisson's ratio of an isotropic material; 0 for other materials, to which formulas with Poisson's ratio do not apply.
    pub(in crate::shapes) fn poisson_ratio(&self) -> f64 {
        if self.across.is_some() { 0.0 } else { 0.5 * self.youngs_modulus_pa / self.shear_modulus_pa - 1.0 }
    }
}

/// A named material with its source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedMaterial {
    /// Name in model files.
    pub name: &'static str,
    /// Properties of the material.
    pub material: Material,
    /// Source of the values.
    pub source: &'static str,
}

const fn isotropic(
    name: &'static str,
    youngs_modulus_pa: f64,
    shear_modulus_pa: f64,
    density_kg_m3: f64,
    source: &'static str,
) -> NamedMaterial {
    NamedMaterial {
        name,
        material: Material { youngs_modulus_pa, shear_modulus_pa, density_kg_m3, across: None },
        source,
    }
}

/// Arguments: Young's and shear modulus along the fibres; Young's modulus, major Poisson's ratio and shear modulus perpendicular to them;
/// density.
const fn along_fibres(
    name: &'static str,
    [along, shear, across, ratio, across_shear, density]: [f64; 6],
    source: &'static str,
) -> NamedMaterial {
    let across = Across { youngs_modulus_pa: across, poisson_ratio: ratio, shear_modulus_pa: across_shear };
    let material =
        Material { youngs_modulus_pa: along, shear_modulus_pa: shear, density_kg_m3: density, across: Some(across) };
    NamedMaterial { name, material, source }
}

const MMPDS: &str = "MIL-HDBK-5J (2003), room temperature; typical value, unchecked";
const DANIEL: &str = "Daniel and Ishai, Engineering Mechanics of Composite Materials, 2nd ed. (2006), appendix A; typical value, unchecked";
const LAMINATED: &str = "lamination theory of the unidirectional material of the same name";
const WOOD: &str = "USDA Wood Handbook FPL-GTR-190 (2010), chapter 5, at 12 % moisture; typical value, unchecked";

/// Library of materials: typical values at room temperature, not design allowables.
pub const MATERIALS: &[NamedMaterial] = &[
    isotropic("aluminium 2024-T3", 72.4e9, 27.6e9, 2770.0, MMPDS),
    isotropic("aluminium 6061-T6", 68.3e9, 26.2e9, 2710.0, MMPDS),
    isotropic("aluminium 7075-T6", 71.0e9, 26.9e9, 2800.0, MMPDS),
    isotropic("steel 4130", 200.0e9, 75.8e9, 7830.0, MMPDS),
    isotropic(
        "steel S355",
        210.0e9,
        80.8e9,
        7850.0,
        "EN 1993-1-1 (2005), 3.2.6, as tabulated by eurocodeapplied.com: E = 210 GPa, Poisson's ratio 0.3",
    ),
    isotropic(
        "steel 304",
        200.0e9,
        76.9e9,
        7900.0,
        "EN 1993-1-4 (2006) and EN 10088-1: E = 200 GPa, Poisson's ratio 0.3; typical value, unchecked",
    ),
    isotropic("titanium Ti-6Al-4V", 110.0e9, 42.7e9, 4430.0, MMPDS),
    isotropic("magnesium AZ31B", 44.8e9, 16.5e9, 1770.0, MMPDS),
    along_fibres("CFRP AS4/3501-6", [147.0e9, 7.0e9, 10.3e9, 0.27, 3.7e9, 1600.0], DANIEL),
    isotropic("CFRP AS4/3501-6 quasi-isotropic", 58.2e9, 22.6e9, 1600.0, LAMINATED),
    along_fibres("GFRP E-glass/epoxy", [41.0e9, 4.3e9, 10.4e9, 0.28, 3.5e9, 1970.0], DANIEL),
    isotropic("GFRP E-glass/epoxy quasi-isotropic", 20.6e9, 7.96e9, 1970.0, LAMINATED),
    along_fibres("aramid 49/epoxy", [80.0e9, 2.2e9, 5.5e9, 0.34, 1.8e9, 1380.0], DANIEL),
    along_fibres("balsa", [3.4e9, 0.18e9, 0.16e9, 0.23, 0.017e9, 180.0], WOOD),
    along_fibres("Sitka spruce", [10.8e9, 0.69e9, 0.84e9, 0.37, 0.032e9, 450.0], WOOD),
    isotropic(
        "PLA",
        3.5e9,
        1.29e9,
        1250.0,
        "Farah et al., Adv. Drug Deliv. Rev. 107 (2016) 367: solid; printed parts are softer and lighter; typical value, unchecked",
    ),
    isotropic(
        "polyamide 12",
        1.65e9,
        0.59e9,
        930.0,
        "EOS PA 2200, data sheet: sintered; Poisson's ratio 0.4; typical value, unchecked",
    ),
    isotropic(
        "polycarbonate",
        2.4e9,
        0.876e9,
        1200.0,
        "Covestro Makrolon 2405, data sheet (ISO 527, ISO 1183): E and density; Poisson's ratio 0.37 is unchecked",
    ),
    isotropic("Rohacell 51 IG", 70.0e6, 19.0e6, 52.0, "Evonik Rohacell 51 IG, data sheet; typical value, unchecked"),
];

/// Returns the material of the library with this name.
pub fn named_material(name: &str) -> Option<Material> {
    MATERIALS.iter().find(|named| named.name == name).map(|named| named.material)
}

/// All names of the library, in quotes and separated by commas.
pub(crate) fn names_of_materials() -> String {
    MATERIALS.iter().map(|named| format!("{:?}", named.name)).collect::<Vec<_>>().join(", ")
}

/// Name most similar to an unknown one, among the materials of the model file and of the library: by edit distance, otherwise by its
/// parts, such as `7075` for `aluminium 7075-T6`.
pub(crate) fn nearest_name<'n>(name: &str, own: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let known: Vec<&'n str> = own.into_iter().chain(MATERIALS.iter().map(|named| named.name)).collect();
    let plain =
        |text: &str| -> String { text.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase() };
    let separator = |letter: char| !letter.is_ascii_alphanumeric();
    // whether a word of the known name starts with this text
    let begins = |known: &str, word: &str| {
        let starts = known.char_indices().filter(|(at, _)| *at == 0 || known[..*at].ends_with(separator));
        starts.into_iter().any(|(at, _)| plain(&known[at..]).starts_with(word))
    };
    let wanted = plain(name);
    let part = || known.iter().copied().find(|known| wanted.len() > 2 && begins(known, &wanted));
    let shared = || {
        let words: Vec<String> = name.split(separator).map(plain).filter(|word| word.len() > 2).collect();
        let count = |known: &str| words.iter().filter(|word| begins(known, word)).count();
        known.iter().copied().rev().max_by_key(|known| count(known)).filter(|known| count(known) > 0)
    };
    part().or_else(|| nearest(name, known.iter().copied())).or_else(shared)
}
