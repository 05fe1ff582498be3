//! Elimination of joints with redundant parameters inside the articulated-body recursion.
//!
//! Only the true degrees of freedom are eliminated: two or three rotations, or the whole twist of a free body. The right-hand side of such
//! a joint holds first the forces on its degrees of freedom, then the residuals of its constraints; the solution holds the change of its
//! parameters. NOTATION eq. (J5).

use crate::multibody::elimination::{BadPivot, FreedomTangent, ROUND_OFF, Weights};
use crate::multibody::joint::Joint;
use crate::multibody::joint::parameters::JointPose;
use crate::multibody::motion::Motion;
use crate::multibody::node::{ArticulatedInertia, Node, Pair};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Factors of one joint, passed from its inward sweep to the outward one.
#[derive(Debug, Clone)]
struct RedundantFactor {
    /// Whether the joint is locked, so that nothing is eliminated.
    held: bool,
    /// Inverse of the rotations' block; the third row and column are empty for two degrees of freedom.
    inverse: Matrix3<f64>,
    /// Inverse of the whole inertia, for free joints.
    whole: Matrix6<f64>,
    /// Product `P S` of the articulated inertia and the motion subspace, velocity rows.
    velocity: Matrix3<f64>,
    /// Product `P S`, spin rows.
    spin: Matrix3<f64>,
    /// Product `P (0; constraint axis)`.
    constraint: Pair,
    /// Right-hand side of the degrees of freedom.
    right_hand: Vector6<f64>,
    /// Rotation about the constraint axis.
    constraint_turn: f64,
}

impl RedundantFactor {
    /// Factors before the first factorisation.
    fn new() -> Self {
        Self {
            held: false,
            inverse: Matrix3::zeros(),
            whole: Matrix6::zeros(),
            velocity: Matrix3::zeros(),
            spin: Matrix3::zeros(),
            constraint: Pair::ZERO,
            right_hand: Vector6::zeros(),
            constraint_turn: 0.0,
        }
    }
}

/// A joint with redundant parameters at the poses of the last sweep.
#[derive(Debug, Clone)]
pub struct RedundantWork {
    /// Attitude and maps, parent's frame.
    pub pose: JointPose,
    /// Attitude of the parent, root ← parent.
    pub parent: Matrix3<f64>,
    /// Rotation axes of the degrees of freedom in the root frame, as columns.
    pub axes: Matrix3<f64>,
    /// [`JointPose::constraint_axis`] in the root frame.
    pub constraint_axis: Vector3<f64>,
    factor: RedundantFactor,
}

impl RedundantWork {
    /// Workspace of a joint whose body is mounted by `mount`, parent ← body.
    pub(super) fn new(joint: &Joint, mount: &Matrix3<f64>) -> Self {
        Self {
            pose: JointPose::new(&joint.kind, &joint.kind.parameters_of(mount)[..joint.kind.coordinates()]),
            parent: Matrix3::identity(),
            axes: Matrix3::zeros(),
            constraint_axis: Vector3::zeros(),
            factor: RedundantFactor::new(),
        }
    }

    /// Moves a body's first node from the pose of its parent, eqs. (J2) and (J3).
    pub(super) fn carry<const RATES: bool>(
        &mut self,
        joint: &Joint,
        parent: Option<&Node>,
        node: &mut Node,
        motion: Motion,
    ) {
        let parent = parent.map_or_else(Matrix3::identity, |parent| parent.rotation);
        let range = joint.range();
        let pose = JointPose::new(&joint.kind, &motion.q[range.clone()]);
        node.rotation = parent * pose.rotation;
        // a free joint is attached to the root frame: its offset needs no rotation
        node.position += pose.offset_m;
        if RATES {
            let (rates, second) = (&motion.v[range.clone()], &motion.a[range]);
            let (spin, spin_rate) = pose.spin(&joint.kind, rates, second);
            let spin = parent * spin;
            node.spin_rate += parent * spin_rate + node.spin.cross(&spin);
            node.spin += spin;
            if joint.kind.floats() {
                node.velocity += Vector3::new(rates[0], rates[1], rates[2]);
                node.acceleration += Vector3::new(second[0], second[1], second[2]);
            }
        }
        self.axes = parent * pose.axes;
        self.constraint_axis = parent * pose.constraint_axis;
        self.parent = parent;
        self.pose = pose;
    }

