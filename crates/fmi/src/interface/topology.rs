//! Topology of the tree of bodies, for the dependencies of the table.

use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{Closure, JointMotion, LatchKind, OneFreedom, Parent, Spatial, SpatialFreedom, Travel};

/// A joint with degrees of freedom, by its index in [`Topology::revolutes`] or [`Topology::spatials`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turning {
    /// A fold joint or a prismatic one.
    Revolute(usize),
    /// A universal, ball or free joint.
    Spatial(usize),
}

/// Order and connection of joints, stations and free ends, as [`foldwing_engine::plant::Plant`] numbers them.
pub(super) struct Topology<'a> {
    /// The model.
    pub machine: &'a Machine,
    /// Bodies whose joint is revolute or prismatic.
    pub revolutes: Vec<usize>,
    /// Bodies whose joint is universal, ball or free.
    pub spatials: Vec<usize>,
    /// Bodies whose outer end is free.
    pub tips: Vec<usize>,
    /// Body and number (from 1, per body) of each station.
    pub stations: Vec<(usize, usize)>,
    /// Per body: the first body of its branch, attached to the root.
    branch: Vec<usize>,
    /// Per body: group of the branches connected with its branch by closed loops with inertia, identified by its first body. Loops
    /// without inertia transmit no acceleration: their forces follow from the state.
    pub group: Vec<usize>,
    /// Per body: first body of the branches connected with its branch by any closed loops or by aerodynamics; other branches have no
    /// effect on its accelerations.
    pub coupled: Vec<usize>,
    /// Per body: rotating joints between the root and the body, from the root outward.
    pub path: Vec<Vec<Turning>>,
}

