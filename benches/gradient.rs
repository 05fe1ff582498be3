//! Cost of the gradient of a run, in runs: on a tape, along directions, adjoint; the shipped wing to 0.4 s.
//!
//! `cargo bench -p foldwing-benches --bench gradient` (or `make bench`) prints the table of `docs/BENCHMARKS.md`. Processor time of one thread,
//! the least of repeated runs, in turn.

#[path = "../crates/study/src/latency/processor_time.rs"]
mod processor_time;

use foldwing::config;
use foldwing::plant::{Gradient, Parameter, Plant, RunResult, Tape};
use processor_time::processor_time;
use std::sync::Arc;
use std::time::Duration;

const WING: &str = include_str!("../examples/models/folding_wing.toml");
const STOP_S: f64 = 0.4;
const REPEATS: usize = 15;

/// A key of the model file with its value: numbers of joint, bodies and section.
const KEYS: [(&str, f64); 12] = [
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

/// The shipped wing with another value of all numbers of a key.
fn plant(key: &str, value: f64) -> Result<Plant, String> {
    let line = |line: &str| match line.split_once(" = ") {
        Some((found, rest)) if found == key => {
            let comment = rest.split_once(" #").map_or("", |(_, comment)| comment);
            format!("{key} = {value:e} #{comment}")
        }
        _ => line.to_owned(),
    };
    let text: Vec<String> = WING.lines().map(line).collect();
    let machine = config::parse(&text.join("\n"), "folding_wing.toml").map_err(|error| error.to_string())?;
    Ok(Plant::new(Arc::new(machine)))
}

fn parameters(count: usize) -> Vec<Parameter> {
    let parameter = |&(key, value): &(&str, f64)| {
        Parameter::new(key, value, 1e-3 * value, |value| plant(key, value)).expect("values beside are possible")
    };
    KEYS[..count].iter().map(parameter).collect()
}

fn started() -> Plant {
    let mut own = plant("", 0.0).expect("the shipped model");
    own.initialize(0.0).expect("it starts");
    own
}

fn on_tape() -> (Plant, Tape) {
    let mut own = started();
    let tape = own.run_on_tape(&[STOP_S]).expect("it runs");
    (own, tape)
}

/// Work that is prepared outside the time measured.
type Work = Box<dyn FnMut() -> Box<dyn FnOnce()>>;

fn main() {
    let results = |plant: &Plant| {
        let strain = plant.outputs().layout().gauges.place(0, 0);
        vec![RunResult::Output { index: strain, time: 0 }, RunResult::LatchTime { joint: 0 }]
    };
    let run: Work = Box::new(|| {
        let mut own = started();
        Box::new(move || own.step(STOP_S).expect("it runs"))
    });
    let taped: Work = Box::new(|| {
        let mut own = started();
        Box::new(move || drop(own.run_on_tape(&[STOP_S]).expect("it runs")))
    });
    let forward = |count: usize| -> Work {
        Box::new(move || {
            let ((mut own, tape), parameters) = (on_tape(), parameters(count));
            Box::new(move || {
                let results = results(&own);
                let mut gradient = Gradient::new(&mut own, &tape, parameters).expect("covered");
                drop(gradient.forward(&results).expect("it has derivatives"));
            })
        })
    };
    let adjoint = |count: usize| -> Work {
        Box::new(move || {
            let ((mut own, tape), parameters) = (on_tape(), parameters(count));
            Box::new(move || {
                let result = results(&own)[0];
                let mut gradient = Gradient::new(&mut own, &tape, parameters).expect("covered");
                drop(gradient.adjoint(result).expect("it has derivatives"));
            })
        })
    };
    let mut rows: Vec<(&str, Work)> = vec![
        ("run", run),
        ("run on a tape", taped),
        ("one direction: a motor's torque", forward(1)),
        ("five directions: numbers of the joint", forward(5)),
        ("twelve directions: of joint, bodies and section", forward(12)),
        ("adjoint, one parameter: a motor's torque", adjoint(1)),
        ("adjoint, five parameters of the joint", adjoint(5)),
        ("adjoint, twelve parameters", adjoint(12)),
    ];
    let mut least = vec![Duration::MAX; rows.len()];
    for _ in 0..REPEATS {
        for (least, (_, prepare)) in least.iter_mut().zip(&mut rows) {
            let work = prepare();
            let begin = processor_time().expect("a clock of the thread");
            work();
            *least = (*least).min(processor_time().expect("a clock of the thread") - begin);
        }
    }
    let (_, tape) = on_tape();
    println!("tape: {:.2} MB\n\n| shipped wing, 0.4 s | ms | runs |\n|---|---|---|", tape.bytes() as f64 / 1e6);
    for ((name, _), time) in rows.iter().zip(&least) {
        let ratio = time.as_secs_f64() / least[0].as_secs_f64();
        println!("| {name} | {:.2} | {ratio:.2} |", 1e3 * time.as_secs_f64());
    }
}
