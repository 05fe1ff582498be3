//! Factors of `M + g C + g² K` with all terms of the tree, gyroscopic and geometric ones included, in O(n); NOTATION eqs. (X30)–(X33).
//!
//! The motion of a node varies by 15 numbers: the first and second derivatives of its displacement, its rotation and the two derivatives of
//! that. The wrench on the node and all outboard parts is a 6×15 matrix times these; in every link the strains, and in every joint its angle,
//! are eliminated by a small inverse, from the tips to the root. The factors leave out rotation of the root and loads at stations.

use crate::beam::element::ElementKind;
use crate::math::strain::{STRAINS, StrainMatrix};
use crate::multibody::derivative::chain::{Column, Timed};
use crate::multibody::derivative::lanes::{State, Triple};
use crate::multibody::derivative::link::Link;
use crate::multibody::derivative::spot::Spot;
use crate::multibody::dynamics::Damping;
use crate::multibody::joint::JointKind;
use crate::multibody::model::{Body, Model};
use nalgebra::{Matrix4, Vector3};

/// Number of the entries of a node's variation.
pub(super) const STATE: usize = 15;
/// Place of the first derivative of the displacement.
pub(super) const RATE: usize = 0;
/// Place of the second derivative of the displacement.
pub(super) const ACCELERATION: usize = 3;
/// Places of the rotation and its derivatives.
pub(super) const TURNS: [usize; 3] = [6, 9, 12];

/// A matrix of 15 columns: change of `R` numbers with a node's variation.
pub(super) type Gains<const R: usize> = [[f64; R]; STATE];

/// Factors of one link or joint with `N` unknowns.
#[derive(Debug, Clone)]
pub(super) struct LinkFactor<const N: usize> {
    /// Displacement and rotation of the outer end per unit of each unknown.
    pub reach: [[f64; 6]; N],
    /// Variation of the outer node per unit of each unknown.
    pub moved: [[f64; STATE]; N],
    /// Inverse of the pivot block, by columns.
    pub inverse: [[f64; N]; N],
    /// Wrench passed to the carrier per unit of each unknown.
    pub passed: [[f64; 6]; N],
    /// Inverse times the change of the unknowns' forces with the carrier's variation.
    pub by_carrier: Gains<N>,
    /// Coupling of a pair by columns: of the inner half's forces with the outer half's unknowns, of the outer half times its inverse.
    pub sibling: [[f64; N]; N],
}

/// Contributions of the outer half of a pair to the inner one.
struct Carried<const N: usize> {
    wrench: [[f64; 6]; N],
    by_middle: Gains<N>,
    block: [[f64; N]; N],
}

/// A link as the elimination needs it.
struct Given<'a, const N: usize> {
    link: &'a Link,
    columns: &'a [Column],
    gain_s: f64,
    /// Forces on the unknowns themselves, by columns.
    own: [[f64; N]; N],
    /// Wrench on the outer node per unit of its variation, and coupling by the mass of the element: outer with inner, inner with outer.
    outer: &'a Gains<6>,
    cross: Option<&'a [Gains<6>; 2]>,
}

/// The linearised tree.
#[derive(Clone, Copy)]
pub(super) struct Linear<'a> {
    pub links: &'a [Link],
    pub spots: &'a [Spot],
    pub columns: &'a [Column],
    /// Mass-proportional damping per body in 1/s.
    pub alphas: &'a [f64],
}

/// The factors and their workspace.
#[derive(Debug, Clone)]
pub(super) struct Exact {
    pub elements: Vec<LinkFactor<STRAINS>>,
    /// Per body; `None` while its joint is held.
    pub joints: Vec<Option<LinkFactor<1>>>,
    /// Per node: wrench per unit of the variation, outboard parts included.
    gains: Vec<Gains<6>>,
    pub single: Sweep<1>,
    pub wrenches: Vec<[f64; 6]>,
    pub states: Vec<[f64; STATE]>,
}

/// Workspace of solutions with `L` right-hand sides: wrenches and variations of the nodes.
#[derive(Debug, Clone)]
pub struct Sweep<const L: usize> {
    pub(super) wrenches: Vec<[Triple<L>; 2]>,
    pub(super) states: Vec<State<L>>,
}

impl<const L: usize> Sweep<L> {
    /// Workspace for a model.
    pub fn new(model: &Model) -> Self {
        let nodes = model.nodes.len();
        Self { wrenches: vec![[[[0.0; L]; 3]; 2]; nodes], states: vec![[[[0.0; L]; 3]; 5]; nodes] }
    }
}

