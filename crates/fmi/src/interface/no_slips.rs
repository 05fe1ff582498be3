//! Rows of skates and wheels.

use crate::interface::cause::{Cause, Depends};
use crate::interface::table::{Shape, Table, Text, place};
use crate::interface::topology::Topology;
use foldwing_engine::machine::{NoSlip, Runner};
use foldwing_engine::plant::{NoSlipOutputs, OutputSet};

/// Outputs of a skate or a wheel: those of its rows, and its distance from the constraints.
pub(super) fn outputs(table: &mut Table, topology: &Topology, (index, no_slip): (usize, &NoSlip)) {
    let layout = table.outputs;
    let (kind, name, body) = (no_slip.table(), &no_slip.name, &topology.machine.bodies[no_slip.body].name);
    let rolls = match no_slip.runner {
        Runner::Skate { .. } => false,
        Runner::Wheel { rolling, .. } => rolling,
    };
    let on = format!("of the plane on body {body} at {kind} {name}");
    let forces = [
        (
            true,
            place!(layout.no_slips, index, NoSlipOutputs, side_force_n),
            "side_force",
            "across the heading, along normal x heading",
        ),
        (rolls, place!(layout.no_slips, index, NoSlipOutputs, rolling_force_n), "rolling_force", "along the heading"),
        (
            no_slip.hold_normal,
            place!(layout.no_slips, index, NoSlipOutputs, normal_force_n),
            "normal_force",
            "along the normal, negative where the plane pulls",
        ),
    ];
    for (_, at, key, direction) in forces.into_iter().filter(|(constrained, ..)| *constrained) {
        let text = Text::new(format!("{kind}.{name}.{key}"), format!("force {on}, {direction}"));
        let depends = Depends::on_group(topology, no_slip.body);
        table.output((at, OutputSet::LOOPS), Shape::Scalar, "Force", depends, text);
    }
    let by_state = |initial| Depends::new([Cause::Travel(no_slip.body)], [initial]);
    let at = place!(layout.no_slips, index, NoSlipOutputs, slip_m_s);
    let meaning = format!("velocity of slip of {kind} {name} in the constrained directions, zero to round-off");
    let text = Text::new(format!("{kind}.{name}.slip"), meaning);
    let depends = by_state(Cause::VelocityStart(no_slip.body));
    table.output((at, OutputSet::LOOPS), Shape::Scalar, "Velocity", depends, text);
    let at = place!(layout.no_slips, index, NoSlipOutputs, height_m);
    let meaning = format!("distance of the point of contact of {kind} {name} from the plane, along its normal");
    let text = Text::new(format!("{kind}.{name}.height"), meaning);
    table.output((at, OutputSet::LOOPS), Shape::Scalar, "Position", by_state(Cause::Folds(no_slip.body)), text);
}
