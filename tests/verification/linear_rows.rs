//! LR-01 to LR-04: every row of `A`, `B`, `C` and `D` against differences of the nonlinear machine.
//!
//! The machine is that of [`Hybrid`]: derivatives of states and outputs at any state, found by the mass matrix. Machines that no
//! integrator from outside may have (lattices and rotors) are checked by their instantaneous outputs, with the loads of the air held.

use crate::whole::is_whole;
use foldwing::config;
use foldwing::interface::{Interface, LinearModel, Value, Variable};
use foldwing::machine::Machine;
use foldwing::plant::{Argument, Holding, Hybrid, NotHybrid, Outputs, Plant};
use nalgebra::{DMatrix, DVector};
use std::fmt::Write;
use std::sync::Arc;

/// Largest error of a row over its scale: what the requirement asks for.
const TOLERANCE: f64 = 1e-6;
/// First steps of the differences, from wide to close: a limit or a row of a table may lie near.
const STEPS: [f64; 2] = [1e-2, 1e-4];
/// Derivative in SI units that is none beside those of machines of this size: gravity's are 10, masses' 1.
const NOTHING: f64 = 1e-3;
/// Factor from one step of a table to the next, and the number of them.
const SHRINK: f64 = 0.5;
const TABLE: usize = 6;

/// Derivative of a function at 0 with an estimate of its error, entry by entry: central differences extrapolated to steps of no
/// length after Ridders, from whichever of [`STEPS`] is surest.
fn derivative(mut at: impl FnMut(f64) -> DVector<f64>) -> (DVector<f64>, DVector<f64>) {
    let mut best: Option<(DVector<f64>, DVector<f64>)> = None;
    for first in STEPS {
        let mut table: Vec<Vec<DVector<f64>>> = Vec::new();
        let mut step = first;
        for row in 0..TABLE {
            let (above, below) = (at(step), at(-step));
            // what the difference loses to round-off, where there is one
            let lost = above
                .zip_map(&below, |a, b| if a == b { 0.0 } else { 4.0 * f64::EPSILON * a.abs().max(b.abs()) / step });
            let mut line = vec![(above - below) / (2.0 * step)];
            let mut factor = 1.0;
            for k in 1..=row {
                factor /= SHRINK * SHRINK;
                let next = (&line[k - 1] * factor - &table[row - 1][k - 1]) / (factor - 1.0);
                let off =
                    (&next - &line[k - 1]).abs().zip_map(&(&next - &table[row - 1][k - 1]).abs(), f64::max) + &lost;
                let (value, error) = best.get_or_insert_with(|| (next.clone(), off.clone()));
                for i in 0..next.len() {
                    if off[i] < error[i] {
                        (value[i], error[i]) = (next[i], off[i]);
                    }
                }
                line.push(next);
            }
            table.push(line);
            step *= SHRINK;
        }
    }
    best.expect("a table")
}

/// A block of a linear model beside its reference, column by column.
struct Block {
    what: &'static str,
    rows: Vec<(String, String)>,
    columns: Vec<(String, String)>,
    linear: DMatrix<f64>,
    reference: DMatrix<f64>,
    error: DMatrix<f64>,
    /// Values of the rows.
    values: DVector<f64>,
}

impl Block {
    /// Rows that are off, and the largest share of a scale. Each row is compared with columns of one unit at a time, so that a
    /// stiff column does not hide a soft one; its scale is at least a small part of the whole row's, of the rows of its unit, and of
    /// its value: what those lose to round-off.
    fn misses(&self) -> (f64, Vec<String>) {
        let (mut worst, mut list) = (0.0f64, Vec::new());
        let mut groups: Vec<&String> = self.columns.iter().map(|(_, unit)| unit).collect();
        groups.sort();
        groups.dedup();
        for group in groups {
            let columns: Vec<usize> = (0..self.columns.len()).filter(|&j| &self.columns[j].1 == group).collect();
            let size = |i: usize| columns.iter().fold(0.0f64, |size, &j| size.max(self.reference[(i, j)].abs()));
            for (i, (name, unit)) in self.rows.iter().enumerate() {
                let alike = (0..self.rows.len()).filter(|&k| &self.rows[k].1 == unit);
                let scale = size(i)
                    .max(1e-2 * alike.map(size).fold(0.0, f64::max))
                    .max(1e-2 * self.reference.row(i).amax())
                    .max(NOTHING * self.values[i].abs());
                for &j in &columns {
                    let error = self.error[(i, j)];
                    // where the reference does not know a row that matters, nothing has been checked
                    let sure = error <= TOLERANCE * scale.max(NOTHING);
                    let left = ((self.linear[(i, j)] - self.reference[(i, j)]).abs() - error).max(0.0);
                    let off = if left > 0.0 { left / scale } else { 0.0 };
                    worst = worst.max(off);
                    if !(off <= TOLERANCE && sure) {
                        list.push(format!(
                            "{}: {name} by {}: {:e} for {:e} +- {:.0e}, {off:.1e} of its scale",
                            self.what,
                            self.columns[j].0,
                            self.linear[(i, j)],
                            self.reference[(i, j)],
                            self.error[(i, j)],
                        ));
                    }
                }
            }
        }
        (worst, list)
    }
}

