//! Rotors in wind: shaft with motor and generator, hub, blades of every kind, blade-element aerodynamics.

use crate::machines::draw::{Dice, Draft, Hinge, Kind, Member};
use crate::machines::model::{Form, Table, Value};
use crate::machines::view::Frame;
use nalgebra::Vector3;

/// Length of the blades, and distance of their inner ends from the apex, in m.
const LENGTH_M: f64 = 4.0;
const HUB_M: f64 = 0.5;

/// A rotor with its shaft along the root's x axis, downwind.
pub fn draw(dice: &mut Dice, draft: &mut Draft) {
    draft.end_s = 0.24;
    let rate_deg_s = dice.number(200.0, 500.0) * if dice.once_in(2) { 1.0 } else { -1.0 };
    let clockwise = rate_deg_s > 0.0;
    let tilt = Vector3::new(0.0, dice.number(-6.0, 6.0), dice.number(-10.0, 10.0));
    draft.add(
        Table::new("rigid_body.hub")
            .with("mass_kg", 40.0)
            .with("inertia_kg_m2", Value::Inertia([3.0, 2.0, 2.0, 0.0, 0.0, 0.0])),
    );
    draft.members.push(Member {
        name: "hub".to_owned(),
        kind: Kind::Rigid,
        length_m: 0.0,
        width_m: 0.0,
        stations: 1,
        copied: false,
        outlined: false,
        by_shape: false,
    });
    let mut shaft = Table::new("joint.shaft")
        .with("type", "revolute")
        .with("parent", "root")
        .with("child", "hub")
        .with("root_position_m", Value::Polar(Vector3::new(0.0, 0.0, 12.0), Frame::Root))
        .with("mount_rotation_deg", Value::TurnDeg(tilt, Frame::Root));
    // the axis is the x axis of the mounted hub
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(tilt.map(f64::to_radians));
    shaft.set("axis", Value::Axial(turn * Vector3::x(), Frame::Root));
    let prescribed = dice.once_in(3);
    let mut hinge = Hinge { name: "shaft".to_owned(), slides: false, free: !prescribed, has: Vec::new() };
    if prescribed {
        shaft.set("motion", "prescribed");
        shaft.set("polynomial_deg", vec![10.0, rate_deg_s]);
        draft.add(shaft);
    } else {
        shaft.set("start_rate_deg_s", rate_deg_s);
        draft.add(shaft);
        draft.add(Table::new("joint.shaft.motor").with("inertia_kg_m2", 20.0).with("gear_ratio", 10.0));
        hinge.has.push("drive");
        if dice.once_in(2) {
            let rpm = 10.0 * rate_deg_s / 6.0;
            let mut rows = vec![vec![0.5 * rpm, 0.0], vec![rpm, rpm.signum() * dice.number(1.0, 20.0)]];
            rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
            draft.add(Table::new("joint.shaft.generator").with("table_rpm_N_m", rows).with("efficiency", 0.93));
        }
    }
    draft.hinges.push(hinge);
    let kind = match dice.whole(0, 5) {
        0 => Kind::Rigid,
        1..=3 => Kind::Modal,
        _ => Kind::Beam,
    };
    // a rigid blade represents several
    let count = if kind == Kind::Rigid { 1 } else { dice.whole(2, 3) };
    blade(dice, draft, kind, count);
    let pitched = !dice.once_in(3);
    let mut joint = Table::new("joint.pitch")
        .with("type", if pitched { "revolute" } else { "clamped" })
        .with("parent", "hub")
        .with("parent_offset_m", Value::Polar(Vector3::new(0.0, 0.0, HUB_M), Frame::Body))
        .with("child", "blade");
    // the blade's x is along the hub's z, its z points downwind: its y is opposite to the hub's y
    let third = std::f64::consts::PI / 2f64.sqrt();
    let mount = Vector3::new(third, 0.0, third).map(f64::to_degrees);
    // a rotation by 180 degrees is its own mirror image, but has two rotation vectors
    joint.set("mount_rotation_deg", Value::TurnDeg(mount, Frame::Body));
    if pitched {
        joint.set("axis", Value::Axial(Vector3::z(), Frame::Body));
        joint.set("start_angle_deg", dice.number(-5.0, 5.0));
        draft.add(joint);
        draft.add(
            Table::new("joint.pitch.motor")
                .with("stiffness_N_m_rad", 2e4)
                .with("damping_N_m_s_rad", 200.0)
                .with("inertia_kg_m2", 2.0),
        );
        // joints and failures of copies have names with a number: only those that refer to the table itself are generated
    } else {
        draft.add(joint);
    }
    air(dice, draft, clockwise, (kind, count));
}

