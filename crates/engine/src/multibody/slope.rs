//! Inertia of elements with shear: the slope of their axis at an end is `d = R (e_x + ε)` instead of `r_x`.
//!
//! The mass (D1) is constant over the nodal vectors `(r, d, r_y, r_z)` of both ends, each with the strain of the element itself. Lumped
//! masses therefore belong to elements instead of nodes, inertia forces act on the linear strains, and these are coupled with the twists of
//! both ends, NOTATION eqs. (D18)–(D20).

use crate::load::RootMotion;
use crate::math::strain::{LINEAR, STRETCH};
use crate::multibody::model::{Body, Element, Model};
use crate::multibody::motion::Motion;
use crate::multibody::nodal::{lump, product, transposed_product, wrench_of};
use crate::multibody::node::{ArticulatedInertia, Node};
use crate::multibody::slope_vector::Slope;
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix3, Matrix4, Vector3};
use std::array::from_fn;

/// Computes the slopes of all elements with shear, and with `RATES` their rates; poses of the nodes must be current.
pub(super) fn sweep<const RATES: bool>(model: &Model, work: &mut Workspace, motion: Motion) {
    for body in model.bodies.iter().filter(|body| body.sheared) {
        for i in 0..body.elements {
            let e = body.first_element + i;
            let own =
                |coordinates: &[f64]| Vector3::from(LINEAR.map(|k| coordinates[model.elements[e].coordinate + k]));
            let mut local = own(motion.q);
            local[STRETCH] += 1.0;
            let nodes = &work.nodes[body.first_node + i..body.first_node + i + 2];
            for (slope, node) in work.slopes[e].iter_mut().zip(nodes) {
                (slope.local, slope.vector) = (local, node.rotation * local);
                if RATES {
                    slope.strained = node.rotation * own(motion.v);
                    slope.pulled = node.rotation * own(motion.a);
                }
            }
        }
    }
}

/// Computes the rates of a body's slopes that are multiplied by the mass, eq. (D18), from those of its nodes.
pub(super) fn load_rates(body: &Body, work: &mut Workspace, root: &RootMotion, alpha: f64) {
    for i in 0..body.elements {
        let nodes = &work.nodes[body.first_node + i..body.first_node + i + 2];
        for (slope, node) in work.slopes[body.first_element + i].iter_mut().zip(nodes) {
            let [_, x, y, z] = &node.load_rate;
            let turned = x * slope.local.x + y * slope.local.y + z * slope.local.z;
            let coriolis = (node.spin + root.angular_velocity_rad_s).cross(&slope.strained) * 2.0;
            slope.load_rate = turned + coriolis + slope.pulled + slope.strained * alpha;
        }
    }
}

/// Forces `m̂ ė` on the nodal vectors of an element's inner and outer ends for given rates of these vectors.
#[inline(always)]
pub(crate) fn forces<const SLIM: bool>(element: &Element, rates: &[[Vector3<f64>; 4]; 2]) -> [[Vector3<f64>; 4]; 2] {
    let [inner, outer] = rates;
    let sum = |a: [Vector3<f64>; 4], b: [Vector3<f64>; 4]| -> [Vector3<f64>; 4] { from_fn(|k| a[k] + b[k]) };
    [
        sum(product::<SLIM>(inner_mass(element), inner), transposed_product::<SLIM>(&element.cross_mass, outer)),
        sum(product::<SLIM>(&element.outer_mass, outer), product::<SLIM>(&element.cross_mass, inner)),
    ]
}

#[inline(always)]
fn inner_mass(element: &Element) -> &Matrix4<f64> {
    match &element.inner_mass {
        Some(mass) => mass,
        None => unreachable!("an element without shear"),
    }
}

/// An element with shear, and the nodes and slopes at its inner and outer end.
pub(crate) struct Ends<'a> {
    element: &'a Element,
    nodes: &'a [Node],
    slopes: &'a [Slope; 2],
}

impl Ends<'_> {
    /// A field of nodal vectors at both ends.
    pub fn field(&self, of: impl Fn(&Slope, &Node) -> [Vector3<f64>; 4]) -> [[Vector3<f64>; 4]; 2] {
        from_fn(|end| of(&self.slopes[end], &self.nodes[end]))
    }

    /// Forces `m̂ ė` for given rates.
    pub fn forces(&self, rates: &[[Vector3<f64>; 4]; 2]) -> [[Vector3<f64>; 4]; 2] {
        forces::<false>(self.element, rates)
    }

    /// Bilinear form `aᵀ m̂ b` of two fields.
    pub fn form(&self, a: &[[Vector3<f64>; 4]; 2], b: &[[Vector3<f64>; 4]; 2]) -> f64 {
        self.forces(b).as_flattened().iter().zip(a.as_flattened()).map(|(force, a)| a.dot(force)).sum()
    }
}

/// Elements of a body with shear; empty for other bodies.
pub(crate) fn ends<'a>(model: &'a Model, work: &'a Workspace, body: &'a Body) -> impl Iterator<Item = Ends<'a>> {
    let count = if body.sheared { body.elements } else { 0 };
    (0..count).map(move |i| Ends {
        element: &model.elements[body.first_element + i],
        nodes: &work.nodes[body.first_node + i..body.first_node + i + 2],
        slopes: &work.slopes[body.first_element + i],
    })
}

