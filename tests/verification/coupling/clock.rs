//! Clocks of importers that accumulate round-off: loads read at the end of an aerodynamic step.

use crate::coupling::wings::start;
use foldwing::config;
use nalgebra::Vector3;

/// Communication step in s: four aerodynamic steps of the shipped tunnel.
const STEP_S: f64 = 5e-3;

/// Aerodynamic force in N and strain at the root after every communication step of a clock; with `sways`, the wind changes at each of them.
fn read(time_s: impl Fn(u32) -> f64, sways: bool) -> Vec<(Vector3<f64>, f64)> {
    let text = include_str!("../../../examples/models/folding_wing_in_tunnel.toml");
    let text = text.replace("strips = 10", "strips = 4").replace("chord_panels = 4", "chord_panels = 2");
    let mut plant = start(config::parse(&text, "tunnel.toml").unwrap_or_else(|error| panic!("{error}")));
    let points = (1..=16).map(|step| {
        if sways {
            plant.inputs_mut().wind_m_s_mut().z = 0.1 * f64::from(step % 3);
        }
        plant.step(time_s(step)).unwrap_or_else(|error| panic!("{error}"));
        let state = plant.snapshot();
        plant.restore(&state).unwrap_or_else(|error| panic!("{error}"));
        (plant.outputs().air_total().force_n, plant.outputs().gauges()[0])
    });
    points.collect()
}

/// Values read at the end of an aerodynamic step belong to that step, whatever the last bits of the importer's clock: products, sums,
/// one bit early or late, and 1e-13 s, the error of a sum of a thousand steps. Before, a clock that was late by one bit read the loads of
/// the next step, which can differ by as much as the largest load of the run.
#[test]
fn q60_loads_do_not_depend_on_the_last_bits_of_the_clock() {
    let product = |step: u32| f64::from(step) * STEP_S;
    for sways in [false, true] {
        let right = read(product, sways);
        let largest_n = right.iter().map(|(force_n, _)| force_n.norm()).fold(0.0, f64::max);
        let largest_strain = right.iter().map(|(_, strain)| strain.abs()).fold(0.0, f64::max);
        let sum = |step: u32| (0..step).fold(0.0, |time_s, _| time_s + STEP_S);
        let clocks: [(&str, &dyn Fn(u32) -> f64); 5] = [
            ("sums", &sum),
            ("late", &|step| product(step).next_up()),
            ("early", &|step| product(step).next_down()),
            ("1e-13 s late", &|step| product(step) + 1e-13),
            ("1e-13 s early", &|step| product(step) - 1e-13),
        ];
        for (name, clock) in clocks {
            let other = read(clock, sways);
            let pairs = || right.iter().zip(&other);
            let force = pairs().map(|(a, b)| (a.0 - b.0).norm()).fold(0.0, f64::max) / largest_n;
            let strain = pairs().map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max) / largest_strain;
            println!("Q-60 {name}, wind sways {sways}: force {force:.1e}, strain {strain:.1e} of the largest");
            // loads change by their own magnitude in some milliseconds: in 1e-13 s by 1e-10 of it
            assert!(force < 1e-8 && strain < 1e-8, "{name}: {force:e}, {strain:e}");
        }
    }
}
