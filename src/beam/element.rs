//! The beam element's constant inertia: mass matrix of the fully parameterised ANCF element, seed eqs. (1)–(4).

use crate::beam::section::Section;
use crate::math::quadrature::GAUSS_4;
use nalgebra::{Matrix4, SMatrix};

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
    /// Mass of an element of `length_m` whose section is `section(ξ)` at `ξ ∈ [0, 1]`.
    ///
    /// Four Gauss points are exact for sections that vary linearly along it (shape functions are cubic).
    pub fn new(length_m: f64, section: impl Fn(f64) -> Section) -> Self {
        let mut mass = SMatrix::<f64, 8, 8>::zeros();
        for (xi, weight) in GAUSS_4 {
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

/// Pseudo-inertia of a rigid body in the same coordinates: `m̂ = [[m, m cᵀ], [m c, S]]`,
/// `S = ½ tr(J_c) I − J_c + m c cᵀ`, NOTATION eq. (D3). It joins the node's block: no special code.
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
    /// Constant strain: second order.
    Constant,
    /// Linear strain by the pair rule, two constant-strain halves with coupled stiffness: fourth order.
    Linear,
}

/// Own and coupling stiffness of the halves of a pair as fractions of `ℓ K_s`, `ℓ` the pair's length:
/// `K = ℓ [[7/16, 1/16], [1/16, 7/16]] ⊗ K_s`, NOTATION eq. (D8).
pub const PAIR_STIFFNESS: (f64, f64) = (7.0 / 16.0, 1.0 / 16.0);
