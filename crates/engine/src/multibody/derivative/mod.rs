//! Exact derivatives of the residual of the tree in O(n): along a direction, and transposed, NOTATION eqs. (X1)–(X5).
//!
//! For a virtual displacement `w` of the coordinates the residual has the virtual work `S = wᵀ r(q, v, a)`. Its poses, velocities,
//! accelerations and virtual displacements are one product of matrices whose entries are jets ([`crate::math::jet`]); one inward sweep of
//! the adjoints gives `∂S/∂(q, v, a, w) = (Kᵀw, Cᵀw, Mᵀw, r)` at once. The derivative along a direction is the same inward sweep with dual
//! numbers. Both sweeps, all links, joints and loads are written once, for any jet.

mod elastic;
mod forces;
mod loads;

pub use elastic::elastic_products;

use crate::math::jet::{Dual, Jet, Varied, Vector, Virtual, along, moment, plus, three, turned, turned_constant};
use crate::math::jet_link::{JetPose, JetSlopes, pose, pose_and_slopes};
use crate::math::strain::{STRAINS, STRETCH, TWIST};
use crate::multibody::dynamics::Environment;
use crate::multibody::joint::JointKind;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Base, Body, Model};
use forces::Loaded;
use nalgebra::Vector3;

/// Pose of a node in jets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<J> {
    /// Position in m.
    pub position: Vector<J>,
    /// Columns of root ← node.
    pub axes: [Vector<J>; 3],
}

impl<J: Jet> Place<J> {
    /// The root frame, shifted by `position_m`.
    fn root(position_m: &Vector3<f64>) -> Self {
        let number = |value: f64| J::constant(value);
        let axis = |j: usize| three(|i| number(if i == j { 1.0 } else { 0.0 }));
        Self { position: three(|i| number(position_m[i])), axes: [axis(0), axis(1), axis(2)] }
    }

    /// A point fixed to it, in its frame; from its position, root frame.
    fn arm(&self, point_m: &Vector3<f64>) -> Vector<J> {
        turned_constant(&self.axes, point_m)
    }

    /// Outer end of a link on it.
    #[inline(always)]
    fn linked(&self, link: &JetPose<J>) -> Self {
        Self {
            position: plus(self.position, turned(&self.axes, &link.arm_m)),
            axes: three(|j| turned(&self.axes, &link.rotation[j])),
        }
    }
}

/// Forces on the position and the rotation of a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forces<J> {
    /// On the position.
    pub force: Vector<J>,
    /// On the rotation, about the node.
    pub moment: Vector<J>,
}

impl<J: Jet> Forces<J> {
    pub(super) const ZERO: Self = Self { force: [J::ZERO; 3], moment: [J::ZERO; 3] };

    /// Adds forces on a point at the end of an arm.
    pub(super) fn add_at(&mut self, arm: &Vector<J>, force: &Vector<J>) {
        self.force = plus(self.force, *force);
        self.moment = plus(self.moment, moment(arm, force));
    }

    /// Adds forces on another node at the end of an arm that turns with this one.
    pub(super) fn add_beyond(&mut self, arm: &Vector<J>, other: &Self) {
        self.add_at(arm, &other.force);
        self.moment = plus(self.moment, other.moment);
    }
}

/// Poses and forces of all nodes for one ring.
#[derive(Debug, Clone)]
struct Sweep<J> {
    places: Vec<Place<J>>,
    forces: Vec<Forces<J>>,
    rows: Vec<J>,
}

impl<J: Jet> Sweep<J> {
    fn new(model: &Model) -> Self {
        Self {
            places: vec![Place::root(&Vector3::zeros()); model.nodes.len()],
            forces: vec![Forces::ZERO; model.nodes.len()],
            rows: vec![J::ZERO; model.coordinates],
        }
    }

