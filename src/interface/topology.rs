//! Who is connected to whom: what the table needs to know of the tree of bodies.

use crate::config::Machine;
use crate::config::machine::{JointKind, JointMotion, Parent, Revolute};

/// Order and connection of joints, stations and free ends, as [`crate::plant::Plant`] numbers them.
pub(super) struct Topology<'a> {
    /// The model.
    pub machine: &'a Machine,
    /// Bodies whose joint is revolute.
    pub revolutes: Vec<usize>,
    /// Bodies whose outer end is free.
    pub tips: Vec<usize>,
    /// Body and number (from 1, per body) of each station.
    pub stations: Vec<(usize, usize)>,
    /// Per body: the first body of its branch, the one that the root holds.
    pub branch: Vec<usize>,
    /// Per body: revolute joints between the root and the body, by index into `revolutes`.
    pub path: Vec<Vec<usize>>,
}

impl<'a> Topology<'a> {
    /// Of a machine whose bodies stand parent before child.
    pub fn new(machine: &'a Machine) -> Self {
        let revolutes: Vec<usize> =
            (0..machine.bodies.len()).filter(|&body| revolute(machine, body).is_some()).collect();
        let mut branch: Vec<usize> = Vec::new();
        let mut path: Vec<Vec<usize>> = Vec::new();
        let mut free = vec![true; machine.bodies.len()];
        for (index, body) in machine.bodies.iter().enumerate() {
            let (first, mut joints) = match body.joint.parent {
                Parent::Root { .. } => (index, Vec::new()),
                Parent::Body { index: parent, position_m } => {
                    let length_m = machine.bodies[parent].length_m;
                    free[parent] &= (length_m - position_m).abs() > 1e-9 * length_m;
                    (branch[parent], path[parent].clone())
                }
            };
            joints.extend(revolutes.iter().position(|&joint| joint == index));
            branch.push(first);
            path.push(joints);
        }
        Self {
            machine,
            revolutes,
            tips: (0..free.len()).filter(|&body| free[body]).collect(),
            stations: machine
                .bodies
                .iter()
                .enumerate()
                .flat_map(|(index, body)| (1..=body.station_positions_m.len()).map(move |number| (index, number)))
                .collect(),
            branch,
            path,
        }
    }

    /// The fold joint of an index into `revolutes`.
    pub fn revolute(&self, joint: usize) -> &'a Revolute {
        revolute(self.machine, self.revolutes[joint]).expect("listed because it is revolute")
    }

    /// Name of a joint by index into `revolutes`.
    pub fn joint_name(&self, joint: usize) -> &'a str {
        &self.machine.bodies[self.revolutes[joint]].joint.name
    }

    /// Whether the angle of a joint moves by its torques.
    pub fn is_free(&self, joint: usize) -> bool {
        self.revolute(joint).motion == JointMotion::Free
    }

    /// Whether the angle of a joint is a function of time.
    pub fn is_prescribed(&self, joint: usize) -> bool {
        matches!(self.revolute(joint).motion, JointMotion::Prescribed(_))
    }

    /// Whether the joint turns at the start.
    pub fn turns_at_start(&self, joint: usize) -> bool {
        self.is_prescribed(joint) || (self.is_free(joint) && self.revolute(joint).start_rate_rad_s != 0.0)
    }
}

/// The fold joint that holds a body, if it is one.
fn revolute(machine: &Machine, body: usize) -> Option<&Revolute> {
    match &machine.bodies[body].joint.kind {
        JointKind::Revolute(revolute) => Some(revolute),
        JointKind::Clamped | JointKind::Spatial(_) => None,
    }
}
