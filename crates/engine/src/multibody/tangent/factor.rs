//! Factorisation and solution in O(n): in every element or pair the strains are eliminated by a small LU factorisation, in every joint its
//! degrees of freedom, and a 6×6 tangent is passed inward; NOTATION eqs. (L5) and (L7).

use crate::math::strain::Strain;
use crate::multibody::model::{Base, Body, Element, Model, Strained};
use crate::multibody::tangent::block::{Block, Cross, Unknowns};
use crate::multibody::tangent::elimination::Factor;
use crate::multibody::tangent::links::{Links, strains_of, stride};
use crate::multibody::tangent::twist::{add, pair, twist};
use crate::multibody::tangent::{SingularTangent, Tangent};
use crate::multibody::workspace::Pair;
use nalgebra::{Const, DimMin, Matrix6, Vector6};

impl Tangent {
    /// Factorises the linearisation.
    pub fn factorize(&mut self, model: &Model) -> Result<(), SingularTangent> {
        let mut outer = self.nodes.clone();
        self.add_own_springs(&mut outer);
        for (index, body) in model.bodies.iter().enumerate().rev() {
            match body.sheared {
                false => self.plain.factorize(model, body, &self.cross, &mut outer)?,
                true => self.sheared.factorize(model, body, &self.cross, &mut outer)?,
            }
            if let Some(modal) = &self.modal[index] {
                let (factor, passed) = Factor::new(modal.block(&outer[body.last_node()]), &modal.sizes, modal.modes)
                    .ok_or(SingularTangent { coordinate: modal.coordinate })?;
                self.modal_factors[index] = Some(factor);
                outer[body.first_node] += passed;
            }
            let joint = &self.joints[index];
            let mut passed = joint.passed(&outer[body.first_node]);
            self.joint_factors[index] = None;
            if joint.freedoms > 0 {
                let (block, sizes) = joint.block(&outer[body.first_node]);
                let (factor, rest) = Factor::new(block, &sizes, joint.freedoms)
                    .ok_or(SingularTangent { coordinate: joint.coordinate })?;
                self.joint_factors[index] = Some(factor);
                passed = rest;
            }
            if let Base::Node(node) = body.base {
                outer[node] += passed;
            }
        }
        self.factorize_closures(model)?;
        self.factorize_rigid(model);
        Ok(())
    }

    /// Solves with the last factorisation: `x` holds the right-hand side and then the solution. Held joints do not move.
    pub fn solve(&mut self, model: &Model, x: &mut [f64]) {
        self.solve_tree(model, x, None);
        self.correct_closures(x);
        self.correct_rigid(model, x);
    }

    /// Solves for the tree with the springs at the closures' ends; the right-hand side may include a wrench on a node.
    pub(super) fn solve_tree(&mut self, model: &Model, x: &mut [f64], load: Option<(usize, &Vector6<f64>)>) {
        self.wrenches.fill(Pair::ZERO);
        if let Some((node, wrench)) = load {
            // a wrench on the side of the residual is negative on the right-hand side
            self.wrenches[node] = pair(&-wrench);
        }
        for (index, body) in model.bodies.iter().enumerate().rev() {
            match body.sheared {
                false => self.plain.reduce(model, body, x, &mut self.wrenches),
                true => self.sheared.reduce(model, body, x, &mut self.wrenches),
            }
            if let (Some(modal), Some(factor)) = (&self.modal[index], &mut self.modal_factors[index]) {
                let outer = twist(&self.wrenches[body.last_node()]);
                factor.right = modal.read(x) - modal.partial.transpose() * outer;
                let passed = modal.carried(&outer) + factor.ax * factor.solve(&factor.right);
                add(&mut self.wrenches[body.first_node], &passed);
            }
            let mut wrench = twist(&self.wrenches[body.first_node]);
            let joint = &self.joints[index];
            if let Some(factor) = &mut self.joint_factors[index] {
                let mut right = -joint.projected(&wrench);
                for k in 0..joint.freedoms {
                    right[k] += x[joint.coordinate + k];
                }
                factor.right = right;
                wrench = joint.carried(&wrench) + factor.ax * factor.solve(&right);
            } else {
                wrench = joint.carried(&wrench);
            }
            if let Base::Node(node) = body.base {
                add(&mut self.wrenches[node], &wrench);
            }
        }
        self.substitute(model, x);
    }

