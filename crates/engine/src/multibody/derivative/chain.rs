//! Variations of the motion of the nodes along the tree, and the transposed map, NOTATION eqs. (X2) and (X3).

use crate::math::so3::hat;
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Vector3};

/// A vector with its first and second time derivatives.
pub(super) type Timed = [Vector3<f64>; 3];

/// The zero vector with zero derivatives.
pub(super) const STILL: Timed = [Vector3::new(0.0, 0.0, 0.0); 3];

/// `[ω̇]× + [ω]×²` of a node: maps a vector fixed to the node to its second time derivative.
#[inline]
pub(super) fn second(node: &Node) -> Matrix3<f64> {
    let first = hat(&node.spin);
    hat(&node.spin_rate) + first * first
}

/// A vector fixed to a node, with its time derivatives, root frame.
#[inline(always)]
pub(super) fn fixed(node: &Node, second: &Matrix3<f64>, vector: Vector3<f64>) -> Timed {
    [vector, node.spin.cross(&vector), second * vector]
}

/// Variation of a node's motion in the root frame: of its position, and the rotation vector of its variation in attitude. In transposed
/// products, the multipliers of these.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    /// Variation of the position in m.
    pub linear: Timed,
    /// Variation of the rotation in rad.
    pub angular: Timed,
}

/// Effect of a coordinate on the outer end of its link or joint, root frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    /// Displacement per unit of the coordinate.
    pub linear: Timed,
    /// Rotation per unit of the coordinate.
    pub angular: Timed,
    /// Derivative of the coordinate's force with respect to a rotation of the inner node: `linear × F + angular × M`.
    pub turned: Vector3<f64>,
}

impl Shift {
    pub const ZERO: Self = Self { linear: STILL, angular: STILL };

    /// Variation of a point fixed to the node at the end of an arm.
    #[inline(always)]
    pub fn carried(&self, arm: &Timed) -> Self {
        let ([d, d1, d2], [turn, turn1, turn2], [r, r1, r2]) = (&self.linear, &self.angular, arm);
        Self {
            linear: [
                d + turn.cross(r),
                d1 + turn1.cross(r) + turn.cross(r1),
                d2 + turn2.cross(r) + turn1.cross(r1) * 2.0 + turn.cross(r2),
            ],
            angular: self.angular,
        }
    }

    /// Adds the multipliers of a point fixed to the node at the end of an arm: the transpose of [`Shift::carried`].
    #[inline(always)]
    pub fn add_carried(&mut self, outer: &Self, arm: &Timed) {
        let ([b, b1, b2], [r, r1, r2]) = (&outer.linear, arm);
        for (own, outer) in self.linear.iter_mut().zip(&outer.linear) {
            *own += outer;
        }
        let [turn, turn1, turn2] = &mut self.angular;
        let [t, t1, t2] = &outer.angular;
        *turn += t + r.cross(b) + r1.cross(b1) + r2.cross(b2);
        *turn1 += t1 + r.cross(b1) + r1.cross(b2) * 2.0;
        *turn2 += t2 + r.cross(b2);
    }
}

/// Adds `c x` with its time derivatives, for the linear or angular part of a column.
#[inline(always)]
pub(super) fn add_part(sum: &mut Timed, [c, c1, c2]: &Timed, [x, x1, x2]: [f64; 3]) {
    sum[0] += c * x;
    sum[1] += c * x1 + c1 * x;
    sum[2] += c * x2 + c1 * (2.0 * x1) + c2 * x;
}

/// The transpose of [`add_part`]: multipliers of `x, ẋ, ẍ` from those of the sum.
#[inline(always)]
pub(super) fn pulled_part([c, c1, c2]: &Timed, [b, b1, b2]: &Timed) -> [f64; 3] {
    [c.dot(b) + c1.dot(b1) + c2.dot(b2), c.dot(b1) + 2.0 * c1.dot(b2), c.dot(b2)]
}

impl Column {
    pub const ZERO: Self = Self { linear: STILL, angular: STILL, turned: Vector3::new(0.0, 0.0, 0.0) };

    /// Adds the effect of a coordinate's variation, with its rate and acceleration.
    #[inline(always)]
    pub fn add(&self, shift: &mut Shift, change: [f64; 3]) {
        add_part(&mut shift.linear, &self.linear, change);
        add_part(&mut shift.angular, &self.angular, change);
    }

    /// Multipliers of the coordinate, its rate and its acceleration.
    #[inline(always)]
    pub fn pulled(&self, on: &Shift) -> [f64; 3] {
        let (linear, angular) = (pulled_part(&self.linear, &on.linear), pulled_part(&self.angular, &on.angular));
        std::array::from_fn(|kind| linear[kind] + angular[kind])
    }

    /// Generalised force on the coordinate due to a wrench at the outer end.
    #[inline(always)]
    pub fn project(&self, force: &Vector3<f64>, moment: &Vector3<f64>) -> f64 {
        self.linear[0].dot(force) + self.angular[0].dot(moment)
    }

    /// Stores the derivative of the generalised force of a wrench with respect to a rotation.
    #[inline(always)]
    pub fn set_turned(&mut self, force: &Vector3<f64>, moment: &Vector3<f64>) {
        self.turned = self.linear[0].cross(force) + self.angular[0].cross(moment);
    }
}
