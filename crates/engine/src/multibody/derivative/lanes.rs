//! Products along several directions side by side: every entry is a row of `L` numbers, one per direction, which are vectors of the
//! processor.

use crate::beam::element::ElementKind;
use crate::math::strain::{STRAINS, STRETCH};
use crate::math::wide::{Fours, WithFours};
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

/// The linearised tree.
#[derive(Clone, Copy)]
pub(super) struct Linear<'a> {
    pub links: &'a [Link],
    pub spots: &'a [Spot],
    pub columns: &'a [Column],
    /// Mass-proportional damping per body in 1/s.
    pub alphas: &'a [f64],
}

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

/// `sum += factor · values`.
#[inline(always)]
fn add_times<V: Fours, const L: usize>(fours: V, sum: &mut Triple<L>, factor: f64, values: &Triple<L>) {
    for i in 0..3 {
        fours.add(&mut sum[i], factor, &values[i]);
    }
}

/// `sum += vector · row`.
#[inline(always)]
fn add_along<V: Fours, const L: usize>(fours: V, sum: &mut Triple<L>, vector: &Vector3<f64>, row: &[f64; L]) {
    for i in 0..3 {
        fours.add(&mut sum[i], vector[i], row);
    }
}

/// `sum += values × vector`.
#[inline(always)]
pub(super) fn add_cross<V: Fours, const L: usize>(
    fours: V,
    sum: &mut Triple<L>,
    values: &Triple<L>,
    vector: &Vector3<f64>,
) {
    for (i, [j, k]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        fours.add(&mut sum[i], vector[k], &values[j]);
        fours.add(&mut sum[i], -vector[j], &values[k]);
    }
}

/// `sum += vector · values`, a scalar product.
#[inline(always)]
fn add_dot<V: Fours, const L: usize>(fours: V, sum: &mut [f64; L], vector: &Vector3<f64>, values: &Triple<L>) {
    for i in 0..3 {
        fours.add(sum, vector[i], &values[i]);
    }
}

/// Variation of a point fixed to a node at the end of an arm.
#[inline(always)]
pub(super) fn outward<V: Fours, const L: usize>(fours: V, state: &State<L>, [r, r1, r2]: &Timed) -> State<L> {
    let [_, _, turn, turn1, turn2] = state;
    let mut outer = *state;
    let [rate, acceleration, ..] = &mut outer;
    add_cross(fours, rate, turn1, r);
    add_cross(fours, rate, turn, r1);
    add_cross(fours, acceleration, turn2, r);
    add_cross(fours, acceleration, turn1, &(r1 * 2.0));
    add_cross(fours, acceleration, turn, r2);
    outer
}

impl Column {
    /// Adds the effect of changes `q`, `v`, `a` of a coordinate; `turns`: whether the coordinate rotates the outer end.
    #[inline(always)]
    fn add_lanes<V: Fours, const L: usize>(
        &self,
        fours: V,
        (state, moved): (&mut State<L>, &mut Triple<L>),
        [q, v, a]: [&[f64; L]; 3],
        turns: bool,
    ) {
        let [rate, acceleration, turn, turn1, turn2] = state;
        let [l, l1, l2] = &self.linear;
        add_along(fours, moved, l, q);
        add_along(fours, rate, l, v);
        add_along(fours, rate, l1, q);
        add_along(fours, acceleration, l, a);
        add_along(fours, acceleration, &(l1 * 2.0), v);
        add_along(fours, acceleration, l2, q);
        if turns {
            let [w, w1, w2] = &self.angular;
            add_along(fours, turn, w, q);
            add_along(fours, turn1, w, v);
            add_along(fours, turn1, w1, q);
            add_along(fours, turn2, w, a);
            add_along(fours, turn2, &(w1 * 2.0), v);
            add_along(fours, turn2, w2, q);
        }
    }
}

impl Spot {
    /// Variation of `L` for the nodal vectors, in a root that does not rotate; `damps`: with the damping of the body.
    #[inline(always)]
    fn lane_loads<V: Fours, const L: usize>(
        &self,
        fours: V,
        state: &State<L>,
        (alpha_1_s, damps): (f64, bool),
    ) -> Four<L> {
        let [rate, acceleration, turn, turn1, turn2] = state;
        let mut loads = [[[0.0; L]; 3]; 4];
        let [origin, axes @ ..] = &mut loads;
        *origin = *acceleration;
        if damps {
            add_times(fours, origin, alpha_1_s, rate);
        }
        for ((load, [r, r1, r2]), [by_rate, by_turn]) in axes.iter_mut().zip(&self.axes).zip(&self.damped) {
            let [by_rate, by_turn] = if damps { [*by_rate, *by_turn] } else { [r1 * 2.0, *r2] };
            add_cross(fours, load, turn2, r);
            add_cross(fours, load, turn1, &by_rate);
            add_cross(fours, load, turn, &by_turn);
        }
        loads
    }
}

