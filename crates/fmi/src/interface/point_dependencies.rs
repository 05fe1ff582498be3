//! Dependencies of the initial motion of a point.

use crate::interface::hinge_dependencies::{start_rate, starts};
use crate::interface::known::Known;
use crate::interface::topology::{Topology, Turning};

/// Returns whether the initial attitude depends on a known.
pub(super) fn turned_initially(topology: &Topology, body: usize, known: Known) -> bool {
    topology.folds(body).any(|joint| topology.turns(joint) && starts(topology, joint, known))
}

/// Returns whether the initial velocity depends on a known.
pub(super) fn velocity_initially(topology: &Topology, body: usize, known: Known) -> bool {
    let turns = topology.path[body].iter().any(|&joint| topology.starts_turning(joint));
    let changes = |joint| starts(topology, joint, known) || start_rate(topology, joint, known);
    turns && topology.folds(body).any(changes)
}

/// Returns whether the initial angular velocity depends on a known. A joint angle rotates the hinge axes outboard of it, not
/// the axis of its joint; a translation has no angular velocity.
pub(super) fn spins_initially(topology: &Topology, body: usize, known: Known) -> bool {
    let path = &topology.path[body];
    path.iter().enumerate().any(|(i, &joint)| {
        let slides = |joint: Turning| matches!(joint, Turning::Revolute(joint) if !topology.turns(joint));
        let spins = |joint: &Turning| topology.starts_turning(*joint) && !slides(*joint);
        let Turning::Revolute(joint) = joint else { return false };
        topology.turns(joint)
            && (start_rate(topology, joint, known)
                || (starts(topology, joint, known) && path[i + 1..].iter().any(spins)))
    })
}
