//! Random machines of the tests of derivatives.

use super::*;
use crate::beam::element::{ElementKind, rigid_body_mass};
use crate::beam::law::SectionLaw;
use crate::beam::modal::{ModalLaw, Shape};
use crate::beam::profile::Profile;
use crate::beam::section::{Material, Solid};
use crate::load::{LoadFrame, RootMotion, Wrench};
use crate::multibody::closure::{ClosureDescription, Penalty};
use crate::multibody::dynamics::residual;
use crate::multibody::model::{Attachment, BodyDescription};
use crate::multibody::no_slip::{NoSlipDescription, Runner};

/// Parts of a random machine besides beams and joints with one degree of freedom.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Extra {
    None,
    /// A universal, ball or free joint at the root and a universal or ball joint further out.
    Spatial,
    /// Three bodies with shear.
    Shear,
    /// Geared motors whose rotors turn with their carrier.
    Rotors,
    /// Two modal bodies.
    Modal,
    /// Rigid loops, a skate and a wheel.
    Constraints,
}

impl Extra {
    pub(super) fn of(seed: u64) -> Self {
        [Self::None, Self::Spatial, Self::Shear, Self::Rotors, Self::Modal, Self::Constraints][(seed / 20) as usize]
    }
}

/// A random machine in motion.
pub(super) struct Case {
    pub(super) model: Model,
    pub(super) damping: Vec<Damping>,
    pub(super) loads: Vec<Wrench>,
    pub(super) root: RootMotion,
    pub(super) motion: [Vec<f64>; 3],
    pub(super) random: fastrand::Rng,
}

pub(super) fn symmetric(random: &mut fastrand::Rng, size: f64) -> f64 {
    size * (2.0 * random.f64() - 1.0)
}

pub(super) fn vector(random: &mut fastrand::Rng, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| symmetric(random, size))
}

/// A modal body of 0.8 m with some flapwise shapes and one edgewise shape, whose ratios of damping differ.
fn shapes(random: &mut fastrand::Rng, flap: usize) -> ModalLaw {
    let shape = |index: usize, random: &mut fastrand::Rng| {
        let first = symmetric(random, 1.0);
        let coefficients = vec![first, 0.4 * index as f64, 1.0 - first - 0.4 * index as f64];
        Shape { coefficients, damping_ratio: 0.02 * (1.0 + index as f64), start_m: 0.0 }
    };
    ModalLaw {
        length_m: 0.8,
        cells: 6,
        mass_kg_m: Profile::Polynomial(vec![0.8, -0.3]),
        flap_stiffness_n_m2: Profile::Polynomial(vec![2.0]),
        edge_stiffness_n_m2: Profile::Polynomial(vec![5.0]),
        twist_rad: random.bool().then(|| Profile::Polynomial(vec![0.4, -0.2])),
        flap: (0..flap).map(|index| shape(index, random)).collect(),
        edge: vec![shape(1, random)],
        axial_shortening: true,
        section_rotation: true,
        rates_of_angles: false,
        mass_factor: 1.0,
        stiffness_factor: 1.0,
    }
}

impl Case {
    /// Four or five bodies with joints of all supported types, rigid and flexible, branches, a loop, offsets, masses, loads in both frames,
    /// a rotating root.
    pub(super) fn new(seed: u64) -> Self {
        Self::with(seed, Extra::None)
    }

