//! Constant inertia of the beam element: mass matrix of the fully parameterised ANCF element, \[O\] (1)–(4).

use crate::beam::law::{NaturalStrain, SectionLaw};
use crate::beam::section::{Section, Stiff};
use crate::math::quadrature::gauss_pieces;
use crate::math::strain::{STRAINS, Strain, StrainMatrix};
use nalgebra::{Matrix4, SMatrix, Vector3};

/// Blocks of the reduced element mass matrix `m̂` (8×8, `M_e = m̂ ⊗ I₃`) over the nodal vectors
/// `(r, r_x, r_y, r_z)` of the inner end `a` and the outer end `b`, NOTATION eq. (D1).
///
/// Units follow the vectors: kg for `r`–`r`, kg·m for `r`–gradient, kg·m² for gradient–gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementMass {
    /// Block of the inner end.
    pub inner: Matrix4<f64>,
    /// Block of the outer end.
    pub outer: Matrix4<f64>,
    /// Coupling block: rows of the outer end, columns of the inner end.
    pub cross: Matrix4<f64>,
}

impl ElementMass {
    /// Mass matrix of an element of `length_m` whose section is `section(ξ)` at `ξ ∈ [0, 1]`.
    ///
    /// Four Gauss points are exact for sections that vary linearly along the element (shape functions are cubic).
    pub fn new(length_m: f64, section: impl Fn(f64) -> Section) -> Self {
        Self::with_kinks(length_m, section, &[])
    }

    /// Mass matrix for a section with kinks at some `ξ`: four Gauss points between each pair of kinks.
    pub fn with_kinks(length_m: f64, section: impl Fn(f64) -> Section, kinks: &[f64]) -> Self {
        let mut mass = SMatrix::<f64, 8, 8>::zeros();
        for (xi, weight) in gauss_pieces(0.0, 1.0, kinks) {
            let section = section(xi);
            let shape = shape_functions(length_m, xi);
            let (s, p, q) = (shape.axis, shape.y, shape.z);
            let [first_y, first_z] = section.first_moment_kg;
            let [yy, yz, zz] = section.second_moment_kg_m;
            mass += (s * s.transpose() * section.mass_kg_m
                + (s * p.transpose() + p * s.transpose()) * first_y
                + (s * q.transpose() + q * s.transpose()) * first_z
                + p * p.transpose() * yy
                + (p * q.transpose() + q * p.transpose()) * yz
                + q * q.transpose() * zz)
                * (weight * length_m);
        }
        Self {
            inner: mass.fixed_view::<4, 4>(0, 0).into_owned(),
            outer: mass.fixed_view::<4, 4>(4, 4).into_owned(),
            cross: mass.fixed_view::<4, 4>(4, 0).into_owned(),
        }
    }
}

/// Shape functions of the element: `r(ξ, y, z) = Σ (axis + y·y + z·z)_k e_k`, NOTATION eq. (D2).
struct ShapeFunctions {
    axis: SMatrix<f64, 8, 1>,
    y: SMatrix<f64, 8, 1>,
    z: SMatrix<f64, 8, 1>,
}

fn shape_functions(length_m: f64, xi: f64) -> ShapeFunctions {
    let (x2, x3) = (xi * xi, xi * xi * xi);
    let axis = [
        1.0 - 3.0 * x2 + 2.0 * x3,
        length_m * (xi - 2.0 * x2 + x3),
        0.0,
        0.0,
        3.0 * x2 - 2.0 * x3,
        length_m * (x3 - x2),
        0.0,
        0.0,
    ];
    ShapeFunctions {
        axis: axis.into(),
        y: [0.0, 0.0, 1.0 - xi, 0.0, 0.0, 0.0, xi, 0.0].into(),
        z: [0.0, 0.0, 0.0, 1.0 - xi, 0.0, 0.0, 0.0, xi].into(),
    }
}

/// Nodal vectors `(r, r_x, r_y, r_z)`, or their rates, at `ξ` of an element of `length_m`, interpolated between its inner and outer end:
/// `r` and its derivative along the axis by the cubic of eq. (D2), the others linearly.
pub fn shape_at(length_m: f64, xi: f64, inner: &[Vector3<f64>; 4], outer: &[Vector3<f64>; 4]) -> [Vector3<f64>; 4] {
    let shape = shape_functions(length_m, xi);
    let slope = [6.0 * (xi * xi - xi) / length_m, 1.0 - 4.0 * xi + 3.0 * xi * xi, 3.0 * xi * xi - 2.0 * xi];
    let of = |weights: &SMatrix<f64, 8, 1>| {
        (0..4).map(|k| inner[k] * weights[k] + outer[k] * weights[k + 4]).sum::<Vector3<f64>>()
    };
    let along = (inner[0] - outer[0]) * slope[0] + inner[1] * slope[1] + outer[1] * slope[2];
    [of(&shape.axis), along, of(&shape.y), of(&shape.z)]
}

