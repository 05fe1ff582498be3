//! Solution by the factors with all terms of the tree, also transposed: one sweep from the tips to the root and one back, NOTATION eq. (X33).

use crate::beam::element::ElementKind;
use crate::math::strain::STRAINS;
use crate::math::wide::{Fours, OneByOne, WithFours, with_fours};
use crate::multibody::derivative::chain::Timed;
use crate::multibody::derivative::elimination::LinkFactor;
use crate::multibody::derivative::exact::{Exact, Sweep};
use crate::multibody::derivative::gains::{ACCELERATION, RATE, STATE, TURNS, add, at, combined, dot, set};
use crate::multibody::derivative::lanes::{self, Triple, outward};
use crate::multibody::derivative::link::Link;
use crate::multibody::model::Model;
use nalgebra::Vector3;

impl<const N: usize> LinkFactor<N> {
    /// Unknowns for a right-hand side, whose carrier does not move, from the wrench on the outer node.
    #[inline(always)]
    fn reduce<V: Fours, const L: usize>(
        &self,
        fours: V,
        right: &mut [[f64; L]; N],
        outer: &[Triple<L>; 2],
    ) -> [[f64; L]; N] {
        for (right, reach) in right.iter_mut().zip(&self.reach) {
            for (entry, row) in reach.iter().zip(outer.as_flattened()) {
                fours.add(right, -entry, row);
            }
        }
        let mut unknowns = [[0.0; L]; N];
        add_columns(fours, &mut unknowns, 1.0, &self.inverse, right);
        unknowns
    }

    /// Wrench passed to the carrier.
    #[inline(always)]
    fn passed_in<V: Fours, const L: usize>(
        &self,
        fours: V,
        outer: &[Triple<L>; 2],
        arm: &Vector3<f64>,
        unknowns: &[[f64; L]; N],
    ) -> [Triple<L>; 2] {
        let mut passed = moved_wrench(fours, outer, arm);
        add_columns(fours, passed.as_flattened_mut(), 1.0, &self.passed, unknowns);
        passed
    }
}

impl Exact {
    /// Solves `(M + g C + g² K) x = right` by the last factors, eq. (X33): `x` holds the right-hand side and then the solution. Held joints
    /// do not move. Allocates nothing.
    pub fn solve(&mut self, links: &[Link], model: &Model, x: &mut [f64]) {
        let Self { elements, joints, single, .. } = self;
        let x = x.as_chunks_mut::<1>().0;
        with_fours(Solution { links, elements, joints, model, sweep: single, x });
    }

    /// The same for several right-hand sides.
    pub fn solve_lanes<const L: usize>(&self, links: &[Link], model: &Model, sweep: &mut Sweep<L>, x: &mut [[f64; L]]) {
        with_fours(Solution { links, elements: &self.elements, joints: &self.joints, model, sweep, x });
    }

