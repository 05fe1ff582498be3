//! Machines of ordinary dimensions: bodies in a tree, their joints, attachments and failures.

use crate::machines::airs::{self, AIRS};
use crate::machines::course::{Action, Doing};
use crate::machines::cylindrical::{self, CYLINDRICAL};
use crate::machines::dc_motor::{self, DC_MOTORS};
use crate::machines::model::{Form, Model, Table, Value};
use crate::machines::no_slip::{self, NO_SLIP};
use crate::machines::rigid::{self, RIGID};
use crate::machines::sliding::{self, SLIDING};
use crate::machines::view::Frame;
use crate::machines::{air, rotor, shaped};
use nalgebra::Vector3;

/// Number of communication steps of a run: the slowest motions of these machines take a few tenths of a second.
pub const STEPS: usize = 24;

/// Draws random numbers of two digits, which are easy to read in the smallest machine that fails.
pub struct Dice(pub fastrand::Rng);

impl Dice {
    /// True once in `many` times.
    pub fn once_in(&mut self, many: usize) -> bool {
        self.0.usize(..many) == 0
    }

    pub fn whole(&mut self, least: usize, most: usize) -> usize {
        self.0.usize(least..=most)
    }

    pub fn number(&mut self, least: f64, most: f64) -> f64 {
        let x = least + (most - least) * self.0.f64();
        format!("{x:.1e}").parse::<f64>().expect("a number").clamp(least, most)
    }

    /// Random number, uniform on a logarithmic scale.
    pub fn size(&mut self, least: f64, most: f64) -> f64 {
        let x = least * (most / least).powf(self.0.f64());
        format!("{x:.1e}").parse::<f64>().expect("a number").clamp(least, most)
    }

    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.number(-size, size))
    }

    /// A function along a body from one value to another, in any of its forms; the constant form has the first value.
    pub fn along(&mut self, length_m: f64, [from, to]: [f64; 2], odd: bool) -> Value {
        match self.whole(0, 2) {
            0 => Value::Function(Form::Number, vec![vec![from]], odd),
            1 => Value::Function(Form::Polynomial, vec![vec![from, (to - from) / length_m]], odd),
            _ => Value::Function(Form::Table, vec![vec![0.0, from], vec![0.6 * length_m, to]], odd),
        }
    }

    pub fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.0.usize(..list.len())]
    }
}

/// Data of a body for the tables that follow.
pub struct Member {
    pub name: String,
    pub kind: Kind,
    pub length_m: f64,
    pub width_m: f64,
    pub stations: usize,
    /// Generated with `count`: its copies have other names.
    pub copied: bool,
    /// A beam whose section is an outline of one material: gauges may lie in any direction.
    pub outlined: bool,
    /// A beam whose section is a tube, a box or another of `shaped`: half as high as wide, or lower.
    pub by_shape: bool,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Beam,
    Rigid,
    Modal,
}

/// Data of a joint for the tables that follow.
pub struct Hinge {
    pub name: String,
    pub slides: bool,
    /// Whether it moves freely, so that its motion may trigger failures.
    pub free: bool,
    pub has: Vec<&'static str>,
}

/// A machine under construction.
pub struct Draft {
    pub tables: Vec<Table>,
    pub members: Vec<Member>,
    pub hinges: Vec<Hinge>,
    pub loops: Vec<String>,
    pub start_s: f64,
    /// Duration of the run in s.
    pub end_s: f64,
}

impl Draft {
    pub fn add(&mut self, table: Table) {
        self.tables.push(table);
    }

    pub fn top(&mut self) -> &mut Table {
        &mut self.tables[0]
    }
}

/// A machine from a seed, reproducible; seeds from [`SLIDING`] on give machines with sliding joints, those from [`RIGID`] on machines with rigid
/// loops, those from [`NO_SLIP`] on machines with skates and wheels, those from [`AIRS`] on machines with several aerodynamic models,
/// those from [`DC_MOTORS`] on machines with DC motors, those from [`CYLINDRICAL`] on machines with cylindrical joints.
pub fn draw(seed: u64) -> Model {
    if seed >= CYLINDRICAL {
        return cylindrical::draw(seed);
    }
    if seed >= DC_MOTORS {
        return dc_motor::draw(seed);
    }
    if seed >= AIRS {
        return airs::draw(seed);
    }
    if seed >= NO_SLIP {
        return no_slip::draw(seed);
    }
    if seed >= RIGID {
        return rigid::draw(seed);
    }
    if seed >= SLIDING {
        return sliding::draw(seed);
    }
    let mut dice = Dice(fastrand::Rng::with_seed(seed));
    let mut draft = begin(&mut dice);
    match dice.whole(0, 9) {
        0..=2 => rotor::draw(&mut dice, &mut draft),
        3 => linkage(&mut dice, &mut draft),
        _ => {
            tree(&mut dice, &mut draft);
            match dice.whole(0, 3) {
                0 => air::strips(&mut dice, &mut draft),
                1 => air::lattice(&mut dice, &mut draft),
                _ if dice.once_in(8) => draft.add(Table::new("aerodynamics").with("model", "none")),
                _ => {}
            }
        }
    }
    end(&mut dice, draft, seed)
}

/// A machine without bodies.
pub fn begin(dice: &mut Dice) -> Draft {
    let step_s = 2e-3;
    let mut draft = Draft {
        tables: vec![Table::new("").with("name", "m")],
        members: Vec::new(),
        hinges: Vec::new(),
        loops: Vec::new(),
        start_s: 0.0,
        end_s: STEPS as f64 * step_s,
    };
    if dice.once_in(6) {
        draft.start_s = 3.0 * step_s;
    }
    if dice.once_in(4) {
        draft.top().set("description", "a machine drawn from a seed");
    }
    let gravity = dice.vector(9.0);
    draft.top().set("gravity_m_s2", Value::Polar(gravity, Frame::Root));
    draft
}

