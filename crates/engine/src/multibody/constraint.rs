//! Coordinates behind those of the bodies: charges of circuits, then multipliers of constraints, rigid loops and no-slip constraints with
//! three rows each.

use crate::multibody::circuit::Circuit;
use crate::multibody::closure::{Closure, Gap, load_unit_force};
use crate::multibody::joint::JointKind;
use crate::multibody::model::Model;
use crate::multibody::no_slip::{NoSlip, ROWS};
use crate::multibody::workspace::{Pair, Workspace};
use nalgebra::Vector3;

/// A constraint of a model.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Constraint<'a> {
    /// Points that coincide.
    Loop(&'a Closure),
    /// A skate or a wheel.
    NoSlip(&'a NoSlip),
}

impl Model {
    /// Whether closed loops or damped modes add a matrix of low rank to that of the tree.
    pub fn is_bordered(&self) -> bool {
        !(self.closures.is_empty() && self.damped_modes.is_empty())
    }

    /// Number of constraints.
    pub(crate) fn constraints(&self) -> usize {
        self.rigid_loops.len() + self.no_slips.len()
    }

    /// A constraint: the rigid loops, then skates and wheels.
    pub(crate) fn constraint(&self, index: usize) -> Constraint<'_> {
        match index.checked_sub(self.rigid_loops.len()) {
            None => Constraint::Loop(&self.rigid_loops[index]),
            Some(own) => Constraint::NoSlip(&self.no_slips[own]),
        }
    }

    /// Coordinates of the tree, with the charges of circuits; those of the multipliers of the constraints follow.
    pub fn tree_coordinates(&self) -> usize {
        self.coordinates - ROWS * self.constraints()
    }

    /// Appends a circuit to a model on the joint of a body, with its coordinate.
    pub fn add_circuit(&mut self, body: usize, [inductance_h, resistance_ohm, constant_n_m_a]: [f64; 3]) {
        let joint = &self.bodies[body].joint;
        let scale_m = match joint.kind {
            JointKind::Prismatic { .. } | JointKind::Sliding => self.reference_length_m,
            JointKind::Clamped
            | JointKind::Revolute { .. }
            | JointKind::Universal { .. }
            | JointKind::Ball
            | JointKind::Free => 1.0,
        };
        let (joint, coordinate) = (joint.coordinate, self.tree_coordinates());
        self.circuits.push(Circuit { body, joint, coordinate, inductance_h, resistance_ohm, constant_n_m_a, scale_m });
        self.coordinates += 1;
    }

    /// Whether all rates are zero except the currents of circuits.
    pub(crate) fn is_still(&self, v: &[f64]) -> bool {
        let current = |c: usize| self.circuits.iter().any(|circuit| circuit.coordinate == c);
        v.iter().enumerate().all(|(c, rate)| *rate == 0.0 || current(c))
    }

    /// Indices of the multipliers of a constraint in vectors of accelerations, rigid loops first. Of a rigid loop they are the components of
    /// the force on its first point in N, root frame; of a skate or a wheel the forces on the body across and along its heading and along
    /// the normal.
    pub fn multipliers(&self, constraint: usize) -> std::ops::Range<usize> {
        let first = self.tree_coordinates() + ROWS * constraint;
        first..first + ROWS
    }
}

impl Constraint<'_> {
    /// Gap of the rows with its rates at the motion of the last sweep; rows without a position have the position zero.
    pub(crate) fn gap(&self, work: &Workspace) -> Gap {
        match self {
            Self::Loop(closure) => closure.gap(work),
            Self::NoSlip(no_slip) => no_slip.gap(work),
        }
    }

    /// Whether a row is constrained.
    pub(crate) fn is_active(&self, row: usize) -> bool {
        match self {
            Self::Loop(_) => true,
            Self::NoSlip(no_slip) => no_slip.active()[row],
        }
    }

    /// Changes of the rows due to the node displacements in `work.bias`, and the largest change of a point.
    pub(crate) fn changes(&self, work: &Workspace) -> (Vector3<f64>, f64) {
        match self {
            Self::Loop(closure) => {
                let [first, second] = closure.point_changes(work);
                (second - first, first.amax().max(second.amax()))
            }
            Self::NoSlip(no_slip) => {
                let change = no_slip.gap_change(work);
                (change, change.amax())
            }
        }
    }

    /// Adds a unit multiplier of a row to the wrenches in `work.bias`.
    pub(crate) fn load_unit(&self, work: &mut Workspace, row: usize) {
        match self {
            Self::Loop(closure) => load_unit_force(work, closure, row),
            Self::NoSlip(no_slip) => no_slip.load_unit(work, row),
        }
    }

    /// Adds the constraint forces to the wrenches of the nodes; returns their wrench about the origin on the root, with the sign of the
    /// nodes' wrenches, if the constraint ends there.
    pub(crate) fn apply(&self, work: &mut Workspace, multipliers: Vector3<f64>) -> Option<Pair> {
        match self {
            Self::Loop(closure) => closure.apply_force(work, multipliers),
            Self::NoSlip(no_slip) => Some(no_slip.apply(work, &multipliers)),
        }
    }

    /// Largest speed of its points at the motion of the last sweep, in m/s.
    pub(crate) fn speed_m_s(&self, work: &Workspace) -> f64 {
        let at = |node: usize, arm_m: f64| work.nodes[node].velocity.norm() + work.nodes[node].spin.norm() * arm_m;
        match self {
            Self::Loop(closure) => {
                let points = closure.nodes.iter().zip(&closure.offsets_m);
                points.map(|(node, offset)| node.map_or(0.0, |node| at(node, offset.norm()))).fold(0.0, f64::max)
            }
            Self::NoSlip(no_slip) => at(no_slip.node, no_slip.arm_m(work)),
        }
    }
}

/// Applies all closures, and the constraints with their multipliers in the accelerations `a`; returns the sum of their wrenches on the root, see
/// [`Closure::apply`].
pub(crate) fn apply_all(model: &Model, work: &mut Workspace, a: &[f64]) -> Option<Pair> {
    let mut on_root: Option<Pair> = None;
    let mut book = |own: Option<Pair>| {
        if let Some(own) = own {
            let sum = on_root.get_or_insert(Pair::ZERO);
            sum.linear += own.linear;
            sum.angular += own.angular;
        }
    };
    for closure in &model.closures {
        book(closure.apply(work));
    }
    for index in 0..model.constraints() {
        let multipliers = Vector3::from_column_slice(&a[model.multipliers(index)]);
        work.rigid_forces[index] = multipliers;
        book(model.constraint(index).apply(work, multipliers));
    }
    on_root
}
