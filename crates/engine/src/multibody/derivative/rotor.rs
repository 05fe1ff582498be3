//! Variations of the forces of geared motors' rotors that turn with their carrier, NOTATION eqs. (D17) and (X38).

use crate::load::RootMotion;
use crate::multibody::derivative::chain::Shift;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Base, Model};
use crate::multibody::workspace::Workspace;
use nalgebra::Vector3;

/// A rotor at the point of linearisation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rotor {
    body: usize,
    /// Coordinate of its joint.
    coordinate: usize,
    /// Node of its carrier.
    node: usize,
    /// Its reflected inertia by the gear ratio in kg·m², and one by the gear ratio.
    coupling: f64,
    carried: f64,
    /// Axis, root frame.
    axis: Vector3<f64>,
    /// Moment on the carrier in N·m, root frame, with the sign of the residual.
    moment: Vector3<f64>,
    /// Slopes of the angular acceleration of the carrier about the axis by the variation of its attitude and the two derivatives of that.
    slopes: [Vector3<f64>; 3],
}

impl Rotor {
    /// The rotors of a model on moving carriers.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let of_body = |(body, own): (usize, &crate::multibody::model::Body)| match own.base {
            Base::Node(node) if own.joint.drive_carried != 0.0 => Some(Self {
                body,
                coordinate: own.joint.coordinate,
                node,
                coupling: own.joint.drive_inertia * own.joint.drive_carried,
                carried: own.joint.drive_carried,
                axis: Vector3::zeros(),
                moment: Vector3::zeros(),
                slopes: [Vector3::zeros(); 3],
            }),
            Base::Node(_) | Base::Root(_) | Base::Axis(_) => None,
        };
        model.bodies.iter().enumerate().filter_map(of_body).collect()
    }

    /// Linearises at the point of the last residual.
    pub fn prepare(&mut self, work: &Workspace, motion: Motion, root: &RootMotion) {
        let Some(one) = work.joints[self.body].one_freedom() else { return };
        let (axis, spin) = (one.axis, work.nodes[self.node].spin);
        let turning = root.angular_velocity_rad_s;
        let across = axis.cross(&turning);
        let of_frame = root.angular_acceleration_rad_s2 + turning.cross(&spin);
        self.axis = axis;
        self.moment = axis * (self.coupling * (motion.a[self.coordinate] + self.carried * one.carrier_rate));
        // the axis turns with its carrier, whose angular velocity varies by `φ̇ + φ × ω`
        self.slopes = [axis.cross(&of_frame) + spin.cross(&across), spin.cross(&axis) + across, axis];
    }

    /// Adds the variations of the force on the joint's coordinate and of the moment on the carrier.
    pub fn forward(&self, shifts: &[Shift], along: Motion, wrenches: &mut [[Vector3<f64>; 2]], sum: &mut [f64]) {
        let angular = &shifts[self.node].angular;
        let rate: f64 = self.slopes.iter().zip(angular).map(|(slope, turn)| slope.dot(turn)).sum();
        sum[self.coordinate] += self.coupling * rate;
        wrenches[self.node][1] += angular[0].cross(&self.moment)
            + self.axis * (self.coupling * (along.a[self.coordinate] + self.carried * rate));
    }

    /// The transpose of [`Self::forward`]: `on` are the multipliers of the wrenches, `w` those of the rows.
    pub fn reverse(&self, on: &[[Vector3<f64>; 2]], w: &[f64], sums: &mut [Shift], by_a: &mut [f64]) {
        let [_, on_moment] = &on[self.node];
        let along = self.coupling * self.axis.dot(on_moment);
        by_a[self.coordinate] += along;
        let by_rate = self.coupling * w[self.coordinate] + self.carried * along;
        let angular = &mut sums[self.node].angular;
        angular.iter_mut().zip(&self.slopes).for_each(|(sum, slope)| *sum += slope * by_rate);
        angular[0] += self.moment.cross(on_moment);
    }
}
