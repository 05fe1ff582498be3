//! Model Exchange as used by optimisers: states and tunable parameters set one by one at any time, directional and adjoint derivatives,
//! declared dependencies.

use crate::fmu::{Fmu, WING};
use crate::model_exchange::{Outside, Phase};
use foldwing::interface::{Causality, Interface, Kind, Variability, Variable};
use foldwing_fmu::derivatives::fmi2GetDirectionalDerivative;
use foldwing_fmu::exchange::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::types::*;

const FLYING: &str = include_str!("../../examples/models/flying_wing.toml");
const PENDULUM: &str = include_str!("../../examples/models/double_pendulum.toml");
const FOUR_BAR: &str = include_str!("../../examples/models/four_bar.toml");
const STRIPS: &str = include_str!("../../examples/models/flared_wing_tip.toml");
/// A wing on strips on a pod that pitches, with a slender body.
const FUSELAGE: &str = r#"
name = "Fuselage"
[rigid_body.pod]
mass_kg = 5.0
inertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
[joint.pitch]
type = "revolute"
parent = "root"
child = "pod"
axis = [0.0, 1.0, 0.0]
start_angle_deg = 3.0
motor.stiffness_N_m_rad = 400.0
[section.spar]
shape = "rectangle"
width_m = 0.2
height_m = 0.02
density_kg_m3 = 500.0
youngs_modulus_Pa = 3e10
shear_modulus_Pa = 6e9
[body.wing]
section = "spar"
length_m = 2.0
elements = 1
load_stations = 1
[joint.flap]
type = "revolute"
parent = "pod"
parent_offset_m = [0.1, 0.0, 0.0]
child = "wing"
axis = [1.0, 0.0, 0.0]
mount_rotation_deg = [0.0, 0.0, 90.0]
motor.stiffness_N_m_rad = 200.0
[surface.wing]
body = "wing"
chord_m = 0.5
elastic_axis_fraction = 0.25
leading_edge = "+y"
strips = 3
[aerodynamics]
wind_m_s = [15.0, 0.5, 1.0]
step_s = 0.01
[aerodynamics.surfaces]
model = "strip"
[aerodynamics.pod]
model = "slender_body"
body = "pod"
radius_m = [[-0.8, 0.0], [-0.3, 0.15], [0.6, 0.12], [1.2, 0.03]]
cross_flow_drag_coefficient = 1.0
axial_drag_coefficient = 0.1
"#;
/// Two beams on the root, one on a hinge with a motor, the other on a ball joint.
const TWO_TREES: &str = r#"
name = "TwoTrees"
gravity_m_s2 = [0.0, 0.0, -9.81]
[section.plate]
shape = "rectangle"
width_m = 0.05
height_m = 0.002
density_kg_m3 = 1400.0
youngs_modulus_Pa = 3e9
poisson_ratio = 0.3
[body.left]
length_m = 0.2
section = "plate"
elements = 2
load_station_positions_m = [0.1]
[body.right]
length_m = 0.3
section = "plate"
elements = 2
load_station_positions_m = [0.2]
[joint.hinge]
type = "revolute"
parent = "root"
child = "left"
axis = [0.0, 1.0, 0.0]
start_angle_deg = 20.0
[joint.hinge.motor]
stiffness_N_m_rad = 0.1
damping_N_m_s_rad = 0.001
[joint.ball]
type = "ball"
parent = "root"
child = "right"
"#;

/// Magnitude of a state in these motions: the nominal one, except for rates of stretch, whose nominal magnitude is that of short waves.
fn magnitude(row: &Variable) -> Option<f64> {
    let stretches = row.name.starts_with("state_rate.") && row.name.ends_with("epsilon_x");
    row.nominal.map(|nominal| if stretches { 0.1 } else { nominal })
}

fn magnitudes(fmu: &Fmu) -> Vec<f64> {
    fmu.table.variables().iter().filter_map(magnitude).collect()
}

/// A machine in an arbitrary motion: all states differ from the start by 1e-3 of their magnitudes.
fn moving(text: &str) -> Outside {
    let mut outside = Outside::started(text);
    let magnitudes = magnitudes(&outside.fmu);
    for (i, (state, nominal)) in outside.states.iter_mut().zip(magnitudes).enumerate() {
        *state += 1e-3 * nominal * (1.0 + 2.0 * i as f64).sin();
    }
    outside.set(0.01, &outside.states);
    // back onto the constraints of redundant parameters
    unsafe {
        outside.fmu.ok(fmi2EnterEventMode(outside.fmu.component));
        outside.update();
        outside.fmu.ok(fmi2EnterContinuousTimeMode(outside.fmu.component));
    }
    outside.read();
    outside
}

