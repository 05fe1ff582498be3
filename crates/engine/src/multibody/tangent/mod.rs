//! Exact tangent of the static residual: elasticity, gravity, dead or follower loads at stations, a rotating root.
//!
//! The tangent is not symmetric: forces and moments rotate with the body or are fixed in the root frame, and rotations do not commute. It
//! is stored link by link and never assembled: [`Tangent::apply`] multiplies by it, [`Tangent::factorize`] and [`Tangent::solve`] solve
//! with it, each in O(n); NOTATION eqs. (L1)–(L7). Closed loops add a small dense correction.
//!
//! Vectors have [`Model::coordinates`] entries, like the residual. A joint with redundant parameters uses the first of its entries for its
//! degrees of freedom (rotations about its axes, rad); the other entries are zero. [`Tangent::to_coordinates`] converts them to changes of
//! the parameters.

mod block;
mod closure;
mod elimination;
mod factor;
mod inertia;
mod joint;
mod links;
mod loops;
mod modal;
mod rigid;
mod slope;
mod twist;

pub use joint::JointTangent;

use crate::load::{LoadFrame, RootMotion, Wrench};
use crate::math::so3::hat;
use crate::math::strain::{SHEARED, STRAINS, Strain};
use crate::multibody::carriage::SlideWork;
use crate::multibody::model::{Base, Body, Model};
use crate::multibody::nodal::multiply;
use crate::multibody::station;
use crate::multibody::workspace::{Pair, Workspace};
use block::{Cross, SHEARED_UNKNOWNS, SlopeTangent, UNKNOWNS};
use elimination::Factor;
use joint::JointBlock;
use links::{Links, link_tangent};
use loops::{ClosureTangent, Coupling, RigidTangent};
use modal::ModalTangent;
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};
use twist::{add, add_turning, follower, inertia, pair, twist};

/// No solution: the tangent has a zero pivot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the static tangent is singular at coordinate {coordinate}")]
pub struct SingularTangent {
    /// Index in `q` of the pivot's block.
    pub coordinate: usize,
}

/// Quantities other than the configuration on which the tangent depends.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    /// Gravity and motion of the root.
    pub root: &'a RootMotion,
    /// Wrench per station, in the station's frame; empty without loads.
    pub stations: &'a [Wrench],
    /// Per body: springs of its joint. Entries of clamped bodies are ignored.
    pub joints: &'a [JointTangent],
}

/// The tangent, link by link, with its factors.
#[derive(Debug, Clone)]
pub struct Tangent {
    /// Change of the wrench on each node itself with its twist.
    nodes: Vec<Matrix6<f64>>,
    /// Elements without shear.
    plain: Links<STRAINS, UNKNOWNS>,
    /// Elements with shear; empty if there are none.
    sheared: Links<SHEARED, SHEARED_UNKNOWNS>,
    /// Centrifugal coupling of the ends of each element; empty while the root does not rotate.
    cross: Vec<Cross>,
    joints: Vec<JointBlock>,
    /// Per body: tangents of modal bodies.
    modal: Vec<Option<Box<ModalTangent>>>,
    joint_factors: Vec<Option<Factor>>,
    modal_factors: Vec<Option<Factor>>,
    closures: Vec<ClosureTangent>,
    coupling: Option<Coupling>,
    rigid: Option<RigidTangent>,
    displaced: Vec<Pair>,
    wrenches: Vec<Pair>,
    /// Carriages of sliding joints; only [`Self::node_displacements`] supports them.
    slides: Vec<SlideWork>,
}

impl Tangent {
    /// Allocates the tangent of a model.
    pub fn new(model: &Model) -> Self {
        let (nodes, elements, bodies) = (model.nodes.len(), model.elements.len(), model.bodies.len());
        Self {
            nodes: vec![Matrix6::zeros(); nodes],
            plain: Links::new(elements),
            sheared: Links::new(if model.sheared { elements } else { 0 }),
            cross: Vec::new(),
            joints: vec![JointBlock::default(); bodies],
            joint_factors: vec![None; bodies],
            modal: vec![None; bodies],
            modal_factors: vec![None; bodies],
            closures: Vec::new(),
            coupling: None,
            rigid: None,
            displaced: vec![Pair::ZERO; nodes],
            wrenches: vec![Pair::ZERO; nodes],
            slides: Vec::new(),
        }
    }

    /// Linearises about `q`. `work` must hold the static residual of `q` (zero rates and accelerations) under the same loads and root
    /// motion.
    pub fn linearize(&mut self, model: &Model, work: &Workspace, q: &[f64], surroundings: Surroundings) {
        self.linearize_shifted(model, work, q, surroundings, 0.0);
    }

