//! Aerodynamics with strips or a vortex lattice for the beams of a tree.

use crate::machines::draw::{Dice, Draft, Kind};
use crate::machines::model::{Table, Value};
use crate::machines::view::Frame;
use nalgebra::Vector3;

fn wind(dice: &mut Dice) -> Vector3<f64> {
    let sign = if dice.once_in(2) { 1.0 } else { -1.0 };
    Vector3::new(dice.number(-1.0, 1.0), sign * dice.number(3.0, 12.0), dice.number(-1.0, 1.0))
}

/// Adds surfaces to the beams; returns their number.
fn surfaces(dice: &mut Dice, draft: &mut Draft, lattice: bool, may_have_polars: bool) -> usize {
    let mut tables = Vec::new();
    for member in draft.members.iter().filter(|member| member.kind == Kind::Beam) {
        let strips = dice.whole(2, 3);
        let mut table = Table::new(format!("surface.{}", member.name))
            .with("body", member.name.as_str())
            .with("leading_edge", Value::Leading(dice.once_in(2)))
            .with("strips", strips);
        let width_m = member.width_m;
        let mut set = |key: &'static str, low: f64, high: f64| {
            let ends = [dice.number(low, high), dice.number(low, high)];
            table.set(key, dice.along(member.length_m, ends, false));
        };
        set("chord_m", 1.0 * width_m, 2.0 * width_m);
        set("elastic_axis_fraction", 0.25, 0.5);
        set("incidence_deg", -5.0, 5.0);
        if lattice {
            table.set("chord_panels", 2usize);
            if dice.once_in(4) {
                let flare = dice.number(-20.0, 20.0);
                let flare = dice.along(member.length_m, [flare, flare], false);
                table.set("flare_deg", flare);
            }
            if may_have_polars && dice.once_in(2) {
                table.set("polar", polar(dice));
            }
        } else if may_have_polars && dice.once_in(3) {
            table.set("polar", polar(dice));
        } else if may_have_polars {
            table.set("zero_lift_angle_deg", dice.number(-2.0, 0.0));
            if dice.once_in(2) {
                let slope = [dice.number(5.0, 6.3), dice.number(5.0, 6.3)];
                let slope = dice.along(member.length_m, slope, false);
                table.set("lift_slope_1_rad", slope);
            }
            table.set("moment_coefficient", dice.number(-0.05, 0.0));
            table.set("drag_coefficient", dice.number(0.0, 0.02));
        }
        tables.push(table);
        if dice.once_in(3) {
            let end_m = member.length_m;
            let mut flap = Table::new(format!("control_surface.a{}", tables.len()))
                .with("body", member.name.as_str())
                .with("from_m", 0.5 * end_m)
                .with("to_m", end_m)
                .with("hinge_fraction", if lattice { 0.5 } else { dice.number(0.6, 0.8) })
                .with("command_deg", dice.number(-5.0, 5.0));
            if dice.once_in(3) {
                // beyond the commands of a run
                flap = flap.with("lower_deg", -20.0).with("upper_deg", 25.0);
            }
            tables.push(flap);
        }
    }
    let count = tables.iter().filter(|table| table.name.starts_with("surface")).count();
    tables.into_iter().for_each(|table| draft.add(table));
    count
}

/// A cambered aerofoil for all angles, whose lift falls beyond stall by a fifth to a half.
fn polar(dice: &mut Dice) -> Vec<Vec<f64>> {
    let left = dice.number(0.5, 0.8);
    let row = |degree: f64, lift: f64, drag: f64| vec![degree, lift, drag, -0.02];
    vec![
        row(-180.0, 0.0, 0.05),
        row(-90.0, 0.0, 1.2),
        row(-22.0, -0.9 * left, 0.25),
        row(-12.0, -0.9, 0.03),
        row(0.0, 0.2, 0.01),
        row(12.0, 1.2, 0.03),
        row(22.0, 1.2 * left, 0.25),
        row(90.0, 0.0, 1.2),
        row(180.0, 0.0, 0.05),
    ]
}

