//! Universal, ball and free joints in the plant: start, attitude, projection.

use crate::machine::Machine;
use crate::machine::Spatial;
use crate::multibody::joint::{Joint, JointKind, RedundantWork};
use crate::multibody::{Model, Workspace};
use nalgebra::{Matrix3, Vector3};

/// A universal, ball or free joint as the equations see it.
#[derive(Debug, Clone)]
pub(crate) struct SpatialJoint {
    /// Body that it holds.
    pub body: usize,
    /// Its parameters.
    joint: Joint,
}

impl SpatialJoint {
    /// The joints of a machine.
    pub fn of_machine(machine: &Machine, model: &Model) -> Vec<Self> {
        machine.spatials().map(|(body, _)| Self { body, joint: model.bodies[body].joint }).collect()
    }

    /// Start rates of the parameters that agree with the start velocities; `q` holds the start attitude.
    pub fn start(&self, spatial: &Spatial, q: &[f64], v: &mut [f64]) {
        let range = self.range();
        let rates = self.joint.kind.parameter_rates(&q[range.clone()], &spatial.start_angular_velocity_rad_s);
        v[range.clone()].copy_from_slice(&rates[..range.len()]);
        if self.joint.kind == JointKind::Free {
            v[range.start..range.start + 3].copy_from_slice(spatial.start_velocity_m_s.as_slice());
        }
    }

    /// Attitude, parent ← body, of the last sweep.
    pub fn rotation(&self, work: &Workspace) -> Matrix3<f64> {
        work.joints[self.body].redundant().map_or_else(Matrix3::identity, |parameters| parameters.pose.rotation)
    }

    /// Attitude (parent ← body) and angular velocity relative to the parent (parent's frame) of the last sweep.
    pub fn motion(&self, work: &Workspace, v: &[f64]) -> (Matrix3<f64>, Vector3<f64>) {
        let Some(parameters) = work.joints[self.body].redundant() else {
            return (Matrix3::identity(), Vector3::zeros());
        };
        (parameters.pose.rotation, self.spin(parameters, v))
    }

    /// Back to the constraints of the parameters.
    pub fn project(&self, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        self.joint.restore(q, v, a);
    }

    /// Its parameters in the coordinates.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.joint.range()
    }

    fn spin(&self, parameters: &RedundantWork, v: &[f64]) -> Vector3<f64> {
        let rates = &v[self.range()];
        parameters.pose.spin(&self.joint.kind, rates, rates).0
    }
}
