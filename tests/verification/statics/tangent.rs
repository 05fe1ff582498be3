//! S-01 to S-04: the exact tangent against differences of the residual and against a dense solution.

use foldwing::beam::element::{ElementKind, rigid_body_mass};
use foldwing::beam::section::Section;
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::multibody::closure::{Closure, Penalty};
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::{Attachment, BodyDescription};
use foldwing::multibody::tangent::{JointTangent, Surroundings, Tangent};
use foldwing::multibody::{Model, Workspace};
use nalgebra::{DVector, Matrix3, Matrix4, Matrix6, Vector3};

/// Pseudo-random numbers in [−1, 1] from a linear congruential generator: the same on every computer.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.roll(), self.roll(), self.roll())
    }

    fn wrench(&mut self) -> Wrench {
        Wrench { force_n: self.vector() * 5.0, moment_n_m: self.vector() * 3.0 }
    }
}

/// A tree of four bodies: both kinds of element, dead and follower loads at stations inside elements and at their ends, offset masses, a
/// coupled section; `joints` of the bodies; with `levers` also offsets and a rigid body; with `sheared` all bodies except the second have
/// shear.
fn tree(dice: &mut Dice, joints: [JointKind; 4], levers: bool, sheared: bool) -> Model {
    let mut stiffness = Matrix4::from_diagonal(&[200.0, 8.0, 10.0, 14.0].into());
    (stiffness[(1, 2)], stiffness[(2, 1)]) = (2.0, 2.0);
    (stiffness[(0, 3)], stiffness[(3, 0)]) = (5.0, 5.0);
    let section = Section {
        shear: None,
        stiffness,
        mass_kg_m: 0.8,
        first_moment_kg: [0.05, -0.02],
        second_moment_kg_m: [0.02, 0.003, 0.01],
        half_width_m: 0.1,
        half_height_m: 0.05,
    };
    let mut whole = Matrix6::from_diagonal(&[200.0, 8.0, 10.0, 14.0, 90.0, 60.0].into());
    for (i, j, coupling) in [(1, 2, 2.0), (0, 3, 5.0), (4, 1, 7.0), (4, 5, 20.0), (5, 2, -6.0), (5, 0, 30.0)] {
        (whole[(i, j)], whole[(j, i)]) = (coupling, coupling);
    }
    let with_shear = Section { shear: Some(whole), ..section.clone() };
    let kinds = [ElementKind::Linear, ElementKind::Constant, ElementKind::Constant, ElementKind::Linear];
    let frames = [LoadFrame::Root, LoadFrame::Section, LoadFrame::Root, LoadFrame::Section];
    let parents = [
        Attachment::Root(Vector3::new(0.1, 0.2, -0.3)),
        Attachment::Body { index: 0, position_m: 0.5 },
        Attachment::Body { index: 0, position_m: 1.0 },
        Attachment::Body { index: 2, position_m: 0.9 },
    ];
    let mut bodies: Vec<BodyDescription> = (0..4)
        .map(|i| BodyDescription {
            length_m: [1.0, 0.7, 0.9, 0.8][i],
            section: if sheared && i != 1 { with_shear.clone() } else { section.clone() }.into(),
            kind: kinds[i],
            elements: [2, 3, 2, 2][i],
            natural_strain: [0.0, 0.3, -0.2, 0.4].into(),
            offset_m: Vector3::zeros(),
            parent: parents[i],
            mount: nalgebra::Rotation3::new(dice.vector() * 0.6).into_inner(),
            joint: joints[i],
            masses: vec![(0.3, rigid_body_mass(0.5, &(dice.vector() * 0.1), &Matrix3::from_diagonal_element(0.02)))],
            stations_m: vec![0.0, 0.2, 0.41, [1.0, 0.7, 0.9, 0.8][i]],
            load_frame: frames[i],
        })
        .collect();
    if levers {
        // all joints have offsets, and the third body is rigid
        bodies[1..].iter_mut().for_each(|body| body.offset_m = dice.vector() * 0.3);
        bodies[2] = BodyDescription { length_m: 0.0, elements: 0, stations_m: vec![0.0], ..bodies[2].clone() };
        bodies[2].masses[0].0 = 0.0;
        bodies[3].parent = Attachment::Body { index: 2, position_m: 0.0 };
    }
    Model::new(&bodies)
}

