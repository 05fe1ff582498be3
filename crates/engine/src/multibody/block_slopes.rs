//! Derivatives of mass and stiffness blocks and of damping with respect to a parameter, eq. (X9).
//!
//! The residual is linear in the blocks of the mesh, the inertias of drives and the penalties of loops. A model that has their derivatives
//! in place of them therefore has the derivative of the residual as its residual.

use crate::load::RootMotion;
use crate::math::wide::{Fours, Quad, WithFours, with_fours};
use crate::multibody::closure::Penalty;
use crate::multibody::derivative::Derivative;
use crate::multibody::dynamics::{self, Damping, Environment};
use crate::multibody::elastic::elastic_forces;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Body, Elastic, Element, NodeMass};
use crate::multibody::nodal::{multiply, wrench_of};
use crate::multibody::node::Node;
use crate::multibody::{Model, Workspace};
use nalgebra::{Matrix4, Vector3};

/// A mesh whose blocks are derivatives.
pub(crate) struct BlockSlopes {
    model: Model,
    /// Whether a stiffness differs.
    stiffens: bool,
    /// Per body.
    weighs: Vec<Weighs>,
    sweep: Sweep,
}

/// Rows of a residual by forces on the nodes.
enum Sweep {
    /// By an inward sweep alone.
    Inward(Inward),
    /// By the whole residual, for machines with closed loops, shear, damping relative to a carrier, or rotors that turn with one.
    Whole(Box<Workspace>),
}

/// Workspace of an inward sweep.
struct Inward {
    /// Vectors of each node that masses of beams multiply.
    vectors: Vec<[Quad; 4]>,
    /// Wrench on each node.
    wrenches: Vec<[Vector3<f64>; 2]>,
}

impl Sweep {
    fn of(model: &Model) -> Self {
        let carried = |body: &Body| body.carrier.is_some() || body.joint.drive_carried != 0.0;
        if model.sheared || !model.closures.is_empty() || model.bodies.iter().any(carried) {
            return Self::Whole(Box::new(Workspace::new(model)));
        }
        let nodes = model.nodes.len();
        Self::Inward(Inward { vectors: vec![[[0.0; 4]; 4]; nodes], wrenches: vec![[Vector3::zeros(); 2]; nodes] })
    }
}

impl Inward {
    /// Adds the wrenches on the nodes of a body by the masses of its beam times vectors of the nodes.
    fn add_beam(&mut self, (model, body): (&Model, &Body), nodes: &[Node], of: impl Fn(&Node) -> [Vector3<f64>; 4]) {
        let range = body.first_node..=body.last_node();
        self.vectors[range.clone()].iter_mut().zip(&nodes[range]).for_each(|(own, node)| *own = padded(&of(node)));
        let Self { vectors, wrenches } = self;
        with_fours(BeamForces { mesh: (model, body), nodes, vectors, wrenches });
    }
}

/// Adds the wrenches on the nodes of a body by the masses of its beam times the vectors of the nodes.
struct BeamForces<'a> {
    mesh: (&'a Model, &'a Body),
    nodes: &'a [Node],
    vectors: &'a [[Quad; 4]],
    wrenches: &'a mut [[Vector3<f64>; 2]],
}

impl WithFours for BeamForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Fours>(self, fours: V) {
        match self.mesh.1.slim_mass {
            true => self.add::<true, V>(fours),
            false => self.add::<false, V>(fours),
        }
    }
}

impl BeamForces<'_> {
    #[inline(always)]
    fn add<const SLIM: bool, V: Fours>(self, fours: V) {
        let Self { mesh: (model, body), nodes, vectors, wrenches } = self;
        let elements = &model.elements[body.first_element..body.first_element + body.elements];
        for n in body.first_node..=body.last_node() {
            let i = n - body.first_node;
            let mut forces = [[0.0; 4]; 4];
            add_mass::<SLIM, V>(fours, &mut forces, &model.nodes[n].beam.data.0, &vectors[n], false);
            if i > 0 {
                add_mass::<SLIM, V>(fours, &mut forces, &elements[i - 1].cross_mass.data.0, &vectors[n - 1], false);
            }
            if let Some(element) = elements.get(i) {
                add_mass::<SLIM, V>(fours, &mut forces, &element.cross_mass.data.0, &vectors[n + 1], true);
            }
            let forces = forces.map(|[x, y, z, _]| Vector3::new(x, y, z));
            add_wrench(&nodes[n], &forces, &mut wrenches[n]);
        }
    }
}