/// Adds masses, loads and gauges, failures, solver and simulation settings, and the actions on the machine.
pub fn end(dice: &mut Dice, mut draft: Draft, seed: u64) -> Model {
    carry(dice, &mut draft);
    failures(dice, &mut draft);
    solver(dice, &mut draft);
    let (start_s, end_s) = (draft.start_s, draft.end_s);
    let mut experiment =
        Table::new("simulation").with("step_s", end_s / STEPS as f64).with("stop_time_s", start_s + end_s);
    if start_s > 0.0 {
        experiment.set("start_time_s", start_s);
    }
    let moves = ["start_rate_deg_s", "start_rate_m_s", "start_velocity_m_s", "flap_start_m", "edge_start_m"];
    let starts_moving = draft.tables.iter().any(|table| moves.iter().any(|key| table.has(key)));
    if dice.once_in(4) {
        // a machine that moves at the start is not in equilibrium
        experiment.set("start", if starts_moving || dice.once_in(2) { "unstrained" } else { "equilibrium" });
    }
    draft.add(experiment);
    let actions = actions(dice);
    Model { seed, tables: draft.tables, actions }
}

/// Method and steps of the solver.
fn solver(dice: &mut Dice, draft: &mut Draft) {
    let mut table = Table::new("solver").with("tolerance", dice.size(1e-8, 1e-6));
    let has = |key: &str, word: &str| draft.tables.iter().any(|table| table.is(key, word));
    let in_air = draft.tables.iter().any(|table| table.name == "aerodynamics" && !table.is("model", "none"));
    let staggered = has("coupling", "staggered");
    let beams = draft.members.iter().any(|member| member.kind == Kind::Beam);
    let stiff =
        beams || draft.tables.iter().any(|table| table.name.ends_with(".latch") || table.name.ends_with(".end_stops"));
    let brakes = draft.tables.iter().any(|table| table.is("kind", "brake_applied"));
    if !in_air && !stiff && dice.once_in(3) && !brakes {
        // beams would need steps of microseconds; brakes are invalid
        table.set("method", "rk4");
        table.set("fixed_step_s", 1e-4);
    } else if (!in_air || staggered) && dice.once_in(10) {
        table.set("mode", "real_time");
        if dice.once_in(2) {
            table.set("max_iterations", dice.whole(6, 10));
        }
    } else {
        let method = dice.pick(&["esdirk4", "esdirk4", "esdirk3", "tr_bdf2", "generalized_alpha", "sdirk2"]);
        table.set("method", method);
        if method == "generalized_alpha" && dice.once_in(2) {
            table.set("rho_infinity", dice.number(0.5, 0.9));
        }
        if !in_air && dice.once_in(12) {
            table.set("fixed_step_s", 5e-4);
        } else if dice.once_in(6) {
            // a rotor's step may be longer than the solver's default maximum
            table.set("max_step_s", dice.size(1e-3, 1e-2));
        }
        if dice.once_in(8) {
            table.set("min_step_s", 1e-10);
        }
        if dice.once_in(8) {
            table.set("mode", "accurate");
        }
    }
    draft.add(table);
}

/// Bodies, each attached to the root or to an earlier body.
fn tree(dice: &mut Dice, draft: &mut Draft) {
    for index in 0..dice.whole(1, 4) {
        let kind = match dice.whole(0, 5) {
            0 => Kind::Rigid,
            1 => Kind::Modal,
            _ => Kind::Beam,
        };
        let parent = (index > 0 && !dice.once_in(4)).then(|| dice.whole(0, index - 1));
        // each copy has another angle about the parent's x axis: if the parent is the root, this axis is not fixed to the machine
        let count = (kind != Kind::Rigid && parent.is_some() && dice.once_in(6)).then(|| dice.whole(2, 3));
        body(dice, draft, kind, count, None);
        joint(dice, draft, parent);
        if count.is_some() {
            // nothing is attached to copies, and their joints have other names
            draft.hinges.retain(|hinge| hinge.name != format!("j{index}"));
            break;
        }
    }
}

