//! Machines with cylindrical joints, in a separate range of seeds.

use crate::machines::draw::{Dice, Draft, draw as draw_other, one_freedom};
use crate::machines::model::{Model, Table, Value};

/// Machines of this seed and above have cylindrical joints.
pub const CYLINDRICAL: u64 = 6_000_000;

/// Keys of a joint that stay with it; all others are those of its degree of freedom.
const COMMON: [&str; 9] = [
    "type",
    "parent",
    "child",
    "axis",
    "parent_position_m",
    "parent_frame",
    "parent_offset_m",
    "root_position_m",
    "mount_rotation_deg",
];

/// A machine of the first range of seeds without rotor and loops, whose revolute and prismatic joints are cylindrical: the degree of freedom
/// of each is one of the two, and the other one is drawn; machines without such joints are unchanged.
pub fn draw(seed: u64) -> Model {
    let mut dice = Dice(fastrand::Rng::with_seed(seed));
    let mut model = (0..)
        .map(|k| draw_other(3 * (seed - CYLINDRICAL) + 1_000 * k))
        .find(|model| {
            !model.has("loop") && !model.has("rotor") && !model.tables.iter().any(|own| own.is("model", "rotor"))
        })
        .expect("a tree");
    let joints: Vec<(String, bool)> = (model.tables.iter())
        .filter(|table| table.is("type", "revolute") || table.is("type", "prismatic"))
        .map(|table| (table.name.clone(), table.is("type", "prismatic")))
        .collect();
    for (name, slides) in joints {
        cylindrical(&mut dice, &mut model, &name, slides);
    }
    if seed.is_multiple_of(8) {
        electrical(&mut dice, &mut model);
    }
    // a free translation or rotation without stiffness has no equilibrium
    for table in &mut model.tables {
        table.keys.retain(|(key, value)| !(*key == "start" && *value == Value::from("equilibrium")));
    }
    model.seed = seed;
    model
}

/// Adds a DC motor to each free degree of freedom of the cylindrical joints.
fn electrical(dice: &mut Dice, model: &mut Model) {
    for (part, constant) in [("translation", "force_constant_N_A"), ("rotation", "torque_constant_N_m_A")] {
        let of_part =
            |table: &&Table| table.name.starts_with("joint.") && table.name.ends_with(part) && !table.has("motion");
        let names: Vec<String> = model.tables.iter().filter(of_part).map(|table| table.name.clone()).collect();
        for name in names {
            let (resistance, value) = (dice.size(0.5, 5.0), dice.size(0.1, 0.4));
            let motor = Table::new(format!("{name}.dc_motor"))
                .with("resistance_ohm", resistance)
                .with("inductance_H", resistance * dice.size(2e-4, 2e-2))
                .with(constant, if part == "translation" { 10.0 * value } else { value / 5.0 })
                .with("voltage_V", dice.number(-3.0, 3.0));
            let joint = name.trim_start_matches("joint.").replace('.', "_");
            // a motor that loses its torque cannot be an electrical one
            let lost = |table: &Table| table.is("kind", "motor_loss") && table.is("joint", &joint);
            while let Some(index) = model.tables.iter().position(lost) {
                *model = model.without(index);
            }
            let place = model.tables.iter().position(|table| table.name == name).expect("the table");
            model.tables.insert(place + 1, motor);
        }
    }
}

/// Makes a joint cylindrical.
fn cylindrical(dice: &mut Dice, model: &mut Model, name: &str, slides: bool) {
    let part = |slides| format!("{name}.{}", if slides { "translation" } else { "rotation" });
    let mut own = Table::new(part(slides));
    let mut tables = Vec::new();
    for mut table in std::mem::take(&mut model.tables) {
        if table.name == name {
            let (common, of_freedom) = table.keys.drain(..).partition(|(key, _)| COMMON.contains(key));
            (table.keys, own.keys) = (common, of_freedom);
            let kind = table.keys.iter_mut().find(|(key, _)| *key == "type").expect("a type");
            kind.1 = Value::from("cylindrical");
            tables.push(table);
            tables.push(std::mem::replace(&mut own, Table::new("")));
            continue;
        }
        if let Some(inner) = table.name.strip_prefix(&format!("{name}.")) {
            table.name = format!("{}.{inner}", part(slides));
        }
        // failures and their triggers
        let (joint, freedom) =
            (name.trim_start_matches("joint."), part(slides).replace("joint.", "").replace('.', "_"));
        for (key, value) in &mut table.keys {
            if *key == "joint" && *value == Value::from(joint) {
                *value = Value::from(freedom.as_str());
            }
        }
        tables.push(table);
    }
    model.tables = tables;
    let mut draft = Draft {
        tables: Vec::new(),
        members: Vec::new(),
        hinges: Vec::new(),
        loops: Vec::new(),
        start_s: 0.0,
        end_s: 0.0,
    };
    one_freedom(dice, &mut draft, Table::new(part(!slides)), !slides);
    let place = model.tables.iter().position(|table| table.name == name).expect("the joint");
    model.tables.splice(place + 1..place + 1, draft.tables);
}