/// A random state without velocities, and its loads.
struct Case {
    model: Model,
    q: Vec<f64>,
    root: RootMotion,
    loads: Vec<Wrench>,
    joints: Vec<JointTangent>,
}

impl Case {
    fn new(seed: u64, joints: [JointKind; 4], held: [bool; 4], rotates: bool) -> Self {
        Self::of(seed, joints, held, (rotates, false, false))
    }

    fn of(seed: u64, joints: [JointKind; 4], held: [bool; 4], (rotates, levers, sheared): (bool, bool, bool)) -> Self {
        let mut dice = Dice(seed);
        let model = tree(&mut dice, joints, levers, sheared);
        let mut q: Vec<f64> = model.natural_coordinates();
        for element in &model.elements {
            for k in 0..element.count() {
                q[element.coordinate + k] += dice.roll() * if (1..4).contains(&k) { 1.2 } else { 0.1 };
            }
        }
        for body in &model.bodies {
            let joint = &body.joint;
            if joint.kind.freedoms() == 1 {
                q[joint.coordinate] = dice.roll() * 2.0;
            }
            if joint.kind.is_redundant() {
                q[joint.range()].iter_mut().for_each(|q| *q += 0.2 * dice.roll());
                let mut rates = vec![0.0; q.len()];
                for _ in 0..6 {
                    joint.restore(&mut q, &mut rates.clone(), &mut rates);
                }
            }
        }
        let root = RootMotion {
            gravity_m_s2: dice.vector() * 9.0,
            acceleration_m_s2: dice.vector(),
            angular_velocity_rad_s: if rotates { dice.vector() * 2.0 } else { Vector3::zeros() },
            angular_acceleration_rad_s2: if rotates { dice.vector() * 3.0 } else { Vector3::zeros() },
        };
        let loads = model.stations.iter().map(|_| dice.wrench()).collect();
        let joints = held.map(|held| if held { JointTangent::HELD } else { JointTangent::one_freedom(0.0) }).to_vec();
        Self { model, q, root, loads, joints }
    }

    fn residual(&self, work: &mut Workspace, q: &[f64]) -> DVector<f64> {
        let n = self.model.coordinates;
        let (zero, damping) = (vec![0.0; n], vec![Damping::default(); self.model.bodies.len()]);
        let environment = Environment { root: &self.root, damping: &damping, stations: &self.loads };
        let mut value = vec![0.0; n];
        residual(&self.model, work, Motion { q, v: &zero, a: &zero }, environment, &mut value);
        DVector::from_vec(value)
    }

    fn tangent(&self, work: &mut Workspace) -> Tangent {
        self.residual(work, &self.q);
        let mut tangent = Tangent::new(&self.model);
        let surroundings = Surroundings { root: &self.root, stations: &self.loads, joints: &self.joints };
        tangent.linearize(&self.model, work, &self.q, surroundings);
        tangent
    }

    /// Entries of the vectors that belong to a degree of freedom.
    fn freedoms(&self) -> Vec<usize> {
        let mut list = Vec::new();
        for (body, joint) in self.model.bodies.iter().zip(&self.joints) {
            if joint.free {
                list.extend(body.joint.coordinate..body.joint.coordinate + body.joint.kind.freedoms());
            }
            let elements = &self.model.elements[body.first_element..body.first_element + body.elements];
            list.extend(elements.iter().flat_map(|element| element.range()));
        }
        list
    }

    /// Largest difference of a column of the tangent to sixth-order differences of the residual, relative to the
    /// largest entry of the tangent.
    fn worst_column(&self) -> f64 {
        let mut work = Workspace::new(&self.model);
        let dense = self.tangent(&mut work).dense(&self.model);
        let freedoms = self.freedoms();
        let still = work.clone();
        let step = 2e-3;
        let mut worst = 0.0f64;
        for &j in &freedoms {
            let mut change = vec![0.0; self.model.coordinates];
            change[j] = 1.0;
            Tangent::to_coordinates(&self.model, &still, &mut change);
            let mut at = |shift: f64| {
                let mut q: Vec<f64> = self.q.iter().zip(&change).map(|(q, change)| q + shift * change).collect();
                let mut rates = vec![0.0; q.len()];
                for body in &self.model.bodies {
                    body.joint.restore(&mut q, &mut rates.clone(), &mut rates);
                }
                self.residual(&mut work, &q)
            };
            let mut slope = (at(step) - at(-step)) * 45.0;
            slope -= (at(2.0 * step) - at(-2.0 * step)) * 9.0;
            slope += at(3.0 * step) - at(-3.0 * step);
            slope /= 60.0 * step;
            for &i in &freedoms {
                worst = worst.max((slope[i] - dense[(i, j)]).abs());
            }
        }
        worst / dense.amax()
    }
}