/// Inputs of a linear model: all real ones but commands behind a rate limit, which the model has follow at once and the machine does not.
fn inputs<'a>(interface: &'a Interface, plant: &Plant) -> Vec<&'a Variable> {
    let limited: Vec<String> = plant
        .machine()
        .one_freedoms()
        .filter(|(_, joint)| joint.drive.rate_limit_rad_s < 1e12)
        .map(|(body, _)| format!("{}.command", plant.machine().bodies[body].joint.name))
        .collect();
    interface.real_inputs().filter(|row| !limited.contains(&row.name)).collect()
}

fn real(interface: &Interface, plant: &Plant, outputs: &Outputs, row: &Variable) -> f64 {
    match interface.get(plant, outputs, row.value_reference) {
        Some(Value::Real(value)) => value,
        other => panic!("{}: {other:?}", row.name),
    }
}

/// Checks all rows of the linear model about the present state of a plant; returns the largest share of a scale by which one is off.
///
/// # Panics
/// With the rows that are off.
pub fn linear_rows_agree_at(plant: &mut Plant) -> f64 {
    if let (true, Ok(mut hybrid)) = (plant.machine().air.is_some(), plant.hybrid()) {
        // the linear model takes the loads of the air that the state has: those of the instant, as the reference finds them
        let mut unused = vec![0.0; hybrid.states()];
        hybrid.derivatives(&mut unused).expect("derivatives");
        hybrid.complete();
        hybrid.outputs();
    }
    let interface = Interface::new(plant.machine());
    let (given, outputs) = (inputs(&interface, plant), interface.real_outputs().collect::<Vec<_>>());
    let model = interface
        .linearize(plant, &given, &outputs)
        .unwrap_or_else(|error| panic!("{}: {error}", plant.machine().name));
    let blocks = match plant.hybrid() {
        Ok(_) => of_states(plant, &interface, &model, &given, &outputs),
        Err(NotHybrid::Air) => of_outputs(plant, &interface, &model, &given, &outputs),
        Err(NotHybrid::Uninitialized) => panic!("not initialised"),
    };
    let found: Vec<(f64, Vec<String>)> = blocks.iter().map(Block::misses).collect();
    let misses: Vec<&String> = found.iter().flat_map(|(_, list)| list).collect();
    let shown: Vec<&str> = misses.iter().take(25).map(|miss| miss.as_str()).collect();
    assert!(misses.is_empty(), "{}: {} entries are off\n{}", plant.machine().name, misses.len(), shown.join("\n"));
    found.iter().map(|(worst, _)| *worst).fold(0.0, f64::max)
}

/// Checks all rows of the linear models of a machine: about its start, moving, and about its equilibrium, where there are such.
///
/// # Panics
/// With the rows that are off.
pub fn linear_rows_agree(machine: &Machine) -> f64 {
    let machine = Arc::new(machine.clone());
    let start_s = machine.experiment.start_time_s;
    let mut plant = Plant::new(machine.clone());
    if machine.spatials().count() > 0 {
        // linear models about rest only
        plant.study().equilibrium(start_s, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        return linear_rows_agree_at(&mut plant);
    }
    plant.initialize(start_s).unwrap_or_else(|error| panic!("{}: {error}", machine.name));
    if machine.one_freedoms().any(|(_, joint)| joint.generator.is_some()) {
        // tables may have a row at the speed of the start, where the slope has two sides (LR-03)
        plant.step(start_s + 0.05).unwrap_or_else(|error| panic!("{}: {error}", machine.name));
    }
    linear_rows_agree_at(&mut plant)
}

fn named<'a>(signals: impl Iterator<Item = (&'a String, &'a String)>) -> Vec<(String, String)> {
    signals.map(|(name, unit)| (name.clone(), unit.clone())).collect()
}

