//! Machines with rigid loops: linkages, and trees whose bodies are joined at arbitrary points.
//!
//! They have a separate range of seeds, so that the machines of all other seeds do not change.

use crate::machines::air;
use crate::machines::draw::{Dice, Draft, Kind, begin, body, end, joint, linkage};
use crate::machines::model::{Model, Table, Value};
use crate::machines::view::{Frame, View};
use foldwing::config;
use foldwing::machine::Machine;
use foldwing::machine::pose::{along, first_frames};
use nalgebra::{Matrix3, Vector3};

/// Machines of this seed and above have rigid loops.
pub const RIGID: u64 = 2_000_000;

/// A machine with rigid loops.
pub fn draw(seed: u64) -> Model {
    let mut dice = Dice(fastrand::Rng::with_seed(seed));
    let mut draft = begin(&mut dice);
    if dice.once_in(4) {
        linkage(&mut dice, &mut draft);
        // the tie to the root stays soft: with a rigid one the linkage could not move
        let pins = ["loop.l0", "loop.l1"];
        for table in draft.tables.iter_mut().filter(|table| pins.contains(&table.name.as_str())) {
            table.keys.retain(|(key, _)| matches!(*key, "bodies" | "positions_m" | "offsets_m"));
            table.set("rigid", true);
        }
        draft.loops.retain(|name| name == "l2");
        return end(&mut dice, draft, seed);
    }
    tree(&mut dice, &mut draft);
    match dice.whole(0, 4) {
        0 => air::strips(&mut dice, &mut draft),
        1 => air::lattice(&mut dice, &mut draft),
        _ => {}
    }
    let mut ends = Vec::new();
    let is_free = draft.tables.iter().any(|table| table.is("type", "free"));
    for _ in 0..dice.whole(1, 2) {
        ends.extend(pair(&mut dice, &draft, is_free));
    }
    let model = end(&mut dice, draft, seed);
    closed(model, ends)
}

/// Two to four bodies, at least one of them a beam.
pub(super) fn tree(dice: &mut Dice, draft: &mut Draft) {
    for index in 0..dice.whole(2, 4) {
        let kind = match dice.whole(0, 5) {
            _ if index == 0 => Kind::Beam,
            0 | 1 => Kind::Rigid,
            2 => Kind::Modal,
            _ => Kind::Beam,
        };
        let parent = (index > 0 && !dice.once_in(4)).then(|| dice.whole(0, index - 1));
        body(dice, draft, kind, None, None);
        joint(dice, draft, parent);
    }
}

/// A point of a loop: its body, `None` on the root, its position along the body and its offset.
pub(super) struct End {
    pub body: Option<usize>,
    pub position_m: f64,
    pub offset_m: Vector3<f64>,
}

/// An arbitrary point of a body.
pub(super) fn on_body(dice: &mut Dice, draft: &Draft, index: usize) -> End {
    let member = &draft.members[index];
    let position_m = match member.kind {
        Kind::Beam => (member.length_m * dice.number(0.3, 1.0)).min(member.length_m),
        Kind::Modal => member.length_m,
        Kind::Rigid => 0.0,
    };
    End { body: Some(index), position_m, offset_m: dice.vector(0.05) }
}

/// Two points on different bodies, or on a body and the root; the offset of the second one follows from the pose.
fn pair(dice: &mut Dice, draft: &Draft, is_free: bool) -> Option<[End; 2]> {
    let last = draft.members.len() - 1;
    let first = dice.whole(0, last);
    // a machine in free flight is not held by the root
    let second = if dice.once_in(3) && !is_free { None } else { Some(dice.whole(0, last)) };
    let mut point = |index: Option<usize>| {
        let position_m = match index.map(|index| &draft.members[index]) {
            Some(member) if member.kind == Kind::Beam => (member.length_m * dice.number(0.3, 1.0)).min(member.length_m),
            Some(member) if member.kind == Kind::Modal => member.length_m,
            _ => 0.0,
        };
        End { body: index, position_m, offset_m: dice.vector(0.05) }
    };
    let ends = [point(Some(first)), point(second)];
    (second != Some(first)).then_some(ends)
}

/// The model with loops between points that coincide in the pose of its start.
fn closed(mut model: Model, loops: Vec<[End; 2]>) -> Model {
    // a machine that is refused without the loops is refused with them
    let Ok(machine) = config::parse(&model.text(&View::plain()), "machine.toml") else { return model };
    let at = model.tables.len() - 1;
    for (number, [mut first, mut second]) in loops.into_iter().enumerate() {
        let point = position_m(&machine, &first);
        second.offset_m = offset_m(&machine, &second, point);
        if number > 0 {
            std::mem::swap(&mut first, &mut second);
        }
        let ends = [first, second];
        let mut table = Table::new(format!("loop.r{number}")).with("rigid", true);
        let name = |end: &End| end.body.map_or_else(|| "root".to_owned(), |body| format!("b{body}"));
        table.set("bodies", Value::List(ends.iter().map(|end| name(end).into()).collect()));
        table.set("positions_m", ends.iter().map(|end| end.position_m).collect::<Vec<f64>>());
        let frame = |end: &End| if end.body.is_some() { Frame::Body } else { Frame::Root };
        table.set("offsets_m", Value::List(ends.iter().map(|end| Value::Polar(end.offset_m, frame(end))).collect()));
        model.tables.insert(at, table);
    }
    model
}

/// Frame of a section of a machine in its start pose.
fn frame(machine: &Machine, end: &End) -> Option<foldwing::machine::pose::Frame> {
    // bodies are sorted outward, whatever their order in the file
    let name = format!("b{}", end.body?);
    let index = machine.bodies.iter().position(|body| body.name == name)?;
    let firsts = first_frames(&machine.bodies, |joint| joint.start_angle_rad);
    Some(along(&machine.bodies[index], &firsts[index], end.position_m))
}

/// Attitude of its section, and position of a point, in the root frame and in m.
pub(super) fn placed(machine: &Machine, end: &End) -> (Matrix3<f64>, Vector3<f64>) {
    let attitude = frame(machine, end).map_or_else(Matrix3::identity, |frame| frame.attitude);
    (attitude, position_m(machine, end))
}

/// Position of a point in the root frame in m.
fn position_m(machine: &Machine, end: &End) -> Vector3<f64> {
    frame(machine, end).map_or(end.offset_m, |frame| frame.position_m + frame.attitude * end.offset_m)
}

/// Offset of an end that is at a point of the root frame, in m.
fn offset_m(machine: &Machine, end: &End, point: Vector3<f64>) -> Vector3<f64> {
    frame(machine, end).map_or(point, |frame| frame.attitude.transpose() * (point - frame.position_m))
}

/// The model without a start in equilibrium, under a condition.
pub(super) fn without_equilibrium(mut model: Model, condition: impl Fn(&Model) -> bool) -> Model {
    if condition(&model) {
        for table in &mut model.tables {
            table.keys.retain(|(key, value)| !(*key == "start" && *value == Value::from("equilibrium")));
        }
    }
    model
}
