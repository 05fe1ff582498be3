//! Outward sweep: poses, velocities and accelerations of all nodes relative to the root frame.

use crate::math::local_link::{self, LANES, Lanes, LocalLinks, LocalMotions, Strains, matrix, vector};
use crate::math::so3::rotation_about;
use crate::multibody::joint::{JointPose, ParameterJoint, ParameterKind};
use crate::multibody::model::{Base, Model};
use crate::multibody::workspace::{Node, ParameterWork, Workspace};
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;

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

/// Poses and, with `RATES`, the rest.
#[inline]
fn sweep<const RATES: bool>(model: &Model, work: &mut Workspace, motion: Motion) {
    sweep_links::<RATES>(model, &mut work.local_links, &mut work.local_motions, motion);
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

        for i in 0..body.elements {
            let e = body.first_element + i;
            let (links, lane) = (&work.local_links[e / LANES], e % LANES);
            let [inner, outer] = &mut work.nodes[body.first_node + i..body.first_node + i + 2] else { unreachable!() };
            let turn = &inner.rotation;
            let arm = turn * vector(&links.arm_m, lane);
            work.arms[e] = arm;
            outer.rotation = turn * matrix(&links.rotation, lane);
            outer.position = inner.position + arm;
            if RATES {
                let motions = &work.local_motions[e / LANES];
                let swing = inner.spin.cross(&arm);
                let velocity = turn * vector(&motions.velocity, lane);
                let spin = turn * vector(&motions.spin, lane);
                outer.velocity = inner.velocity + swing + velocity;
                outer.spin = inner.spin + spin;
                outer.acceleration = inner.acceleration
                    + inner.spin_rate.cross(&arm)
                    + inner.spin.cross(&(swing + velocity * 2.0))
                    + turn * vector(&motions.acceleration, lane);
                outer.spin_rate = inner.spin_rate + inner.spin.cross(&spin) + turn * vector(&motions.spin_rate, lane);
            }
        }
    }
}

/// Works out all links in their own frames, some at a time.
#[inline]
fn sweep_links<const RATES: bool>(
    model: &Model,
    links: &mut [LocalLinks],
    motions: &mut [LocalMotions],
    motion: Motion,
) {
    let chunks = model.elements.chunks(LANES).zip(links.iter_mut().zip(motions));
    for (elements, (links, motions)) in chunks {
        let element = |lane: usize| &elements[lane.min(elements.len() - 1)];
        let first = from_fn(|lane| element(lane).coordinate);
        let length_m = Lanes(from_fn(|lane| element(lane).length_m));
        let q = Strains::read(motion.q, &first);
        if RATES {
            let (v, a) = (Strains::read(motion.v, &first), Strains::read(motion.a, &first));
            (*links, *motions) = local_link::poses_and_motions(length_m, &q, &v, &a);
        } else {
            *links = local_link::poses(length_m, &q);
        }
    }
}
