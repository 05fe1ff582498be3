//! Elimination of joints with redundant parameters inside the articulated-body recursion.
//!
//! Only the true freedoms are eliminated: two or three rotations, or the whole twist of a free body. The right side of
//! such a joint holds first the forces on its freedoms, then the residuals of its constraints; the solution holds the
//! change of its parameters. NOTATION eq. (J5).

use crate::multibody::factor::{BadPivot, HingeTangent, Weights};
use crate::multibody::joint::{ParameterJoint, ParameterKind};
use crate::multibody::workspace::{ArticulatedInertia, Pair, ParameterWork};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Factors of one joint and what its inward sweep leaves for the outward one.
#[derive(Debug, Clone)]
pub(crate) struct ParameterFactor {
    /// Nothing is eliminated: the joint is locked.
    held: bool,
    /// Inverse of the rotations' block; the third row and column are empty for two freedoms.
    inverse: Matrix3<f64>,
    /// Free joints: inverse of the whole inertia.
    whole: Matrix6<f64>,
    /// `P S`, velocity rows.
    velocity: Matrix3<f64>,
    /// `P S`, spin rows.
    spin: Matrix3<f64>,
    /// `P (0; constraint axis)`.
    constraint: Pair,
    /// Right side of the freedoms.
    right_hand: Vector6<f64>,
    /// Turn about the constraint axis.
    constraint_turn: f64,
}

impl ParameterFactor {
    /// Nothing factorised yet.
    pub(crate) fn new() -> Self {
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

impl ParameterWork {
    /// Eliminates the freedoms from the inertia of the body's first node; returns what the parent feels.
    pub(crate) fn factorize(
        &mut self,
        joint: &ParameterJoint,
        inertia: &ArticulatedInertia,
        weights: Weights,
        tangent: &HingeTangent,
    ) -> Result<ArticulatedInertia, BadPivot> {
        let bad = BadPivot { coordinate: joint.coordinate };
        self.factor.held = !tangent.free;
        if self.factor.held {
            return Ok(*inertia);
        }
        if joint.kind == ParameterKind::Free {
            let mut whole = Matrix6::zeros();
            whole.fixed_view_mut::<3, 3>(0, 0).copy_from(&inertia.vv);
            whole.fixed_view_mut::<3, 3>(0, 3).copy_from(&inertia.vw);
            whole.fixed_view_mut::<3, 3>(3, 0).copy_from(&inertia.vw.transpose());
            whole.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia.ww);
            self.factor.whole = nalgebra::Cholesky::new(whole).ok_or(bad)?.inverse();
            return Ok(ArticulatedInertia::ZERO);
        }
        let (velocity, spin) = (inertia.vw * self.axes, inertia.ww * self.axes);
        let diagonal = weights.stiffness * tangent.stiffness_n_m_rad + weights.damping * tangent.damping_n_m_s_rad;
        let mut block = self.axes.transpose() * spin + Matrix3::from_diagonal_element(diagonal);
        if joint.kind.freedoms() == 2 {
            block[(2, 2)] = 1.0; // no third freedom: keep the factor regular
        }
        let mut inverse = nalgebra::Cholesky::new(block).ok_or(bad)?.inverse();
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

    /// Inward half of the solution: takes the joint's share out of the right side `p` of its node.
    pub(crate) fn reduce(&mut self, joint: &ParameterJoint, x: &[f64], p: &mut Pair) {
        let (c, freedoms) = (joint.coordinate, joint.kind.freedoms());
        if self.factor.held {
            return;
        }
        if joint.kind == ParameterKind::Free {
            for i in 0..3 {
                self.factor.right_hand[i] = x[c + i] + p.linear[i];
                self.factor.right_hand[i + 3] = x[c + 3 + i] + p.angular[i];
            }
            *p = Pair::ZERO;
            return;
        }
        let constraint = &x[c + freedoms..c + joint.kind.parameters()];
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

    /// Outward half: the change of the parameters into `x`; `moved` goes from the parent's twist to the node's.
    ///
    /// Returns the largest square of a parameter's change.
    pub(crate) fn expand(&self, joint: &ParameterJoint, x: &mut [f64], moved: &mut Pair) -> f64 {
        let (c, freedoms) = (joint.coordinate, joint.kind.freedoms());
        let parameters = joint.kind.parameters();
        if self.factor.held {
            x[c..c + parameters].fill(0.0);
            return 0.0;
        }
        let turn = if joint.kind == ParameterKind::Free {
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
        if joint.kind == ParameterKind::Free {
            x[c..c + 3].copy_from_slice(moved.linear.as_slice());
        }
        // offsets of free joints count through the node's displacement
        change.iter().fold(0.0, |largest, change| largest.max(change * change))
    }

    /// Forces on the freedoms from the wrench `p` of the joint's node.
    pub(crate) fn project(&self, joint: &ParameterJoint, p: &Pair, out: &mut [f64]) {
        let c = joint.coordinate;
        if joint.kind == ParameterKind::Free {
            out[c..c + 3].copy_from_slice(p.linear.as_slice());
            out[c + 3..c + 6].copy_from_slice(p.angular.as_slice());
            return;
        }
        let torques = self.axes.transpose() * p.angular;
        let freedoms = joint.kind.freedoms();
        out[c..c + freedoms].copy_from_slice(&torques.as_slice()[..freedoms]);
    }

    /// Twist of the node that a change of the parameters causes, added to that of the parent.
    pub(crate) fn displace(&self, joint: &ParameterJoint, change: &[f64], moved: &mut Pair) {
        let c = joint.coordinate;
        let mut turn = Vector3::zeros();
        for i in 0..joint.kind.parameters() {
            turn += self.pose.spin_map.column(i) * change[c + i];
        }
        moved.angular += self.parent * turn;
        if joint.kind == ParameterKind::Free {
            moved.linear += Vector3::new(change[c], change[c + 1], change[c + 2]);
        }
    }
}