fn blade(dice: &mut Dice, draft: &mut Draft, kind: Kind, count: usize) {
    if kind == Kind::Rigid {
        draft.add(
            Table::new("rigid_body.blade")
                .with("mass_kg", 20.0)
                .with("centre_of_mass_m", Value::Polar(Vector3::new(1.6, 0.0, 0.0), Frame::Body))
                .with("inertia_kg_m2", Value::Inertia([0.3, 25.0, 25.2, 0.0, 0.0, 0.0])),
        );
    } else if kind == Kind::Modal {
        let mut table = Table::new("modal_body.blade")
            .with("count", count)
            .with("length_m", LENGTH_M)
            .with("nodes", dice.whole(5, 8))
            .with("stations", vec![0.0, 1.0])
            .with("mass_kg_m", vec![8.0, 3.0])
            .with("flap_stiffness_N_m2", vec![2e5, 2e4])
            .with("edge_stiffness_N_m2", vec![8e5, 8e4])
            .with("flap_shapes", vec![vec![1.5, -0.5]])
            .with("edge_shapes", vec![vec![1.5, -0.5]])
            .with("flap_damping_ratios", vec![0.01])
            .with("edge_damping_ratios", vec![0.01]);
        if dice.once_in(2) {
            table.set("twist_deg", vec![Value::Odd(-10.0), Value::Odd(0.0)]);
        }
        draft.add(table);
    } else {
        draft.add(
            Table::new("section.spar")
                .with("shape", "explicit")
                .with("axial_stiffness_N", 1e8)
                .with("torsional_rigidity_N_m2", 5e4)
                .with("flap_stiffness_N_m2", 1e5)
                .with("edge_stiffness_N_m2", 4e5)
                .with("coupling_twist_flap_N_m2", Value::Odd(dice.number(-5e3, 5e3)))
                .with("mass_kg_m", 6.0)
                .with("second_moments_kg_m", Value::List(vec![0.1.into(), Value::Odd(0.0), 0.01.into()])),
        );
        draft.add(
            Table::new("body.blade")
                .with("count", count)
                .with("length_m", LENGTH_M)
                .with("section", "spar")
                .with("elements", dice.whole(1, 2))
                .with("stiffness_damping_s", 1e-3),
        );
    }
    draft.members.push(Member {
        name: "blade".to_owned(),
        kind,
        length_m: LENGTH_M,
        width_m: 0.4,
        stations: usize::from(kind == Kind::Rigid),
        copied: kind != Kind::Rigid,
        outlined: false,
        by_shape: false,
    });
}

