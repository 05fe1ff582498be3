//! Universal, ball and free joints in the system: start, attitude, projection.

use crate::machine::{LoopEnd, Machine, Parent, Spatial};
use crate::multibody::joint::{Joint, RedundantWork};
use crate::multibody::{Model, Workspace};
use nalgebra::{Matrix3, Vector3};

/// A universal, ball or free joint in the equations of motion.
#[derive(Debug, Clone)]
pub(crate) struct SpatialJoint {
    /// Body attached by the joint.
    pub body: usize,
    /// Redundant parameters of the joint.
    joint: Joint,
    /// Whether it is a free joint that is the only connection of its bodies to the rest of the model, without loops, skates and wheels.
    pub flies: bool,
    /// Whether it is held while the other parts of the model settle, eq. (Q8).
    pub held: bool,
}

impl SpatialJoint {
    /// The joints of a model.
    pub fn of_machine(machine: &Machine, model: &Model) -> Vec<Self> {
        let of = |(body, _): (usize, &Spatial)| {
            let joint = model.bodies[body].joint;
            let looped = machine.closures.iter().flat_map(|closure| closure.ends).filter_map(LoopEnd::on_body);
            let mut held = looped.map(|(end, _)| end).chain(machine.no_slips.iter().map(|no_slip| no_slip.body));
            let flies = joint.kind.floats() && !held.any(|end| carries(machine, body, end));
            Self { body, joint, flies, held: false }
        };
        machine.spatials().map(of).collect()
    }

    /// Sets the initial rates of the parameters consistent with the initial velocities; `q` holds the initial attitude.
    pub fn start(&self, spatial: &Spatial, q: &[f64], v: &mut [f64]) {
        let range = self.range();
        let rates = self.joint.kind.parameter_rates(&q[range.clone()], &spatial.start_angular_velocity_rad_s);
        v[range.clone()].copy_from_slice(&rates[..range.len()]);
        if self.joint.kind.floats() {
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

    /// Projects coordinates, rates and accelerations onto the constraints of the parameters.
    pub fn project(&self, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        self.joint.restore(q, v, a);
    }

    /// Range of its parameters in the coordinates.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.joint.range()
    }

    /// Force in N and moment in N·m about the joint required to hold it, from a residual; root frame.
    pub fn holding(&self, residual: &[f64]) -> [Vector3<f64>; 2] {
        let first = self.range().start;
        [0, 3].map(|part| Vector3::from_column_slice(&residual[first + part..first + part + 3]))
    }

    fn spin(&self, parameters: &RedundantWork, v: &[f64]) -> Vector3<f64> {
        let rates = &v[self.range()];
        parameters.pose.spin(&self.joint.kind, rates, rates).0
    }
}

/// Whether `body` is `end` or lies between `end` and the root.
fn carries(machine: &Machine, body: usize, end: usize) -> bool {
    let mut at = end;
    loop {
        match machine.bodies[at].joint.parent {
            _ if at == body => return true,
            Parent::Body { index, .. } => at = index,
            Parent::Root { .. } => return false,
        }
    }
}
