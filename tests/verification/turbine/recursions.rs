//! Modal bodies in the recursions: elimination against a dense matrix, the tangent against differences, and the power of loads.

use crate::trees::Random;
use crate::turbine::machine::{law, turbine};
use foldwing::beam::element::{ElementKind, rigid_body_mass};
use foldwing::beam::law::{NaturalStrain, SectionLaw};
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::factor::{FreedomTangent, Weights, factorize, solve};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::{Motion, sweep_poses};
use foldwing::multibody::model::{Attachment, BodyDescription};
use foldwing::multibody::tangent::{JointTangent, Surroundings, Tangent};
use foldwing::multibody::{Model, Workspace, station};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

/// A tower, a rigid body on a hinge offset from its top, a twisted blade on that body, a mass at the blade's tip and a rigid body on a hinge
/// there; loads in both frames along the bodies and at the ends.
fn tree([axial_shortening, section_rotation]: [bool; 2]) -> Model {
    let machine = turbine();
    let law_of = |name: &str| {
        let mut law = law(machine.bodies.iter().find(|body| body.name == name).expect("a body")).clone();
        (law.axial_shortening, law.section_rotation) = (axial_shortening, section_rotation);
        SectionLaw::from(law)
    };
    let inertia = Matrix3::from_diagonal(&Vector3::new(3e5, 2e5, 4e5));
    let heavy = |mass_kg: f64| rigid_body_mass(mass_kg, &Vector3::new(0.4, -0.8, 1.1), &inertia);
    let body = |section: SectionLaw, length_m: f64, elements: usize| BodyDescription {
        length_m,
        section,
        kind: ElementKind::Linear,
        elements,
        natural_strain: NaturalStrain::from([0.0; 4]),
        parent: Attachment::Root(Vector3::new(1.0, 2.0, 0.5)),
        offset_m: Vector3::zeros(),
        mount: Rotation3::new(Vector3::new(0.3, -1.4, 0.5)).into_inner(),
        joint: JointKind::Clamped,
        masses: Vec::new(),
        stations_m: vec![0.0, 0.31 * length_m, 0.77 * length_m, length_m],
        load_frame: LoadFrame::Section,
    };
    let tower = body(law_of("tower"), 87.6, 20);
    let nacelle = BodyDescription {
        parent: Attachment::Body { index: 0, position_m: 87.6 },
        offset_m: Vector3::new(1.0, 0.5, -2.0),
        joint: JointKind::Revolute { axis: Vector3::new(0.6, 0.0, 0.8) },
        masses: vec![(0.0, heavy(2e5))],
        stations_m: vec![0.0],
        load_frame: LoadFrame::Root,
        ..body(law_of("tower"), 0.0, 0)
    };
    let nacelle = BodyDescription { section: foldwing_solid(), ..nacelle };
    let blade = BodyDescription {
        parent: Attachment::Body { index: 1, position_m: 0.0 },
        offset_m: Vector3::new(0.0, 1.5, 0.2),
        joint: JointKind::Revolute { axis: Vector3::x() },
        masses: vec![(61.5, heavy(900.0))],
        load_frame: LoadFrame::Root,
        ..body(law_of("blade1"), 61.5, 17)
    };
    // parts attached to a moving modal body transmit their forces through it
    let tip = BodyDescription {
        parent: Attachment::Body { index: 2, position_m: 61.5 },
        offset_m: Vector3::new(0.3, -0.4, 0.1),
        joint: JointKind::Revolute { axis: Vector3::y() },
        masses: vec![(0.0, heavy(700.0))],
        ..nacelle.clone()
    };
    Model::new(&[tower, nacelle, blade, tip])
}

/// An unused section.
fn foldwing_solid() -> SectionLaw {
    use foldwing::beam::section::{Material, Solid};
    Solid::rectangle(1.0, 1.0, Material::isotropic(1.0, 0.0, 1.0)).into()
}