/// Adds the inertia forces of a body's beam to the wrenches of its nodes and, with `PROJECT`, to the residual of its linear strains,
/// eq. (D18).
pub(super) fn inertia_forces<const SLIM: bool, const PROJECT: bool>(
    model: &Model,
    body: &Body,
    work: &mut Workspace,
    residual: &mut [f64],
) {
    for i in 0..body.elements {
        let element = &model.elements[body.first_element + i];
        let nodes = &mut work.nodes[body.first_node + i..body.first_node + i + 2];
        let slopes = &work.slopes[body.first_element + i];
        let forces = forces::<SLIM>(element, &from_fn(|end| slopes[end].load_rates(&nodes[end])));
        for ((node, slope), forces) in nodes.iter_mut().zip(slopes).zip(&forces) {
            let (force, moment) = wrench_of(&slope.axes(node), forces);
            node.force += force;
            node.moment += moment;
            if PROJECT {
                let on_strains = node.rotation.tr_mul(&forces[1]);
                LINEAR.iter().zip(on_strains.iter()).for_each(|(k, force)| residual[element.coordinate + k] += force);
            }
        }
    }
}

/// Force and moment about `carrier` of the nodal forces of a body's beam for rates relative to that node, eq. (D15).
pub(super) fn damping_resultant(
    model: &Model,
    body: &Body,
    work: &Workspace,
    carrier: &Node,
) -> (Vector3<f64>, Vector3<f64>) {
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for ends in ends(model, work, body) {
        let rates = ends.field(|slope, node| slope.relative_velocities(node, Some(carrier)));
        for ((node, slope), forces) in ends.nodes.iter().zip(ends.slopes).zip(&ends.forces(&rates)) {
            let (own_force, own_moment) = wrench_of(&slope.axes(node), forces);
            force += own_force;
            moment += own_moment + (node.position - carrier.position).cross(&own_force);
        }
    }
    (force, moment)
}

/// Inertia forces at the outer end of element `i` of a body, exerted by the element on the node: force and moment.
pub(super) fn wrench_of_outer_end(
    model: &Model,
    body: &Body,
    work: &Workspace,
    i: usize,
) -> (Vector3<f64>, Vector3<f64>) {
    let element = &model.elements[body.first_element + i];
    let nodes = &work.nodes[body.first_node + i..body.first_node + i + 2];
    let slopes = &work.slopes[body.first_element + i];
    let [_, outer] = forces::<false>(element, &from_fn(|end| slopes[end].load_rates(&nodes[end])));
    wrench_of(&slopes[1].axes(&nodes[1]), &outer)
}

/// Coupling of the twist of one end with the linear strains: momentum and angular momentum per rate of each strain.
pub(super) struct Coupling {
    pub velocity: [Vector3<f64>; 3],
    pub spin: [Vector3<f64>; 3],
}

/// Inertia of an element in its linear strains and the twists of its ends, without the cross inertia (D11); eqs. (D19), (D20).
pub(super) struct SlopeInertia {
    /// `[d r_y r_z]` of the inner and outer ends.
    pub axes: [Matrix3<f64>; 2],
    /// Lumped inertias of the ends, eq. (D10) with these axes.
    pub lumps: [ArticulatedInertia; 2],
    /// Couplings `H_{aε}` and `H_{bε}` of the inner and outer ends.
    pub couplings: [Coupling; 2],
    /// Inertia `H_{εε}` of the strains.
    pub own: Matrix3<f64>,
}

impl SlopeInertia {
    /// Inertia of element `e` with the inner node `n`, times `scale`.
    pub fn new(model: &Model, work: &Workspace, (e, n): (usize, usize), scale: f64) -> Self {
        let element = &model.elements[e];
        let rotations = [&work.nodes[n].rotation, &work.nodes[n + 1].rotation];
        let axes: [Matrix3<f64>; 2] = from_fn(|end| work.slopes[e][end].axes(&work.nodes[n + end]));
        let own = [inner_mass(element) * scale, element.outer_mass * scale];
        let cross = element.cross_mass * scale;
        // Σ m_k1 r_k of the same end, and of the vectors of the other end in the block that couples them
        let along = |end: usize, mass: [f64; 3]| axes[end] * Vector3::from(mass);
        let within: [Vector3<f64>; 2] = from_fn(|end| along(end, from_fn(|k| own[end][(k + 1, 1)])));
        let across = [along(0, from_fn(|l| cross[(1, l + 1)])), along(1, from_fn(|k| cross[(k + 1, 1)]))];
        let origins = [cross[(1, 0)], cross[(0, 1)]];
        let couplings = from_fn(|end| {
            let (here, there) = (rotations[end], rotations[1 - end]);
            let columns = |rotation: &Matrix3<f64>, k: usize| rotation.fixed_view::<3, 1>(0, k).into_owned();
            Coupling {
                velocity: from_fn(|k| columns(here, k) * own[end][(0, 1)] + columns(there, k) * origins[end]),
                spin: from_fn(|k| within[end].cross(&columns(here, k)) + across[end].cross(&columns(there, k))),
            }
        });
        let turned = rotations[1].tr_mul(rotations[0]) * cross[(1, 1)];
        Self {
            axes,
            lumps: from_fn(|end| lump(&own[end], &axes[end])),
            couplings,
            own: Matrix3::from_diagonal_element(own[0][(1, 1)] + own[1][(1, 1)]) + turned + turned.transpose(),
        }
    }
}
