//! Workspace of the recursions, allocated once per model and overwritten by every sweep.

use crate::math::local_jacobian::LocalJacobian;
use crate::math::local_link::{LANES, LocalLinks, LocalMotions};
use crate::math::se3::Link;
use crate::math::strain::{SHEARED, STRAINS, Strain, StrainMatrix};
use crate::multibody::closure::ClosureFactor;
use crate::multibody::joint::JointWork;
use crate::multibody::modal::ModalWork;
use crate::multibody::model::{Base, Model};
use crate::multibody::rigid_loop::RigidFactor;
use crate::multibody::slide::SlideWork;
use crate::multibody::slope::Slope;
use nalgebra::{Matrix3, Vector3};

/// Motion of a node relative to the root frame, and the sum of the wrenches on it so far.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// Attitude, root ← node.
    pub rotation: Matrix3<f64>,
    /// Position in m.
    pub position: Vector3<f64>,
    /// Velocity in m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity in rad/s.
    pub spin: Vector3<f64>,
    /// Acceleration relative to the root frame in m/s².
    pub acceleration: Vector3<f64>,
    /// Angular acceleration relative to the root frame in rad/s².
    pub spin_rate: Vector3<f64>,
    /// `ë + α ė` of the nodal vectors `(r, r_x, r_y, r_z)`, inertial, minus gravity: multiplied by the mass.
    pub load_rate: [Vector3<f64>; 4],
    /// Force at the node: inertia forces minus loads of the outboard part, N.
    pub force: Vector3<f64>,
    /// Moment at the node in N·m.
    pub moment: Vector3<f64>,
    /// Contribution to `force` and `moment` of parts at the node itself: attached masses, loads on it, child bodies.
    pub fixed: Pair,
}

impl Node {
    const ZERO: Self = Self {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        position: Vector3::new(0.0, 0.0, 0.0),
        velocity: Vector3::new(0.0, 0.0, 0.0),
        spin: Vector3::new(0.0, 0.0, 0.0),
        acceleration: Vector3::new(0.0, 0.0, 0.0),
        spin_rate: Vector3::new(0.0, 0.0, 0.0),
        load_rate: [Vector3::new(0.0, 0.0, 0.0); 4],
        force: Vector3::new(0.0, 0.0, 0.0),
        moment: Vector3::new(0.0, 0.0, 0.0),
        fixed: Pair::ZERO,
    };

    /// Velocity and angular velocity relative to a rigid body that moves with `carrier`, root frame.
    #[inline]
    pub(crate) fn relative_to(&self, carrier: &Self) -> (Vector3<f64>, Vector3<f64>) {
        let carried = carrier.velocity + carrier.spin.cross(&(self.position - carrier.position));
        (self.velocity - carried, self.spin - carrier.spin)
    }

    /// Adds a wrench of parts attached to the node.
    #[inline]
    pub(crate) fn add_fixed(&mut self, force: &Vector3<f64>, moment: &Vector3<f64>) {
        self.force += force;
        self.moment += moment;
        self.fixed.linear += force;
        self.fixed.angular += moment;
    }
}

/// Symmetric 6×6 articulated inertia in blocks over (velocity, spin).
#[derive(Debug, Clone, Copy)]
pub struct ArticulatedInertia {
    /// Velocity–velocity block.
    pub vv: Matrix3<f64>,
    /// Velocity–spin block.
    pub vw: Matrix3<f64>,
    /// Spin–spin block.
    pub ww: Matrix3<f64>,
}

impl ArticulatedInertia {
    /// Adds another articulated inertia.
    #[inline]
    pub(crate) fn add(&mut self, other: &Self) {
        self.vv += other.vv;
        self.vw += other.vw;
        self.ww += other.ww;
    }

