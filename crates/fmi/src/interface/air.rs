//! Rows of machines in air, and what they depend on.

use crate::interface::Variability;
use crate::interface::binding::{Binding, Input, JointInput, JointParameter, Output, Parameter};
use crate::interface::table::{AXES, POSITIVE, Table};
use crate::interface::topology::Topology;

/// Wind.
pub(super) fn inputs(table: &mut Table, topology: &Topology) {
    if topology.machine.air.is_none() {
        return;
    }
    for (i, axis) in AXES.iter().enumerate() {
        let meaning = format!("velocity of the air relative to the root's origin, {axis}, root frame");
        table.input(Input::Wind(i), format!("wind.velocity.{axis}"), Some("Velocity"), meaning);
    }
}

/// Loads of the air, and circulations on request.
pub(super) fn outputs(table: &mut Table, topology: &Topology) {
    let Some(air) = &topology.machine.air else { return };
    let mut vector = |bind: &dyn Fn(usize) -> Output, name: &str, declared, meaning: &str| {
        for (i, axis) in AXES.iter().enumerate() {
            let meaning = format!("{meaning}, {axis}, root frame");
            table.output(bind(i), format!("{name}.{axis}"), Some(declared), meaning);
        }
    };
    vector(&Output::AirForce, "aero.force", "Force", "force of the air on the wing");
    vector(&Output::AirMoment, "aero.moment", "Moment", "moment of the air on the wing at the origin");
    for (station, &(body, number)) in topology.stations.iter().enumerate() {
        if !air.surfaces.iter().any(|surface| surface.body == body) {
            continue;
        }
        let body = &topology.machine.bodies[body].name;
        let of = format!("of the air near station {number} of body {body}");
        let group = format!("aero.load.{body}[{number}]");
        let force = |i| Output::AirStationForce(station, i);
        vector(&force, &format!("{group}.force"), "Force", &format!("force {of}"));
        let moment = |i| Output::AirStationMoment(station, i);
        vector(&moment, &format!("{group}.moment"), "Moment", &format!("moment at the station {of}"));
    }
    if !air.reports_circulation {
        return;
    }
    let strips =
        air.surfaces.iter().flat_map(|surface| (1..surface.positions_m.len()).map(move |strip| (surface, strip)));
    for (index, (surface, strip)) in strips.enumerate() {
        let body = &topology.machine.bodies[surface.body].name;
        let meaning = format!("circulation of strip {strip} of body {body}");
        let name = format!("aero.circulation.{body}[{strip}]");
        table.output(Output::AirCirculation(index), name, Some("Circulation"), meaning);
    }
}

/// Density.
pub(super) fn parameters(table: &mut Table, topology: &Topology) {
    if topology.machine.air.is_some() {
        let text = ("aero.density".to_owned(), Some("Density"), POSITIVE, "density of the air".to_owned());
        table.parameter(Parameter::AirDensity, Variability::Tunable, text);
    }
}

/// Whether an output at a communication point feels the loads of the air, which are given functions of time there.
pub(super) fn blows(topology: &Topology, known: Binding) -> bool {
    topology.machine.air.is_some() && known == Binding::Time
}

/// Whether the loads of the air at the start depend on something: on the flow, and on where the wing stands and how
/// it moves.
pub(super) fn blows_initially(topology: &Topology, known: Binding) -> bool {
    topology.machine.air.is_some()
        && match known {
            Binding::Time => topology.machine.air.as_ref().is_some_and(|air| !air.gusts.is_empty()),
            Binding::Input(Input::Wind(_) | Input::RootAngularVelocity(_)) => true,
            Binding::Input(Input::Joint(joint, JointInput::Release)) => topology.turns_at_start(joint),
            Binding::Parameter(Parameter::AirDensity) => true,
            Binding::Parameter(Parameter::Joint(_, field)) => field == JointParameter::StartAngle,
            _ => false,
        }
}