impl Exact {
    pub fn new(model: &Model) -> Self {
        let nodes = model.nodes.len();
        Self {
            elements: vec![LinkFactor::ZERO; model.elements.len()],
            joints: vec![None; model.bodies.len()],
            gains: vec![[[0.0; 6]; STATE]; nodes],
            single: Sweep::new(model),
            wrenches: vec![[0.0; 6]; nodes],
            states: vec![[0.0; STATE]; nodes],
        }
    }
}

impl<const N: usize> LinkFactor<N> {
    const ZERO: Self = Self {
        reach: [[0.0; 6]; N],
        moved: [[0.0; STATE]; N],
        inverse: [[0.0; N]; N],
        passed: [[0.0; 6]; N],
        by_carrier: [[0.0; N]; STATE],
        sibling: [[0.0; N]; N],
    };
}

/// `sum += factor · values`.
#[inline(always)]
pub(super) fn add<const R: usize>(sum: &mut [f64; R], factor: f64, values: &[f64; R]) {
    for i in 0..R {
        sum[i] += factor * values[i];
    }
}

#[inline(always)]
pub(super) fn dot<const R: usize>(a: &[f64; R], b: &[f64; R]) -> f64 {
    (0..R).fold(0.0, |sum, i| sum + a[i] * b[i])
}

/// Sum of columns with factors.
#[inline(always)]
pub(super) fn combined<const R: usize, const C: usize>(columns: &[[f64; R]; C], factors: &[f64; C]) -> [f64; R] {
    let mut sum = [0.0; R];
    for k in 0..C {
        add(&mut sum, factors[k], &columns[k]);
    }
    sum
}

#[inline(always)]
pub(super) fn set(values: &mut [f64], at: usize, vector: &Vector3<f64>) {
    values[at..at + 3].copy_from_slice(vector.as_slice());
}

#[inline(always)]
pub(super) fn at(values: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(values[at], values[at + 1], values[at + 2])
}

/// Adds `matrix · [arm]ᵀ×`, three columns from three columns: change with a rotation that moves the end of an arm.
#[inline(always)]
fn add_turned<const R: usize>(sum: &mut Gains<R>, to: usize, matrix: &Gains<R>, from: usize, arm: &Vector3<f64>) {
    for (k, [i, j]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        add(&mut sum[to + k], arm[i], &matrix[from + j]);
        add(&mut sum[to + k], -arm[j], &matrix[from + i]);
    }
}

/// Change with the carrier's variation, from the change with that of the outer node.
#[inline(always)]
fn carried<const R: usize>(matrix: &Gains<R>, [r, r1, r2]: &Timed) -> Gains<R> {
    let mut sum = *matrix;
    let [turn, turn1, turn2] = TURNS;
    add_turned(&mut sum, turn, matrix, RATE, r1);
    add_turned(&mut sum, turn, matrix, ACCELERATION, r2);
    add_turned(&mut sum, turn1, matrix, RATE, r);
    add_turned(&mut sum, turn1, matrix, ACCELERATION, &(r1 * 2.0));
    add_turned(&mut sum, turn2, matrix, ACCELERATION, r);
    sum
}

/// Wrench at the carrier of a wrench at the end of an arm.
#[inline(always)]
fn moved_in(wrench: &[f64; 6], arm: &Vector3<f64>) -> [f64; 6] {
    let mut inner = *wrench;
    set(&mut inner, 3, &(at(wrench, 3) + arm.cross(&at(wrench, 0))));
    inner
}