    /// Sum with another articulated inertia.
    #[inline]
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { vv: self.vv + other.vv, vw: self.vw + other.vw, ww: self.ww + other.ww }
    }

    /// Zero inertia.
    pub const ZERO: Self = Self {
        vv: Matrix3::from_array_storage(ZERO_3),
        vw: Matrix3::from_array_storage(ZERO_3),
        ww: Matrix3::from_array_storage(ZERO_3),
    };
}

const ZERO_3: nalgebra::ArrayStorage<f64, 3, 3> = nalgebra::ArrayStorage([[0.0; 3]; 3]);

/// Factors of one element's elimination.
#[derive(Debug, Clone, Copy)]
pub struct ElementFactor<const N: usize> {
    /// Lower Cholesky factor of `X`, with inverted diagonal.
    pub cholesky: StrainMatrix<N>,
    /// `U`: coupling of the strains to the inner node, velocity rows.
    pub velocity: [Vector3<f64>; N],
    /// `U`, spin rows.
    pub spin: [Vector3<f64>; N],
    /// Coupling to the strains of the inner half, for outer halves.
    pub coupling: StrainMatrix<N>,
}

/// Factors of all elements, and their right-hand sides in a solution; used for the elements with `N` strains.
#[derive(Debug, Clone)]
pub(crate) struct Eliminated<const N: usize> {
    pub factors: Vec<ElementFactor<N>>,
    pub right_hand: Vec<Strain<N>>,
}

impl<const N: usize> Eliminated<N> {
    fn new(elements: usize) -> Self {
        let zero = [Vector3::zeros(); N];
        let factor = ElementFactor {
            cholesky: StrainMatrix::zeros(),
            velocity: zero,
            spin: zero,
            coupling: StrainMatrix::zeros(),
        };
        Self { factors: vec![factor; elements], right_hand: vec![Strain::zeros(); elements] }
    }
}

/// Access to the factors of the elements with `N` strains.
pub(crate) trait Keeps<const N: usize> {
    /// The factors.
    fn eliminated(&self) -> &Eliminated<N>;
    /// The factors, for overwriting.
    fn eliminated_mut(&mut self) -> &mut Eliminated<N>;
}

impl Keeps<STRAINS> for Workspace {
    #[inline(always)]
    fn eliminated(&self) -> &Eliminated<STRAINS> {
        &self.plain
    }

    #[inline(always)]
    fn eliminated_mut(&mut self) -> &mut Eliminated<STRAINS> {
        &mut self.plain
    }
}

impl Keeps<SHEARED> for Workspace {
    #[inline(always)]
    fn eliminated(&self) -> &Eliminated<SHEARED> {
        &self.sheared
    }

    #[inline(always)]
    fn eliminated_mut(&mut self) -> &mut Eliminated<SHEARED> {
        &mut self.sheared
    }
}

/// Small displacement or wrench as a pair of vectors.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Velocity or force.
    pub linear: Vector3<f64>,
    /// Spin or moment.
    pub angular: Vector3<f64>,
}

impl Pair {
    /// Zero vectors.
    pub const ZERO: Self = Self { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };
}

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
    pub(crate) sheared: Eliminated<SHEARED>,
    pub(crate) closure_factor: ClosureFactor,
    pub(crate) rigid_factor: RigidFactor,
    /// Per rigid loop: force on its first point in N, root frame, at the last wrenches.
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

    /// Takes over the outward sweep of another workspace, for elements without shear.
    pub(crate) fn take_sweep(&mut self, other: &Self) {
        self.nodes.copy_from_slice(&other.nodes);
        self.local_links.copy_from_slice(&other.local_links);
        self.arms.copy_from_slice(&other.arms);
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
            sheared: Eliminated::new(if model.sheared { elements } else { 0 }),
            closure_factor: ClosureFactor::new(3 * model.closures.len() + model.damped_modes.len(), model.coordinates),
            rigid_forces: vec![zero; model.rigid_loops.len()],
            rigid_factor: RigidFactor::new(3 * model.rigid_loops.len(), model.tree_coordinates()),
        }
    }
}
