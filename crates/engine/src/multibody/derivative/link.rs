//! Columns of a constant-strain link and the derivatives of its forces with respect to its strains, NOTATION eq. (X2).

use crate::math::jet::{Jet, Moving, Partial, Vector, dot, three};
use crate::math::jet_link::{self, JetSlopes};
use crate::math::se3::Coefficients;
use crate::math::strain::{STRAINS, STRETCH, StrainMatrix, TWIST};
use crate::multibody::derivative::chain::{Column, STILL, Timed, fixed};
use crate::multibody::joint::JointKind;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Base, Body, Element};
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Vector3};

/// The link or joint between a node and its carrier, the next node towards the root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    /// Carrier of the node; `None` on the root.
    pub carrier: Option<usize>,
    /// Index of its first coordinate, and the number of its coordinates.
    pub first: usize,
    pub count: usize,
    /// Element of the link; `None` for a joint.
    pub element: Option<usize>,
    /// Vector from carrier to node in m, root frame.
    pub arm: Timed,
    /// Force of the outboard part at the node.
    pub force: Vector3<f64>,
    /// Derivatives of the forces on its strains (rows) with respect to its strains.
    pub slopes: StrainMatrix,
}

impl Link {
    pub const NONE: Self = Self {
        carrier: None,
        first: 0,
        count: 0,
        element: None,
        arm: STILL,
        force: Vector3::new(0.0, 0.0, 0.0),
        slopes: StrainMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; STRAINS]; STRAINS])),
    };

    /// Link of the joint of a body.
    pub fn of_joint(body: &Body) -> Self {
        let carrier = match body.base {
            Base::Root(_) => None,
            Base::Node(node) => Some(node),
            Base::Axis(_) => unreachable!("no derivatives with sliding joints"),
        };
        let count = match body.joint.kind {
            JointKind::Revolute { .. } | JointKind::Prismatic { .. } => 1,
            JointKind::Clamped
            | JointKind::Sliding
            | JointKind::Universal { .. }
            | JointKind::Ball
            | JointKind::Free => 0,
        };
        Self { carrier, first: body.joint.coordinate, count, ..Self::NONE }
    }

    /// Indices of its coordinates.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
    }
}

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
/// of the inner node: those of eqs. (K2)–(K4) after their scalar products with the wrench, which leave few products of jets.
pub(super) fn slopes(element: &Element, q: &[f64], force: &Vector3<f64>, moment: &Vector3<f64>) -> StrainMatrix {
    type Number = Partial<STRAINS>;
    let length_m = element.length_m;
    let strain = |i: usize| Number::along(q[element.coordinate + i], i);
    // Θ and a
    let turn: Vector<Number> = three(|i| strain(TWIST + i).times(length_m));
    let stretched_m = Number::constant(length_m) + strain(STRETCH).times(length_m);
    let along = |vector: &Vector3<f64>| turn[0].times(vector.x) + turn[1].times(vector.y) + turn[2].times(vector.z);
    let square = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2];
    let k = Coefficients::at(square.value());
    let [b3, c3] = k.third(square.value());
    let (b, c) = (square.composed([k.b, k.b1, k.b2]), square.composed([k.c, k.c1, k.c2]));
    let (b_slope, c_slope) = (square.composed([k.b1, k.b2, b3]), square.composed([k.c1, k.c2, c3]));
    // (Θ × e_x)·F and (Θ × (Θ × e_x))·F
    let along_force = along(force);
    let once = turn[2].times(force.y) - turn[1].times(force.z);
    let twice = turn[0] * along_force - square.times(force.x);
    let both = (b_slope * once + c_slope * twice).times(2.0);
    let along_moment = along(moment);
    let row = |j: usize| {
        let (next, last) = ((j + 1) % 3, (j + 2) % 3);
        let mut by_c = turn[0].times(force[j]) - turn[j].times(2.0 * force.x);
        if j == 0 {
            by_c = by_c + along_force;
        }
        let by_b = b.times([0.0, -force.z, force.y][j]);
        let displacing = stretched_m * (turn[j] * both + c * by_c + by_b);
        let turned = turn[last].times(moment[next]) - turn[next].times(moment[last]);
        displacing + b * turned + c * (turn[j] * along_moment - square.times(moment[j]))
    };
    let first = b * once + c * twice;
    let rows: [Number; STRAINS] = [first, row(0), row(1), row(2)];
    StrainMatrix::from_fn(|i, j| length_m * rows[i].by[j])
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