/// A body of ordinary size as the last member; one of a given length is straight.
pub fn body(dice: &mut Dice, draft: &mut Draft, kind: Kind, count: Option<usize>, straight_m: Option<f64>) {
    let name = format!("b{}", draft.members.len());
    let length_m = straight_m.unwrap_or_else(|| dice.number(0.25, 0.6));
    let (mut width_m, mut outlined, mut by_shape) = (0.05, false, false);
    let stations;
    let mut table = match kind {
        Kind::Beam => {
            let section = format!("s{}", draft.members.len());
            let shape = self::section(dice, draft, &section, length_m);
            (width_m, outlined) = (shape.width_m, shape.is_outline);
            let elements = dice.whole(1, 2);
            let mut table = Table::new(format!("body.{name}"))
                .with("length_m", length_m)
                .with("section", section.as_str())
                .with("elements", elements)
                .with("stiffness_damping_s", dice.size(1e-4, 1e-3));
            if dice.once_in(2) {
                table.set("element", dice.pick(&["constant", "linear"]));
            }
            if shape.is_outline && dice.once_in(3) {
                let outer = format!("t{}", draft.members.len());
                let tip = dice.number(0.6, 0.9);
                draft.add(shape.smaller(&outer, tip));
                table.set("outer_section", outer);
                outlined = false;
            } else if shape.is_outline && dice.once_in(3) {
                let [width, height] = [dice.number(0.6, 1.0), dice.number(0.6, 1.0)];
                let width = dice.taper(length_m, width);
                table.set("width_taper", width);
                if dice.once_in(2) {
                    let height = dice.taper(length_m, height);
                    table.set("height_taper", height);
                }
            } else if shape.is_outline && shaped::instead(draft, &section, width_m, length_m) {
                (by_shape, outlined) = (true, false);
            }
            if straight_m.is_none() {
                bent(dice, &mut table, length_m);
            }
            if dice.once_in(3) {
                table.set("mass_damping_1_s", dice.number(0.1, 2.0));
                if dice.once_in(2) {
                    table.set("damp_attached_masses", true);
                }
            }
            if dice.once_in(4) {
                table.set("stiffness_damping_factors", vec![1.0, dice.number(0.0, 2.0), 1.0, dice.number(0.5, 1.5)]);
            }
            // without drawing a random number, so that everything else is unchanged; modes of round sections come in pairs
            if digits(length_m) % 4 == 1 {
                table.set("modal_damping_ratios", vec![0.03, 0.03]);
            }
            if digits(length_m).is_multiple_of(3) {
                table.set("shear", true);
                outlined = false; // strains normal to the axis are not recovered
                if digits(length_m).is_multiple_of(2) {
                    table.set("shear_damping_factors", vec![0.5, 2.0]);
                }
            }
            stations = dice.whole(0, 2);
            if stations == 2 && dice.once_in(2) {
                table.set("load_station_positions_m", vec![0.3 * length_m, 0.9 * length_m]);
            } else {
                table.set("load_stations", stations);
            }
            table
        }
        Kind::Rigid => {
            let mass_kg = dice.number(0.05, 0.3);
            let [a, b, c] = [0.3, 0.1, 0.05].map(|size| mass_kg * size * size / 12.0);
            let off = 0.1 * dice.number(-1.0, 1.0) * c;
            stations = 1;
            let centre = dice.vector(0.05);
            let table = Table::new(format!("rigid_body.{name}"))
                .with("mass_kg", mass_kg)
                .with("centre_of_mass_m", Value::Polar(centre, Frame::Body));
            if dice.once_in(5) {
                // inertia of a flywheel about one axis
                let flywheel = Value::Inertia([5.0 * (a + b), a + c, a + b, off, -off, off]);
                table.with("inertia_kg_m2", flywheel).with("allow_nonphysical_inertia", true)
            } else {
                table.with("inertia_kg_m2", Value::Inertia([b + c, a + c, a + b, off, -off, off]))
            }
        }
        Kind::Modal => {
            let mass = dice.number(0.1, 0.4);
            let (flap, edge) = (dice.number(1.0, 20.0), dice.number(20.0, 100.0));
            let mut table = Table::new(format!("modal_body.{name}"))
                .with("length_m", length_m)
                .with("nodes", dice.whole(4, 8))
                .with("stations", vec![0.0, 1.0])
                .with("mass_kg_m", vec![mass, dice.number(0.1, 0.4)])
                .with("flap_stiffness_N_m2", vec![flap, 0.5 * flap])
                .with("edge_stiffness_N_m2", vec![edge, edge])
                .with("load_station_positions_m", vec![0.5 * length_m]);
            stations = 1;
            if dice.once_in(2) {
                table.set("twist_deg", vec![Value::Odd(dice.number(-20.0, 20.0)), Value::Odd(0.0)]);
            }
            let shapes = [vec![1.5, -0.5], vec![-2.0, 3.0]];
            for (key, ratios, start, most) in [
                ("flap_shapes", "flap_damping_ratios", "flap_start_m", 2),
                ("edge_shapes", "edge_damping_ratios", "edge_start_m", 1),
            ] {
                let count = dice.whole(usize::from(key == "flap_shapes"), most);
                if count > 0 {
                    table.set(key, shapes[..count].to_vec());
                    table.set(ratios, vec![dice.number(0.0, 0.05); count]);
                }
                if count > 0 && dice.once_in(2) {
                    let at = |x| if key == "edge_shapes" { Value::Odd(x) } else { Value::from(x) };
                    table.set(start, Value::List((0..count).map(|_| at(dice.number(-0.01, 0.01))).collect()));
                }
            }
            if dice.once_in(4) {
                table.set(dice.pick_key(), false);
            }
            table
        }
    };
    if stations > 0 && dice.once_in(2) {
        table.set("load_frame", dice.pick(&["section", "section", "root"]));
    }
    if let Some(count) = count {
        table.keys.insert(0, ("count", count.into()));
    }
    draft.add(table);
    draft.members.push(Member { name, kind, length_m, width_m, stations, copied: count.is_some(), outlined, by_shape });
}

impl Dice {
    fn pick_key(&mut self) -> &'static str {
        if self.once_in(2) { "axial_shortening" } else { "section_rotation" }
    }
}

/// Unloaded shape of a beam, in one of the ways to specify it.
fn bent(dice: &mut Dice, table: &mut Table, length_m: f64) {
    match dice.whole(0, 8) {
        0 | 1 => {
            let curvature = Vector3::new(dice.number(-0.5, 0.5), dice.number(-0.5, 0.5), dice.number(-0.2, 0.2));
            table.set("natural_curvature_1_m", Value::Axial(curvature, Frame::Body));
        }
        2 | 3 => {
            for (key, size, odd) in
                [("twist_1_m", 0.5, true), ("curvature_y_1_m", 0.5, false), ("curvature_z_1_m", 0.2, true)]
            {
                let ends = [dice.number(-size, size), dice.number(-size, size)];
                let along = dice.along(length_m, ends, odd);
                if dice.once_in(2) {
                    table.set(key, along);
                }
            }
        }
        4 => {
            if dice.once_in(2) {
                table.set("axis.eta", vec![0.0, 0.5, 1.0]);
            } else {
                table.set("axis.s_m", vec![0.0, 0.5 * length_m, length_m]);
            }
            let bend = |size: f64, odd: bool| {
                let at = |x: f64| if odd { Value::Odd(x) } else { Value::from(x) };
                // slopes far below one, so that arc lengths are valid
                Value::List([0.0, 0.2 * size, size].map(at).to_vec())
            };
            let [y, z] = [dice.number(-0.05, 0.05), dice.number(-0.05, 0.05)];
            table.set("axis.y_m", bend(y * length_m, true));
            table.set("axis.z_m", bend(z * length_m, false));
            if dice.once_in(2) {
                let twist = dice.number(-15.0, 15.0);
                table.set("axis.twist_deg", bend(twist, true));
            }
        }
        _ => {}
    }
}

impl Dice {
    /// Factor of an outline from 1 at the inner end to another at the outer one.
    fn taper(&mut self, length_m: f64, outer: f64) -> Value {
        match self.whole(0, 2) {
            0 => outer.into(),
            1 => Value::Function(Form::Polynomial, vec![vec![1.0, (outer - 1.0) / length_m]], false),
            _ => Value::Function(Form::Table, vec![vec![0.0, 1.0], vec![length_m, outer]], false),
        }
    }
}

/// Data of a cross-section for its body.
struct Shape {
    width_m: f64,
    /// Given by an outline and a material.
    is_outline: bool,
    table: Table,
}

impl Shape {
    /// The same cross-section, scaled down by a factor.
    fn smaller(&self, name: &str, factor: f64) -> Table {
        let mut table = Table::new(format!("section.{name}"));
        for (key, value) in &self.table.keys {
            let scaled = match value {
                Value::Plain(text) if matches!(*key, "width_m" | "height_m") => {
                    Value::from(factor * text.parse::<f64>().expect("a number"))
                }
                value => value.clone(),
            };
            table.set(key, scaled);
        }
        table
    }
}

