//! Machines with skates and wheels, in a separate range of seeds.

use crate::machines::air;
use crate::machines::draw::{Dice, begin, end};
use crate::machines::model::{Model, Table, Value};
use crate::machines::rigid::{End, on_body, placed, tree, without_equilibrium};
use crate::machines::view::{Frame, View};
use foldwing::config;
use nalgebra::Vector3;

/// Machines of this seed and above have skates and wheels.
pub const NO_SLIP: u64 = 3_000_000;

/// A machine with one or two skates and wheels on planes through their points.
pub fn draw(seed: u64) -> Model {
    let mut dice = Dice(fastrand::Rng::with_seed(seed));
    let mut draft = begin(&mut dice);
    tree(&mut dice, &mut draft);
    let members = draft.members.len();
    let ends: Vec<End> = (0..dice.whole(1, 2)).map(|_| on_body(&mut dice, &draft, dice_index(seed, members))).collect();
    // without a random number of the tree, so that it is unchanged
    let mut others = Dice(fastrand::Rng::with_seed(seed ^ 0x00a1_7000));
    match seed % 4 {
        1 => air::strips(&mut others, &mut draft),
        3 => air::lattice(&mut others, &mut draft),
        _ => {}
    }
    let model = without_equilibrium(end(&mut dice, draft, seed), |_| true);
    with_runners(&mut dice, model, ends)
}

/// A model with a skate or a wheel at each of the points, on a plane through it.
pub(super) fn with_runners(dice: &mut Dice, mut model: Model, ends: Vec<End>) -> Model {
    if ends.is_empty() {
        return model;
    }
    // a machine that is refused without the constraints is refused with them
    let Ok(machine) = config::parse(&model.text(&View::plain()), "machine.toml") else { return model };
    let at = model.tables.len() - 1;
    for (number, own) in ends.into_iter().enumerate() {
        let normal = unit(dice);
        let direction = unit(dice);
        let (attitude, point) = placed(&machine, &own);
        let is_wheel = dice.once_in(2);
        let mut table = Table::new(format!("{}.n{number}", if is_wheel { "wheel" } else { "skate" }));
        table.set("body", format!("b{}", own.body.expect("on a body")));
        if own.position_m > 0.0 || dice.once_in(2) {
            table.set("position_m", own.position_m);
        }
        table.set("offset_m", Value::Polar(own.offset_m, Frame::Body));
        table.set("plane_normal", Value::Polar(normal * dice.number(0.5, 2.0), Frame::Root));
        let mut contact = point;
        if is_wheel {
            let axis = attitude * direction;
            let radius_m = dice.number(0.02, 0.3);
            contact -= (normal - axis * axis.dot(&normal)).normalize() * radius_m;
            table.set("axis", Value::Axial(direction, Frame::Body));
            table.set("radius_m", radius_m);
            table.set("rolling", dice.once_in(2));
        } else {
            table.set("direction", Value::Polar(direction, Frame::Body));
        }
        table.set("plane_point_m", Value::Polar(contact, Frame::Root));
        table.set("hold_normal", !dice.once_in(3));
        model.tables.insert(at, table);
    }
    model
}

/// Body of a constraint: one of the outer ones rather than the first.
fn dice_index(seed: u64, members: usize) -> usize {
    members - 1 - usize::try_from(seed % 2).expect("0 or 1").min(members - 1)
}

fn unit(dice: &mut Dice) -> Vector3<f64> {
    loop {
        let vector = dice.vector(1.0);
        if vector.norm() > 0.1 {
            return vector.normalize();
        }
    }
}
