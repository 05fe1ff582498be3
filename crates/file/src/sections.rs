//! Sections of the file to [`Section`]: outlines, stiffness matrices, inertia.

use crate::file::{ExplicitSection, SectionFile, SolidSection, TableSection};
use crate::stations::Places;
use crate::validate::Checker;
use foldwing_engine::beam::section::{Material, Outline, Section, Solid};
use foldwing_engine::machine::validate::section::{are_second_moments, asymmetry, is_positive_definite, is_sound};
use indexmap::IndexMap;
use nalgebra::Matrix4;

/// Sections of the file by name; `None` after an error.
pub(super) type Sections<'f> = IndexMap<&'f str, Option<Built>>;

/// A section of the file.
pub(super) enum Built {
    /// Rectangle or ellipse of one material.
    Solid(Solid),
    /// By its properties; half width and half height are 0 if they are not stated.
    Explicit(Section),
    /// Several along a body.
    Table(Stations),
}

/// Sections along a body.
pub(super) struct Stations {
    /// Their positions.
    pub places: Places,
    /// The sections there.
    pub sections: Vec<Section>,
}

impl Built {
    /// Its properties, if they are the same everywhere.
    pub fn section(&self) -> Option<Section> {
        match self {
            Self::Solid(solid) => Some(solid.section()),
            Self::Explicit(section) => Some(section.clone()),
            Self::Table(_) => None,
        }
    }
}

/// Builds a section; `None` if a problem was found.
pub(super) fn build(name: &str, section: &SectionFile, checker: &mut Checker) -> Option<Built> {
    let built = match section {
        SectionFile::Rectangle(file) => Built::Solid(solid(name, Outline::Rectangle, file, checker)?),
        SectionFile::Ellipse(file) => Built::Solid(solid(name, Outline::Ellipse, file, checker)?),
        SectionFile::Explicit(explicit) => build_explicit(name, explicit, checker)?,
        SectionFile::Table(table) => return build_table(name, table, checker).map(Built::Table),
    };
    if built.section().is_some_and(|section| !is_sound(&section)) {
        let allowed = "dimensions and material whose mass, inertia and stiffness are positive, finite numbers in SI";
        checker.refuse_as(&["section", name], "a section of such dimensions", allowed);
        return None;
    }
    Some(built)
}

fn build_table(name: &str, table: &TableSection, checker: &mut Checker) -> Option<Stations> {
    match (&table.along, &table.file) {
        (Some(along), None) => along.stations(name, checker),
        (Some(_), Some(_)) => {
            checker.refuse(&["section", name, "file"], "either along or file, not both");
            None
        }
        (None, Some(_)) => {
            let allowed = "a file name, if the model itself is read from a file; a model given as text states along";
            checker.refuse(&["section", name, "file"], allowed);
            None
        }
        (None, None) => {
            checker.refuse(&["section", name, "along"], "a table of properties at stations, or a file");
            None
        }
    }
}

fn solid(name: &str, outline: Outline, file: &SolidSection, checker: &mut Checker) -> Option<Solid> {
    Some(Solid {
        outline,
        width_m: file.width_m,
        height_m: file.height_m,
        material: material(name, file, checker)?,
        torsional_rigidity_n_m2: file.torsional_rigidity_n_m2,
    })
}

fn material(name: &str, solid: &SolidSection, checker: &mut Checker) -> Option<Material> {
    let shear_modulus_pa = match (solid.shear_modulus_pa, solid.poisson_ratio) {
        (Some(_), Some(_)) => {
            checker.refuse(&["section", name, "poisson_ratio"], "either shear_modulus_Pa or poisson_ratio, not both");
            return None;
        }
        (Some(shear_modulus_pa), None) => shear_modulus_pa,
        (None, Some(ratio)) => 0.5 * solid.youngs_modulus_pa / (1.0 + ratio),
        // The shear modulus acts through the torsional rigidity alone.
        (None, None) if solid.torsional_rigidity_n_m2.is_some() => 0.0,
        (None, None) => {
            let allowed = "a finite modulus > 0 Pa, or poisson_ratio, or torsional_rigidity_N_m2 instead";
            checker.refuse(&["section", name, "shear_modulus_Pa"], allowed);
            return None;
        }
    };
    Some(Material { youngs_modulus_pa: solid.youngs_modulus_pa, shear_modulus_pa, density_kg_m3: solid.density_kg_m3 })
}