fn gust(dice: &mut Dice, draft: &mut Draft) {
    if !dice.once_in(3) {
        return;
    }
    let (mut velocity, mut way, origin) = (dice.vector(1.0), dice.vector(1.0), dice.vector(0.2));
    let shape = dice.pick(&["sharp_edge", "one_minus_cosine", "table", "dryden", "von_karman"]);
    if matches!(shape, "dryden" | "von_karman") {
        // their spectra differ along and normal to the flight path
        (velocity, way) =
            if dice.once_in(2) { (Vector3::z(), Vector3::zeros()) } else { (Vector3::y(), Vector3::zeros()) };
    }
    let mut table = Table::new("gust.u0")
        .with("shape", shape)
        .with("velocity_m_s", Value::Polar(velocity, Frame::Root))
        .with("direction", Value::Polar(way + Vector3::new(0.0, 2.0, 0.0), Frame::Root))
        .with("speed_m_s", dice.number(3.0, 12.0))
        .with("origin_m", Value::Polar(origin, Frame::Root));
    match shape {
        "one_minus_cosine" => table.set("length_m", dice.number(0.1, 1.0)),
        "table" => table.set("table", vec![vec![0.0, 0.0], vec![0.1, 1.0], vec![0.3, -0.5]]),
        "dryden" | "von_karman" => {
            table = table.with("scale_m", dice.number(0.5, 2.0)).with("seed", dice.whole(0, 99));
            if dice.once_in(3) {
                table.set("resolution_m", 0.01);
            }
        }
        _ => {}
    }
    if dice.once_in(3) {
        table.set("start_s", draft.start_s + dice.number(0.0, 0.3) * draft.end_s);
    }
    draft.add(table);
}

fn aerodynamics(dice: &mut Dice, model: &str) -> Table {
    let wind = wind(dice);
    let mut table = Table::new("aerodynamics")
        .with("model", model)
        .with("wind_m_s", Value::Polar(wind, Frame::Root))
        .with("step_s", dice.number(2e-3, 4e-3))
        .with("coupling_tolerance", dice.size(1e-8, 1e-6));
    if dice.once_in(2) {
        table.set("steady_initial_flow", false);
    }
    if dice.once_in(4) {
        table.set("coupling_iterations", 100usize);
    }
    if dice.once_in(3) {
        table.set("density_kg_m3", dice.number(0.5, 1.3));
    }
    if dice.once_in(3) {
        table.set("report_circulation", true);
    }
    table
}

pub fn strips(dice: &mut Dice, draft: &mut Draft) {
    let mut table = aerodynamics(dice, "strip");
    let mut may_have_polars = true;
    match dice.whole(0, 5) {
        0 => {
            table.set("tip_loss", "lifting_line");
            if dice.once_in(3) {
                table.set("core_radius_m", dice.size(1e-4, 1e-3));
            }
            may_have_polars = false;
            if dice.once_in(3) {
                table.set("mirror_normal", Value::Polar(Vector3::new(1.0, 0.0, 0.0), Frame::Root));
            }
        }
        1 => {
            table.set("speed_of_sound_m_s", 340.0);
            may_have_polars = false;
        }
        2 => table.set("quasi_steady", true),
        3 => table.set("indicial", dice.pick(&["fine", "jones"])),
        4 => table.set("tip_loss", "none"),
        _ => {}
    }
    if dice.once_in(5) {
        table.set("apparent_mass", false);
    }
    if surfaces(dice, draft, false, may_have_polars) > 0 {
        draft.add(table);
        gust(dice, draft);
    }
}

pub fn lattice(dice: &mut Dice, draft: &mut Draft) {
    let mut table = aerodynamics(dice, "uvlm").with("wake_rows", dice.whole(4, 8));
    if dice.once_in(4) {
        table.set("threads", 2usize);
    }
    if dice.once_in(4) {
        table.set("core_radius_m", dice.size(1e-4, 1e-3));
    }
    if dice.once_in(2) {
        table.set("free_wake", true);
    }
    // the lift and drag of a polar include the suction
    let has_suction = dice.once_in(2);
    if has_suction {
        table.set("leading_edge_suction", true);
    }
    if dice.once_in(4) {
        table.set("ground_normal", Value::Polar(Vector3::new(0.0, 0.0, 1.0), Frame::Root));
        table.set("ground_distance_m", dice.number(2.0, 4.0));
    }
    if surfaces(dice, draft, true, has_suction) > 0 {
        draft.add(table);
        gust(dice, draft);
    }
}