    /// Carries the poses outward.
    fn outward(&mut self, model: &Model, coordinate: &impl Fn(usize) -> J) {
        for body in &model.bodies {
            let carrier = carrier(body, &self.places);
            self.places[body.first_node] = joint_place(body, &carrier, coordinate);
            let elements = &model.elements[body.first_element..body.first_element + body.elements];
            for (element, node) in elements.iter().zip(body.first_node..) {
                let strain = strains(element.coordinate, coordinate);
                self.places[node + 1] = self.places[node].linked(&pose(element.length_m, &strain));
            }
        }
    }

    /// Projects the forces of all nodes on the coordinates.
    fn inward(&mut self, model: &Model, coordinate: &impl Fn(usize) -> J) {
        for body in model.bodies.iter().rev() {
            let mut outer = self.forces[body.last_node()];
            for i in (0..body.elements).rev() {
                let element = &model.elements[body.first_element + i];
                let strain = strains(element.coordinate, coordinate);
                let node = body.first_node + i;
                let mut forces = self.forces[node];
                let on = pass_link(element.length_m, &strain, &self.places[node], &outer, &mut forces);
                for (row, on) in self.rows[element.range()].iter_mut().zip(on) {
                    *row = *row + on;
                }
                outer = forces;
            }
            let carrier = carrier(body, &self.places);
            let c = body.joint.coordinate;
            match &body.joint.kind {
                JointKind::Revolute { axis } => {
                    self.rows[c] = self.rows[c] + along(&carrier.arm(axis), &outer.moment);
                }
                JointKind::Prismatic { axis } => {
                    self.rows[c] = self.rows[c] + along(&carrier.arm(axis), &outer.force);
                }
                JointKind::Clamped | JointKind::Universal { .. } | JointKind::Ball | JointKind::Free => {}
            }
            if let Base::Node(node) = body.base {
                let first = &self.places[body.first_node].position;
                let arm = three(|i| first[i] - self.places[node].position[i]);
                self.forces[node].add_beyond(&arm, &outer);
            }
        }
    }
}

/// The strains of an element.
#[inline(always)]
fn strains<J: Jet>(first: usize, coordinate: &impl Fn(usize) -> J) -> [J; STRAINS] {
    let mut strains = [J::ZERO; STRAINS];
    strains.iter_mut().zip(first..).for_each(|(strain, i)| *strain = coordinate(i));
    strains
}

/// Place of the node that carries a body.
fn carrier<J: Jet>(body: &Body, places: &[Place<J>]) -> Place<J> {
    match &body.base {
        Base::Root(position_m) => Place::root(position_m),
        Base::Node(node) => places[*node],
    }
}

/// Place of a body's first node, eqs. (K9) and (J7).
fn joint_place<J: Jet>(body: &Body, carrier: &Place<J>, coordinate: &impl Fn(usize) -> J) -> Place<J> {
    let mut position = carrier.position;
    if matches!(body.base, Base::Node(_)) {
        position = plus(position, carrier.arm(&body.offset_m));
    }
    let mounted = |axes: &[Vector<J>; 3]| -> [Vector<J>; 3] {
        three(|j| turned_constant(axes, &body.mount.column(j).into_owned()))
    };
    match &body.joint.kind {
        JointKind::Revolute { axis } => {
            let angle = coordinate(body.joint.coordinate);
            let (sine, cosine) = angle.value().sin_cos();
            let cos = angle.composed([cosine, -sine, -cosine, sine]);
            let sin = angle.composed([sine, cosine, -sine, -cosine]);
            let turn: [Vector<J>; 3] = three(|j| {
                let unit = Vector3::ith(j, 1.0);
                let (kept, swing) = (axis * axis[j], axis.cross(&unit));
                three(|i| J::constant(kept[i]) + cos.times(unit[i] - kept[i]) + sin.times(swing[i]))
            });
            let rotated = three(|j| turned(&carrier.axes, &turn[j]));
            Place { position, axes: mounted(&rotated) }
        }
        JointKind::Prismatic { axis } => {
            let way = coordinate(body.joint.coordinate);
            let along = carrier.arm(axis).map(|axis| axis * way);
            Place { position: plus(position, along), axes: mounted(&carrier.axes) }
        }
        JointKind::Clamped | JointKind::Universal { .. } | JointKind::Ball | JointKind::Free => {
            Place { position, axes: mounted(&carrier.axes) }
        }
    }
}

