//! C-40 to C-43: the product's recursions and time integration against the dense models, for the double pendulums.

use crate::conventional::assembly::Assembly;
use crate::conventional::pendulum::{
    Between, DENSITY_KG_M3, GRAVITY_M_S2, LENGTH_M, SECOND_M4, SHEAR_PA, SIDE_M, STEP_S, YOUNG_PA, joint_parameters,
    start_of_b,
};
use crate::conventional::reference;
use crate::conventional::sample::{Sample, run_as_printed, write_table};
use crate::plant::machines;
use crate::whole::is_whole;
use foldwing::beam::section::{Material, Section};
use foldwing::load::{LoadFrame, RootMotion};
use foldwing::machine::*;
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::factor::{FreedomTangent, Weights, factorize, solve};
use foldwing::multibody::joint;
use foldwing::multibody::kinematics;
use foldwing::multibody::model::{Attachment, BodyDescription};
use foldwing::multibody::{Model, Workspace};
use foldwing::plant::Outputs;
use nalgebra::{DVector, Matrix3, Vector3};

/// Section of Table 3.
fn section() -> Section {
    let material = Material { youngs_modulus_pa: YOUNG_PA, shear_modulus_pa: SHEAR_PA, density_kg_m3: DENSITY_KG_M3 };
    Section::rectangle(SIDE_M, SIDE_M, &material, Some(SHEAR_PA * 2.0 * SECOND_M4))
}

/// The double pendulum as a machine.
fn machine(between: Between, kind: ElementKind, count: usize, solver: Solver) -> Machine {
    let between = match between {
        Between::Ball => Joint::ball("between"),
        Between::Universal => Joint::universal("between", Vector3::y(), Vector3::z()),
        Between::Revolute => Joint::revolute("between", Vector3::x()),
    };
    let beam = |name| machines::body(name, LENGTH_M, &section(), kind, count);
    let bodies = [(beam("a"), Joint::ball("mount")), (beam("b"), between.on("a").mount(start_of_b()))];
    Machine { gravity_m_s2: Vector3::new(0.0, -GRAVITY_M_S2, 0.0), solver, ..machines::machine(bodies) }
}

/// ESDIRK4 with fixed steps.
fn fixed(step_s: f64) -> Solver {
    Solver { fixed_step_s: Some(step_s), max_step_s: step_s, ..machines::solver(Method::Esdirk4, 1e-10) }
}

/// Outputs every 10 ms, the start included.
fn outputs(machine: Machine, end_s: f64) -> Vec<Outputs> {
    let mut plant = machines::start(machine);
    let mut all = vec![plant.outputs().clone()];
    let count = (end_s / 0.01).round() as usize;
    machines::run(&mut plant, end_s, count, |_| {}, |outputs| all.push(outputs.clone()));
    all
}