/// Adds the products of a mass block, given by columns, or of its transpose with vectors; `SLIM`: the block couples only `r` and `r_x`.
#[inline(always)]
fn add_mass<const SLIM: bool, V: Fours>(
    fours: V,
    forces: &mut [Quad; 4],
    columns: &[[f64; 4]; 4],
    vectors: &[Quad; 4],
    transposed: bool,
) {
    for i in 0..4 {
        for j in 0..4 {
            if !SLIM || i == j || (i < 2 && j < 2) {
                let mass = if transposed { columns[i][j] } else { columns[j][i] };
                fours.add(&mut forces[i], mass, &vectors[j]);
            }
        }
    }
}

/// Vectors filled up with zeros.
#[inline(always)]
fn padded(vectors: &[Vector3<f64>; 4]) -> [Quad; 4] {
    vectors.map(|vector| [vector.x, vector.y, vector.z, 0.0])
}

/// Adds the wrenches on the nodes of a body by its attached masses times vectors of the nodes.
fn add_attached(
    (model, body): (&Model, &Body),
    nodes: &[Node],
    vectors: impl Fn(&Node) -> [Vector3<f64>; 4],
    wrenches: &mut [[Vector3<f64>; 2]],
) {
    for n in body.first_node..=body.last_node() {
        if let Some(attached) = &model.nodes[n].attached {
            add_wrench(&nodes[n], &multiply(attached, &vectors(&nodes[n])), &mut wrenches[n]);
        }
    }
}

#[inline(always)]
fn add_wrench(node: &Node, forces: &[Vector3<f64>; 4], wrench: &mut [Vector3<f64>; 2]) {
    let (force, moment) = wrench_of(&node.rotation, forces);
    wrench[0] += force;
    wrench[1] += moment;
}

/// Rates of the nodal vectors.
fn rates(node: &Node) -> [Vector3<f64>; 4] {
    let axis = |k: usize| node.spin.cross(&node.rotation.column(k).into_owned());
    [node.velocity, axis(0), axis(1), axis(2)]
}

/// Masses that differ in a body.
#[derive(Clone, Copy)]
struct Weighs {
    beam: bool,
    attached: bool,
}

impl Weighs {
    fn of(model: &Model, body: &Body) -> Self {
        let elements = &model.elements[body.first_element..body.first_element + body.elements];
        let nodes = &model.nodes[body.first_node..=body.last_node()];
        let has = |mass: &Matrix4<f64>| mass.iter().any(|entry| *entry != 0.0);
        Self {
            beam: elements.iter().any(|element| has(&element.cross_mass)) || nodes.iter().any(|node| has(&node.beam)),
            attached: nodes.iter().any(|node| node.attached.as_ref().is_some_and(has)),
        }
    }
}

