//! Outward sweep: poses, velocities and accelerations of all nodes relative to the root frame.

use crate::math::se3::LinkGeometry;
use crate::math::so3::rotation_about;
use crate::multibody::joint::{JointPose, ParameterJoint, ParameterKind};
use crate::multibody::model::{Base, Model};
use crate::multibody::workspace::{Node, ParameterWork, Workspace};
use nalgebra::{Matrix3, Vector3};

/// Coordinates, rates and accelerations, each of [`Model::coordinates`].
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Joint angles (rad) and strains (–, 1/m).
    pub q: &'a [f64],
    /// Their rates per second.
    pub v: &'a [f64],
    /// Their accelerations per second squared.
    pub a: &'a [f64],
}

/// Four strains of an element out of a coordinate vector.
#[inline]
pub(crate) fn strains(coordinates: &[f64], first: usize) -> [f64; 4] {
    let s = &coordinates[first..first + 4];
    [s[0], s[1], s[2], s[3]]
}

/// Poses and Jacobians only: what a kinematic norm or a tangent at a configuration needs.
pub fn sweep_poses(model: &Model, work: &mut Workspace, q: &[f64]) {
    sweep::<false>(model, work, Motion { q, v: &[], a: &[] });
}

/// Poses, velocities and accelerations, NOTATION eqs. (K8)–(K9). Allocates nothing.
pub fn sweep_motion(model: &Model, work: &mut Workspace, motion: Motion) {
    sweep::<true>(model, work, motion);
}

/// Moves a body's first node, which stands where its parent is, by a joint with redundant parameters.
fn move_joint<const RATES: bool>(
    joint: &ParameterJoint,
    work: &mut ParameterWork,
    node: &mut Node,
    parent: &Matrix3<f64>,
    motion: Motion,
) {
    let range = joint.coordinate..joint.coordinate + joint.kind.parameters();
    let pose = JointPose::new(&joint.kind, &motion.q[range.clone()]);
    node.rotation = parent * pose.rotation;
    // a free joint hangs on the root frame: its offset needs no turning
    node.position += pose.offset_m;
    if RATES {
        let (rates, second) = (&motion.v[range.clone()], &motion.a[range]);
        let (spin, spin_rate) = pose.spin(&joint.kind, rates, second);
        let spin = parent * spin;
        node.spin_rate += parent * spin_rate + node.spin.cross(&spin);
        node.spin += spin;
        if joint.kind == ParameterKind::Free {
            node.velocity += Vector3::new(rates[0], rates[1], rates[2]);
            node.acceleration += Vector3::new(second[0], second[1], second[2]);
        }
    }
    work.axes = parent * pose.axes;
    work.constraint_axis = parent * pose.constraint_axis;
    work.parent = *parent;
    work.pose = pose;
}

#[inline]
fn sweep<const RATES: bool>(model: &Model, work: &mut Workspace, motion: Motion) {
    let zero = Vector3::zeros();
    for (index, body) in model.bodies.iter().enumerate() {
        let (position, parent) = match body.base {
            Base::Root(position) => (position, None),
            Base::Node(node) => (work.nodes[node].position, Some(work.nodes[node])),
        };
        let node = &mut work.nodes[body.first_node];
        node.position = position;
        match &parent {
            Some(parent) if RATES => {
                node.velocity = parent.velocity;
                node.spin = parent.spin;
                node.acceleration = parent.acceleration;
                node.spin_rate = parent.spin_rate;
            }
            _ => {
                node.velocity = zero;
                node.spin = zero;
                node.acceleration = zero;
                node.spin_rate = zero;
            }
        }
        let mut mount = body.mount;
        let mut axis = zero;
        if let Some(hinge) = &body.hinge {
            mount = rotation_about(&hinge.axis, motion.q[hinge.coordinate]) * mount;
            axis = parent.as_ref().map_or(hinge.axis, |parent| parent.rotation * hinge.axis);
            if RATES {
                let rate = motion.v[hinge.coordinate];
                node.spin_rate += axis * motion.a[hinge.coordinate] + node.spin.cross(&axis) * rate;
                node.spin += axis * rate;
            }
        }
        node.rotation = parent.as_ref().map_or(mount, |parent| parent.rotation * mount);
        work.hinges[index] = axis;
        if let (Some(joint), Some(parameters)) = (&body.parameters, &mut work.parameters[index]) {
            let parent = parent.as_ref().map_or_else(Matrix3::identity, |parent| parent.rotation);
            move_joint::<RATES>(joint, parameters, node, &parent, motion);
        }

        let range = body.first_element..body.first_element + body.elements;
        let mut inner = *node;
        for ((element, link), outer) in
            model.elements[range.clone()].iter().zip(&mut work.links[range]).zip(&mut work.nodes[body.first_node + 1..])
        {
            let first = element.coordinate;
            let (geometry, pose) = LinkGeometry::new(&inner.rotation, element.length_m, &strains(motion.q, first));
            *link = pose;
            let mut next = Node { position: inner.position + pose.arm_m, rotation: pose.rotation, ..inner };
            if RATES {
                let rates = geometry.rates(&inner.rotation, &strains(motion.v, first));
                let pull = strains(motion.a, first);
                let arm = &pose.arm_m;
                next.velocity = inner.velocity + inner.spin.cross(arm) + rates.velocity;
                next.spin = inner.spin + rates.spin;
                next.acceleration = inner.acceleration
                    + inner.spin_rate.cross(arm)
                    + inner.spin.cross(&(inner.spin.cross(arm) + rates.velocity * 2.0))
                    + rates.velocity_bias
                    + pose.velocity[0] * pull[0]
                    + pose.velocity[1] * pull[1]
                    + pose.velocity[2] * pull[2]
                    + pose.velocity[3] * pull[3];
                next.spin_rate = inner.spin_rate
                    + inner.spin.cross(&rates.spin)
                    + rates.spin_bias
                    + pose.spin[0] * pull[1]
                    + pose.spin[1] * pull[2]
                    + pose.spin[2] * pull[3];
            }
            outer.position = next.position;
            outer.rotation = next.rotation;
            outer.velocity = next.velocity;
            outer.spin = next.spin;
            outer.acceleration = next.acceleration;
            outer.spin_rate = next.spin_rate;
            inner = next;
        }
    }
}
