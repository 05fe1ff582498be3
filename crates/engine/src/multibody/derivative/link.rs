//! Columns of a constant-strain link and the derivatives of its forces with respect to its strains, NOTATION eq. (X2).

use crate::math::jet::{Jet, Moving, Partial, Vector, dot, three};
use crate::math::jet_link::{self, JetSlopes};
use crate::math::strain::{STRAINS, STRETCH, StrainMatrix, TWIST};
use crate::multibody::derivative::chain::{Column, Timed, fixed};
use crate::multibody::kinematics::Motion;
use crate::multibody::model::Element;
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Vector3};

/// A vector that moves in the frame of a node, transformed to the root frame with its derivatives.
#[inline]
pub(super) fn turned(node: &Node, second: &Matrix3<f64>, vector: Timed) -> Timed {
    let [c, c1, c2] = vector.map(|order| node.rotation * order);
    let [c, by_spin, by_second] = fixed(node, second, c);
    [c, c1 + by_spin, c2 + node.spin.cross(&c1) * 2.0 + by_second]
}

/// Value and time derivatives of a vector of jets.
#[inline(always)]
pub(super) fn orders(vector: &Vector<Moving>, factor: f64) -> Timed {
    let order = |kind: usize| Vector3::new(vector[0].0[kind], vector[1].0[kind], vector[2].0[kind]) * factor;
    three(order)
}

/// Columns of an element, resolved on its inner node.
pub(super) fn columns(element: &Element, motion: Motion, node: &Node, second: &Matrix3<f64>) -> [Column; STRAINS] {
    let strain = |i: usize| {
        let c = element.coordinate + i;
        Moving([motion.q[c], motion.v[c], motion.a[c]])
    };
    let strains: [Moving; STRAINS] = std::array::from_fn(strain);
    let JetSlopes { tangent, slope_m } = jet_link::slopes(element.length_m, &strains);
    let mut columns = [Column::ZERO; STRAINS];
    columns[STRETCH].linear = turned(node, second, orders(&tangent[0], element.length_m));
    for (j, column) in columns[TWIST..].iter_mut().enumerate() {
        column.linear = turned(node, second, orders(&slope_m[j], element.length_m));
        column.angular = turned(node, second, orders(&tangent[j], element.length_m));
    }
    columns
}

/// Derivatives of the forces on the strains (rows) with respect to the strains, for a constant wrench at the outer end, given in the frame
/// of the inner node.
pub(super) fn slopes(element: &Element, q: &[f64], force: &Vector3<f64>, moment: &Vector3<f64>) -> StrainMatrix {
    let strains: [Partial<STRAINS>; STRAINS] = std::array::from_fn(|i| Partial::along(q[element.coordinate + i], i));
    let JetSlopes { tangent, slope_m } = jet_link::slopes(element.length_m, &strains);
    let along = |column: &Vector<Partial<STRAINS>>, vector: &Vector3<f64>| {
        column[0].times(vector.x) + column[1].times(vector.y) + column[2].times(vector.z)
    };
    let row = |i: usize| match i {
        STRETCH => along(&tangent[0], force),
        _ => along(&slope_m[i - TWIST], force) + along(&tangent[i - TWIST], moment),
    };
    let rows: [Partial<STRAINS>; STRAINS] = std::array::from_fn(row);
    StrainMatrix::from_fn(|i, j| element.length_m * rows[i].by[j])
}

/// Forces on the strains of a link due to a wrench at its outer end, in the frame of its inner end.
#[inline]
pub(super) fn forces<const N: usize>(
    length_m: f64,
    strains: &[Partial<N>; STRAINS],
    force: &Vector<Partial<N>>,
    moment: &Vector<Partial<N>>,
) -> [Partial<N>; STRAINS] {
    let JetSlopes { tangent, slope_m } = jet_link::slopes(length_m, strains);
    let mut rows = [Partial::ZERO; STRAINS];
    rows[STRETCH] = dot(&tangent[0], force).times(length_m);
    for j in 0..3 {
        rows[TWIST + j] = (dot(&slope_m[j], force) + dot(&tangent[j], moment)).times(length_m);
    }
    rows
}