    /// Solves the transposed equations by the same factors.
    pub fn solve_transposed(&mut self, links: &[Link], model: &Model, x: &mut [f64]) {
        let Self { elements, joints, wrenches, states, .. } = self;
        states.fill([0.0; STATE]);
        for (index, body) in model.bodies.iter().enumerate().rev() {
            let pairs = body.kind == ElementKind::Linear;
            let mut sibling = [0.0; STRAINS];
            for i in (0..body.elements).rev() {
                let (factor, n) = (&elements[body.first_element + i], body.first_node + i + 1);
                let link = &links[n];
                let own = &mut x[link.range()];
                let mut on: [f64; STRAINS] = std::array::from_fn(|k| own[k] + dot(&factor.moved[k], &states[n]));
                if pairs && i % 2 == 0 {
                    add(&mut on, -1.0, &sibling);
                }
                let mut passed = inward(&states[n], &link.arm);
                (0..STATE).for_each(|k| passed[k] -= dot(&factor.by_carrier[k], &on));
                add(&mut states[n - 1], 1.0, &passed);
                own.copy_from_slice(&on);
                sibling = factor.sibling.map(|column| dot(&column, &on));
            }
            let (n, link) = (body.first_node, &links[body.first_node]);
            let mut passed = inward(&states[n], &link.arm);
            if let Some(factor) = &joints[index] {
                x[link.first] += dot(&factor.moved[0], &states[n]);
                (0..STATE).for_each(|k| passed[k] -= factor.by_carrier[k][0] * x[link.first]);
            } else if link.count == 1 {
                x[link.first] = 0.0;
            }
            if let Some(carrier) = link.carrier {
                add(&mut states[carrier], 1.0, &passed);
            }
        }
        for (index, body) in model.bodies.iter().enumerate() {
            let (n, link) = (body.first_node, &links[body.first_node]);
            let before = link.carrier.map_or([0.0; 6], |carrier| wrenches[carrier]);
            let mut moved = moved_out(&before, &link.arm[0]);
            if let Some(factor) = &joints[index] {
                x[link.first] = factor.inverse[0][0] * (x[link.first] + dot(&factor.passed[0], &before));
                add(&mut moved, -x[link.first], &factor.reach[0]);
            }
            wrenches[n] = moved;
            let pairs = body.kind == ElementKind::Linear;
            let mut sibling = [0.0; STRAINS];
            for i in 0..body.elements {
                let (factor, n) = (&elements[body.first_element + i], body.first_node + i + 1);
                let link = &links[n];
                let own = &mut x[link.range()];
                let mut on: [f64; STRAINS] = std::array::from_fn(|k| own[k] + dot(&factor.passed[k], &moved));
                if pairs && i % 2 == 1 {
                    add(&mut on, -1.0, &sibling);
                }
                let solved = factor.inverse.map(|column| dot(&column, &on));
                own.copy_from_slice(&solved);
                moved = moved_out(&moved, &link.arm[0]);
                add(&mut moved, -1.0, &combined(OneByOne, &factor.reach, &solved));
                wrenches[n] = moved;
                sibling = factor.sibling.map(|column| dot(&column, &solved));
            }
        }
    }
}

/// The transpose of [`outward`].
#[inline(always)]
fn inward(state: &[f64; STATE], [r, r1, r2]: &Timed) -> [f64; STATE] {
    let (b1, b2) = (at(state, RATE), at(state, ACCELERATION));
    let [turn, turn1, turn2] = TURNS.map(|place| at(state, place));
    let mut inner = *state;
    set(&mut inner, TURNS[0], &(turn + r1.cross(&b1) + r2.cross(&b2)));
    set(&mut inner, TURNS[1], &(turn1 + r.cross(&b1) + r1.cross(&b2) * 2.0));
    set(&mut inner, TURNS[2], &(turn2 + r.cross(&b2)));
    inner
}

/// Both sweeps of a solution.
struct Solution<'a, const L: usize> {
    links: &'a [Link],
    elements: &'a [LinkFactor<STRAINS>],
    joints: &'a [Option<LinkFactor<1>>],
    model: &'a Model,
    sweep: &'a mut Sweep<L>,
    x: &'a mut [[f64; L]],
}

