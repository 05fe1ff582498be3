//! Inertia of elements with shear: the slope of their axis at an end is `d = R (e_x + ε)` instead of `r_x`.
//!
//! The mass (D1) is constant over the nodal vectors `(r, d, r_y, r_z)` of both ends, each with the strain of the element itself. Lumped
//! masses therefore belong to elements instead of nodes, and inertia forces act on the linear strains, NOTATION eq. (D18).

use crate::load::RootMotion;
use crate::math::strain::{LINEAR, SHEARED, STRETCH, strains_at};
use crate::multibody::model::{Body, Element, Model};
use crate::multibody::motion::Motion;
use crate::multibody::nodal::{product, transposed_product, wrench_of};
use crate::multibody::node::Node;
use crate::multibody::slope_vector::Slope;
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix4, Vector3};
use std::array::from_fn;

/// Computes the slopes of all elements with shear, and with `RATES` their rates; poses of the nodes must be current.
#[inline(never)]
pub(super) fn sweep<const RATES: bool>(model: &Model, work: &mut Workspace, motion: Motion) {
    for body in model.bodies.iter().filter(|body| body.sheared) {
        for i in 0..body.elements {
            let e = body.first_element + i;
            let first = model.elements[e].coordinate;
            let own = |coordinates: &[f64]| {
                let strains: [f64; SHEARED] = strains_at(coordinates, first);
                Vector3::from(LINEAR.map(|k| strains[k]))
            };
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
pub(super) fn inner_mass(element: &Element) -> &Matrix4<f64> {
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
    let on = |node: &mut Node, [origin, y, z]: &[Vector3<f64>; 3], moment: &Vector3<f64>| {
        let across = |k: usize, force: &Vector3<f64>| node.rotation.fixed_view::<3, 1>(0, k).cross(force);
        node.moment += moment + across(1, y) + across(2, z);
        node.force += origin;
    };
    // forces on `r`, `r_y`, `r_z` of the inner node and their moment on `d`, by the element before
    let (mut before, mut moment) = ([Vector3::zeros(); 3], Vector3::zeros());
    for i in 0..body.elements {
        let element = &model.elements[body.first_element + i];
        let nodes = &mut work.nodes[body.first_node + i..body.first_node + i + 2];
        let slopes = &work.slopes[body.first_element + i];
        let [inner, outer] = forces::<SLIM>(element, &from_fn(|end| slopes[end].load_rates(&nodes[end])));
        moment += slopes[0].vector.cross(&inner[1]);
        on(&mut nodes[0], &[before[0] + inner[0], before[1] + inner[2], before[2] + inner[3]], &moment);
        if PROJECT {
            let own = &mut residual[element.range_of::<SHEARED>()];
            for (node, forces) in nodes.iter().zip([&inner, &outer]) {
                let on_strains = node.rotation.tr_mul(&forces[1]);
                (0..3).for_each(|k| own[LINEAR[k]] += on_strains[k]);
            }
        }
        (before, moment) = ([outer[0], outer[2], outer[3]], slopes[1].vector.cross(&outer[1]));
    }
    on(&mut work.nodes[body.last_node()], &before, &moment);
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