impl<'a> Topology<'a> {
    /// Topology of a model whose parents precede their children.
    pub fn new(machine: &'a Machine) -> Self {
        let revolutes: Vec<usize> =
            (0..machine.bodies.len()).filter(|&body| revolute(machine, body).is_some()).collect();
        let spatials: Vec<usize> = (0..machine.bodies.len()).filter(|&body| spatial(machine, body).is_some()).collect();
        let mut branch: Vec<usize> = Vec::new();
        let mut path: Vec<Vec<Turning>> = Vec::new();
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
            joints.extend(revolutes.iter().position(|&joint| joint == index).map(Turning::Revolute));
            joints.extend(spatials.iter().position(|&joint| joint == index).map(Turning::Spatial));
            branch.push(first);
            path.push(joints);
        }
        let group = groups(&branch, machine.closures.iter().filter(|closure| closure.resists_acceleration()));
        let coupled =
            if machine.air.is_some() { vec![0; branch.len()] } else { groups(&branch, machine.closures.iter()) };
        Self {
            machine,
            revolutes,
            spatials,
            tips: (0..free.len()).filter(|&body| free[body]).collect(),
            stations: machine
                .bodies
                .iter()
                .enumerate()
                .flat_map(|(index, body)| (1..=body.station_positions_m.len()).map(move |number| (index, number)))
                .collect(),
            branch,
            group,
            coupled,
            path,
        }
    }

    /// The joint at an index into `revolutes`.
    pub fn revolute(&self, joint: usize) -> &'a OneFreedom {
        revolute(self.machine, self.revolutes[joint]).expect("listed because it has one freedom").1
    }

    /// Type of motion of the joint at an index into `revolutes`.
    pub fn travel(&self, joint: usize) -> Travel {
        revolute(self.machine, self.revolutes[joint]).expect("listed because it has one freedom").0
    }

    /// Returns whether the joint at an index into `revolutes` is revolute.
    pub fn turns(&self, joint: usize) -> bool {
        self.travel(joint) == Travel::Rotation
    }

    /// Name of a joint by index into `revolutes`.
    pub fn joint_name(&self, joint: usize) -> &'a str {
        &self.machine.bodies[self.revolutes[joint]].joint.name
    }

    /// Returns whether the motion of a joint depends on its torques.
    pub fn is_free(&self, joint: usize) -> bool {
        self.revolute(joint).motion == JointMotion::Free
    }

    /// Returns whether a joint has an elastic latch.
    pub fn has_elastic_latch(&self, joint: usize) -> bool {
        self.revolute(joint).latch.as_ref().is_some_and(|latch| latch.kind == LatchKind::Elastic)
    }

    /// Returns whether a joint has a rigid latch.
    pub fn has_rigid_latch(&self, joint: usize) -> bool {
        self.revolute(joint).latch.as_ref().is_some_and(|latch| latch.kind == LatchKind::Rigid)
    }

    /// Returns whether the angle of a joint is a function of time.
    pub fn is_prescribed(&self, joint: usize) -> bool {
        matches!(self.revolute(joint).motion, JointMotion::Prescribed(_))
    }

    /// Returns whether the fold joint rotates at the start.
    pub fn turns_at_start(&self, joint: usize) -> bool {
        self.is_prescribed(joint) || (self.is_free(joint) && self.revolute(joint).start_rate_rad_s != 0.0)
    }

    /// The universal, ball or free joint at an index into `spatials`.
    pub fn spatial(&self, joint: usize) -> &'a Spatial {
        spatial(self.machine, self.spatials[joint]).expect("listed because it is universal, ball or free")
    }

    /// Returns whether the joint at an index into `spatials` is a free joint.
    pub fn is_unbound(&self, joint: usize) -> bool {
        self.spatial(joint).freedom == SpatialFreedom::Free
    }

    /// Returns whether the universal, ball or free joint rotates at the start.
    pub fn spins_at_start(&self, joint: usize) -> bool {
        self.spatial(joint).start_angular_velocity_rad_s.amax() > 0.0
    }

    /// Returns whether a body's joint is a ball joint.
    pub fn is_ball(&self, body: usize) -> bool {
        spatial(self.machine, body).is_some_and(|joint| joint.freedom == SpatialFreedom::Ball)
    }

    /// Returns whether a joint on a path rotates at the start.
    pub fn starts_turning(&self, joint: Turning) -> bool {
        match joint {
            Turning::Revolute(joint) => self.turns_at_start(joint),
            Turning::Spatial(joint) => self.spins_at_start(joint),
        }
    }

    /// Fold joints between the root and a body, from the root outward.
    pub fn folds(&self, body: usize) -> impl Iterator<Item = usize> {
        self.path[body].iter().filter_map(|joint| match joint {
            Turning::Revolute(joint) => Some(*joint),
            Turning::Spatial(_) => None,
        })
    }

    /// Returns whether the group of a body floats: no joint, no loop with inertia, no skate and no wheel connects it to the root.
    pub fn floats(&self, body: usize) -> bool {
        let group = self.group[body];
        let held = |closure: usize| {
            self.machine.closures[closure].resists_acceleration()
                && self.ends_on_root(closure)
                && self.joined(closure).any(|body| self.group[body] == group)
        };
        let mut members = self.branch.iter().copied().filter(|&first| self.group[first] == group);
        let rests = self.machine.no_slips.iter().any(|no_slip| self.group[no_slip.body] == group);
        members.all(|first| self.unbound(first).is_some()) && !(0..self.machine.closures.len()).any(held) && !rests
    }

    /// Returns whether the first body of a body's branch is on a free joint and has a velocity at the start.
    pub fn drifts(&self, body: usize) -> bool {
        self.unbound(self.branch[body]).is_some_and(|joint| joint.start_velocity_m_s.amax() > 0.0)
    }

    /// Returns whether the branch of a body is on a free joint.
    pub fn flies(&self, body: usize) -> bool {
        self.unbound(self.branch[body]).is_some()
    }

    /// The free joint of a body, if it has one.
    fn unbound(&self, body: usize) -> Option<&'a Spatial> {
        spatial(self.machine, body).filter(|joint| joint.freedom == SpatialFreedom::Free)
    }

    /// Bodies of the first and the second point of a closed loop; `None` for the root.
    pub fn ends(&self, closure: usize) -> [Option<usize>; 2] {
        self.machine.closures[closure].ends.map(|end| end.on_body().map(|(body, _)| body))
    }

    /// Bodies of a closed loop: two, or one for a loop on the root.
    pub fn joined(&self, closure: usize) -> impl Iterator<Item = usize> + use<> {
        self.ends(closure).into_iter().flatten()
    }

    /// Returns whether a closed loop ends on the root.
    pub fn ends_on_root(&self, closure: usize) -> bool {
        self.ends(closure).contains(&None)
    }

    /// Fold joints between the root and exactly one side of a closed loop: they change the size of its gap.
    pub fn opens(&self, closure: usize) -> impl Iterator<Item = usize> {
        let folds = |body: Option<usize>| body.map_or_else(Vec::new, |body| self.folds(body).collect());
        let [first, second]: [Vec<usize>; 2] = self.ends(closure).map(folds);
        let either = first.clone().into_iter().chain(second.clone());
        either.filter(move |joint| first.contains(joint) != second.contains(joint))
    }
}

/// Per body: the first body of the first branch of its group.
fn groups<'a>(branch: &[usize], closures: impl Iterator<Item = &'a Closure>) -> Vec<usize> {
    let mut group = branch.to_vec();
    for closure in closures {
        // the root is fixed: loops on it connect no branches with each other
        let [Some(first), Some(second)] = closure.ends.map(|end| end.on_body().map(|(body, _)| group[body])) else {
            continue;
        };
        let (kept, joined) = (first.min(second), first.max(second));
        group.iter_mut().filter(|of| **of == joined).for_each(|of| *of = kept);
    }
    group
}

/// The revolute or prismatic joint of a body, if it has one.
fn revolute(machine: &Machine, body: usize) -> Option<(Travel, &OneFreedom)> {
    machine.bodies[body].joint.kind.one_freedom()
}

/// The universal, ball or free joint of a body, if it has one.
fn spatial(machine: &Machine, body: usize) -> Option<&Spatial> {
    machine.bodies[body].joint.kind.spatial()
}
