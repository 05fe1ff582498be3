//! Sections by shape, replacing some rectangles and ellipses.

use crate::machines::draw::{Dice, Draft};
use crate::machines::model::{Form, Table, Value};

/// Materials of the library for the shapes that accept any.
const MATERIALS: [&str; 4] = ["aluminium 7075-T6", "steel 4130", "GFRP E-glass/epoxy", "polycarbonate"];

/// Replaces the section of a body of constant section by one given by its shape, for a third of them. Uses a separate random generator,
/// seeded by width and length, so that machines without such a section are unchanged. Returns whether it did.
pub fn instead(draft: &mut Draft, name: &str, width_m: f64, length_m: f64) -> bool {
    let mut dice = Dice(fastrand::Rng::with_seed(width_m.to_bits() ^ length_m.to_bits().rotate_left(17)));
    if !dice.once_in(3) {
        return false;
    }
    let named = format!("section.{name}");
    let Some(place) = draft.tables.iter().position(|table| table.name == named) else { return false };
    let material = material(&mut dice, draft, name);
    let table = Table::new(named.as_str());
    let mut spar = None;
    let drawn = match dice.whole(0, 5) {
        0 => table
            .with("shape", "tube")
            .with("diameter_m", dimension(&mut dice, 0.4 * width_m, length_m))
            .with("wall_m", dimension(&mut dice, 0.001, length_m))
            .with("material", material),
        kind @ 1..=3 => {
            let mut table = table
                .with("shape", ["box", "I", "C"][kind - 1])
                .with("width_m", dimension(&mut dice, 0.6 * width_m, length_m))
                .with("height_m", dimension(&mut dice, 0.3 * width_m, length_m))
                .with("wall_m", dimension(&mut dice, 0.001, length_m))
                .with("material", material);
            if dice.once_in(2) {
                table.set("web_wall_m", dimension(&mut dice, 0.0015, length_m));
            }
            // its mirror image is open on the other side
            if kind == 3 {
                table.set("open_side", Value::Leading(dice.once_in(2)));
            }
            table
        }
        4 => {
            let mut table = table
                .with("shape", "profile")
                .with("chord_m", dimension(&mut dice, 1.5 * width_m, length_m))
                .with("skin_wall_m", dimension(&mut dice, 0.0005, length_m))
                .with("material", material)
                .with("leading_edge", Value::Leading(dice.once_in(2)));
            if dice.once_in(2) {
                table.set("aerofoil", dice.pick(&["naca0012", "naca2412", "naca4415"]));
            } else {
                let outline =
                    [[1.0, 0.0], [0.7, 0.05], [0.3, 0.08], [0.0, 0.0], [0.3, -0.05], [0.7, -0.03], [1.0, 0.0]];
                table.set("outline", outline.map(|point| point.to_vec()).to_vec());
            }
            if dice.once_in(2) {
                let mut web = Table::new(format!("section.{name}.spar.web"))
                    .with("position", dice.number(0.25, 0.5))
                    .with("wall_m", dimension(&mut dice, 0.001, length_m));
                if dice.once_in(2) {
                    web.set("material", "balsa");
                }
                spar = Some(web);
            }
            table
        }
        _ => laminate(&mut dice, table, width_m),
    };
    draft.tables[place] = drawn;
    if let Some(spar) = spar {
        draft.tables.insert(place + 1, spar);
    }
    true
}

/// A symmetric laminate without in-plane shear coupling: pairs of plies at opposite angles.
fn laminate(dice: &mut Dice, table: Table, width_m: f64) -> Table {
    let angle_deg = dice.number(10.0, 60.0);
    let plies: Vec<Value> = [0.0, angle_deg, -angle_deg].into_iter().map(Value::Odd).collect();
    let count = plies.len();
    let mut table = table
        .with("shape", "laminate")
        .with("width_m", width_m)
        .with("layup_deg", Value::List(plies))
        .with("symmetric", true);
    if dice.once_in(2) {
        table.set("ply_thickness_m", 0.0005);
    } else {
        table.set("ply_thicknesses_m", vec![0.0004, 0.0006, 0.0006]);
    }
    if dice.once_in(2) {
        table.set("ply_materials", vec!["CFRP AS4/3501-6"; count]);
    } else {
        table.set("material", "GFRP E-glass/epoxy");
    }
    table
}

/// The name of a material of the library, or of one defined in the model.
fn material(dice: &mut Dice, draft: &mut Draft, section: &str) -> String {
    if dice.once_in(2) {
        return dice.pick(&MATERIALS).to_owned();
    }
    let (name, young) = (format!("m{section}"), dice.size(3e9, 7e10));
    let mut table = Table::new(format!("material.{name}"))
        .with("youngs_modulus_Pa", young)
        .with("density_kg_m3", dice.number(1000.0, 2700.0));
    match dice.whole(0, 2) {
        0 => table.set("poisson_ratio", 0.3),
        1 => table.set("shear_modulus_Pa", 0.4 * young),
        _ => {
            table.set("shear_modulus_Pa", 0.1 * young);
            table.set("transverse_youngs_modulus_Pa", 0.2 * young);
            table.set("transverse_shear_modulus_Pa", 0.08 * young);
            table.set("poisson_ratio", 0.3);
        }
    }
    draft.add(table);
    name
}

/// A dimension that is constant, or decreases to four fifths at the outer end.
fn dimension(dice: &mut Dice, inner_m: f64, length_m: f64) -> Value {
    match dice.whole(0, 2) {
        0 => inner_m.into(),
        1 => Value::Function(Form::Polynomial, vec![vec![inner_m, -0.2 * inner_m / length_m]], false),
        _ => Value::Function(Form::Table, vec![vec![0.0, inner_m], vec![length_m, 0.8 * inner_m]], false),
    }
}