/// Passes the forces at the outer end of a link to its inner node, and returns those on its strains.
fn pass_link<J: Jet>(
    length_m: f64,
    strain: &[J; STRAINS],
    inner: &Place<J>,
    outer: &Forces<J>,
    on_inner: &mut Forces<J>,
) -> [J; STRAINS] {
    let (link, JetSlopes { tangent, slope_m }) = pose_and_slopes(length_m, strain);
    on_inner.add_beyond(&turned(&inner.axes, &link.arm_m), outer);
    let local = |on: &Vector<J>| -> Vector<J> { three(|i| along(&inner.axes[i], on)) };
    let (force, torque) = (local(&outer.force), local(&outer.moment));
    let mut rows = [J::ZERO; STRAINS];
    rows[STRETCH] = along(&tangent[0], &force).times(length_m);
    for j in 0..3 {
        rows[TWIST + j] = (along(&slope_m[j], &force) + along(&tangent[j], &torque)).times(length_m);
    }
    rows
}

/// Scratch of the derivatives, sized once per model.
#[derive(Debug, Clone)]
pub struct Derivative {
    transposed: Sweep<Virtual>,
    varied: Sweep<Varied>,
    dual: Sweep<Dual>,
}

impl Derivative {
    /// Scratch for a model.
    pub fn new(model: &Model) -> Self {
        Self { transposed: Sweep::new(model), varied: Sweep::new(model), dual: Sweep::new(model) }
    }

    /// Adds the derivative of the tree's residual along `direction`, `K δq + C δv + M δa`, to `sum`: inertia, gravity, mass-proportional
    /// damping, loads at stations, loops. Without the strains' own forces ([`elastic_products`]) and forces on joints. Eq. (X5).
    pub fn forward(
        &mut self,
        model: &Model,
        environment: &Environment,
        motion: Motion,
        direction: Motion,
        sum: &mut [f64],
    ) {
        let Self { varied, dual, .. } = self;
        let whole =
            |i: usize| Varied([motion.q[i], motion.v[i], motion.a[i], direction.q[i], direction.v[i], direction.a[i]]);
        let part = |i: usize| Dual([motion.q[i], direction.q[i]]);
        varied.outward(model, &whole);
        Varied::load(model, environment, &varied.places, &mut dual.forces);
        for (place, full) in dual.places.iter_mut().zip(&varied.places) {
            let both = |jet: Varied| Dual([jet.0[0], jet.0[3]]);
            *place = Place { position: full.position.map(both), axes: full.axes.map(|axis| axis.map(both)) };
        }
        dual.rows.fill(Dual::ZERO);
        loads::apply(model, environment.stations, &dual.places, &part, &mut dual.forces, &mut dual.rows);
        dual.inward(model, &part);
        sum.iter_mut().zip(&dual.rows).for_each(|(sum, row)| *sum += row.0[1]);
    }

    /// Adds the transposed products `Kᵀw`, `Cᵀw` and `Mᵀw` of the same parts to `sums`, eq. (X4).
    pub fn reverse(
        &mut self,
        model: &Model,
        environment: &Environment,
        motion: Motion,
        w: &[f64],
        sums: [&mut [f64]; 3],
    ) {
        let sweep = &mut self.transposed;
        let whole = |i: usize| Virtual([motion.q[i], motion.v[i], motion.a[i], w[i]]);
        sweep.outward(model, &whole);
        Virtual::load(model, environment, &sweep.places, &mut sweep.forces);
        sweep.rows.fill(Virtual::ZERO);
        loads::apply(model, environment.stations, &sweep.places, &whole, &mut sweep.forces, &mut sweep.rows);
        sweep.inward(model, &whole);
        for (kind, sum) in sums.into_iter().enumerate() {
            sum.iter_mut().zip(&sweep.rows).for_each(|(sum, row)| *sum += row.0[kind]);
        }
    }
}

#[cfg(test)]
mod tests;
