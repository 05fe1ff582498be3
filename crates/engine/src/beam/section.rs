//! Cross-sections: stiffness, inertia and outline.

use crate::math::strain::{SHEARED, STRAINS, Strain, StrainMatrix};
use nalgebra::SMatrix;

/// Properties of a cross-section about the beam axis, in the section frame (`y` chordwise, `z` thickness).
///
/// Strains are ordered `(εx, κx, κy, κz)`; the axial strain at a point is `εx + z κy − y κz`, NOTATION eq. (K7).
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Symmetric positive definite stiffness for `(εx, κx, κy, κz)`: N, N·m and N·m², NOTATION eq. (S1).
    pub stiffness: StrainMatrix,
    /// Stiffness for the strains with shear `(εx, κx, κy, κz, γy, γz)`: N, N·m and N·m², NOTATION eq. (S24); `stiffness` is its
    /// condensation (S9). `None`: the section does not deform in shear.
    pub shear: Option<StrainMatrix<SHEARED>>,
    /// Mass per length in kg/m.
    pub mass_kg_m: f64,
    /// First moments of mass per length `(∫ρ y dA, ∫ρ z dA)` in kg.
    pub first_moment_kg: [f64; 2],
    /// Second moments of mass per length `(∫ρ y² dA, ∫ρ y z dA, ∫ρ z² dA)` in kg·m.
    pub second_moment_kg_m: [f64; 3],
    /// Largest |y| of the outline in m.
    pub half_width_m: f64,
    /// Largest |z| of the outline in m.
    pub half_height_m: f64,
}

/// Isotropic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus in Pa.
    pub youngs_modulus_pa: f64,
    /// Shear modulus in Pa.
    pub shear_modulus_pa: f64,
    /// Density in kg/m³.
    pub density_kg_m3: f64,
}

impl Material {
    /// Isotropic material from Young's modulus in Pa, Poisson's ratio and density in kg/m³.
    pub fn isotropic(youngs_modulus_pa: f64, poisson_ratio: f64, density_kg_m3: f64) -> Self {
        Self { youngs_modulus_pa, shear_modulus_pa: 0.5 * youngs_modulus_pa / (1.0 + poisson_ratio), density_kg_m3 }
    }

    /// Poisson's ratio `E/2G − 1`; `None` if the shear modulus is not known.
    pub fn poisson_ratio(&self) -> Option<f64> {
        (self.shear_modulus_pa > 0.0).then(|| 0.5 * self.youngs_modulus_pa / self.shear_modulus_pa - 1.0)
    }
}

/// Outline of a solid section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outline {
    /// Rectangle with sides along `y` and `z`.
    Rectangle,
    /// Ellipse with axes along `y` and `z`.
    Ellipse,
}

/// A solid section of one isotropic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    /// Outline.
    pub outline: Outline,
    /// Full width along `y` in m.
    pub width_m: f64,
    /// Full height along `z` in m.
    pub height_m: f64,
    /// Material; its shear modulus may be 0 (unknown) if `torsional_rigidity_n_m2` is given.
    pub material: Material,
    /// Torsional rigidity in N·m² that replaces Saint-Venant's value.
    pub torsional_rigidity_n_m2: Option<f64>,
    /// Factor `k` of the shear stiffness `kGA`; `None`: the section does not deform in shear.
    pub shear_factor: Option<f64>,
}

impl Solid {
    /// Rectangle with full width along `y` and full height along `z` in m.
    pub fn rectangle(width_m: f64, height_m: f64, material: Material) -> Self {
        Self {
            outline: Outline::Rectangle,
            width_m,
            height_m,
            material,
            torsional_rigidity_n_m2: None,
            shear_factor: None,
        }
    }

    /// Ellipse with full width along `y` and full height along `z` in m.
    pub fn ellipse(width_m: f64, height_m: f64, material: Material) -> Self {
        Self { outline: Outline::Ellipse, ..Self::rectangle(width_m, height_m, material) }
    }

