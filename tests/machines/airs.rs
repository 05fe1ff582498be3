//! Machines with several aerodynamic models, in a separate range of seeds: two rotors, one on the root and one on a beam, mostly strips on
//! the beam, and a slender body on the beam or a hub; some have strips and a pod at the tip as a slender body, and no rotor.

use crate::machines::draw::{Dice, Draft, begin, end};
use crate::machines::model::{Form, Model, Table, Value};
use crate::machines::rigid::without_equilibrium;
use crate::machines::view::Frame;
use nalgebra::{UnitQuaternion, Vector3};

/// Machines of this seed and above have several aerodynamic models.
pub const AIRS: u64 = 4_000_000;

/// Length of the wing and of the blades, and distance of the blades from the apex, in m.
const WING_M: f64 = 2.5;
const BLADE_M: f64 = 0.7;
const HUB_M: f64 = 0.15;

/// A wing along the root's y axis, with a rotor on it and one on the root; x is downwind.
pub fn draw(seed: u64) -> Model {
    let mut dice = Dice(fastrand::Rng::with_seed(seed));
    let mut draft = begin(&mut dice);
    draft.end_s = 0.12;
    let winged = !dice.once_in(3);
    let podded = winged && Dice(fastrand::Rng::with_seed(!seed ^ 1)).once_in(3);
    wing(&mut dice, &mut draft, winged);
    let mut common = Table::new("aerodynamics")
        .with("wind_m_s", {
            let aside = dice.vector(1.0);
            Value::Polar(Vector3::new(dice.number(8.0, 16.0), aside.y, aside.z), Frame::Root)
        })
        .with("step_s", dice.number(2e-3, 4e-3));
    common.set("coupling", dice.pick(&["iterated", "iterated", "staggered"]));
    if dice.once_in(3) {
        common.set("density_kg_m3", dice.number(0.8, 1.3));
    }
    if dice.once_in(3) {
        common.set("report_circulation", true);
    }
    draft.add(common);
    if winged {
        draft.add(strips(&mut dice));
    }
    let mut of_body = Dice(fastrand::Rng::with_seed(!seed));
    if podded {
        pod(&mut dice, &mut draft);
        slender_body(&mut of_body, &mut draft, Some("pod"));
        return without_equilibrium(end(&mut dice, draft, seed), |_| true);
    }
    rotor(&mut dice, &mut draft, 0);
    rotor(&mut dice, &mut draft, 1);
    slender_body(&mut of_body, &mut draft, winged.then_some("hub0"));
    let row = |degree: f64, lift: f64, drag: f64| vec![degree, lift, drag, -0.03];
    draft.add(
        Table::new("polar.foil").with("aspect_ratio", 12.0).with("pressure_shift_deg", 20.0).with(
            "rows",
            vec![row(-10.0, -0.8, 0.02), row(0.0, 0.3, 0.008), row(6.0, 0.95, 0.01), row(12.0, 1.3, 0.03)],
        ),
    );
    // rotating machines are in no equilibrium
    without_equilibrium(end(&mut dice, draft, seed), |_| true)
}

fn wing(dice: &mut Dice, draft: &mut Draft, winged: bool) {
    draft.add(
        Table::new("section.spar")
            .with("shape", "explicit")
            .with("axial_stiffness_N", 2e7)
            .with("torsional_rigidity_N_m2", dice.size(2e3, 2e4))
            .with("flap_stiffness_N_m2", dice.size(5e3, 5e4))
            .with("edge_stiffness_N_m2", 1e5)
            .with("coupling_twist_flap_N_m2", Value::Odd(dice.number(-300.0, 300.0)))
            .with("mass_kg_m", 4.0)
            .with("second_moments_kg_m", Value::List(vec![0.05.into(), Value::Odd(0.0), 0.01.into()])),
    );
    draft.add(
        Table::new("body.wing")
            .with("section", "spar")
            .with("length_m", WING_M)
            .with("elements", dice.whole(1, 2))
            .with("stiffness_damping_s", 1e-3)
            .with("load_stations", 2usize),
    );
    let mount = Vector3::new(dice.number(-5.0, 5.0), 0.0, 90.0);
    draft.add(
        Table::new("joint.wing")
            .with("type", "clamped")
            .with("parent", "root")
            .with("child", "wing")
            .with("mount_rotation_deg", Value::TurnDeg(mount, Frame::Root)),
    );
    if !winged {
        return;
    }
    let mut surface = Table::new("surface.wing")
        .with("body", "wing")
        .with("leading_edge", Value::Leading(true))
        .with("strips", dice.whole(2, 4))
        .with("chord_m", 0.4)
        .with("elastic_axis_fraction", dice.number(0.25, 0.5));
    let ends = [dice.number(-3.0, 6.0), dice.number(-3.0, 6.0)];
    let incidence = dice.along(WING_M, ends, false);
    surface.set("incidence_deg", incidence);
    draft.add(surface);
    if dice.once_in(2) {
        draft.add(
            Table::new("control_surface.a1")
                .with("body", "wing")
                .with("from_m", 0.5 * WING_M)
                .with("to_m", WING_M)
                .with("hinge_fraction", 0.7)
                .with("command_deg", dice.number(-5.0, 5.0)),
        );
    }
}

