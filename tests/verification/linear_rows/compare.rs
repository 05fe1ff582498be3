//! Every row of `A`, `B`, `C` and `D` against differences of the nonlinear machine.
//!
//! The machine is that of [`Hybrid`]: derivatives of states and outputs at any state, found by the mass matrix. Machines that no
//! integrator from outside may have (lattices and rotors) are checked by their instantaneous outputs, with the loads of the air held.

use foldwing::interface::{Interface, LinearModel, Value, Variable};
use foldwing::machine::Machine;
use foldwing::plant::{Argument, Holding, Hybrid, NotHybrid, Outputs, Plant};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Largest error of a row over its scale: what the requirement asks for.
const TOLERANCE: f64 = 1e-6;
/// First steps of the differences, from wide to close: a limit or a row of a table may lie near.
const STEPS: [f64; 2] = [1e-2, 1e-4];
/// The same of inputs: most loads and commands act linearly, where wider steps lose less to round-off.
const INPUT_STEPS: [f64; 3] = [1.0, 1e-2, 1e-4];
/// The same of accelerations, in which all is linear.
const ACCELERATION_STEPS: [f64; 1] = [100.0];
/// Derivative in SI units that is none beside those of machines of this size: gravity's are 10, masses' 1.
const NOTHING: f64 = 1e-3;
/// Factor from one step of a table to the next, and the number of them.
const SHRINK: f64 = 0.5;
const TABLE: usize = 6;

/// What derivatives of loads lose to round-off, over the largest derivative of a load by the same quantity: reactions and section loads
/// are sums along the tree of masses times accelerations, and those are solutions by a mass matrix whose condition is 1e4 or more.
const ROUND_OFF: f64 = 1e-12;

/// First steps of an input: flaps have ends.
fn steps_of(input: &str) -> &'static [f64] {
    if input.starts_with("aero.flap.") { &STEPS } else { &INPUT_STEPS }
}

/// Relative error of the entries of `A` and `B` that is not seen in their own rows, but in sums of them that nearly cancel.
const CANCELLED: f64 = 1e-9;

/// Whether the rows of a machine's linear model are right.
#[derive(Debug, PartialEq)]
pub enum Rows {
    /// The largest error over the scale of a row.
    Agree(f64),
    /// The machine has no linear model there, for a reason.
    Refused(String),
    /// Entries that are off, by name.
    Miss(String),
}

/// Derivative of a function at 0 with an estimate of its error, entry by entry: central differences extrapolated to steps of no
/// length after Ridders, from whichever of [`STEPS`] is surest.
fn derivative(at: impl FnMut(f64) -> DVector<f64>) -> (DVector<f64>, DVector<f64>) {
    derivative_from(&STEPS, at)
}