/// Pseudo-inertia of a rigid body in the nodal coordinates: `m̂ = [[m, m cᵀ], [m c, S]]`, `S = ½ tr(J_c) I − J_c + m c cᵀ`, NOTATION eq.
/// (D3). It is added to the node's block, without special code.
pub fn rigid_body_mass(
    mass_kg: f64,
    offset_m: &nalgebra::Vector3<f64>,
    inertia_kg_m2: &nalgebra::Matrix3<f64>,
) -> Matrix4<f64> {
    let spread = nalgebra::Matrix3::identity() * (0.5 * inertia_kg_m2.trace()) - inertia_kg_m2
        + offset_m * offset_m.transpose() * mass_kg;
    let mut mass = Matrix4::zeros();
    mass[(0, 0)] = mass_kg;
    for i in 0..3 {
        mass[(0, i + 1)] = mass_kg * offset_m[i];
        mass[(i + 1, 0)] = mass_kg * offset_m[i];
        for j in 0..3 {
            mass[(i + 1, j + 1)] = spread[(i, j)];
        }
    }
    mass
}

/// Kind of strain element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementKind {
    /// Constant strain: second-order accurate.
    Constant,
    /// Linear strain by the pair rule, two constant-strain halves with coupled stiffness: fourth-order accurate.
    Linear,
}

/// Elastic properties of one element: a constant-strain element, or the two halves of a pair.
///
/// | symbol             | field            | shape               | unit            |
/// |--------------------|------------------|---------------------|-----------------|
/// | `∫ N_i² K_s ds`    | `own`            | `N`×`N`             | N·m, N·m², N·m³ |
/// | `∫ N_A N_B K_s ds` | `coupling`       | `N`×`N`             | N·m, N·m², N·m³ |
/// | `A₀`, `B₀`         | `natural_strain` | `N`                 | –, 1/m          |
#[derive(Debug, Clone, PartialEq)]
pub struct ElementElasticity<const N: usize> {
    /// Stiffness of the strains of each part: one entry for a constant element, two for a pair.
    pub own: Vec<StrainMatrix<N>>,
    /// Stiffness between the halves of a pair, symmetric; zero for a constant element.
    pub coupling: StrainMatrix<N>,
    /// Natural strain of each part; the shears have none.
    pub natural_strain: Vec<Strain<N>>,
}

impl<const N: usize> ElementElasticity<N>
where
    Section: Stiff<N>,
{
    /// Elastic properties of the element on `[start_m, start_m + length_m]` of a body, NOTATION eqs. (S7), (S8): the section stiffness
    /// weighted by the shape functions of the kind, and the L2 projection of the natural strain.
    pub fn new(
        kind: ElementKind,
        (start_m, length_m): (f64, f64),
        section: &SectionLaw,
        natural: &NaturalStrain,
    ) -> Self {
        let end_m = start_m + length_m;
        let middle_m = start_m + 0.5 * length_m;
        // shape functions of the parts: 1, or N_A and N_B = ½ ∓ (3/2ℓ)(s − ℓ/2)
        let shapes = |s: f64| {
            let slope = 1.5 * (s - middle_m) / length_m;
            match kind {
                ElementKind::Constant => [1.0, 0.0],
                ElementKind::Linear => [0.5 - slope, 0.5 + slope],
            }
        };
        let mut own = [StrainMatrix::<N>::zeros(); 2];
        let mut coupling = StrainMatrix::<N>::zeros();
        for (s, weight) in gauss_pieces(start_m, end_m, &section.kinks_m()) {
            let stiffness = Stiff::<N>::stiffness(&section.at(s)) * weight;
            let [a, b] = shapes(s);
            own[0] += stiffness * (a * a);
            own[1] += stiffness * (b * b);
            coupling += stiffness * (a * b);
        }
        let (mut mean, mut slope) = (Strain::<STRAINS>::zeros(), Strain::<STRAINS>::zeros());
        let whole = |natural: Strain| Strain::<N>::from_fn(|i, _| natural.get(i).copied().unwrap_or(0.0));
        for (s, weight) in gauss_pieces(start_m, end_m, &natural.kinks_m()) {
            let strain = natural.at(s);
            mean += strain * (weight / length_m);
            slope += strain * (12.0 * (s - middle_m) * weight / length_m.powi(3));
        }
        match kind {
            ElementKind::Constant => Self { own: vec![own[0]], coupling, natural_strain: vec![whole(mean)] },
            ElementKind::Linear => {
                let third = slope * (length_m / 3.0);
                Self { own: own.to_vec(), coupling, natural_strain: vec![whole(mean - third), whole(mean + third)] }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::section::Material;

    /// For a uniform section `K = ℓ [[7/16, 1/16], [1/16, 7/16]] ⊗ K_s`, eq. (D8).
    #[test]
    fn uniform_pair_has_the_weights_of_the_pair_rule() {
        let material = Material { youngs_modulus_pa: 3.0, shear_modulus_pa: 1.0, density_kg_m3: 1.0 };
        let section = Section::rectangle(2.0, 1.0, &material, None);
        let law = SectionLaw::from(section.clone());
        let natural = NaturalStrain::from([0.0, 0.1, 0.2, 0.3]);
        let pair = ElementElasticity::new(ElementKind::Linear, (0.4, 0.8), &law, &natural);
        for (found, weight) in [(&pair.own[0], 7.0), (&pair.own[1], 7.0), (&pair.coupling, 1.0)] {
            let expected = section.stiffness * (0.8 * weight / 16.0);
            assert!((found - expected).norm() < 1e-14 * expected.norm());
        }
        for part in &pair.natural_strain {
            assert!((part - natural.at(0.0)).norm() < 5e-15, "{part}");
        }
    }
}
