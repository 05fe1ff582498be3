//! Rows of models with aerodynamics, and their dependencies.

use crate::interface::Variability;
use crate::interface::cause::{Cause, Depends};
use crate::interface::known::{Input, JointInput, JointParameter, Known, Parameter};
use crate::interface::table::{POSITIVE, Shape, Table, Text, Type, wrench, wrench_texts};
use crate::interface::topology::Topology;
use foldwing_engine::plant::{FlapInputs, FlapOutputs, OutputSet, RotorLoads};
use std::mem::offset_of;

/// Wind.
pub(super) fn inputs(table: &mut Table, topology: &Topology) {
    if topology.machine.air.is_some() {
        let place = table.inputs.layout().wind_m_s.place(0, 0);
        let meaning = "wind velocity relative to the root's origin, {}, root frame";
        let text = Text::new("wind.velocity", meaning);
        table.input(Input::Wind, place, Shape::Vector, Type::Real("Velocity"), text);
    }
}

/// Angles of control surfaces and their rates.
pub(super) fn flap_inputs(table: &mut Table, topology: &Topology) {
    let layout = *table.inputs.layout();
    for (index, flap) in topology.machine.air.iter().flat_map(|air| &air.flaps).enumerate() {
        let name = &flap.name;
        let at = |offset| layout.flaps.place(index, offset);
        let meaning = format!(
            "control surface {name}: commanded angle, positive with the trailing edge towards -z of the section"
        );
        let text = Text::new(format!("aero.control_surface.{name}.angle_command"), meaning);
        let place = at(offset_of!(FlapInputs, command_rad));
        table.input(Input::Flap(index), place, Shape::Scalar, Type::Real("Angle"), text);
        let meaning = format!("control surface {name}: time derivative of the commanded angle; supply it consistently");
        let text = Text::new(format!("aero.control_surface.{name}.angle_command_rate"), meaning);
        let place = at(offset_of!(FlapInputs, command_rate_rad_s));
        table.input(Input::FlapRate(index), place, Shape::Scalar, Type::Real("AngularVelocity"), text);
    }
}

/// Angles, rates and hinge moments of control surfaces.
fn flap_outputs(table: &mut Table, index: usize, name: &str) {
    let layout = table.outputs;
    let at = |offset| (layout.flaps.place(index, offset), OutputSet::AIR);
    let own = |cause| Depends::new([cause], [cause]).settling(false);
    let text = Text::new(format!("aero.control_surface.{name}.angle"), format!("control surface {name}: angle"));
    table.output(at(offset_of!(FlapOutputs, angle_rad)), Shape::Scalar, "Angle", own(Cause::Flap(index)), text);
    let text =
        Text::new(format!("aero.control_surface.{name}.rate"), format!("control surface {name}: rate of the angle"));
    let rate = own(Cause::FlapRate(index));
    table.output(at(offset_of!(FlapOutputs, rate_rad_s)), Shape::Scalar, "AngularVelocity", rate, text);
    let meaning =
        format!("control surface {name}: aerodynamic hinge moment, positive in the direction of positive angles");
    let text = Text::new(format!("aero.control_surface.{name}.hinge_moment"), meaning);
    let air = Depends::new([Cause::Air], [Cause::AirStart]);
    table.output(at(offset_of!(FlapOutputs, hinge_moment_n_m)), Shape::Scalar, "Moment", air, text);
}