/// Place of an input in the flat vector of inputs, found on a plant that does nothing else.
fn place_of(interface: &Interface, idle: &mut Plant, row: &Variable) -> usize {
    let before = idle.inputs().clone();
    let value = real(interface, idle, idle.outputs(), row);
    interface
        .set(idle, row.value_reference, Value::Real(value + 1.0))
        .unwrap_or_else(|error| panic!("{}: {error:?}", row.name));
    let place = (0..before.values().len()).find(|&i| before.values()[i] != idle.inputs().values()[i]);
    idle.inputs_mut().clone_from(&before);
    place.unwrap_or_else(|| panic!("{}: no input", row.name))
}

/// All of `A`, `B`, `C`, `D` through [`Hybrid`].
fn of_states(
    plant: &mut Plant,
    interface: &Interface,
    model: &LinearModel,
    given: &[&Variable],
    outputs: &[&Variable],
) -> Vec<Block> {
    let snapshot = plant.snapshot();
    let mut beside = Plant::new(Arc::new(plant.machine().clone()));
    beside.initialize(plant.machine().experiment.start_time_s).expect("starts again");
    beside.restore(&snapshot).expect("the same machine");
    let freedoms = beside.freedoms();
    let n = freedoms.len();
    let places: Vec<usize> = plant.hybrid().expect("a hybrid system").coordinates().to_vec();
    let m = places.len();
    let directions: Vec<DVector<f64>> = freedoms
        .iter()
        .map(|freedom| {
            let all = beside.study().direction(freedom);
            DVector::from_iterator(m, places.iter().map(|&c| all[c]))
        })
        .collect();
    let directions = DMatrix::from_columns(&directions);
    let back = directions.clone().pseudo_inverse(1e-12).expect("independent freedoms");
    let mut idle = Plant::new(Arc::new(plant.machine().clone()));
    let given: Vec<usize> = given.iter().map(|row| place_of(interface, &mut idle, row)).collect();
    let lags: Vec<usize> = {
        // gusts of the file have lags of their own, which are no states without inputs for gusts
        let names = plant.exchange_lags();
        (0..names.len()).filter(|&i| model.states[2 * n..].iter().any(|state| state.name == names[i])).collect()
    };
    let mut hybrid = plant.hybrid().expect("a hybrid system");
    let mut base = vec![0.0; hybrid.states()];
    hybrid.read(&mut base);
    let time_s = hybrid.time_s();
    // derivatives of freedoms, their rates and the lags, then outputs
    let read = |hybrid: &mut Hybrid, states: &[f64]| -> DVector<f64> {
        hybrid.set(time_s, states);
        let mut slope = vec![0.0; states.len()];
        hybrid.derivatives(&mut slope).expect("derivatives");
        let part = |first: usize| &back * DVector::from_column_slice(&slope[first..first + m]);
        let found = hybrid.outputs().clone();
        let values: Vec<f64> = outputs.iter().map(|row| real(interface, &idle, &found, row)).collect();
        let of_lags: Vec<f64> = lags.iter().map(|&lag| slope[2 * m + lag]).collect();
        let all = part(0).iter().chain(part(m).iter()).chain(&of_lags).chain(&values).copied().collect::<Vec<_>>();
        DVector::from_vec(all)
    };
    let states = model.states.len();
    assert_eq!(states, 2 * n + lags.len());
    let present = read(&mut hybrid, &base);
    let mut columns: Vec<(DVector<f64>, DVector<f64>)> = Vec::new();
    for freedom in &freedoms {
        columns.push(derivative(|amount| {
            let moved = beside.study().displaced(freedom, amount);
            let mut there = base.clone();
            places.iter().enumerate().for_each(|(i, &c)| there[i] = moved[c]);
            read(&mut hybrid, &there)
        }));
    }
    for j in 0..n {
        columns.push(derivative(|amount| {
            let mut there = base.clone();
            (0..m).for_each(|i| there[m + i] += amount * directions[(i, j)]);
            read(&mut hybrid, &there)
        }));
    }
    for &lag in &lags {
        columns.push(derivative(|amount| {
            let mut there = base.clone();
            there[2 * m + lag] += amount;
            read(&mut hybrid, &there)
        }));
    }
    for (j, &place) in given.iter().enumerate() {
        let kept = hybrid.system_mut().inputs().clone();
        columns.push(derivative(|amount| {
            // a step of the wind makes the rates jump, by what B has in the rows of the coordinates
            let jump = &directions * model.matrices.b.view((0, j), (n, 1)) * amount;
            let mut there = base.clone();
            (0..m).for_each(|i| there[m + i] += jump[i]);
            hybrid.system_mut().inputs_mut().values_mut()[place] += amount;
            hybrid.follow_inputs();
            let found = read(&mut hybrid, &there);
            hybrid.system_mut().inputs_mut().clone_from(&kept);
            hybrid.follow_inputs();
            found
        }));
    }
    plant.restore(&snapshot).expect("the same machine");
    type Pair = (DVector<f64>, DVector<f64>);
    let all = |pick: fn(&Pair) -> &DVector<f64>| {
        DMatrix::from_columns(&columns.iter().map(|column| pick(column).clone()).collect::<Vec<_>>())
    };
    let (values, errors) = (all(|column| &column.0), all(|column| &column.1));
    let of_states = named(model.states.iter().map(|signal| (&signal.name, &signal.unit)));
    let of_inputs = named(model.inputs.iter().map(|signal| (&signal.name, &signal.unit)));
    let of_outputs = named(model.outputs.iter().map(|signal| (&signal.name, &signal.unit)));
    let block = |what,
                 rows: &Vec<(String, String)>,
                 columns: &Vec<(String, String)>,
                 linear: &DMatrix<f64>,
                 at: (usize, usize)| Block {
        what,
        rows: rows.clone(),
        columns: columns.clone(),
        linear: linear.clone(),
        reference: values.view(at, linear.shape()).into_owned(),
        error: errors.view(at, linear.shape()).into_owned(),
        values: present.rows(at.0, linear.nrows()).into_owned(),
    };
    let matrices = &model.matrices;
    vec![
        block("A", &of_states, &of_states, &matrices.a, (0, 0)),
        block("B", &of_states, &of_inputs, &matrices.b, (0, states)),
        block("C", &of_outputs, &of_states, &matrices.c, (states, 0)),
        block("D", &of_outputs, &of_inputs, &matrices.d, (states, states)),
    ]
}