/// C-40. Product (O(n) recursion with the constraints kept inside the joints) against dense joint parameters (KKT) on the same mesh: tip,
/// elastic energy (which depends on all strains), joint forces and moments, and total energy over 2 s (0.4 s in short studies), both by
/// Runge–Kutta with the paper's step.
///
/// The dense form corrects drift in the redundant parameters, the product does so differently, and both have round-off with a condition
/// number of 1e6: 1e-9 m is five orders below the difference of two meshes.
#[test]
#[ignore = "long; `make long` runs it"]
fn c40_product_follows_the_dense_model() {
    let span_s = if is_whole() { 2.0 } else { 0.4 };
    for between in Between::ALL {
        let name = between.name();
        let (dense, start) = joint_parameters(between, 2);
        let dense = run_as_printed(&dense, &start, span_s, true);
        let solver = Solver { method: Method::Rk4, ..fixed(STEP_S) };
        let product = outputs(machine(between, ElementKind::Constant, 2, solver), span_s);
        let worst = |quantity: &dyn Fn(&Sample, &Outputs) -> f64| {
            dense.iter().zip(&product).map(|(a, b)| quantity(a, b)).fold(0.0, f64::max)
        };
        // the universal joint's rotation keeps r_y^P and r_z^Q normal
        let cardan = match between {
            Between::Universal => worst(&|_, b| (b.spatial()[1].rotation * Vector3::z()).y.abs()),
            _ => 0.0,
        };
        let tip_m = worst(&|a, b| (a.tip_m - b.tips()[0].position_m).norm());
        let force_n = worst(&|a, b| (a.reaction[0] - b.joint_reactions()[1].force_n).norm());
        let moment_n_m = worst(&|a, b| (a.reaction[1] - b.joint_reactions()[1].moment_n_m).norm());
        let max_force_n = worst(&|a, _| a.reaction[0].norm());
        let max_moment_n_m = worst(&|a, _| a.reaction[1].norm());
        let elastic_j = worst(&|a, b| (a.energy_j[1] - b.energy().elastic).abs());
        let max_elastic_j = worst(&|a, _| a.energy_j[1]);
        let kinetic_j = worst(&|a, _| a.energy_j[0]);
        let energy = worst(&|_, b| b.energy().total.abs()) / kinetic_j;
        println!(
            "{name}: tip {tip_m:.1e} m, elastic energy {elastic_j:.1e} J of {max_elastic_j:.1e} J, \
             joint force {force_n:.1e} N of {max_force_n:.0} N, moment {moment_n_m:.1e} N·m of {max_moment_n_m:.1e} N·m, energy {energy:.1e}, r_y^P·r_z^Q {cardan:.1e}"
        );
        assert!(tip_m < 1e-9, "{name}: tips differ by {tip_m:.1e} m");
        assert!(
            elastic_j < 1e-7 * max_elastic_j,
            "{name}: elastic energies differ by {elastic_j:.1e} J of {max_elastic_j:.1e} J"
        );
        assert!(force_n < 1e-7 * max_force_n, "{name}: joint forces differ by {force_n:.1e} N of {max_force_n:.0} N");
        assert!(moment_n_m < 1e-5, "{name}: joint moments differ by {moment_n_m:.1e} N·m of {max_moment_n_m:.1e} N·m");
        assert!(energy < 1e-6, "{name}: total energy reaches {energy:.1e} of the largest kinetic energy");
        assert!(cardan < 1e-10, "{name}: r_y^P·r_z^Q = {cardan:.1e}");
        write_product(name, &product);
    }
}

/// Writes a motion computed by the product.
fn write_product(name: &str, product: &[Outputs]) {
    let rows = product.iter().map(|outputs| {
        let mut row = vec![outputs.time_s];
        row.extend(outputs.tips()[0].position_m.iter());
        row.extend([outputs.energy().kinetic, outputs.energy().elastic, outputs.energy().gravity]);
        row.extend(outputs.joint_reactions()[1].force_n.iter());
        row.extend(outputs.joint_reactions()[1].moment_n_m.iter());
        row
    });
    let header = "t_s,tip_x_m,tip_y_m,tip_z_m,kinetic_j,elastic_j,gravity_j,fx_n,fy_n,fz_n,mx_n_m,my_n_m,mz_n_m";
    write_table(&format!("double_pendulum_{name}_product"), header, rows);
}

/// C-42. Tip of the ball–ball pendulum computed by the product: within 1 mm of the reference up to 1 s with eight constant elements or four
/// pairs per body.
#[test]
fn c42_product_meets_the_reference_up_to_1_s() {
    let reference = reference::columns("double_pendulum_ball_ball_exudyn.csv");
    for (kind, count) in [(ElementKind::Constant, 8), (ElementKind::Linear, 4)] {
        let product = outputs(machine(Between::Ball, kind, count, fixed(1e-3)), 1.0);
        let error_m = product
            .iter()
            .zip(&reference)
            .map(|(outputs, row)| (outputs.tips()[0].position_m - Vector3::new(row[4], row[5], -row[6])).norm());
        let error_m = error_m.fold(0.0, f64::max);
        println!("{count} {kind:?}: tip within {error_m:.2e} m up to 1 s");
        assert!(error_m < 1e-3, "{count} {kind:?}: tip {error_m:.2e} m off");
    }
}

