//! Pose of the unstrained machine: frames of its sections at given fold angles and positions of prismatic joints.

use crate::machine::{Body, JointKind, OneFreedom, Parent};
use crate::math::strain::{CURVATURES, STRETCH};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A section of the unstrained machine in the root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin in m.
    pub position_m: Vector3<f64>,
    /// Attitude, root ← section.
    pub attitude: Matrix3<f64>,
}

/// Frames of the bodies' inner ends, with natural strains only, at the fold angles (rad) and positions of prismatic joints (m) returned by
/// `stand`.
///
/// Universal, ball and free joints are in their initial attitude, which is their mount.
pub fn first_frames(bodies: &[Body], stand: impl Fn(&OneFreedom) -> f64) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::with_capacity(bodies.len());
    for body in bodies {
        let origin = match body.joint.parent {
            Parent::Root { position_m } => Frame { position_m, attitude: Matrix3::identity() },
            Parent::Body { index, position_m } => {
                let position_m = match &body.joint.kind {
                    JointKind::Sliding(own) => stand(own),
                    JointKind::Clamped | JointKind::Revolute(_) | JointKind::Prismatic(_) | JointKind::Spatial(_) => {
                        position_m
                    }
                };
                let place = along(&bodies[index], &frames[index], position_m);
                Frame { position_m: place.position_m + place.attitude * body.joint.offset_m, ..place }
            }
        };
        let moved = body.joint.kind.one_freedom().filter(|_| !body.joint.kind.rides());
        let (displacement_m, fold) = moved.map_or_else(
            || (Vector3::zeros(), Matrix3::identity()),
            |(travel, joint)| travel.moved(&joint.axis, stand(joint)),
        );
        let mut first = Frame { attitude: origin.attitude * fold * body.joint.mount, ..origin };
        if displacement_m != Vector3::zeros() {
            first.position_m += origin.attitude * displacement_m;
        }
        frames.push(first);
    }
    frames
}

/// Frame at a distance from a body's first frame along the curve of its natural strain, by the midpoint rule. A full circle closes to 1e-4
/// of its radius.
pub fn along(body: &Body, first: &Frame, distance_m: f64) -> Frame {
    const STEPS: usize = 200;
    if body.is_rigid() {
        return *first;
    }
    let step = distance_m / STEPS as f64;
    let mut frame = *first;
    for i in 0..STEPS {
        let strain = body.natural_strain.at(step * (i as f64 + 0.5));
        let turn = Vector3::from_column_slice(&strain.as_slice()[CURVATURES]);
        let half_turn = Rotation3::new(turn * (0.5 * step)).into_inner();
        let middle = frame.attitude * half_turn;
        frame.position_m += middle.column(0) * ((1.0 + strain[STRETCH]) * step);
        frame.attitude = middle * half_turn;
    }
    frame
}
