//! Gradients against each other and against differences of runs with the same steps.

use super::*;
use crate::beam::profile::Profile as Along;
use crate::beam::section::{Material, Solid};
use crate::gradient::tape::{Ending, Step};
use crate::machine::builder::{JointBuilder, MachineBuilder};
use crate::machine::{
    Air, AttachedMass, Beyond, Body, Effect, EndStops, Failure, Gauge, GeneratorLaw, Joint, JointKind, JointMotion,
    Latch, LatchKind, LiftingSurface, Machine, Method, Motion, Motor, OneFreedom, Solver, Spring, StartState,
};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

mod accounts;
mod air;
mod airs;
mod chains;
mod constraints;
mod electric;
mod failures;
mod folding;
mod generators;
mod inputs;
mod integrals_in_air;
mod limits;
mod means;
mod modal;
mod motor;
mod prescribed;
mod refusals;
mod rigid;
mod rotor;
mod rows;
mod rows_in_air;
mod shear;
mod spatial;
mod staggered;
mod starts;

fn solver() -> Solver {
    // Newton's iteration to 1e-12: the tape's points then fulfil the equations that are differentiated
    Solver { tolerance: 1e-10, fixed_step_s: Some(4e-3), ..Solver::default() }
}

/// Numbers of a folding wing.
#[derive(Clone, Copy)]
struct Numbers {
    stiffness: f64,
    damping: f64,
    torque: f64,
    command: f64,
    latch_stiffness: f64,
    latch_angle: f64,
    stop: f64,
    start_angle: f64,
    start_rate: f64,
    length: f64,
    thickness: f64,
    density: f64,
    mass: f64,
    beta: f64,
    load: f64,
    limit: f64,
    rate_limit: f64,
    fail_s: f64,
    delay_s: f64,
    remaining: f64,
    brake: f64,
    ramp_s: f64,
    slip: f64,
    runaway: f64,
    gear: f64,
    row: f64,
    row_torque: f64,
    gain: f64,
    resistance: f64,
    inductance: f64,
    torque_constant: f64,
    voltage: f64,
    current: f64,
    rotor: f64,
    ratio: f64,
}

impl Numbers {
    const USUAL: Self = Self {
        stiffness: 0.4,
        damping: 0.02,
        torque: 0.15,
        command: 0.2,
        latch_stiffness: 60.0,
        latch_angle: 0.0,
        stop: 0.35,
        start_angle: 1.2,
        start_rate: -0.3,
        length: 0.4,
        thickness: 0.004,
        density: 1400.0,
        mass: 0.05,
        beta: 1e-3,
        load: 0.3,
        limit: 0.31,
        rate_limit: 3.0,
        fail_s: 0.103,
        delay_s: 0.02,
        remaining: 0.3,
        brake: 0.2,
        ramp_s: 0.06,
        slip: 0.5,
        runaway: 0.9,
        gear: 10.0,
        row: 15.0,
        row_torque: 0.004,
        gain: 2e-5,
        resistance: 2.0,
        inductance: 4e-3,
        torque_constant: 0.01,
        voltage: 3.0,
        current: 0.2,
        rotor: 3e-4,
        ratio: 0.02,
    };

    fn machine(self, latched: bool) -> Result<Machine, String> {
        self.builder(latched).build().map_err(|refused| refused.to_string())
    }

    fn builder(self, latched: bool) -> MachineBuilder {
        self.builder_on(hinge(), latched)
    }

    /// The wing on a root joint.
    fn builder_on(self, root: JointBuilder, latched: bool) -> MachineBuilder {
        self.builder_with(|solid| solid, root, latched)
    }