    /// [`Self::linearize`] for `K + σ BᵀMB`, with `σ` in 1/s²; eq. (L15).
    pub fn linearize_shifted(
        &mut self,
        model: &Model,
        work: &Workspace,
        q: &[f64],
        surroundings: Surroundings,
        shift_1_s2: f64,
    ) {
        let turn = hat(&surroundings.root.angular_velocity_rad_s);
        let frame = hat(&surroundings.root.angular_acceleration_rad_s2)
            + turn * turn
            + Matrix3::from_diagonal_element(shift_1_s2);
        let rotates = surroundings.root.rotates() || shift_1_s2 != 0.0;
        self.linearize_nodes(model, work, &frame);
        self.slides.clone_from(&work.slides);
        self.cross.clear();
        for (index, body) in model.bodies.iter().enumerate() {
            for i in 0..body.elements {
                let e = body.first_element + i;
                let element = &model.elements[e];
                let (inner, outer) = (&work.nodes[body.first_node + i], &work.nodes[body.first_node + i + 1]);
                let place = (e, body.first_node + i);
                match body.sheared {
                    false => self.plain.links[e] = link_tangent(model, work, q, place),
                    true => self.sheared.links[e] = link_tangent(model, work, q, place),
                }
                if body.sheared {
                    let ends = (&work.nodes[place.1..place.1 + 2], &work.slopes[e]);
                    let [at_inner, at_outer] = &mut self.nodes[place.1..place.1 + 2] else { unreachable!() };
                    let (slope, cross) = SlopeTangent::new(element, &frame, ends, [at_inner, at_outer]);
                    self.sheared.slopes[e] = slope;
                    if rotates {
                        self.cross.push(cross);
                    }
                } else if rotates {
                    self.cross.push(Cross {
                        outer_inner: inertia(&element.cross_mass, &frame, &outer.rotation, &inner.rotation),
                        inner_outer: inertia(&element.cross_mass.transpose(), &frame, &inner.rotation, &outer.rotation),
                    });
                }
            }
            self.modal[index] = match (&body.modal, &work.modal[index]) {
                (Some(modal), Some(scratch)) => {
                    let nodes = [&work.nodes[body.first_node], &work.nodes[body.last_node()]];
                    Some(Box::new(ModalTangent::new(modal, scratch, nodes, &frame)))
                }
                _ => None,
            };
            let mut joint = surroundings.joints[index];
            joint.stiffness[(0, 0)] += shift_1_s2 * body.joint.drive_inertia;
            self.joints[index] = JointBlock::new(model, work, index, &joint);
        }
        self.linearize_stations(model, work, q, surroundings.stations);
        self.linearize_closures(model, work);
    }

    /// Linearises the nodal forces, which rotate with their node and depend on its position in a rotating frame, eq. (L4).
    fn linearize_nodes(&mut self, model: &Model, work: &Workspace, frame: &Matrix3<f64>) {
        for (n, (tangent, mass)) in self.nodes.iter_mut().zip(&model.nodes).enumerate() {
            let node = &work.nodes[n];
            let whole = mass.attached.map_or(mass.beam, |attached| attached + mass.beam);
            *tangent = inertia(&whole, frame, &node.rotation, &node.rotation);
            add_turning(tangent, &node.rotation, &multiply(&whole, &node.load_rate));
        }
        for body in model.bodies.iter().filter(|body| !body.sheared) {
            for i in 0..body.elements {
                let cross = &model.elements[body.first_element + i].cross_mass;
                let (a, b) = (body.first_node + i, body.first_node + i + 1);
                let (inner, outer) = (&work.nodes[a], &work.nodes[b]);
                add_turning(&mut self.nodes[a], &inner.rotation, &multiply(&cross.transpose(), &outer.load_rate));
                add_turning(&mut self.nodes[b], &outer.rotation, &multiply(cross, &inner.load_rate));
            }
        }
    }

    fn linearize_stations(&mut self, model: &Model, work: &Workspace, q: &[f64], loads: &[Wrench]) {
        self.plain.stations.fill(None);
        self.sheared.stations.fill(None);
        for (place, load) in model.stations.iter().zip(loads).filter(|(_, load)| !load.is_zero()) {
            if let Some(node) = station::node_under(model, place) {
                if place.frame == LoadFrame::Section {
                    let rotation = &work.nodes[node].rotation;
                    self.nodes[node] += follower(&(rotation * load.force_n), &(rotation * load.moment_n_m));
                }
                continue;
            }
            let body = &model.bodies[place.body];
            if let (Some(modal), Some(scratch), Some(tangent)) =
                (&body.modal, &work.modal[place.body], &mut self.modal[place.body])
            {
                let node = &work.nodes[body.first_node];
                tangent.add_load(modal, scratch, node, place.offset_m, (load, place.frame));
                continue;
            }
            match body.sheared {
                false => self.plain.add_load(model, work, q, (place, load)),
                true => self.sheared.add_load(model, work, q, (place, load)),
            }
        }
    }