impl<const L: usize> WithFours for Solution<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<V: Fours>(self, fours: V) {
        let Self { links, elements, joints, model, sweep: Sweep { wrenches, states }, x } = self;
        wrenches.fill([[[0.0; L]; 3]; 2]);
        for (index, body) in model.bodies.iter().enumerate().rev() {
            let pairs = body.kind == ElementKind::Linear;
            let mut sibling = [[0.0; L]; STRAINS];
            for i in (0..body.elements).rev() {
                let (factor, n) = (&elements[body.first_element + i], body.first_node + i + 1);
                let link = &links[n];
                let own = &mut x[link.range()];
                let mut right: [[f64; L]; STRAINS] = std::array::from_fn(|k| own[k]);
                if pairs && i % 2 == 0 {
                    add_columns(fours, &mut right, -1.0, &factor.sibling, &sibling);
                }
                sibling = factor.reduce(fours, &mut right, &wrenches[n]);
                let passed = factor.passed_in(fours, &wrenches[n], &link.arm[0], &sibling);
                add_wrench(fours, &mut wrenches[n - 1], &passed);
                own.copy_from_slice(&sibling);
            }
            let (n, link) = (body.first_node, &links[body.first_node]);
            let passed = match &joints[index] {
                Some(factor) => {
                    let unknown = factor.reduce(fours, &mut [x[link.first]], &wrenches[n]);
                    x[link.first] = unknown[0];
                    factor.passed_in(fours, &wrenches[n], &link.arm[0], &unknown)
                }
                None => {
                    x[link.range()].fill([0.0; L]);
                    moved_wrench(fours, &wrenches[n], &link.arm[0])
                }
            };
            if let Some(carrier) = link.carrier {
                add_wrench(fours, &mut wrenches[carrier], &passed);
            }
        }
        for (index, body) in model.bodies.iter().enumerate() {
            let (n, link) = (body.first_node, &links[body.first_node]);
            let before = link.carrier.map_or([[[0.0; L]; 3]; 5], |carrier| states[carrier]);
            let mut state = outward(fours, &before, &link.arm);
            if let Some(factor) = &joints[index] {
                let mut unknown = [x[link.first]];
                add_columns(fours, &mut unknown, -1.0, &factor.by_carrier, before.as_flattened());
                x[link.first] = unknown[0];
                add_columns(fours, state.as_flattened_mut(), 1.0, &factor.moved, &unknown);
            }
            states[n] = state;
            let pairs = body.kind == ElementKind::Linear;
            let mut sibling = [[0.0; L]; STRAINS];
            for i in 0..body.elements {
                let (factor, n) = (&elements[body.first_element + i], body.first_node + i + 1);
                let link = &links[n];
                let own = &mut x[link.range()];
                let mut unknowns: [[f64; L]; STRAINS] = std::array::from_fn(|k| own[k]);
                add_columns(fours, &mut unknowns, -1.0, &factor.by_carrier, state.as_flattened());
                if pairs && i % 2 == 1 {
                    add_columns(fours, &mut unknowns, -1.0, &factor.sibling, &sibling);
                }
                own.copy_from_slice(&unknowns);
                state = outward(fours, &state, &link.arm);
                add_columns(fours, state.as_flattened_mut(), 1.0, &factor.moved, &unknowns);
                states[n] = state;
                sibling = unknowns;
            }
        }
    }
}

/// `sum += sign · Σ columns[k] · rows[k]`.
#[inline(always)]
fn add_columns<V: Fours, const R: usize, const C: usize, const L: usize>(
    fours: V,
    sum: &mut [[f64; L]],
    sign: f64,
    columns: &[[f64; R]; C],
    rows: &[[f64; L]],
) {
    let (Some(sum), Some(rows)) = (sum.first_chunk_mut::<R>(), rows.first_chunk::<C>()) else { return };
    if L == 1 {
        // the entries of a column are vectors of the processor
        let Some(sum) = sum.as_flattened_mut().first_chunk_mut::<R>() else { return };
        for k in 0..C {
            fours.add(sum, sign * rows[k][0], &columns[k]);
        }
        return;
    }
    for k in 0..C {
        for i in 0..R {
            fours.add(&mut sum[i], sign * columns[k][i], &rows[k]);
        }
    }
}

#[inline(always)]
fn add_wrench<V: Fours, const L: usize>(fours: V, sum: &mut [Triple<L>; 2], wrench: &[Triple<L>; 2]) {
    for i in 0..3 {
        fours.add(&mut sum[0][i], 1.0, &wrench[0][i]);
        fours.add(&mut sum[1][i], 1.0, &wrench[1][i]);
    }
}

/// Wrenches at the carrier of wrenches at the end of an arm.
#[inline(always)]
fn moved_wrench<V: Fours, const L: usize>(fours: V, wrench: &[Triple<L>; 2], arm: &Vector3<f64>) -> [Triple<L>; 2] {
    let mut inner = *wrench;
    lanes::add_cross(fours, &mut inner[1], &wrench[0], &-arm);
    inner
}

/// Virtual motion of the end of an arm, from that of the carrier: the transpose of [`moved_wrench`].
#[inline(always)]
fn moved_out(motion: &[f64; 6], arm: &Vector3<f64>) -> [f64; 6] {
    let mut outer = *motion;
    set(&mut outer, 0, &(at(motion, 0) + at(motion, 3).cross(arm)));
    outer
}
