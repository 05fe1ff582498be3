//! Jumps of the rates between two steps, eq. (X17), and the variations of their impulses.

use crate::gradient::add;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::System;
use crate::system::brake::JUMP_1_S;

/// Variations of the impulses of a jump.
pub(super) struct Impulses {
    /// Coordinates of the joints that it stops.
    pub stopped: Vec<usize>,
    /// Their variations in every direction.
    pub variations: Vec<Vec<f64>>,
}

/// Jump of the rates between two steps.
#[derive(Debug, Clone)]
pub(super) struct Jump {
    /// Configuration at which it happens, at rest, with the jump times [`JUMP_1_S`] as accelerations.
    pub at: Point,
    /// The same without accelerations.
    pub still: Point,
    /// Coordinates of the joints that it stops.
    pub stopped: Vec<usize>,
}

impl Jump {
    /// Slope of the residual of a system with the jump as accelerations, less that without it: of `M Δv`, with the rows of the joints that
    /// are stopped.
    pub fn momentum(&self, system: &mut System, scratch: &mut [f64], factor: f64, sum: &mut [f64]) {
        system.join_loops();
        for (point, sign) in [(&self.at, 1.0), (&self.still, -1.0)] {
            system.equations.residual(point.time_s, &point.q, &point.v, &point.a, scratch);
            for joint in
                system.equations.forces.joints().iter().filter(|joint| self.stopped.contains(&joint.coordinate))
            {
                scratch[joint.coordinate] = joint.holding_n_m;
            }
            add(sum, sign * factor / JUMP_1_S, scratch);
        }
        system.part_loops();
    }
}
