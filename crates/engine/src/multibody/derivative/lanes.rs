//! Products along several directions side by side: every entry is a row of `L` numbers, one per direction, which the compiler keeps in
//! vectors of the processor.

use crate::beam::element::ElementKind;
use crate::math::strain::STRAINS;
use crate::multibody::derivative::chain::{Column, Timed};
use crate::multibody::derivative::link::Link;
use crate::multibody::derivative::spot::Spot;
use crate::multibody::dynamics::Damping;
use crate::multibody::model::{Body, Model};
use nalgebra::Vector3;

/// A vector of three rows.
pub(super) type Triple<const L: usize> = [[f64; L]; 3];

/// Variation of a node: first and second derivatives of its displacement, rotation with two derivatives.
pub(super) type State<const L: usize> = [Triple<L>; 5];

/// Changes of a node's four vectors.
type Four<const L: usize> = [Triple<L>; 4];

/// Workspace per node.
#[derive(Debug, Clone)]
pub struct Lanes<const L: usize> {
    states: Vec<State<L>>,
    /// Displacement relative to the carrier.
    moved: Vec<Triple<L>>,
    loads: Vec<Four<L>>,
    wrenches: Vec<[Triple<L>; 2]>,
}

impl<const L: usize> Lanes<L> {
    /// Workspace for a model.
    pub fn new(model: &Model) -> Self {
        let nodes = model.nodes.len();
        let zero = [[0.0; L]; 3];
        Self {
            states: vec![[zero; 5]; nodes],
            moved: vec![zero; nodes],
            loads: vec![[zero; 4]; nodes],
            wrenches: vec![[zero; 2]; nodes],
        }
    }
}

/// `sum += factor · row`.
#[inline(always)]
pub(super) fn add<const L: usize>(sum: &mut [f64; L], factor: f64, row: &[f64; L]) {
    for lane in 0..L {
        sum[lane] += factor * row[lane];
    }
}

/// `sum += factor · values`.
#[inline(always)]
fn add_times<const L: usize>(sum: &mut Triple<L>, factor: f64, values: &Triple<L>) {
    for i in 0..3 {
        add(&mut sum[i], factor, &values[i]);
    }
}

/// `sum += vector · row`.
#[inline(always)]
fn add_along<const L: usize>(sum: &mut Triple<L>, vector: &Vector3<f64>, row: &[f64; L]) {
    for i in 0..3 {
        add(&mut sum[i], vector[i], row);
    }
}

/// `sum += values × vector`.
#[inline(always)]
pub(super) fn add_cross<const L: usize>(sum: &mut Triple<L>, values: &Triple<L>, vector: &Vector3<f64>) {
    for (i, [j, k]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        add(&mut sum[i], vector[k], &values[j]);
        add(&mut sum[i], -vector[j], &values[k]);
    }
}

/// `sum += vector · values`, a scalar product.
#[inline(always)]
fn add_dot<const L: usize>(sum: &mut [f64; L], vector: &Vector3<f64>, values: &Triple<L>) {
    for i in 0..3 {
        add(sum, vector[i], &values[i]);
    }
}

/// Variation of a point fixed to a node at the end of an arm.
#[inline(always)]
pub(super) fn outward<const L: usize>(state: &State<L>, [r, r1, r2]: &Timed) -> State<L> {
    let [_, _, turn, turn1, turn2] = state;
    let mut outer = *state;
    let [rate, acceleration, ..] = &mut outer;
    add_cross(rate, turn1, r);
    add_cross(rate, turn, r1);
    add_cross(acceleration, turn2, r);
    add_cross(acceleration, turn1, &(r1 * 2.0));
    add_cross(acceleration, turn, r2);
    outer
}

impl Column {
    /// Adds the effect of changes `q`, `v`, `a` of a coordinate; `turns`: whether the coordinate rotates the outer end.
    #[inline(always)]
    fn add_lanes<const L: usize>(
        &self,
        (state, moved): (&mut State<L>, &mut Triple<L>),
        [q, v, a]: [&[f64; L]; 3],
        turns: bool,
    ) {
        let [rate, acceleration, turn, turn1, turn2] = state;
        let [l, l1, l2] = &self.linear;
        add_along(moved, l, q);
        add_along(rate, l, v);
        add_along(rate, l1, q);
        add_along(acceleration, l, a);
        add_along(acceleration, &(l1 * 2.0), v);
        add_along(acceleration, l2, q);
        if turns {
            let [w, w1, w2] = &self.angular;
            add_along(turn, w, q);
            add_along(turn1, w, v);
            add_along(turn1, w1, q);
            add_along(turn2, w, a);
            add_along(turn2, &(w1 * 2.0), v);
            add_along(turn2, w2, q);
        }
    }
}