struct Setting {
    model: Model,
    root: RootMotion,
    loads: Vec<Wrench>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

fn setting(seed: u64) -> Setting {
    keeping(seed, [true, true])
}

/// A setting with or without shortening and rotation of sections.
fn keeping(seed: u64, keeps: [bool; 2]) -> Setting {
    let model = tree(keeps);
    let mut random = Random::new(seed);
    let n = model.coordinates;
    let mut vector = |size: f64| -> Vec<f64> { (0..n).map(|_| size * random.symmetric()).collect() };
    let (q, v, a) = (vector(1.5), vector(2.0), vector(5.0));
    let root = RootMotion {
        gravity_m_s2: random.vector() * 10.0,
        acceleration_m_s2: random.vector(),
        angular_velocity_rad_s: random.vector() * 1.3,
        angular_acceleration_rad_s2: random.vector() * 0.4,
    };
    let wrench = |random: &mut Random| Wrench { force_n: random.vector() * 3e5, moment_n_m: random.vector() * 1e6 };
    let loads = (0..model.stations.len()).map(|_| wrench(&mut random)).collect();
    Setting { model, root, loads, q, v, a }
}

impl Setting {
    fn residual(&self, work: &mut Workspace, q: &[f64], v: &[f64], a: &[f64]) -> DVector<f64> {
        let mut value = vec![0.0; q.len()];
        let damping = vec![Damping::default(); self.model.bodies.len()];
        let environment = Environment { root: &self.root, damping: &damping, stations: &self.loads };
        residual(&self.model, work, Motion { q, v, a }, environment, &mut value);
        value.into()
    }
}

/// WT-08. The articulated-body elimination of modal bodies against a dense matrix: columns of the mass matrix from residuals of unit
/// accelerations, stiffness and symmetric damping from the elements. Tolerance 1e-11 of the solution, for condition numbers of 1e5.
#[test]
fn wt08_elimination_is_that_of_the_dense_matrix() {
    for seed in 1..=3 {
        let setting = setting(seed);
        let (model, n) = (&setting.model, setting.q.len());
        let mut work = Workspace::new(model);
        let zero = vec![0.0; n];
        let base = setting.residual(&mut work, &setting.q, &zero, &zero);
        let mut mass = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut unit = zero.clone();
            unit[j] = 1.0;
            mass.column_mut(j).copy_from(&(setting.residual(&mut work, &setting.q, &zero, &unit) - &base));
        }
        assert!((&mass - mass.transpose()).amax() < 1e-9 * mass.amax(), "the mass is not symmetric");
        let weights = Weights { mass: 1.0, damping: 5e-3, stiffness: 2.5e-5 };
        let mut matrix = mass * weights.mass;
        for modal in model.bodies.iter().filter_map(|body| body.modal.as_ref()) {
            let (first, element) = (modal.coordinate, &modal.element);
            for i in 0..element.modes {
                for j in 0..element.modes {
                    let damping = 0.5 * (element.damping[(i, j)] + element.damping[(j, i)]);
                    matrix[(first + i, first + j)] +=
                        weights.stiffness * element.stiffness[(i, j)] + weights.damping * damping;
                }
            }
        }
        let hinge = FreedomTangent { free: true, stiffness: 3e6, damping: 2e5 };
        let tangents = vec![hinge; model.bodies.len()];
        for body in &model.bodies[1..] {
            let c = body.joint.coordinate;
            matrix[(c, c)] += weights.stiffness * hinge.stiffness + weights.damping * hinge.damping;
        }
        sweep_poses(model, &mut work, &setting.q);
        let damping = vec![Damping::default(); model.bodies.len()];
        factorize(model, &mut work, weights, &damping, &tangents).expect("a factor");
        let right = DVector::from_vec(setting.a.clone()).map(|a| a * 1e5);
        let mut x = right.as_slice().to_vec();
        solve(model, &mut work, &mut x);
        let expected = matrix.lu().solve(&right).expect("a regular matrix");
        let error = (DVector::from_vec(x) - &expected).amax() / expected.amax();
        println!("WT-08, seed {seed}: {error:.1e}");
        assert!(error < 1e-11, "seed {seed}: off by {error:.1e}");
    }
}

/// WT-09. The exact static tangent against differences of the static residual, on a rotating root, with dead and follower loads; and its
/// factorisation against the tangent. Sixth-order differences of 1e-2 have an error of 1e-9.
#[test]
fn wt09_tangent_is_the_derivative_of_the_residual() {
    for seed in 1..=3 {
        let (worst, back) = tangent_errors(&setting(seed));
        println!("WT-09, seed {seed}: tangent {worst:.1e}, solution {back:.1e}");
        assert!(worst < 1e-8, "seed {seed}: the tangent is off by {worst:.1e}");
        assert!(back < 1e-8, "seed {seed}: the solution is off by {back:.1e}");
    }
}

/// WT-54. WT-09 for bodies without shortening, without rotation of sections, and without both.
#[test]
fn wt54_tangent_of_bodies_that_keep_less() {
    for keeps in [[false, true], [true, false], [false, false]] {
        let (worst, back) = tangent_errors(&keeping(1, keeps));
        println!("WT-54, {keeps:?}: tangent {worst:.1e}, solution {back:.1e}");
        assert!(worst < 1e-8, "{keeps:?}: the tangent is off by {worst:.1e}");
        assert!(back < 1e-8, "{keeps:?}: the solution is off by {back:.1e}");
    }
}