    /// Writes zero forces on the degrees of freedom, followed by the residuals of the constraints, eq. (J4).
    pub(super) fn own_forces(&self, joint: &Joint, motion: Motion, residual: &mut [f64]) {
        let (range, freedoms) = (joint.range(), joint.kind.freedoms());
        let first = range.start + freedoms;
        residual[range.start..first].fill(0.0);
        let (rates, second) = (&motion.v[range.clone()], &motion.a[range.clone()]);
        self.pose.constraint_residual(&joint.kind, rates, second, &mut residual[first..range.end]);
    }

    /// Eliminates the degrees of freedom from the inertia of the body's first node; returns the inertia at the parent.
    pub(super) fn eliminate(
        &mut self,
        joint: &Joint,
        inertia: &ArticulatedInertia,
        weights: Weights,
        tangent: &FreedomTangent,
    ) -> Result<ArticulatedInertia, BadPivot> {
        let bad = BadPivot { coordinate: joint.coordinate };
        self.factor.held = !tangent.free;
        if self.factor.held {
            return Ok(*inertia);
        }
        if joint.kind.floats() {
            let mut whole = Matrix6::zeros();
            whole.fixed_view_mut::<3, 3>(0, 0).copy_from(&inertia.vv);
            whole.fixed_view_mut::<3, 3>(0, 3).copy_from(&inertia.vw);
            whole.fixed_view_mut::<3, 3>(3, 0).copy_from(&inertia.vw.transpose());
            whole.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia.ww);
            let factor = nalgebra::Cholesky::new(whole).ok_or(bad)?;
            for range in [0..3, 3..6] {
                if !is_regular(range.map(|i| (factor.l_dirty()[(i, i)], whole[(i, i)]))) {
                    return Err(bad);
                }
            }
            self.factor.whole = factor.inverse();
            return Ok(ArticulatedInertia::ZERO);
        }
        let (velocity, spin) = (inertia.vw * self.axes, inertia.ww * self.axes);
        let diagonal = weights.stiffness * tangent.stiffness + weights.damping * tangent.damping;
        let mut block = self.axes.transpose() * spin + Matrix3::from_diagonal_element(diagonal);
        if joint.kind.freedoms() == 2 {
            block[(2, 2)] = 1.0; // no third degree of freedom: keep the factor regular
        }
        let factor = nalgebra::Cholesky::new(block).ok_or(bad)?;
        if !is_regular((0..joint.kind.freedoms()).map(|i| (factor.l_dirty()[(i, i)], block[(i, i)]))) {
            return Err(bad);
        }
        let mut inverse = factor.inverse();
        if joint.kind.freedoms() == 2 {
            inverse[(2, 2)] = 0.0;
        }
        self.factor.constraint =
            Pair { linear: inertia.vw * self.constraint_axis, angular: inertia.ww * self.constraint_axis };
        (self.factor.inverse, self.factor.velocity, self.factor.spin) = (inverse, velocity, spin);
        Ok(ArticulatedInertia {
            vv: inertia.vv - velocity * inverse * velocity.transpose(),
            vw: inertia.vw - velocity * inverse * spin.transpose(),
            ww: inertia.ww - spin * inverse * spin.transpose(),
        })
    }

    /// Inward half of the solution: subtracts the contribution of the joint from the right-hand side `p` of its node.
    pub(super) fn reduce(&mut self, joint: &Joint, x: &[f64], p: &mut Pair) {
        let (c, freedoms) = (joint.coordinate, joint.kind.freedoms());
        if self.factor.held {
            return;
        }
        if joint.kind.floats() {
            for i in 0..3 {
                self.factor.right_hand[i] = x[c + i] + p.linear[i];
                self.factor.right_hand[i + 3] = x[c + 3 + i] + p.angular[i];
            }
            *p = Pair::ZERO;
            return;
        }
        let constraint = &x[c + freedoms..c + joint.kind.coordinates()];
        let turn = self.pose.constraint_turn(&joint.kind, constraint);
        p.linear -= self.factor.constraint.linear * turn;
        p.angular -= self.factor.constraint.angular * turn;
        let mut g = self.axes.transpose() * p.angular;
        for i in 0..freedoms {
            g[i] += x[c + i];
        }
        let y = self.factor.inverse * g;
        p.linear -= self.factor.velocity * y;
        p.angular -= self.factor.spin * y;
        self.factor.right_hand.fixed_rows_mut::<3>(0).copy_from(&g);
        self.factor.constraint_turn = turn;
    }

    /// Outward half: writes the change of the parameters to `x`; `moved` is transformed from the parent's twist to the node's.
    ///
    /// Returns the largest square of a parameter's change that is not contained in the node's own displacement.
    pub(super) fn expand(&self, joint: &Joint, x: &mut [f64], moved: &mut Pair) -> f64 {
        let (c, freedoms) = (joint.coordinate, joint.kind.freedoms());
        let parameters = joint.kind.coordinates();
        if self.factor.held {
            x[c..c + parameters].fill(0.0);
            return 0.0;
        }
        let turn = if joint.kind.floats() {
            let twist = self.factor.whole * self.factor.right_hand;
            moved.linear = twist.fixed_rows::<3>(0).into_owned();
            moved.angular = twist.fixed_rows::<3>(3).into_owned();
            moved.angular
        } else {
            let pull = self.factor.right_hand.fixed_rows::<3>(0)
                - self.factor.velocity.transpose() * moved.linear
                - self.factor.spin.transpose() * moved.angular;
            let turn = self.axes * (self.factor.inverse * pull) + self.constraint_axis * self.factor.constraint_turn;
            moved.angular += turn;
            turn
        };
        let change = self.pose.parameter_change(
            &joint.kind,
            &(self.parent.transpose() * turn),
            &x[c + freedoms..c + parameters],
        );
        x[c..c + parameters].copy_from_slice(&change[..parameters]);
        if joint.kind.floats() {
            x[c..c + 3].copy_from_slice(moved.linear.as_slice());
        }
        if joint.kind.floats() {
            return 0.0; // the displacement of the body is contained in that of the node
        }
        change.iter().fold(0.0, |largest, change| largest.max(change * change))
    }

    /// Forces on the degrees of freedom from the wrench `p` of the joint's node.
    pub(super) fn project(&self, joint: &Joint, p: &Pair, out: &mut [f64]) {
        let c = joint.coordinate;
        if joint.kind.floats() {
            out[c..c + 3].copy_from_slice(p.linear.as_slice());
            out[c + 3..c + 6].copy_from_slice(p.angular.as_slice());
            return;
        }
        let torques = self.axes.transpose() * p.angular;
        let freedoms = joint.kind.freedoms();
        out[c..c + freedoms].copy_from_slice(&torques.as_slice()[..freedoms]);
    }

    /// Adds the node's twist due to a change of the parameters to that of the parent.
    pub(super) fn displace(&self, joint: &Joint, change: &[f64], moved: &mut Pair) {
        let c = joint.coordinate;
        let mut turn = Vector3::zeros();
        for i in 0..joint.kind.coordinates() {
            turn += self.pose.spin_map.column(i) * change[c + i];
        }
        moved.angular += self.parent * turn;
        if joint.kind.floats() {
            moved.linear += Vector3::new(change[c], change[c + 1], change[c + 2]);
        }
    }

    /// Converts the changes of the degrees of freedom in `x` to changes of the parameters, in place.
    pub(super) fn to_parameters(&self, joint: &Joint, x: &mut [f64]) {
        let x = &mut x[joint.range()];
        let shift = joint.kind.translations();
        let mut turn = Vector3::zeros();
        for k in 0..joint.kind.freedoms() - shift {
            turn += if shift == 3 { Vector3::ith(k, x[shift + k]) } else { self.axes.column(k) * x[k] };
        }
        let change = self.pose.parameter_change(&joint.kind, &(self.parent.transpose() * turn), &[0.0; 7]);
        let kept = [x[0], x[1], x[2]];
        let count = x.len();
        x.copy_from_slice(&change[..count]);
        if shift == 3 {
            x[..3].copy_from_slice(&kept);
        }
    }
}

/// Whether the pivots of a Cholesky factor are larger than the round-off of the largest diagonal entry. `entries` have the same unit: pairs
/// of the factor's and the matrix's diagonal entries.
fn is_regular(entries: impl Iterator<Item = (f64, f64)>) -> bool {
    let (least, largest) = entries
        .fold((f64::INFINITY, 0.0f64), |(least, largest), (root, whole)| (least.min(root * root), largest.max(whole)));
    least > ROUND_OFF * largest
}
