//! Trees for the checks at random states, and the random numbers for them.

use foldwing::beam::element::{ElementKind, rigid_body_mass};
use foldwing::beam::section::{Section, condensed};
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::multibody::Model;
use foldwing::multibody::dynamics::Damping;
use foldwing::multibody::factor::FreedomTangent;
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::model::{Attachment, BodyDescription};
use nalgebra::{Matrix3, Matrix4, Rotation3, SMatrix, Unit, Vector3};

/// Numerical Recipes' 64-bit linear congruential generator; its upper bits are adequate for test states.
pub struct Random(u64);

impl Random {
    /// Generator for a seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        for _ in 0..4 {
            random.symmetric();
        }
        random
    }

    /// Uniform in `[−1, 1)`.
    pub fn symmetric(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A vector of three such numbers.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.symmetric(), self.symmetric(), self.symmetric())
    }

    /// Unit vector.
    pub fn direction(&mut self) -> Vector3<f64> {
        (self.vector() + Vector3::new(0.01, 0.02, 0.03)).normalize()
    }

    /// Any rotation.
    pub fn rotation(&mut self) -> Matrix3<f64> {
        Rotation3::from_axis_angle(&Unit::new_normalize(self.direction()), 3.0 * self.symmetric()).into_inner()
    }
}

/// Point masses `(kg, position in the section frame in m)` that make up a rigid body.
pub type Cloud = Vec<(f64, Vector3<f64>)>;

/// A tree: its description, its attached bodies as clouds of point masses, and the meshed model.
pub struct Case {
    /// Bodies.
    pub descriptions: Vec<BodyDescription>,
    /// Body, distance from its inner end in m, and the point masses there.
    pub clouds: Vec<(usize, f64, Cloud)>,
    /// Meshed model.
    pub model: Model,
}