/// A rigid pod along the wind at the tip, on a hinge with a spring or clamped.
fn pod(dice: &mut Dice, draft: &mut Draft) {
    draft.add(
        Table::new("rigid_body.pod")
            .with("mass_kg", dice.number(1.0, 4.0))
            .with("inertia_kg_m2", Value::Inertia([0.06, 0.2, 0.2, 0.0, 0.0, 0.0])),
    );
    let hinged = dice.once_in(2);
    let mut joint = Table::new("joint.pod")
        .with("type", if hinged { "revolute" } else { "clamped" })
        .with("parent", "wing")
        .with("child", "pod")
        .with("mount_rotation_deg", Value::TurnDeg(Vector3::new(0.0, 0.0, -90.0), Frame::Body));
    if hinged {
        joint.set("axis", Value::Axial(Vector3::x(), Frame::Body));
        joint.set("start_rate_deg_s", dice.number(-60.0, 60.0));
    }
    draft.add(joint);
    if hinged {
        draft.add(
            Table::new("joint.pod.motor")
                .with("stiffness_N_m_rad", dice.size(30.0, 300.0))
                .with("damping_N_m_s_rad", dice.number(0.1, 1.0)),
        );
    }
}

/// A slender body on a rigid body, or on the beam where that has no surface; its numbers leave the others as they are.
fn slender_body(dice: &mut Dice, draft: &mut Draft, on: Option<&str>) {
    let (body, from, to) = match on {
        Some(body) => (body, -0.3, dice.number(0.1, 0.4)),
        None => ("wing", dice.number(0.0, 0.5), WING_M),
    };
    let middle = from + dice.number(0.2, 0.8) * (to - from);
    let open = if dice.once_in(2) { 0.05 } else { 0.0 };
    let rows = vec![vec![from, 0.0], vec![middle, dice.number(0.06, 0.12)], vec![to, open]];
    let mut table =
        Table::new("aerodynamics.hull").with("model", "slender_body").with("body", body).with("radius_m", rows);
    if dice.once_in(2) {
        table.set("segments", dice.whole(2, 6));
    }
    if dice.once_in(2) {
        table.set("cross_flow_drag_coefficient", dice.number(0.5, 1.2));
    }
    if dice.once_in(2) {
        table.set("axial_drag_coefficient", dice.number(0.05, 0.3));
    }
    if dice.once_in(4) {
        table.set("apparent_mass", false);
    }
    draft.add(table);
}

fn strips(dice: &mut Dice) -> Table {
    let mut table = Table::new("aerodynamics.wing").with("model", "strip");
    match dice.whole(0, 5) {
        0 => {
            table.set("tip_loss", "lifting_line");
            if dice.once_in(2) {
                table.set("core_radius_m", dice.size(1e-4, 1e-3));
            }
            if dice.once_in(2) {
                table.set("mirror_normal", Value::Polar(Vector3::y(), Frame::Root));
            }
        }
        1 => table.set("speed_of_sound_m_s", 340.0),
        2 => table.set("quasi_steady", true),
        3 => table.set("indicial", dice.pick(&["fine", "jones"])),
        4 => table.set("tip_loss", "none"),
        _ => {}
    }
    if dice.once_in(4) {
        table.set("apparent_mass", false);
    }
    if dice.once_in(4) {
        table.set("leading_edge_suction", false);
    }
    table
}

