//! What the initial motion of a point depends on.

use crate::interface::binding::{Binding, PointOutput};
use crate::interface::hinge_dependencies::{start_rate, starts};
use crate::interface::topology::{Topology, Turning};

/// Initial value of a point's row, accelerations excepted.
pub(super) fn point_initially(topology: &Topology, body: usize, field: PointOutput, known: Binding) -> bool {
    let path = &topology.path[body];
    let turns = |joints: &[Turning]| joints.iter().any(|&joint| topology.starts_turning(joint));
    match field {
        PointOutput::Position(_) => topology.folds(body).any(|joint| starts(topology, joint, known)),
        PointOutput::Rotation(_) => {
            topology.folds(body).any(|joint| topology.turns(joint) && starts(topology, joint, known))
        }
        PointOutput::Velocity(_) => {
            let changes = |joint| starts(topology, joint, known) || start_rate(topology, joint, known);
            turns(path) && topology.folds(body).any(changes)
        }
        // An angle turns the hinges behind it, not its own; what only slides has no angular velocity.
        PointOutput::AngularVelocity(_) => path.iter().enumerate().any(|(i, &joint)| {
            let slides = |joint: Turning| matches!(joint, Turning::Revolute(joint) if !topology.turns(joint));
            let spins = |joint: &Turning| topology.starts_turning(*joint) && !slides(*joint);
            let Turning::Revolute(joint) = joint else { return false };
            topology.turns(joint)
                && (start_rate(topology, joint, known)
                    || (starts(topology, joint, known) && path[i + 1..].iter().any(spins)))
        }),
        PointOutput::Acceleration(_) | PointOutput::AngularAcceleration(_) => false,
    }
}