const HINGES: [JointKind; 4] = [
    JointKind::Clamped,
    JointKind::Revolute { axis: Vector3::new(0.0, 1.0, 0.0) },
    JointKind::Revolute { axis: Vector3::new(0.6, 0.0, 0.8) },
    JointKind::Revolute { axis: Vector3::new(0.0, 0.6, 0.8) },
];

fn spatial() -> [JointKind; 4] {
    [
        JointKind::Free,
        JointKind::Ball,
        JointKind::universal(Vector3::y(), Vector3::new(0.0, 0.0, 1.0)),
        JointKind::Revolute { axis: Vector3::new(0.0, 0.6, 0.8) },
    ]
}

/// S-01. The tangent against sixth-order differences of the residual at random states with strains up to a radian per element: both kinds
/// of element, hinges free and locked, dead and follower loads inside elements, inside pairs and on nodes, offset masses, a rotating root.
/// The differences are accurate to 1e-12.
#[test]
fn s01_tangent_is_the_derivative_of_the_residual() {
    for seed in 1..=3 {
        for (held, rotates) in [([false; 4], false), ([true, false, true, false], true)] {
            let worst = Case::new(seed, HINGES, held, rotates).worst_column();
            println!("S-01 seed {seed}, rotating root {rotates}: {worst:.1e}");
            assert!(worst < 1e-11, "seed {seed}, rotating root {rotates}: {worst:.1e}");
        }
    }
}

const SLIDES: [JointKind; 4] = [
    JointKind::Prismatic { axis: Vector3::new(0.0, 0.6, 0.8) },
    JointKind::Revolute { axis: Vector3::new(0.0, 1.0, 0.0) },
    JointKind::Prismatic { axis: Vector3::new(0.6, 0.0, 0.8) },
    JointKind::Prismatic { axis: Vector3::new(0.8, 0.6, 0.0) },
];

/// S-05. S-01 with prismatic joints, offsets and a rigid body, free and locked; hinges, ball and universal joints with offsets; and the
/// O(n) solution against the dense matrix.
#[test]
fn s05_tangent_with_levers() {
    let hung = [JointKind::Clamped, JointKind::Ball, spatial()[2], HINGES[3]];
    for (seed, joints) in [(11, SLIDES), (12, SLIDES), (13, hung), (14, HINGES), (15, hung)] {
        for (held, rotates) in [([false; 4], false), ([false, true, true, false], true), ([true; 4], true)] {
            let case = Case::of(seed, joints, held, (rotates, true, false));
            let worst = case.worst_column();
            // in a uniform field a translation of the whole tree along its free slide has no stiffness
            let backward = if rotates { backward_error(&case, seed) } else { 0.0 };
            println!("S-05 seed {seed}, rotating root {rotates}: {worst:.1e}, backward error {backward:.1e}");
            assert!(worst < 1e-11, "seed {seed}, rotating root {rotates}: {worst:.1e}");
            assert!(backward < 1e-13, "seed {seed}, rotating root {rotates}: backward error {backward:.1e}");
        }
    }
}

/// SH-21. S-01 to S-05 for bodies with shear, one without between them: gravity, a rotating root and loads at stations act on the tangents
/// of the axis, which rotate with the nodes and change with the strains.
#[test]
fn sh21_tangent_of_elements_with_shear() {
    let mut worst_all = [0.0f64; 2];
    for (seed, joints, levers) in [(21, HINGES, false), (22, spatial(), false), (23, SLIDES, true), (24, HINGES, true)]
    {
        for (held, rotates) in [([false; 4], false), ([false; 4], true), ([false, true, true, false], true)] {
            let case = Case::of(seed, joints, held, (rotates, levers, true));
            let worst = case.worst_column();
            // in a uniform field a translation of a free tree has no stiffness
            let backward = if rotates { backward_error(&case, seed) } else { 0.0 };
            worst_all = [worst_all[0].max(worst), worst_all[1].max(backward)];
            assert!(worst < 1e-11, "seed {seed}, rotating root {rotates}: {worst:.1e}");
            assert!(backward < 1e-13, "seed {seed}, rotating root {rotates}: backward error {backward:.1e}");
        }
    }
    println!("SH-21 differences {:.1e}, backward error {:.1e}", worst_all[0], worst_all[1]);
}