    /// Replaces Saint-Venant's value for the outline by a torsional rigidity `GJ` in N·m².
    pub fn with_torsional_rigidity_n_m2(self, rigidity_n_m2: f64) -> Self {
        Self { torsional_rigidity_n_m2: Some(rigidity_n_m2), ..self }
    }

    /// Adds shear with the factor of the outline: 5/6 for rectangles, Cowper's `6(1+ν)/(7+6ν)` of the circle for ellipses, NOTATION eq.
    /// (S24).
    pub fn with_shear(self) -> Self {
        let ratio = self.material.poisson_ratio().unwrap_or(0.0);
        let factor = match self.outline {
            Outline::Rectangle => 5.0 / 6.0,
            Outline::Ellipse => 6.0 * (1.0 + ratio) / (7.0 + 6.0 * ratio),
        };
        Self { shear_factor: Some(factor), ..self }
    }

    /// Stiffness, inertia and outline as a section.
    pub fn section(&self) -> Section {
        let make = match self.outline {
            Outline::Rectangle => Section::rectangle,
            Outline::Ellipse => Section::ellipse,
        };
        let section = make(self.width_m, self.height_m, &self.material, self.torsional_rigidity_n_m2);
        let area_m2 = section.mass_kg_m / self.material.density_kg_m3;
        match self.shear_factor {
            None => section,
            Some(factor) => section.with_shear_stiffness_n([factor * self.material.shear_modulus_pa * area_m2; 2]),
        }
    }

    /// Saint-Venant torsion constant of the outline in m⁴, NOTATION eqs. (S2), (S3).
    pub fn torsion_constant_m4(&self) -> f64 {
        match self.outline {
            Outline::Rectangle => rectangle_torsion_constant_m4(self.width_m, self.height_m),
            Outline::Ellipse => ellipse_torsion_constant_m4(self.width_m, self.height_m),
        }
    }

    /// Returns the solid with scaled width and height, NOTATION eq. (S5). A given torsional rigidity is scaled like Saint-Venant's value
    /// for the outline.
    pub fn stretched(&self, width_factor: f64, height_factor: f64) -> Self {
        let mut solid = *self;
        solid.width_m *= width_factor;
        solid.height_m *= height_factor;
        if (width_factor, height_factor) != (1.0, 1.0) {
            let growth = solid.torsion_constant_m4() / self.torsion_constant_m4();
            solid.torsional_rigidity_n_m2 = self.torsional_rigidity_n_m2.map(|rigidity| rigidity * growth);
        }
        solid
    }

    /// Returns the solid with its density multiplied by `mass_factor` and its stiffness by `stiffness_factor`.
    pub fn scaled(&self, mass_factor: f64, stiffness_factor: f64) -> Self {
        Self {
            material: Material {
                youngs_modulus_pa: self.material.youngs_modulus_pa * stiffness_factor,
                shear_modulus_pa: self.material.shear_modulus_pa * stiffness_factor,
                density_kg_m3: self.material.density_kg_m3 * mass_factor,
            },
            torsional_rigidity_n_m2: self.torsional_rigidity_n_m2.map(|rigidity| rigidity * stiffness_factor),
            ..*self
        }
    }
}

impl Section {
    /// Solid rectangle, `width_m` along `y`, `height_m` along `z`.
    ///
    /// `torsional_rigidity_n_m2` overrides Saint-Venant's `GJ` (NOTATION eq. (S2)).
    pub fn rectangle(width_m: f64, height_m: f64, material: &Material, torsional_rigidity_n_m2: Option<f64>) -> Self {
        let area = width_m * height_m;
        let second_y = width_m * height_m.powi(3) / 12.0; // ∫z² dA
        let second_z = height_m * width_m.powi(3) / 12.0; // ∫y² dA
        let torsion = torsional_rigidity_n_m2
            .unwrap_or_else(|| material.shear_modulus_pa * rectangle_torsion_constant_m4(width_m, height_m));
        Self::solid(area, second_y, second_z, torsion, material, 0.5 * width_m, 0.5 * height_m)
    }

