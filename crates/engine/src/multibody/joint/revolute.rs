//! Revolute joints: rotation about an axis that is fixed to both sides.

use crate::math::so3::rotation_about;
use crate::multibody::joint::one_freedom::OneFreedom;
use crate::multibody::motion::Motion;
use crate::multibody::node::Node;
use nalgebra::{Matrix3, Vector3};

/// Rotates a node at the joint, eq. (K9).
#[inline]
pub(super) fn carry<const RATES: bool>(
    (axis, coordinate): (&Vector3<f64>, usize),
    mount: &Matrix3<f64>,
    one: &mut OneFreedom,
    parent: Option<&Node>,
    node: &mut Node,
    motion: Motion,
) {
    let mount = rotation_about(axis, motion.q[coordinate]) * mount;
    one.axis = parent.map_or(*axis, |parent| parent.rotation * axis);
    if RATES {
        let rate = motion.v[coordinate];
        node.spin_rate += one.axis * motion.a[coordinate] + node.spin.cross(&one.axis) * rate;
        node.spin += one.axis * rate;
    }
    node.rotation = parent.map_or(mount, |parent| parent.rotation * mount);
}
