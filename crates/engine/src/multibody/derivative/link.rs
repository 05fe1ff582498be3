//! Columns of a constant-strain link and the derivatives of its forces with respect to its strains, NOTATION eq. (X2).

use crate::math::jet::{Jet, Moving, Partial, Vector, dot, three};
use crate::math::jet_link::{self, JetSlopes};
use crate::math::se3::Coefficients;
use crate::math::strain::{LINEAR, SHEARED, STRAINS, STRETCH, StrainMatrix, TWIST};
use crate::math::wide::{Fours, Quad};
use crate::multibody::derivative::chain::{Column, STILL, Timed, fixed};
use crate::multibody::derivative::spot::Spot;
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
    /// Element of the link; `None` for a joint and for the shapes of a modal body.
    pub element: Option<usize>,
    /// Modal body whose shapes its coordinates belong to.
    pub modal: Option<usize>,
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
        modal: None,
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

/// A moving vector in the frame of a node, whose axes and their derivatives are given, in the root frame, with factor.
#[inline(always)]
fn resolved<V: Fours>(fours: V, [axes, axes1, axes2]: &[[Quad; 3]; 3], vector: &Vector<Moving>, factor: f64) -> Timed {
    let mut sums = [[0.0; 4]; 3];
    for k in 0..3 {
        let [c, c1, c2] = vector[k].0.map(|order| order * factor);
        fours.add(&mut sums[0], c, &axes[k]);
        fours.add(&mut sums[1], c1, &axes[k]);
        fours.add(&mut sums[1], c, &axes1[k]);
        fours.add(&mut sums[2], c2, &axes[k]);
        fours.add(&mut sums[2], 2.0 * c1, &axes1[k]);
        fours.add(&mut sums[2], c, &axes2[k]);
    }
    three(|order| Vector3::new(sums[order][0], sums[order][1], sums[order][2]))
}

/// Columns of an element, resolved on its inner node.
#[inline(always)]
pub(super) fn columns<V: Fours>(fours: V, element: &Element, motion: Motion, node: &Spot) -> [Column; STRAINS] {
    let strain = |i: usize| {
        let c = element.coordinate + i;
        Moving([motion.q[c], motion.v[c], motion.a[c]])
    };
    let strains: [Moving; STRAINS] = std::array::from_fn(strain);
    let JetSlopes { tangent, slope_m } = jet_link::slopes(element.length_m, &strains);
    let mut axes = [[[0.0; 4]; 3]; 3];
    for (k, axis) in node.axes.iter().enumerate() {
        for (order, vector) in axis.iter().enumerate() {
            axes[order][k][..3].copy_from_slice(vector.as_slice());
        }
    }
    let mut columns = [Column::ZERO; STRAINS];
    columns[STRETCH].linear = resolved(fours, &axes, &tangent[0], element.length_m);
    for (j, column) in columns[TWIST..].iter_mut().enumerate() {
        column.linear = resolved(fours, &axes, &slope_m[j], element.length_m);
        column.angular = resolved(fours, &axes, &tangent[j], element.length_m);
    }
    columns
}

/// Derivatives of the forces on the strains (rows) with respect to the strains, for a constant wrench at the outer end, given in the frame
/// of the inner node: second derivatives of `F·(b Θ × e_x + c Θ × (Θ × e_x))` times `a`, eqs. (K2) and (K4), and first ones of `Vᵀ M`, eq.
/// (K3).
#[inline(always)]
pub(super) fn slopes(element: &Element, q: &[f64], force: &Vector3<f64>, moment: &Vector3<f64>) -> StrainMatrix {
    let length_m = element.length_m;
    // Θ and a
    let turn: [f64; 3] = three(|i| q[element.coordinate + TWIST + i] * length_m);
    let stretched_m = length_m + q[element.coordinate + STRETCH] * length_m;
    let along = |vector: &Vector3<f64>| turn[0] * vector.x + turn[1] * vector.y + turn[2] * vector.z;
    let square = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2];
    let (k, _) = Coefficients::with_third(square);
    // (Θ × e_x)·F and (Θ × (Θ × e_x))·F with their derivatives by Θ
    let (along_force, along_moment) = (along(force), along(moment));
    let (once, by_once) = (turn[2] * force.y - turn[1] * force.z, [0.0, -force.z, force.y]);
    let twice = turn[0] * along_force - square * force.x;
    let mut by_twice: [f64; 3] = three(|j| turn[0] * force[j] - 2.0 * turn[j] * force.x);
    by_twice[0] += along_force;
    let [first, second] = [k.b1 * once + k.c1 * twice, k.b2 * once + k.c2 * twice];
    let mixed: [f64; 3] = three(|j| k.b1 * by_once[j] + k.c1 * by_twice[j]);
    // (M × Θ)_j and Θ_j Θ·M − x M_j
    let turned = moment.cross(&Vector3::from(turn));
    let across: [f64; 3] = three(|j| turn[j] * along_moment - square * moment[j]);
    let by_square: [f64; 3] = three(|j| 2.0 * (k.b1 * turned[j] + k.c1 * across[j]));
    let area = length_m * length_m;
    let mut slopes = StrainMatrix::zeros();
    for j in 0..3 {
        let own = 2.0 * turn[j] * first + k.b * by_once[j] + k.c * by_twice[j];
        slopes[(STRETCH, TWIST + j)] = area * own;
        slopes[(TWIST + j, STRETCH)] = area * own;
        for i in 0..3 {
            let mut by = 4.0 * turn[j] * turn[i] * second + 2.0 * (turn[j] * mixed[i] + turn[i] * mixed[j]);
            if i == 0 {
                by += k.c * force[j];
            }
            if j == 0 {
                by += k.c * force[i];
            }
            let mut by_moment = turn[i] * by_square[j] + k.c * (turn[j] * moment[i] - 2.0 * turn[i] * moment[j]);
            if i == j {
                by += 2.0 * (first - k.c * force.x);
                by_moment += k.c * along_moment;
            }
            slopes[(TWIST + j, TWIST + i)] = area * (stretched_m * by + by_moment);
        }
    }
    // derivative of M × Θ
    for (j, [next, last]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        slopes[(TWIST + j, TWIST + last)] += area * k.b * moment[next];
        slopes[(TWIST + j, TWIST + next)] -= area * k.b * moment[last];
    }
    slopes
}

/// Forces on the strains of a link due to a wrench at its outer end, in the frame of its inner end.
#[inline]
pub(super) fn forces<const N: usize, const P: usize>(
    length_m: f64,
    strains: &[Partial<P>; N],
    force: &Vector<Partial<P>>,
    moment: &Vector<Partial<P>>,
) -> [Partial<P>; N] {
    let JetSlopes { tangent, slope_m } = match N == SHEARED {
        false => jet_link::slopes(length_m, &std::array::from_fn(|i| strains[i])),
        true => jet_link::sheared_slopes(length_m, &std::array::from_fn(|i| strains[i])),
    };
    let mut rows = [Partial::ZERO; N];
    for (axis, strain) in LINEAR.into_iter().enumerate().filter(|(_, strain)| *strain < N) {
        rows[strain] = dot(&tangent[axis], force).times(length_m);
    }
    for j in 0..3 {
        rows[TWIST + j] = (dot(&slope_m[j], force) + dot(&tangent[j], moment)).times(length_m);
    }
    rows
}