    /// Solid ellipse with full axes `width_m` along `y` and `height_m` along `z`.
    ///
    /// `torsional_rigidity_n_m2` overrides Saint-Venant's `GJ = G π a³ b³ / (a² + b²)` (NOTATION eq. (S3)).
    pub fn ellipse(width_m: f64, height_m: f64, material: &Material, torsional_rigidity_n_m2: Option<f64>) -> Self {
        use std::f64::consts::PI;
        let (a, b) = (0.5 * width_m, 0.5 * height_m);
        let torsion = torsional_rigidity_n_m2
            .unwrap_or_else(|| material.shear_modulus_pa * ellipse_torsion_constant_m4(width_m, height_m));
        let (second_y, second_z) = (PI * a * b.powi(3) / 4.0, PI * b * a.powi(3) / 4.0);
        Self::solid(PI * a * b, second_y, second_z, torsion, material, a, b)
    }

    fn solid(
        area: f64,
        second_y: f64,
        second_z: f64,
        torsion: f64,
        material: &Material,
        half_width_m: f64,
        half_height_m: f64,
    ) -> Self {
        let young = material.youngs_modulus_pa;
        Self {
            stiffness: StrainMatrix::from_diagonal(&Strain::<STRAINS>::new(
                young * area,
                torsion,
                young * second_y,
                young * second_z,
            )),
            mass_kg_m: material.density_kg_m3 * area,
            first_moment_kg: [0.0, 0.0],
            second_moment_kg_m: [material.density_kg_m3 * second_z, 0.0, material.density_kg_m3 * second_y],
            half_width_m,
            half_height_m,
            shear: None,
        }
    }

    /// Adds uncoupled shear stiffnesses `GA_y`, `GA_z` in N.
    pub fn with_shear_stiffness_n(self, stiffness_n: [f64; 2]) -> Self {
        Self { shear: Some(uncoupled_shear(&self.stiffness, stiffness_n)), ..self }
    }

    /// Returns the section with its inertia multiplied by `mass_factor` and its stiffness by `stiffness_factor`.
    pub fn scaled(&self, mass_factor: f64, stiffness_factor: f64) -> Self {
        Self {
            stiffness: self.stiffness * stiffness_factor,
            shear: self.shear.map(|stiffness| stiffness * stiffness_factor),
            mass_kg_m: self.mass_kg_m * mass_factor,
            first_moment_kg: self.first_moment_kg.map(|moment| moment * mass_factor),
            second_moment_kg_m: self.second_moment_kg_m.map(|moment| moment * mass_factor),
            ..*self
        }
    }

    /// Section at `fraction` of the distance to another one, with linear stiffness, inertia and outline, NOTATION eq. (S6).
    pub fn towards(&self, other: &Self, fraction: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * fraction;
        let shear = self.shear.zip(other.shear).map(|(own, other)| own.zip_map(&other, mix));
        Self {
            stiffness: shear
                .and_then(|whole| condensed(&whole))
                .unwrap_or_else(|| self.stiffness.zip_map(&other.stiffness, mix)),
            shear,
            mass_kg_m: mix(self.mass_kg_m, other.mass_kg_m),
            first_moment_kg: std::array::from_fn(|i| mix(self.first_moment_kg[i], other.first_moment_kg[i])),
            second_moment_kg_m: std::array::from_fn(|i| mix(self.second_moment_kg_m[i], other.second_moment_kg_m[i])),
            half_width_m: mix(self.half_width_m, other.half_width_m),
            half_height_m: mix(self.half_height_m, other.half_height_m),
        }
    }
}

/// Sections with a stiffness matrix for elements with `N` strains.
pub trait Stiff<const N: usize> {
    /// Stiffness matrix: N, N·m and N·m².
    fn stiffness(&self) -> StrainMatrix<N>;
}

impl Stiff<STRAINS> for Section {
    fn stiffness(&self) -> StrainMatrix {
        self.stiffness
    }
}

impl Stiff<SHEARED> for Section {
    /// Stiffness with shear; NaN for a section without shear.
    fn stiffness(&self) -> StrainMatrix<SHEARED> {
        self.shear.unwrap_or_else(|| StrainMatrix::repeat(f64::NAN))
    }
}