/// Aerodynamic loads, and circulations on request.
pub(super) fn outputs(table: &mut Table, topology: &Topology) {
    let Some(air) = &topology.machine.air else { return };
    let layout = table.outputs;
    let depends = Depends::new([Cause::Air], [Cause::AirStart]);
    let force = "aerodynamic force on the wing, {}, root frame";
    let moment = "aerodynamic moment on the wing about the origin, {}, root frame";
    let texts = wrench_texts("aero", [force, moment]);
    wrench(table, (layout.air_total.place(0, 0), OutputSet::AIR), &depends, texts);
    for (station, &(body, number)) in topology.stations.iter().enumerate() {
        if !air.loads_body(body) {
            continue;
        }
        let body = &topology.machine.bodies[body].name;
        let of = format!("lumped at station {number} of body {body}, {{}}, root frame");
        let of_all = format!("lumped at the stations of body {body}, {{}}, root frame");
        let [force, moment] = wrench_texts(
            &format!("aero.load.{body}[{number}]"),
            [&format!("aerodynamic force {of}"), &format!("aerodynamic moment {of}")],
        );
        let texts = [
            force.in_array(format!("aero.load.{body}.force"), format!("aerodynamic force {of_all}")),
            moment.in_array(format!("aero.load.{body}.moment"), format!("aerodynamic moment {of_all}")),
        ];
        let at = (layout.air_stations.place(station, 0), OutputSet::AIR);
        wrench(table, at, &depends, texts);
    }
    for (index, (part, _)) in air.rotors().enumerate() {
        let rotor = match part.name.as_str() {
            "" => "rotor".to_owned(),
            name => format!("rotor.{name}"),
        };
        let rows: [(&str, usize, &str, &str); 8] = [
            (
                "thrust",
                offset_of!(RotorLoads, thrust_n),
                "Force",
                "aerodynamic thrust along the shaft, positive downwind",
            ),
            (
                "torque",
                offset_of!(RotorLoads, torque_n_m),
                "Moment",
                "aerodynamic torque about the shaft, positive if it drives the rotor",
            ),
            ("power", offset_of!(RotorLoads, power_w), "Power", "aerodynamic power of the rotor"),
            (
                "speed",
                offset_of!(RotorLoads, speed_rad_s),
                "AngularVelocity",
                "rotational speed of the hub about the shaft",
            ),
            (
                "wind",
                offset_of!(RotorLoads, wind_m_s),
                "Velocity",
                "mean wind component along the shaft over the sections of all blades",
            ),
            (
                "power_coefficient",
                offset_of!(RotorLoads, power_coefficient),
                "Ratio",
                "rotor power divided by the power of the axial wind through the rotor disc; 0 if the axial wind is \
                 less than 1 % of the relative air speed at the tips",
            ),
            (
                "thrust_coefficient",
                offset_of!(RotorLoads, thrust_coefficient),
                "Ratio",
                "thrust divided by the product of dynamic pressure of the axial wind and disc area; 0 under the same \
                 condition as the power coefficient",
            ),
            (
                "tip_speed_ratio",
                offset_of!(RotorLoads, tip_speed_ratio),
                "Ratio",
                "speed of the outermost sections divided by the axial wind speed; 0 under the same condition as the \
                 power coefficient",
            ),
        ];
        for (name, offset, kind, meaning) in rows {
            let at = (layout.rotor.place(index, offset), OutputSet::AIR);
            table.output(at, Shape::Scalar, kind, depends.clone(), Text::new(format!("{rotor}.{name}"), meaning));
        }
    }
    for (index, flap) in air.flaps.iter().enumerate() {
        flap_outputs(table, index, &flap.name);
    }
    if !air.reports_circulation {
        return;
    }
    let strips =
        air.surfaces.iter().flat_map(|surface| (1..surface.positions_m.len()).map(move |strip| (surface, strip)));
    for (index, (surface, strip)) in strips.enumerate() {
        let body = &topology.machine.bodies[surface.body].name;
        let name = format!("aero.circulation.{body}[{strip}]");
        let text = Text::new(name, format!("circulation of strip {strip} of body {body}"))
            .in_array(format!("aero.circulation.{body}"), format!("circulation of the strips of body {body}"));
        let at = (layout.circulation_m2_s.place(index, 0), OutputSet::AIR);
        table.output(at, Shape::Scalar, "Circulation", depends.clone(), text);
    }
}

/// Density.
pub(super) fn parameters(table: &mut Table, topology: &Topology) {
    if topology.machine.air.is_some() {
        let place = table.parameters.layout().air_density_kg_m3.place(0, 0);
        let text = Text::new("aero.density", "air density");
        table.parameter(Parameter::AirDensity, place, Variability::Tunable, "Density", POSITIVE, text);
    }
}

/// Returns whether outputs at a communication point depend on a known through the aerodynamic loads, which are given functions
/// of time there.
pub(super) fn blows(topology: &Topology, known: Known) -> bool {
    topology.machine.air.is_some() && known == Known::Time
}

/// Returns whether the aerodynamic loads at the start depend on a known, which may change the flow or the position and motion of
/// the wing.
pub(super) fn blows_initially(topology: &Topology, known: Known) -> bool {
    topology.machine.air.is_some()
        && match known {
            Known::Time => topology.machine.air.as_ref().is_some_and(|air| !air.gusts.is_empty()),
            Known::Input(Input::Wind | Input::RootAngularVelocity | Input::Flap(_) | Input::FlapRate(_)) => true,
            Known::Input(Input::Joint(joint, JointInput::Release)) => topology.turns_at_start(joint),
            Known::Parameter(Parameter::AirDensity) => true,
            Known::Parameter(Parameter::Joint(_, field)) => field == JointParameter::StartAngle,
            Known::Input(_) | Known::Parameter(_) => false,
        }
}