/// The same from given first steps.
fn derivative_from(steps: &[f64], mut at: impl FnMut(f64) -> DVector<f64>) -> (DVector<f64>, DVector<f64>) {
    let mut best: Option<(DVector<f64>, DVector<f64>)> = None;
    for &first in steps {
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
    /// What the reference loses to round-off where it takes large numbers from each other.
    lost: DMatrix<f64>,
    /// Values of the rows.
    values: DVector<f64>,
}

impl Block {
    /// Rows that are off, and the largest share of a scale. Each row is compared with columns of one unit at a time, so that a
    /// stiff column does not hide a soft one; its scale is at least a small part of the whole row's, of the rows of its unit, and of
    /// its value: what those lose to round-off.
    fn misses(&self) -> (f64, Vec<String>) {
        let (mut worst, mut list) = (0.0f64, Vec::new());
        let is_load = |unit: &str| matches!(unit, "N" | "N.m");
        let lost = |j: usize, unit: &str| {
            let loads = (0..self.rows.len()).filter(|&k| is_load(unit) && is_load(&self.rows[k].1));
            ROUND_OFF * loads.map(|k| self.reference[(k, j)].abs()).fold(0.0, f64::max)
        };
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
                    .max(NOTHING * self.values[i].abs())
                    // of a machine that is all but at rest kinetic energies of 1e-20 J have derivatives of that size
                    .max(TOLERANCE * NOTHING);
                for &j in &columns {
                    let error = self.error[(i, j)];
                    // where the reference does not know a row that matters, nothing has been checked
                    let lost = lost(j, unit) + self.lost[(i, j)];
                    let sure = error <= TOLERANCE * scale.max(NOTHING) + lost;
                    let left = ((self.linear[(i, j)] - self.reference[(i, j)]).abs() - error - lost).max(0.0);
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

/// Checks all rows of the linear model about the present state of a plant.
pub fn linear_rows_agree_at(plant: &mut Plant) -> Rows {
    if plant.freedoms().is_empty() {
        return Rows::Refused("nothing can move".to_owned());
    }
    if let (true, Ok(mut hybrid)) = (plant.machine().air.is_some(), plant.hybrid()) {
        // the linear model takes the loads of the air that the state has: those of the instant, as the reference finds them
        let mut unused = vec![0.0; hybrid.states()];
        hybrid.derivatives(&mut unused).expect("derivatives");
        hybrid.complete();
        hybrid.outputs();
    }
    let interface = Interface::new(plant.machine());
    let (given, outputs) = (inputs(&interface, plant), interface.real_outputs().collect::<Vec<_>>());
    let model = match interface.linearize(plant, &given, &outputs) {
        Ok(model) => model,
        Err(error) => return Rows::Refused(error.to_string()),
    };
    let blocks = match plant.hybrid() {
        Ok(_) => of_states(plant, &interface, &model, &given, &outputs),
        Err(NotHybrid::Air) => of_outputs(plant, &interface, &model, &given, &outputs),
        Err(NotHybrid::Uninitialized) => panic!("not initialised"),
    };
    let found: Vec<(f64, Vec<String>)> = blocks.iter().map(Block::misses).collect();
    let misses: Vec<&String> = found.iter().flat_map(|(_, list)| list).collect();
    let shown: Vec<&str> = misses.iter().take(25).map(|miss| miss.as_str()).collect();
    if misses.is_empty() {
        Rows::Agree(found.iter().map(|(worst, _)| *worst).fold(0.0, f64::max))
    } else {
        Rows::Miss(format!("{} entries are off\n{}", misses.len(), shown.join("\n")))
    }
}

/// Checks all rows of the linear models of a machine: about its start, moving, and about its equilibrium, where there are such.
pub fn linear_rows_agree(machine: &Machine) -> Rows {
    let machine = Arc::new(machine.clone());
    let start_s = machine.experiment.start_time_s;
    let mut plant = Plant::new(machine.clone());
    if machine.spatials().count() > 0 {
        // linear models about rest only
        if let Err(error) = plant.study().equilibrium(start_s, Holding::AsReleased) {
            return Rows::Refused(error.to_string());
        }
        return linear_rows_agree_at(&mut plant);
    }
    if let Err(error) = plant.initialize(start_s) {
        return Rows::Refused(error.to_string());
    }
    if machine.one_freedoms().any(|(_, joint)| joint.generator.is_some()) {
        // tables may have a row at the speed of the start, where the slope has two sides (LR-03)
        if let Err(error) = plant.step(start_s + 0.05) {
            return Rows::Refused(error.to_string());
        }
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
        columns.push(derivative_from(steps_of(&model.inputs[j].name), |amount| {
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
        lost: DMatrix::zeros(linear.nrows(), linear.ncols()),
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
            .map(|freedom| {
                let steps = if argument == Argument::Acceleration { &ACCELERATION_STEPS[..] } else { &STEPS[..] };
                derivative_from(steps, |amount| read(&plant.study().outputs_beside(Some((argument, freedom, amount)))))
            })
            .collect::<Vec<_>>()
    });
    let by_input: Vec<_> = given
        .iter()
        .zip(&model.inputs)
        .map(|(&place, input)| {
            derivative_from(steps_of(&input.name), |amount| {
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
    // the accelerations of stiff parts nearly cancel in the loads that they add up to
    let pull = matrix(&pull, 0).abs() * CANCELLED;
    let (c_lost, d_lost) = (&pull * m.a.rows(n, n).abs(), &pull * m.b.rows(n, n).abs());
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
            lost: c_lost,
            values: values.clone(),
        },
        Block {
            what: "D",
            rows,
            columns: of_inputs,
            linear: pick(&m.d),
            reference: d,
            error: d_error,
            lost: d_lost,
            values,
        },
    ]
}