    /// The same with sections that a function changes.
    fn builder_with(self, change: fn(Solid) -> Solid, root: JointBuilder, latched: bool) -> MachineBuilder {
        let material = |density_kg_m3| Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3 };
        let section = change(Solid::rectangle(0.05, self.thickness, material(self.density)));
        let inner = Body::beam("inner", self.length, section)
            .elements(2)
            .mass_damping_1_s(0.5)
            .stiffness_damping_s(self.beta)
            .load_stations(1);
        let outer = Body::beam("outer", 0.3, section).elements(2).stiffness_damping_s(self.beta);
        let drive = Motor {
            stiffness_n_m_rad: self.stiffness,
            damping_n_m_s_rad: self.damping,
            constant_torque_n_m: self.torque,
            command_rad: self.command,
            inertia_kg_m2: 1e-4,
            ..Motor::default()
        };
        let mut fold = Joint::revolute("fold", [1.0, 0.1, 0.0])
            .on("inner")
            .offset_m([0.01, 0.0, 0.005])
            .motor(drive)
            .start_angle_rad(self.start_angle)
            .start_rate_rad_s(self.start_rate);
        if latched {
            let latch =
                Latch::with_stiffness_n_m_rad(self.latch_stiffness).angle_rad(self.latch_angle).capture_rad(0.01);
            fold = fold.latch(latch);
        } else {
            let stops = EndStops {
                lower_rad: Some(self.stop),
                upper_rad: None,
                stiffness_n_m_rad: 20.0,
                damping_n_m_s_rad: 0.05,
            };
            fold = fold.end_stops(stops);
        }
        let wrench = crate::load::Wrench { force_n: [0.0, 0.0, self.load].into(), ..Default::default() };
        Machine::builder("Folding")
            .gravity_m_s2([0.0, 0.0, -9.81])
            .body(inner, root)
            .body(outer, fold)
            .mass("outer", AttachedMass::point("tip", 0.3, self.mass))
            .load("pull", "inner", 1, wrench)
            .gauge(Gauge::on("root", "inner", 0.05))
            .solver(solver())
    }
}

/// Root joint of the wing.
fn hinge() -> JointBuilder {
    Joint::revolute("flap", [0.0, 1.0, 0.0]).spring(Spring { stiffness_n_m_rad: 40.0, ..Spring::default() })
}

