//! S-40 to S-46: the linear model against differences of simulations.

use crate::statics::machines::plant;
use foldwing::interface::{Interface, LinearModel, Value, Variable};
use foldwing::plant::{Holding, Plant};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// A wing of two soft bodies with damping, spring and load stations; small enough for tight integration.
fn wing(start: &str) -> String {
    format!(
        "name = 'W'\ngravity_m_s2 = [0.0, 1.0, -9.0]\n\
         [section.s]\nshape = 'explicit'\naxial_stiffness_N = 400.0\ntorsional_rigidity_N_m2 = 0.8\n\
         flap_stiffness_N_m2 = 1.0\nedge_stiffness_N_m2 = 3.0\ncoupling_twist_flap_N_m2 = 0.2\nmass_kg_m = 0.5\n\
         centre_of_mass_m = [0.01, 0.0]\nsecond_moments_kg_m = [0.01, 0.0, 0.004]\n\
         half_width_m = 0.1\nhalf_height_m = 0.05\n\
         [body.inner]\nlength_m = 0.6\nsection = 's'\nelements = 1\nmass_damping_1_s = 0.3\n\
         stiffness_damping_s = 1e-3\nload_stations = 1\n\
         [body.outer]\nlength_m = 0.5\nsection = 's'\nelement = 'constant'\nelements = 2\nload_stations = 1\n\
         load_frame = 'section'\n\
         [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'inner'\n\
         [joint.fold]\ntype = 'revolute'\nparent = 'inner'\nchild = 'outer'\naxis = [0.3, 1.0, 0.0]\n\
         start_angle_deg = 40.0\n[joint.fold.motor]\nstiffness_N_m_rad = 2.0\ndamping_N_m_s_rad = 0.05\n\
         [gauge.root]\nbody = 'inner'\nposition_m = 0.0\n\
         [load.a]\nbody = 'outer'\nstation = 1\nforce_N = [0.2, -0.1, 0.5]\nmoment_N_m = [0.05, 0.0, 0.02]\n\
         [solver]\nmethod = 'esdirk4'\nfixed_step_s = 1e-4\ntolerance = 1e-12\n[simulation]\nstart = '{start}'\n"
    )
}

struct Setup {
    plant: Plant,
    interface: Interface,
}

impl Setup {
    fn new(start: &str) -> Self {
        Self::of(&wing(start))
    }

    fn of(text: &str) -> Self {
        let plant = plant(text);
        let interface = Interface::new(plant.machine());
        Self { plant, interface }
    }

    fn inputs(&self) -> Vec<&Variable> {
        self.interface.real_inputs().collect()
    }

    fn outputs(&self) -> Vec<&Variable> {
        self.interface.real_outputs().collect()
    }

    fn model(&mut self) -> LinearModel {
        let (inputs, outputs): (Vec<_>, Vec<_>) =
            (self.interface.real_inputs().collect(), self.interface.real_outputs().collect());
        self.interface.linearize(&mut self.plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}"))
    }

    fn read(&self) -> DVector<f64> {
        let value = |row: &&Variable| match self.interface.get(&self.plant, self.plant.outputs(), row.value_reference) {
            Some(Value::Real(value)) => value,
            other => panic!("{}: {other:?}", row.name),
        };
        DVector::from_iterator(self.outputs().len(), self.outputs().iter().map(value))
    }
}

/// Inputs of S-40: one of each kind.
const STEPPED: [&str; 9] = [
    "fold.angle_command",
    "fold.external_torque",
    "gravity.y",
    "load.inner[1].force.z",
    "load.outer[1].force.x",
    "load.outer[1].moment.y",
    "root.acceleration.x",
    "root.angular_velocity.y",
    "root.angular_acceleration.z",
];

/// S-40. Response to a step of each kind of input about the equilibrium, simulated on both sides of it with two step heights (Richardson
/// extrapolation: the remaining error is of fifth order), against `exp(At)` with `B`, `C`, `D`: every output at 0.05 s within 1e-7 of the
/// largest response of an output of its unit.
#[test]
fn s40_step_responses_are_those_of_the_simulation() {
    compare_step_responses("S-40", &mut Setup::new("unstrained"), &STEPPED);
}

