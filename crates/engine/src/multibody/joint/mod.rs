//! Joints: motion of the first frame of a body relative to the node to which it is attached, its carrier.
//!
//! Every type of joint implements the same operations, here by enum: the pose of its body (`Joint::carry`), the projection of a wrench
//! (`Joint::project`), its elimination in the inward articulated-body recursion (`Joint::eliminate`, `Joint::reduce`) and its solution in
//! the outward one (`Joint::expand`). The sweeps over the tree are independent of the joint types. Each of two families has common algebra:
//! joints with one degree of freedom along a screw (`one_freedom`) and joints with redundant parameters (`redundant`).
//!
//! Between the carrier node and the body's first node there is an arm: the offset of the attachment, and the displacement of a prismatic
//! joint. It is treated here for all sweeps, NOTATION eqs. (J7)–(J9).

mod kind;
mod one_freedom;
pub mod parameters;
mod prismatic;
mod redundant;
mod revolute;

pub use kind::{Joint, JointKind};
pub use one_freedom::OneFreedom;
pub use redundant::RedundantWork;

use crate::math::so3::hat;
use crate::multibody::elimination::{BadPivot, FreedomTangent, Weights};
use crate::multibody::motion::Motion;
use crate::multibody::node::NormSquared;
use crate::multibody::node::{ArticulatedInertia, Node, Pair};
use nalgebra::{Matrix3, Matrix6, Vector3};

/// Workspace of one joint: its pose and its factors.
#[derive(Debug, Clone)]
pub struct JointWork {
    /// Vector from the carrier node to the body's first node, root frame, m; eq. (J7).
    pub arm: Vector3<f64>,
    /// Whether there is a carrier node and the arm may be nonzero.
    levered: bool,
    /// Workspace of the joint type.
    pub(crate) freedoms: Freedoms,
}

/// Workspace of a joint type between the sweeps.
#[derive(Debug, Clone)]
pub(crate) enum Freedoms {
    /// For clamped joints.
    None,
    /// For joints with one degree of freedom.
    One(OneFreedom),
    /// For joints with redundant parameters.
    Redundant(Box<RedundantWork>),
}

impl JointWork {
    /// Workspace of a joint whose body is mounted by `mount` (parent ← body), with `offset_m` from a node if `carried`.
    pub(crate) fn new(joint: &Joint, mount: &Matrix3<f64>, offset_m: &Vector3<f64>, carried: bool) -> Self {
        let moves = matches!(joint.kind, JointKind::Prismatic { .. });
        Self {
            arm: Vector3::zeros(),
            levered: carried && (moves || *offset_m != Vector3::zeros()),
            freedoms: match joint.kind {
                JointKind::Clamped => Freedoms::None,
                JointKind::Revolute { .. } | JointKind::Prismatic { .. } | JointKind::Sliding => {
                    Freedoms::One(OneFreedom::new(&joint.kind))
                }
                JointKind::Universal { .. } | JointKind::Ball | JointKind::Free => {
                    Freedoms::Redundant(Box::new(RedundantWork::new(joint, mount)))
                }
            },
        }
    }

    /// Pose and maps of a joint with redundant parameters.
    pub fn redundant(&self) -> Option<&RedundantWork> {
        match &self.freedoms {
            Freedoms::Redundant(work) => Some(work),
            Freedoms::None | Freedoms::One(_) => None,
        }
    }

    /// Workspace of a joint with one degree of freedom.
    pub(crate) fn one_freedom(&self) -> Option<&OneFreedom> {
        match &self.freedoms {
            Freedoms::One(one) => Some(one),
            Freedoms::None | Freedoms::Redundant(_) => None,
        }
    }

    /// Mutable workspace of a joint with one degree of freedom.
    pub(crate) fn one_freedom_mut(&mut self) -> Option<&mut OneFreedom> {
        match &mut self.freedoms {
            Freedoms::One(one) => Some(one),
            Freedoms::None | Freedoms::Redundant(_) => None,
        }
    }

    /// Sets the twist of the body's first node per rate of a sliding joint's coordinate: that of its carriage, moved along the arm.
    pub(crate) fn ride(&mut self, column: &Pair, arm: &Vector3<f64>) {
        if let Freedoms::One(one) = &mut self.freedoms {
            one.ride(Pair { linear: column.linear + column.angular.cross(arm), angular: column.angular });
        }
    }

    /// Twist of the body's first node due to a twist of the carrier node, with a fixed joint, eq. (J8).
    #[inline]
    pub(crate) fn carried(&self, parent: &Pair) -> Pair {
        let mut moved = *parent;
        if self.levered {
            moved.linear += moved.angular.cross(&self.arm);
        }
        moved
    }