/// A rotor of a few blades, which one rigid blade represents: the first on the wing, the second on the root.
fn rotor(dice: &mut Dice, draft: &mut Draft, number: usize) {
    let rate_deg_s = dice.number(1500.0, 3500.0) * if dice.once_in(2) { 1.0 } else { -1.0 };
    let clockwise = rate_deg_s > 0.0;
    draft.add(
        Table::new(format!("rigid_body.hub{number}"))
            .with("mass_kg", 2.0)
            .with("inertia_kg_m2", Value::Inertia([0.06, 0.05, 0.05, 0.0, 0.0, 0.0])),
    );
    let mut shaft =
        Table::new(format!("joint.shaft{number}")).with("type", "revolute").with("child", format!("hub{number}"));
    // the axis is the x axis of the mounted hub
    let (mount, frame) = if number == 0 {
        shaft.set("parent", "wing");
        shaft.set("parent_position_m", dice.number(0.5, 1.0) * WING_M);
        shaft.set("parent_offset_m", Value::Polar(Vector3::new(0.0, 0.4, 0.0), Frame::Body));
        (Vector3::new(0.0, 0.0, -90.0), Frame::Body)
    } else {
        shaft.set("parent", "root");
        shaft.set("root_position_m", Value::Polar(Vector3::new(0.5, -2.0, 1.0), Frame::Root));
        (Vector3::new(0.0, dice.number(-6.0, 6.0), dice.number(-10.0, 10.0)), Frame::Root)
    };
    let axis = UnitQuaternion::from_scaled_axis(mount.map(f64::to_radians)) * Vector3::x();
    shaft.set("mount_rotation_deg", Value::TurnDeg(mount, frame));
    shaft.set("axis", Value::Axial(axis, frame));
    let prescribed = dice.once_in(3);
    if prescribed {
        shaft.set("motion", "prescribed");
        shaft.set("polynomial_deg", vec![10.0, rate_deg_s]);
        draft.add(shaft);
    } else {
        shaft.set("start_rate_deg_s", rate_deg_s);
        draft.add(shaft);
        // a drive whose torque falls with the speed
        let damping = 0.05;
        let torque = -1.2 * damping * rate_deg_s.to_radians();
        draft.add(
            Table::new(format!("joint.shaft{number}.motor"))
                .with("damping_N_m_s_rad", damping)
                .with("constant_torque_N_m", torque)
                .with("inertia_kg_m2", 0.05),
        );
    }
    let name = format!("blade{number}");
    draft.add(
        Table::new(format!("rigid_body.{name}"))
            .with("mass_kg", 0.2)
            .with("centre_of_mass_m", Value::Polar(Vector3::new(0.25, 0.0, 0.0), Frame::Body))
            .with("inertia_kg_m2", Value::Inertia([1e-4, 0.01, 0.01, 0.0, 0.0, 0.0])),
    );
    // the blade's x is along the hub's z, its z points downwind: a rotation by 180 degrees, its own mirror image with two rotation vectors
    let third = (std::f64::consts::PI / 2f64.sqrt()).to_degrees();
    draft.add(
        Table::new(format!("joint.root{number}"))
            .with("type", "clamped")
            .with("parent", format!("hub{number}"))
            .with("parent_offset_m", Value::Polar(Vector3::new(0.0, 0.0, HUB_M), Frame::Body))
            .with("child", name.as_str())
            .with("mount_rotation_deg", Value::TurnDeg(Vector3::new(third, 0.0, third), Frame::Body)),
    );
    draft.add(
        Table::new(format!("surface.{name}"))
            .with("body", name.as_str())
            .with("length_m", BLADE_M)
            .with("chord_m", 0.09)
            .with("elastic_axis_fraction", 0.25)
            .with("leading_edge", Value::Leading(clockwise))
            .with("incidence_deg", Value::Function(Form::Table, vec![vec![0.0, -40.0], vec![BLADE_M, -14.0]], false))
            .with("stations_m", vec![0.0, 0.2, 0.45, BLADE_M])
            .with("polars", vec!["foil"; 4]),
    );
    draft.add(part(dice, number, clockwise));
}

fn part(dice: &mut Dice, number: usize, clockwise: bool) -> Table {
    let mut table = Table::new(format!("aerodynamics.rotor{number}"))
        .with("model", "bem")
        .with("hub", format!("hub{number}"))
        .with("hub_radius_m", HUB_M)
        .with("rotation_direction", Value::Clockwise(clockwise))
        .with("blades", dice.whole(2, 4));
    let lagged = dice.once_in(4);
    if lagged {
        table.set("inflow_lag_s", dice.number(0.05, 0.2));
    } else {
        for key in ["skewed_wake", "dynamic_inflow"] {
            if dice.once_in(2) {
                table.set(key, true);
            }
        }
        if dice.once_in(3) {
            table.set("end_loads", dice.pick(&["full_induction", "zero"]));
        }
        if dice.once_in(6) {
            table.set("aerodyn_compatible", true);
        }
    }
    match dice.whole(0, 2) {
        0 => table.set("dynamic_stall", true),
        1 => table.set("pitch_rate", dice.pick(&["hub", "air", "none"])),
        _ => {}
    }
    if dice.once_in(4) {
        table.set("shaft_axis", Value::Polar(Vector3::x(), Frame::Body));
    }
    if dice.once_in(3) {
        table.set("load_interpolation", dice.pick(&["piecewise_constant", "linear"]));
    }
    table
}