fn derivatives(fmu: &Fmu) -> Vec<f64> {
    let mut found = vec![f64::NAN; fmu.table.nominals().len()];
    fmu.ok(unsafe { fmi2GetDerivatives(fmu.component, found.as_mut_ptr(), found.len()) });
    found
}

fn references(table: &Interface, fits: impl Fn(&Variable) -> bool) -> Vec<u32> {
    table.variables().iter().filter(|row| fits(row)).map(|row| row.value_reference).collect()
}

fn real(row: &Variable) -> bool {
    row.value.kind() == Kind::Real
}

fn get(fmu: &Fmu, rows: &[u32]) -> Vec<f64> {
    let mut values = vec![f64::NAN; rows.len()];
    fmu.ok(unsafe { fmi2GetReal(fmu.component, rows.as_ptr(), rows.len(), values.as_mut_ptr()) });
    values
}

fn set(fmu: &Fmu, rows: &[u32], values: &[f64]) {
    fmu.ok(unsafe { fmi2SetReal(fmu.component, rows.as_ptr(), rows.len(), values.as_ptr()) });
}

fn slope(fmu: &Fmu, unknowns: &[u32], knowns: &[u32], seeds: &[f64]) -> Vec<f64> {
    let mut found = vec![f64::NAN; unknowns.len()];
    fmu.ok(unsafe {
        fmi2GetDirectionalDerivative(
            fmu.component,
            unknowns.as_ptr(),
            unknowns.len(),
            knowns.as_ptr(),
            knowns.len(),
            seeds.as_ptr(),
            found.as_mut_ptr(),
        )
    });
    found
}

/// Unknowns, and the knowns of the integration: states, Real inputs, tunable parameters.
fn unknowns_and_knowns(fmu: &Fmu) -> (Vec<u32>, Vec<u32>) {
    let unknowns =
        references(&fmu.table, |row| real(row) && (row.derivative_of.is_some() || row.causality == Causality::Output));
    let knowns = references(&fmu.table, |row| {
        let tunable = row.causality == Causality::Parameter && row.variability == Variability::Tunable;
        real(row) && (row.nominal.is_some() || row.causality == Causality::Input || tunable)
    });
    (unknowns, knowns)
}

/// ME-10. Importers that treat states as variables (CasADi) set each with `fmi2SetReal`, in Continuous-Time Mode and in events: the
/// derivatives are bit-identical to those after `fmi2SetContinuousStates`. Tunable parameters also take effect at once. A number that is
/// not finite is rejected, and nothing is set.
#[test]
fn me10_states_and_tunable_parameters_are_set_one_by_one() {
    for text in [WING, PENDULUM] {
        let reference = moving(text);
        let expected = derivatives(&reference.fmu);
        let mut single = Outside::started(text);
        single.set(0.01, &single.states);
        let rows = references(&single.fmu.table, |row| row.nominal.is_some());
        for (row, state) in rows.iter().zip(&reference.states) {
            set(&single.fmu, &[*row], &[*state]);
        }
        assert_eq!(derivatives(&single.fmu), expected);
        single.read();
        assert_eq!(single.states, reference.states);
        let status = unsafe { fmi2SetReal(single.fmu.component, rows.as_ptr(), 2, [1.0, f64::NAN].as_ptr()) };
        single.fmu.refused(status, fmi2Discard, &["cannot be NaN"]);
        assert_eq!(derivatives(&single.fmu), expected);

        let mut in_event = Outside::new(Fmu::exchanged(text)).in_phase(Phase::Event);
        set(&in_event.fmu, &rows, &reference.states);
        in_event.read();
        assert_eq!(in_event.states, reference.states);
    }
    // the motor's moment is (command - angle) stiffness: doubling the stiffness doubles its derivative with respect to the command
    let wing = moving(WING);
    let row = |name: &str| wing.fmu.table.find(name).expect(name).value_reference;
    let (stiffness, command, angle) =
        (row("fold.motor_stiffness"), row("fold.angle_command"), row("fold.motor_torque"));
    let before = slope(&wing.fmu, &[angle], &[command], &[1.0])[0];
    set(&wing.fmu, &[stiffness], &[2.0 * get(&wing.fmu, &[stiffness])[0]]);
    let after = slope(&wing.fmu, &[angle], &[command], &[1.0])[0];
    assert!((after / before - 2.0).abs() < 1e-10, "{before} {after}");
}

