//! Repeats one part of the gradients of the shipped wing's run to 0.4 s, for `tools/gradient_cost.py`, which counts the instructions of a call.
//!
//! `gradient_cost WORK CALLS`: `run`, `tape`, `forward N` or `adjoint N` with the first `N` of twelve parameters. Prints the results.

use foldwing_engine::beam::section::{Material, Solid};
use foldwing_engine::gradient::{Gradient, Parameter, RunResult};
use foldwing_engine::machine::{AttachedMass, Body, Gauge, Joint, Latch, Machine, Motor, Refused};
use foldwing_engine::run::Plant;
use std::sync::Arc;

const STOP_S: f64 = 0.4;
/// Largest number of calls of a run.
const MOST_RUNS: usize = 2;

/// Numbers of joint, bodies and section, in the order of the parameters.
#[derive(Clone, Copy)]
struct Numbers([f64; 12]);

const SHIPPED: Numbers = Numbers([0.043, 0.026, 8e-4, 1e4, 170.0, 2.83e9, 1425.0, 0.18, 2.5, 0.0203, 0.002, 0.05]);

fn started(numbers: Numbers) -> Result<Plant, Refused> {
    let [torque, stiffness, damping, ratio, start_deg, modulus, density, torsion, alpha, mass, height, width] =
        numbers.0;
    let material = Material { youngs_modulus_pa: modulus, shear_modulus_pa: 1e9, density_kg_m3: density };
    let mut section = Solid::rectangle(width, height, material).section();
    section.stiffness[(1, 1)] = torsion;
    let plate = |name: &str| Body::beam(name, 0.15, section.clone()).elements(4).mass_damping_1_s(alpha);
    let motor = Motor {
        stiffness_n_m_rad: stiffness,
        damping_n_m_s_rad: damping,
        constant_torque_n_m: torque,
        ..Motor::default()
    };
    let fold = Joint::revolute("fold", [0.0, 1.0, 0.0])
        .on("inner")
        .start_angle_rad(start_deg.to_radians())
        .motor(motor)
        .latch(Latch::with_ratio(ratio));
    let machine = Machine::builder("FoldingWing")
        .gravity_m_s2([-9.8, 0.0, 0.0])
        .body(plate("inner"), Joint::clamped("mount"))
        .body(plate("outer"), fold)
        .mass("inner", AttachedMass::point("actuator", 0.15, mass))
        .gauge(Gauge::on("root", "inner", 0.02))
        .stop_time_s(STOP_S)
        .step_s(5e-4)
        .build()?;
    Ok(Plant::new(Arc::new(machine)))
}

fn parameters(count: usize) -> Vec<Parameter> {
    let parameter = |place: usize| {
        let value = SHIPPED.0[place];
        let beside = |value: f64| {
            let mut numbers = SHIPPED;
            numbers.0[place] = value;
            started(numbers)
        };
        Parameter::new(format!("number {place}"), value, 1e-3 * value, beside).expect("values beside are possible")
    };
    (0..count).map(parameter).collect()
}

fn initialised() -> Plant {
    let mut plant = started(SHIPPED).expect("the shipped wing");
    plant.initialize(0.0).expect("it starts");
    plant
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let number = |word: &str| word.parse::<usize>().ok();
    let (work, count, calls) = match words[..] {
        [work @ ("run" | "tape"), calls] => (work, Some(0), number(calls)),
        [work @ ("forward" | "adjoint"), count, calls] => {
            (work, number(count).filter(|count| *count <= 12), number(calls))
        }
        _ => ("", None, None),
    };
    let (Some(count), Some(calls)) = (count, calls) else {
        eprintln!("gradient_cost run|tape|(forward|adjoint PARAMETERS) CALLS");
        std::process::exit(2);
    };
    if matches!(work, "run" | "tape") {
        // the initialisation of all plants is not part of the work
        let mut plants: Vec<Plant> = (0..MOST_RUNS).map(|_| initialised()).collect();
        for plant in plants.iter_mut().take(calls) {
            match work {
                "run" => plant.step(STOP_S).expect("it runs"),
                _ => drop(plant.run_on_tape(&[STOP_S]).expect("it has derivatives")),
            }
            plant.outputs().values().iter().for_each(|value| println!("{value:.17e}"));
        }
        return;
    }
    let mut plant = initialised();
    let tape = plant.run_on_tape(&[STOP_S]).expect("it has derivatives");
    let gauge = plant.outputs().layout().gauges.place(0, 0);
    let mut gradient = Gradient::new(&mut plant, &tape, parameters(count)).expect("covered");
    let strain = RunResult::Output { index: gauge, time: 0 };
    for call in 0..calls {
        let table = match work {
            "forward" => gradient.forward(&[strain, RunResult::LatchTime { joint: 0 }]).expect("it has derivatives"),
            _ => vec![gradient.adjoint(strain).expect("it has derivatives")],
        };
        if call + 1 == calls {
            table.iter().flatten().for_each(|slope| println!("{slope:.17e}"));
        }
    }
}