/// C-43. Total energy computed by the product over 2 s: constant to 1e-6 of the largest kinetic energy with ESDIRK4 at 5 ms.
#[test]
fn c43_product_conserves_energy() {
    for between in Between::ALL {
        let name = between.name();
        let product = outputs(machine(between, ElementKind::Constant, 2, fixed(5e-3)), 2.0);
        let kinetic_j = product.iter().map(|outputs| outputs.energy().kinetic).fold(0.0, f64::max);
        let energy = product.iter().map(|outputs| outputs.energy().total.abs()).fold(0.0, f64::max) / kinetic_j;
        println!("{name}: energy {energy:.1e} of {kinetic_j:.0} J over 2 s at 5 ms");
        assert!(energy < 1e-6, "{name}: total energy reaches {energy:.1e} of the largest kinetic energy");
    }
}

/// Model of the product with the same mesh as a dense one.
fn model(between: Between) -> Model {
    let body = |parent, mount, joint| BodyDescription {
        length_m: LENGTH_M,
        section: foldwing::beam::law::SectionLaw::Uniform(section()),
        kind: ElementKind::Constant,
        elements: 2,
        natural_strain: [0.0; 4].into(),
        offset_m: Vector3::zeros(),
        parent,
        mount,
        joint,
        masses: Vec::new(),
        stations_m: Vec::new(),
        load_frame: LoadFrame::Root,
    };
    let joint = match between {
        Between::Ball => joint::JointKind::Ball,
        Between::Universal => joint::JointKind::universal(Vector3::y(), Vector3::z()),
        Between::Revolute => joint::JointKind::Revolute { axis: Vector3::x() },
    };
    Model::new(&[
        body(Attachment::Root(Vector3::zeros()), Matrix3::identity(), joint::JointKind::Ball),
        body(Attachment::Body { index: 0, position_m: LENGTH_M }, start_of_b(), joint),
    ])
}

/// A bent and moving state that satisfies the constraints.
fn scattered(system: &Assembly, start: &DVector<f64>, seed: f64) -> (DVector<f64>, DVector<f64>) {
    let wave = |i: usize, phase: f64| (12.9898 * i as f64 + phase + seed).sin();
    let mut q = DVector::from_fn(start.len(), |i, _| start[i] + 0.3 * wave(i, 0.0));
    let mut v = DVector::from_fn(start.len(), |i, _| wave(i, 2.0));
    (0..3).for_each(|_| system.project(&mut q, &mut v));
    (q, v)
}

/// C-41. Accelerations of all coordinates, redundant joint parameters included, at bent and moving states: by the product's recursion, and
/// by eq. (9) in dense form with multipliers. The condition number of the mass matrix is about 1e6 here.
#[test]
fn c41_accelerations_equal_the_dense_ones() {
    for between in Between::ALL {
        let (dense, start) = joint_parameters(between, 2);
        let model = model(between);
        assert_eq!(model.coordinates, dense.coordinates(), "{between:?}: coordinates");
        for seed in [0.3, 1.1, 4.7] {
            let (q, v) = scattered(&dense, &start, seed);
            let (expected, _) = dense.accelerations(&q, &v);
            let mut work = Workspace::new(&model);
            let (zero, mut x) = (vec![0.0; q.len()], vec![0.0; q.len()]);
            let gravity_m_s2 = Vector3::new(0.0, -GRAVITY_M_S2, 0.0);
            let root = RootMotion { gravity_m_s2, ..RootMotion::default() };
            let damping = [Damping::default(); 2];
            let environment = Environment { root: &root, damping: &damping, stations: &[] };
            let motion = kinematics::Motion { q: q.as_slice(), v: v.as_slice(), a: &zero };
            residual(&model, &mut work, motion, environment, &mut x);
            let weights = Weights { mass: 1.0, damping: 0.0, stiffness: 0.0 };
            let free = FreedomTangent { free: true, stiffness: 0.0, damping: 0.0 };
            factorize(&model, &mut work, weights, &damping, &[free; 2]).expect("a positive mass matrix");
            solve(&model, &mut work, &mut x);
            let product = -DVector::from_vec(x);
            let error = (&product - &expected).amax() / expected.amax();
            println!("{between:?}, state {seed}: accelerations differ by {error:.1e} of {:.1e}", expected.amax());
            assert!(error < 1e-9, "{between:?}, state {seed}: accelerations differ by {error:.1e}");
        }
    }
}
