//! Cross-sections: stiffness, inertia and outline.

use nalgebra::Matrix4;

/// Properties of a cross-section, about the beam axis and in the section frame (`y` chordwise, `z` thickness).
///
/// Strains are ordered `(εx, κx, κy, κz)`; the axial strain at a point is `εx + z κy − y κz`, NOTATION eq. (K7).
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Symmetric positive definite stiffness of `(εx, κx, κy, κz)`: N, N·m and N·m², NOTATION eq. (S1).
    pub stiffness: Matrix4<f64>,
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
    pub young_pa: f64,
    /// Shear modulus in Pa.
    pub shear_pa: f64,
    /// Density in kg/m³.
    pub density_kg_m3: f64,
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
            .unwrap_or_else(|| material.shear_pa * rectangle_torsion_constant_m4(width_m, height_m));
        Self::solid(area, second_y, second_z, torsion, material, 0.5 * width_m, 0.5 * height_m)
    }

    /// Solid ellipse with full axes `width_m` along `y` and `height_m` along `z`.
    ///
    /// `torsional_rigidity_n_m2` overrides Saint-Venant's `GJ = G π a³ b³ / (a² + b²)` (NOTATION eq. (S3)).
    pub fn ellipse(width_m: f64, height_m: f64, material: &Material, torsional_rigidity_n_m2: Option<f64>) -> Self {
        use std::f64::consts::PI;
        let (a, b) = (0.5 * width_m, 0.5 * height_m);
        let torsion =
            torsional_rigidity_n_m2.unwrap_or_else(|| material.shear_pa * PI * a.powi(3) * b.powi(3) / (a * a + b * b));
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
        let young = material.young_pa;
        Self {
            stiffness: Matrix4::from_diagonal(&nalgebra::Vector4::new(
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
        }
    }

    /// The same section with its inertia multiplied by `mass_factor` and its stiffness by `stiffness_factor`.
    pub fn scaled(&self, mass_factor: f64, stiffness_factor: f64) -> Self {
        Self {
            stiffness: self.stiffness * stiffness_factor,
            mass_kg_m: self.mass_kg_m * mass_factor,
            first_moment_kg: self.first_moment_kg.map(|moment| moment * mass_factor),
            second_moment_kg_m: self.second_moment_kg_m.map(|moment| moment * mass_factor),
            ..*self
        }
    }
}

/// Saint-Venant torsion constant of a solid rectangle in m⁴ by its series, NOTATION eq. (S2).
///
/// The terms fall with `k⁻⁵`; twenty odd terms leave an error below 1e-8 of the sum for any aspect ratio.
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
