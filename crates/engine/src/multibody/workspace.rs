//! Workspace of the recursions, allocated once per model and overwritten by every sweep.

use crate::math::local_jacobian::LocalJacobian;
use crate::math::local_link::{LANES, LocalLinks, LocalMotions};
use crate::math::se3::Link;
use crate::math::strain::STRAINS;
use crate::multibody::carriage::SlideWork;
use crate::multibody::joint::JointWork;
use crate::multibody::loops::ClosureFactor;
use crate::multibody::modal::ModalWork;
use crate::multibody::model::{Base, Model};
use crate::multibody::node::Eliminated;
use crate::multibody::rigid_factor::RigidFactor;
use crate::multibody::runner::ROWS;
use crate::multibody::sheared_panel::ShearedFactor;
use crate::multibody::slope_vector::Slope;
use nalgebra::Vector3;
use std::sync::Arc;

pub use crate::multibody::node::{ArticulatedInertia, ElementFactor, Node, Pair};

/// Workspace of the recursions.
#[derive(Debug, Clone)]
pub struct Workspace {
    /// Motion and wrench of each node.
    pub nodes: Vec<Node>,
    /// Poses and Jacobians of all elements in their own frames, in groups, from the last sweep.
    pub(crate) local_links: Vec<LocalLinks>,
    /// Per element: vector from the inner to the outer end in the root frame, from the last sweep, m.
    pub(crate) arms: Vec<Vector3<f64>>,
    /// Rates and accelerations that correspond to `local_links`.
    pub(crate) local_motions: Vec<LocalMotions>,
    /// Per body: its joint.
    pub joints: Vec<JointWork>,
    /// Per body: workspace of modal bodies.
    pub(crate) modal: Vec<Option<Box<ModalWork>>>,
    /// Reaction force at the root's origin: inertia forces minus loads of the whole wing, N.
    pub root_force: Vector3<f64>,
    /// Moment of that reaction about the origin, N·m.
    pub root_moment: Vector3<f64>,
    /// Per sliding joint: its carriage.
    pub(crate) slides: Vec<SlideWork>,
    /// Per node: velocity and angular velocity before an impulse, for machines with sliding joints.
    pub(crate) carried: Vec<Pair>,
    pub(crate) inertia: Vec<ArticulatedInertia>,
    pub(crate) bias: Vec<Pair>,
    /// Per element: slopes of the axis at its inner and outer ends, for elements with shear; empty if there are none.
    pub(crate) slopes: Vec<[Slope; 2]>,
    /// Elements without shear.
    pub(crate) plain: Eliminated<STRAINS>,
    /// Elements with shear; empty if there are none.
    pub(crate) sheared: Vec<ShearedFactor>,
    pub(crate) closure_factor: ClosureFactor,
    pub(crate) rigid_factor: RigidFactor,
    /// Factors by which states are projected onto the constraints in place of the last ones: those of a run on a tape, along whose steps another
    /// machine runs.
    pub(crate) closing: Option<Arc<RigidFactor>>,
    /// Per constraint: its multipliers in N at the last wrenches; of a rigid loop the force on its first point, root frame.
    pub(crate) rigid_forces: Vec<Vector3<f64>>,
}

impl Workspace {
    /// Jacobian of an element in its own frame, from the last sweep.
    #[inline]
    pub(crate) fn jacobian(&self, element: usize) -> LocalJacobian {
        LocalJacobian::of(&self.local_links[element / LANES], element % LANES)
    }

    /// An element's link in the root frame at the poses of the last sweep; `node` is its inner node.
    #[inline]
    pub(crate) fn link<const N: usize>(&self, model: &Model, element: usize, node: usize) -> Link<N> {
        self.jacobian(element).turned(&self.nodes[node].rotation, model.elements[element].length_m)
    }

    /// Takes over the outward sweep of another workspace.
    pub(crate) fn take_sweep(&mut self, other: &Self) {
        self.nodes.copy_from_slice(&other.nodes);
        self.local_links.copy_from_slice(&other.local_links);
        self.arms.copy_from_slice(&other.arms);
        self.slopes.copy_from_slice(&other.slopes);
        self.joints.clone_from_slice(&other.joints);
    }

    /// Workspace for a model.
    pub fn new(model: &Model) -> Self {
        let (nodes, elements) = (model.nodes.len(), model.elements.len());
        let zero = Vector3::zeros();
        Self {
            nodes: vec![Node::ZERO; nodes],
            local_links: vec![LocalLinks::ZERO; elements.div_ceil(LANES)],
            arms: vec![zero; elements],
            local_motions: vec![LocalMotions::ZERO; elements.div_ceil(LANES)],
            joints: model
                .bodies
                .iter()
                .map(|body| {
                    let carried = !matches!(body.base, Base::Root(_));
                    JointWork::new(&body.joint, &body.mount, &body.offset_m, carried)
                })
                .collect(),
            modal: model.bodies.iter().map(|body| body.modal.as_ref().map(|_| Box::new(ModalWork::new()))).collect(),
            root_force: zero,
            root_moment: zero,
            slides: model.slides.iter().map(|slide| SlideWork::new(model.bodies[slide.beam].first_element)).collect(),
            carried: vec![Pair::ZERO; if model.slides.is_empty() { 0 } else { nodes }],
            inertia: vec![ArticulatedInertia::ZERO; nodes],
            bias: vec![Pair::ZERO; nodes],
            slopes: vec![[Slope::ZERO; 2]; if model.sheared { elements } else { 0 }],
            plain: Eliminated::new(elements),
            sheared: vec![ShearedFactor::ZERO; if model.sheared { elements } else { 0 }],
            closure_factor: ClosureFactor::new(3 * model.closures.len() + model.damped_modes.len(), model.coordinates),
            rigid_forces: vec![zero; model.constraints()],
            closing: None,
            rigid_factor: RigidFactor::new(ROWS * model.constraints(), model.tree_coordinates()),
        }
    }
}