/// Whether an output shows loads of the air, which [`of_outputs`] holds; the other outputs of machines with a rotor are checked.
fn shows_air(name: &str) -> bool {
    let parts = ["force", "moment", "strain", "aero.", "rotor.", "circulation", "holding_torque"];
    parts.iter().any(|part| name.contains(part))
}

/// `C` and `D` by the outputs at states and accelerations beside the present, with the loads of the air held: `A` and `B` say which
/// accelerations belong to a state.
fn of_outputs(
    plant: &mut Plant,
    interface: &Interface,
    model: &LinearModel,
    given: &[&Variable],
    outputs: &[&Variable],
) -> Vec<Block> {
    let mut idle = Plant::new(Arc::new(plant.machine().clone()));
    let given: Vec<usize> = given.iter().map(|row| place_of(interface, &mut idle, row)).collect();
    let shown: Vec<usize> = (0..outputs.len()).filter(|&i| model.without_air || !shows_air(&outputs[i].name)).collect();
    let read = |found: &Outputs| {
        DVector::from_iterator(shown.len(), shown.iter().map(|&i| real(interface, &idle, found, outputs[i])))
    };
    let freedoms = plant.freedoms();
    let (n, states) = (freedoms.len(), model.states.len());
    let mut sides = [Argument::Position, Argument::Rate, Argument::Acceleration].map(|argument| {
        freedoms
            .iter()
            .map(|freedom| derivative(|amount| read(&plant.study().outputs_beside(Some((argument, freedom, amount))))))
            .collect::<Vec<_>>()
    });
    let by_input: Vec<_> = given
        .iter()
        .map(|&place| {
            derivative(|amount| {
                let kept = plant.inputs().clone();
                plant.inputs_mut().values_mut()[place] += amount;
                let found = read(&plant.study().outputs_beside(None));
                plant.inputs_mut().clone_from(&kept);
                found
            })
        })
        .collect();
    let matrix = |list: &[(DVector<f64>, DVector<f64>)], part: usize| {
        let columns: Vec<_> = list.iter().map(|both| if part == 0 { both.0.clone() } else { both.1.clone() }).collect();
        if columns.is_empty() { DMatrix::zeros(shown.len(), 0) } else { DMatrix::from_columns(&columns) }
    };
    let pull = sides[2].split_off(0);
    let m = &model.matrices;
    let pairs = [0, 1].map(|part| {
        let sign = |matrix: DMatrix<f64>| if part == 0 { matrix } else { matrix.abs() };
        let by_pull = matrix(&pull, part);
        let mut c = &by_pull * sign(m.a.rows(n, n).into_owned());
        let mut d = &by_pull * sign(m.b.rows(n, n).into_owned());
        for (k, side) in sides.iter().take(2).enumerate() {
            let mut own = c.columns_mut(k * n, n);
            own += matrix(side, part);
        }
        d += matrix(&by_input, part);
        (c, d)
    });
    let rows: Vec<(String, String)> =
        shown.iter().map(|&i| (model.outputs[i].name.clone(), model.outputs[i].unit.clone())).collect();
    let of_states = named(model.states.iter().map(|signal| (&signal.name, &signal.unit)));
    let of_inputs = named(model.inputs.iter().map(|signal| (&signal.name, &signal.unit)));
    let [(c, d), (c_error, d_error)] = pairs;
    let values = read(plant.outputs());
    let pick = |matrix: &DMatrix<f64>| matrix.select_rows(&shown);
    assert_eq!(c.ncols(), states);
    vec![
        Block {
            what: "C",
            rows: rows.clone(),
            columns: of_states,
            linear: pick(&m.c),
            reference: c,
            error: c_error,
            values: values.clone(),
        },
        Block { what: "D", rows, columns: of_inputs, linear: pick(&m.d), reference: d, error: d_error, values },
    ]
}

