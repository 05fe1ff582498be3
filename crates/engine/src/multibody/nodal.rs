//! Products of mass blocks with the nodal vectors `(r, r_x, r_y, r_z)`, and the wrenches of nodal forces.

use crate::math::so3::hat;
use crate::multibody::node::ArticulatedInertia;
use nalgebra::{Matrix3, Matrix4, Vector3};

/// [`multiply`], reduced for blocks that couple only `r` and `r_x`.
#[inline]
pub(super) fn product<const SLIM: bool>(mass: &Matrix4<f64>, vectors: &[Vector3<f64>; 4]) -> [Vector3<f64>; 4] {
    if !SLIM {
        return multiply(mass, vectors);
    }
    let [origin, x, y, z] = vectors;
    [
        origin * mass[(0, 0)] + x * mass[(0, 1)],
        origin * mass[(1, 0)] + x * mass[(1, 1)],
        y * mass[(2, 2)],
        z * mass[(3, 3)],
    ]
}

/// [`multiply_transposed`], reduced for blocks that couple only `r` and `r_x`.
#[inline]
pub(super) fn transposed_product<const SLIM: bool>(
    mass: &Matrix4<f64>,
    vectors: &[Vector3<f64>; 4],
) -> [Vector3<f64>; 4] {
    if !SLIM {
        return multiply_transposed(mass, vectors);
    }
    let [origin, x, y, z] = vectors;
    [
        origin * mass[(0, 0)] + x * mass[(1, 0)],
        origin * mass[(0, 1)] + x * mass[(1, 1)],
        y * mass[(2, 2)],
        z * mass[(3, 3)],
    ]
}

/// Products `f_i = Σ_j m[i,j] e_j` of a mass block with nodal vectors.
#[inline]
pub(crate) fn multiply(mass: &Matrix4<f64>, vectors: &[Vector3<f64>; 4]) -> [Vector3<f64>; 4] {
    std::array::from_fn(|i| {
        vectors[0] * mass[(i, 0)] + vectors[1] * mass[(i, 1)] + vectors[2] * mass[(i, 2)] + vectors[3] * mass[(i, 3)]
    })
}

/// Products `f_j = Σ_i m[i,j] e_i` of the transposed mass block with nodal vectors.
#[inline]
pub(crate) fn multiply_transposed(mass: &Matrix4<f64>, vectors: &[Vector3<f64>; 4]) -> [Vector3<f64>; 4] {
    std::array::from_fn(|j| {
        vectors[0] * mass[(0, j)] + vectors[1] * mass[(1, j)] + vectors[2] * mass[(2, j)] + vectors[3] * mass[(3, j)]
    })
}

/// Force and moment of nodal forces: `F = f₀`, `M = Σ r_k × f_k`, eq. (D6).
#[inline]
pub(crate) fn wrench_of(rotation: &Matrix3<f64>, forces: &[Vector3<f64>; 4]) -> (Vector3<f64>, Vector3<f64>) {
    let column = |k: usize| rotation.fixed_view::<3, 1>(0, k).into_owned();
    let moment = column(0).cross(&forces[1]) + column(1).cross(&forces[2]) + column(2).cross(&forces[3]);
    (forces[0], moment)
}

/// Lumped mass of a node in twist form, eq. (D10).
#[inline]
pub(super) fn lump(mass: &Matrix4<f64>, rotation: &Matrix3<f64>) -> ArticulatedInertia {
    let gradients: Matrix3<f64> = mass.fixed_view::<3, 3>(1, 1).into_owned();
    let spread = rotation * gradients * rotation.transpose();
    let first = rotation * Vector3::new(mass[(0, 1)], mass[(0, 2)], mass[(0, 3)]);
    ArticulatedInertia {
        vv: Matrix3::from_diagonal_element(mass[(0, 0)]),
        vw: -hat(&first),
        ww: Matrix3::from_diagonal_element(spread.trace()) - spread,
    }
}