fn section(dice: &mut Dice, draft: &mut Draft, name: &str, length_m: f64) -> Shape {
    let (width_m, height_m) = (dice.number(0.03, 0.08), dice.number(0.003, 0.006));
    let (young, density) = (dice.size(3e9, 7e10), dice.number(1000.0, 2700.0));
    let table = Table::new(format!("section.{name}"));
    let (area, flat, edge) = (width_m * height_m, width_m * height_m.powi(3) / 12.0, height_m * width_m.powi(3) / 12.0);
    match dice.whole(0, 3) {
        0 | 1 => {
            let shape = dice.pick(&["rectangle", "ellipse"]);
            let mut table = (table.with("shape", shape).with("width_m", width_m).with("height_m", height_m))
                .with("density_kg_m3", density)
                .with("youngs_modulus_Pa", young);
            if dice.once_in(3) {
                table.set("shear_modulus_Pa", 0.4 * young);
            } else {
                table.set("poisson_ratio", 0.3);
            }
            draft.add(table.clone());
            return Shape { width_m, is_outline: true, table };
        }
        2 => {
            let [share, other] = [dice.number(-0.3, 0.3), dice.number(-0.3, 0.3)];
            let torsion = young * flat;
            let centre = dice.number(-0.1, 0.1) * width_m;
            let mut table = table.with("shape", "explicit");
            // stretch, twist, flap, lag; pairs are coupled by fractions of the square root of their product
            let stiffness = [young * area, torsion, young * flat, young * edge];
            let pairs = [(1, 2, share), (0, 2, other), (0, 3, 0.2)].into_iter().chain(if dice.once_in(2) {
                let mut small = || dice.number(-0.1, 0.1);
                vec![(0, 1, small()), (1, 3, small()), (2, 3, small())]
            } else {
                Vec::new()
            });
            let odd = |i: usize, j: usize| matches!((i, j), (0, 1) | (0, 3) | (1, 2) | (2, 3));
            let coupling = |i: usize, j: usize, share: f64| {
                let value = share * (stiffness[i] * stiffness[j]).sqrt();
                if odd(i, j) { Value::Odd(value) } else { value.into() }
            };
            // along y and z, as far below the axial stiffness as in composite plates
            let shear = [0.3 * young * area, 0.1 * young * area];
            if dice.once_in(3) {
                let with_shear = digits(width_m).is_multiple_of(2);
                // indices of stretch, twist, flap and lag in the matrix, and of the shears
                let (size, place) = if with_shear { (6, [0, 3, 4, 5]) } else { (4, [0, 1, 2, 3]) };
                let mut rows = vec![vec![Value::from(0.0); size]; size];
                for i in 0..4 {
                    rows[place[i]][place[i]] = stiffness[i].into();
                }
                for (i, j, share) in pairs {
                    rows[place[i]][place[j]] = coupling(i, j, share);
                    rows[place[j]][place[i]] = coupling(i, j, share);
                }
                let key = if with_shear {
                    (rows[1][1], rows[2][2]) = (shear[0].into(), shear[1].into());
                    // the shear along y changes its sign in a mirror image, as do twist and lag
                    for (i, j, value, odd) in [
                        (1, 3, 0.1 * (shear[0] * stiffness[1]).sqrt(), false),
                        (2, 4, 0.1 * (shear[1] * stiffness[2]).sqrt(), false),
                        (1, 2, 0.1 * (shear[0] * shear[1]).sqrt(), true),
                        (0, 2, 0.1 * (shear[1] * stiffness[0]).sqrt(), false),
                    ] {
                        let value = if odd { Value::Odd(value) } else { value.into() };
                        (rows[i][j], rows[j][i]) = (value.clone(), value);
                    }
                    "stiffness_with_shear_SI"
                } else {
                    table.set("shear_stiffness_N", shear.to_vec());
                    "stiffness_SI"
                };
                table.set(key, Value::List(rows.into_iter().map(Value::List).collect()));
            } else {
                table.set("shear_stiffness_N", shear.to_vec());
                for (key, value) in STIFFNESS_KEYS.into_iter().zip(stiffness) {
                    table.set(key, value);
                }
                for (i, j, share) in pairs {
                    table.set(coupling_key(i, j), coupling(i, j, share));
                }
            }
            draft.add(
                table
                    .with("mass_kg_m", density * area)
                    .with("centre_of_mass_m", Value::List(vec![Value::Odd(centre), (0.1 * height_m).into()]))
                    .with(
                        "second_moments_kg_m",
                        Value::List(vec![
                            (density * edge).into(),
                            Value::Odd(0.1 * density * flat),
                            (density * flat).into(),
                        ]),
                    )
                    .with("half_width_m", 0.5 * width_m)
                    .with("half_height_m", 0.5 * height_m),
            );
        }
        _ => {
            let taper = |x: f64| vec![x, 0.8 * x, 0.6 * x];
            draft.add(table.with("shape", "table"));
            let mut along = Table::new(format!("section.{name}.along"));
            if dice.once_in(2) {
                along.set("eta", vec![0.0, 0.4, 1.0]);
            } else {
                along.set("s_m", vec![0.0, 0.4 * length_m, length_m]);
            }
            if dice.once_in(2) {
                let bent = young * flat;
                for (i, j, size) in [
                    (0, 1, 0.05 * young * (area * flat).sqrt()),
                    (0, 2, 0.1 * young * (area * flat).sqrt()),
                    (0, 3, 0.05 * young * (area * edge).sqrt()),
                    (1, 2, 0.1 * bent),
                    (1, 3, 0.1 * bent),
                    (2, 3, 0.1 * bent),
                ] {
                    let odd = matches!((i, j), (0, 1) | (0, 3) | (1, 2) | (2, 3));
                    let at = |x: f64| if odd { Value::Odd(x) } else { x.into() };
                    along.set(coupling_key(i, j), Value::List(taper(size).into_iter().map(at).collect()));
                }
            }
            let shear = [0.3 * young * area, 0.1 * young * area];
            along.set("shear_stiffness_y_N", taper(shear[0]));
            along.set("shear_stiffness_z_N", taper(shear[1]));
            if digits(width_m).is_multiple_of(2) {
                for (key, size, odd) in [
                    ("coupling_shear_y_shear_z_N", (shear[0] * shear[1]).sqrt(), true),
                    ("coupling_shear_y_axial_N", (shear[0] * young * area).sqrt(), true),
                    ("coupling_shear_y_twist_N_m", (shear[0] * young * flat).sqrt(), false),
                    ("coupling_shear_y_flap_N_m", (shear[0] * young * flat).sqrt(), true),
                    ("coupling_shear_y_edge_N_m", (shear[0] * young * edge).sqrt(), false),
                    ("coupling_shear_z_axial_N", (shear[1] * young * area).sqrt(), false),
                    ("coupling_shear_z_twist_N_m", (shear[1] * young * flat).sqrt(), true),
                    ("coupling_shear_z_flap_N_m", (shear[1] * young * flat).sqrt(), false),
                    ("coupling_shear_z_edge_N_m", (shear[1] * young * edge).sqrt(), true),
                ] {
                    let at = |x: f64| if odd { Value::Odd(x) } else { x.into() };
                    along.set(key, Value::List(taper(0.1 * size).into_iter().map(at).collect()));
                }
            }
            if dice.once_in(2) {
                along.set("tension_centre_y_m", vec![Value::Odd(0.001), Value::Odd(0.0), Value::Odd(-0.001)]);
                along.set("tension_centre_z_m", vec![0.0, 1e-4, 2e-4]);
                along.set("centre_of_mass_z_m", vec![0.0, 2e-4, 1e-4]);
                let mixed = 0.1 * density * flat;
                along.set("second_moment_yz_kg_m", Value::List(taper(mixed).into_iter().map(Value::Odd).collect()));
            }
            draft.add(
                along
                    .with("axial_stiffness_N", taper(young * area))
                    .with("torsional_rigidity_N_m2", taper(young * flat))
                    .with("flap_stiffness_N_m2", taper(young * flat))
                    .with("edge_stiffness_N_m2", taper(young * edge))
                    .with("mass_kg_m", taper(density * area))
                    .with("centre_of_mass_y_m", vec![Value::Odd(0.0), Value::Odd(0.002), Value::Odd(-0.002)])
                    .with("second_moment_yy_kg_m", taper(density * edge))
                    .with("second_moment_zz_kg_m", taper(density * flat))
                    .with("half_width_m", vec![0.5 * width_m; 3])
                    .with("half_height_m", vec![0.5 * height_m; 3]),
            );
        }
    }
    Shape { width_m, is_outline: false, table: Table::new("") }
}

