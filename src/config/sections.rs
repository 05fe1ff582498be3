//! Sections of the file to [`Section`]: outlines, stiffness matrices, inertia.

use crate::beam::section::{Material, Outline, Section, Solid};
use crate::config::file::{ExplicitSection, SectionFile, SolidSection};
use crate::config::validate::Checker;
use crate::machine::UNLIMITED;
use indexmap::IndexMap;
use nalgebra::{Cholesky, Matrix4};

/// Asymmetry of a stiffness matrix that is taken for round-off, relative to its diagonal.
const SYMMETRY_TOLERANCE: f64 = 1e-9;

/// Smallest pivot of a stiffness matrix scaled to a unit diagonal: below it the matrix counts as singular.
const SMALLEST_PIVOT: f64 = 1e-10;

/// Sections of the file by name; `None` where a problem was found.
pub(super) type Sections<'f> = IndexMap<&'f str, Option<Built>>;

/// A section as the file gives it.
pub(super) enum Built {
    /// Rectangle or ellipse of one material.
    Solid(Solid),
    /// By its properties; gauges need to know whether its half width and half height are stated.
    Explicit {
        /// The section.
        section: Section,
        /// Half width and half height are stated.
        has_outline: bool,
    },
}

impl Built {
    /// Its properties.
    pub fn section(&self) -> Section {
        match self {
            Self::Solid(solid) => solid.section(),
            Self::Explicit { section, .. } => section.clone(),
        }
    }

    /// True where the outline is known.
    pub fn has_outline(&self) -> bool {
        matches!(self, Self::Solid(_) | Self::Explicit { has_outline: true, .. })
    }
}