/// Wrench on a node, with the axes of `rows`, per unit of the variation of another, with the axes of `columns`, due to a mass block; `alpha_1_s`:
/// damping of the mass. `SLIM`: the block couples only `r` and `r_x`.
#[inline(always)]
fn add_inertia<const SLIM: bool>(
    sum: &mut Gains<6>,
    mass: &Matrix4<f64>,
    [rows, columns]: [&Spot; 2],
    (alpha_1_s, damps): (f64, bool),
) {
    let alpha = if damps { alpha_1_s } else { 0.0 };
    let couples = |i: usize, j: usize| !SLIM || i == j || (i < 2 && j < 2);
    let axes: [Vector3<f64>; 3] = std::array::from_fn(|k| rows.axes[k][0]);
    let mut first = Vector3::zeros();
    for (k, axis) in axes.iter().enumerate() {
        if couples(k + 1, 0) {
            first += axis * mass[(k + 1, 0)];
        }
    }
    for (place, factor) in [(RATE, alpha), (ACCELERATION, 1.0)] {
        let [own, x, y, z] = [mass[(0, 0)], first.x, first.y, first.z].map(|value| factor * value);
        add(&mut sum[place], 1.0, &[own, 0.0, 0.0, 0.0, z, -y]);
        add(&mut sum[place + 1], 1.0, &[0.0, own, 0.0, -z, 0.0, x]);
        add(&mut sum[place + 2], 1.0, &[0.0, 0.0, own, y, -x, 0.0]);
    }
    for (order, place) in TURNS.into_iter().enumerate() {
        // factor of the rotation's derivative of this order in the variation of each axis's load
        let factor = |k: usize| {
            let [r, r1, r2] = &columns.axes[k];
            match (order, damps) {
                (2, _) => *r,
                (1, true) => columns.damped[k][0],
                (1, false) => r1 * 2.0,
                (_, true) => columns.damped[k][1],
                (_, false) => *r2,
            }
        };
        let factors = [factor(0), factor(1), factor(2)];
        let of = |i: usize| {
            let mut own = Vector3::zeros();
            for (k, factor) in factors.iter().enumerate() {
                if couples(i, k + 1) {
                    own += factor * mass[(i, k + 1)];
                }
            }
            own
        };
        let force = of(0);
        let on = [of(1), of(2), of(3)];
        let whole = (0..3).fold(0.0, |whole, k| whole + axes[k].dot(&on[k]));
        let mut moments = [Vector3::new(whole, 0.0, 0.0), Vector3::new(0.0, whole, 0.0), Vector3::new(0.0, 0.0, whole)];
        for (j, moment) in moments.iter_mut().enumerate() {
            for k in 0..3 {
                *moment -= on[k] * axes[k][j];
            }
        }
        let [x, y, z] = [force.x, force.y, force.z];
        let [a, b, c] = moments;
        add(&mut sum[place], 1.0, &[0.0, -z, y, a.x, a.y, a.z]);
        add(&mut sum[place + 1], 1.0, &[z, 0.0, -x, b.x, b.y, b.z]);
        add(&mut sum[place + 2], 1.0, &[-y, x, 0.0, c.x, c.y, c.z]);
    }
}

/// Couplings by the mass of an element: of the outer end with the variation of the inner one, and the reverse.
#[inline(always)]
fn coupling_of<const SLIM: bool>(mass: &Matrix4<f64>, [outer, inner]: [&Spot; 2], alpha_1_s: f64) -> [Gains<6>; 2] {
    let mut cross = [[[0.0; 6]; STATE]; 2];
    add_inertia::<SLIM>(&mut cross[0], mass, [outer, inner], (alpha_1_s, true));
    add_inertia::<SLIM>(&mut cross[1], &mass.transpose(), [inner, outer], (alpha_1_s, true));
    cross
}

/// Inverse without pivoting, by columns; `None` at a pivot that is not positive or not finite: the block is positive but for the terms of
/// the motion.
#[inline(always)]
fn inverse<const N: usize>(mut block: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    for k in 0..N {
        let pivot = block[k][k];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let own = 1.0 / pivot;
        let mut column = block[k];
        column[k] = 0.0;
        for (_, other) in block.iter_mut().enumerate().filter(|(j, _)| *j != k) {
            let share = other[k] * own;
            other[k] = 0.0;
            add(other, -share, &column);
            other[k] = share;
        }
        block[k] = column.map(|entry| -entry * own);
        block[k][k] = own;
    }
    Some(block)
}

