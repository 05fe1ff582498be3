//! Machines with bodies that slide along a beam, some of them in the air of strips or of a vortex lattice, some with a skate or a wheel.
//!
//! They have a separate range of seeds, so that the machines of all other seeds do not change.

use crate::machines::air;
use crate::machines::draw::{Dice, Draft, Kind, Member, begin, body, end, joint, one_freedom};
use crate::machines::model::{Model, Table, Value};
use crate::machines::no_slip::with_runners;
use crate::machines::rigid::on_body;
use crate::machines::view::Frame;
use nalgebra::Vector3;

/// Machines of this seed and above have sliding joints.
pub const SLIDING: u64 = 1_000_000;

/// A machine with a beam, free or on a joint, and one or two bodies that slide along it.
pub fn draw(seed: u64) -> Model {
    let mut dice = Dice(fastrand::Rng::with_seed(seed));
    let mut draft = begin(&mut dice);
    let carrier = dice.once_in(4).then(|| {
        body(&mut dice, &mut draft, Kind::Rigid, None, None);
        joint(&mut dice, &mut draft, None);
        0
    });
    let beam = draft.members.len();
    body(&mut dice, &mut draft, Kind::Beam, None, None);
    let elements = dice.whole(2, 5);
    let is_constant = dice.once_in(3);
    let table = draft.tables.last_mut().expect("the beam");
    table.keys.retain(|(key, _)| !matches!(*key, "elements" | "element"));
    table.set("elements", elements);
    table.set("element", if is_constant { "constant" } else { "linear" });
    joint(&mut dice, &mut draft, carrier);
    if dice.once_in(4) {
        body(&mut dice, &mut draft, Kind::Rigid, None, None);
        joint(&mut dice, &mut draft, Some(beam));
    }
    for _ in 0..dice.whole(1, 2) {
        rider(&mut dice, &mut draft, (beam, elements));
    }
    // without a random number of the tree, so that it is unchanged
    let mut others = Dice(fastrand::Rng::with_seed(seed ^ 0x00a1_7000));
    match seed % 4 {
        1 => air::strips(&mut others, &mut draft),
        3 => air::lattice(&mut others, &mut draft),
        _ => {}
    }
    let last = draft.members.len() - 1;
    let runners = if seed % 6 == 2 { vec![on_body(&mut others, &draft, last)] } else { Vec::new() };
    let mut model = end(&mut dice, draft, seed);
    allowed(&mut model, if is_constant { None } else { Some(beam) });
    with_runners(&mut others, model, runners)
}

/// A body on a sliding joint: a point mass, a rigid body in any attitude, a beam, or a massless carriage with a body on a joint.
fn rider(dice: &mut Dice, draft: &mut Draft, (beam, elements): (usize, usize)) {
    let index = draft.members.len();
    let name = format!("b{index}");
    let kind = dice.whole(0, 5);
    let mut member = Member {
        name: name.clone(),
        kind: Kind::Rigid,
        length_m: 0.0,
        width_m: 0.0,
        stations: 0,
        copied: false,
        outlined: false,
        by_shape: false,
    };
    match kind {
        0..=2 => body(dice, draft, Kind::Rigid, None, None),
        3 | 4 => {
            draft.add(Table::new(format!("rigid_body.{name}")));
            draft.members.push(member);
        }
        _ => {
            // without shear: the slopes of a beam with shear have independent velocities, for which no impulse is derived
            let section = format!("s{index}");
            member.width_m = dice.number(0.02, 0.04);
            draft.add(
                Table::new(format!("section.{section}"))
                    .with("shape", "rectangle")
                    .with("width_m", member.width_m)
                    .with("height_m", dice.number(0.003, 0.006))
                    .with("density_kg_m3", 2000.0)
                    .with("youngs_modulus_Pa", dice.size(3e9, 7e10))
                    .with("poisson_ratio", 0.3),
            );
            member.length_m = dice.number(0.1, 0.2);
            let table = Table::new(format!("body.{name}"))
                .with("length_m", member.length_m)
                .with("section", section)
                .with("elements", dice.whole(1, 2))
                .with("load_stations", 1_usize)
                .with("stiffness_damping_s", dice.size(1e-4, 1e-3));
            draft.add(table);
            (member.kind, member.stations) = (Kind::Beam, 1);
            draft.members.push(member);
        }
    }
    if kind == 3 {
        let offset = dice.vector(0.03);
        draft.add(
            Table::new(format!("mass.m{index}"))
                .with("body", name.as_str())
                .with("position_m", 0.0)
                .with("mass_kg", dice.number(0.05, 0.3))
                .with("offset_m", Value::Polar(offset, Frame::Body)),
        );
    }
    slide(dice, draft, (beam, elements), &name);
    if kind <= 2 {
        attitude(draft, index);
    }
    if kind == 4 {
        body(dice, draft, Kind::Rigid, None, None);
        joint(dice, draft, Some(index));
    }
}

/// Attitude of a rigid body on its sliding joint, without drawing a random number, so that everything else is unchanged.
fn attitude(draft: &mut Draft, index: usize) {
    let name = format!("joint.j{index}");
    let joint = draft.tables.iter_mut().find(|table| table.name == name).expect("the joint");
    let digits = (1e3 * joint.number("start_position_m").abs()).round() as u64;
    match digits % 4 {
        0 => joint.set("attitude", "section"),
        1 => {
            joint.set("attitude", "hinge");
            // not along one of the axes
            let axis = Vector3::new(0.2, 1.0, 0.1 * (digits % 7) as f64);
            joint.set("axis", Value::Axial(axis, Frame::Body));
            joint.set("start_angle_deg", 10.0 * (digits % 5) as f64);
            joint.set("start_rate_deg_s", -30.0 * (digits % 3) as f64);
        }
        2 => {
            joint.set("attitude", "ball");
            let spin = Vector3::new(40.0, -20.0, 10.0 * (digits % 5) as f64);
            joint.set("start_angular_velocity_deg_s", Value::Axial(spin, Frame::Body));
        }
        _ => {}
    }
}

