//! Variations of the penalty forces of closed loops, NOTATION eqs. (C1), (C2) and (X3).

use crate::multibody::closure::Closure;
use crate::multibody::derivative::chain::{STILL, Shift, Timed, fixed, second};
use crate::multibody::workspace::{Node, Workspace};
use nalgebra::Vector3;

/// A loop at the point of linearisation.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoopForce {
    nodes: [Option<usize>; 2],
    /// Vectors from the nodes to the points of the gap in m; zero on the root.
    arms: [Timed; 2],
    /// Penalty factors of the gap, its rate and its acceleration.
    penalty: [f64; 3],
    /// Force on the second point.
    force: Vector3<f64>,
}

impl LoopForce {
    pub const ZERO: Self =
        Self { nodes: [None; 2], arms: [STILL; 2], penalty: [0.0; 3], force: Vector3::new(0.0, 0.0, 0.0) };

    pub fn new(closure: &Closure, work: &Workspace) -> Self {
        let arm = |side: usize| -> Timed {
            let Some(n) = closure.nodes[side] else { return STILL };
            let node: &Node = &work.nodes[n];
            fixed(node, &second(node), node.rotation * closure.offsets_m[side])
        };
        let penalty = &closure.penalty;
        Self {
            nodes: closure.nodes,
            arms: [arm(0), arm(1)],
            penalty: [penalty.stiffness_n_m, penalty.damping_n_s_m, penalty.inertia_kg],
            force: closure.force_n(&closure.gap(work)),
        }
    }

    /// Adds the variations of the loop's wrenches on both nodes.
    pub fn forward(&self, shifts: &[Shift], wrenches: &mut [[Vector3<f64>; 2]]) {
        let ends = [0, 1].map(|side| match self.nodes[side] {
            Some(n) => shifts[n].carried(&self.arms[side]).linear,
            None => STILL,
        });
        let force =
            (0..3).fold(Vector3::zeros(), |sum, order| sum + (ends[1][order] - ends[0][order]) * self.penalty[order]);
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let Some(node) = self.nodes[side] else { continue };
            let arm = self.arms[side][0];
            let turned = shifts[node].angular[0].cross(&arm);
            let [sum_force, sum_moment] = &mut wrenches[node];
            *sum_force += force * sign;
            *sum_moment += (turned.cross(&self.force) + arm.cross(&force)) * sign;
        }
    }

    /// The transpose of [`Self::forward`].
    pub fn reverse(&self, on: &[[Vector3<f64>; 2]], sums: &mut [Shift]) {
        let mut by_force = Vector3::zeros();
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let Some(node) = self.nodes[side] else { continue };
            let arm = self.arms[side][0];
            let [force, moment] = &on[node];
            by_force += (force + moment.cross(&arm)) * sign;
            sums[node].angular[0] += arm.cross(&self.force.cross(moment)) * sign;
        }
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let Some(node) = self.nodes[side] else { continue };
            let end = Shift { linear: self.penalty.map(|factor| by_force * (factor * sign)), angular: STILL };
            sums[node].add_carried(&end, &self.arms[side]);
        }
    }
}