impl Case {
    /// Reduces the clouds by the textbook formulas of mass, centre and inertia, and meshes.
    pub fn new(mut descriptions: Vec<BodyDescription>, clouds: Vec<(usize, f64, Cloud)>) -> Self {
        for (body, position_m, cloud) in &clouds {
            let mass: f64 = cloud.iter().map(|(mass, _)| mass).sum();
            let centre = cloud.iter().map(|(mass, place)| place * *mass).sum::<Vector3<f64>>() / mass;
            let mut inertia = Matrix3::zeros();
            for (mass, place) in cloud {
                let arm = place - centre;
                inertia += (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * *mass;
            }
            descriptions[*body].masses.push((*position_m, rigid_body_mass(mass, &centre, &inertia)));
        }
        let model = Model::new(&descriptions);
        Self { descriptions, clouds, model }
    }
}

/// Section with every coupling that a symmetric positive definite stiffness and inertia can have.
pub fn full_section(random: &mut Random) -> Section {
    let root = Matrix4::from_fn(|_, _| random.symmetric());
    let spread = Matrix3::from_fn(|_, _| random.symmetric());
    let inertia = spread * spread.transpose() + Matrix3::identity() * 0.3;
    Section {
        stiffness: root * root.transpose() + Matrix4::identity() * 0.5,
        mass_kg_m: 1.5 * inertia[(0, 0)],
        first_moment_kg: [0.3 * inertia[(0, 1)], 0.3 * inertia[(0, 2)]],
        second_moment_kg_m: [0.06 * inertia[(1, 1)], 0.06 * inertia[(1, 2)], 0.06 * inertia[(2, 2)]],
        half_width_m: 0.1,
        half_height_m: 0.05,
        shear: None,
    }
}

/// A tree with shear in every beam, or in every other one: fully coupled stiffnesses.
pub fn with_shear(seed: u64, case: &Case, every: usize) -> Case {
    let mut random = Random::new(seed + 300);
    let mut descriptions = case.descriptions.clone();
    for body in descriptions.iter_mut().filter(|body| body.elements > 0).step_by(every) {
        let root = SMatrix::<f64, 6, 6>::from_fn(|_, _| random.symmetric());
        let whole = root * root.transpose() + SMatrix::identity() * 0.5;
        let stiffness = condensed(&whole).expect("positive definite");
        body.section = Section { stiffness, shear: Some(whole), ..body.section.at(0.0) }.into();
    }
    Case { model: Model::new(&descriptions), descriptions, clouds: case.clouds.clone() }
}

/// Clamped body at the origin with a full section and natural strain.
pub fn random_body(random: &mut Random, length_m: f64, kind: ElementKind, elements: usize) -> BodyDescription {
    BodyDescription {
        length_m,
        section: full_section(random).into(),
        kind,
        elements,
        natural_strain: [
            0.02 * random.symmetric(),
            0.3 * random.symmetric(),
            0.3 * random.symmetric(),
            0.3 * random.symmetric(),
        ]
        .into(),
        offset_m: Vector3::zeros(),
        parent: Attachment::Root(Vector3::zeros()),
        mount: Matrix3::identity(),
        joint: JointKind::Clamped,
        masses: Vec::new(),
        stations_m: Vec::new(),
        load_frame: LoadFrame::Root,
    }
}

/// Clamped A, hinge, B.
pub fn two_bodies(seed: u64, kinds: [ElementKind; 2], elements: usize) -> Case {
    let mut random = Random::new(seed);
    let mut a = random_body(&mut random, 0.9, kinds[0], elements);
    let mut b = random_body(&mut random, 0.7, kinds[1], elements);
    a.mount = random.rotation();
    a.parent = Attachment::Root(random.vector());
    a.stations_m = vec![0.21, 0.9];
    a.load_frame = LoadFrame::Section;
    b.parent = Attachment::Body { index: 0, position_m: 0.9 };
    b.joint = JointKind::Revolute { axis: random.direction() };
    b.mount = random.rotation();
    b.stations_m = vec![0.0, 0.13, 0.35, 0.7];
    Case::new(vec![a, b], Vec::new())
}

/// Branches from the middle and the tip of a mounted body, a second tree on the root, rigid bodies off the axis.
pub fn branching_tree(seed: u64, kinds: [ElementKind; 4]) -> Case {
    let mut random = Random::new(seed);
    let mut bodies: Vec<BodyDescription> =
        kinds.iter().zip([1.0, 0.6, 0.5, 0.8]).map(|(&kind, l)| random_body(&mut random, l, kind, 3)).collect();
    for body in &mut bodies {
        body.mount = random.rotation();
    }
    bodies[0].parent = Attachment::Root(random.vector());
    bodies[1].parent = Attachment::Body { index: 0, position_m: 0.4 };
    bodies[1].joint = JointKind::Revolute { axis: random.direction() };
    bodies[2].parent = Attachment::Body { index: 0, position_m: 1.0 };
    bodies[3].parent = Attachment::Root(random.vector());
    bodies[3].joint = JointKind::Revolute { axis: random.direction() };
    bodies[0].stations_m = vec![0.1, 0.4, 0.77];
    bodies[1].stations_m = vec![0.33, 0.6];
    bodies[1].load_frame = LoadFrame::Section;
    bodies[2].stations_m = vec![0.05];
    bodies[3].stations_m = vec![0.5, 0.8];
    bodies[3].load_frame = LoadFrame::Section;
    let mut cloud = |n: usize| -> Cloud {
        (0..n).map(|_| (0.2 + 0.1 * random.symmetric(), random.vector() * 0.2 + Vector3::x() * 0.1)).collect()
    };
    let clouds = vec![(0, 0.7, cloud(5)), (1, 0.6, cloud(1)), (2, 0.0, cloud(4)), (3, 0.8, cloud(6))];
    Case::new(bodies, clouds)
}

/// Rigid bodies, offsets and prismatic joints: a rigid body on a prismatic joint at the root carries a beam at an offset; to this beam are
/// attached a beam on an offset hinge, which carries one on a prismatic joint, and a rigid body on an offset prismatic joint, which carries
/// a rigid body on an offset hinge.
pub fn levers(seed: u64, kinds: [ElementKind; 3]) -> Case {
    let mut random = Random::new(seed);
    let mut beams = kinds.map(|kind| random_body(&mut random, 0.7, kind, 2)).into_iter();
    let rigid = random_rigid_body;
    let mut bodies: Vec<BodyDescription> = [true, false, false, true, true, false]
        .iter()
        .map(|&is_rigid| if is_rigid { rigid(&mut random) } else { beams.next().expect("three beams") })
        .collect();
    let hang = |index, position_m| Attachment::Body { index, position_m };
    let parents = [hang(0, 0.0), hang(1, 0.3), hang(1, 0.7), hang(3, 0.0), hang(2, 0.7)];
    bodies[0].parent = Attachment::Root(random.vector());
    for (body, parent) in bodies[1..].iter_mut().zip(parents) {
        body.parent = parent;
        body.offset_m = random.vector() * 0.4;
    }
    bodies[5].offset_m = Vector3::zeros();
    for body in &mut bodies {
        body.mount = random.rotation();
        body.load_frame = if random.symmetric() > 0.0 { LoadFrame::Section } else { LoadFrame::Root };
        body.stations_m = if body.elements == 0 { vec![0.0] } else { vec![0.0, 0.2, 0.7] };
    }
    for (index, slides) in [(0, true), (2, false), (3, true), (4, false), (5, true)] {
        let axis = random.direction();
        bodies[index].joint = if slides { JointKind::Prismatic { axis } } else { JointKind::Revolute { axis } };
    }
    let mut cloud = |n: usize| -> Cloud {
        (0..n).map(|_| (0.2 + 0.1 * random.symmetric(), random.vector() * 0.2 + Vector3::x() * 0.1)).collect()
    };
    let clouds = vec![(0, 0.0, cloud(6)), (3, 0.0, cloud(5)), (4, 0.0, cloud(4)), (1, 0.7, cloud(2))];
    Case::new(bodies, clouds)
}

/// Clamped body at the origin without elements; its mass is given as a cloud.
fn random_rigid_body(random: &mut Random) -> BodyDescription {
    BodyDescription { length_m: 0.0, elements: 0, ..random_body(random, 1.0, ElementKind::Constant, 1) }
}

/// All inputs of the equations of motion, at random.
pub struct State {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Rates.
    pub v: Vec<f64>,
    /// Accelerations.
    pub a: Vec<f64>,
    /// Root motion with gravity.
    pub root: RootMotion,
    /// Damping of each body.
    pub damping: Vec<Damping>,
    /// Loads of each station.
    pub loads: Vec<Wrench>,
    /// Hinge terms of each body's joint.
    pub hinges: Vec<FreedomTangent>,
}

impl State {
    /// Strains that rotate each link by up to `link_angle_rad`, rates and accelerations of order one.
    pub fn random(case: &Case, seed: u64, link_angle_rad: f64) -> Self {
        let mut random = Random::new(seed);
        let n = case.model.coordinates;
        let mut q: Vec<f64> = (0..n).map(|_| 3.0 * random.symmetric()).collect();
        for element in &case.model.elements {
            let turn = random.direction() * (link_angle_rad * (0.75 + 0.25 * random.symmetric()) / element.length_m);
            let stretch = 0.1 * random.symmetric() * link_angle_rad.min(1.0);
            let strains = [stretch, turn.x, turn.y, turn.z, -1.5 * stretch, 0.7 * stretch];
            q[element.range()].copy_from_slice(&strains[..element.range().len()]);
        }
        let bodies = case.model.bodies.len();
        Self {
            q,
            v: (0..n).map(|_| random.symmetric()).collect(),
            a: (0..n).map(|_| 2.0 * random.symmetric()).collect(),
            root: RootMotion {
                gravity_m_s2: random.vector() * 9.8,
                acceleration_m_s2: random.vector() * 4.0,
                angular_velocity_rad_s: random.vector() * 2.0,
                angular_acceleration_rad_s2: random.vector() * 3.0,
            },
            damping: (0..bodies)
                .map(|_| Damping {
                    mass_1_s: 2.0 + random.symmetric(),
                    stiffness_s: 0.02 * (1.5 + random.symmetric()),
                    ..Damping::default()
                })
                .collect(),
            loads: case
                .model
                .stations
                .iter()
                .map(|_| Wrench { force_n: random.vector() * 5.0, moment_n_m: random.vector() * 2.0 })
                .collect(),
            hinges: (0..bodies)
                .map(|_| FreedomTangent { free: true, stiffness: 2.0 + random.symmetric(), damping: 0.1 })
                .collect(),
        }
    }
}

use ElementKind::{Constant, Linear};

/// A named tree and the largest angle of its links in rad.
pub struct Named {
    /// Name for messages.
    pub name: &'static str,
    /// The tree.
    pub case: Case,
    /// Angle of a link in rad.
    pub link_angle_rad: f64,
}

/// All trees of the random-state checks.
pub fn all_trees(seed: u64) -> Vec<Named> {
    let single = |kind, elements| {
        let mut random = Random::new(seed + 100);
        let mut body = random_body(&mut random, 1.2, kind, elements);
        body.stations_m = vec![0.31, 1.2];
        Case::new(vec![body], Vec::new())
    };
    let stiff = |factor: f64| {
        let mut random = Random::new(seed + 200);
        let mut bodies = two_bodies(seed, [Constant, Linear], 4).descriptions;
        for body in &mut bodies {
            let stiffness = Matrix4::from_diagonal(&nalgebra::Vector4::new(factor, 1.0, 1.5, 2.0))
                * (1.0 + 0.1 * random.symmetric());
            body.section = Section { stiffness, ..body.section.at(0.0) }.into();
        }
        Case::new(bodies, Vec::new())
    };
    let named = |name, case, link_angle_rad| Named { name, case, link_angle_rad };
    vec![
        named("single constant", single(Constant, 5), 0.3),
        named("single pairs", single(Linear, 3), 0.3),
        named("constant 4+4", two_bodies(seed, [Constant; 2], 4), 0.4),
        named("pairs 2+2", two_bodies(seed, [Linear; 2], 2), 0.4),
        named("constant and pairs", two_bodies(seed, [Constant, Linear], 3), 0.6),
        named("pairs and constant", two_bodies(seed, [Linear, Constant], 3), 0.6),
        named("constant 15+15", two_bodies(seed, [Constant; 2], 15), 0.1),
        named("pairs 8+8", two_bodies(seed, [Linear; 2], 8), 0.1),
        named("branching constant", branching_tree(seed, [Constant; 4]), 0.5),
        named("branching mixed", branching_tree(seed, [Linear, Constant, Linear, Linear]), 0.5),
        named("links of 0.05 rad", branching_tree(seed, [Linear, Linear, Constant, Constant]), 0.05),
        named("links of 1.4 rad", two_bodies(seed, [Constant, Linear], 3), 1.4),
        named("links of 1.7 rad", two_bodies(seed, [Constant, Linear], 3), 1.7),
        named("links of 3 rad", two_bodies(seed, [Constant, Linear], 3), 3.0),
        named("links of 1e-7 rad", two_bodies(seed, [Linear, Constant], 3), 1e-7),
        named("levers constant", levers(seed, [Constant; 3]), 0.4),
        named("levers mixed", levers(seed, [Linear, Constant, Linear]), 0.4),
        named("shear, constant", with_shear(seed, &single(Constant, 5), 1), 0.3),
        named("shear, pairs", with_shear(seed, &single(Linear, 3), 1), 0.3),
        named("shear beside none", with_shear(seed, &two_bodies(seed, [Constant, Linear], 3), 2), 0.6),
        named("none beside shear", with_shear(seed, &branching_tree(seed, [Linear, Constant, Linear, Linear]), 2), 0.5),
        named("shear, branching", with_shear(seed, &branching_tree(seed, [Linear, Constant, Linear, Linear]), 1), 0.5),
        named("shear, levers", with_shear(seed, &levers(seed, [Linear, Constant, Linear]), 1), 0.4),
        named("shear, links of 1.7 rad", with_shear(seed, &two_bodies(seed, [Linear, Constant], 3), 1), 1.7),
        named("shear, links of 1e-7 rad", with_shear(seed, &two_bodies(seed, [Linear, Constant], 3), 1), 1e-7),
        named("EA x 1e4", stiff(1e4), 0.4),
        named("EA x 1e12", stiff(1e12), 0.4),
    ]
}
