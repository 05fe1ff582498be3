//! Joints with one degree of freedom, a rotation about an axis or a translation along it, and their elimination.

use crate::multibody::elimination::{BadPivot, FreedomTangent, ROUND_OFF, Weights};
use crate::multibody::joint::{Joint, JointKind};
use crate::multibody::node::{ArticulatedInertia, Pair};
use nalgebra::Vector3;

/// Type of motion along or about the axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Freedom {
    /// Rotation about the axis.
    Rotation,
    /// Translation along the axis.
    Translation,
    /// Any twist, of a body that slides along a beam.
    Twist,
}

/// A joint with one degree of freedom at the poses of the last sweep, with its factor.
#[derive(Debug, Clone)]
pub struct OneFreedom {
    /// Unit axis in the root frame.
    pub axis: Vector3<f64>,
    freedom: Freedom,
    /// Twist of the body per unit of the degree of freedom, for a sliding joint.
    twist: Pair,
    /// Inverse of the pivot; 0 for a held joint.
    inverse_pivot: f64,
    /// Product `P s` of the articulated inertia and the screw `s`.
    pushed: Pair,
    right_hand: f64,
    /// Angular acceleration of the carrier about the joint axis in rad/s², from [`crate::multibody::dynamics`], for a motor whose rotor
    /// rotates with the carrier.
    pub carrier_rate: f64,
}

impl OneFreedom {
    pub(super) fn new(kind: &JointKind) -> Self {
        Self {
            axis: Vector3::zeros(),
            freedom: match kind {
                JointKind::Sliding => Freedom::Twist,
                JointKind::Prismatic { .. } => Freedom::Translation,
                JointKind::Clamped
                | JointKind::Revolute { .. }
                | JointKind::Universal { .. }
                | JointKind::Ball
                | JointKind::Free => Freedom::Rotation,
            },
            twist: Pair::ZERO,
            inverse_pivot: 0.0,
            pushed: Pair::ZERO,
            right_hand: 0.0,
            carrier_rate: 0.0,
        }
    }

    /// Sets the twist of the body per unit of the degree of freedom of a sliding joint.
    pub(super) fn ride(&mut self, twist: Pair) {
        self.axis = twist.linear.try_normalize(0.0).unwrap_or_else(Vector3::x);
        self.twist = twist;
    }

    /// Twist of the body per unit of the degree of freedom.
    pub(super) fn screw(&self) -> Pair {
        match self.freedom {
            Freedom::Rotation => Pair { linear: Vector3::zeros(), angular: self.axis },
            Freedom::Translation => Pair { linear: self.axis, angular: Vector3::zeros() },
            Freedom::Twist => self.twist,
        }
    }

    /// Component of a wrench along the degree of freedom: force or torque.
    #[inline]
    pub(super) fn project(&self, wrench: &Pair) -> f64 {
        match self.freedom {
            Freedom::Rotation => self.axis.dot(&wrench.angular),
            Freedom::Translation => self.axis.dot(&wrench.linear),
            Freedom::Twist => self.twist.linear.dot(&wrench.linear) + self.twist.angular.dot(&wrench.angular),
        }
    }

    #[inline]
    pub(super) fn eliminate(
        &mut self,
        joint: &Joint,
        inertia: &ArticulatedInertia,
        weights: Weights,
        tangent: &FreedomTangent,
    ) -> Result<ArticulatedInertia, BadPivot> {
        let mut inertia = *inertia;
        // contribution of the motor's rotor to the inertia of the carrier, eq. (D17)
        let coupling = weights.mass * joint.drive_inertia * joint.drive_carried;
        if !tangent.free {
            (self.inverse_pivot, self.pushed) = (0.0, Pair::ZERO);
            self.add_rotor(&mut inertia, coupling * joint.drive_carried);
            return Ok(inertia);
        }
        let (velocity, spin) = match self.freedom {
            Freedom::Rotation => (inertia.vw * self.axis, inertia.ww * self.axis),
            Freedom::Translation => (inertia.vv * self.axis, inertia.vw.tr_mul(&self.axis)),
            Freedom::Twist => (
                inertia.vv * self.twist.linear + inertia.vw * self.twist.angular,
                inertia.vw.tr_mul(&self.twist.linear) + inertia.ww * self.twist.angular,
            ),
        };
        let pivot = self.project(&Pair { linear: velocity, angular: spin })
            + weights.stiffness * tangent.stiffness
            + weights.damping * tangent.damping
            + weights.mass * joint.drive_inertia;
        let scale = match self.freedom {
            Freedom::Rotation => inertia.ww.trace(),
            Freedom::Translation => inertia.vv.trace(),
            Freedom::Twist => inertia.vv.trace() * self.twist.linear.norm_squared(),
        };
        if !(pivot > ROUND_OFF * scale.max(0.0) && pivot.is_finite()) {
            return Err(BadPivot { coordinate: joint.coordinate });
        }
        let spin = if coupling == 0.0 { spin } else { spin + self.axis * coupling };
        self.add_rotor(&mut inertia, coupling * joint.drive_carried);
        self.pushed = Pair { linear: velocity, angular: spin };
        let inverse_pivot = 1.0 / pivot;
        self.inverse_pivot = inverse_pivot;
        Ok(ArticulatedInertia {
            vv: inertia.vv - velocity * velocity.transpose() * inverse_pivot,
            vw: inertia.vw - velocity * spin.transpose() * inverse_pivot,
            ww: inertia.ww - spin * spin.transpose() * inverse_pivot,
        })
    }

    /// Adds the moment of inertia of a motor's rotor about the axis.
    #[inline]
    fn add_rotor(&self, inertia: &mut ArticulatedInertia, moment: f64) {
        if moment != 0.0 {
            inertia.ww += self.axis * self.axis.transpose() * moment;
        }
    }

    #[inline]
    pub(super) fn reduce(&mut self, force: f64, p: &mut Pair) {
        let g = force + self.project(p);
        self.right_hand = g;
        let y = g * self.inverse_pivot;
        p.linear -= self.pushed.linear * y;
        p.angular -= self.pushed.angular * y;
    }

    /// Change of the degree of freedom; `moved` is transformed to the twist of the body's first node.
    #[inline]
    pub(super) fn expand(&self, moved: &mut Pair) -> f64 {
        let pull = self.right_hand - self.pushed.linear.dot(&moved.linear) - self.pushed.angular.dot(&moved.angular);
        let change = pull * self.inverse_pivot;
        self.displace(change, moved);
        change
    }

    #[inline]
    pub(super) fn displace(&self, change: f64, moved: &mut Pair) {
        match self.freedom {
            Freedom::Rotation => moved.angular += self.axis * change,
            Freedom::Translation => moved.linear += self.axis * change,
            Freedom::Twist => {
                moved.linear += self.twist.linear * change;
                moved.angular += self.twist.angular * change;
            }
        }
    }
}