/// Errors of the tangent relative to differences, and of its factorisation.
fn tangent_errors(setting: &Setting) -> (f64, f64) {
    let (model, n) = (&setting.model, setting.q.len());
    let mut work = Workspace::new(model);
    let zero = vec![0.0; n];
    setting.residual(&mut work, &setting.q, &zero, &zero);
    let joints = vec![JointTangent::one_freedom(0.0); model.bodies.len()];
    let mut tangent = Tangent::new(model);
    let surroundings = Surroundings { root: &setting.root, stations: &setting.loads, joints: &joints };
    tangent.linearize(model, &work, &setting.q, surroundings);
    let exact = tangent.dense(model);
    let mut worst = 0.0f64;
    for j in 0..n {
        let at = |steps: f64| {
            let mut q = setting.q.clone();
            q[j] += 1e-2 * steps;
            setting.residual(&mut Workspace::new(model), &q, &zero, &zero)
        };
        let slope = ((at(1.0) - at(-1.0)) * 45.0 - (at(2.0) - at(-2.0)) * 9.0 + at(3.0) - at(-3.0)) / 0.6;
        worst = worst.max((exact.column(j) - &slope).amax() / slope.amax());
    }
    tangent.factorize(model).expect("a factor");
    let (mut y, mut x) = (vec![0.0; n], setting.a.clone());
    tangent.apply(model, &setting.a, &mut y);
    x.copy_from_slice(&y);
    tangent.solve(model, &mut x);
    let back = (0..n).map(|i| (x[i] - setting.a[i]).abs()).fold(0.0, f64::max);
    (worst, back)
}

/// WT-10. The power of a load at a station equals that of its generalised forces on the coordinates: forces are mapped by the transpose of
/// the velocity map.
#[test]
fn wt10_loads_do_the_power_of_their_places() {
    let mut setting = setting(4);
    setting.root = RootMotion::default();
    let n = setting.q.len();
    let (model, mut work, zero) = (setting.model.clone(), Workspace::new(&setting.model), vec![0.0; n]);
    let with = setting.residual(&mut work, &setting.q, &setting.v, &zero);
    let motion = Motion { q: &setting.q, v: &setting.v, a: &zero };
    let power: f64 = model
        .stations
        .iter()
        .zip(&setting.loads)
        .map(|(place, load)| station::power_w(&station::motion(&model, &work, motion, place), load, place.frame))
        .sum();
    let loads = std::mem::take(&mut setting.loads);
    let without = setting.residual(&mut work, &setting.q, &setting.v, &zero);
    assert!(!loads.is_empty());
    let on_coordinates = (without - with).dot(&DVector::from_vec(setting.v.clone()));
    println!("WT-10: {power:.6e} W and {on_coordinates:.6e} W");
    assert!((power - on_coordinates).abs() < 1e-10 * power.abs());
}

/// WT-11. Velocities and accelerations of points and sections are the rates of their positions and attitudes.
#[test]
fn wt11_places_move_as_their_positions_change() {
    let setting = setting(5);
    let (model, n) = (&setting.model, setting.q.len());
    let at =
        |t: f64| -> Vec<f64> { (0..n).map(|i| setting.q[i] + t * setting.v[i] + 0.5 * t * t * setting.a[i]).collect() };
    let rate = |t: f64| -> Vec<f64> { (0..n).map(|i| setting.v[i] + t * setting.a[i]).collect() };
    let step = 1e-4;
    for (index, place) in model.stations.iter().enumerate() {
        let mut work = Workspace::new(model);
        let mut moving = |t: f64| {
            let (q, v) = (at(t), rate(t));
            setting.residual(&mut work, &q, &v, &setting.a);
            let motion = Motion { q: &q, v: &v, a: &setting.a };
            station::accelerated(model, &work, motion, place)
        };
        let (before, now, after) = (moving(-step), moving(0.0), moving(step));
        let velocity = (after.motion.position_m - before.motion.position_m) / (2.0 * step);
        let acceleration = (after.motion.velocity_m_s - before.motion.velocity_m_s) / (2.0 * step);
        // differences have an error of the square of the step: on the tower, whose positions are polynomials of fourth degree in time, 1e-8
        // of about 1e2 m/s³; further outboard, where bodies rotate at a few rad/s, of up to 1e5 m/s³, in addition to Coriolis terms of 1
        // m/s² and more
        let allowed = if place.body == 0 { 1e-5 } else { 1e-3 };
        assert!((velocity - now.motion.velocity_m_s).norm() < allowed, "station {index}: {velocity}");
        let off = (acceleration - now.acceleration_m_s2).norm();
        println!("WT-11: station {index} of body {}: {off:.1e} m/s² of {:.1e}", place.body, acceleration.norm());
        assert!(off < allowed, "station {index}: {acceleration}");
        let turned = Rotation3::from_matrix_unchecked(after.motion.rotation * before.motion.rotation.transpose());
        let spin = turned.scaled_axis() / (2.0 * step);
        let spin_rate = (after.motion.spin_rad_s - before.motion.spin_rad_s) / (2.0 * step);
        assert!((spin - now.motion.spin_rad_s).norm() < 1e-5, "station {index}: {spin} {}", now.motion.spin_rad_s);
        assert!(
            (spin_rate - now.spin_rate_rad_s2).norm() < 1e-5,
            "station {index}: {spin_rate} {}",
            now.spin_rate_rad_s2
        );
    }
}
