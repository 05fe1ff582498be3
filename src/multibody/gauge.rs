//! Strain along a body: between element centres for constant elements, recovered from the section wrench for
//! linear ones.
//!
//! The raw strain of a pair is second order pointwise; at its ends the wrench of all that lies outboard gives a
//! fourth-order value, `ε = ε₀ − K_s⁻¹ Rᵀ (F, M) − β ε̇`, NOTATION eq. (G2). Inside, a cubic joins both ends and the
//! raw values at the two Gauss points, eq. (G3).

use crate::beam::element::ElementKind;
use crate::multibody::dynamics::{Damping, multiply, wrench_of};
use crate::multibody::kinematics::{Motion, strains};
use crate::multibody::model::Model;
use crate::multibody::workspace::Workspace;
use nalgebra::{Vector3, Vector4};

/// Where a gauge sits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugePoint {
    /// Body.
    pub body: usize,
    /// Distance from the body's inner end in m.
    pub position_m: f64,
    /// Chordwise coordinate in m.
    pub y_m: f64,
    /// Thickness coordinate in m.
    pub z_m: f64,
}

impl GaugePoint {
    /// Axial strain at the point: `εx + z κy − y κz`, eq. (K7). `work` must hold a residual of `motion`.
    pub fn strain(&self, model: &Model, work: &Workspace, motion: Motion, damping: &[Damping]) -> f64 {
        let section = section_strain(model, work, motion, damping, self.body, self.position_m);
        section[0] + self.z_m * section[2] - self.y_m * section[3]
    }
}

/// Section strains `(εx, κx, κy, κz)` of a body at `position_m` from its inner end. `work` must hold a residual of
/// `motion`.
pub fn section_strain(
    model: &Model,
    work: &Workspace,
    motion: Motion,
    damping: &[Damping],
    body: usize,
    position_m: f64,
) -> Vector4<f64> {
    match model.bodies[body].kind {
        ElementKind::Constant => between_centres(model, motion.q, body, position_m),
        ElementKind::Linear => recovered(model, work, motion, damping[body].stiffness_s, body, position_m),
    }
}

/// Linear between element centres, extrapolated in the end half-elements, eq. (G1).
fn between_centres(model: &Model, q: &[f64], body: usize, position_m: f64) -> Vector4<f64> {
    let body = &model.bodies[body];
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    let strain = |i: usize| Vector4::from(strains(q, elements[i].coordinate));
    if elements.len() == 1 {
        return strain(0);
    }
    let centre = |i: usize| elements[i].start_m + 0.5 * elements[i].length_m;
    let after = (1..elements.len() - 1).find(|&i| centre(i) >= position_m).unwrap_or(elements.len() - 1);
    let weight = (position_m - centre(after - 1)) / (centre(after) - centre(after - 1));
    strain(after - 1) * (1.0 - weight) + strain(after) * weight
}

/// Abscissae of the two Gauss points of `[0, 1]`.
const GAUSS_2: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

fn recovered(model: &Model, work: &Workspace, motion: Motion, beta: f64, body: usize, position_m: f64) -> Vector4<f64> {
    let (inner, offset_m) = model.locate(body, position_m);
    let first_node = model.bodies[body].first_node + inner - model.bodies[body].first_element;
    let first = model.elements[inner].coordinate;
    let half = |coordinates: &[f64], shift: usize| Vector4::from(strains(coordinates, first + shift));
    // ε(σ) = (A+B)/2 + 3/2 (B−A)(σ − 1/2), eq. (D8)
    let raw = |coordinates: &[f64], sigma: f64| {
        let (a, b) = (half(coordinates, 0), half(coordinates, 4));
        (a + b) * 0.5 + (b - a) * (1.5 * (sigma - 0.5))
    };
    let sigma = offset_m / (2.0 * model.elements[inner].length_m);
    let values = [
        end_strain(model, work, body, (first_node, Side::Outboard), inner) - raw(motion.v, 0.0) * beta,
        raw(motion.q, GAUSS_2[0]),
        raw(motion.q, GAUSS_2[1]),
        end_strain(model, work, body, (first_node + 2, Side::Inboard), inner) - raw(motion.v, 1.0) * beta,
    ];
    let places = [0.0, GAUSS_2[0], GAUSS_2[1], 1.0];
    let mut strain = Vector4::zeros();
    for (i, value) in values.iter().enumerate() {
        let weight: f64 = (0..4).filter(|&j| j != i).map(|j| (sigma - places[j]) / (places[i] - places[j])).product();
        strain += value * weight;
    }
    strain
}

/// Strain that balances the wrench of all that lies outboard of a node (damping not yet taken off), eq. (G2).
fn end_strain(
    model: &Model,
    work: &Workspace,
    body: usize,
    (node, side): (usize, Side),
    element: usize,
) -> Vector4<f64> {
    let (force, moment) = section_wrench(model, work, body, node, side);
    let axes = work.nodes[node].rotation.transpose();
    let (force, moment): (Vector3<f64>, Vector3<f64>) = (axes * force, axes * moment);
    let element = &model.elements[element];
    let resultant = Vector4::new(-force.x, -moment.x, -moment.y, -moment.z);
    let stiffness =
        nalgebra::Cholesky::new(element.section_stiffness).expect("a section's stiffness is positive definite");
    element.natural_strain + stiffness.solve(&resultant)
}

/// Section next to a node: attached masses, loads on the node and child bodies stand between the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Towards the body's inner end: what sits on the node lies outboard.
    Inboard,
    /// Towards the body's outer end.
    Outboard,
}

/// Force and moment that inertia less loads of all outboard parts exert at a section next to a node, root frame: the
/// accumulated wrench less the inner element's own share and, outboard of the node, what sits on it.
pub fn section_wrench(
    model: &Model,
    work: &Workspace,
    body: usize,
    node: usize,
    side: Side,
) -> (Vector3<f64>, Vector3<f64>) {
    let mut here = work.nodes[node];
    if side == Side::Outboard {
        here.force -= here.fixed.linear;
        here.moment -= here.fixed.angular;
    }
    let body = &model.bodies[body];
    if node == body.first_node {
        return (here.force, here.moment);
    }
    let element = &model.elements[body.first_element + node - body.first_node - 1];
    let own = multiply(&element.outer_mass, &here.load_rate);
    let from_inner = multiply(&element.cross_mass, &work.nodes[node - 1].load_rate);
    let forces = std::array::from_fn(|k| own[k] + from_inner[k]);
    let (force, moment) = wrench_of(&here.rotation, &forces);
    (here.force - force, here.moment - moment)
}
