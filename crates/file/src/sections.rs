//! Conversion of the sections in the model file to [`Section`]: outlines, stiffness matrices, inertia.

use crate::checker::Checker;
use crate::file::{ExplicitSection, SectionFile, SolidSection, TableSection};
use crate::shaped::{self, Builder, Materials};
use crate::shapes::Shape;
use crate::stations::Stations;
use foldwing_engine::beam::section::{Material, Outline, Section, Solid, condensed, uncoupled_shear};
use foldwing_engine::machine::validate::section::{are_second_moments, asymmetry, is_positive_definite, is_sound};
use foldwing_engine::math::strain::{EDGE, FLAP, SHEAR_Y, SHEAR_Z, SHEARED, STRAINS, STRETCH, StrainMatrix, TWIST};
use indexmap::IndexMap;

/// Sections of the model file by name; `None` after an error.
pub(super) type Sections<'f> = IndexMap<&'f str, Option<Built>>;

/// Section of the model file.
#[expect(clippy::large_enum_variant, reason = "there is one per section")]
pub(super) enum Built {
    /// Rectangle or ellipse of one material.
    Solid(Solid),
    /// Section given by its properties; half width and half height are 0 if not stated.
    Explicit(Section),
    /// Section given by its shape, whose dimensions may vary along a body.
    Shape(Box<Shape>),
    /// Several sections along a body.
    Table(Stations),
}

impl Built {
    /// Returns its properties if they are uniform along the body, with shear if the shear stiffness is known.
    pub fn section(&self) -> Option<Section> {
        match self {
            Self::Solid(solid) if solid.material.shear_modulus_pa > 0.0 => Some(solid.with_shear().section()),
            Self::Solid(solid) => Some(solid.section()),
            Self::Explicit(section) => Some(section.clone()),
            Self::Shape(shape) if shape.is_constant() => Some(shape.at(0.0).ok()?.section()),
            Self::Shape(_) | Self::Table(_) => None,
        }
    }

    /// Outline of the aerofoil whose skin is the section, as fractions of its chord; empty for other sections.
    pub fn aerofoil(&self) -> &[[f64; 2]] {
        match self {
            Self::Shape(shape) => shape.aerofoil(),
            Self::Solid(_) | Self::Explicit(_) | Self::Table(_) => &[],
        }
    }
}