/// Adds the forces of a mass block on the nodal vectors; `SLIM`: the block couples only `r` and `r_x`.
#[inline(always)]
fn add_mass<const SLIM: bool, V: Fours, const L: usize>(
    fours: V,
    forces: &mut Four<L>,
    mass: impl Fn(usize, usize) -> f64,
    loads: &Four<L>,
) {
    for (i, force) in forces.iter_mut().enumerate() {
        for (j, load) in loads.iter().enumerate() {
            if !SLIM || i == j || (i < 2 && j < 2) {
                add_times(fours, force, mass(i, j), load);
            }
        }
    }
}

/// The arguments of [`Derivative::forward_lanes`](super::Derivative::forward_lanes).
pub(super) struct Product<'a, const L: usize> {
    pub linear: Linear<'a>,
    pub mesh: (&'a Model, &'a [Damping]),
    pub work: &'a mut Lanes<L>,
    pub along: [&'a [[f64; L]]; 3],
    pub sum: &'a mut [[f64; L]],
}

impl<const L: usize> WithFours for Product<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<V: Fours>(self, fours: V) {
        let Self { linear, mesh: (model, damping), work, along: [q, v, a], sum } = self;
        let Linear { links, spots, columns, alphas } = linear;
        let Lanes { states, moved, loads, wrenches } = work;
        for (n, link) in links.iter().enumerate() {
            let mut state = [[[0.0; L]; 3]; 5];
            let mut own = [[0.0; L]; 3];
            if let Some(carrier) = link.carrier {
                state = outward(fours, &states[carrier], &link.arm);
                add_cross(fours, &mut own, &states[carrier][2], &link.arm[0]);
            }
            let along = [q, v, a];
            match link.element {
                Some(_) => move_outer::<V, STRAINS, L>(fours, link, columns, along, (&mut state, &mut own)),
                None if link.count == 1 => move_outer::<V, 1, L>(fours, link, columns, along, (&mut state, &mut own)),
                None => {}
            }
            (states[n], moved[n]) = (state, own);
        }
        for (body, alpha) in model.bodies.iter().zip(alphas) {
            match body.slim_mass {
                true => weigh::<true, V, L>(fours, (model, body, *alpha), spots, states, loads, wrenches),
                false => weigh::<false, V, L>(fours, (model, body, *alpha), spots, states, loads, wrenches),
            }
        }
        for (body, damping) in model.bodies.iter().zip(damping).rev() {
            for n in (body.first_node..=body.last_node()).rev() {
                let link = &links[n];
                match link.element {
                    Some(element) => {
                        project::<V, STRAINS, L>(fours, link, columns, states, (&wrenches[n], q), sum);
                        add_elastic(fours, model, (body, damping), element, [q, v], sum);
                    }
                    None if link.count == 1 => {
                        project::<V, 1, L>(fours, link, columns, states, (&wrenches[n], q), sum);
                    }
                    None => {}
                }
                pass_on(fours, (link, n), moved, wrenches);
            }
        }
    }
}

/// Variation of the outer node due to the `N` unknowns of a link or joint.
#[inline(always)]
fn move_outer<V: Fours, const N: usize, const L: usize>(
    fours: V,
    link: &Link,
    columns: &[Column],
    along: [&[[f64; L]]; 3],
    (state, moved): (&mut State<L>, &mut Triple<L>),
) {
    let [Some(q), Some(v), Some(a)] = along.map(|rows| rows[link.first..].first_chunk::<N>()) else { return };
    let Some(columns) = columns[link.first..].first_chunk::<N>() else { return };
    for i in 0..N {
        // the stretch of an element does not turn the outer end
        let turns = N == 1 || i != STRETCH;
        columns[i].add_lanes(fours, (&mut *state, &mut *moved), [&q[i], &v[i], &a[i]], turns);
    }
}

