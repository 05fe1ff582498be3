//! Derivatives of mass and stiffness blocks and of damping with respect to a parameter, eq. (X9).
//!
//! The residual is linear in the blocks of the mesh, the inertias of drives and the penalties of loops. A model that has their derivatives
//! in place of them therefore has the derivative of the residual as its residual.

use crate::load::RootMotion;
use crate::multibody::closure::Penalty;
use crate::multibody::dynamics::{self, Damping, Environment};
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Elastic, Element, NodeMass};
use crate::multibody::{Model, Workspace};
use nalgebra::Matrix4;

/// A mesh whose blocks are derivatives.
pub(crate) struct BlockSlopes {
    model: Model,
    work: Workspace,
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
        let work = Workspace::new(&model);
        Some(Self { model, work })
    }

    /// Derivative of the residual of tree and loops at a point whose outward sweep is in `swept`, in the gravity field and with the damping
    /// of `environment`; loads do not contribute.
    pub fn residual(
        &mut self,
        swept: &Workspace,
        (root, damping): (&RootMotion, &[Damping]),
        motion: Motion,
        out: &mut [f64],
    ) {
        let environment = Environment { root, damping, stations: &[] };
        self.work.take_sweep(swept);
        dynamics::residual_of_swept(&self.model, &mut self.work, motion, environment, out);
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
    work: Workspace,
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
        Some(Self { own: own.to_vec(), changed, change, work: Workspace::new(model), scratch })
    }

    /// Adds the derivative at a point whose outward sweep is in `swept` to `sum`.
    pub fn add_residual(
        &mut self,
        (model, swept): (&Model, &Workspace),
        root: &RootMotion,
        motion: Motion,
        sum: &mut [f64],
    ) {
        for (damping, sign) in [(&self.changed, 1.0), (&self.own, -1.0)] {
            let environment = Environment { root, damping, stations: &[] };
            self.work.take_sweep(swept);
            dynamics::residual_of_swept(model, &mut self.work, motion, environment, &mut self.scratch);
            sum.iter_mut().zip(&self.scratch).for_each(|(sum, value)| *sum += sign / self.change * value);
        }
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