/// A shipped model.
fn shipped(path: &str) -> Machine {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(path);
    config::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).0
}

/// LR-01. Shipped models about their start, or about their equilibrium where a joint has several freedoms. Short: one of each kind of
/// air and joint.
#[test]
fn lr01_rows_of_shipped_models() {
    const SHORT: [&str; 6] = [
        "models/goland_wing.toml",
        "models/flared_wing_tip.toml",
        "models/four_bar.toml",
        "models/roll_fold.toml",
        "failures/pitch_link.toml",
        "turbine/nrel_5mw_wind.toml",
    ];
    const REST: [&str; 21] = [
        "aileron/folding_aileron.toml",
        "failures/latch_does_not_catch.toml",
        "failures/motor_dies.toml",
        "failures/pitch_link_5mw.toml",
        "failures/pitch_link_flexible.toml",
        "failures/pitch_link_in_wind.toml",
        "gust.toml",
        "models/branched.toml",
        "models/curved_blade.toml",
        "models/folding_wing.toml",
        "models/folding_wing_as_printed.toml",
        "models/folding_wing_constant.toml",
        "models/folding_wing_in_tunnel.toml",
        "models/slender_wing.toml",
        "models/three_bodies.toml",
        "turbine/nrel_5mw.toml",
        "turbine/nrel_5mw_reduced.toml",
        "turbine/nrel_5mw_strain.toml",
        "two_body.toml",
        "wind_tunnel/slanted_double_pendulum.toml",
        "wind_tunnel/sideslip_wing.toml",
    ];
    let rest = if is_whole() { &REST[..] } else { &[] };
    for path in SHORT.iter().chain(rest) {
        println!("LR-01 {path}");
        println!("LR-01 {path}: off by at most {:.1e} of a row's scale", linear_rows_agree(&shipped(path)));
    }
}

/// Numbers between 0 and 1, the same each time.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }
}