/// ME-11. Directional derivatives of all state derivatives and outputs, with respect to every state, input and tunable parameter, and along
/// all of them at once, equal central differences taken by the importer, for seven machines: without aerodynamics, with redundant parameters,
/// in flight, with a closed loop, with strips, with strips and a slender body. The differences are of second order, extrapolated; their error is 1e-7 of the largest entry
/// of a column. The state derivatives are bit-identical afterwards. In an event, a pending jump of an input is not lost.
#[test]
fn me11_directional_derivatives_are_those_of_differences() {
    for text in [WING, PENDULUM, FLYING, FOUR_BAR, STRIPS, TWO_TREES, FUSELAGE] {
        let outside = moving(text);
        let fmu = &outside.fmu;
        let (unknowns, knowns) = unknowns_and_knowns(fmu);
        let before = derivatives(fmu);
        let (present, base) = (get(fmu, &knowns), get(fmu, &unknowns));
        let mut total = vec![0.0; unknowns.len()];
        for (i, &known) in knowns.iter().enumerate() {
            let row = &fmu.table.variables()[known as usize];
            let found = slope(fmu, &unknowns, &[known], &[1.0]);
            total.iter_mut().zip(&found).for_each(|(sum, entry)| *sum += entry * magnitude(row).unwrap_or(0.0));
            // infinite limits have no effect
            if present[i].abs() >= 1e20 {
                continue;
            }
            // values are quadratic in inputs and linear in parameters, and sums of large terms
            let (step, round_off) = match magnitude(row) {
                None if present[i] == 0.0 || row.causality == Causality::Input => (1e-2, 1e-9),
                nominal => (1e-4 * nominal.unwrap_or(present[i].abs()), 1e-9),
            };
            let at = |amount: f64| {
                set(fmu, &[known], &[present[i] + amount]);
                get(fmu, &unknowns)
            };
            // a range may end at 0
            let forward = row.range.is_some_and(|(min, _)| present[i] - 2.0 * step < min);
            let central: Vec<f64> = if forward {
                let (first, second) = (at(step), at(2.0 * step));
                (0..base.len()).map(|k| (4.0 * first[k] - second[k] - 3.0 * base[k]) / (2.0 * step)).collect()
            } else {
                let [a, b, c, d] = [1.0, -1.0, 2.0, -2.0].map(|times| at(times * step));
                (0..base.len()).map(|k| (8.0 * (a[k] - b[k]) - (c[k] - d[k])) / (12.0 * step)).collect()
            };
            at(0.0);
            let scale = central.iter().zip(&base).fold(0.0f64, |max, (entry, _)| max.max(entry.abs()));
            for (k, (found, expected)) in found.iter().zip(&central).enumerate() {
                let bound = 1e-7 * scale + round_off * base[k].abs().max(1.0) / step;
                let of = &fmu.table.variables()[unknowns[k] as usize].name;
                assert!(
                    (found - expected).abs() <= bound,
                    "{}: d {of} / d {}: {found:e}, {expected:e}",
                    fmu.table.variables()[known as usize].name,
                    row.name
                );
            }
        }
        let states = references(&fmu.table, |row| row.nominal.is_some());
        let along = slope(fmu, &unknowns, &states, &magnitudes(fmu));
        let scale = total.iter().fold(0.0f64, |max, entry| max.max(entry.abs()));
        for (found, expected) in along.iter().zip(&total) {
            assert!((found - expected).abs() < 1e-8 * scale, "{found:e} {expected:e}");
        }
        assert_eq!(derivatives(fmu), before);
    }
    let mut wing = moving(WING);
    let command = wing.fmu.table.find("fold.angle_command").expect("an input").value_reference;
    let work = wing.fmu.table.find("energy.work").expect("an output").value_reference;
    let mut jump = |differentiate: bool| {
        let mut before = std::ptr::null_mut();
        let c = wing.fmu.component;
        unsafe {
            wing.fmu.ok(foldwing_fmu::states::fmi2GetFMUstate(c, &mut before));
            wing.fmu.ok(fmi2EnterEventMode(c));
            set(&wing.fmu, &[command], &[0.3]);
            if differentiate {
                let (unknowns, knowns) = unknowns_and_knowns(&wing.fmu);
                slope(&wing.fmu, &unknowns, &knowns, &vec![1.0; knowns.len()]);
            }
            wing.update();
            wing.fmu.ok(fmi2EnterContinuousTimeMode(c));
            let found = (get(&wing.fmu, &[work]), derivatives(&wing.fmu));
            wing.fmu.ok(foldwing_fmu::states::fmi2SetFMUstate(c, before));
            found
        }
    };
    assert_eq!(jump(true), jump(false));
}