    /// Adds the contribution of the arm to a moment that is transmitted from the body's first node to the carrier node, eq. (J8).
    #[inline]
    pub(crate) fn pass_on(&self, force: &Vector3<f64>, moment: &mut Vector3<f64>) {
        if self.levered {
            *moment += self.arm.cross(force);
        }
    }

    /// Transforms an articulated inertia from the body's first node to the carrier node, eq. (J9).
    #[inline]
    fn shifted(&self, inertia: ArticulatedInertia) -> ArticulatedInertia {
        if !self.levered {
            return inertia;
        }
        let arm = hat(&self.arm);
        let vw = inertia.vw - inertia.vv * arm;
        ArticulatedInertia { vv: inertia.vv, vw, ww: inertia.ww - inertia.vw.transpose() * arm + arm * vw }
    }
}

impl Joint {
    /// Writes the initial coordinates into `q`: zero, or the parameters of the mounted attitude.
    pub fn rest(&self, mount: &Matrix3<f64>, q: &mut [f64]) {
        let count = self.kind.coordinates();
        if self.kind.is_redundant() {
            q[self.range()].copy_from_slice(&self.kind.parameters_of(mount)[..count]);
        } else {
            q[self.range()].fill(0.0);
        }
    }

    /// Moves a body's first node to its pose on the joint, eqs. (K9), (J2), (J3) and (J7); with `RATES` also its rates and accelerations.
    /// `offset_m` is that of the attachment: from the root's origin, or in the frame of `parent`.
    #[inline]
    pub(crate) fn carry<const RATES: bool>(
        &self,
        (offset_m, mount): (&Vector3<f64>, &Matrix3<f64>),
        work: &mut JointWork,
        parent: Option<&Node>,
        node: &mut Node,
        motion: Motion,
    ) {
        match parent {
            Some(parent) => {
                node.position = parent.position;
                if RATES {
                    node.velocity = parent.velocity;
                    node.spin = parent.spin;
                    node.acceleration = parent.acceleration;
                    node.spin_rate = parent.spin_rate;
                }
            }
            None => {
                node.position = *offset_m;
                node.velocity = Vector3::zeros();
                node.spin = Vector3::zeros();
                node.acceleration = Vector3::zeros();
                node.spin_rate = Vector3::zeros();
            }
        }
        if work.levered {
            work.arm = parent.map_or_else(Vector3::zeros, |parent| parent.rotation * offset_m);
            move_along::<RATES>(&work.arm, node);
        }
        match (&self.kind, &mut work.freedoms) {
            (JointKind::Revolute { axis }, Freedoms::One(one)) => {
                revolute::carry::<RATES>((axis, self.coordinate), mount, one, parent, node, motion);
            }
            (JointKind::Prismatic { axis }, Freedoms::One(one)) => {
                work.arm += prismatic::carry::<RATES>((axis, self.coordinate), mount, one, parent, node, motion);
            }
            (JointKind::Universal { .. } | JointKind::Ball | JointKind::Free, Freedoms::Redundant(redundant)) => {
                redundant.carry::<RATES>(self, parent, node, motion)
            }
            (JointKind::Clamped, Freedoms::None) | (JointKind::Sliding, Freedoms::One(_)) => {
                node.rotation = parent.map_or(*mount, |parent| parent.rotation * mount);
            }
            (_, Freedoms::None | Freedoms::One(_) | Freedoms::Redundant(_)) => {
                unreachable!("the scratch of a joint is that of its type")
            }
        }
    }

    /// Adds the forces on the degrees of freedom that are not from the tree: the inertia of the motor, and the residuals of constraints.
    #[inline]
    pub(crate) fn own_forces(&self, work: &JointWork, motion: Motion, residual: &mut [f64]) {
        match &work.freedoms {
            Freedoms::None => {}
            Freedoms::One(_) => residual[self.coordinate] = self.drive_inertia * motion.a[self.coordinate],
            Freedoms::Redundant(redundant) => redundant.own_forces(self, motion, residual),
        }
    }

    /// Adds the projection of the wrench at the body's first node on the degrees of freedom to the residual, eq. (D9).
    #[inline]
    pub(crate) fn project(&self, work: &JointWork, wrench: &Pair, residual: &mut [f64]) {
        match &work.freedoms {
            Freedoms::None => {}
            Freedoms::One(one) => residual[self.coordinate] += one.project(wrench),
            Freedoms::Redundant(redundant) => redundant.project(self, wrench, residual),
        }
    }