/// Forces on the `N` unknowns of a link or joint.
#[inline(always)]
fn project<V: Fours, const N: usize, const L: usize>(
    fours: V,
    link: &Link,
    columns: &[Column],
    states: &[State<L>],
    ([force, moment], q): (&[Triple<L>; 2], &[[f64; L]]),
    sum: &mut [[f64; L]],
) {
    let (Some(q), Some(columns)) = (q[link.first..].first_chunk::<N>(), columns[link.first..].first_chunk::<N>())
    else {
        return;
    };
    let Some(sum) = sum[link.first..].first_chunk_mut::<N>() else { return };
    let turn = link.carrier.map_or([[0.0; L]; 3], |carrier| states[carrier][2]);
    for i in 0..N {
        let mut own = [0.0; L];
        add_dot(fours, &mut own, &columns[i].linear[0], force);
        if N == 1 || i != STRETCH {
            add_dot(fours, &mut own, &columns[i].angular[0], moment);
        }
        add_dot(fours, &mut own, &columns[i].turned, &turn);
        if N == STRAINS {
            for (k, changes) in q.iter().enumerate() {
                fours.add(&mut own, link.slopes[(i, k)], changes);
            }
        }
        sum[i] = own;
    }
}

/// Wrench that a link passes to its carrier.
#[inline(always)]
fn pass_on<V: Fours, const L: usize>(
    fours: V,
    (link, n): (&Link, usize),
    moved: &[Triple<L>],
    wrenches: &mut [[Triple<L>; 2]],
) {
    let Some(carrier) = link.carrier else { return };
    let [force, moment] = wrenches[n];
    let [on_force, on_moment] = &mut wrenches[carrier];
    add_times(fours, on_force, 1.0, &force);
    add_times(fours, on_moment, 1.0, &moment);
    // arm × force and moved × force of the point
    add_cross(fours, on_moment, &force, &-link.arm[0]);
    add_cross(fours, on_moment, &moved[n], &link.force);
}

/// Variations of the wrenches on the nodes of a body.
#[inline(always)]
fn weigh<const SLIM: bool, V: Fours, const L: usize>(
    fours: V,
    (model, body, alpha_1_s): (&Model, &Body, f64),
    spots: &[Spot],
    states: &[State<L>],
    loads: &mut [Four<L>],
    wrenches: &mut [[Triple<L>; 2]],
) {
    let range = body.first_node..=body.last_node();
    for n in range.clone() {
        loads[n] = spots[n].lane_loads(fours, &states[n], (alpha_1_s, true));
    }
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    for (i, n) in range.enumerate() {
        let mut forces = [[[0.0; L]; 3]; 4];
        let beam = &model.nodes[n].beam;
        add_mass::<SLIM, V, L>(fours, &mut forces, |i, j| beam[(i, j)], &loads[n]);
        if i > 0 {
            let cross = &elements[i - 1].cross_mass;
            add_mass::<SLIM, V, L>(fours, &mut forces, |i, j| cross[(i, j)], &loads[n - 1]);
        }
        if let Some(element) = elements.get(i) {
            let cross = &element.cross_mass;
            add_mass::<SLIM, V, L>(fours, &mut forces, |i, j| cross[(j, i)], &loads[n + 1]);
        }
        if let Some(attached) = &model.nodes[n].attached {
            let damps = body.damps_attached || alpha_1_s == 0.0;
            let own = if damps { loads[n] } else { spots[n].lane_loads(fours, &states[n], (alpha_1_s, false)) };
            add_mass::<false, V, L>(fours, &mut forces, |i, j| attached[(i, j)], &own);
        }
        let mut moment = [[0.0; L]; 3];
        for (axis, force) in spots[n].axes.iter().zip(&forces[1..]) {
            add_cross(fours, &mut moment, force, &-axis[0]);
        }
        for (k, turn) in states[n][2].iter().enumerate() {
            add_along(fours, &mut moment, &spots[n].by_turn.column(k).into_owned(), turn);
        }
        wrenches[n] = [forces[0], moment];
    }
}

/// Adds the forces of stiffness and stiffness-proportional damping on the strains of an element, eq. (D8).
#[inline(always)]
fn add_elastic<V: Fours, const L: usize>(
    fours: V,
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
    let Some(sum) = sum[element.coordinate..].first_chunk_mut::<STRAINS>() else { return };
    for (block, from) in [Some((&element.elastic.stiffness, element.coordinate)), sibling].into_iter().flatten() {
        let [Some(q), Some(v)] = [q, v].map(|rows| rows[from..].first_chunk::<STRAINS>()) else { return };
        match &body.damping_roots {
            Some(roots) => {
                for k in 0..STRAINS {
                    for i in 0..STRAINS {
                        let entry = block[(i, k)];
                        fours.add(&mut sum[i], entry, &q[k]);
                        fours.add(&mut sum[i], entry * damping.stiffness_s * (roots[i] * roots[k]), &v[k]);
                    }
                }
            }
            None => {
                for k in 0..STRAINS {
                    let mut along = q[k];
                    fours.add(&mut along, damping.stiffness_s, &v[k]);
                    for i in 0..STRAINS {
                        fours.add(&mut sum[i], block[(i, k)], &along);
                    }
                }
            }
        }
    }
}