/// A chain of one to four beams and rigid bodies on turning joints: motors within and beyond their limits, springs, dampers, stops that
/// are pressed on, generators over a table, brakes that slip, elastic latches that are closed; loads, gauges, section loads, and for
/// some the air of strips.
fn random_machine(random: &mut Random) -> String {
    let mut text = String::from(
        "name = 'random'\ngravity_m_s2 = [0.5, -0.3, -9.0]\n[section.s]\nshape = 'explicit'\naxial_stiffness_N = 4e4\n\
         torsional_rigidity_N_m2 = 8.0\nflap_stiffness_N_m2 = 12.0\nlag_stiffness_N_m2 = 30.0\ncoupling_twist_flap_N_m2 = 1.5\n\
         mass_kg_m = 0.5\ncentre_of_mass_m = [0.01, 0.0]\nsecond_moments_kg_m = [0.01, 0.0, 0.004]\nhalf_width_m = 0.1\n\
         half_height_m = 0.05\n",
    );
    let count = 1 + (4.0 * random.unit()) as usize;
    let in_air = random.chance(0.25);
    let mut beams = Vec::new();
    for k in 0..count {
        let parent = if k == 0 { "root".to_owned() } else { format!("b{}", k - 1) };
        let beam = random.chance(0.5) || in_air && k == 0;
        if beam {
            beams.push(k);
            let _ = write!(
                text,
                "[body.b{k}]\nlength_m = {:.3}\nsection = 's'\nelements = {}\nelement = '{}'\nmass_damping_1_s = {:.3}\n\
                 stiffness_damping_s = {:.5}\nload_stations = 1\n[gauge.g{k}]\nbody = 'b{k}'\nposition_m = 0.1\n\
                 [section_load.c{k}]\nbody = 'b{k}'\nposition_m = 0.15\n",
                random.between(0.3, 0.7),
                if random.chance(0.5) { 1 } else { 2 },
                if random.chance(0.5) { "linear" } else { "constant" },
                random.between(0.0, 0.5),
                random.between(0.0, 1e-3),
            );
        } else {
            let _ = write!(
                text,
                "[rigid_body.b{k}]\nmass_kg = {:.3}\ncentre_of_mass_m = [{:.3}, 0.05, -0.03]\n\
                 inertia_kg_m2 = [0.02, 0.03, 0.04, 0.001, 0.0, 0.002]\n",
                random.between(0.3, 2.0),
                random.between(-0.2, 0.3),
            );
        }
        let slide = random.chance(0.25);
        let (kind, per, rate, limit, upper) = if slide {
            ("prismatic", "N_m", "start_rate_m_s", "force_limit_N", ("upper_m", "stiffness_N_m", "damping_N_s_m"))
        } else {
            (
                "revolute",
                "N_m_rad",
                "start_rate_deg_s",
                "torque_limit_N_m",
                ("upper_deg", "stiffness_N_m_rad", "damping_N_m_s_rad"),
            )
        };
        let turn = if slide { 1.0 } else { 57.3 };
        let _ = write!(
            text,
            "[joint.j{k}]\ntype = '{kind}'\nparent = '{parent}'\nchild = 'b{k}'\naxis = [{:.3}, 1.0, {:.3}]\n\
             {rate} = {:.3}\n{} = {:.4}\ndrive.stiffness_{per} = {:.3}\ndrive.{} = {:.3}\n",
            random.between(-0.5, 0.5),
            random.between(-0.5, 0.5),
            turn * random.between(-2.0, 2.0),
            if slide { "start_position_m" } else { "start_angle_deg" },
            turn * random.between(-0.2, 0.4),
            random.between(0.5, 8.0),
            upper.2,
            random.between(0.0, 0.4),
        );
        if random.chance(0.5) {
            let _ = writeln!(text, "drive.{limit} = {:.3}", random.between(0.05, 3.0));
        }
        if random.chance(0.4) {
            let _ = writeln!(text, "spring.stiffness_{per} = {:.3}", random.between(0.5, 5.0));
        }
        if !slide && random.chance(0.5) {
            let _ = write!(
                text,
                "drive.gear_ratio = {:.2}\n[joint.j{k}.generator]\ntable_rpm_N_m = [[-10.0, {:.3}], [5.0, 0.1], [12.0, {:.3}]]\nbeyond = 'power'\nefficiency = 0.9\n",
                random.between(1.0, 3.0),
                random.between(-0.5, 0.5),
                random.between(0.3, 2.0),
            );
        }
        if random.chance(0.4) {
            let _ = write!(
                text,
                "[joint.j{k}.stops]\n{} = {:.4}\n{} = {:.1}\n{} = {:.3}\n",
                upper.0,
                turn * random.between(-0.3, 0.3),
                upper.1,
                random.between(100.0, 1000.0),
                upper.2,
                random.between(0.0, 5.0),
            );
        } else if random.chance(0.3) {
            let (at, window, ratio) = if slide {
                ("position_m", "capture_m", "stiffness_N_m")
            } else {
                ("angle_deg", "capture_deg", "stiffness_N_m_rad")
            };
            let _ = write!(
                text,
                "[joint.j{k}.latch]\n{at} = {:.4}\n{window} = {:.4}\n{ratio} = 400.0\n",
                turn * 0.1,
                turn * 0.8
            );
        }
        if random.chance(0.4) {
            let (torque, slip) = if slide { ("force_N", "slip_m_s") } else { ("torque_N_m", "slip_deg_s") };
            let _ = write!(
                text,
                "[failure.f{k}]\nkind = 'brake_comes_on'\njoint = 'j{k}'\nat_time_s = 0.001\n{torque} = {:.3}\nramp_s = 0.002\n{slip} = {:.4}\n",
                random.between(0.1, 2.0),
                turn * random.between(0.3, 2.0),
            );
        }
    }
    if in_air {
        text += "[aerodynamics]\nmodel = 'strip'\nwind_m_s = [0.5, -9.0, 0.7]\nstep_s = 1e-3\n";
        for k in beams {
            let _ = write!(text, "[surface.b{k}]\nbody = 'b{k}'\nchord_m = 0.2\nstrips = 2\n");
        }
    }
    text + "[solver]\ntolerance = 1e-10\n[experiment]\nstop_time_s = 1.0\nstep_s = 1e-3\n"
}

