//! responses of the linear aeroelastic model to a gust, to wind and to a force, against those of the nonlinear machine in time, for
//! small inputs, deployed and folded.

use crate::whole::is_whole;
use foldwing::config;
use foldwing::interface::{Interface, LinearModel};
use foldwing::machine::Machine;
use foldwing::plant::Plant;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Duration of the input pulse, and end of the record, in s.
const BUMP_S: f64 = 0.06;
const END_S: f64 = 0.12;
/// Steps of the record in s.
const SAMPLE_S: f64 = 1e-3;

/// Input that has the pulse.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Bump {
    Gust,
    Wind,
    Force,
}

impl Bump {
    /// Amplitude: small compared with a wind of 20 m/s, and with the wing's weight of 0.4 N.
    fn size(self) -> f64 {
        if self == Self::Force { 1e-4 } else { 1e-3 }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Gust => "gust.z",
            Self::Wind => "wind.velocity.z",
            Self::Force => "load.outer[4].force.z",
        }
    }
}

/// `(1 − cos)/2`.
fn bump(time_s: f64) -> f64 {
    if time_s < BUMP_S { 0.5 * (1.0 - (std::f64::consts::TAU * time_s / BUMP_S).cos()) } else { 0.0 }
}

/// The shipped folding wing in a wind that loads it; `step_s` is the aerodynamic step. The gust travels so fast that it reaches the whole
/// wing at once.
fn machine(angle_deg: f64, held: bool, step_s: f64, gust_m_s: f64) -> Machine {
    let text = include_str!("../../../examples/models/folding_wing.toml");
    let text: String = text
        .lines()
        .map(|line| match line.split(" = ").next() {
            Some("start_angle_deg") => format!("start_angle_deg = {angle_deg:?}\nrelease = {}\n", !held),
            Some("release") => String::new(),
            _ => format!("{line}\n"),
        })
        .collect();
    let (text, _) = text.split_once("[simulation]").expect("an experiment at the end");
    let speed_m_s = 1e7;
    let text = format!(
        "{text}\n[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0.0, -20.0, 0.5]\nstep_s = {step_s:?}\n\
         coupling_tolerance = 1e-9\n[surface.inner]\nbody = \"inner\"\nstrips = 4\n[surface.outer]\nbody = \"outer\"\nstrips = 4\n\
         [gust.bump]\nshape = \"one_minus_cosine\"\nvelocity_m_s = [0.0, 0.0, {gust_m_s:?}]\nlength_m = {:?}\n\
         direction = [0.0, -1.0, 0.0]\nspeed_m_s = {speed_m_s:?}\n\
         [simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\nstart = \"equilibrium\"\n",
        BUMP_S * speed_m_s,
    );
    config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Position of the tip and bending strain over time, minus their values at the start, from a simulation.
fn marched(angle_deg: f64, held: bool, step_s: f64, kind: Bump, size: f64) -> Vec<[f64; 2]> {
    let gust = if kind == Bump::Gust { size } else { 0.0 };
    let mut plant = Plant::new(Arc::new(machine(angle_deg, held, step_s, gust)));
    plant.parameters_mut().solver_mut().tolerance = 1e-9;
    plant.parameters_mut().solver_mut().max_step_s = step_s;
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let read = |plant: &Plant| {
        let outputs = plant.outputs();
        [outputs.tips()[0].position_m.z, outputs.gauges()[0]]
    };
    let start = read(&plant);
    let wind_m_s = *plant.inputs().wind_m_s();
    let samples = (END_S / SAMPLE_S).round() as u32;
    (1..=samples)
        .map(|i| {
            let (from, to) = (f64::from(i - 1) * SAMPLE_S, f64::from(i) * SAMPLE_S);
            let (value, rate) = (size * bump(from), size * (bump(to) - bump(from)) / SAMPLE_S);
            match kind {
                Bump::Gust => {}
                Bump::Wind => {
                    plant.inputs_mut().wind_m_s_mut().z = wind_m_s.z + value;
                    plant.input_rates_mut().wind_m_s_mut().z = rate;
                }
                Bump::Force => {
                    let last = plant.inputs().stations().len() - 1;
                    plant.inputs_mut().stations_mut()[last].force_n.z = value;
                    plant.input_rates_mut().stations_mut()[last].force_n.z = rate;
                }
            }
            plant.step(to).unwrap_or_else(|error| panic!("{error}"));
            let now = read(&plant);
            [now[0] - start[0], now[1] - start[1]]
        })
        .collect()
}

/// The same quantities from the linear model, by the trapezoidal rule in steps of 1/40 of the samples.
fn linear(model: &LinearModel, size: f64) -> Vec<[f64; 2]> {
    let m = &model.matrices;
    let (n, parts) = (m.a.nrows(), 40);
    let step_s = SAMPLE_S / f64::from(parts);
    let one = DMatrix::<f64>::identity(n, n);
    let ahead = (&one - &m.a * (0.5 * step_s)).lu();
    let back = &one + &m.a * (0.5 * step_s);
    let mut x = DVector::zeros(n);
    let samples = (END_S / SAMPLE_S).round() as u32;
    // inputs as in the plant: linear between the samples, except for the gust, which is a given function
    let input = |i: u32, part: u32| {
        let at = (f64::from(i) + f64::from(part) / f64::from(parts)) * SAMPLE_S;
        if model.inputs[0].name == "gust.z" {
            return size * bump(at);
        }
        let ends = [f64::from(i), f64::from(i + 1)].map(|at| bump(at * SAMPLE_S));
        size * (ends[0] + (ends[1] - ends[0]) * f64::from(part) / f64::from(parts))
    };
    (0..samples)
        .map(|i| {
            let mut last = 0.0;
            for part in 0..parts {
                let ends = [input(i, part), input(i, part + 1)];
                let right = &back * &x + m.b.column(0) * (0.5 * step_s * (ends[0] + ends[1]));
                x = ahead.solve(&right).expect("regular");
                last = ends[1];
            }
            let y = &m.c * &x + m.d.column(0) * last;
            [y[0], y[1]]
        })
        .collect()
}

/// Held at 60° and free behind a closed latch at 0°: largest difference of tip and root strain relative to the largest value. The
/// simulation is extrapolated to zero step by its second order. Short studies: the gust with the tip held, the wind with the latch.
#[test]
fn q66_small_inputs_move_the_linear_model_as_the_machine() {
    for (angle_deg, held) in [(60.0, true), (0.0, false)] {
        for kind in [Bump::Gust, Bump::Wind, Bump::Force] {
            if !is_whole() && (kind == Bump::Force || (kind == Bump::Wind) == held) {
                continue;
            }
            let machine = machine(angle_deg, held, 1e-3, 0.0);
            let interface = Interface::new(&machine);
            let mut plant = Plant::new(Arc::new(machine));
            plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
            let named = |name: &str| interface.find(name).unwrap_or_else(|| panic!("{name}"));
            let gauge = interface.real_outputs().find(|row| row.name.starts_with("gauge.")).expect("a gauge");
            let outputs = [named("tip.position.z"), gauge];
            let model = match kind {
                Bump::Gust => interface.linearize_in_gusts(&mut plant, &[], &[2], &outputs),
                _ => interface.linearize(&mut plant, &[named(kind.name())], &outputs),
            };
            let model = model.unwrap_or_else(|error| panic!("{error}"));
            assert!(!model.without_air);
            let expected = linear(&model, kind.size());
            let runs = [1e-3, 0.5e-3].map(|step_s| marched(angle_deg, held, step_s, kind, kind.size()));
            for output in 0..2 {
                let size = expected.iter().fold(0.0f64, |size, y| size.max(y[output].abs()));
                let off = |marched: &dyn Fn(usize) -> f64| {
                    let differences = expected.iter().enumerate().map(|(i, y)| (y[output] - marched(i)).abs());
                    differences.fold(0.0, f64::max) / size
                };
                let limit = |i: usize| runs[1][i][output] + (runs[1][i][output] - runs[0][i][output]) / 3.0;
                let found = [off(&|i| runs[0][i][output]), off(&|i| runs[1][i][output]), off(&limit)];
                println!("Q-66 {angle_deg} deg, {kind:?}, output {output}: size {size:.2e}, off {found:.6?}");
                assert!(found[2] < 1e-4, "{angle_deg} {kind:?} {output}: {found:?}");
            }
        }
    }
}