fn compare_step_responses(case: &str, setup: &mut Setup, stepped: &[&str]) {
    setup.plant.study().equilibrium(0.0, Holding::AsReleased).unwrap();
    let model = setup.model();
    let rest = setup.plant.snapshot();
    let energies = |name: &str| name.starts_with("energy.work") || name.starts_with("energy.dissipated");
    let end_s = 0.05;
    let (states, count) = (model.states.len(), setup.inputs().len());
    // exp of [[A, B], [0, 0]] t: the response to steps
    let mut whole = DMatrix::zeros(states + count, states + count);
    whole.view_mut((0, 0), (states, states)).copy_from(&model.matrices.a);
    whole.view_mut((0, states), (states, count)).copy_from(&model.matrices.b);
    let response = (whole * end_s).exp();
    let linear = &model.matrices.c * response.view((0, states), (states, count)) + &model.matrices.d;

    for input in stepped {
        let j = setup.inputs().iter().position(|row| row.name == *input).expect(input);
        let reference = setup.interface.find(input).unwrap().value_reference;
        let base = match setup.interface.get(&setup.plant, setup.plant.outputs(), reference) {
            Some(Value::Real(value)) => value,
            other => panic!("{other:?}"),
        };
        let mut at = |amount: f64| {
            setup.plant.restore(&rest).unwrap();
            setup.interface.set(&mut setup.plant, reference, Value::Real(base + amount)).unwrap();
            setup.plant.step(end_s).unwrap();
            setup.read()
        };
        let mut slope = |height: f64| (at(height) - at(-height)) / (2.0 * height);
        let height = 2e-2;
        let simulated = (slope(0.5 * height) * 4.0 - slope(height)) / 3.0;
        setup.plant.restore(&rest).unwrap();
        let mut worst = (0.0f64, "");
        for (i, row) in setup.outputs().iter().enumerate().filter(|(_, row)| !energies(&row.name)) {
            // scale: the largest response among outputs of the same unit
            let scale = setup
                .outputs()
                .iter()
                .enumerate()
                .filter(|(_, other)| other.unit() == row.unit() && !energies(&other.name))
                .fold(1e-3f64, |scale, (k, _)| scale.max(simulated[k].abs()));
            let error = (simulated[i] - linear[(i, j)]).abs() / scale;
            if error > worst.0 {
                worst = (error, &row.name);
            }
        }
        println!("{case} {input}: worst {:.1e} in {}", worst.0, worst.1);
        assert!(worst.0 < 1e-7, "{input}: {:.1e} in {}", worst.0, worst.1);
    }
}

/// S-41. About a moving state: along the simulation `dy/dt = C dx/dt` for every output, accelerations and forces
/// included, with `dx/dt` and `dy/dt` by sixth-order differences of the simulation. 1e-7 of the largest rate among
/// outputs of the same unit.
#[test]
fn s41_rates_along_a_motion() {
    compare_rates("S-41", &mut Setup::new("equilibrium"));
}

fn compare_rates(case: &str, setup: &mut Setup) {
    let (middle, step) = (0.0503, 1e-4);
    let mut samples = Vec::new();
    let mut model = None;
    setup.plant.initialize(0.0).unwrap();
    setup.plant.step(middle - 3.0 * step).unwrap();
    for k in -3i32..=3 {
        if k > -3 {
            setup.plant.step(middle + f64::from(k) * step).unwrap();
        }
        if k == 0 {
            model = Some(setup.model());
        }
        let (q, v) = setup.plant.free_state();
        samples.push((DVector::from_iterator(q.len() + v.len(), q.into_iter().chain(v)), setup.read()));
    }
    let model = model.unwrap();
    let slope = |at: &dyn Fn(usize) -> DVector<f64>| {
        ((at(4) - at(2)) * 45.0 - (at(5) - at(1)) * 9.0 + (at(6) - at(0))) / (60.0 * step)
    };
    let (x, y) = (slope(&|i| samples[i].0.clone()), slope(&|i| samples[i].1.clone()));
    let linear = &model.matrices.c * &x;
    let outputs = setup.outputs();
    let mut worst = (0.0f64, "");
    for (i, row) in outputs.iter().enumerate() {
        if row.name.starts_with("energy.work") || row.name.starts_with("energy.dissipated") {
            continue;
        }
        let scale = (0..outputs.len())
            .filter(|&k| outputs[k].unit() == row.unit())
            .fold(0.0f64, |scale, k| scale.max(linear[k].abs()));
        let error = (y[i] - linear[i]).abs() / scale;
        if error > worst.0 {
            worst = (error, &row.name);
        }
    }
    println!("{case} worst {:.1e} in {}", worst.0, worst.1);
    assert!(worst.0 < 1e-7, "{:.1e} in {}", worst.0, worst.1);
    // A gives the derivatives of the states
    let rate = &model.matrices.a * &x;
    let second = slope(&|i| samples[i].0.clone());
    assert!((rate.rows(0, x.len() / 2) - second.rows(x.len() / 2, x.len() / 2)).norm() < 1e-9 * second.norm());
}

/// S-42. Eigenvalues of `A` equal those of the modes; 1e-8.
#[test]
fn s42_eigenvalues_of_the_linear_model_are_the_modes() {
    compare_eigenvalues("S-42", &mut Setup::new("unstrained"));
}

