//! Kinematic norm: displacement of the nodes due to a change of the coordinates; last part of NOTATION eq. (D13).

use crate::math::strain::{SHEARED, STRAINS};
use crate::multibody::model::{Base, Model};
use crate::multibody::node::NormSquared;
use crate::multibody::node::Pair;
use crate::multibody::slide;
use crate::multibody::workspace::Workspace;

/// Twist of an element's outer end due to that of its inner end `node` and the change of its strains.
#[inline]
pub(crate) fn displaced<const N: usize>(
    model: &Model,
    work: &Workspace,
    (element, node): (usize, usize),
    inner: &Pair,
    strain: [f64; N],
) -> Pair {
    let (jacobian, rotation) = (work.jacobian(element), &work.nodes[node].rotation);
    let (linear, angular) = jacobian.push(model.elements[element].length_m, &strain);
    Pair {
        linear: inner.linear + inner.angular.cross(&work.arms[element]) + rotation * linear,
        angular: inner.angular + rotation * angular,
    }
}

/// [`displaced`] for a change of all coordinates.
#[inline]
fn changed(model: &Model, work: &Workspace, place: (usize, usize), inner: &Pair, change: &[f64]) -> Pair {
    let element = &model.elements[place.0];
    match element.sheared {
        None => displaced::<STRAINS>(model, work, place, inner, element.strains(change)),
        Some(_) => displaced::<SHEARED>(model, work, place, inner, element.strains(change)),
    }
}

/// Kinematic norm of a change of coordinates at the poses in `work`: largest rotation in rad, or node displacement divided by the reference
/// length.
pub fn kinematic_norm(model: &Model, work: &mut Workspace, change: &[f64]) -> f64 {
    let mut norm = NormSquared::default();
    for (index, body) in model.bodies.iter().enumerate() {
        let mut moved = match body.base {
            Base::Root(_) => Pair::ZERO,
            Base::Node(node) => work.bias[node],
            Base::Axis(index) => slide::displaced(model, work, index, change),
        };
        body.joint.displace(&work.joints[index], change, &mut moved);
        norm.include(&moved);
        work.bias[body.first_node] = moved;
        if let (Some(modal), Some(scratch)) = (&body.modal, &work.modal[index]) {
            moved = modal.displaced(scratch, &moved, change);
            work.bias[body.last_node()] = moved;
            norm.include(&moved);
        }
        for i in 0..body.elements {
            let (element, node) = (body.first_element + i, body.first_node + i);
            moved = changed(model, work, (element, node), &moved, change);
            work.bias[body.first_node + i + 1] = moved;
            norm.include(&moved);
        }
    }
    norm.value(model.reference_length_m)
}

/// First coordinate of the joint or element whose contribution to a change of coordinates is largest in the kinematic norm, at the poses in
/// `work`; contributions that are not finite are ignored.
pub fn largest_share(model: &Model, work: &Workspace, change: &[f64]) -> usize {
    let mut largest = (0.0, 0);
    let mut offer = |coordinate: usize, size: f64| {
        if size.is_finite() && size > largest.0 {
            largest = (size, coordinate);
        }
    };
    for (index, body) in model.bodies.iter().enumerate() {
        if body.joint.kind.freedoms() > 0 {
            let mut moved = Pair::ZERO;
            body.joint.displace(&work.joints[index], change, &mut moved);
            offer(body.joint.coordinate, alone(&moved, model.reference_length_m));
        }
        if let (Some(modal), Some(scratch)) = (&body.modal, &work.modal[index]) {
            let moved = modal.displaced(scratch, &Pair::ZERO, change);
            offer(modal.coordinate, alone(&moved, model.reference_length_m));
        }
        for i in 0..body.elements {
            let (index, node) = (body.first_element + i, body.first_node + i);
            let element = &model.elements[index];
            let moved = changed(model, work, (index, node), &Pair::ZERO, change);
            offer(element.coordinate, alone(&moved, model.reference_length_m));
        }
    }
    largest.1
}

/// Kinematic norm of one twist.
fn alone(moved: &Pair, reference_length_m: f64) -> f64 {
    (moved.linear.norm() / reference_length_m).max(moved.angular.norm())
}