/// An integer from the bits of a random number: a choice without drawing another one.
fn digits(number: f64) -> u64 {
    number.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40
}

/// Stiffnesses of stretch, twist, flap and lag.
const STIFFNESS_KEYS: [&str; 4] =
    ["axial_stiffness_N", "torsional_rigidity_N_m2", "flap_stiffness_N_m2", "edge_stiffness_N_m2"];

/// Key of the coupling of two of these stiffnesses.
fn coupling_key(i: usize, j: usize) -> &'static str {
    match (i, j) {
        (0, 1) => "coupling_axial_twist_N_m",
        (0, 2) => "coupling_axial_flap_N_m",
        (0, 3) => "coupling_axial_edge_N_m",
        (1, 2) => "coupling_twist_flap_N_m2",
        (1, 3) => "coupling_twist_edge_N_m2",
        (2, 3) => "coupling_flap_edge_N_m2",
        _ => unreachable!("the first is the smaller of four"),
    }
}

/// The joint of the last body.
pub fn joint(dice: &mut Dice, draft: &mut Draft, parent: Option<usize>) {
    let index = draft.members.len() - 1;
    let name = format!("j{index}");
    let frame = if parent.is_some() { Frame::Body } else { Frame::Root };
    let mut table = Table::new(format!("joint.{name}"));
    let kind = dice.pick(match parent {
        // a tree in free flight: nothing else may hold the root
        None if index == 0 => &["clamped", "revolute", "revolute", "prismatic", "universal", "ball", "free"],
        None => &["clamped", "revolute", "prismatic"],
        Some(_) => &["clamped", "revolute", "revolute", "revolute", "prismatic", "universal", "ball"],
    });
    table.set("type", kind);
    match parent {
        None => {
            table.set("parent", "root");
            let place = dice.vector(0.3);
            table.set("root_position_m", Value::Polar(place, Frame::Root));
        }
        Some(parent) => {
            let parent = &draft.members[parent];
            table.set("parent", parent.name.as_str());
            match parent.kind {
                Kind::Beam if dice.once_in(3) => {
                    table.set("parent_position_m", dice.number(0.5, 1.0) * parent.length_m)
                }
                Kind::Rigid if dice.once_in(2) => {
                    let frame = format!("f{index}");
                    let (place, turn) = (dice.vector(0.1), dice.vector(40.0));
                    let table_of_frame = Table::new(format!("rigid_body.{}.frame.{frame}", parent.name))
                        .with("position_m", Value::Polar(place, Frame::Body))
                        .with("rotation_deg", Value::TurnDeg(turn, Frame::Body));
                    table.set("parent_frame", frame);
                    draft.add(table_of_frame);
                }
                _ if dice.once_in(4) => {
                    let arm = dice.vector(0.05);
                    table.set("parent_offset_m", Value::Polar(arm, Frame::Body));
                }
                Kind::Beam | Kind::Rigid | Kind::Modal => {}
            }
        }
    }
    table.set("child", format!("b{index}"));
    if draft.members[index].kind == Kind::Modal && matches!(kind, "ball" | "free") {
        // its mass lies on its axis, about which it may rotate
        let offset = dice.vector(0.01) + Vector3::new(0.0, 0.02, 0.03);
        draft.add(
            Table::new(format!("mass.m{index}"))
                .with("body", format!("b{index}"))
                .with("position_m", draft.members[index].length_m)
                .with("mass_kg", dice.number(0.02, 0.05))
                .with("offset_m", Value::Polar(offset, Frame::Body)),
        );
    }
    let mount = dice.vector(40.0);
    table.set("mount_rotation_deg", Value::TurnDeg(mount, frame));
    let axis = Vector3::new(0.3 * dice.number(-1.0, 1.0), 1.0, 0.3 * dice.number(-1.0, 1.0));
    match kind {
        "universal" | "ball" => {
            if kind == "universal" {
                table.set("axis", Value::Axial(axis, frame));
                table.set("body_axis", Value::Axial(Vector3::new(0.0, 0.1, 1.0), Frame::Body));
            }
            let stiffness = dice.size(0.5, 5.0);
            let drive = Table::new(format!("joint.{name}.motor"))
                .with("stiffness_N_m_rad", stiffness)
                .with("damping_N_m_s_rad", 0.01 * stiffness);
            draft.add(table);
            draft.add(drive);
        }
        "free" => {
            let (velocity, spin) = (dice.vector(3.0), dice.vector(60.0));
            table.set("start_velocity_m_s", Value::Polar(velocity, Frame::Root));
            table.set("start_angular_velocity_deg_s", Value::Axial(spin, Frame::Root));
            draft.add(table);
        }
        "revolute" => {
            table.set("axis", Value::Axial(axis, frame));
            one_freedom(dice, draft, table, false);
        }
        "prismatic" => {
            table.set("axis", Value::Polar(axis, frame));
            one_freedom(dice, draft, table, true);
        }
        _ => draft.add(table),
    }
}

