//! Every row of `A`, `B`, `C` and `D` against differences of the nonlinear machine.
//!
//! The reference uses the equations of [`Hybrid`]: derivatives of states and outputs at any state, solved with the mass matrix. Machines
//! that cannot be integrated from outside use [`Study::rates_beside`](foldwing::plant::Study::rates_beside): rotors with instantaneous
//! loads, also beside strips and slender bodies, lattices with constant loads, as in the linear model in continuous time.

use foldwing::interface::{Interface, LinearModel, Value, Variable};
use foldwing::machine::Machine;
use foldwing::plant::{Beside, Holding, Hybrid, InstantRates, NotHybrid, Outputs, Plant};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Maximum error of a row relative to its scale: the requirement.
const TOLERANCE: f64 = 1e-6;
/// First steps of the differences, from wide to close, because a limit or a table row may be near.
const STEPS: [f64; 2] = [1e-2, 1e-4];
/// First steps for inputs: most loads and commands act linearly, so wider steps lose less to round-off.
const INPUT_STEPS: [f64; 3] = [1.0, 1e-2, 1e-4];
/// First steps for rotors: a section may be 1e-7 rad from a corner of its polar, where wider differences average both sides.
const ROTOR_STEPS: [f64; 3] = [1e-2, 1e-4, 1e-6];
/// Degree of attachment below which linear models and states next to the current one take as 0 its square root in (B14), whose derivative
/// is infinite at 0, NOTATION (B27).
const SEPARATED: f64 = 1e-6;
/// Degree of attachment at which differences with respect to it are taken: below 0, where the loads are smooth because the square root is
/// absent. Steps from 0 on would have to stay below 1e-6 and lose six digits.
const BELOW_SEPARATED: f64 = -2e-2;
/// Derivative in SI units that is negligible for machines of this size: those with respect to gravity are about 10, to masses about 1.
const NOTHING: f64 = 1e-3;
/// Error of a reference in SI units below which it counts as accurate, however small the row.
const UNKNOWN: f64 = 1e-5 * NOTHING;
/// Ratio of successive steps of a table, and their number.
const SHRINK: f64 = 0.5;
const TABLE: usize = 6;

/// Round-off of derivatives of loads, relative to the largest derivative of a load with respect to the same quantity: reactions and
/// internal loads are sums along the tree of masses times accelerations, and the latter are solved with a mass matrix whose condition
/// number is 1e4 or more.
const ROUND_OFF: f64 = 1e-12;

/// Steps for measuring the round-off of a function, relative to the first step of the closest differences: smallest and largest. With
/// shorter steps, iterated roots (1e-14) may not change; beyond a tenth of the differences, functions are no longer cubic.
const GRAIN_STEPS: [f64; 2] = [1e-4, 0.0125];
const GRAIN_WIDEST: f64 = 1e-6;
const GRAIN_PAIRS: u32 = 8;

/// Factor on the estimated error of a derivative from close steps within which other estimates must agree: extrapolation amplifies
/// round-off.
const AGREEMENT: f64 = 4.0;

/// Error of a difference of two values, in multiples of their round-off.
const ROUND_OFFS: f64 = 8.0;

/// First steps for loads, in which the accelerations are linear without limits: the round-off of heavy machines is far above a newton.
const LOAD_STEPS: [f64; 2] = [1e4, 1.0];

/// First steps for an input: control surfaces have limits, and the wind moves rotor sections across corners of polars.
fn steps_of(input: &str, is_rotor: bool) -> &'static [f64] {
    if input.starts_with("aero.control_surface.") {
        &STEPS
    } else if input.starts_with("load.") {
        &LOAD_STEPS
    } else if is_rotor && (input.starts_with("wind.") || input.starts_with("root.angular_velocity.")) {
        &ROTOR_STEPS
    } else {
        &INPUT_STEPS
    }
}

