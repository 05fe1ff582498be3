//! Reading outputs changes neither their values nor later results.

use crate::plant::machines::*;
use foldwing::machine::{Body, ElementKind, Method, Revolute, Solver};
use foldwing::plant::{OutputSet, Outputs, Plant};
use nalgebra::{Matrix3, Vector3};

/// Each group of outputs separately.
const GROUPS: [OutputSet; 16] = [
    OutputSet::JOINTS,
    OutputSet::ACCOUNTS,
    OutputSet::GAUGES,
    OutputSet::TIP_PLACES,
    OutputSet::STATION_PLACES,
    OutputSet::SPATIAL,
    OutputSet::TIP_MOTIONS,
    OutputSet::STATION_MOTIONS,
    OutputSet::ENERGIES,
    OutputSet::REACTIONS,
    OutputSet::LOOPS,
    OutputSet::ROOT,
    OutputSet::AIR,
    OutputSet::HOLDING,
    OutputSet::STATION_ACCELERATIONS,
    OutputSet::SECTION_LOADS,
];

/// Shipped models with every kind of joint, closed loops and aerodynamics.
const MODELS: [&str; 6] =
    ["folding_wing", "folding_wing_constant", "double_pendulum", "flying_wing", "four_bar", "goland_wing"];

fn shipped(name: &str) -> Plant {
    let path = format!("{}/examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("a shipped model");
    start(foldwing::config::parse(&text, &path).expect("a valid model"))
}

/// P-100. Outputs computed group by group, in any order, are bit-identical to those computed all at once; steps after which no outputs or
/// only one value is read lead to the same states.
#[test]
fn p100_outputs_do_not_depend_on_what_is_read() {
    for name in MODELS {
        let (mut whole, mut single, mut blind) = (shipped(name), shipped(name), shipped(name));
        for plant in [&mut single, &mut blind] {
            plant.watch(OutputSet::NONE);
        }
        for i in 1..=60 {
            let end_s = 7e-4 * f64::from(i);
            for plant in [&mut whole, &mut single, &mut blind] {
                if i % 20 == 0 {
                    plant.inputs_mut().root_mut().gravity_m_s2.y += 0.1;
                }
                coast(plant, end_s);
            }
            for k in 0..GROUPS.len() {
                single.provide(GROUPS[(5 * k + i as usize) % GROUPS.len()]);
            }
            assert_eq!(single.outputs(), whole.outputs(), "{name} at {end_s} s");
        }
        assert_eq!(blind.snapshot(), whole.snapshot(), "{name}: the state depends on what was read");
        assert_eq!(single.snapshot(), whole.snapshot(), "{name}: the state depends on what was read");
        blind.provide(OutputSet::ALL);
        assert_eq!(blind.outputs(), whole.outputs(), "{name}: read late");
    }
}

/// P-101. A quaternion keeps its sign if a joint makes whole revolutions within internal steps: values at neighbouring communication points
/// differ little, with a flexible and with a rigid blade.
///
/// A free joint rotates at 300 rad/s; internal steps of up to 0.1 s correspond to 30 rad, communication steps to 0.03 rad. The bound is
/// twice the change of half the angle.
#[test]
fn p101_signs_follow_turns_within_an_internal_step() {
    let flexible = body("blade", 0.1, &wing_section(), ElementKind::Constant, 1);
    let rigid = Body::rigid("blade").inertia(0.1, [0.05, 0.0, 0.0], Matrix3::from_diagonal_element(1e-3));
    for blade in [flexible, rigid] {
        let hinge = Revolute { start_rate_rad_s: 300.0, ..free_hinge(0.0) };
        let mut spinner = machine([(blade, hinged_to_root(hinge))]);
        spinner.gravity_m_s2 = Vector3::zeros();
        spinner.solver = Solver { max_step_s: 0.1, ..solver(Method::Esdirk4, 1.0) };
        let mut plant = start(spinner);
        let mut last: Option<Outputs> = None;
        for i in 1..=2000 {
            coast(&mut plant, 1e-4 * f64::from(i));
            let now = plant.outputs().clone();
            if let Some(last) = &last {
                let turned = (now.tips()[0].rotation.coords - last.tips()[0].rotation.coords).norm();
                assert!(turned < 0.03, "sign flips at {i}");
            }
            last = Some(now);
        }
        let steps = plant.statistics().steps;
        assert!(steps < 100, "{steps} internal steps are too short to tell");
    }
}

/// P-102. Inputs too large for finite outputs are an error, whichever outputs are read.
#[test]
fn p102_overflow_is_told_though_nothing_is_read() {
    let mut plant = start(wing(ElementKind::Linear, 1, Method::Esdirk4, 1e-4));
    plant.watch(OutputSet::NONE);
    coast(&mut plant, 1e-3);
    plant.inputs_mut().root_mut().gravity_m_s2.x = 1e306;
    let error = plant.step(2e-3).expect_err("gravity of 1e306 m/s2");
    println!("{error}");
    assert_eq!(plant.time_s(), 1e-3);
}