fn build_explicit(name: &str, explicit: &ExplicitSection, checker: &mut Checker) -> Option<Built> {
    let stiffness = stiffness(name, explicit, checker);
    let second_moments = second_moments(name, explicit, checker);
    let (half_width_m, half_height_m) = match (explicit.half_width_m, explicit.half_height_m) {
        (Some(half_width_m), Some(half_height_m)) => (half_width_m, half_height_m),
        (None, None) => (0.0, 0.0),
        (width, _) => {
            let missing = if width.is_none() { "half_width_m" } else { "half_height_m" };
            checker.refuse(&["section", name, missing], "half_width_m and half_height_m together, or neither");
            return None;
        }
    };
    let (mass, [y, z]) = (explicit.mass_kg_m, explicit.centre_of_mass_m);
    let [yy, yz, zz] = second_moments?;
    let section = Section {
        stiffness: stiffness?,
        mass_kg_m: mass,
        first_moment_kg: [mass * y, mass * z],
        second_moment_kg_m: [yy + mass * y * y, yz + mass * y * z, zz + mass * z * z],
        half_width_m,
        half_height_m,
    };
    Some(Built::Explicit(section))
}

/// Second moments about the centre of mass, `[yy, yz, zz]` in kg·m, checked.
fn second_moments(name: &str, explicit: &ExplicitSection, checker: &mut Checker) -> Option<[f64; 3]> {
    if are_second_moments(explicit.second_moments_kg_m) {
        return Some(explicit.second_moments_kg_m);
    }
    let allowed = "[yy, yz, zz] in kg·m with yy >= 0, zz >= 0, yy + zz > 0 and yz² <= yy zz";
    checker.refuse(&["section", name, "second_moments_kg_m"], allowed);
    None
}

/// The section stiffness, symmetric and positive definite.
fn stiffness(name: &str, explicit: &ExplicitSection, checker: &mut Checker) -> Option<Matrix4<f64>> {
    let stiffnesses = [
        ("axial_stiffness_N", explicit.axial_stiffness_n, 0, 0),
        ("torsional_rigidity_N_m2", explicit.torsional_rigidity_n_m2, 1, 1),
        ("flap_stiffness_N_m2", explicit.flap_stiffness_n_m2, 2, 2),
        ("edge_stiffness_N_m2", explicit.edge_stiffness_n_m2, 3, 3),
    ];
    let couplings = [
        ("coupling_axial_twist_N_m", explicit.coupling_axial_twist_n_m, 0, 1),
        ("coupling_axial_flap_N_m", explicit.coupling_axial_flap_n_m, 0, 2),
        ("coupling_axial_edge_N_m", explicit.coupling_axial_edge_n_m, 0, 3),
        ("coupling_twist_flap_N_m2", explicit.coupling_twist_flap_n_m2, 1, 2),
        ("coupling_twist_edge_N_m2", explicit.coupling_twist_edge_n_m2, 1, 3),
        ("coupling_flap_edge_N_m2", explicit.coupling_flap_edge_n_m2, 2, 3),
    ];
    let entries = || stiffnesses.iter().chain(&couplings);
    if let Some(rows) = explicit.stiffness_si {
        if let Some((key, ..)) = entries().find(|(_, value, ..)| value.is_some()) {
            checker.refuse(&["section", name, key], "either stiffness_SI or the stiffnesses one by one, not both");
            return None;
        }
        return full_stiffness(name, &rows, checker);
    }
    let missing: Vec<_> = stiffnesses.iter().filter(|(_, value, ..)| value.is_none()).collect();
    for (key, ..) in &missing {
        checker.refuse(&["section", name, key], "a finite stiffness > 0, or the whole matrix stiffness_SI instead");
    }
    if !missing.is_empty() {
        return None;
    }
    let mut matrix = Matrix4::zeros();
    for (_, value, row, column) in entries() {
        matrix[(*row, *column)] = value.unwrap_or(0.0);
        matrix[(*column, *row)] = value.unwrap_or(0.0);
    }
    if !is_positive_definite(&matrix) {
        let key = couplings.iter().find(|(_, value, ..)| value.is_some()).map_or("axial_stiffness_N", |(key, ..)| key);
        checker.refuse(&["section", name, key], "couplings that leave the stiffness matrix positive definite");
        return None;
    }
    Some(matrix)
}

fn full_stiffness(name: &str, rows: &[[f64; 4]; 4], checker: &mut Checker) -> Option<Matrix4<f64>> {
    let path = ["section", name, "stiffness_SI"];
    let matrix = Matrix4::from_fn(|i, j| rows[i][j]);
    if let Some((i, j)) = asymmetry(&matrix) {
        let (lower, upper) = (matrix[(i, j)], matrix[(j, i)]);
        let found =
            format!("{lower} in row {}, column {} and {upper} in row {}, column {}", i + 1, j + 1, j + 1, i + 1);
        checker.refuse_as(&path, found, "a symmetric matrix");
        return None;
    }
    let symmetric = 0.5 * (matrix + matrix.transpose());
    if !is_positive_definite(&symmetric) {
        checker.refuse_as(&path, "a matrix that is not positive definite", "a symmetric positive definite matrix");
        return None;
    }
    Some(symmetric)
}