/// Eliminates the unknowns of a link into its factor; returns the change of the wrench at the carrier with its variation. `from_sibling`: the
/// terms that the outer half of a pair passes to the inner one.
#[inline(always)]
fn eliminate<const N: usize>(
    given: &Given<N>,
    from_sibling: Option<&Carried<N>>,
    factor: &mut LinkFactor<N>,
) -> Option<Gains<6>> {
    let Given { link, columns, gain_s, own, outer, cross } = given;
    let (g, g2) = (*gain_s, gain_s * gain_s);
    let arm = &link.arm;
    // reach by rows: changes of all forces with one entry of a wrench
    let mut rows = [[0.0; N]; 6];
    for (j, column) in columns.iter().enumerate().take(N) {
        let ([l, l1, l2], [w, w1, w2]) = (&column.linear, &column.angular);
        let (reach, moved) = (&mut factor.reach[j], &mut factor.moved[j]);
        set(reach, 0, l);
        set(reach, 3, w);
        set(moved, RATE, &(l * g + l1 * g2));
        set(moved, ACCELERATION, &(l + l1 * (2.0 * g) + l2 * g2));
        set(moved, TURNS[0], &(w * g2));
        set(moved, TURNS[1], &(w * g + w1 * g2));
        set(moved, TURNS[2], &(w + w1 * (2.0 * g) + w2 * g2));
        (0..6).for_each(|i| rows[i][j] = reach[i]);
    }
    let mut on_outer = carried(outer, arm);
    if let Some([outer_inner, _]) = cross {
        for k in 0..STATE {
            add(&mut on_outer[k], 1.0, &outer_inner[k]);
        }
    }
    let mut by_carrier = [[0.0; N]; STATE];
    for k in 0..STATE {
        by_carrier[k] = combined(&rows, &on_outer[k]);
    }
    for (j, column) in columns.iter().enumerate().take(N) {
        (0..3).for_each(|i| by_carrier[TURNS[0] + i][j] += column.turned[i]);
    }
    if let Some(Carried { by_middle, .. }) = from_sibling {
        let by_inner = carried(by_middle, arm);
        for k in 0..STATE {
            add(&mut by_carrier[k], 1.0, &by_inner[k]);
        }
    }
    let mut block = *own;
    for j in 0..N {
        let moved = &factor.moved[j];
        let mut wrench = combined(outer, moved);
        if let Some(Carried { wrench: wrenches, by_middle, block: own }) = from_sibling {
            add(&mut wrench, 1.0, &wrenches[j]);
            add(&mut block[j], 1.0, &own[j]);
            add(&mut block[j], 1.0, &combined(by_middle, moved));
        }
        add(&mut block[j], 1.0, &combined(&rows, &wrench));
        let mut passed = moved_in(&wrench, &arm[0]);
        if let Some([_, inner_outer]) = cross {
            add(&mut passed, 1.0, &combined(inner_outer, moved));
        }
        let moment = at(&passed, 3) + columns[j].linear[0].cross(&link.force) * g2;
        set(&mut passed, 3, &moment);
        factor.passed[j] = passed;
    }
    factor.inverse = inverse(block)?;
    let mut on_inner = match cross {
        Some([_, inner_outer]) => carried(inner_outer, arm),
        None => [[0.0; 6]; STATE],
    };
    for k in 0..STATE {
        add(&mut on_inner[k], 1.0, &moved_in(&on_outer[k], &arm[0]));
        factor.by_carrier[k] = combined(&factor.inverse, &by_carrier[k]);
        for j in 0..N {
            add(&mut on_inner[k], -factor.by_carrier[k][j], &factor.passed[j]);
        }
    }
    // the force turns with the arm
    let along = link.force.dot(&arm[0]);
    for k in 0..3 {
        let turn = &mut on_inner[TURNS[0] + k];
        turn[3 + k] -= along;
        for i in 0..3 {
            turn[3 + i] += arm[0][i] * link.force[k];
        }
    }
    Some(on_inner)
}

/// A matrix over the strains by columns.
fn columns_of(matrix: &StrainMatrix) -> [[f64; STRAINS]; STRAINS] {
    matrix.data.0
}

/// See [`Derivative::has_factors`](super::Derivative::has_factors).
pub(super) fn covers(model: &Model) -> bool {
    let covered = |body: &Body| {
        let joint = match body.joint.kind {
            JointKind::Clamped | JointKind::Revolute { .. } | JointKind::Prismatic { .. } => true,
            JointKind::Sliding | JointKind::Universal { .. } | JointKind::Ball | JointKind::Free => false,
        };
        joint && body.modal.is_none() && !body.sheared && body.carrier.is_none()
    };
    model.closures.is_empty() && model.damped_modes.is_empty() && model.bodies.iter().all(covered)
}

