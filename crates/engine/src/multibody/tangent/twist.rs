//! Twists and wrenches in one vector, and mass matrices of nodal vectors in terms of twists; NOTATION eq. (L4).

use crate::math::so3::hat;
use crate::multibody::workspace::Pair;
use nalgebra::{Matrix3, Matrix4, Matrix6, SMatrix, SVector, Vector3, Vector6};

/// Both halves of a twist or wrench in one vector.
pub(super) fn twist(pair: &Pair) -> Vector6<f64> {
    Vector6::new(pair.linear.x, pair.linear.y, pair.linear.z, pair.angular.x, pair.angular.y, pair.angular.z)
}

/// Adds as many of the values as `y` has entries.
pub(super) fn accumulate<const N: usize>(y: &mut [f64], values: &SVector<f64, N>) {
    for (y, value) in y.iter_mut().zip(values.iter()) {
        *y += value;
    }
}

pub(super) fn pair(twist: &Vector6<f64>) -> Pair {
    Pair { linear: twist.fixed_rows::<3>(0).into_owned(), angular: twist.fixed_rows::<3>(3).into_owned() }
}

pub(super) fn add(sum: &mut Pair, wrench: &Vector6<f64>) {
    let more = pair(wrench);
    sum.linear += more.linear;
    sum.angular += more.angular;
}

/// Nodal forces due to the acceleration `frame·e`, in twist form: rows for the node with axes `row`, columns for the one with axes
/// `column`, eq. (L4).
pub(super) fn inertia(
    mass: &Matrix4<f64>,
    frame: &Matrix3<f64>,
    row: &Matrix3<f64>,
    column: &Matrix3<f64>,
) -> Matrix6<f64> {
    if *frame == Matrix3::zeros() {
        return Matrix6::zeros();
    }
    shares(mass, frame, &spread(row), &spread(column))
}

/// Map from the twist of a node with the given axes to its nodal vectors.
pub(super) fn spread(axes: &Matrix3<f64>) -> SMatrix<f64, 12, 6> {
    let mut map = SMatrix::<f64, 12, 6>::zeros();
    map.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    for k in 0..3 {
        map.fixed_view_mut::<3, 3>(3 * k + 3, 3).copy_from(&-hat(&axes.column(k).into_owned()));
    }
    map
}

/// Generalised forces on the variables of `row` due to the acceleration `frame·e`, for changes of nodal vectors according to `column`.
pub(super) fn shares<const R: usize, const C: usize>(
    mass: &Matrix4<f64>,
    frame: &Matrix3<f64>,
    row: &SMatrix<f64, 12, R>,
    column: &SMatrix<f64, 12, C>,
) -> SMatrix<f64, R, C> {
    let mut forces = SMatrix::<f64, 12, C>::zeros();
    for i in 0..4 {
        for j in 0..4 {
            let share = frame * column.fixed_view::<3, C>(3 * j, 0) * mass[(i, j)];
            let mut rows = forces.fixed_view_mut::<3, C>(3 * i, 0);
            rows += share;
        }
    }
    // virtual power: the transpose of the map converts nodal forces to a wrench
    row.transpose() * forces
}

/// Adds the effect of constant nodal forces on gradients that rotate: `M = Σ r_k × f_k`, `δM = Σ [f_k][r_k] δφ`.
pub(super) fn add_turning(tangent: &mut Matrix6<f64>, axes: &Matrix3<f64>, forces: &[Vector3<f64>; 4]) {
    let mut spin = tangent.fixed_view_mut::<3, 3>(3, 3);
    for k in 0..3 {
        spin += hat(&forces[k + 1]) * hat(&axes.column(k).into_owned());
    }
}

/// Tangent of a load that rotates with its node, with the sign of the residual (loads are negative).
pub(super) fn follower(force_n: &Vector3<f64>, moment_n_m: &Vector3<f64>) -> Matrix6<f64> {
    let mut tangent = Matrix6::zeros();
    tangent.fixed_view_mut::<3, 3>(0, 3).copy_from(&hat(force_n));
    tangent.fixed_view_mut::<3, 3>(3, 3).copy_from(&hat(moment_n_m));
    tangent
}
