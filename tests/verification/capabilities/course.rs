//! Inputs within a communication step.

use super::{Bench, Dice};
use crate::coupling::wings;
use foldwing::interface::Causality;

const LOAD: &str = "load.outer[4].force.z";
/// Amplitude in N and circular frequency in 1/s of the load: turns the outer wing by some 0.1 rad.
const LOAD_N: f64 = 0.05;
const OMEGA_1_S: f64 = 125.0;
/// Phase at the start. Held loads act half a step late, which the angle feels through the load at the start: without it
/// the first order would vanish.
const PHASE_RAD: f64 = 0.7;
/// Before the latch closes.
const END_S: f64 = 0.064;

/// Fold angle in rad and tip height in m after a sinusoidal load that is given at `steps` communication points.
fn under_sine(steps: usize, with_rates: bool) -> [f64; 2] {
    let mut bench = Bench::shipped("folding_wing");
    bench.set("solver.tolerance", 1e-8);
    bench.plant.initialize(0.0).expect("a start");
    for i in 0..steps {
        let time_s = END_S * i as f64 / steps as f64;
        bench.set(LOAD, LOAD_N * (OMEGA_1_S * time_s + PHASE_RAD).sin());
        if with_rates {
            bench.set_rate(LOAD, LOAD_N * OMEGA_1_S * (OMEGA_1_S * time_s + PHASE_RAD).cos());
        }
        bench.step(END_S * (i + 1) as f64 / steps as f64);
    }
    [bench.get("fold.angle"), bench.get("tip.position.z")]
}

/// E-01. A sinusoidal load given at the communication points: held, the error falls with the communication step; with
/// its derivative, with the square. Reference: 16 times finer, with derivatives.
#[test]
fn e01_input_derivatives_make_the_error_fall_with_the_square_of_the_communication_step() {
    let steps = [16, 32, 64, 128];
    let exact = under_sine(2048, true);
    let errors = |with_rates: bool| steps.map(|steps| (under_sine(steps, with_rates)[0] - exact[0]).abs());
    let (held, with_rates) = (errors(false), errors(true));
    println!("E-01: communication step in ms, error of the fold angle in rad held and with derivatives");
    for i in 0..steps.len() {
        println!("E-01: {:.3} {:.3e} {:.3e}", 1e3 * END_S / steps[i] as f64, held[i], with_rates[i]);
    }
    let order = |errors: [f64; 4]| (errors[2] / errors[3]).log2();
    println!("E-01: orders {:.2} and {:.2}", order(held), order(with_rates));
    // orders of the two finest steps, which the next power of the step changes by some percent
    assert!((order(held) - 1.0).abs() < 0.15, "held: {held:?}");
    assert!((order(with_rates) - 2.0).abs() < 0.15, "with derivatives: {with_rates:?}");
    assert!(with_rates[3] < 0.2 * held[3], "{} against {}", with_rates[3], held[3]);
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).with_file_name("verification");
    std::fs::create_dir_all(&folder).expect("writable");
    let rows = (0..4).map(|i| format!("{:e},{:e},{:e}\n", END_S / steps[i] as f64, held[i], with_rates[i]));
    let text = format!("step_s,held_rad,with_derivatives_rad\n{}", rows.collect::<String>());
    std::fs::write(folder.join("input_derivatives.csv"), text).expect("writable");
}

