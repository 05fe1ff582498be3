//! Wings with aerodynamics, as model texts: the shipped folding wing with surfaces on both bodies.

use foldwing::config;
use foldwing::machine::Machine;
use foldwing::plant::Plant;
use std::fmt::Write;
use std::sync::Arc;

/// The shipped folding wing with aerodynamics: `air` are the lines of `[aerodynamics]`, `strips` the number per body; strip theory has no
/// panels along the chord.
pub fn folding_wing(air: &str, strips: usize, chord_panels: usize) -> Machine {
    with(include_str!("../../../examples/models/folding_wing.toml"), air, strips, chord_panels)
}

/// The folding wing with all structural quantities divided by a number: masses, stiffnesses, torques. In vacuum its motion is unchanged.
pub fn light_wing(divisor: f64, air: &str, strips: usize) -> Machine {
    let mut text = include_str!("../../../examples/models/folding_wing.toml").replace("elements = 4", "elements = 1");
    for (key, value) in [
        ("density_kg_m3", 1425.0),
        ("youngs_modulus_Pa", 2.83e9),
        ("torsional_rigidity_N_m2", 0.18),
        ("mass_kg", 0.0203),
        ("stiffness_N_m_rad", 0.026),
        ("damping_N_m_s_rad", 0.0008),
        ("constant_torque_N_m", 0.043),
    ] {
        let line = |value: f64| format!("\n{key} = {value}\n");
        let stated =
            text.lines().find(|line| line.starts_with(&format!("{key} = "))).expect("a key of the file").to_owned();
        let number: f64 = stated.split(" = ").nth(1).and_then(|number| number.parse().ok()).expect("a number");
        assert_eq!(number, value, "{key}");
        text = text.replacen(&format!("\n{stated}\n"), &line(value / divisor), 1);
    }
    with(&text, air, strips, 1)
}

fn with(model: &str, air: &str, strips: usize, chord_panels: usize) -> Machine {
    let mut text = format!("{model}\n[aerodynamics]\n{air}\n");
    let panels = if air.contains("\"strip\"") { String::new() } else { format!("chord_panels = {chord_panels}\n") };
    for body in ["inner", "outer"] {
        write!(text, "[surface.{body}]\nbody = \"{body}\"\nstrips = {strips}\n{panels}").expect("a String takes all");
    }
    config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// A plant at time zero.
pub fn start(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Simulates to `end_s` in communication steps and returns the plant.
pub fn march(mut plant: Plant, end_s: f64, steps: u32) -> Plant {
    let from_s = plant.time_s();
    for i in 1..=steps {
        let end = from_s + (end_s - from_s) * f64::from(i) / f64::from(steps);
        plant.step(end).unwrap_or_else(|error| panic!("{error}"));
    }
    plant
}