    /// `y = K x`: change of the residual due to a change of the coordinates. Entries of held joints are not read, and are zero in `y`.
    pub fn apply(&mut self, model: &Model, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.displace(model, x);
        for (n, wrench) in self.wrenches.iter_mut().enumerate() {
            *wrench = pair(&(self.nodes[n] * twist(&self.displaced[n])));
        }
        if !self.cross.is_empty() {
            for body in &model.bodies {
                for i in 0..body.elements {
                    let (cross, a) = (&self.cross[body.first_element + i], body.first_node + i);
                    let (inner, outer) = (twist(&self.displaced[a]), twist(&self.displaced[a + 1]));
                    add(&mut self.wrenches[a], &(cross.inner_outer * outer));
                    add(&mut self.wrenches[a + 1], &(cross.outer_inner * inner));
                }
            }
        }
        self.push_closures();
        for (index, body) in model.bodies.iter().enumerate().rev() {
            let nodes = (&self.displaced[..], &mut self.wrenches[..]);
            match body.sheared {
                false => self.plain.apply(model, body, x, y, nodes),
                true => self.sheared.apply(model, body, x, y, nodes),
            }
            if let Some(modal) = &self.modal[index] {
                let outer = twist(&self.wrenches[body.last_node()]);
                let passed = modal.push(x, &twist(&self.displaced[body.first_node]), &outer, y);
                add(&mut self.wrenches[body.first_node], &passed);
            }
            let wrench = twist(&self.wrenches[body.first_node]);
            let before = self.base_twist(model, body, x);
            let passed = self.joints[index].push(x, &before, &wrench, y);
            if let Base::Node(node) = body.base {
                add(&mut self.wrenches[node], &passed);
            }
        }
    }

    /// Computes the twists of all nodes due to a change of the coordinates.
    fn displace(&mut self, model: &Model, x: &[f64]) {
        for (index, body) in model.bodies.iter().enumerate() {
            let mut moved = self.joints[index].displaced(x, &self.base_twist(model, body, x));
            self.displaced[body.first_node] = pair(&moved);
            if let Some(modal) = &self.modal[index] {
                self.displaced[body.last_node()] = pair(&modal.displaced(x, &moved));
            }
            for i in 0..body.elements {
                let e = body.first_element + i;
                let element = &model.elements[e];
                moved = match body.sheared {
                    false => self.plain.links[e].displaced(&Strain::from(element.strains(x)), &moved),
                    true => self.sheared.links[e].displaced(&Strain::from(element.strains(x)), &moved),
                };
                self.displaced[body.first_node + i + 1] = pair(&moved);
            }
        }
    }

    fn base_twist(&self, model: &Model, body: &Body, x: &[f64]) -> Vector6<f64> {
        match body.base {
            Base::Root(_) => Vector6::zeros(),
            Base::Node(node) => twist(&self.displaced[node]),
            Base::Axis(index) => {
                let (slide, own) = (&model.slides[index], &self.slides[index]);
                twist(&own.displaced(model, slide, &self.displaced[own.inner_node(model, slide)], x))
            }
        }
    }

    /// Displacement (m) and rotation vector (rad) of every node, root frame, due to a change of the coordinates.
    pub fn node_displacements(&mut self, model: &Model, x: &[f64]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        self.displace(model, x);
        self.displaced.iter().map(|moved| (moved.linear, moved.angular)).collect()
    }

    /// The whole matrix, column by column, for modes and linearisation of small models, O(n²).
    pub fn dense(&mut self, model: &Model) -> DMatrix<f64> {
        let n = model.coordinates;
        let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
        let mut matrix = DMatrix::zeros(n, n);
        for j in 0..n {
            unit[j] = 1.0;
            self.apply(model, &unit, &mut column);
            matrix.column_mut(j).copy_from_slice(&column);
            unit[j] = 0.0;
        }
        matrix
    }

    /// Converts changes of the degrees of freedom to changes of the coordinates, in place; `work` holds the poses of the linearisation.
    pub fn to_coordinates(model: &Model, work: &Workspace, x: &mut [f64]) {
        for (body, joint) in model.bodies.iter().zip(&work.joints) {
            body.joint.expand_freedoms(joint, x);
        }
    }
}