impl BlockSlopes {
    /// Combines the blocks of several machines with the weights of a difference quotient. `None` if the models differ from `own` in more
    /// than blocks, for example in lengths, or have elements with shear.
    pub fn new<'a>(own: &Model, others: impl Iterator<Item = (f64, &'a Model)>) -> Option<Self> {
        if own.sheared {
            return None;
        }
        let mut model = own.clone();
        clear(&mut model);
        let empty = model.clone();
        for (weight, other) in others {
            let mut same = other.clone();
            clear(&mut same);
            for ((sum, same), own) in model.bodies.iter_mut().zip(&mut same.bodies).zip(&own.bodies) {
                sum.slim_mass &= same.slim_mass;
                same.slim_mass = own.slim_mass;
            }
            if same != empty {
                return None;
            }
            add(&mut model, weight, other);
        }
        let stiffens = model.elements.iter_mut().any(|element| {
            let [stiffness, coupling, ..] = element_blocks(element);
            stiffness.iter().chain(&*coupling).any(|entry| *entry != 0.0)
        });
        let weighs = model.bodies.iter().map(|body| Weighs::of(&model, body)).collect();
        let sweep = Sweep::of(own);
        Some(Self { model, stiffens, weighs, sweep })
    }

    /// Derivative of the residual of tree and loops at a point whose residual is in `swept` and which `derivative` has linearised, in the
    /// gravity field and with the damping of `environment`; loads do not contribute.
    pub fn residual(
        &mut self,
        (swept, derivative): (&Workspace, &Derivative),
        (root, damping): (&RootMotion, &[Damping]),
        motion: Motion,
        out: &mut [f64],
    ) {
        let Self { model, stiffens, weighs, sweep } = self;
        match sweep {
            Sweep::Whole(work) => {
                let environment = Environment { root, damping, stations: &[] };
                work.take_sweep(swept);
                dynamics::residual_of_swept(model, work, motion, environment, out);
            }
            Sweep::Inward(inward) => {
                if *stiffens {
                    elastic_forces(model, swept, motion, damping, out);
                } else {
                    out.fill(0.0);
                    for (body, joint) in model.bodies.iter().zip(&swept.joints) {
                        body.joint.own_forces(joint, motion, out);
                    }
                }
                let differs = |weighs: &Weighs| weighs.beam || weighs.attached;
                if weighs.iter().any(differs) {
                    inward.wrenches.fill([Vector3::zeros(); 2]);
                    for ((body, damping), weighs) in model.bodies.iter().zip(damping).zip(&*weighs) {
                        let (mesh, nodes) = ((&*model, body), &swept.nodes);
                        if weighs.beam {
                            inward.add_beam(mesh, nodes, |node| node.load_rate);
                        }
                        if weighs.attached {
                            let alpha_1_s = if body.damps_attached { 0.0 } else { damping.mass_1_s };
                            let undamped = |node: &Node| {
                                let rates = rates(node);
                                std::array::from_fn(|k| node.load_rate[k] - rates[k] * alpha_1_s)
                            };
                            add_attached(mesh, nodes, undamped, &mut inward.wrenches);
                        }
                    }
                    derivative.project(&mut inward.wrenches, out);
                }
            }
        }
        // constraints of joints have no blocks
        for joint in self.model.bodies.iter().map(|body| &body.joint).filter(|joint| joint.kind.is_redundant()) {
            out[joint.range()][joint.kind.freedoms()..].fill(0.0);
        }
    }
}

/// Size of the change of the damping in a difference of residuals: that of a mass-proportional one in 1/s, a thousandth of it in s for a
/// stiffness-proportional one, and a millionth in s² for inertias of the strains. The residual is affine in them, so that any size is exact, and the
/// larger, the smaller the round-off.
const DAMPING_CHANGE: f64 = 1e3;

/// Derivative of the residual with respect to a parameter of the damping of the bodies.
pub(crate) struct DampingSlope {
    own: Vec<Damping>,
    /// The damping of the bodies, changed along the derivative.
    changed: Vec<Damping>,
    /// Change of the parameter that corresponds to this damping, to first order.
    change: f64,
    /// The derivative by the damping of the bodies.
    slopes: Vec<Damping>,
    sweep: Sweep,
    scratch: Vec<f64>,
}

impl DampingSlope {
    /// Combines the damping of several machines with the weights of a difference quotient; `None` if all have the same.
    pub fn new<'a>(
        model: &Model,
        own: &[Damping],
        others: impl Iterator<Item = (f64, &'a [Damping])> + Clone,
    ) -> Option<Self> {
        if others.clone().all(|(_, other)| other == own) {
            return None;
        }
        let mut slopes = vec![Damping::default(); own.len()];
        for (weight, other) in others {
            for (sum, other) in slopes.iter_mut().zip(other) {
                sum.mass_1_s += weight * other.mass_1_s;
                sum.stiffness_s += weight * other.stiffness_s;
                sum.strain_inertia_s2 += weight * other.strain_inertia_s2;
            }
        }
        let size = |slope: &Damping| {
            let (of_stiffness, of_inertia) = (1e3 * slope.stiffness_s, 1e6 * slope.strain_inertia_s2);
            slope.mass_1_s.abs().max(of_stiffness.abs()).max(of_inertia.abs())
        };
        let change = DAMPING_CHANGE / slopes.iter().map(size).fold(f64::MIN_POSITIVE, f64::max);
        let along = |(own, slope): (&Damping, &Damping)| Damping {
            mass_1_s: own.mass_1_s + change * slope.mass_1_s,
            stiffness_s: own.stiffness_s + change * slope.stiffness_s,
            strain_inertia_s2: own.strain_inertia_s2 + change * slope.strain_inertia_s2,
        };
        let changed = own.iter().zip(&slopes).map(along).collect();
        let scratch = vec![0.0; model.coordinates];
        Some(Self { own: own.to_vec(), changed, change, slopes, sweep: Sweep::of(model), scratch })
    }