/// The remaining keys of a revolute or prismatic joint.
pub fn one_freedom(dice: &mut Dice, draft: &mut Draft, mut table: Table, slides: bool) {
    let name = table.name.clone();
    // deg and N·m for the revolute joint, m and N for the prismatic one
    let unit = if slides { 1e-3 } else { 1.0 };
    let key = |revolute, prismatic| if slides { prismatic } else { revolute };
    let mut hinge = Hinge { name: name.trim_start_matches("joint.").to_owned(), slides, free: true, has: Vec::new() };
    if dice.once_in(16) {
        table.set("motion", "locked");
        table.set(key("start_angle_deg", "start_position_m"), unit * dice.number(-40.0, 40.0));
        hinge.free = false;
        draft.hinges.push(hinge);
        return draft.add(table);
    }
    if dice.once_in(8) {
        table.set("motion", "prescribed");
        let [a, b, c] = [20.0, 60.0, 300.0].map(|size| unit * dice.number(-size, size));
        if dice.once_in(2) {
            table.set(key("polynomial_deg", "polynomial_m"), vec![a, b, c]);
        } else {
            let rows = vec![vec![0.0, a], vec![0.02, a + 0.1 * b], vec![0.05, a - 0.1 * b]];
            table.set(key("table_s_deg", "table_s_m"), rows);
            if dice.once_in(2) {
                table.set("table_ends", dice.pick(&["rest", "extrapolate"]));
            }
        }
        hinge.free = false;
        draft.hinges.push(hinge);
        return draft.add(table);
    }
    if dice.once_in(8) {
        table.set("motion", "free");
    }
    let start = unit * dice.number(-40.0, 40.0);
    table.set(key("start_angle_deg", "start_position_m"), start);
    if dice.once_in(6) {
        table.set("release", false);
        hinge.has.push("stopper");
    } else if dice.once_in(2) {
        table.set(key("start_rate_deg_s", "start_rate_m_s"), unit * dice.number(-300.0, 300.0));
    }
    draft.add(table);
    let stiffness = dice.size(0.2, 5.0) * if slides { 200.0 } else { 1.0 };
    if !dice.once_in(4) {
        let mut drive = Table::new(format!("{name}.motor"))
            .with(key("stiffness_N_m_rad", "stiffness_N_m"), stiffness)
            .with(key("damping_N_m_s_rad", "damping_N_s_m"), 0.01 * stiffness);
        if dice.once_in(2) {
            drive.set(key("command_deg", "command_m"), unit * dice.number(-40.0, 40.0));
        }
        if dice.once_in(3) {
            drive.set(key("constant_torque_N_m", "constant_force_N"), 0.2 * stiffness * unit.sqrt());
        }
        if dice.once_in(4) {
            drive.set(key("torque_limit_N_m", "force_limit_N"), 0.5 * stiffness * unit.sqrt());
        }
        if dice.once_in(4) {
            drive.set(key("rate_limit_deg_s", "rate_limit_m_s"), 500.0 * unit);
        }
        if dice.once_in(3) {
            drive.set(key("inertia_kg_m2", "mass_kg"), dice.size(1e-4, 1e-2));
            if !slides && dice.once_in(2) {
                drive.set("gear_ratio", if dice.once_in(2) { 20.0 } else { -5.0 });
            }
        }
        if !slides && !drive.has("gear_ratio") && dice.once_in(3) {
            drive.set("gear_ratio", 1.0);
        }
        if drive.has("gear_ratio") && dice.once_in(2) {
            let mut generator = Table::new(format!("{name}.generator"))
                .with("table_rpm_N_m", vec![vec![-60.0, -0.02], vec![10.0, 0.0], vec![60.0, 0.03]])
                .with("efficiency", 0.9);
            if dice.once_in(3) {
                generator.set("on", false);
            }
            if dice.once_in(2) {
                generator.set("above_table", dice.pick(&["constant_torque", "constant_power"]));
            }
            if dice.once_in(3) {
                generator.set("quadratic_gain_N_m_rpm2", 1e-6);
            }
            draft.add(generator);
        }
        draft.add(drive);
        hinge.has.extend(["drive", "neutral angle"]);
    }
    if dice.once_in(3) {
        draft.add(
            Table::new(format!("{name}.spring"))
                .with(key("stiffness_N_m_rad", "stiffness_N_m"), 0.5 * stiffness)
                .with(key("damping_N_m_s_rad", "damping_N_s_m"), 0.002 * stiffness)
                .with(key("rest_angle_deg", "rest_position_m"), unit * dice.number(-20.0, 20.0)),
        );
        hinge.has.push("spring");
    }
    if dice.once_in(3) {
        let rigid = dice.once_in(2);
        let (off, capture) = (dice.number(-10.0, 10.0), dice.number(0.01, 0.5));
        let mut latch = Table::new(format!("{name}.latch"))
            .with(key("angle_deg", "position_m"), start + unit * off)
            .with(key("capture_deg", "capture_m"), unit * capture);
        if rigid {
            latch.set("kind", "rigid");
            if off.abs() <= 1.01 * capture {
                // closed at the start, it permits no motion
                let joint = draft.tables.iter_mut().find(|table| table.name == name).expect("the joint");
                joint.keys.retain(|(key, _)| !key.starts_with("start_rate"));
            }
        } else {
            if dice.once_in(3) {
                latch.set("kind", "elastic");
            }
            if (hinge.has.contains(&"drive") || hinge.has.contains(&"spring")) && dice.once_in(2) {
                latch.set("stiffness_ratio", 20.0);
            } else {
                latch.set(key("stiffness_N_m_rad", "stiffness_N_m"), 20.0 * stiffness);
            }
            if dice.once_in(5) {
                latch.set("initially_closed", true);
            }
        }
        if !latch.has("initially_closed") && dice.once_in(5) {
            latch.set("enable", false);
        }
        draft.add(latch);
        hinge.has.push("latch");
    }
    if dice.once_in(3) {
        let mut stops = Table::new(format!("{name}.end_stops"))
            .with(key("upper_deg", "upper_m"), start + unit * dice.number(1.0, 20.0))
            .with(key("stiffness_N_m_rad", "stiffness_N_m"), 30.0 * stiffness);
        if dice.once_in(2) {
            stops.set(key("lower_deg", "lower_m"), start - unit * dice.number(1.0, 20.0));
        }
        if dice.once_in(2) {
            stops.set(key("damping_N_m_s_rad", "damping_N_s_m"), 0.02 * stiffness);
        }
        draft.add(stops);
    }
    draft.hinges.push(hinge);
}

