//! Strain along a body: between element centres for constant elements, recovered from the section wrench for
//! linear ones.
//!
//! The raw strain of a pair is of second order pointwise; at its ends the wrench of the outboard part gives a fourth-order value, `ε − ε₀ =
//! −K_s⁻¹ Rᵀ (F, M) − β ε̇`, NOTATION eq. (G2). In between, a cubic interpolates both ends and the raw values at the two Gauss points, eq.
//! (G3). Stiffness and natural strain are those of the section.
//!
//! The wrench changes immediately with every force, the strains of the elements do not: while the mesh does not resolve the waves (a torque
//! that jumps, the first instants after a release or a latch) the recovered end values alternate in sign from pair to pair, and are nonzero
//! before the body is strained. [`element_measures`] returns the strains of the elements.

use crate::beam::element::ElementKind;
use crate::math::strain::{CURVATURES, SHEAR_Y, SHEAR_Z, SHEARED, STRAINS, STRETCH, Strain, StrainMatrix};
use crate::multibody::dynamics::Damping;
use crate::multibody::model::{Element, Model, Strained};
use crate::multibody::motion::Motion;
use crate::multibody::nodal::{multiply, wrench_of};
use crate::multibody::slope;
use crate::multibody::workspace::Workspace;
use nalgebra::Vector3;

/// Position and direction of a gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugePoint {
    /// Index of the body.
    pub body: usize,
    /// Distance from the body's inner end in m.
    pub position_m: f64,
    /// Weights of the strain measures `(γ, k₁, k₂, k₃)`: the row of [`crate::beam::recovery`].
    pub row: Strain,
}

impl GaugePoint {
    /// Strain at the gauge, zero for an unstrained body, eq. (G4). `work` must hold a residual of `motion`.
    pub fn strain(&self, model: &Model, work: &Workspace, motion: Motion, damping: &[Damping]) -> f64 {
        self.row.dot(&strain_measures(model, work, motion, damping, self.body, self.position_m))
    }
}

/// Section strains `(εx, κx, κy, κz)` of a body at `position_m` from its inner end, including the natural strain. `work` must hold a
/// residual of `motion`.
pub fn section_strain(
    model: &Model,
    work: &Workspace,
    motion: Motion,
    damping: &[Damping],
    body: usize,
    position_m: f64,
) -> Strain {
    strain_measures(model, work, motion, damping, body, position_m) + model.bodies[body].natural_strain.at(position_m)
}

/// Strain measures `(γ₁, k₁, k₂, k₃)` of a section: its strains minus the natural strains.
pub fn strain_measures(
    model: &Model,
    work: &Workspace,
    motion: Motion,
    damping: &[Damping],
    body: usize,
    position_m: f64,
) -> Strain {
    match model.bodies[body].sheared {
        false => measures(model, work, motion, damping, (body, position_m)),
        true => {
            let measures = measures::<SHEARED>(model, work, motion, damping, (body, position_m));
            measures.fixed_rows::<STRAINS>(0).into_owned()
        }
    }
}

/// Shears `(γy, γz)` of a section, eqs. (G1)–(G3); zero for a body without shear. `work` must hold a residual of `motion`.
pub fn section_shear(
    model: &Model,
    work: &Workspace,
    motion: Motion,
    damping: &[Damping],
    body: usize,
    position_m: f64,
) -> [f64; 2] {
    if !model.bodies[body].sheared {
        return [0.0; 2];
    }
    let measures = measures::<SHEARED>(model, work, motion, damping, (body, position_m));
    [measures[SHEAR_Y], measures[SHEAR_Z]]
}

/// All `N` strain measures of a body with elements of `N` strains, or of a body without elements.
fn measures<const N: usize>(
    model: &Model,
    work: &Workspace,
    motion: Motion,
    damping: &[Damping],
    (body, position_m): (usize, f64),
) -> Strain<N>
where
    Element: Strained<N>,
{
    if model.bodies[body].elements == 0 {
        return Strain::zeros(); // rigid bodies have no strain
    }
    match model.bodies[body].kind {
        ElementKind::Constant => between_centres(model, motion.q, body, position_m),
        ElementKind::Linear => recovered(model, work, motion, damping[body].stiffness_s, (body, position_m)),
    }
}

