//! Prismatic joints: translation along an axis that is fixed to both sides.

use crate::multibody::joint::one_freedom::OneFreedom;
use crate::multibody::motion::Motion;
use crate::multibody::node::Node;
use nalgebra::{Matrix3, Vector3};

/// Moves a node from the joint's zero position along the axis, eq. (J7); returns the displacement in m, root frame.
#[inline]
pub(super) fn carry<const RATES: bool>(
    (axis, coordinate): (&Vector3<f64>, usize),
    mount: &Matrix3<f64>,
    one: &mut OneFreedom,
    parent: Option<&Node>,
    node: &mut Node,
    motion: Motion,
) -> Vector3<f64> {
    one.axis = parent.map_or(*axis, |parent| parent.rotation * axis);
    let displacement = one.axis * motion.q[coordinate];
    node.position += displacement;
    if RATES {
        let (swing, slide) = (node.spin.cross(&displacement), one.axis * motion.v[coordinate]);
        node.velocity += swing + slide;
        node.acceleration += node.spin_rate.cross(&displacement)
            + node.spin.cross(&(swing + slide * 2.0))
            + one.axis * motion.a[coordinate];
    }
    node.rotation = parent.map_or(*mount, |parent| parent.rotation * mount);
    displacement
}