    /// Adds the derivative at a point whose residual is in `swept` and which `derivative` has linearised to `sum`.
    pub fn add_residual(
        &mut self,
        (model, swept, derivative): (&Model, &Workspace, &Derivative),
        root: &RootMotion,
        motion: Motion,
        sum: &mut [f64],
    ) {
        let Self { own, changed, change, slopes, sweep, scratch } = self;
        let of_strains = slopes.iter().any(|slope| slope.stiffness_s != 0.0 || slope.strain_inertia_s2 != 0.0);
        for (damping, sign) in [(&*changed, 1.0), (&*own, -1.0)] {
            match sweep {
                Sweep::Whole(work) => {
                    let environment = Environment { root, damping, stations: &[] };
                    work.take_sweep(swept);
                    dynamics::residual_of_swept(model, work, motion, environment, scratch);
                }
                Sweep::Inward(_) if of_strains => elastic_forces(model, swept, motion, damping, scratch),
                Sweep::Inward(_) => continue,
            }
            sum.iter_mut().zip(&*scratch).for_each(|(sum, value)| *sum += sign / *change * value);
        }
        let Sweep::Inward(inward) = sweep else { return };
        let damped = |slope: &Damping| slope.mass_1_s != 0.0;
        if !slopes.iter().any(damped) {
            return;
        }
        inward.wrenches.fill([Vector3::zeros(); 2]);
        for (body, slope) in model.bodies.iter().zip(&*slopes).filter(|(_, slope)| damped(slope)) {
            let rates = |node: &Node| rates(node).map(|rate| rate * slope.mass_1_s);
            inward.add_beam((model, body), &swept.nodes, rates);
            if body.damps_attached {
                add_attached((model, body), &swept.nodes, rates, &mut inward.wrenches);
            }
        }
        derivative.project(&mut inward.wrenches, sum);
    }
}

/// Blocks of an element in a fixed order.
fn element_blocks(element: &mut Element) -> [&mut [f64]; 6] {
    let Element { elastic, cross_mass, outer_mass, .. } = element;
    let Elastic { stiffness, coupling, section_stiffness: [inner, outer], .. } = elastic;
    [
        stiffness.as_mut_slice(),
        coupling.as_mut_slice(),
        inner.as_mut_slice(),
        outer.as_mut_slice(),
        cross_mass.as_mut_slice(),
        outer_mass.as_mut_slice(),
    ]
}

fn clear(model: &mut Model) {
    for element in &mut model.elements {
        element_blocks(element).into_iter().for_each(|block| block.fill(0.0));
    }
    for NodeMass { beam, attached } in &mut model.nodes {
        *beam = Matrix4::zeros();
        if let Some(attached) = attached {
            *attached = Matrix4::zeros();
        }
    }
    for body in &mut model.bodies {
        body.joint.drive_inertia = 0.0;
    }
    for closure in &mut model.closures {
        closure.penalty = Penalty { inertia_kg: 0.0, damping_n_s_m: 0.0, stiffness_n_m: 0.0 };
    }
}

fn add(sum: &mut Model, weight: f64, other: &Model) {
    let mut other = other.clone();
    for (sum, other) in sum.elements.iter_mut().zip(&mut other.elements) {
        for (sum, other) in element_blocks(sum).into_iter().zip(element_blocks(other)) {
            sum.iter_mut().zip(&*other).for_each(|(sum, other)| *sum += weight * other);
        }
    }
    for (sum, other) in sum.nodes.iter_mut().zip(&other.nodes) {
        sum.beam += other.beam * weight;
        if let (Some(sum), Some(other)) = (&mut sum.attached, &other.attached) {
            *sum += other * weight;
        }
    }
    for (sum, other) in sum.bodies.iter_mut().zip(&other.bodies) {
        sum.joint.drive_inertia += weight * other.joint.drive_inertia;
    }
    for (sum, other) in sum.closures.iter_mut().zip(&other.closures) {
        let (sum, other) = (&mut sum.penalty, &other.penalty);
        sum.inertia_kg += weight * other.inertia_kg;
        sum.damping_n_s_m += weight * other.damping_n_s_m;
        sum.stiffness_n_m += weight * other.stiffness_n_m;
    }
}