/// ME-12. Variables without derivatives are rejected by name: fixed parameters, switches, outputs as knowns; states and inputs as unknowns.
#[test]
fn me12_other_derivatives_are_refused_by_name() {
    let outside = moving(WING);
    let fmu = &outside.fmu;
    let refuse = |unknown: &str, known: &str, words: &str| {
        let row = |name: &str| fmu.table.find(name).expect(name).value_reference;
        let (unknown, known, mut found) = (row(unknown), row(known), 0.0);
        let status = unsafe { fmi2GetDirectionalDerivative(fmu.component, &unknown, 1, &known, 1, &1.0, &mut found) };
        fmu.refused(status, fmi2Error, &[words]);
    };
    let knowns = "knowns must be continuous states, Real inputs, tunable parameters and time";
    let unknowns = "unknowns must be derivatives of states and Real outputs";
    refuse("der(state.fold.angle)", "fold.start_angle", knowns);
    refuse("der(state.fold.angle)", "fold.angle", knowns);
    refuse("der(state.fold.angle)", "fold.release", "has type Boolean, not Real");
    refuse("state.fold.angle", "state.fold.angle", unknowns);
    refuse("fold.external_torque", "state.fold.angle", unknowns);
}

/// ME-13. Every dependence of a derivative found by differences is declared, and the lists are short for separate trees: of two trees
/// neither depends on the motion or the loads of the other.
#[test]
fn me13_dependencies_have_no_false_zero_and_end_at_the_tree() {
    for text in [PENDULUM, FLYING, FOUR_BAR, TWO_TREES] {
        let machine = foldwing::config::parse(text, "model.toml").expect("a model");
        let outside = moving(text);
        let fmu = &outside.fmu;
        let declared = fmu.table.dependencies(&machine);
        let unknowns = references(&fmu.table, |row| row.derivative_of.is_some());
        let knowns =
            references(&fmu.table, |row| real(row) && (row.nominal.is_some() || row.causality == Causality::Input));
        for &known in &knowns {
            for (unknown, entry) in unknowns.iter().zip(slope(fmu, &unknowns, &[known], &[1.0])) {
                let list = &declared[*unknown as usize];
                if entry != 0.0 && !list.on_all && !list.running.iter().any(|(row, _)| *row == known) {
                    // round-off of a sum of large numbers
                    let name = |row: u32| &fmu.table.variables()[row as usize].name;
                    assert!(entry.abs() < 1e-6, "d {} / d {} = {entry:e} is not declared", name(*unknown), name(known));
                }
            }
        }
        if text == TWO_TREES {
            let row = |name: &str| fmu.table.find(name).expect(name).value_reference;
            let list = &declared[row("der(state_rate.hinge.angle)") as usize];
            assert!(!list.on_all);
            let has = |name: &str| list.running.iter().any(|(found, _)| *found == row(name));
            assert!(
                has("state_rate.left.element[2].kappa_y") && has("load.left[1].force.z") && has("hinge.angle_command")
            );
            let of_other =
                |row: u32| ["right", "ball"].iter().any(|part| fmu.table.variables()[row as usize].name.contains(part));
            assert!(list.running.iter().all(|(row, _)| !of_other(*row)));
            let parameter = &declared[row("der(state.ball.parameter[2])") as usize];
            assert_eq!(parameter.running.len(), 8, "four parameters and their rates");
        }
    }
}

/// ME-14. The torque of a motor has a kink at its limit. Close to it, the derivative of the torque with respect to the command is that of the
/// branch on which the command lies: the stiffness of the motor 1e-5 rad before the limit, and zero 1e-5 rad beyond it.
#[test]
fn me14_derivatives_end_at_the_limit_of_a_motor() {
    let limited = WING.replace("constant_torque_N_m = 0.043", "torque_limit_N_m = 0.02");
    assert_ne!(limited, WING);
    let wing = Outside::started(&limited);
    let row = |name: &str| wing.fmu.table.find(name).expect(name).value_reference;
    let (angle, command, torque) = (row("fold.angle"), row("fold.angle_command"), row("fold.motor_torque"));
    let stiffness = get(&wing.fmu, &[row("fold.motor_stiffness")])[0];
    let edge = get(&wing.fmu, &[angle])[0] - 0.02 / stiffness;
    for (beside, expected) in [(1e-5, stiffness), (-1e-5, 0.0)] {
        set(&wing.fmu, &[command], &[edge + beside]);
        let found = slope(&wing.fmu, &[torque], &[command], &[1.0])[0];
        assert!((found - expected).abs() < 1e-6 * stiffness, "{beside}: {found}, {expected}");
    }
}