fn compare_eigenvalues(case: &str, setup: &mut Setup) {
    setup.plant.study().equilibrium(0.0, Holding::AsReleased).unwrap();
    let model = setup.model();
    let modes = setup.plant.study().modes(6).unwrap();
    let eigenvalues: Vec<Complex<f64>> = model.matrices.a.complex_eigenvalues().iter().copied().collect();
    for mode in &modes {
        let gap = eigenvalues.iter().map(|value| (value - mode.eigenvalue_1_s).norm()).fold(f64::INFINITY, f64::min);
        println!(
            "{case} {:.6} Hz, damping {:.5}: {:.1e}",
            mode.frequency_hz,
            mode.damping_ratio,
            gap / mode.eigenvalue_1_s.norm()
        );
        assert!(gap < 1e-8 * mode.eigenvalue_1_s.norm(), "{:?}: {gap:.1e}", mode.eigenvalue_1_s);
        assert!(mode.damping_ratio > 0.0 && mode.frequency_hz * TAU > 0.1);
    }
}

/// S-43. Names, units and values of signals; the state is unchanged.
#[test]
fn s43_signals_are_named_and_the_plant_stays() {
    let mut setup = Setup::new("unstrained");
    setup.plant.initialize(0.0).unwrap();
    setup.plant.step(0.01).unwrap();
    let (before, outputs) = (setup.plant.snapshot(), setup.plant.outputs().clone());
    let model = setup.model();
    assert_eq!(setup.plant.outputs(), &outputs);
    assert!(setup.plant.snapshot() == before, "the linearisation changed the state");
    let names: Vec<&str> = model.states.iter().map(|signal| signal.name.as_str()).collect();
    let n = names.len() / 2;
    assert_eq!(n, setup.plant.coordinates());
    assert!(names.contains(&"fold.angle") && names.contains(&"der(fold.angle)"));
    assert_eq!((names[0], names[n]), ("inner.element[1].epsilon_x", "der(inner.element[1].epsilon_x)"));
    let angle = names.iter().position(|name| *name == "fold.angle").unwrap();
    assert_eq!(model.states[angle].value, outputs.joints()[0].angle_rad);
    assert_eq!((model.states[angle].unit.as_str(), model.states[angle + n].unit.as_str()), ("rad", "rad/s"));
    assert_eq!(model.matrices.d.shape(), (model.outputs.len(), model.inputs.len()));
}

/// Two hinged bars that lean against each other: a soft ball joint with inertia, damper and arms of 30 mm between their ends.
fn gable(start: &str) -> String {
    let section = wing(start);
    let (section, run) = (section.split("[body.inner]").next().unwrap(), section.split("[solver]").nth(1).unwrap());
    let (ridge_m, angle_deg) = (0.6 * 40f64.to_radians().cos(), 40.0);
    format!(
        "{section}[body.left]\nlength_m = 0.6\nsection = 's'\nelements = 1\nmass_damping_1_s = 0.3\n\
         stiffness_damping_s = 1e-3\nload_stations = 1\n\
         [body.right]\nlength_m = 0.6\nsection = 's'\nelement = 'constant'\nelements = 2\nload_stations = 1\n\
         [joint.west]\ntype = 'revolute'\nparent = 'root'\nchild = 'left'\naxis = [0, 1, 0]\n\
         start_angle_deg = -{angle_deg}\n[joint.west.motor]\nstiffness_N_m_rad = 2.0\n\
         command_deg = -{angle_deg}\ndamping_N_m_s_rad = 0.05\n\
         [joint.east]\ntype = 'revolute'\nparent = 'root'\nchild = 'right'\naxis = [0, 1, 0]\n\
         root_position_m = [{}, 0, 0]\nmount_rotation_deg = [0, 0, 180]\nstart_angle_deg = {angle_deg}\n\
         [loop.ridge]\nbodies = ['left', 'right']\noffsets_m = [[0, 0.03, 0], [0, -0.03, 0]]\n\
         stiffness_N_m = 5e3\ndamping_N_s_m = 0.5\ninertia_kg = 0.02\n\
         [gauge.root]\nbody = 'left'\nposition_m = 0.3\n\
         [load.a]\nbody = 'right'\nstation = 1\nforce_N = [0.2, -0.1, 0.5]\nmoment_N_m = [0.05, 0.0, 0.02]\n\
         [solver]{run}",
        2.0 * ridge_m
    )
}

/// S-44. A machine with a closed loop: step responses of `A`, `B`, `C`, `D` equal those of the simulation, gap and force of the loop
/// included; as S-40 (at zero rates there is no first-order response to an angular velocity of the root).
#[test]
fn s44_step_responses_around_a_loop() {
    let inputs = [
        "west.angle_command",
        "east.external_torque",
        "gravity.y",
        "load.left[1].force.z",
        "load.right[1].moment.y",
        "root.acceleration.x",
        "root.angular_acceleration.z",
    ];
    compare_step_responses("S-44", &mut Setup::of(&gable("unstrained")), &inputs);
}

/// S-45. Rates along a motion of a machine with a closed loop; as S-41.
#[test]
fn s45_rates_along_a_motion_around_a_loop() {
    compare_rates("S-45", &mut Setup::of(&gable("unstrained")));
}

/// S-46. Eigenvalues of `A` of a machine with a closed loop are its modes; as S-42.
#[test]
fn s46_eigenvalues_around_a_loop_are_the_modes() {
    compare_eigenvalues("S-46", &mut Setup::of(&gable("unstrained")));
}