/// Builds a section; `None` if a problem was found.
pub(super) fn build(name: &str, section: &SectionFile, checker: &mut Checker) -> Option<Built> {
    let built = match section {
        SectionFile::Rectangle(file) => Built::Solid(solid(name, Outline::Rectangle, file, checker)?),
        SectionFile::Ellipse(file) => Built::Solid(solid(name, Outline::Ellipse, file, checker)?),
        SectionFile::Explicit(explicit) => build_explicit(name, explicit, checker)?,
    };
    if !is_sound(&built.section()) {
        let allowed = "dimensions and material whose mass, inertia and stiffness are positive, finite numbers in SI";
        checker.refuse_as(&["section", name], "a section of such dimensions", allowed);
        return None;
    }
    Some(built)
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

/// True where nothing overflowed or underflowed on the way from dimensions to properties.
pub(super) fn is_sound(section: &Section) -> bool {
    let in_range = |value: f64| value > 0.0 && value <= UNLIMITED;
    let [yy, _, zz] = section.second_moment_kg_m;
    section.stiffness.diagonal().iter().copied().all(in_range) && in_range(section.mass_kg_m) && in_range(yy + zz)
}

fn material(name: &str, solid: &SolidSection, checker: &mut Checker) -> Option<Material> {
    let shear_pa = match (solid.shear_pa, solid.poisson_ratio) {
        (Some(_), Some(_)) => {
            checker.refuse(&["section", name, "poisson_ratio"], "either shear_Pa or poisson_ratio, not both");
            return None;
        }
        (Some(shear_pa), None) => shear_pa,
        (None, Some(ratio)) => 0.5 * solid.young_pa / (1.0 + ratio),
        // The shear modulus acts through the torsional rigidity alone.
        (None, None) if solid.torsional_rigidity_n_m2.is_some() => 0.0,
        (None, None) => {
            let allowed = "a finite modulus > 0 Pa, or poisson_ratio, or torsional_rigidity_N_m2 instead";
            checker.refuse(&["section", name, "shear_Pa"], allowed);
            return None;
        }
    };
    Some(Material { young_pa: solid.young_pa, shear_pa, density_kg_m3: solid.density_kg_m3 })
}

fn build_explicit(name: &str, explicit: &ExplicitSection, checker: &mut Checker) -> Option<Built> {
    let stiffness = stiffness(name, explicit, checker);
    let second_moments = second_moments(name, explicit, checker);
    let (half_width_m, half_height_m, has_outline) = match (explicit.half_width_m, explicit.half_height_m) {
        (Some(half_width_m), Some(half_height_m)) => (half_width_m, half_height_m, true),
        (None, None) => (0.0, 0.0, false),
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
    Some(Built::Explicit { section, has_outline })
}

/// Second moments about the centre of mass, `[yy, yz, zz]` in kg·m, checked.
fn second_moments(name: &str, explicit: &ExplicitSection, checker: &mut Checker) -> Option<[f64; 3]> {
    let [yy, yz, zz] = explicit.second_moments_kg_m;
    let semidefinite = yy >= 0.0 && zz >= 0.0 && yz.abs() <= (yy.sqrt() * zz.sqrt()) * (1.0 + 1e-9);
    if semidefinite && yy + zz > 0.0 {
        return Some([yy, yz, zz]);
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
        ("lag_stiffness_N_m2", explicit.lag_stiffness_n_m2, 3, 3),
    ];
    let couplings = [
        ("coupling_axial_twist_N_m", explicit.coupling_axial_twist_n_m, 0, 1),
        ("coupling_axial_flap_N_m", explicit.coupling_axial_flap_n_m, 0, 2),
        ("coupling_axial_lag_N_m", explicit.coupling_axial_lag_n_m, 0, 3),
        ("coupling_twist_flap_N_m2", explicit.coupling_twist_flap_n_m2, 1, 2),
        ("coupling_twist_lag_N_m2", explicit.coupling_twist_lag_n_m2, 1, 3),
        ("coupling_flap_lag_N_m2", explicit.coupling_flap_lag_n_m2, 2, 3),
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
    let scale = |i: usize, j: usize| matrix[(i, i)].abs().sqrt() * matrix[(j, j)].abs().sqrt();
    for i in 0..4 {
        for j in 0..i {
            let (lower, upper) = (matrix[(i, j)], matrix[(j, i)]);
            if (lower - upper).abs() > SYMMETRY_TOLERANCE * scale(i, j) {
                let found = format!(
                    "{lower} in row {}, column {} and {upper} in row {}, column {}",
                    i + 1,
                    j + 1,
                    j + 1,
                    i + 1
                );
                checker.refuse_as(&path, found, "a symmetric matrix");
                return None;
            }
        }
    }
    let symmetric = 0.5 * (matrix + matrix.transpose());
    if !is_positive_definite(&symmetric) {
        checker.refuse_as(&path, "a matrix that is not positive definite", "a symmetric positive definite matrix");
        return None;
    }
    Some(symmetric)
}

/// True where a symmetric matrix, scaled to a unit diagonal, has pivots above [`SMALLEST_PIVOT`].
fn is_positive_definite(matrix: &Matrix4<f64>) -> bool {
    let diagonal = matrix.diagonal();
    if diagonal.iter().any(|entry| *entry <= 0.0) {
        return false;
    }
    let scaled = Matrix4::from_fn(|i, j| matrix[(i, j)] / (diagonal[i].sqrt() * diagonal[j].sqrt()));
    Cholesky::new(scaled).is_some_and(|factor| factor.l().diagonal().iter().all(|pivot| pivot * pivot > SMALLEST_PIVOT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definiteness_does_not_depend_on_units() {
        // A bend–twist coupling of 99 % of the geometric mean, stiffnesses eight decades apart.
        let mut matrix = Matrix4::from_diagonal(&nalgebra::Vector4::new(1e9, 1e1, 2e1, 3e2));
        let coupling = 0.99 * (1e1_f64 * 2e1).sqrt();
        (matrix[(1, 2)], matrix[(2, 1)]) = (coupling, coupling);
        assert!(is_positive_definite(&matrix));
        (matrix[(1, 2)], matrix[(2, 1)]) = (coupling / 0.98, coupling / 0.98);
        assert!(!is_positive_definite(&matrix));
    }
}