/// Backward error of the O(n) solution for a random right-hand side.
fn backward_error(case: &Case, seed: u64) -> f64 {
    let mut dice = Dice(seed);
    let mut work = Workspace::new(&case.model);
    let mut tangent = case.tangent(&mut work);
    let freedoms = case.freedoms();
    let mut right = vec![0.0; case.model.coordinates];
    freedoms.iter().for_each(|&i| right[i] = dice.roll());
    let mut x = right.clone();
    tangent.factorize(&case.model).expect("random tangents are regular");
    tangent.solve(&case.model, &mut x);
    let largest = x.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let mut product = vec![0.0; case.model.coordinates];
    tangent.apply(&case.model, &x, &mut product);
    let worst = freedoms.iter().fold(0.0f64, |worst, &i| worst.max((product[i] - right[i]).abs()));
    worst / (tangent.dense(&case.model).amax() * largest)
}

/// S-02. S-01 with free, ball and universal joints, in their degrees of freedom.
#[test]
fn s02_tangent_of_joints_with_redundant_parameters() {
    for seed in 4..=6 {
        for rotates in [false, true] {
            let worst = Case::new(seed, spatial(), [false; 4], rotates).worst_column();
            println!("S-02 seed {seed}, rotating root {rotates}: {worst:.1e}");
            assert!(worst < 1e-11, "seed {seed}, rotating root {rotates}: {worst:.1e}");
        }
    }
}

/// S-03. The O(n) factorisation solves the system of the dense matrix: backward error at round-off. The root rotates, because translations
/// of a free body in a uniform field have no stiffness.
#[test]
fn s03_recursive_solution_is_the_dense_one() {
    for seed in 1..=6 {
        let case = match seed % 2 {
            0 => Case::new(seed, HINGES, [false, false, true, false], true),
            _ => Case::new(seed, spatial(), [false; 4], true),
        };
        let backward = backward_error(&case, seed);
        println!("S-03 seed {seed}: backward error {backward:.1e}");
        assert!(backward < 1e-14, "seed {seed}: backward error {backward:.1e}");
    }
}

/// S-04. Closed loops: two closures between branches, with offset points and gaps of some millimetres. The tangent against differences, and
/// the corrected O(n) solution against the dense matrix; including hinges held only by the loops.
#[test]
fn s04_closed_loops() {
    for seed in 8..=10 {
        let mut case = Case::new(seed, HINGES, [false; 4], seed == 9);
        let mut dice = Dice(seed);
        let mut closure = |first: usize, second: usize, stiffness_n_m: f64| Closure {
            nodes: [first, second].map(|body| Some(case.model.bodies[body].last_node())),
            offsets_m: [dice.vector() * 0.1, dice.vector() * 0.1],
            penalty: Penalty { inertia_kg: 0.1, damping_n_s_m: 1.0, stiffness_n_m },
        };
        case.model.closures = vec![closure(1, 3, 300.0), closure(0, 1, 80.0), closure(2, 2, 120.0)];
        case.model.closures[2].nodes[seed as usize % 2] = None; // on the root
        let worst = case.worst_column();

        let n = case.model.coordinates;
        let mut work = Workspace::new(&case.model);
        let mut tangent = case.tangent(&mut work);
        let right: Vec<f64> = (0..n).map(|_| dice.roll()).collect();
        let mut x = right.clone();
        tangent.factorize(&case.model).expect("random tangents are regular");
        tangent.solve(&case.model, &mut x);
        let dense = tangent.dense(&case.model);
        let product = &dense * DVector::from_column_slice(&x);
        let gap = (product - DVector::from_vec(right)).amax();
        let backward = gap / (dense.amax() * x.iter().fold(0.0f64, |largest, x| largest.max(x.abs())));
        println!("S-04 seed {seed}: differences {worst:.1e}, backward error {backward:.1e}");
        assert!(worst < 1e-11 && backward < 1e-12, "seed {seed}: {worst:.1e}, {backward:.1e}");
    }
}