    /// Outward half of [`Self::solve`].
    fn substitute(&mut self, model: &Model, x: &mut [f64]) {
        for (index, body) in model.bodies.iter().enumerate() {
            let before = self.base_twist(model, body, x);
            x[body.joint.range()].fill(0.0);
            let joint = &self.joints[index];
            if let Some(factor) = &self.joint_factors[index] {
                let freedoms = factor.solve(&(factor.right - factor.xa * before));
                x[joint.coordinate..joint.coordinate + joint.freedoms]
                    .copy_from_slice(&freedoms.as_slice()[..joint.freedoms]);
            }
            let moved = joint.displaced(x, &before);
            self.displaced[body.first_node] = pair(&moved);
            if let (Some(modal), Some(factor)) = (&self.modal[index], &self.modal_factors[index]) {
                let own = factor.solve(&(factor.right - factor.xa * moved));
                x[modal.coordinate..modal.coordinate + modal.modes].copy_from_slice(&own.as_slice()[..modal.modes]);
                self.displaced[body.last_node()] = pair(&modal.displaced(x, &moved));
            }
            match body.sheared {
                false => self.plain.expand(model, body, x, &mut self.displaced),
                true => self.sheared.expand(model, body, x, &mut self.displaced),
            }
        }
    }
}

impl<const N: usize, const U: usize> Links<N, U>
where
    Element: Strained<N>,
    Const<U>: DimMin<Const<U>, Output = Const<U>>,
{
    /// Eliminates the strains of a body; `outer` are the tangents of the nodes.
    fn factorize(
        &mut self,
        model: &Model,
        body: &Body,
        cross: &[Cross],
        outer: &mut [Matrix6<f64>],
    ) -> Result<(), SingularTangent> {
        let stride = stride(body);
        for i in (0..body.elements).step_by(stride).rev() {
            let e = body.first_element + i;
            let n = body.first_node + i;
            let (block, sizes) = self.segment(model, body, i, (cross, outer));
            let strains = strains_of(model, e, stride);
            let (factor, passed) =
                Factor::new(block, &sizes, strains.len()).ok_or(SingularTangent { coordinate: strains.start })?;
            self.factors[e] = Some(factor);
            outer[n] += passed;
        }
        Ok(())
    }

    /// Block of the element or pair that starts with element `i` of a body, and the sizes of its pivots.
    fn segment(
        &self,
        model: &Model,
        body: &Body,
        i: usize,
        (cross, outer): (&[Cross], &[Matrix6<f64>]),
    ) -> (Block<U>, [f64; U]) {
        let (e, n) = (body.first_element + i, body.first_node + i);
        let stride = stride(body);
        let cross = if cross.is_empty() { &[] } else { &cross[e..e + stride] };
        let slopes = if self.slopes.is_empty() { &[] } else { &self.slopes[e..e + stride] };
        let inertia = (cross, slopes);
        let mut block = Block::<U>::of_links(&self.links[e..e + stride], inertia, &outer[n + stride], &outer[n + 1]);
        let mut sizes = [1.0; U];
        for half in 0..stride {
            let elastic = model.elements[e + half].elastic();
            let first = N * half;
            let mut own = block.xx.fixed_view_mut::<N, N>(first, first);
            own += elastic.stiffness;
            for k in 0..N {
                sizes[first + k] = elastic.stiffness[(k, k)];
            }
            if stride == 2 {
                let mut coupling = block.xx.fixed_view_mut::<N, N>(first, N - first);
                coupling += elastic.coupling;
            }
        }
        if let Some(stations) = &self.stations[e] {
            block.add(stations);
        }
        (block, sizes)
    }

    /// Inward half of [`Tangent::solve`] over the elements of a body.
    fn reduce(&mut self, model: &Model, body: &Body, x: &[f64], wrenches: &mut [Pair]) {
        let stride = stride(body);
        for i in (0..body.elements).step_by(stride).rev() {
            let (e, n) = (body.first_element + i, body.first_node + i);
            let mut wrench = twist(&wrenches[n + stride]);
            let mut right = Unknowns::<U>::zeros();
            for half in (0..stride).rev() {
                let link = &self.links[e + half];
                let forces = Strain::from(model.elements[e + half].strains(x)) - link.jacobian.transpose() * wrench;
                right.fixed_rows_mut::<N>(N * half).copy_from(&forces);
                wrench = link.carried(&wrench);
            }
            if let Some(factor) = &mut self.factors[e] {
                factor.right = right;
                wrench += factor.ax * factor.solve(&right);
            }
            add(&mut wrenches[n], &wrench);
        }
    }

    /// Outward half over the elements of a body, whose first node has moved.
    fn expand(&self, model: &Model, body: &Body, x: &mut [f64], displaced: &mut [Pair]) {
        let stride = stride(body);
        let mut moved = twist(&displaced[body.first_node]);
        for i in (0..body.elements).step_by(stride) {
            let e = body.first_element + i;
            let Some(factor) = &self.factors[e] else { continue };
            let strains = factor.solve(&(factor.right - factor.xa * moved));
            for half in 0..stride {
                let own: Strain<N> = strains.fixed_rows::<N>(N * half).into_owned();
                x[model.elements[e + half].range()].copy_from_slice(own.as_slice());
                moved = self.links[e + half].displaced(&own, &moved);
                displaced[body.first_node + i + half + 1] = pair(&moved);
            }
        }
    }
}