/// Result of the check of the rows of a machine's linear model.
#[derive(Debug, PartialEq)]
pub enum Rows {
    /// The largest error relative to the scale of its row.
    Agree(f64),
    /// The machine has no linear model in this state; contains the reason.
    Refused(String),
    /// Entries beyond the tolerance, by name.
    Miss(String),
}

/// Derivative of a function at 0, entry by entry.
struct Slope {
    value: DVector<f64>,
    /// Estimate of its error.
    error: DVector<f64>,
    /// Size of the second derivative: an argument that is off by round-off changes the slope by as much of it.
    bend: DVector<f64>,
}

/// Derivative of a function at 0, from [`STEPS`]. `grain` is round-off of the entries that is
/// not visible in their values: a deflection of 1 µm is a difference of positions of metres.
fn derivative(grain: &DVector<f64>, at: impl FnMut(f64) -> DVector<f64>) -> Slope {
    derivative_from(&STEPS, grain, at)
}

/// The derivative from given first steps, from wide to close: the estimate with the smallest error.
fn derivative_from(steps: &[f64], grain: &DVector<f64>, at: impl FnMut(f64) -> DVector<f64>) -> Slope {
    surest(steps, grain, at, |_, _, _| true)
}

/// The derivative of loads of rotors, whose polars have corners. Wide steps lose less to round-off, but corners between them may bend a
/// table to a value with a small estimated error: an estimate from wide steps counts only if it agrees with that from closer steps within
/// their errors, and the spread of the close differences is used if it is wider than that of the wide ones, which indicates round-off.
fn derivative_off_corners(steps: &[f64], grain: &DVector<f64>, at: impl FnMut(f64) -> DVector<f64>) -> Slope {
    surest(steps, grain, at, |kept, wide, i| {
        let scattered = if wide.spread[i] <= kept.spread[i] { kept.spread[i] } else { 0.0 };
        (wide.value[i] - kept.value[i]).abs() <= wide.error[i] + AGREEMENT * kept.error[i] + scattered
    })
}

/// Of the estimates from close to wide that agree with those from closer steps, the one with the smallest error, entry by entry.
fn surest(
    steps: &[f64],
    grain: &DVector<f64>,
    mut at: impl FnMut(f64) -> DVector<f64>,
    counts: impl Fn(&Estimate, &Estimate, usize) -> bool,
) -> Slope {
    let closest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let bend = ((at(closest) + at(-closest) - at(0.0) * 2.0) / (closest * closest)).abs();
    let grain = grain.zip_map(&scatter(closest, &mut at), f64::max);
    let found = steps.iter().rev().map(|first| Estimate::of(*first, &grain, &mut at));
    let surer = |mut kept: Estimate, wide: Estimate| {
        for i in 0..kept.value.len() {
            if wide.error[i] < kept.error[i] && counts(&kept, &wide, i) {
                (kept.value[i], kept.error[i], kept.spread[i]) = (wide.value[i], wide.error[i], wide.spread[i]);
            }
        }
        kept
    };
    let Estimate { value, error, .. } = found.reduce(surer).expect("a table");
    Slope { value, error, bend }
}

/// Round-off of the entries of a function: the largest deviation of differences over multiples of [`GRAIN_STEPS`], where the function is a
/// cubic up to round-off, from the odd cubic fitted to them; zero if there is a corner at the instant. Cancelling terms have more round-off
/// than the value suggests, and two differences that are equal by chance seem exact.
fn scatter(closest: f64, at: &mut impl FnMut(f64) -> DVector<f64>) -> DVector<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let line: Vec<f64> = (1..=GRAIN_PAIRS).map(f64::from).collect();
    let cubes: Vec<f64> = line.iter().map(|place| place.powi(3)).collect();
    let share = dot(&cubes, &line) / dot(&line, &line);
    let bend: Vec<f64> = cubes.iter().zip(&line).map(|(cube, place)| cube - share * place).collect();
    let off = GRAIN_STEPS.iter().flat_map(|share| {
        let step = share * closest.min(GRAIN_WIDEST);
        let mut found: Vec<DVector<f64>> = line.iter().map(|place| at(place * step) - at(-place * step)).collect();
        for shape in [&line, &bend] {
            let weighted = shape.iter().zip(&found).map(|(weight, found)| found * *weight);
            let amount = weighted.sum::<DVector<f64>>() / dot(shape, shape);
            found.iter_mut().zip(shape).for_each(|(found, weight)| *found -= &amount * *weight);
        }
        found.into_iter().map(|found| found.abs())
    });
    // safety factor for few samples
    2.0 * off.reduce(|a, b| a.zip_map(&b, f64::max)).expect("differences")
}