impl Spot {
    /// Variation of `L` for the nodal vectors, in a root that does not rotate; `damps`: with the damping of the body.
    #[inline(always)]
    fn lane_loads<const L: usize>(&self, state: &State<L>, (alpha_1_s, damps): (f64, bool)) -> Four<L> {
        let [rate, acceleration, turn, turn1, turn2] = state;
        let mut loads = [[[0.0; L]; 3]; 4];
        let [origin, axes @ ..] = &mut loads;
        *origin = *acceleration;
        if damps {
            add_times(origin, alpha_1_s, rate);
        }
        for ((load, [r, r1, r2]), [by_rate, by_turn]) in axes.iter_mut().zip(&self.axes).zip(&self.damped) {
            let [by_rate, by_turn] = if damps { [*by_rate, *by_turn] } else { [r1 * 2.0, *r2] };
            add_cross(load, turn2, r);
            add_cross(load, turn1, &by_rate);
            add_cross(load, turn, &by_turn);
        }
        loads
    }
}

/// Adds the forces of a mass block on the nodal vectors; `SLIM`: the block couples only `r` and `r_x`.
#[inline(always)]
fn add_mass<const SLIM: bool, const L: usize>(
    forces: &mut Four<L>,
    mass: impl Fn(usize, usize) -> f64,
    loads: &Four<L>,
) {
    for (i, force) in forces.iter_mut().enumerate() {
        for (j, load) in loads.iter().enumerate() {
            if !SLIM || i == j || (i < 2 && j < 2) {
                add_times(force, mass(i, j), load);
            }
        }
    }
}

/// `K δq + C δv + M δa` of the tree with the elastic and damping forces of the strains, without those of joints, along `L` directions,
/// into `sum`.
#[inline(always)]
pub(super) fn forward<const L: usize>(
    (links, spots, columns, alphas): (&[Link], &[Spot], &[Column], &[f64]),
    (model, damping): (&Model, &[Damping]),
    work: &mut Lanes<L>,
    [q, v, a]: [&[[f64; L]]; 3],
    sum: &mut [[f64; L]],
) {
    let Lanes { states, moved, loads, wrenches } = work;
    for (n, link) in links.iter().enumerate() {
        let mut state = [[[0.0; L]; 3]; 5];
        let mut own = [[0.0; L]; 3];
        if let Some(carrier) = link.carrier {
            state = outward(&states[carrier], &link.arm);
            add_cross(&mut own, &states[carrier][2], &link.arm[0]);
        }
        for i in link.range() {
            let turns = link.element.is_none() || i != link.first;
            columns[i].add_lanes((&mut state, &mut own), [&q[i], &v[i], &a[i]], turns);
        }
        (states[n], moved[n]) = (state, own);
    }
    for (body, alpha) in model.bodies.iter().zip(alphas) {
        match body.slim_mass {
            true => weigh::<true, L>((model, body, *alpha), spots, states, loads, wrenches),
            false => weigh::<false, L>((model, body, *alpha), spots, states, loads, wrenches),
        }
    }
    for (body, damping) in model.bodies.iter().zip(damping).rev() {
        for n in (body.first_node..=body.last_node()).rev() {
            let link = &links[n];
            project((link, n), columns, (states, moved), wrenches, q, sum);
            if let Some(element) = link.element {
                add_elastic(model, (body, damping), element, [q, v], sum);
            }
        }
    }
}