impl Exact {
    /// Factorises `M + g C + g² K` at the linearised point, eqs. (X30)–(X32). `joint` gives for each body the coefficient of its joint's own
    /// acceleration (inertia, `g` times damping, `g²` times stiffness), `None` while the joint is held. Allocates nothing.
    ///
    /// `None` if a pivot is not positive.
    pub fn factorize(
        &mut self,
        Linear { links, spots, columns, alphas }: Linear,
        model: &Model,
        gain_s: f64,
        damping: &[Damping],
        joint: impl Fn(usize) -> Option<f64>,
    ) -> Option<()> {
        let exact = self;
        for (index, body) in model.bodies.iter().enumerate() {
            match body.slim_mass {
                true => exact.start_body::<true>(model, body, spots, alphas[index]),
                false => exact.start_body::<false>(model, body, spots, alphas[index]),
            }
        }
        for (index, body) in model.bodies.iter().enumerate().rev() {
            let weights: StrainMatrix = body.damped_weights(gain_s * gain_s, gain_s * damping[index].stiffness_s);
            let mut sibling: Option<Carried<STRAINS>> = None;
            for i in (0..body.elements).rev() {
                let (e, n) = (body.first_element + i, body.first_node + i + 1);
                let (element, link) = (&model.elements[e], &links[n]);
                let ends = [&spots[n], &spots[n - 1]];
                let cross = match body.slim_mass {
                    true => coupling_of::<true>(&element.cross_mass, ends, alphas[index]),
                    false => coupling_of::<false>(&element.cross_mass, ends, alphas[index]),
                };
                let own = element.elastic.stiffness.component_mul(&weights) + link.slopes * (gain_s * gain_s);
                let given = Given {
                    link,
                    columns: &columns[link.range()],
                    gain_s,
                    own: columns_of(&own),
                    outer: &exact.gains[n],
                    cross: Some(&cross),
                };
                let factor = &mut exact.elements[e];
                let passed = eliminate(&given, sibling.take().as_ref(), factor)?;
                exact.gains[n - 1].iter_mut().zip(&passed).for_each(|(sum, passed)| add(sum, 1.0, passed));
                if body.kind == ElementKind::Linear {
                    let coupling = columns_of(&element.elastic.coupling.component_mul(&weights));
                    if i % 2 == 1 {
                        factor.sibling = coupling.map(|column| combined(&factor.inverse, &column));
                        let inner = &model.elements[e - 1].elastic.coupling;
                        let inner = columns_of(&inner.component_mul(&weights)).map(|column| column.map(|x| -x));
                        sibling = Some(Carried {
                            wrench: factor.sibling.map(|by| combined(&factor.passed, &by).map(|x| -x)),
                            by_middle: factor.by_carrier.map(|by| combined(&inner, &by)),
                            block: factor.sibling.map(|by| combined(&inner, &by)),
                        });
                    } else {
                        factor.sibling = coupling;
                    }
                }
            }
            let n = body.first_node;
            let link = &links[n];
            let pivot = if link.count == 1 { joint(index) } else { None };
            let outer = &exact.gains[n];
            let mut passed = None;
            exact.joints[index] = match pivot {
                Some(pivot) => {
                    let columns = &columns[link.range()];
                    let given = Given { link, columns, gain_s, own: [[pivot]], outer, cross: None };
                    let mut factor = LinkFactor::<1>::ZERO;
                    passed = Some(eliminate(&given, None, &mut factor)?);
                    Some(factor)
                }
                None => None,
            };
            let Some(carrier) = link.carrier else { continue };
            let passed = match passed {
                Some(passed) => passed,
                None => {
                    let given = Given::<0> { link, columns: &[], gain_s, own: [], outer, cross: None };
                    let mut factor = LinkFactor::<0>::ZERO;
                    eliminate(&given, None, &mut factor)?
                }
            };
            exact.gains[carrier].iter_mut().zip(&passed).for_each(|(sum, passed)| add(sum, 1.0, passed));
        }
        Some(())
    }
}

impl Exact {
    /// Change of the wrenches on the nodes of a body with their own motion.
    fn start_body<const SLIM: bool>(&mut self, model: &Model, body: &Body, spots: &[Spot], alpha_1_s: f64) {
        let range = body.first_node..=body.last_node();
        for ((n, spot), sum) in range.clone().zip(&spots[range.clone()]).zip(&mut self.gains[range]) {
            *sum = [[0.0; 6]; STATE];
            add_inertia::<SLIM>(sum, &model.nodes[n].beam, [spot; 2], (alpha_1_s, true));
            if let Some(attached) = &model.nodes[n].attached {
                add_inertia::<false>(sum, attached, [spot; 2], (alpha_1_s, body.damps_attached || alpha_1_s == 0.0));
            }
            for k in 0..3 {
                (0..3).for_each(|i| sum[TURNS[0] + k][3 + i] += spot.by_turn[(i, k)]);
            }
        }
    }
}