/// Builds a section; `None` after an error.
pub(super) fn build(name: &str, section: &SectionFile, materials: &Materials, checker: &mut Checker) -> Option<Built> {
    let mut builder = Builder { name, materials, checker };
    let built = match section {
        SectionFile::Rectangle(file) => Built::Solid(solid(Outline::Rectangle, file, &mut builder)?),
        SectionFile::Ellipse(file) => Built::Solid(solid(Outline::Ellipse, file, &mut builder)?),
        SectionFile::Tube(file) => shape(builder.tube(file)?, &mut builder)?,
        SectionFile::Box(file) => {
            let (frame, material) = builder.frame(file)?;
            shape(Shape::Box(frame, material), &mut builder)?
        }
        SectionFile::I(file) => {
            let (frame, material) = builder.frame(file)?;
            shape(Shape::I(frame, material), &mut builder)?
        }
        SectionFile::C(file) => shape(builder.channel(file)?, &mut builder)?,
        SectionFile::Angle(file) => shape(builder.angle(file)?, &mut builder)?,
        SectionFile::Profile(file) => shape(builder.profile(file)?, &mut builder)?,
        SectionFile::Laminate(file) => shape(builder.laminate(file)?, &mut builder)?,
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

/// Checks that the dimensions of a shape at the inner end of a body give a section.
fn shape(shape: Shape, builder: &mut Builder) -> Option<Built> {
    match shape.at(0.0) {
        Ok(_) => Some(Built::Shape(Box::new(shape))),
        Err(refused) => {
            let body = (!shape.is_constant()).then_some("");
            shaped::refuse(builder.name, body, &refused, builder.checker);
            None
        }
    }
}

fn build_table(name: &str, table: &TableSection, checker: &mut Checker) -> Option<Stations> {
    match (&table.along, &table.file) {
        (Some(along), None) => along.stations(name, checker),
        (Some(_), Some(_)) => {
            checker.refuse(&["section", name, "file"], "either along or file, not both");
            None
        }
        (None, Some(_)) => {
            let allowed = "a file name, if the model itself is read from a file; a model given as text must have along";
            checker.refuse(&["section", name, "file"], allowed);
            None
        }
        (None, None) => {
            checker.refuse(&["section", name, "along"], "a table of properties at stations, or a file");
            None
        }
    }
}

fn solid(outline: Outline, file: &SolidSection, builder: &mut Builder) -> Option<Solid> {
    Some(Solid {
        outline,
        width_m: file.width_m,
        height_m: file.height_m,
        material: material(file, builder)?,
        torsional_rigidity_n_m2: file.torsional_rigidity_n_m2,
        shear_factor: None,
    })
}

/// Material of a solid section, given by name or by its properties.
fn material(solid: &SolidSection, Builder { name, materials, checker }: &mut Builder) -> Option<Material> {
    let at = |key| ["section", *name, key];
    if let Some(named) = &solid.material {
        let properties = [
            ("density_kg_m3", solid.density_kg_m3),
            ("youngs_modulus_Pa", solid.youngs_modulus_pa),
            ("shear_modulus_Pa", solid.shear_modulus_pa),
            ("poisson_ratio", solid.poisson_ratio),
        ];
        if let Some((key, _)) = properties.iter().find(|(_, value)| value.is_some()) {
            checker.refuse(&at(key), "either material or density and moduli, not both");
            return None;
        }
        let found = shaped::material(&at("material"), named, materials, checker)?;
        return Some(Material {
            youngs_modulus_pa: found.youngs_modulus_pa,
            shear_modulus_pa: found.shear_modulus_pa,
            density_kg_m3: found.density_kg_m3,
        });
    }
    for (key, quantity, value) in [
        ("density_kg_m3", "density > 0 kg/m³", solid.density_kg_m3),
        ("youngs_modulus_Pa", "modulus > 0 Pa", solid.youngs_modulus_pa),
    ] {
        if value.is_none() {
            checker.refuse(&at(key), format!("a finite {quantity}, or material = \"…\" instead"));
        }
    }
    let (density_kg_m3, youngs_modulus_pa) = (solid.density_kg_m3?, solid.youngs_modulus_pa?);
    let shear_modulus_pa = match (solid.shear_modulus_pa, solid.poisson_ratio) {
        (Some(_), Some(_)) => {
            checker.refuse(&at("poisson_ratio"), "either shear_modulus_Pa or poisson_ratio, not both");
            return None;
        }
        (Some(shear_modulus_pa), None) => shear_modulus_pa,
        (None, Some(ratio)) => 0.5 * youngs_modulus_pa / (1.0 + ratio),
        // the shear modulus affects only the torsional rigidity, which is stated
        (None, None) if solid.torsional_rigidity_n_m2.is_some() => 0.0,
        (None, None) => {
            let allowed = "a finite modulus > 0 Pa, or poisson_ratio, or torsional_rigidity_N_m2 instead";
            checker.refuse(&at("shear_modulus_Pa"), allowed);
            return None;
        }
    };
    Some(Material { youngs_modulus_pa, shear_modulus_pa, density_kg_m3 })
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
    let (stiffness, shear) = stiffness?;
    let section = Section {
        stiffness,
        shear,
        mass_kg_m: mass,
        first_moment_kg: [mass * y, mass * z],
        second_moment_kg_m: [yy + mass * y * y, yz + mass * y * z, zz + mass * z * z],
        half_width_m,
        half_height_m,
    };
    Some(Built::Explicit(section))
}

/// Second moments about the centre of mass, `[yy, yz, zz]` in kg·m, checked to be possible.
fn second_moments(name: &str, explicit: &ExplicitSection, checker: &mut Checker) -> Option<[f64; 3]> {
    if are_second_moments(explicit.second_moments_kg_m) {
        return Some(explicit.second_moments_kg_m);
    }
    let allowed = "[yy, yz, zz] in kg·m with yy >= 0, zz >= 0, yy + zz > 0 and yz² <= yy zz";
    checker.refuse(&["section", name, "second_moments_kg_m"], allowed);
    None
}

/// Stiffness for the strains without shear, and with shear if it is known.
type Stiffness = (StrainMatrix, Option<StrainMatrix<SHEARED>>);

/// Section stiffness, checked to be symmetric and positive definite.
fn stiffness(name: &str, explicit: &ExplicitSection, checker: &mut Checker) -> Option<Stiffness> {
    let stiffnesses = [
        ("axial_stiffness_N", explicit.axial_stiffness_n, STRETCH, STRETCH),
        ("torsional_rigidity_N_m2", explicit.torsional_rigidity_n_m2, TWIST, TWIST),
        ("flap_stiffness_N_m2", explicit.flap_stiffness_n_m2, FLAP, FLAP),
        ("edge_stiffness_N_m2", explicit.edge_stiffness_n_m2, EDGE, EDGE),
    ];
    let couplings = [
        ("coupling_axial_twist_N_m", explicit.coupling_axial_twist_n_m, STRETCH, TWIST),
        ("coupling_axial_flap_N_m", explicit.coupling_axial_flap_n_m, STRETCH, FLAP),
        ("coupling_axial_edge_N_m", explicit.coupling_axial_edge_n_m, STRETCH, EDGE),
        ("coupling_twist_flap_N_m2", explicit.coupling_twist_flap_n_m2, TWIST, FLAP),
        ("coupling_twist_edge_N_m2", explicit.coupling_twist_edge_n_m2, TWIST, EDGE),
        ("coupling_flap_edge_N_m2", explicit.coupling_flap_edge_n_m2, FLAP, EDGE),
    ];
    let entries = || stiffnesses.iter().chain(&couplings);
    if let Some(rows) = explicit.stiffness_with_shear_si {
        let others = [
            ("stiffness_SI", explicit.stiffness_si.is_some()),
            ("shear_stiffness_N", explicit.shear_stiffness_n.is_some()),
        ];
        let one_by_one = entries().map(|(key, value, ..)| (*key, value.is_some()));
        if let Some((key, _)) = one_by_one.chain(others).find(|(_, stated)| *stated) {
            let allowed = "either stiffness_with_shear_SI or other stiffnesses, not both";
            checker.refuse(&["section", name, key], allowed);
            return None;
        }
        return stiffness_with_shear(name, &rows, checker);
    }
    if let Some([y, z]) = explicit.shear_stiffness_n
        && !(y > 0.0 && z > 0.0)
    {
        checker.refuse(&["section", name, "shear_stiffness_N"], "two finite stiffnesses > 0 N");
        return None;
    }
    let with_shear = |stiffness: StrainMatrix| {
        (stiffness, explicit.shear_stiffness_n.map(|shear_n| uncoupled_shear(&stiffness, shear_n)))
    };
    if let Some(rows) = explicit.stiffness_si {
        if let Some((key, ..)) = entries().find(|(_, value, ..)| value.is_some()) {
            checker.refuse(&["section", name, key], "either stiffness_SI or the stiffnesses one by one, not both");
            return None;
        }
        return full_stiffness(name, "stiffness_SI", &rows, checker).map(with_shear);
    }
    let missing: Vec<_> = stiffnesses.iter().filter(|(_, value, ..)| value.is_none()).collect();
    for (key, ..) in &missing {
        checker.refuse(&["section", name, key], "a finite stiffness > 0, or the whole matrix stiffness_SI instead");
    }
    if !missing.is_empty() {
        return None;
    }
    let mut matrix = StrainMatrix::<STRAINS>::zeros();
    for (_, value, row, column) in entries() {
        matrix[(*row, *column)] = value.unwrap_or(0.0);
        matrix[(*column, *row)] = value.unwrap_or(0.0);
    }
    if !is_positive_definite(&matrix) {
        let key = couplings.iter().find(|(_, value, ..)| value.is_some()).map_or("axial_stiffness_N", |(key, ..)| key);
        checker.refuse(&["section", name, key], "couplings that leave the stiffness matrix positive definite");
        return None;
    }
    Some(with_shear(matrix))
}

/// Order of the strains `(εx, γy, γz, κx, κy, κz)` in a full matrix of the file, given by their indices.
const FULL_ORDER: [usize; SHEARED] = [STRETCH, SHEAR_Y, SHEAR_Z, TWIST, FLAP, EDGE];

/// Condensed stiffness, and full stiffness with shear, NOTATION eqs. (S9), (S24).
fn stiffness_with_shear(name: &str, rows: &[[f64; SHEARED]; SHEARED], checker: &mut Checker) -> Option<Stiffness> {
    let full = full_stiffness(name, "stiffness_with_shear_SI", rows, checker)?;
    let mut whole = StrainMatrix::<SHEARED>::zeros();
    for (i, row) in FULL_ORDER.into_iter().enumerate() {
        for (j, column) in FULL_ORDER.into_iter().enumerate() {
            whole[(row, column)] = full[(i, j)];
        }
    }
    Some((condensed(&whole)?, Some(whole)))
}

fn full_stiffness<const N: usize>(
    name: &str,
    key: &str,
    rows: &[[f64; N]; N],
    checker: &mut Checker,
) -> Option<StrainMatrix<N>> {
    let path = ["section", name, key];
    let matrix = StrainMatrix::<N>::from_fn(|i, j| rows[i][j]);
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