/// LR-02. Random machines about a state of motion. Short: eight of the hundred.
#[test]
fn lr02_rows_of_random_machines() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut worst = 0.0f64;
    for number in 0..if is_whole() { 100 } else { 8 } {
        let text = random_machine(&mut random);
        let machine = config::parse(&text, "random.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}\n{text}"));
        plant.step(0.005).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let off = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| linear_rows_agree_at(&mut plant)));
        let Ok(off) = off else { panic!("machine {number}\n{text}") };
        worst = worst.max(off);
    }
    println!("LR-02: off by at most {worst:.1e} of a row's scale");
}

/// LR-03. At a kink the four matrices take the same side: a motor that wants just what its limit allows is free of the limit, a
/// generator at a row of its table goes on towards higher speeds, a joint that lies just at its stop, at rest, is apart from it.
/// Beside the kink each takes the side on which it is.
#[test]
fn lr03_one_side_of_a_kink() {
    let model = |wanted: f64, rpm: f64, at_m: f64| {
        let text = format!(
            "name = 'K'\n[rigid_body.block]\nmass_kg = 2.0\ninertia_kg_m2 = [0.5, 0.5, 0.5, 0.0, 0.0, 0.0]\n\
             [rigid_body.rotor]\nmass_kg = 1.0\ninertia_kg_m2 = [0.5, 0.5, 0.5, 0.0, 0.0, 0.0]\n\
             [rigid_body.rest]\nmass_kg = 1.0\n\
             [joint.slide]\ntype = 'prismatic'\nparent = 'root'\nchild = 'block'\naxis = [1.0, 0.0, 0.0]\n\
             start_position_m = {wanted:?}\ndrive.stiffness_N_m = 4.0\ndrive.force_limit_N = 2.0\n\
             [joint.shaft]\ntype = 'revolute'\nparent = 'root'\nchild = 'rotor'\naxis = [1.0, 0.0, 0.0]\n\
             start_rate_deg_s = {:?}\ndrive.gear_ratio = 1.0\n\
             [joint.shaft.generator]\ntable_rpm_N_m = [[0.0, 0.0], [30.0, 1.0], [60.0, 4.0]]\n\
             [joint.stop]\ntype = 'prismatic'\nparent = 'root'\nchild = 'rest'\naxis = [0.0, 1.0, 0.0]\nstart_position_m = {at_m:?}\n\
             [joint.stop.stops]\nupper_m = 0.25\nstiffness_N_m = 50.0\ndamping_N_s_m = 3.0\n[experiment]\nstop_time_s = 1.0\n",
            rpm * 6.0
        );
        let machine = config::parse(&text, "kinks.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let interface = Interface::new(plant.machine());
        let outputs: Vec<_> = interface.real_outputs().collect();
        let inputs: Vec<_> = interface.real_inputs().collect();
        interface.linearize(&mut plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}"))
    };
    let entry = |model: &LinearModel, matrix: char, row: &str, column: &str| {
        let place = |list: &[foldwing::interface::LinearSignal], name: &str| {
            list.iter().position(|signal| signal.name == name).unwrap_or_else(|| panic!("{name}"))
        };
        let m = &model.matrices;
        match matrix {
            'A' => m.a[(place(&model.states, row), place(&model.states, column))],
            'B' => m.b[(place(&model.states, row), place(&model.inputs, column))],
            'C' => m.c[(place(&model.outputs, row), place(&model.states, column))],
            _ => m.d[(place(&model.outputs, row), place(&model.inputs, column))],
        }
    };
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
    let beyond = 1e-9;
    // slope of the motor, of the generator over its speed in N.m.s/rad, of the stop
    let per_rpm = 30.0 / std::f64::consts::PI;
    for (wanted, rpm, at_m, motor, generator, stop) in [
        (0.5, 30.0, 0.25, 4.0, 0.1 * per_rpm, [0.0, 0.0]),
        (0.5 + beyond, 30.0 - beyond, 0.25 + beyond, 0.0, per_rpm / 30.0, [50.0, 3.0]),
        (0.5 - beyond, 30.0 + beyond, 0.25 - beyond, 4.0, 0.1 * per_rpm, [0.0, 0.0]),
    ] {
        let model = model(wanted, rpm, at_m);
        near(entry(&model, 'A', "der(slide.position)", "slide.position"), -motor / 2.0);
        near(entry(&model, 'B', "der(slide.position)", "slide.command"), motor / 2.0);
        near(entry(&model, 'C', "slide.motor_force", "slide.position"), -motor);
        near(entry(&model, 'D', "slide.motor_force", "slide.command"), motor);
        near(entry(&model, 'A', "der(shaft.angle)", "der(shaft.angle)"), -generator / 0.5);
        near(entry(&model, 'C', "shaft.generator_torque", "der(shaft.angle)"), generator);
        near(entry(&model, 'A', "der(stop.position)", "stop.position"), -stop[0]);
        near(entry(&model, 'A', "der(stop.position)", "der(stop.position)"), -stop[1]);
    }
}

/// LR-04. In compressible air the loads grow with the Mach number: the static gain of the linear lattice by the speed of the wind is the
/// derivative of the loads of established flows, which at Mach 0.5 grow by a sixth more than with the square of the speed.
#[test]
fn lr04_lattice_in_compressible_air() {
    let machine = |speed_m_s: f64| {
        let text = format!(
            "name = 'M'\n[section.s]\nshape = 'explicit'\naxial_stiffness_N = 1e12\ntorsional_rigidity_N_m2 = 1e11\n\
             flap_stiffness_N_m2 = 1e11\nlag_stiffness_N_m2 = 1e11\nmass_kg_m = 5.0\nsecond_moments_kg_m = [0.1, 0.0, 0.1]\n\
             half_width_m = 0.5\nhalf_height_m = 0.1\n[body.wing]\nlength_m = 4.0\nsection = 's'\nelements = 1\n\
             [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'wing'\n\
             [aerodynamics]\nmodel = 'uvlm'\ndensity_kg_m3 = 0.5\nwind_m_s = [0.0, {:?}, {:?}]\nspeed_of_sound_m_s = 300.0\n\
             step_s = 2e-3\nwake_rows = 20\n[surface.wing]\nbody = 'wing'\nchord_m = 1.0\nstrips = 4\nchord_panels = 2\n\
             [experiment]\nstop_time_s = 1.0\nstart = 'equilibrium'\n",
            -speed_m_s,
            0.05 * speed_m_s
        );
        config::parse(&text, "mach.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
    };
    let started = |speed_m_s: f64| {
        let mut plant = Plant::new(Arc::new(machine(speed_m_s)));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant
    };
    let mut plant = Plant::new(Arc::new(machine(150.0)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::new(plant.machine());
    let named = |name: &str| interface.find(name).unwrap_or_else(|| panic!("{name}"));
    let inputs = ["wind.velocity.y", "wind.velocity.z"].map(named);
    let model = interface.linearize_lattice(&mut plant, &inputs, &[], &[named("aero.force.z")]);
    let model = model.unwrap_or_else(|error| panic!("{error}"));
    let m = &model.matrices;
    let n = m.a.nrows();
    let at_rest = (DMatrix::identity(n, n) - &m.a).lu().solve(&m.b).expect("decays");
    let gain = &m.c * at_rest + &m.d;
    // along the wind: both components grow with the speed
    let found = -gain[(0, 0)] + 0.05 * gain[(0, 1)];
    let lift_n = |speed_m_s: f64| started(speed_m_s).outputs().air_total().force_n.z;
    let slope = |step: f64| (lift_n(150.0 + step) - lift_n(150.0 - step)) / (2.0 * step);
    let expected = (4.0 * slope(1.0) - slope(2.0)) / 3.0;
    let power = expected * 150.0 / lift_n(150.0);
    println!("LR-04: {found} N.s/m for {expected}, the load grows with the power {power} of the speed");
    // without Mach's number the power would be 2
    assert!(power > 2.1, "{power}");
    assert!((found / expected - 1.0).abs() < 2e-3, "{found} for {expected}");
}