/// Forces on the unknowns of a link and the wrench that it passes to its carrier.
#[inline(always)]
fn project<const L: usize>(
    (link, n): (&Link, usize),
    columns: &[Column],
    (states, moved): (&[State<L>], &[Triple<L>]),
    wrenches: &mut [[Triple<L>; 2]],
    q: &[[f64; L]],
    sum: &mut [[f64; L]],
) {
    let [force, moment] = wrenches[n];
    for i in link.range() {
        let column = &columns[i];
        let mut own = [0.0; L];
        add_dot(&mut own, &column.linear[0], &force);
        if link.element.is_none() || i != link.first {
            add_dot(&mut own, &column.angular[0], &moment);
        }
        if let Some(carrier) = link.carrier {
            add_dot(&mut own, &column.turned, &states[carrier][2]);
        }
        if link.element.is_some() {
            for (k, changes) in q[link.range()].iter().enumerate() {
                add(&mut own, link.slopes[(i - link.first, k)], changes);
            }
        }
        sum[i] = own;
    }
    let Some(carrier) = link.carrier else { return };
    let [on_force, on_moment] = &mut wrenches[carrier];
    add_times(on_force, 1.0, &force);
    add_times(on_moment, 1.0, &moment);
    // arm × force and moved × force of the point
    add_cross(on_moment, &force, &-link.arm[0]);
    add_cross(on_moment, &moved[n], &link.force);
}

/// Variations of the wrenches on the nodes of a body.
fn weigh<const SLIM: bool, const L: usize>(
    (model, body, alpha_1_s): (&Model, &Body, f64),
    spots: &[Spot],
    states: &[State<L>],
    loads: &mut [Four<L>],
    wrenches: &mut [[Triple<L>; 2]],
) {
    let range = body.first_node..=body.last_node();
    for n in range.clone() {
        loads[n] = spots[n].lane_loads(&states[n], (alpha_1_s, true));
    }
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    for (i, n) in range.enumerate() {
        let mut forces = [[[0.0; L]; 3]; 4];
        let beam = &model.nodes[n].beam;
        add_mass::<SLIM, L>(&mut forces, |i, j| beam[(i, j)], &loads[n]);
        if i > 0 {
            let cross = &elements[i - 1].cross_mass;
            add_mass::<SLIM, L>(&mut forces, |i, j| cross[(i, j)], &loads[n - 1]);
        }
        if let Some(element) = elements.get(i) {
            let cross = &element.cross_mass;
            add_mass::<SLIM, L>(&mut forces, |i, j| cross[(j, i)], &loads[n + 1]);
        }
        if let Some(attached) = &model.nodes[n].attached {
            let damps = body.damps_attached || alpha_1_s == 0.0;
            let own = if damps { loads[n] } else { spots[n].lane_loads(&states[n], (alpha_1_s, false)) };
            add_mass::<false, L>(&mut forces, |i, j| attached[(i, j)], &own);
        }
        let mut moment = [[0.0; L]; 3];
        for (axis, force) in spots[n].axes.iter().zip(&forces[1..]) {
            add_cross(&mut moment, force, &-axis[0]);
        }
        for (k, turn) in states[n][2].iter().enumerate() {
            add_along(&mut moment, &spots[n].by_turn.column(k).into_owned(), turn);
        }
        wrenches[n] = [forces[0], moment];
    }
}

/// Adds the forces of stiffness and stiffness-proportional damping on the strains of an element, eq. (D8).
#[inline(always)]
fn add_elastic<const L: usize>(
    model: &Model,
    (body, damping): (&Body, &Damping),
    index: usize,
    [q, v]: [&[[f64; L]]; 2],
    sum: &mut [[f64; L]],
) {
    let element = &model.elements[index];
    let odd = (index - body.first_element) ^ 1;
    let sibling = (body.kind == ElementKind::Linear)
        .then(|| (&element.elastic.coupling, model.elements[body.first_element + odd].coordinate));
    let roots = body.damping_roots.as_ref();
    for (block, from) in [Some((&element.elastic.stiffness, element.coordinate)), sibling].into_iter().flatten() {
        for k in 0..STRAINS {
            for i in 0..STRAINS {
                let by = roots.map_or(damping.stiffness_s, |roots| damping.stiffness_s * (roots[i] * roots[k]));
                let (own, entry) = (&mut sum[element.coordinate + i], block[(i, k)]);
                add(own, entry, &q[from + k]);
                if by != 0.0 {
                    add(own, entry * by, &v[from + k]);
                }
            }
        }
    }
}