/// A parallelogram closed by a loop: crank, coupler and rocker.
pub fn linkage(dice: &mut Dice, draft: &mut Draft) {
    let angle_deg = dice.number(30.0, 100.0);
    for index in 0..3 {
        // the unloaded shape closes the loop
        let length_m = if index == 1 { 0.5 } else { 0.3 };
        body(dice, draft, Kind::Beam, None, Some(length_m));
        let (frame, start) = if index == 1 { (Frame::Body, -angle_deg) } else { (Frame::Root, angle_deg) };
        let mut joint = Table::new(format!("joint.j{index}")).with("type", "revolute");
        joint.set("parent", if index == 1 { "b0" } else { "root" });
        joint.set("child", format!("b{index}"));
        if index == 2 {
            joint.set("root_position_m", Value::Polar(Vector3::new(0.5, 0.0, 0.0), Frame::Root));
        }
        if index != 1 {
            joint.set("mount_rotation_deg", Value::TurnDeg(Vector3::zeros(), Frame::Root));
        }
        joint.set("axis", Value::Axial(Vector3::new(0.0, -1.0, 0.0), frame));
        joint.set("start_angle_deg", start);
        draft.add(joint);
        draft.hinges.push(Hinge { name: format!("j{index}"), slides: false, free: true, has: Vec::new() });
    }
    draft.add(
        Table::new("joint.j0.motor")
            .with("constant_torque_N_m", dice.number(-1.0, 1.0))
            .with("damping_N_m_s_rad", 0.05),
    );
    draft.hinges[0].has.push("drive");
    for (name, side) in [("l0", -0.015), ("l1", 0.015)] {
        let offset = Value::Polar(Vector3::new(0.0, side, 0.0), Frame::Body);
        let mut closure = Table::new(format!("loop.{name}"))
            .with("bodies", vec!["b1", "b2"])
            .with("offsets_m", Value::List(vec![offset.clone(), offset]))
            .with("stiffness_N_m", 1e5)
            .with("damping_N_s_m", 50.0);
        if dice.once_in(2) {
            closure.set("inertia_kg", 0.01);
        }
        if dice.once_in(3) {
            closure.set("positions_m", vec![0.5, 0.3]);
        }
        draft.add(closure);
        draft.loops.push(name.to_owned());
    }
    // without drawing a random number, so that everything else is unchanged
    let draws = digits(angle_deg);
    if draws.is_multiple_of(2) {
        // a soft tie from the middle of the crank to the root, in either order
        let at = Vector3::new(angle_deg.to_radians().cos(), 0.0, angle_deg.to_radians().sin()) * 0.15;
        let mut ends =
            [("b0", 0.15, Value::Polar(Vector3::zeros(), Frame::Body)), ("root", 0.0, Value::Polar(at, Frame::Root))];
        if draws.is_multiple_of(4) {
            ends.reverse();
        }
        let [(first, first_m, first_offset), (second, second_m, second_offset)] = ends;
        let mut tie = Table::new("loop.l2")
            .with("bodies", vec![first, second])
            .with("positions_m", vec![first_m, second_m])
            .with("offsets_m", Value::List(vec![first_offset, second_offset]))
            .with("stiffness_N_m", 30.0)
            .with("damping_N_s_m", 0.2);
        if draws.is_multiple_of(3) {
            tie.set("inertia_kg", 0.01);
        }
        draft.add(tie);
        draft.loops.push("l2".to_owned());
    }
}