/// Strains interpolated linearly between element centres, extrapolated in the end half-elements, eq. (G1).
fn between_centres<const N: usize>(model: &Model, q: &[f64], body: usize, position_m: f64) -> Strain<N>
where
    Element: Strained<N>,
{
    let body = &model.bodies[body];
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    let strain = |i: usize| Strain::from(elements[i].strains(q)) - elements[i].elastic().natural_strain;
    if elements.len() == 1 {
        return strain(0);
    }
    let centre = |i: usize| elements[i].start_m + 0.5 * elements[i].length_m;
    let after = (1..elements.len() - 1).find(|&i| centre(i) >= position_m).unwrap_or(elements.len() - 1);
    let weight = (position_m - centre(after - 1)) / (centre(after) - centre(after - 1));
    strain(after - 1) * (1.0 - weight) + strain(after) * weight
}

/// Abscissae of the two Gauss points on `[0, 1]`.
const GAUSS_2: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Strain measures `(γ₁, k₁, k₂, k₃)` of a section from the strains of the elements, eq. (G7): independent of wrenches, so that they vanish
/// for unstrained elements. For displays of whole bodies; gauges use [`strain_measures`].
pub fn element_measures(model: &Model, q: &[f64], body: usize, position_m: f64) -> Strain {
    match model.bodies[body].sheared {
        false => of_elements(model, q, body, position_m),
        true => of_elements::<SHEARED>(model, q, body, position_m).fixed_rows::<STRAINS>(0).into_owned(),
    }
}

fn of_elements<const N: usize>(model: &Model, q: &[f64], body: usize, position_m: f64) -> Strain<N>
where
    Element: Strained<N>,
{
    if model.bodies[body].elements == 0 {
        return Strain::zeros(); // rigid bodies have no strain
    }
    if model.bodies[body].kind == ElementKind::Constant {
        return between_centres(model, q, body, position_m);
    }
    let (inner, offset_m) = model.locate(body, position_m);
    let strain = |half: &Element| Strain::from(half.strains(q)) - half.elastic().natural_strain;
    let line = |first: usize, sigma: f64| on_line(&model.elements[first..first + 2], &strain, sigma);
    let (begin, end) =
        (model.bodies[body].first_element, model.bodies[body].first_element + model.bodies[body].elements);
    let mut values = [0.0, GAUSS_2[0], GAUSS_2[1], 1.0].map(|sigma| line(inner, sigma));
    if inner > begin {
        values[0] = (values[0] + line(inner - 2, 1.0)) * 0.5;
    }
    if inner + 2 < end {
        values[3] = (values[3] + line(inner + 2, 0.0)) * 0.5;
    }
    cubic(&values, offset_m / (2.0 * model.elements[inner].length_m))
}

/// Linear function over a pair from values at its halves, at `sigma` from 0 to 1 along it: `(A+B)/2 + 3/2 (B−A)(σ − 1/2)`, eq. (D8).
fn on_line<const N: usize>(halves: &[Element], of: &dyn Fn(&Element) -> Strain<N>, sigma: f64) -> Strain<N> {
    let (a, b) = (of(&halves[0]), of(&halves[1]));
    (a + b) * 0.5 + (b - a) * (1.5 * (sigma - 0.5))
}

/// The cubic through the values at both ends of a pair and at its Gauss points, eq. (G3).
fn cubic<const N: usize>(values: &[Strain<N>; 4], sigma: f64) -> Strain<N> {
    let places = [0.0, GAUSS_2[0], GAUSS_2[1], 1.0];
    let mut strain = Strain::<N>::zeros();
    for (i, value) in values.iter().enumerate() {
        let weight: f64 =
            (0..values.len()).filter(|&j| j != i).map(|j| (sigma - places[j]) / (places[i] - places[j])).product();
        strain += value * weight;
    }
    strain
}