/// Adds uncoupled shear stiffnesses `GA_y`, `GA_z` in N to a stiffness without shear.
pub fn uncoupled_shear(stiffness: &StrainMatrix, shear_n: [f64; 2]) -> StrainMatrix<SHEARED> {
    let mut whole = StrainMatrix::<SHEARED>::zeros();
    whole.fixed_view_mut::<STRAINS, STRAINS>(0, 0).copy_from(stiffness);
    for (i, shear_n) in shear_n.into_iter().enumerate() {
        whole[(STRAINS + i, STRAINS + i)] = shear_n;
    }
    whole
}

/// Stiffness with shear from the stiffness at zero shear forces: `shears` is the block of the shears, `mixed` its coupling with the other
/// strains. `None` if that block is singular. The inverse of [`condensed`].
pub fn expanded(
    at_zero_force: &StrainMatrix,
    shears: &SMatrix<f64, { SHEARED - STRAINS }, { SHEARED - STRAINS }>,
    mixed: &SMatrix<f64, { SHEARED - STRAINS }, STRAINS>,
) -> Option<StrainMatrix<SHEARED>> {
    let inner = at_zero_force + mixed.transpose() * shears.try_inverse()? * mixed;
    let mut whole = StrainMatrix::<SHEARED>::zeros();
    whole.fixed_view_mut::<STRAINS, STRAINS>(0, 0).copy_from(&((inner + inner.transpose()) * 0.5));
    whole.fixed_view_mut::<{ SHEARED - STRAINS }, STRAINS>(STRAINS, 0).copy_from(mixed);
    whole.fixed_view_mut::<STRAINS, { SHEARED - STRAINS }>(0, STRAINS).copy_from(&mixed.transpose());
    whole.fixed_view_mut::<{ SHEARED - STRAINS }, { SHEARED - STRAINS }>(STRAINS, STRAINS).copy_from(shears);
    Some(whole)
}

/// Condenses the stiffness with shear to the stiffness at zero shear forces, NOTATION eq. (S9). `None` if the block of the shears is
/// singular.
pub fn condensed(whole: &StrainMatrix<SHEARED>) -> Option<StrainMatrix> {
    let of_shears = whole.fixed_view::<{ SHEARED - STRAINS }, { SHEARED - STRAINS }>(STRAINS, STRAINS).into_owned();
    let mixed = whole.fixed_view::<{ SHEARED - STRAINS }, STRAINS>(STRAINS, 0).into_owned();
    let condensed = whole.fixed_view::<STRAINS, STRAINS>(0, 0) - mixed.transpose() * of_shears.try_inverse()? * mixed;
    Some((condensed + condensed.transpose()) * 0.5)
}

/// Torsion constant of a solid ellipse with full axes in m, in m⁴: `π a³ b³ / (a² + b²)`, NOTATION eq. (S3).
pub fn ellipse_torsion_constant_m4(width_m: f64, height_m: f64) -> f64 {
    let (a, b) = (0.5 * width_m, 0.5 * height_m);
    std::f64::consts::PI * a.powi(3) * b.powi(3) / (a * a + b * b)
}

/// Saint-Venant torsion constant of a solid rectangle in m⁴, by a series, NOTATION eq. (S2).
///
/// The terms decrease as `k⁻⁵`; with twenty odd terms the error is below 1e-8 of the sum for any aspect ratio.
pub fn rectangle_torsion_constant_m4(width_m: f64, height_m: f64) -> f64 {
    use std::f64::consts::PI;
    let (long, short) = if width_m > height_m { (width_m, height_m) } else { (height_m, width_m) };
    let series: f64 = (0..20)
        .map(|i| {
            let k = f64::from(2 * i + 1);
            (k * PI * long / (2.0 * short)).tanh() / k.powi(5)
        })
        .sum();
    long * short.powi(3) / 3.0 * (1.0 - 192.0 * short / (PI.powi(5) * long) * series)
}