/// Masses, gauges, internal loads and loads.
fn carry(dice: &mut Dice, draft: &mut Draft) {
    let members = std::mem::take(&mut draft.members);
    for (index, member) in members.iter().enumerate() {
        if member.copied {
            continue;
        }
        if member.kind == Kind::Beam && dice.once_in(3) {
            let offset = dice.vector(0.01);
            draft.add(
                Table::new(format!("mass.w{index}"))
                    .with("body", member.name.as_str())
                    .with("position_m", dice.number(0.1, 1.0) * member.length_m)
                    .with("mass_kg", dice.number(0.01, 0.1))
                    .with("offset_m", Value::Polar(offset, Frame::Body))
                    .with("inertia_kg_m2", Value::Inertia([1e-5, 2e-5, 1.5e-5, 1e-6, -1e-6, 2e-6])),
            );
        }
        if member.kind == Kind::Beam && dice.once_in(3) {
            // the narrowest shape is a tube that ends with a radius of 0.16 widths
            let reach = if member.by_shape { 15.0 * member.width_m } else { 1.0 };
            let mut gauge = Table::new(format!("gauge.g{index}"))
                .with("body", member.name.as_str())
                .with("position_m", dice.number(0.0, 1.0) * member.length_m)
                .with("y_m", Value::Odd(dice.number(-0.01, 0.01) * reach))
                .with("z_m", 0.0);
            if member.outlined && dice.once_in(2) {
                let across = Vector3::new(1.0, dice.number(-1.0, 1.0), 0.0);
                gauge.set("direction", Value::Polar(across, Frame::Body));
            }
            draft.add(gauge);
        }
        if member.kind == Kind::Beam && dice.once_in(3) {
            let (share, side) = (dice.number(0.0, 1.0), dice.pick(&["inboard", "outboard"]));
            // there is nothing outboard of the outer end
            let side = if share == 1.0 { "inboard" } else { side };
            draft.add(
                Table::new(format!("internal_load.q{index}"))
                    .with("body", member.name.as_str())
                    .with("position_m", share * member.length_m)
                    .with("side", side),
            );
        }
        if member.stations > 0 && dice.once_in(2) {
            let follows = draft
                .tables
                .iter()
                .any(|table| table.name.ends_with(&format!(".{}", member.name)) && table.is("load_frame", "section"));
            let frame = if follows { Frame::Body } else { Frame::Root };
            let (force, moment) = (dice.vector(1.0), dice.vector(0.05));
            draft.add(
                Table::new(format!("load.p{index}"))
                    .with("body", member.name.as_str())
                    .with("station", dice.whole(1, member.stations))
                    .with("force_N", Value::Polar(force, frame))
                    .with("moment_N_m", Value::Axial(moment, frame)),
            );
        }
    }
    draft.members = members;
}

fn failures(dice: &mut Dice, draft: &mut Draft) {
    let mut able: Vec<(&'static str, &'static str, String, bool)> = Vec::new();
    for hinge in &draft.hinges {
        let name = || hinge.name.clone();
        for (part, kind) in [
            ("drive", "motor_loss"),
            ("neutral angle", "motor_jam"),
            ("neutral angle", "motor_runaway"),
            ("latch", "latch_break"),
            ("latch", "latch_no_capture"),
            ("stopper", "lock_release"),
            ("spring", "spring_break"),
        ] {
            if hinge.has.contains(&part) {
                able.push((kind, "joint", name(), hinge.slides));
            }
        }
        if hinge.free {
            able.push(("brake_applied", "joint", name(), hinge.slides));
        }
    }
    able.extend(draft.loops.iter().map(|name| ("loop_break", "loop", name.clone(), false)));
    let beams = draft.members.iter().filter(|member| member.kind == Kind::Beam && !member.copied);
    able.extend(beams.map(|member| ("stiffness_loss", "body", member.name.clone(), false)));
    for index in 0..dice.whole(0, 2) {
        if able.is_empty() {
            return;
        }
        let (kind, key, name, slides) = able.swap_remove(dice.whole(0, able.len() - 1));
        let mut table = Table::new(format!("failure.x{index}")).with("kind", kind).with(key, name);
        match kind {
            "motor_runaway" if slides => table = table.with("to_m", 0.02).with("rate_m_s", 0.5),
            "motor_runaway" => table = table.with("to_deg", 30.0).with("rate_deg_s", 400.0),
            "spring_break" | "loop_break" if dice.once_in(2) => table.set("remaining_fraction", 0.3),
            "stiffness_loss" => table.set("remaining_fraction", dice.number(0.1, 0.9)),
            "brake_applied" => {
                table.set(if slides { "force_N" } else { "torque_N_m" }, dice.size(0.05, 2.0));
                if dice.once_in(2) {
                    table.set("ramp_s", 0.01);
                }
                if dice.once_in(2) {
                    table.set(if slides { "slip_m_s" } else { "slip_deg_s" }, if slides { 2e-3 } else { 1.0 });
                }
            }
            _ => {}
        }
        let free: Vec<_> = draft.hinges.iter().filter(|hinge| hinge.free).collect();
        match dice.whole(0, 3) {
            0 if !free.is_empty() => {
                let hinge = free[dice.whole(0, free.len() - 1)];
                let name = hinge.name.as_str();
                let (angle, rate) = if hinge.slides { (5e-3, 0.1) } else { (10.0, 100.0) };
                let (key, bound) = match (dice.whole(0, 3), hinge.slides) {
                    (0, false) => ("rate_above_deg_s", rate),
                    (0, true) => ("rate_above_m_s", rate),
                    (1, false) => ("rate_below_deg_s", -rate),
                    (1, true) => ("rate_below_m_s", -rate),
                    (2, false) => ("angle_above_deg", angle),
                    (2, true) => ("position_above_m", angle),
                    (_, false) => ("angle_below_deg", -angle),
                    (_, true) => ("position_below_m", -angle),
                };
                let when = Table::new(format!("failure.x{index}.when")).with("joint", name).with(key, bound);
                draft.tables.push(table);
                draft.tables.push(when);
            }
            1 if index > 0 => draft.add(table.with("after", "x0").with("delay_s", 0.005)),
            2 => draft.add(table),
            _ => {
                // some exactly at a communication point
                let share = if dice.once_in(3) { 8.0 / STEPS as f64 } else { dice.number(0.1, 0.7) };
                let at_s = share * draft.end_s;
                draft.add(table.with("at_time_s", draft.start_s + at_s));
            }
        }
    }
}

fn actions(dice: &mut Dice) -> Vec<Action> {
    (0..dice.whole(0, 4))
        .map(|_| {
            let which = dice.whole(0, 9);
            let doing = match dice.whole(0, 11) {
                0 => Doing::RootAcceleration(dice.vector(5.0)),
                1 => Doing::RootSpin(dice.vector(1.0), dice.vector(10.0)),
                2 => Doing::Wind(dice.vector(1.0)),
                3 | 4 => Doing::Load(which, dice.vector(0.5), dice.vector(0.02)),
                5 => Doing::Command(which, dice.number(-0.5, 0.5)),
                6 => Doing::Torque(which, dice.number(-0.2, 0.2)),
                7 => Doing::Release(which, dice.once_in(2)),
                8 => Doing::LatchEnable(which, dice.once_in(2)),
                9 => Doing::GeneratorOn(which, dice.once_in(2)),
                10 => Doing::Trigger(which),
                _ => Doing::Flap(which, dice.number(-0.2, 0.2)),
            };
            Action { step: dice.whole(0, STEPS - 2), doing }
        })
        .collect()
}