/// E-02. Inputs that run linearly are given exactly by value and derivative: all real inputs at once, the communication
/// step does not matter beyond the tolerance of the integration, 1e-9 per step. The account of energy holds with all of
/// them moving, to the 1e-6 of the largest kinetic energy of P-11 (4e-7 is the ringing of an abrupt start): work of
/// running fields, commands subject to a rate limit, limited torques, loads, rotation.
#[test]
fn e02_linear_inputs_are_exact_and_conserve_energy() {
    let run = |steps: usize| {
        let mut bench = Bench::shipped("branched");
        bench.set("solver.tolerance", 1e-9);
        bench.plant.initialize(0.0).expect("a start");
        let names: Vec<String> = bench.reals(Causality::Input).iter().map(|row| row.name.clone()).collect();
        let mut dice = Dice(7);
        let courses: Vec<(String, f64, f64)> = names
            .into_iter()
            .map(|name| {
                let size = if name.starts_with("load.") { 0.02 } else { 0.5 };
                (name, size * dice.roll(), 20.0 * size * dice.roll())
            })
            .collect();
        let mut kinetic_j = 0.0_f64;
        let mut balance_j = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..steps {
            let at = |i: usize| 0.04 * i as f64 / steps as f64;
            for (name, value, rate) in &courses {
                bench.set(name, value + rate * at(i));
                bench.set_rate(name, *rate);
            }
            bench.step(at(i + 1));
            let energy = bench.plant.outputs().energy();
            kinetic_j = kinetic_j.max(energy.kinetic);
            let balance = energy.total - energy.work + energy.dissipated;
            balance_j = (balance_j.0.min(balance), balance_j.1.max(balance));
        }
        let references: Vec<u32> = bench.reals(Causality::Output).iter().map(|row| row.value_reference).collect();
        let tip: Vec<f64> = (0..3).map(|i| bench.plant.outputs().tips()[0].position_m[i]).collect();
        assert!(bench.values(&references).iter().all(|value| value.is_finite()));
        (tip, (balance_j.1 - balance_j.0) / kinetic_j)
    };
    let (fine, coarse) = (run(40), run(4));
    println!("E-02: tips {:?} and {:?} m, energy {:.1e} and {:.1e}", fine.0, coarse.0, fine.1, coarse.1);
    for (fine, coarse) in fine.0.iter().zip(&coarse.0) {
        assert!((fine - coarse).abs() < 1e-7, "{fine} m and {coarse} m");
    }
    assert!(fine.1 < 1e-6 && coarse.1 < 1e-6, "drift of the energy: {:e} and {:e}", fine.1, coarse.1);
}

/// E-03. Derivatives hold for one step, and the input keeps the value reached: a get returns it, and the next step continues from there
/// without a jump. They are part of the state.
#[test]
fn e03_derivatives_hold_for_one_step_and_belong_to_the_state() {
    let mut bench = Bench::shipped("folding_wing");
    bench.set("fold.external_torque", 0.01);
    bench.set_rate("fold.external_torque", -2.0);
    let before = bench.plant.snapshot();
    bench.step(1e-3);
    assert!((bench.get("fold.external_torque") - 0.008).abs() < 1e-17);
    let first = bench.plant.outputs().clone();
    bench.step(2e-3);
    assert!((bench.get("fold.external_torque") - 0.008).abs() < 1e-17, "held from here on");
    bench.plant.restore(&before).expect("own snapshot");
    assert_eq!(bench.get("fold.external_torque"), 0.01);
    bench.step(1e-3);
    assert_eq!(*bench.plant.outputs(), first, "the derivative was restored with the state");
}

/// E-04. Wind that runs linearly, in steps of the caller of one, two and ten steps of the air, is the same wind: value and
/// way of the wind are exact, so that only the iteration's tolerance (1e-6 of the loads) and the integration's remain.
/// Steps that end inside those of the air cut them: there the difference falls with the step of the air.
#[test]
fn e04_linear_wind_is_exact_at_the_steps_of_the_air() {
    let run = |steps: usize| {
        let air = "model = \"uvlm\"\nstep_s = 1e-3\nwake_rows = 20\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 0.0]";
        let mut bench = Bench::of(wings::folding_wing(air, 3, 2));
        let at = |i: usize| 0.04 * i as f64 / steps as f64;
        for i in 0..steps {
            bench.set("wind.velocity.y", -10.0 - 100.0 * at(i));
            bench.set_rate("wind.velocity.y", -100.0);
            bench.set_rate("wind.velocity.z", 20.0);
            bench.step(at(i + 1));
        }
        (bench.get("fold.angle"), bench.get("wind.velocity.z"))
    };
    let runs = [40, 20, 4, 64].map(run);
    println!("E-04: {runs:?}");
    for (angle_rad, wind_m_s) in runs {
        assert!((wind_m_s - 0.8).abs() < 1e-12, "the wind stays where its rates have led: {wind_m_s} m/s");
        assert!((angle_rad - runs[0].0).abs() < 1e-4, "{runs:?}");
    }
    assert!((runs[1].0 - runs[0].0).abs() < 1e-6 && (runs[2].0 - runs[0].0).abs() < 1e-6, "{runs:?}");
}