fn recovered<const N: usize>(
    model: &Model,
    work: &Workspace,
    motion: Motion,
    beta: f64,
    (body, position_m): (usize, f64),
) -> Strain<N>
where
    Element: Strained<N>,
{
    let (inner, offset_m) = model.locate(body, position_m);
    let first_node = model.bodies[body].first_node + inner - model.bodies[body].first_element;
    let halves = &model.elements[inner..inner + 2];
    let raw = |of: &dyn Fn(&Element) -> Strain<N>, sigma: f64| on_line(halves, of, sigma);
    let strain = |half: &Element| Strain::from(half.strains(motion.q)) - half.elastic().natural_strain;
    let rate = |half: &Element| Strain::from(half.strains(motion.v));
    let roots = model.bodies[body].damping_roots.map(|roots| roots.fixed_rows::<N>(0).into_owned());
    // strain that corresponds to the damping stress: the strain rate itself if all factors are 1
    let viscous = |rate: Strain<N>, stiffness: &StrainMatrix<N>| match &roots {
        None => rate,
        Some(roots) => {
            let stress = roots.component_mul(&(stiffness * roots.component_mul(&rate)));
            nalgebra::Cholesky::new(*stiffness).map_or(rate, |factor| factor.solve(&stress))
        }
    };
    let by_modes = |sigma: f64, stiffness: &StrainMatrix<N>| -> Strain<N> {
        if model.damped_modes.iter().all(|mode| mode.body != body) {
            return Strain::zeros();
        }
        let stress = stress_of_modes(model, body, halves, motion.v, sigma);
        nalgebra::Cholesky::new(*stiffness).map_or(stress, |factor| factor.solve(&stress))
    };
    let sigma = offset_m / (2.0 * halves[0].length_m);
    let [at_inner, at_outer] = [halves[0].elastic().section_stiffness[0], halves[1].elastic().section_stiffness[1]];
    let values = [
        end_strain(model, work, body, (first_node, Side::Outboard), &at_inner)
            - viscous(raw(&rate, 0.0), &at_inner) * beta
            - by_modes(0.0, &at_inner),
        raw(&strain, GAUSS_2[0]),
        raw(&strain, GAUSS_2[1]),
        end_strain(model, work, body, (first_node + 2, Side::Inboard), &at_outer)
            - viscous(raw(&rate, 1.0), &at_outer) * beta
            - by_modes(1.0, &at_outer),
    ];
    cubic(&values, sigma)
}

/// Stress resultants of the damping of modes at `sigma` from 0 to 1 along a pair: the linear field whose work on the strains of the halves is
/// that of their damping forces `f`. With (D8) its values at the halves are `(7f_A − f_B)/(3L)` and `(7f_B − f_A)/(3L)`, `L` the pair's length.
fn stress_of_modes<const N: usize>(model: &Model, body: usize, halves: &[Element], v: &[f64], sigma: f64) -> Strain<N> {
    let [mut inner, mut outer] = [Strain::<N>::zeros(); 2];
    for mode in model.damped_modes.iter().filter(|mode| mode.body == body) {
        inner += Strain::from(mode.forces_on::<N>(&halves[0], v));
        outer += Strain::from(mode.forces_on::<N>(&halves[1], v));
    }
    let share = 1.0 / (6.0 * halves[0].length_m);
    let (a, b) = ((inner * 7.0 - outer) * share, (outer * 7.0 - inner) * share);
    (a + b) * 0.5 + (b - a) * (1.5 * (sigma - 0.5))
}

/// Strain measures that balance the wrench of the part outboard of a node (including damping), eq. (G2).
fn end_strain<const N: usize>(
    model: &Model,
    work: &Workspace,
    body: usize,
    (node, side): (usize, Side),
    section_stiffness: &StrainMatrix<N>,
) -> Strain<N> {
    let (force, moment) = section_wrench(model, work, body, node, side);
    let axes = work.nodes[node].rotation.transpose();
    let (force, moment): (Vector3<f64>, Vector3<f64>) = (axes * force, axes * moment);
    // without shear only the axial component of the force works on a strain
    let mut resultant = Strain::<N>::zeros();
    resultant[STRETCH] = -force.x;
    if N == SHEARED {
        (resultant[SHEAR_Y], resultant[SHEAR_Z]) = (-force.y, -force.z);
    }
    resultant.as_mut_slice()[CURVATURES].copy_from_slice((-moment).as_slice());
    // sections of a validated machine are positive definite; others have no defined strain
    nalgebra::Cholesky::new(*section_stiffness)
        .map_or(Strain::<N>::repeat(f64::NAN), |stiffness| stiffness.solve(&resultant))
}

/// Side of a node at which the section is cut: attached masses, loads on the node and child bodies lie between the two sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Towards the body's inner end: attached masses and loads of the node are part of the outboard part.
    Inboard,
    /// Towards the body's outer end.
    Outboard,
}

/// Inertia forces minus loads of all outboard parts, as force and moment at a section next to a node, root frame: the accumulated wrench
/// minus the contribution of the inner element and, outboard of the node, minus that of attached masses and loads.
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
    if node == body.first_node || body.modal.is_some() {
        return (here.force, here.moment);
    }
    if body.sheared {
        let (force, moment) = slope::wrench_of_outer_end(model, body, work, node - body.first_node - 1);
        return (here.force - force, here.moment - moment);
    }
    let element = &model.elements[body.first_element + node - body.first_node - 1];
    let own = multiply(&element.outer_mass, &here.load_rate);
    let from_inner = multiply(&element.cross_mass, &work.nodes[node - 1].load_rate);
    let forces = std::array::from_fn(|k| own[k] + from_inner[k]);
    let (force, moment) = wrench_of(&here.rotation, &forces);
    (here.force - force, here.moment - moment)
}