/// A derivative by central differences extrapolated to zero step by Ridders' method, entry by entry.
struct Estimate {
    value: DVector<f64>,
    /// Estimate of the error, round-off of the last digit included.
    error: DVector<f64>,
    /// Spread of the differences that are extrapolated.
    spread: DVector<f64>,
}

impl Estimate {
    /// The estimate with the smallest error from a table that begins with a step.
    fn of(first: f64, grain: &DVector<f64>, at: &mut impl FnMut(f64) -> DVector<f64>) -> Self {
        let mut best: Option<Self> = None;
        let mut table: Vec<Vec<DVector<f64>>> = Vec::new();
        let mut step = first;
        for row in 0..TABLE {
            let (above, below) = (at(step), at(-step));
            // loss of the difference to round-off: two equal values may differ beyond their last digit
            let lost = above.zip_map(&below, |a, b| 4.0 * f64::EPSILON * a.abs().max(b.abs()) / step) + grain / step;
            let mut line = vec![(above - below) / (2.0 * step)];
            let mut factor = 1.0;
            for k in 1..=row {
                factor /= SHRINK * SHRINK;
                let next = (&line[k - 1] * factor - &table[row - 1][k - 1]) / (factor - 1.0);
                let off =
                    (&next - &line[k - 1]).abs().zip_map(&(&next - &table[row - 1][k - 1]).abs(), f64::max) + &lost;
                let Self { value, error, .. } = best.get_or_insert_with(|| Self {
                    value: next.clone(),
                    error: off.clone(),
                    spread: DVector::zeros(next.len()),
                });
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
        let mut best = best.expect("a table");
        let [most, least] = [f64::max, f64::min].map(|end| {
            let differences = table.iter().map(|line| line[0].clone());
            differences.reduce(|a, b| a.zip_map(&b, end)).expect("a table")
        });
        best.spread = most - least;
        best
    }
}

fn is_load(unit: &str) -> bool {
    matches!(unit, "N" | "N.m")
}

/// Total length in m of all bodies in a row, at least that of a rigid body's arms.
fn length_m(machine: &Machine) -> f64 {
    machine.bodies.iter().map(|body| body.length_m).sum::<f64>().max(1.0)
}

/// A block of a linear model and its reference, column by column.
struct Block {
    what: &'static str,
    rows: Vec<(String, String)>,
    columns: Vec<(String, String)>,
    linear: DMatrix<f64>,
    reference: DMatrix<f64>,
    error: DMatrix<f64>,
    bend: DMatrix<f64>,
    /// Values of the rows.
    values: DVector<f64>,
    /// [`length_m`]: scale between forces and moments.
    length_m: f64,
    /// First step of the differences for each column in which it must be short; infinite otherwise.
    short: Vec<f64>,
}

impl Block {
    /// Rows beyond the tolerance, and the largest relative error. Each row is compared with columns of one unit at a time, so that a stiff
    /// column does not hide a soft one; its scale is at least a small fraction of the whole row, of the rows of its unit, of moments for
    /// forces and of forces for moments, and of its value: these lose as much to round-off. For a planar machine, out-of-plane components
    /// of the root moment are residues of in-plane forces.
    fn misses(&self) -> (f64, Vec<String>) {
        let (mut worst, mut list) = (0.0f64, Vec::new());
        let in_unit_of = |unit: &str, other: &str| match (unit, other) {
            ("N", "N.m") => 1.0 / self.length_m,
            ("N.m", "N") => self.length_m,
            _ if unit == other => 1.0,
            _ => 0.0,
        };
        let lost = |j: usize, unit: &str| {
            let loads = (0..self.rows.len()).filter(|&k| is_load(unit) && is_load(&self.rows[k].1));
            ROUND_OFF * loads.map(|k| self.reference[(k, j)].abs()).fold(0.0, f64::max)
        };
        let loads = (0..self.rows.len()).filter(|&k| is_load(&self.rows[k].1));
        let heaviest = loads.map(|k| self.values[k].abs()).fold(0.0, f64::max);
        let of_short_steps = |i: usize, j: usize| {
            let value = match self.rows[i].1.as_str() {
                "N" | "N.m" => heaviest,
                // differences of positions
                "m" => self.length_m.max(self.values[i].abs()),
                _ => self.values[i].abs(),
            };
            ROUND_OFFS * f64::EPSILON * value / self.short[j]
        };
        let mut groups: Vec<&String> = self.columns.iter().map(|(_, unit)| unit).collect();
        groups.sort();
        groups.dedup();
        for group in groups {
            let columns: Vec<usize> = (0..self.columns.len()).filter(|&j| &self.columns[j].1 == group).collect();
            let size = |i: usize| columns.iter().fold(0.0f64, |size, &j| size.max(self.reference[(i, j)].abs()));
            for (i, (name, unit)) in self.rows.iter().enumerate() {
                let alike = (0..self.rows.len()).map(|k| in_unit_of(unit, &self.rows[k].1) * size(k));
                let scale = size(i)
                    .max(1e-2 * alike.fold(0.0, f64::max))
                    .max(1e-2 * self.reference.row(i).amax())
                    .max(NOTHING * self.values[i].abs())
                    // for a machine almost at rest, kinetic energies of 1e-20 J have derivatives of that size
                    .max(TOLERANCE * NOTHING);
                for &j in &columns {
                    let error = self.error[(i, j)];
                    // if the reference is too inaccurate for a row that matters, nothing has been checked
                    // states are known to round-off: the elastic energy of a stiff strain of 1e-16 has a slope of 1e-7 J
                    let lost = lost(j, unit).max(of_short_steps(i, j)).max(f64::EPSILON * self.bend[(i, j)]);
                    let sure = error <= (TOLERANCE * scale).max(UNKNOWN) + lost;
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

/// Inputs of a linear model: all real ones except commands behind a rate limit, which take effect at once in the model but not in the
/// machine.
fn inputs<'a>(interface: &'a Interface, plant: &Plant) -> Vec<&'a Variable> {
    let limited: Vec<String> = plant
        .machine()
        .bodies
        .iter()
        .filter_map(|body| {
            let (travel, joint) = body.joint.kind.one_freedom()?;
            let command = format!("{}.{}_command", body.joint.name, travel.coordinate());
            (joint.motor.rate_limit_rad_s < 1e12).then_some(command)
        })
        .collect();
    interface.real_inputs().filter(|row| !limited.contains(&row.name)).collect()
}

fn real(interface: &Interface, plant: &Plant, outputs: &Outputs, row: &Variable) -> f64 {
    match interface.get(plant, outputs, row.value_reference) {
        Some(Value::Real(value)) => value,
        other => panic!("{}: {other:?}", row.name),
    }
}

/// Checks all rows of the linear model about the current state of a plant.
pub fn linear_rows_agree_at(plant: &mut Plant) -> Rows {
    if plant.freedoms().is_empty() {
        return Rows::Refused("nothing can move".to_owned());
    }
    let interface = Interface::new(plant.machine());
    let (given, outputs) = (inputs(&interface, plant), interface.real_outputs().collect::<Vec<_>>());
    let model = match interface.linearize(plant, &given, &outputs) {
        Ok(model) => model,
        Err(error) => return Rows::Refused(error.to_string()),
    };
    let is_hybrid = match plant.hybrid() {
        // rows of polars and separated sections need the steps of [`Compared::by_instants`]
        Ok(_) => plant.machine().air.as_ref().is_none_or(|air| air.rotors().next().is_none()),
        Err(NotHybrid::Air | NotHybrid::NoSlip | NotHybrid::RigidLoop | NotHybrid::Sliding) => false,
        Err(NotHybrid::Uninitialized) => panic!("not initialised"),
    };
    let compared = Compared { interface: &interface, model: &model, given: &given, outputs: &outputs };
    let blocks = compared
        .blocks(if is_hybrid { compared.by_hybrid(plant) } else { compared.by_instants(plant) }, plant.machine());
    let found: Vec<(f64, Vec<String>)> = blocks.iter().map(Block::misses).collect();
    let misses: Vec<&String> = found.iter().flat_map(|(_, list)| list).collect();
    let shown: Vec<&str> = misses.iter().take(25).map(|miss| miss.as_str()).collect();
    if misses.is_empty() {
        Rows::Agree(found.iter().map(|(worst, _)| *worst).fold(0.0, f64::max))
    } else {
        Rows::Miss(format!("{} entries are off\n{}", misses.len(), shown.join("\n")))
    }
}

/// Checks all rows of the linear models of a machine: about its start, moving, and about its equilibrium, if available.
pub fn linear_rows_agree(machine: &Machine) -> Rows {
    let machine = Arc::new(machine.clone());
    let start_s = machine.experiment.start_time_s;
    let mut plant = Plant::new(machine.clone());
    if machine.spatials().count() > 0 {
        // linear models only about an equilibrium
        if let Err(error) = plant.study().equilibrium(start_s, Holding::AsReleased) {
            return Rows::Refused(error.to_string());
        }
        return linear_rows_agree_at(&mut plant);
    }
    if let Err(error) = plant.initialize(start_s) {
        return Rows::Refused(error.to_string());
    }
    if machine.one_freedoms().any(|(_, joint)| joint.generator.is_some()) {
        // a generator table may have a row exactly at the start speed, where its derivative is discontinuous (LR-03): move away from it
        if let Err(error) = plant.step(start_s + 0.05) {
            return Rows::Refused(error.to_string());
        }
    }
    linear_rows_agree_at(&mut plant)
}

/// Index of an input in the flat vector of inputs, determined with a separate plant.
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

/// Derivatives of the rates of the states and of the outputs with respect to states and inputs.
struct Differences {
    /// The rates and outputs themselves.
    present: DVector<f64>,
    /// Derivatives, column by column.
    columns: Vec<Slope>,
    /// First steps of the columns that need short ones; infinite for the others.
    short: Vec<f64>,
}

/// A linear model and its variables in the table.
struct Compared<'a> {
    interface: &'a Interface,
    model: &'a LinearModel,
    given: &'a [&'a Variable],
    outputs: &'a [&'a Variable],
}

impl Compared<'_> {
    /// Indices of the inputs in the flat vector of inputs.
    fn places(&self, idle: &mut Plant) -> Vec<usize> {
        self.given.iter().map(|row| place_of(self.interface, idle, row)).collect()
    }

    /// Rates of the degrees of freedom, of their rates and of the lags, then the outputs.
    fn stacked(&self, idle: &Plant, parts: [&[f64]; 3], found: &Outputs) -> DVector<f64> {
        let values = self.outputs.iter().map(|row| real(self.interface, idle, found, row));
        DVector::from_vec(parts.into_iter().flatten().copied().chain(values).collect())
    }

    /// Round-off of the rows that is not visible in their values: lengths are differences of positions.
    fn grain(&self, present: &DVector<f64>, machine: &Machine) -> DVector<f64> {
        let mut grain = DVector::zeros(present.len());
        let first = present.len() - self.outputs.len();
        for (i, _) in self.model.outputs.iter().enumerate().filter(|(_, output)| output.unit == "m") {
            grain[first + i] = 4.0 * f64::EPSILON * length_m(machine);
        }
        grain
    }

    /// Differences by [`Hybrid`].
    fn by_hybrid(&self, plant: &mut Plant) -> Differences {
        let model = self.model;
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
        let given = self.places(&mut idle);
        let names: Vec<&str> = model.states[2 * n..].iter().map(|state| state.name.as_str()).collect();
        let others = [plant.exchange_lags(), plant.exchange_currents()].concat();
        assert_eq!(others, names, "lag states and currents of the hybrid system and of the linear model");
        let mut hybrid = plant.hybrid().expect("a hybrid system");
        hybrid.follow_inputs();
        let mut base = vec![0.0; hybrid.states()];
        hybrid.read(&mut base);
        let time_s = hybrid.time_s();
        let read = |hybrid: &mut Hybrid, states: &[f64]| -> DVector<f64> {
            hybrid.set(time_s, states);
            let mut slope = vec![0.0; states.len()];
            hybrid.derivatives(&mut slope).expect("derivatives");
            let part = |first: usize| &back * DVector::from_column_slice(&slope[first..first + m]);
            let parts = [part(0), part(m)];
            self.stacked(&idle, [parts[0].as_slice(), parts[1].as_slice(), &slope[2 * m..]], hybrid.outputs())
        };
        let present = read(&mut hybrid, &base);
        let grain = self.grain(&present, beside.machine());
        let mut columns: Vec<Slope> = Vec::new();
        for freedom in &freedoms {
            columns.push(derivative(&grain, |amount| {
                let moved = beside.study().displaced(freedom, amount);
                let mut there = base.clone();
                places.iter().enumerate().for_each(|(i, &c)| there[i] = moved[c]);
                read(&mut hybrid, &there)
            }));
        }
        for j in 0..n {
            columns.push(derivative(&grain, |amount| {
                let mut there = base.clone();
                (0..m).for_each(|i| there[m + i] += amount * directions[(i, j)]);
                read(&mut hybrid, &there)
            }));
        }
        for lag in 0..model.states.len() - 2 * n {
            columns.push(derivative(&grain, |amount| {
                let mut there = base.clone();
                there[2 * m + lag] += amount;
                read(&mut hybrid, &there)
            }));
        }
        for (j, &place) in given.iter().enumerate() {
            let kept = hybrid.system_mut().inputs().clone();
            columns.push(derivative_from(steps_of(&model.inputs[j].name, false), &grain, |amount| {
                // a step of the wind makes the rates jump, by the entries of B in the rows of the coordinates
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
        let short = vec![f64::INFINITY; columns.len()];
        Differences { present, columns, short }
    }

    /// Differences by the equations at an instant.
    fn by_instants(&self, plant: &mut Plant) -> Differences {
        let freedoms = plant.freedoms();
        let lags = self.model.states.len() - 2 * freedoms.len();
        let directions: Vec<DVector<f64>> =
            freedoms.iter().map(|freedom| DVector::from(plant.study().direction(freedom))).collect();
        let back = DMatrix::from_columns(&directions).pseudo_inverse(1e-12).expect("independent freedoms");
        let mut idle = Plant::new(Arc::new(plant.machine().clone()));
        let given = self.places(&mut idle);
        let at = |plant: &mut Plant, change: Beside| {
            let found = plant.study().rates_beside(change).unwrap_or_else(|error| panic!("{error}"));
            let InstantRates { rates, accelerations, of_lags, outputs } = found;
            assert_eq!(of_lags.len(), lags);
            let parts = [rates, accelerations].map(|part| &back * DVector::from(part));
            self.stacked(&idle, [parts[0].as_slice(), parts[1].as_slice(), &of_lags], &outputs)
        };
        let present = at(plant, Beside::Nothing);
        let grain = self.grain(&present, plant.machine());
        // lattices have constant loads and no lags; blades without corners permit the closer steps
        let is_rotor = plant.machine().air.as_ref().is_some_and(|air| air.rotors().next().is_some());
        let steps: &[f64] = if is_rotor { &ROTOR_STEPS } else { &STEPS };
        let difference = |steps: &[f64], at: &mut dyn FnMut(f64) -> DVector<f64>| match is_rotor {
            true => derivative_off_corners(steps, &grain, at),
            false => derivative_from(steps, &grain, at),
        };
        let (mut columns, mut short) = (Vec::new(), vec![f64::INFINITY; 2 * freedoms.len()]);
        for freedom in &freedoms {
            columns.push(difference(steps, &mut |amount| at(plant, Beside::Position(freedom, amount))));
        }
        for freedom in &freedoms {
            columns.push(difference(steps, &mut |amount| at(plant, Beside::Rate(freedom, amount))));
        }
        for lag in 0..lags {
            let state = &self.model.states[2 * freedoms.len() + lag];
            let is_attachment = state.name.ends_with(".attachment");
            let from = if is_attachment && state.value < SEPARATED { BELOW_SEPARATED } else { 0.0 };
            // steps beyond 0 leave the range of the square root
            let root = if is_attachment && from == 0.0 { 0.25 * state.value } else { f64::INFINITY };
            let steps: Vec<f64> = steps.iter().map(|step| step.min(root)).collect();
            // the last differences of a table have 2^-5 of the first step
            short.push(if root < ROTOR_STEPS[1] { root * SHRINK.powi(TABLE as i32 - 1) } else { f64::INFINITY });
            columns.push(difference(&steps, &mut |amount| at(plant, Beside::Lag(lag, from + amount))));
        }
        let directions = DMatrix::from_columns(&directions);
        for (j, (&place, input)) in given.iter().zip(&self.model.inputs).enumerate() {
            columns.push(difference(steps_of(&input.name, is_rotor), &mut |amount| {
                let kept = plant.inputs().clone();
                plant.inputs_mut().values_mut()[place] += amount;
                // a step of the wind makes the rates jump, by the entries of B in the rows of the coordinates
                let jump = &directions * self.model.matrices.b.view((0, j), (freedoms.len(), 1)) * amount;
                let found = at(plant, Beside::Rates(jump.as_slice()));
                plant.inputs_mut().clone_from(&kept);
                found
            }));
        }
        short.resize(columns.len(), f64::INFINITY);
        Differences { present, columns, short }
    }

    /// The four matrices and their references.
    fn blocks(&self, differences: Differences, machine: &Machine) -> [Block; 4] {
        let length_m = length_m(machine);
        let Differences { present, columns, short } = differences;
        let matrix = |of: fn(&Slope) -> &DVector<f64>| {
            DMatrix::from_columns(&columns.iter().map(|slope| of(slope).clone()).collect::<Vec<_>>())
        };
        let values = matrix(|slope| &slope.value);
        let [errors, bends] = [matrix(|slope| &slope.error), matrix(|slope| &slope.bend)];
        let [of_states, of_inputs, of_outputs] = [&self.model.states, &self.model.inputs, &self.model.outputs]
            .map(|list| list.iter().map(|signal| (signal.name.clone(), signal.unit.clone())).collect::<Vec<_>>());
        let states = of_states.len();
        let block = |what, rows: &Vec<(String, String)>, columns: &Vec<(String, String)>, linear: &DMatrix<f64>, at| {
            let (first, column): (usize, usize) = at;
            Block {
                what,
                rows: rows.clone(),
                columns: columns.clone(),
                linear: linear.clone(),
                reference: values.view(at, linear.shape()).into_owned(),
                error: errors.view(at, linear.shape()).into_owned(),
                bend: bends.view(at, linear.shape()).into_owned(),
                values: present.rows(first, linear.nrows()).into_owned(),
                length_m,
                short: short[column..column + linear.ncols()].to_vec(),
            }
        };
        let matrices = &self.model.matrices;
        [
            block("A", &of_states, &of_states, &matrices.a, (0, 0)),
            block("B", &of_states, &of_inputs, &matrices.b, (0, states)),
            block("C", &of_outputs, &of_states, &matrices.c, (states, 0)),
            block("D", &of_outputs, &of_inputs, &matrices.d, (states, states)),
        ]
    }
}