    /// The same with other parts.
    pub(super) fn with(seed: u64, extra: Extra) -> Self {
        let spatial = extra == Extra::Spatial;
        let mut random = fastrand::Rng::with_seed(seed);
        let bodies: Vec<BodyDescription> = (0..5)
            .map(|index: usize| {
                let random = &mut random;
                let rigid = index == 2;
                let axis = vector(random, 1.0).normalize();
                let joint = match random.u32(0..5) {
                    0 => JointKind::Clamped,
                    1 => JointKind::Prismatic { axis },
                    _ => JointKind::Revolute { axis },
                };
                let universal = JointKind::universal(axis, Vector3::new(axis.y, -axis.x, 0.3).normalize());
                let joint = match (spatial, index, seed % 3) {
                    (true, 0, 0) => JointKind::Free,
                    (true, 0, 1) | (true, 3, 2) => JointKind::Ball,
                    (true, 0 | 3, _) => universal,
                    (_, _, _) => joint,
                };
                let solid = Solid::rectangle(0.05, 0.012, Material::isotropic(1e8, 0.3, 1000.0));
                let position_m = [0.0, 0.4, 0.8][random.usize(0..3)];
                let parent = match index {
                    0 => Attachment::Root(vector(random, 0.3)),
                    _ => {
                        let parent = random.usize(0..index);
                        Attachment::Body { index: parent, position_m: if parent == 2 { 0.0 } else { position_m } }
                    }
                };
                let sheared = extra == Extra::Shear && [0, 1, 4].contains(&index);
                let modal = extra == Extra::Modal && [1, 4].contains(&index);
                let section = match (modal, sheared) {
                    (true, _) => SectionLaw::Modal(Box::new(shapes(random, if index == 1 { 2 } else { 4 }))),
                    (false, true) => solid.with_shear().section().into(),
                    (false, false) => solid.section().into(),
                };
                let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.04));
                let turn = nalgebra::Rotation3::new(vector(random, 1.5));
                BodyDescription {
                    length_m: if rigid { 0.0 } else { 0.8 },
                    section,
                    kind: if random.bool() { ElementKind::Linear } else { ElementKind::Constant },
                    elements: if rigid || modal { 0 } else { 2 },
                    natural_strain: [0.0, symmetric(random, 0.5), symmetric(random, 0.5), 0.1].into(),
                    offset_m: if index == 0 { Vector3::zeros() } else { vector(random, 0.2) },
                    parent,
                    mount: turn.into_inner(),
                    joint,
                    masses: vec![(
                        if rigid { 0.0 } else { position_m },
                        rigid_body_mass(0.7, &vector(random, 0.1), &inertia),
                    )],
                    stations_m: if rigid { vec![0.0] } else { vec![0.0, 0.13, 0.4, 0.61, 0.8] },
                    load_frame: if random.bool() { LoadFrame::Section } else { LoadFrame::Root },
                }
            })
            .collect();
        let closure = ClosureDescription {
            places: [Some((0, 0.8)), Some((4, 0.8))],
            offsets_m: [vector(&mut random, 0.1), vector(&mut random, 0.1)],
            rigid: extra == Extra::Constraints,
            penalty: Penalty { inertia_kg: 0.3, damping_n_s_m: 2.0, stiffness_n_m: 50.0 },
        };
        let on_root = ClosureDescription {
            places: [None, Some((4, 0.8))],
            offsets_m: closure.offsets_m.map(|m| m * 3.0),
            ..closure.clone()
        };
        let mut no_slips = Vec::new();
        if extra == Extra::Constraints {
            let mut direction = || vector(&mut random, 1.0).normalize();
            let skate = NoSlipDescription {
                place: (4, 0.4),
                offset_m: direction() * 0.1,
                runner: Runner::Skate { direction: direction() },
                normal: direction(),
                distance_m: 0.3,
                holds_normal: seed.is_multiple_of(2),
            };
            let runner = Runner::Wheel { axis: direction(), radius_m: 0.2, rolling: !seed.is_multiple_of(3) };
            let wheel = NoSlipDescription { place: (0, 0.8), runner, normal: direction(), holds_normal: true, ..skate };
            no_slips.extend([skate, wheel]);
        }
        let mut model = Model::with_constraints(&bodies, &[closure, on_root], &no_slips);
        model.bodies[1].damps_attached = true;
        model.bodies[3].damping_roots = Some([0.5, 1.0, 1.2, 0.9, 1.0, 1.0].into());
        let hinged = |own: &&mut Body| extra == Extra::Rotors && matches!(own.joint.kind, JointKind::Revolute { .. });
        for body in model.bodies.iter_mut().filter(hinged) {
            (body.joint.drive_inertia, body.joint.drive_carried) = (0.2, 0.7);
        }
        let n = model.coordinates;
        let mut motion: [Vec<f64>; 3] =
            [0.6, 1.5, 4.0].map(|size| (0..n).map(|_| symmetric(&mut random, size)).collect());
        let [q, v, a] = &mut motion;
        for body in &model.bodies {
            // Euler parameters of any length; direction cosines are those of an attitude
            if body.joint.kind.constraints() > 1 {
                let turn = q[body.joint.range()].to_vec();
                body.joint.rest(&body.mount, q);
                q[body.joint.range()].iter_mut().zip(turn).for_each(|(q, turn)| *q += 0.2 * turn);
                body.joint.restore(q, v, a);
            }
        }
        let damping_of = |body: &Body| {
            let mass_1_s = 2.0 * random.f64();
            // modal bodies have no mass-proportional damping
            let mass_1_s = if body.modal.is_some() { 0.0 } else { mass_1_s };
            Damping { mass_1_s, stiffness_s: 0.01 * random.f64(), ..Damping::default() }
        };
        let damping = model.bodies.iter().map(damping_of).collect();
        let mut wrench = || Wrench { force_n: vector(&mut random, 2.0), moment_n_m: vector(&mut random, 0.5) };
        let loads = model.stations.iter().map(|_| wrench()).collect();
        let root = RootMotion {
            gravity_m_s2: vector(&mut random, 10.0),
            acceleration_m_s2: vector(&mut random, 3.0),
            angular_velocity_rad_s: vector(&mut random, 2.0),
            angular_acceleration_rad_s2: vector(&mut random, 2.0),
        };
        Self { model, damping, loads, root, motion, random }
    }

    pub(super) fn environment(&self) -> Environment<'_> {
        Environment { root: &self.root, damping: &self.damping, stations: &self.loads }
    }

    pub(super) fn random(&mut self, size: f64) -> Vec<f64> {
        (0..self.model.coordinates).map(|_| symmetric(&mut self.random, size)).collect()
    }

    pub(super) fn residual_at(&self, work: &mut Workspace, direction: &[Vec<f64>; 3], step: f64) -> Vec<f64> {
        let [q, v, a]: [Vec<f64>; 3] = std::array::from_fn(|kind| {
            self.motion[kind].iter().zip(&direction[kind]).map(|(x, d)| x + step * d).collect()
        });
        let mut found = vec![0.0; q.len()];
        residual(&self.model, work, Motion { q: &q, v: &v, a: &a }, self.environment(), &mut found);
        // without the inertia of each joint's own rotor, which the recursion does not have
        for joint in self.model.bodies.iter().map(|body| &body.joint).filter(|joint| joint.drive_inertia != 0.0) {
            found[joint.coordinate] -= joint.drive_inertia * a[joint.coordinate];
        }
        found
    }

    /// `K δq + C δv + M δa` of tree and strains.
    pub(super) fn forward(&self, direction: &[Vec<f64>; 3]) -> Vec<f64> {
        let mut sum = vec![0.0; self.model.coordinates];
        let [motion, along] = [&self.motion, direction].map(|[q, v, a]| Motion { q, v, a });
        self.prepared(motion).forward(&self.model, along, &mut sum);
        elastic_products::<false>(&self.model, &self.damping, along.q, along.v, |row, force, viscous| {
            sum[row] += force + viscous
        });
        sum
    }

    pub(super) fn prepared(&self, motion: Motion) -> Derivative {
        let (mut work, mut unused) = (Workspace::new(&self.model), vec![0.0; self.model.coordinates]);
        residual(&self.model, &mut work, motion, self.environment(), &mut unused);
        let mut derivative = Derivative::new(&self.model);
        derivative.prepare(&self.model, &work, motion, &self.environment());
        derivative
    }

    pub(super) fn reverse(&self, w: &[f64]) -> [Vec<f64>; 3] {
        let mut sums = [(); 3].map(|()| vec![0.0; w.len()]);
        let [by_q, by_v, by_a] = &mut sums;
        let motion = Motion { q: &self.motion[0], v: &self.motion[1], a: &self.motion[2] };
        self.prepared(motion).reverse(&self.model, w, [by_q, by_v, by_a]);
        elastic_products::<true>(&self.model, &self.damping, w, w, |row, force, viscous| {
            sums[0][row] += force;
            sums[1][row] += viscous;
        });
        sums
    }
}
