//! Machines with DC motors, in a separate range of seeds.

use crate::machines::draw::{Dice, draw as draw_other};
use crate::machines::model::{Model, Table};
use crate::machines::rigid::RIGID;
use crate::machines::sliding::SLIDING;

/// Machines of this seed and above have DC motors.
pub const DC_MOTORS: u64 = 5_000_000;

/// A machine of another range of seeds, with DC motors on most of its free revolute, prismatic and sliding joints; machines without
/// such a joint are unchanged.
pub fn draw(seed: u64) -> Model {
    let own = seed - DC_MOTORS;
    let mut model = draw_other(match own % 8 {
        6 => SLIDING + own,
        7 => RIGID + own,
        _ => own,
    });
    let mut dice = Dice(fastrand::Rng::with_seed(seed));
    let of_joint = |table: &&Table| {
        table.name.strip_prefix("joint.").is_some_and(|name| !name.contains('.'))
            && !table.is("motion", "locked")
            && !table.is("motion", "prescribed")
    };
    let joints: Vec<(usize, String, bool)> = model
        .tables
        .iter()
        .enumerate()
        .filter(|(_, table)| of_joint(table))
        .filter_map(|(place, table)| {
            let slides = table.is("type", "prismatic") || table.is("type", "sliding");
            (slides || table.is("type", "revolute")).then(|| (place, table.name.clone(), slides))
        })
        .collect();
    for (place, name, slides) in joints.into_iter().rev() {
        if dice.once_in(4) {
            continue;
        }
        let constant = dice.size(0.1, 0.4);
        let resistance = dice.size(0.5, 5.0);
        let mut table = Table::new(format!("{name}.dc_motor"))
            .with("resistance_ohm", resistance)
            // electrical time constants from 0.2 ms to 20 ms
            .with("inductance_H", resistance * dice.size(2e-4, 2e-2));
        match slides {
            true => table.set("force_constant_N_A", 10.0 * constant),
            false => table.set("torque_constant_N_m_A", constant / 5.0),
        }
        if !dice.once_in(4) {
            table.set("voltage_V", dice.number(-3.0, 3.0));
        }
        if dice.once_in(3) {
            table.set("start_current_A", dice.number(-0.5, 0.5));
        }
        let joint = name.trim_start_matches("joint.").to_owned();
        // a motor that loses its torque cannot be an electrical one
        model.tables.retain(|table| !(table.is("kind", "motor_loss") && table.is("joint", &joint)));
        let place = model.tables.iter().position(|table| table.name == name).unwrap_or(place);
        model.tables.insert(place + 1, table);
    }
    model.seed = seed;
    model
}
