//! Control surfaces on machines: response of the linear model against the simulated machine, equilibrium, snapshots, both sides of a wing.

use foldwing::config;
use foldwing::interface::{Interface, LinearModel};
use foldwing::machine::Machine;
use foldwing::plant::Plant;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Duration of the deflection pulse, and end of the record, in s.
const BUMP_S: f64 = 0.06;
const END_S: f64 = 0.12;
/// Steps of the record in s.
const SAMPLE_S: f64 = 1e-3;
/// Largest deflection in rad: small compared with an incidence of 0.025.
const SIZE_RAD: f64 = 1e-5;

/// `(1 − cos)/2` and its rate in 1/s.
fn bump(time_s: f64) -> [f64; 2] {
    let phase = TAU * time_s / BUMP_S;
    if time_s < BUMP_S { [0.5 * (1.0 - phase.cos()), 0.5 * TAU / BUMP_S * phase.sin()] } else { [0.0, 0.0] }
}

/// The shipped folding wing with an aileron on the folding part, in a wind that loads the wing.
fn machine(angle_deg: f64, held: bool, model: &str, step_s: f64) -> Machine {
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
    let panels = if model == "uvlm" { "chord_panels = 4\n" } else { "" };
    let text = format!(
        "{text}\n[aerodynamics]\nmodel = {model:?}\nwind_m_s = [0.0, -20.0, 0.5]\nstep_s = {step_s:?}\n\
         coupling_tolerance = 1e-9\n[surface.inner]\nbody = \"inner\"\nstrips = 4\n{panels}\
         [surface.outer]\nbody = \"outer\"\nstrips = 5\n{panels}\
         [control_surface.aileron]\nbody = \"outer\"\nfrom_m = 0.04\nto_m = 0.14\nhinge_fraction = 0.75\n\
         [simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\nstart = \"equilibrium\"\n",
    );
    config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn initialized(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Tip, bending strain and hinge moment.
fn read(plant: &Plant) -> [f64; 3] {
    let outputs = plant.outputs();
    [outputs.tips()[0].position_m.z, outputs.gauges()[0], outputs.flaps()[0].hinge_moment_n_m]
}

/// Tip, bending strain and hinge moment over time, minus their values at the start, from a simulation.
fn marched(angle_deg: f64, held: bool, step_s: f64) -> Vec<[f64; 3]> {
    let mut plant = Plant::new(Arc::new(machine(angle_deg, held, "strip", step_s)));
    plant.parameters_mut().solver_mut().tolerance = 1e-9;
    plant.parameters_mut().solver_mut().max_step_s = step_s;
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let start = read(&plant);
    let samples = (END_S / SAMPLE_S).round() as u32;
    (1..=samples)
        .map(|i| {
            let (from_s, to_s) = (f64::from(i - 1) * SAMPLE_S, f64::from(i) * SAMPLE_S);
            let (from, to) = (bump(from_s), bump(to_s));
            let [command_rad, command_rate_rad_s] = from.map(|value| SIZE_RAD * value);
            let slope = |k: usize| SIZE_RAD * (to[k] - from[k]) / SAMPLE_S;
            let flap = &mut plant.inputs_mut().flaps_mut()[0];
            (flap.command_rad, flap.command_rate_rad_s) = (command_rad, command_rate_rad_s);
            let rates = &mut plant.input_rates_mut().flaps_mut()[0];
            (rates.command_rad, rates.command_rate_rad_s) = (slope(0), slope(1));
            plant.step(to_s).unwrap_or_else(|error| panic!("{error}"));
            let now = read(&plant);
            [now[0] - start[0], now[1] - start[1], now[2] - start[2]]
        })
        .collect()
}

/// The same quantities from the linear model, by the trapezoidal rule in steps of 1/40 of the samples, with inputs linear between samples.
fn linear(model: &LinearModel) -> Vec<[f64; 3]> {
    let m = &model.matrices;
    let (n, parts) = (m.a.nrows(), 40);
    let step_s = SAMPLE_S / f64::from(parts);
    let one = DMatrix::<f64>::identity(n, n);
    let ahead = (&one - &m.a * (0.5 * step_s)).lu();
    let back = &one + &m.a * (0.5 * step_s);
    let input = |i: u32, part: u32| {
        let share = f64::from(part) / f64::from(parts);
        let (from, to) = (bump(f64::from(i) * SAMPLE_S), bump(f64::from(i + 1) * SAMPLE_S));
        DVector::from_iterator(2, (0..2).map(|k| SIZE_RAD * (from[k] + (to[k] - from[k]) * share)))
    };
    let mut x = DVector::zeros(n);
    let samples = (END_S / SAMPLE_S).round() as u32;
    (0..samples)
        .map(|i| {
            for part in 0..parts {
                let right = &back * &x + &m.b * ((input(i, part) + input(i, part + 1)) * (0.5 * step_s));
                x = ahead.solve(&right).expect("regular");
            }
            let y = &m.c * &x + &m.d * input(i, parts);
            [y[0], y[1], y[2]]
        })
        .collect()
}

/// A small aileron deflection and return, with the tip held at 60° and with a closed latch at 0°: tip and root strain agree within
/// 1e-4 of the largest value, with the simulation extrapolated to zero step by its second order. The hinge moment excludes the contribution
/// of the rate of the input `command_rate` through the apparent mass, which is bounded separately.
#[test]
fn q67_a_small_aileron_moves_the_linear_model_as_the_machine() {
    for (angle_deg, held) in [(60.0, true), (0.0, false)] {
        let machine = machine(angle_deg, held, "strip", 1e-3);
        let interface = Interface::new(&machine);
        let mut plant = initialized(machine);
        let named = |name: &str| interface.find(name).unwrap_or_else(|| panic!("{name}"));
        let gauge = interface.real_outputs().find(|row| row.name.starts_with("gauge.")).expect("a gauge");
        let outputs = [named("tip.position.z"), gauge, named("aero.control_surface.aileron.hinge_moment")];
        let inputs = [
            named("aero.control_surface.aileron.angle_command"),
            named("aero.control_surface.aileron.angle_command_rate"),
        ];
        let model = interface.linearize(&mut plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}"));
        let expected = linear(&model);
        let runs = [1e-3, 0.5e-3].map(|step_s| marched(angle_deg, held, step_s));
        for output in 0..3 {
            let size = expected.iter().fold(0.0f64, |size, y| size.max(y[output].abs()));
            let off = |marched: &dyn Fn(usize) -> f64| {
                let differences = expected.iter().enumerate().map(|(i, y)| (y[output] - marched(i)).abs());
                differences.fold(0.0, f64::max) / size
            };
            let limit = |i: usize| runs[1][i][output] + (runs[1][i][output] - runs[0][i][output]) / 3.0;
            let found = [off(&|i| runs[0][i][output]), off(&|i| runs[1][i][output]), off(&limit)];
            println!("Q-67 {angle_deg} deg, output {output}: size {size:.2e}, off {found:.6?}");
            if output < 2 {
                assert!(found[2] < 1e-4, "{angle_deg} {output}: {found:?}");
            }
        }
    }
}

/// In equilibrium the control surface bends the wing as much as in the linear model, and the hinge moment agrees; with strips and
/// with the lattice a downward deflection raises the wing and has a restoring hinge moment.
#[test]
fn q68_a_flap_bends_the_wing_at_rest() {
    for model in ["strip", "uvlm"] {
        let at = |angle_rad: f64| {
            let mut plant = Plant::new(Arc::new(machine(0.0, false, model, 1e-3)));
            plant.inputs_mut().flaps_mut()[0].command_rad = angle_rad;
            plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
            (read(&plant), plant.outputs().flaps()[0].angle_rad)
        };
        let ((above, angle_rad), (below, _)) = (at(1e-3), at(-1e-3));
        assert_eq!(angle_rad, 1e-3);
        let slopes: Vec<f64> = above.iter().zip(below).map(|(above, below)| (above - below) / 2e-3).collect();
        println!("Q-68 {model}: {slopes:?}");
        assert!(slopes[0] > 0.0 && slopes[2] < 0.0, "{slopes:?}");
        if model == "strip" {
            let machine = machine(0.0, false, model, 1e-3);
            let interface = Interface::new(&machine);
            let mut plant = initialized(machine);
            let named = |name: &str| interface.find(name).unwrap_or_else(|| panic!("{name}"));
            let outputs = [named("tip.position.z"), named("aero.control_surface.aileron.hinge_moment")];
            let inputs = [named("aero.control_surface.aileron.angle_command")];
            let linear = interface.linearize(&mut plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}"));
            let m = &linear.matrices;
            let rest = -m.a.clone().lu().solve(&m.b).expect("regular");
            let gains = &m.c * rest + &m.d;
            for (gain, slope) in gains.iter().zip([slopes[0], slopes[2]]) {
                // central differences of 1e-3 rad: error of third order
                approx::assert_relative_eq!(*gain, slope, max_relative = 1e-4);
            }
        }
    }
}

/// Steps repeated from a snapshot, with a moving control surface, give bit-identical results; a command beyond the limits is rejected
/// with location, value and remedy, and the machine stays at the last valid time.
#[test]
fn q69_flaps_go_back_with_snapshots_and_stop_at_their_limits() {
    for model in ["strip", "uvlm"] {
        let mut plant = initialized(machine(60.0, true, model, 1e-3));
        let go = |plant: &mut Plant, from: u32| {
            for i in from..from + 5 {
                let time_s = f64::from(i) * SAMPLE_S;
                plant.inputs_mut().flaps_mut()[0].command_rad = 0.1 * (40.0 * time_s).sin();
                plant.inputs_mut().flaps_mut()[0].command_rate_rad_s = 4.0 * (40.0 * time_s).cos();
                plant.step(time_s + SAMPLE_S).unwrap_or_else(|error| panic!("{error}"));
            }
            plant.outputs().values().to_vec()
        };
        go(&mut plant, 0);
        let snapshot = plant.snapshot();
        let first = go(&mut plant, 5);
        go(&mut plant, 10);
        plant.restore(&snapshot).expect("its own");
        assert_eq!(go(&mut plant, 5), first, "{model}");
        plant.inputs_mut().flaps_mut()[0].command_rad = 1000.0;
        let error = plant.step(0.011).expect_err("beyond the limits").to_string();
        for part in
            ["aero.control_surface.aileron.angle_command", "1000 rad", "-0.523599 to 0.523599", "upper_deg = 30"]
        {
            assert!(error.contains(part), "{error}");
        }
    }
}

/// Positive angles move the trailing edge towards `−z` on whichever side the leading edge lies: a wing whose leading edge lies
/// towards `−y`, in the wind from there, is the mirror image of one towards `+y`.
#[test]
fn q70_flaps_go_down_on_both_sides() {
    let found = ["+y", "-y"].map(|side| {
        let sign = if side == "+y" { -1.0 } else { 1.0 };
        let text = format!(
            "name = \"Side\"\n[section.s]\nshape = \"rectangle\"\nwidth_m = 0.2\nheight_m = 0.01\ndensity_kg_m3 = 1000.0\n\
             youngs_modulus_Pa = 1e10\ntorsional_rigidity_N_m2 = 50.0\n[body.wing]\nlength_m = 1.0\nsection = \"s\"\nelements = 4\n\
             [joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"wing\"\n[aerodynamics]\nmodel = \"strip\"\n\
             wind_m_s = [0.0, {:?}, 0.0]\n[surface.wing]\nbody = \"wing\"\nstrips = 4\nleading_edge = \"{side}\"\n\
             [control_surface.f]\nbody = \"wing\"\nfrom_m = 0.5\nto_m = 1.0\nhinge_fraction = 0.7\ncommand_deg = 2.0\n\
             [simulation]\nstop_time_s = 0.1\nstep_s = 1e-3\nstart = \"equilibrium\"\n",
            sign * 20.0
        );
        let plant = initialized(config::parse(&text, "side.toml").unwrap_or_else(|error| panic!("{error}")));
        let outputs = plant.outputs();
        [outputs.air_total().force_n.z, outputs.tips()[0].position_m.z, outputs.flaps()[0].hinge_moment_n_m]
    });
    let [plus, minus] = found;
    assert!(plus[0] > 0.0 && plus[2] < 0.0, "{plus:?}");
    for (plus, minus) in plus.into_iter().zip(minus) {
        approx::assert_relative_eq!(plus, minus, max_relative = 1e-9);
    }
}
