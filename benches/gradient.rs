//! Cost of the gradient of a run relative to that of a run: recorded on a tape, forward along directions, and adjoint; the shipped wing and
//! the flared wing tip in a gust, up to 0.4 s.
//!
//! `cargo bench -p foldwing-benches --bench gradient` (or `make bench`) prints the table of `docs/BENCHMARKS.md`. The times are processor
//! times of one thread, the smallest of repeated runs that alternate.

#[path = "../crates/study/src/latency/processor_time.rs"]
mod processor_time;

use foldwing::config;
use foldwing::plant::{Gradient, Parameter, Plant, RunResult, Tape};
use processor_time::processor_time;
use std::sync::Arc;
use std::time::Duration;

const WING: &str = include_str!("../examples/models/folding_wing.toml");
const IN_AIR: &str = include_str!("../examples/models/flared_wing_tip.toml");
const STOP_S: f64 = 0.4;
const REPEATS: usize = 15;

/// A key of a model file and its value.
type Key = (&'static str, f64);

/// Numbers of the wing with aerodynamics.
const KEYS_IN_AIR: [Key; 5] = [
    ("density_kg_m3", 1.225),
    ("incidence_deg", 3.0),
    ("damping_N_m_s_rad", 0.02),
    ("torsional_rigidity_N_m2", 120.0),
    ("flap_stiffness_N_m2", 150.0),
];

/// Numbers of joint, bodies and section.
const KEYS: [Key; 12] = [
    ("constant_torque_N_m", 0.043),
    ("stiffness_N_m_rad", 0.026),
    ("damping_N_m_s_rad", 0.0008),
    ("stiffness_ratio", 1e4),
    ("start_angle_deg", 170.0),
    ("youngs_modulus_Pa", 2.83e9),
    ("density_kg_m3", 1425.0),
    ("torsional_rigidity_N_m2", 0.18),
    ("mass_damping_1_s", 2.5),
    ("mass_kg", 0.0203),
    ("height_m", 0.002),
    ("width_m", 0.05),
];

/// A machine with another value for all occurrences of a key.
fn plant(model: &str, key: &str, value: f64) -> Result<Plant, String> {
    let line = |line: &str| match line.split_once(" = ") {
        Some((found, rest)) if found == key => {
            let comment = rest.split_once(" #").map_or("", |(_, comment)| comment);
            format!("{key} = {value:e} #{comment}")
        }
        _ => line.to_owned(),
    };
    let text: Vec<String> = model.lines().map(line).collect();
    let machine = config::parse(&text.join("\n"), "model.toml").map_err(|error| error.to_string())?;
    Ok(Plant::new(Arc::new(machine)))
}

fn parameters(model: &str, keys: &[Key]) -> Vec<Parameter> {
    let parameter = |&(key, value): &Key| {
        Parameter::new(key, value, 1e-3 * value, |value| plant(model, key, value)).expect("values beside are possible")
    };
    keys.iter().map(parameter).collect()
}

fn started(model: &str) -> Plant {
    let mut own = plant(model, "", 0.0).expect("the shipped model");
    own.initialize(0.0).expect("it starts");
    own
}

fn on_tape(model: &str) -> (Plant, Tape) {
    let mut own = started(model);
    let tape = own.run_on_tape(&[STOP_S]).expect("it runs");
    (own, tape)
}

/// Work that is prepared outside the measured time.
type Work = Box<dyn FnMut() -> Box<dyn FnOnce()>>;

fn results(plant: &Plant) -> Vec<RunResult> {
    let strain = plant.outputs().layout().gauges.place(0, 0);
    vec![RunResult::Output { index: strain, time: 0 }]
}

fn run(model: &'static str) -> Work {
    Box::new(move || {
        let mut own = started(model);
        Box::new(move || own.step(STOP_S).expect("it runs"))
    })
}

fn taped(model: &'static str) -> Work {
    Box::new(move || {
        let mut own = started(model);
        Box::new(move || drop(own.run_on_tape(&[STOP_S]).expect("it runs")))
    })
}

fn forward(model: &'static str, keys: &'static [Key], latches: bool) -> Work {
    Box::new(move || {
        let ((mut own, tape), parameters) = (on_tape(model), parameters(model, keys));
        Box::new(move || {
            let mut results = results(&own);
            results.extend(latches.then_some(RunResult::LatchTime { joint: 0 }));
            let mut gradient = Gradient::new(&mut own, &tape, parameters).expect("covered");
            drop(gradient.forward(&results).expect("it has derivatives"));
        })
    })
}

fn adjoint(model: &'static str, keys: &'static [Key]) -> Work {
    Box::new(move || {
        let ((mut own, tape), parameters) = (on_tape(model), parameters(model, keys));
        Box::new(move || {
            let result = results(&own)[0];
            let mut gradient = Gradient::new(&mut own, &tape, parameters).expect("covered");
            drop(gradient.adjoint(result).expect("it has derivatives"));
        })
    })
}

fn main() {
    let rows = vec![
        ("run", run(WING)),
        ("run on a tape", taped(WING)),
        ("one direction: a motor's torque", forward(WING, &KEYS[..1], true)),
        ("five directions: numbers of the joint", forward(WING, &KEYS[..5], true)),
        ("twelve directions: of joint, bodies and section", forward(WING, &KEYS, true)),
        ("adjoint, one parameter: a motor's torque", adjoint(WING, &KEYS[..1])),
        ("adjoint, five parameters of the joint", adjoint(WING, &KEYS[..5])),
        ("adjoint, twelve parameters", adjoint(WING, &KEYS)),
    ];
    print("shipped wing", WING, rows);
    let rows = vec![
        ("run", run(IN_AIR)),
        ("run on a tape", taped(IN_AIR)),
        ("one direction: the density", forward(IN_AIR, &KEYS_IN_AIR[..1], false)),
        ("five directions: of air, surfaces, joint and section", forward(IN_AIR, &KEYS_IN_AIR, false)),
        ("adjoint, one parameter: the density", adjoint(IN_AIR, &KEYS_IN_AIR[..1])),
        ("adjoint, five parameters", adjoint(IN_AIR, &KEYS_IN_AIR)),
    ];
    print("flared wing tip", IN_AIR, rows);
}

/// Measures the works alternately and prints their table.
fn print(name: &str, model: &str, mut rows: Vec<(&str, Work)>) {
    let mut least = vec![Duration::MAX; rows.len()];
    for _ in 0..REPEATS {
        for (least, (_, prepare)) in least.iter_mut().zip(&mut rows) {
            let work = prepare();
            let begin = processor_time().expect("a clock of the thread");
            work();
            *least = (*least).min(processor_time().expect("a clock of the thread") - begin);
        }
    }
    let (_, tape) = on_tape(model);
    println!("tape: {:.2} MB\n\n| {name}, 0.4 s | ms | runs |\n|---|---|---|", tape.bytes() as f64 / 1e6);
    for ((name, _), time) in rows.iter().zip(&least) {
        let ratio = time.as_secs_f64() / least[0].as_secs_f64();
        println!("| {name} | {:.2} | {ratio:.2} |", 1e3 * time.as_secs_f64());
    }
    println!();
}