fn air(dice: &mut Dice, draft: &mut Draft, clockwise: bool, (kind, count): (Kind, usize)) {
    let wind = Vector3::new(dice.number(6.0, 14.0), dice.number(-1.0, 1.0), dice.number(-1.0, 1.0));
    let mut table = Table::new("aerodynamics")
        .with("model", "bem")
        .with("hub", "hub")
        .with("hub_radius_m", HUB_M)
        .with("rotation_direction", Value::Clockwise(clockwise))
        .with("wind_m_s", Value::Polar(wind, Frame::Root))
        .with("step_s", 0.01);
    table.set("coupling", dice.pick(&["staggered", "iterated"]));
    let lagged = dice.once_in(5);
    if lagged {
        table.set("inflow_lag_s", dice.number(0.1, 0.5));
    } else {
        for key in ["skewed_wake", "dynamic_inflow"] {
            if dice.once_in(2) {
                table.set(key, true);
            }
        }
    }
    match dice.whole(0, 3) {
        0 => table.set("dynamic_stall", true),
        1 => table.set("pitch_rate", dice.pick(&["hub", "air", "none"])),
        _ => {}
    }
    if !lagged && dice.once_in(3) {
        table.set("end_loads", dice.pick(&["full_induction", "zero"]));
    }
    if !lagged && dice.once_in(6) {
        table.set("aerodyn_compatible", true);
    }
    if dice.once_in(5) {
        // the axis in the hub's frame, given explicitly
        table.set("shaft_axis", Value::Polar(Vector3::x(), Frame::Body));
    }
    if kind == Kind::Rigid {
        table.set("blades", 3usize);
    } else if dice.once_in(5) {
        table.set("blades", 2 * count);
    }
    if dice.once_in(3) {
        table.set("density_kg_m3", dice.number(0.9, 1.3));
    }
    if dice.once_in(4) {
        table.set("load_interpolation", dice.pick(&["piecewise_constant", "linear"]));
    }
    draft.add(table);
    let stations = vec![0.0, 0.8, 2.0, 3.2, LENGTH_M];
    let mut surface = Table::new("surface.blade")
        .with("body", "blade")
        .with("chord_m", Value::Function(Form::Table, vec![vec![0.0, 0.5], vec![LENGTH_M, 0.25]], false))
        .with("elastic_axis_fraction", dice.number(0.25, 0.35))
        .with("leading_edge", Value::Leading(clockwise))
        .with("incidence_deg", Value::Function(Form::Table, vec![vec![0.0, -15.0], vec![LENGTH_M, -1.0]], false))
        .with("stations_m", stations)
        .with("polars", vec!["foil"; 5]);
    if kind == Kind::Rigid {
        surface.set("length_m", LENGTH_M);
    }
    draft.add(surface);
    let mut foil = Table::new("polar.foil");
    if dice.once_in(2) {
        let row = |degree: f64, lift: f64, drag: f64| vec![degree, lift, drag, -0.03];
        foil.set(
            "rows",
            vec![row(-10.0, -0.8, 0.02), row(0.0, 0.3, 0.008), row(6.0, 0.95, 0.01), row(12.0, 1.3, 0.03)],
        );
        foil.set("aspect_ratio", 12.0);
        foil.set("pressure_shift_deg", 20.0);
    } else {
        let mut rows = Vec::new();
        for degree in (-180..=180).step_by(12) {
            let angle = f64::from(degree).to_radians();
            let attached = 1.0 / (1.0 + ((f64::from(degree).abs() - 15.0) / 2.0).exp());
            let lift = attached * 0.1 * (f64::from(degree) + 3.0) + (1.0 - attached) * 1.6 * angle.sin() * angle.cos();
            let round = |x: f64| (1e3 * x).round() / 1e3;
            rows.push(vec![f64::from(degree), round(lift), round(0.01 + 1.2 * angle.sin().powi(2)), -0.03]);
        }
        foil.set("rows", rows);
    }
    draft.add(foil);
    if dice.once_in(3) {
        let mut field = Table::new("wind")
            .with("up", Value::Polar(Vector3::z(), Frame::Root))
            .with("downwind", Value::Polar(Vector3::x(), Frame::Root))
            .with("ground_m", Value::Polar(Vector3::zeros(), Frame::Root))
            .with("reference_height_m", 12.0);
        match dice.whole(0, 3) {
            0 => field.set("shear_exponent", 0.2),
            1 => field.set("roughness_m", 0.03),
            2 => {
                // instead of the wind input
                for (key, value) in
                    &mut draft.tables.iter_mut().find(|table| table.name == "aerodynamics").expect("air").keys
                {
                    if *key == "wind_m_s" {
                        *value = Value::Polar(Vector3::zeros(), Frame::Root);
                    }
                }
                draft.add(
                    Table::new("wind.turbulence")
                        .with("seed", dice.whole(0, 99))
                        .with("mean_m_s", dice.number(8.0, 14.0))
                        .with("standard_deviation_m_s", dice.number(0.5, 2.0))
                        .with("points", vec![4usize, 4])
                        .with("spacing_m", vec![5.0, 5.0])
                        .with("planes", 16usize)
                        .with("plane_interval_s", 0.05),
                );
            }
            _ => {
                let row = |time_s: f64, speed: f64, degree: f64, vertical: f64, across: f64| {
                    Value::List(vec![
                        time_s.into(),
                        speed.into(),
                        Value::Odd(degree),
                        vertical.into(),
                        Value::Odd(across),
                        0.1.into(),
                        0.02.into(),
                        0.0.into(),
                    ])
                };
                field.set("table", Value::List(vec![row(0.0, 0.0, 0.0, 0.0, 0.0), row(0.1, 2.0, 5.0, 0.2, 0.05)]));
                field.set("reference_length_m", 9.0);
            }
        }
        draft.add(field);
    }
    if dice.once_in(3) {
        draft.add(
            Table::new("tower")
                .with("base_m", Value::Polar(Vector3::new(2.0, 0.0, 0.0), Frame::Root))
                .with("up", Value::Polar(Vector3::z(), Frame::Root))
                .with("rows", vec![vec![0.0, 0.8, 1.0], vec![12.0, 0.5, 1.0]])
                .with("potential", dice.pick(&["none", "cylinder", "bak"]))
                .with("shadow", dice.pick(&["none", "powles"])),
        );
    }
}