/// The sliding joint of a body: drawn as a prismatic joint, with all its positions shifted to near an element boundary.
fn slide(dice: &mut Dice, draft: &mut Draft, (beam, elements): (usize, usize), child: &str) {
    let (length_m, parent) = (draft.members[beam].length_m, draft.members[beam].name.clone());
    let name = format!("joint.j{}", child.trim_start_matches('b'));
    let mut table = Table::new(name.as_str()).with("type", "sliding").with("parent", parent).with("child", child);
    if dice.once_in(3) {
        let arm = dice.vector(0.05);
        table.set("parent_offset_m", Value::Polar(arm, Frame::Body));
    }
    if dice.once_in(2) {
        let mount = dice.vector(40.0);
        table.set("mount_rotation_deg", Value::TurnDeg(mount, Frame::Body));
    }
    one_freedom(dice, draft, table, true);
    // from one side of a boundary towards the other
    let border = dice.whole(1, elements - 1) as f64;
    let side = if dice.once_in(2) { 1.0 } else { -1.0 };
    let [from, to] = [border - side * dice.number(0.02, 0.5), border + side * dice.number(0.2, 1.2)]
        .map(|place| (place / elements as f64).clamp(0.05, 0.95));
    // rounded, so that the file is easy to read
    let digits = |x: f64| (x * 1e3).round() / 1e3;
    let (start_m, rate_m_s) = (digits(from * length_m), digits((to - from) * length_m / draft.end_s));
    let has_stopper =
        draft.tables.iter().any(|own| own.name == name && (own.has("release") || own.is("motion", "locked")));
    let own = |table: &&mut Table| table.name == name || table.name.starts_with(&format!("{name}."));
    let drawn_m =
        draft.tables.iter().find(|table| table.name == name).map_or(0.0, |table| table.number("start_position_m"));
    for table in draft.tables.iter_mut().filter(own) {
        let moves = table.has("start_rate_m_s");
        move_along(table, start_m - drawn_m);
        if let Some((_, Value::List(law))) = table.keys.iter_mut().find(|(key, _)| *key == "polynomial_m") {
            law[1] = rate_m_s.into();
        }
        if table.name.ends_with(".motor") && !table.has("command_m") {
            // instead of the inner end
            table.set("command_m", digits(to * length_m));
        }
        if table.name == name && !has_stopper && !table.is("motion", "prescribed") {
            // most of them cross a boundary; a latch that is closed at the start permits no motion
            table.keys.retain(|(key, _)| *key != "start_rate_m_s");
            if moves || !dice.once_in(4) {
                table.set("start_rate_m_s", rate_m_s);
            }
        }
    }
    let is_held = draft.tables.iter().any(|table| table.name == format!("{name}.latch") && table.is("kind", "rigid"));
    if is_held {
        let joint = draft.tables.iter_mut().find(|table| table.name == name).expect("the joint");
        joint.keys.retain(|(key, _)| *key != "start_rate_m_s");
    }
}

/// Keys of positions along the beam, in tables of a joint and of failures.
const POSITIONS: [&str; 9] = [
    "start_position_m",
    "command_m",
    "rest_position_m",
    "position_m",
    "upper_m",
    "lower_m",
    "to_m",
    "position_above_m",
    "position_below_m",
];

/// Adds a length to all positions of a table.
fn move_along(table: &mut Table, by_m: f64) {
    let moved = |value: &Value| match value {
        Value::Plain(text) => Value::from(((text.parse::<f64>().expect("a number") + by_m) * 1e6).round() / 1e6),
        other => unreachable!("{other:?} is no position"),
    };
    for (key, value) in &mut table.keys {
        match (*key, value) {
            (key, value) if POSITIONS.contains(&key) => *value = moved(value),
            ("polynomial_m", Value::List(coefficients)) => coefficients[0] = moved(&coefficients[0]),
            ("table_s_m", Value::List(rows)) => {
                for row in rows {
                    if let Value::List(row) = row {
                        row[1] = moved(&row[1]);
                    }
                }
            }
            _ => {}
        }
    }
}

/// Removes parts that are not supported with sliding joints: damped modes, and gauges on the beam if its elements are linear; also starts in
/// equilibrium, which bodies that slide freely do not have. Shifts the bounds of failures to the positions of the joints.
fn allowed(model: &mut Model, beam_of_pairs: Option<usize>) {
    let starts: Vec<(String, f64)> = (model.tables.iter())
        .filter(|table| table.is("type", "sliding"))
        .map(|table| {
            let start_m = table.number("start_position_m");
            (table.name.trim_start_matches("joint.").to_owned(), start_m)
        })
        .collect();
    let beam = beam_of_pairs.map(|beam| format!("b{beam}"));
    model.tables.retain(|table| {
        !(table.name.starts_with("gauge.") && beam.as_ref().is_some_and(|beam| table.is("body", beam)))
    });
    for table in &mut model.tables {
        table.keys.retain(|(key, value)| {
            *key != "modal_damping_ratios" && !(*key == "start" && *value == Value::from("equilibrium"))
        });
        if let Some((_, start_m)) =
            starts.iter().find(|(name, _)| table.name.starts_with("failure.") && table.is("joint", name))
        {
            move_along(table, *start_m);
        }
    }
}
