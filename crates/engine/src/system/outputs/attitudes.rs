//! Previous attitudes, for quaternions with continuous signs.

use crate::force::joint::JointForces;
use crate::math::so3::quaternion_near;
use crate::multibody::kinematics::sweep_poses;
use crate::multibody::model::Element;
use crate::multibody::station;
use crate::system::System;
use crate::system::equations::Equations;
use crate::system::spatial::SpatialJoint;
use crate::system::state::State;
use nalgebra::{UnitQuaternion, Vector3};

impl System {
    /// Stores the attitudes at the end of the last internal step, for quaternions with continuous signs. The signs do not depend on which
    /// outputs are read.
    pub(crate) fn remember_attitudes(&mut self) {
        let State { ahead, spatial_rotations, tip_rotations, station_rotations, .. } = &mut self.state;
        let last = [spatial_rotations, tip_rotations, station_rotations];
        self.equations.remember_attitudes(&ahead.q, &self.tip_bodies, last);
    }

    /// Also stores the current attitudes if the rotation in the internal step is so large that the attitude at its end does not determine
    /// the sign.
    pub(crate) fn remember_far_turns(&mut self) {
        let State { start, ahead, now, spatial_rotations, tip_rotations, station_rotations, .. } = &mut self.state;
        if turn_between(&self.equations, &start.q, &ahead.q) > FAR_TURN_RAD {
            sweep_poses(&self.equations.model, &mut self.equations.work, &now.q);
            let last = [spatial_rotations, tip_rotations, station_rotations];
            self.equations.remember_attitudes(&now.q, &self.tip_bodies, last);
        }
    }
}

impl Equations {
    /// Updates the stored attitudes of joints, tips and stations to the poses of the last sweep.
    fn remember_attitudes(
        &self,
        q: &[f64],
        tip_bodies: &[usize],
        [joints, tips, stations]: [&mut Vec<UnitQuaternion<f64>>; 3],
    ) {
        let (model, work) = (&self.model, &self.work);
        for (last, joint) in joints.iter_mut().zip(&self.spatial) {
            *last = quaternion_near(&joint.rotation(work), last);
        }
        for (last, &body) in tips.iter_mut().zip(tip_bodies) {
            *last = quaternion_near(&work.nodes[model.bodies[body].last_node()].rotation, last);
        }
        for (last, place) in stations.iter_mut().zip(&model.stations) {
            *last = quaternion_near(&station::rotation(model, work, q, place), last);
        }
    }
}

/// Rotation within one internal step, in rad, above which attitudes are stored at every communication point.
const FAR_TURN_RAD: f64 = 1.0;

/// Bound in rad on the rotation of any part of the model between two sets of coordinates: sum of the rotations in all joints and
/// elements.
fn turn_between(equations: &Equations, from: &[f64], to: &[f64]) -> f64 {
    let change = |c: usize| to[c] - from[c];
    let turns = |joint: &&JointForces| equations.model.bodies[joint.body].joint.kind.translations() == 0;
    let hinges: f64 = equations.forces.joints().iter().filter(turns).map(|joint| change(joint.coordinate).abs()).sum();
    let spatial: f64 = equations.spatial.iter().flat_map(SpatialJoint::range).map(|c| 2.0 * change(c).abs()).sum();
    let bend = |element: &Element| {
        let first = element.curvatures().start;
        element.length_m * Vector3::from_fn(|i, _| change(first + i)).norm()
    };
    let modal = equations.model.bodies.iter().filter_map(|body| body.modal.as_ref());
    let modal: f64 = modal.map(|modal| modal.turn_between(from, to)).sum();
    hinges + spatial + modal + equations.model.elements.iter().map(bend).sum::<f64>()
}