/// A number and its place.
type Place = (&'static str, fn(&mut Numbers) -> &mut f64);

const PLACES: [Place; 15] = [
    ("stiffness", |n| &mut n.stiffness),
    ("damping", |n| &mut n.damping),
    ("torque", |n| &mut n.torque),
    ("command", |n| &mut n.command),
    ("latch_stiffness", |n| &mut n.latch_stiffness),
    ("latch_angle", |n| &mut n.latch_angle),
    ("stop", |n| &mut n.stop),
    ("start_angle", |n| &mut n.start_angle),
    ("start_rate", |n| &mut n.start_rate),
    ("length", |n| &mut n.length),
    ("thickness", |n| &mut n.thickness),
    ("density", |n| &mut n.density),
    ("mass", |n| &mut n.mass),
    ("beta", |n| &mut n.beta),
    ("load", |n| &mut n.load),
];

fn beside((_, place): Place, shift: f64) -> Numbers {
    let mut numbers = Numbers::USUAL;
    *place(&mut numbers) += shift;
    numbers
}

fn size(place: Place) -> f64 {
    let mut numbers = Numbers::USUAL;
    let value = (place.1)(&mut numbers).abs();
    if value == 0.0 { 1.0 } else { value }
}

fn started(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

const TIMES_S: [f64; 2] = [0.26, 0.4];
/// Step of the differences of runs as a share of a number: their truncation is that of stiff motions behind an impulse.
const DIFFERENCE: f64 = 5e-4;
/// Difference of values along the same steps, as a share of a value, that the tolerance of Newton's iteration leaves.
const SAME_VALUE: f64 = 1e-8;
/// The same from crossings: a run locates them to 1e-10 s, the one along its steps to round-off, and values change by up to 15 per s there.
const SAME_CROSSING: f64 = 15.0 * 1e-10;
/// Slope of a result by a number, as a share of both, that is round-off.
const NO_SLOPE: f64 = 1e-9;

/// The run of another machine with the steps of a tape: the chosen lengths stay, crossings are located, requested times are reached.
fn retraced(tape: &Tape, machine: Machine, results: &[RunResult]) -> Vec<f64> {
    retraced_with(tape, machine, &tape.inputs, results)
}

/// The same with other inputs over time, whose rows have the times of those of the tape.
fn retraced_with(tape: &Tape, machine: Machine, inputs: &InputRows, results: &[RunResult]) -> Vec<f64> {
    retraced_at(tape, machine, inputs, (&TIMES_S, results))
}

/// The same for results at other times.
fn retraced_at(
    tape: &Tape,
    machine: Machine,
    inputs: &InputRows,
    (times_s, results): (&[f64], &[RunResult]),
) -> Vec<f64> {
    let mut plant = Plant::new(Arc::new(machine));
    inputs.set(&mut plant, 0.0);
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let mut copy = plant.run_along(tape, inputs).unwrap_or_else(|error| panic!("{error}"));
    for time_s in times_s {
        plant.request(&mut copy, *time_s).unwrap_or_else(|error| panic!("{error}"));
    }
    let mut gradient = Gradient::new(&mut plant, &copy, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    gradient.values(results).unwrap_or_else(|error| panic!("{error}"))
}

struct Compared {
    forward_and_adjoint: f64,
    differences: f64,
    events: usize,
}

/// A plant of a machine, with the start values of the machine.
fn plant_of(machine: Result<Machine, String>) -> Result<Plant, String> {
    machine.map(|machine| Plant::new(Arc::new(machine)))
}

/// Gradients of a machine's results by its numbers, both ways and by fourth-order differences of runs with the same steps: the largest
/// differences, each relative to the result's largest entry of a parameter times the parameter's size.
fn compare(latched: bool, places: &[Place]) -> Compared {
    compare_machines(latched, |numbers| numbers.machine(latched), places)
}

fn compare_machines(latched: bool, machine: impl Fn(Numbers) -> Result<Machine, String>, places: &[Place]) -> Compared {
    compare_results(machine, &InputRows::default(), places, |plant| {
        let layout = *plant.outputs().layout();
        let [gauge, tip, energy, angle] =
            [layout.gauges.place(0, 0), layout.tips.place(0, 0), layout.energy.place(0, 0), layout.joints.place(0, 0)];
        let output = |index: usize, time: usize| RunResult::Output { index, time };
        let mut results =
            vec![output(gauge, 0), output(tip + 2, 0), output(energy, 1), output(angle, 1), output(gauge, 1)];
        if latched {
            results.push(RunResult::LatchTime { joint: 1 });
        }
        results
    })
}

/// The same for results that a function gives, with inputs over time.
fn compare_results(
    machine: impl Fn(Numbers) -> Result<Machine, String>,
    inputs: &InputRows,
    places: &[Place],
    results: impl Fn(&Plant) -> Vec<RunResult>,
) -> Compared {
    compare_over(DIFFERENCE, machine, inputs, places, results)
}

/// The same with another step of the differences, as a share of a number.
fn compare_over(
    difference: f64,
    machine: impl Fn(Numbers) -> Result<Machine, String>,
    inputs: &InputRows,
    places: &[Place],
    results: impl Fn(&Plant) -> Vec<RunResult>,
) -> Compared {
    let mut plant = Plant::new(Arc::new(machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}"))));
    inputs.set(&mut plant, 0.0);
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let tape = plant.run_on_tape_with(inputs, &TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    let results = results(&plant);
    let events = tape.steps.iter().filter(|step| matches!(step.ending, Ending::Crossing(_))).count();
    let parameters: Vec<Parameter> = places
        .iter()
        .map(|place| {
            Parameter::new(place.0, 0.0, 1e-3 * size(*place), |shift| plant_of(machine(beside(*place, shift))))
                .unwrap_or_else(|error| panic!("{error}"))
        })
        .collect();
    let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let adjoint: Vec<Vec<f64>> =
        results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();
    let own = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let same = machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}"));
    same_values(&own, &retraced(&tape, same, &results));
    let mut known = vec![vec![0.0; places.len()]; results.len()];
    for (column, place) in places.iter().enumerate() {
        let step = difference * size(*place);
        for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let there = machine(beside(*place, steps * step)).unwrap_or_else(|error| panic!("{error}"));
            for (row, value) in known.iter_mut().zip(retraced(&tape, there, &results)) {
                row[column] += weight / (12.0 * step) * value;
            }
        }
    }
    let places: Vec<(&str, f64)> = places.iter().map(|place| (place.0, size(*place))).collect();
    let [forward_and_adjoint, differences] = disagreements((&results, &own), &places, [&forward, &adjoint, &known]);
    Compared { forward_and_adjoint, differences, events }
}

/// Asserts that results of a run and of the same machine along its steps are equal.
fn same_values(own: &[f64], along: &[f64]) {
    for (own, along) in own.iter().zip(along) {
        assert!((own - along).abs() <= SAME_VALUE * along.abs() + SAME_CROSSING, "{own} and {along}");
    }
}

/// Largest differences of forward and adjoint, and of forward and known derivatives (results by numbers), relative to the largest known
/// entry of a result, each times the size of its number, given with its name. The derivatives of a result that no number changes are
/// round-off.
fn disagreements(
    (results, own): (&[RunResult], &[f64]),
    places: &[(&str, f64)],
    [forward, adjoint, known]: [&[Vec<f64>]; 3],
) -> [f64; 2] {
    let mut worst = [0.0f64; 2];
    for (row, result) in results.iter().enumerate() {
        let entry = |table: &[Vec<f64>], column: usize| table[row][column] * places[column].1;
        let most = |table| (0..places.len()).fold(0.0, |most, column| larger(most, entry(table, column).abs()));
        let scale = most(known);
        if scale <= NO_SLOPE * own[row].abs() {
            let most = larger(most(forward), most(adjoint));
            assert!(most <= NO_SLOPE * own[row].abs(), "{result:?} of {:e}: {most:.1e}", own[row]);
            continue;
        }
        for (column, (name, _)) in places.iter().enumerate() {
            let [forward, adjoint, known] = [forward, adjoint, known].map(|table| entry(table, column) / scale);
            let apart = [(forward - adjoint).abs(), (forward - known).abs()];
            worst = [0, 1].map(|which| larger(worst[which], apart[which]));
            if apart[0] > 1e-10 || apart[1] > 1e-6 {
                println!("{result:?} of {:e} by {name}: {forward} {adjoint} {known}, {scale:e}", own[row]);
            }
        }
    }
    worst
}

/// The larger of two disagreements: one that is not a number is infinite, which `f64::max` would leave out.
fn larger(worst: f64, apart: f64) -> f64 {
    if apart.is_nan() { f64::INFINITY } else { worst.max(apart) }
}

/// GR-01: through an elastic latch, by fourteen numbers of drive, latch, start, beams, masses and loads.
#[test]
fn gradients_pass_through_a_latch() {
    let places: Vec<Place> = PLACES.into_iter().filter(|place| place.0 != "stop").collect();
    let Compared { forward_and_adjoint, differences, events } = compare(true, &places);
    assert!(events > 0, "no event");
    assert!(forward_and_adjoint < 1e-10, "{forward_and_adjoint:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-02: onto an end stop, the damping of the stop included.
#[test]
fn gradients_pass_through_an_end_stop() {
    let places: Vec<Place> = PLACES.into_iter().filter(|place| !place.0.starts_with("latch")).collect();
    let Compared { forward_and_adjoint, differences, events } = compare(false, &places);
    assert!(events > 0, "no event");
    assert!(forward_and_adjoint < 1e-10, "{forward_and_adjoint:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-03: forward and adjoint are transposes of one another for 20 wings with random numbers, with a latch and with a stop, crossed or not:
/// `⟨ȳ, J δ⟩ = ⟨Jᵀ ȳ, δ⟩` to 1e-10 of the sum of the terms' sizes.
#[test]
fn forward_and_adjoint_are_transposes_for_random_wings() {
    let places = [PLACES[0], PLACES[5], PLACES[7], PLACES[9]];
    let (mut worst, mut events) = (0.0f64, 0);
    for seed in 0..20 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut numbers = Numbers::USUAL;
        for (_, place) in PLACES {
            *place(&mut numbers) *= 0.8 + 0.4 * random.f64();
        }
        let machine = |place: Place, shift: f64| {
            let mut beside = numbers;
            *(place.1)(&mut beside) += shift;
            let mut machine = beside.machine(seed % 2 == 0)?;
            machine.solver = Solver::default();
            Ok(machine)
        };
        let mut plant = started(machine(places[0], 0.0).unwrap_or_else(|error| panic!("{error}")));
        let tape = plant.run_on_tape(&[0.1, 0.16]).unwrap_or_else(|error| panic!("{error}"));
        events += tape.steps.iter().filter(|step| matches!(step.ending, Ending::Crossing(_))).count();
        let parameters: Vec<Parameter> = places
            .iter()
            .map(|place| Parameter::new(place.0, 0.0, 1e-3 * size(*place), |shift| plant_of(machine(*place, shift))))
            .collect::<Result<_, _>>()
            .unwrap_or_else(|error| panic!("{error}"));
        let layout = *plant.outputs().layout();
        let results = [layout.gauges.place(0, 0), layout.energy.place(0, 0), layout.tips.place(0, 0)]
            .map(|index| RunResult::Output { index, time: 1 });
        let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
        let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
        for (row, result) in forward.iter().zip(results) {
            let back = gradient.adjoint(result).unwrap_or_else(|error| panic!("{error}"));
            let along: Vec<f64> = places.iter().map(|place| size(*place) * (2.0 * random.f64() - 1.0)).collect();
            let terms = row.iter().zip(&along).map(|(slope, along)| (slope * along).abs()).sum::<f64>();
            worst = larger(worst, (dot(row, &along) - dot(&back, &along)).abs() / terms);
        }
    }
    assert!(events >= 10, "{events}");
    assert!(worst < 1e-10, "{worst:.1e}");
}