    /// Eliminates the degrees of freedom from the inertia of the body's first node; returns the inertia at the carrier node.
    #[inline]
    pub(crate) fn eliminate(
        &self,
        work: &mut JointWork,
        inertia: &ArticulatedInertia,
        weights: Weights,
        tangent: &FreedomTangent,
    ) -> Result<ArticulatedInertia, BadPivot> {
        let passed = match &mut work.freedoms {
            Freedoms::None => *inertia,
            Freedoms::One(one) => one.eliminate(self, inertia, weights, tangent)?,
            Freedoms::Redundant(redundant) => redundant.eliminate(self, inertia, weights, tangent)?,
        };
        Ok(work.shifted(passed))
    }

    /// Inward half of the solution: transforms the right-hand side `p` of the body's first node to that of the carrier node.
    #[inline]
    pub(crate) fn reduce(&self, work: &mut JointWork, x: &[f64], p: &mut Pair) {
        match &mut work.freedoms {
            Freedoms::None => {}
            Freedoms::One(one) => one.reduce(x[self.coordinate], p),
            Freedoms::Redundant(redundant) => redundant.reduce(self, x, p),
        }
        let force = p.linear;
        work.pass_on(&force, &mut p.angular);
    }

    /// Outward half: writes the change of the coordinates to `x`; `moved` is transformed from the twist of the carrier node to that of the
    /// body's first node, which is added to `norm`.
    #[inline]
    pub(crate) fn expand(&self, work: &JointWork, x: &mut [f64], moved: &mut Pair, norm: &mut NormSquared) {
        *moved = work.carried(moved);
        match &work.freedoms {
            Freedoms::None if !work.levered => return,
            Freedoms::None => {}
            Freedoms::One(one) => x[self.coordinate] = one.expand(moved),
            Freedoms::Redundant(redundant) => {
                let largest = redundant.expand(self, x, moved);
                norm.angular = norm.angular.max(largest);
            }
        }
        norm.include(moved);
    }

    /// Transforms `moved` from the twist of the carrier node to that of the body's first node, for a change of the coordinates.
    #[inline]
    pub(crate) fn displace(&self, work: &JointWork, change: &[f64], moved: &mut Pair) {
        *moved = work.carried(moved);
        match &work.freedoms {
            Freedoms::None => {}
            Freedoms::One(one) => one.displace(change[self.coordinate], moved),
            Freedoms::Redundant(redundant) => redundant.displace(self, change, moved),
        }
    }

    /// Projects redundant coordinates with their first and second time derivatives onto the constraints, eq. (J6).
    pub fn restore(&self, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        if self.kind.is_redundant() {
            let range = self.range();
            parameters::project(&self.kind, &mut q[range.clone()], &mut v[range.clone()], &mut a[range]);
        }
    }

    /// Twist of the body per degree of freedom, root frame, as columns (velocity above spin); columns beyond the degrees of freedom are
    /// zero.
    pub(crate) fn freedom_twists(&self, work: &JointWork) -> Matrix6<f64> {
        let mut twists = Matrix6::zeros();
        match &work.freedoms {
            Freedoms::None => {}
            Freedoms::One(one) => {
                let screw = one.screw();
                twists.fixed_view_mut::<3, 1>(0, 0).copy_from(&screw.linear);
                twists.fixed_view_mut::<3, 1>(3, 0).copy_from(&screw.angular);
            }
            Freedoms::Redundant(_) if self.kind.floats() => twists.fill_with_identity(),
            Freedoms::Redundant(redundant) => twists.fixed_view_mut::<3, 3>(3, 0).copy_from(&redundant.axes),
        }
        twists
    }

    /// Change of the projections of a moment with the degrees of freedom, if one axis of the joint rotates another: entry `(i, j)` is the
    /// change of projection `i` with degree of freedom `j`.
    pub(crate) fn turning_axes(&self, work: &JointWork, moment: &Vector3<f64>) -> Matrix6<f64> {
        let mut change = Matrix6::zeros();
        if let (JointKind::Universal { .. }, Some(redundant)) = (&self.kind, work.redundant()) {
            // the second axis rotates with the first rotation
            let axis = |k: usize| -> Vector3<f64> { redundant.axes.column(k).into_owned() };
            change[(1, 0)] = moment.dot(&axis(0).cross(&axis(1)));
        }
        change
    }

    /// Converts changes of the degrees of freedom, which come first in `x`, to changes of the coordinates, in place.
    pub(crate) fn expand_freedoms(&self, work: &JointWork, x: &mut [f64]) {
        if let Some(redundant) = work.redundant() {
            redundant.to_parameters(self, x);
        }
    }
}

/// Moves a node by an arm that is fixed in its frame, eq. (J7).
#[inline]
fn move_along<const RATES: bool>(arm: &Vector3<f64>, node: &mut Node) {
    node.position += arm;
    if RATES {
        let swing = node.spin.cross(arm);
        node.velocity += swing;
        node.acceleration += node.spin_rate.cross(arm) + node.spin.cross(&swing);
    }
}
