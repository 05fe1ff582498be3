//! The elements of one kind in a tangent: links, loads inside them, and products with them.

use crate::beam::element::ElementKind;
use crate::load::{LoadFrame, Wrench};
use crate::math::se3::LinkGeometry;
use crate::math::strain::{SHEARED, Strain};
use crate::multibody::model::{Body, Element, Model, Station, Strained};
use crate::multibody::station;
use crate::multibody::tangent::block::{Block, LinkTangent, SlopeTangent, Unknowns, turned};
use crate::multibody::tangent::elimination::Factor;
use crate::multibody::tangent::twist::{accumulate, add, follower, twist};
use crate::multibody::workspace::{Pair, Workspace};
use nalgebra::{Const, DimMin, Matrix6, SMatrix};
use std::ops::Range;

/// Links of all elements; used for those with `N` strains.
#[derive(Debug, Clone)]
pub(super) struct Links<const N: usize, const U: usize>
where
    Const<U>: DimMin<Const<U>, Output = Const<U>>,
{
    pub(super) links: Vec<LinkTangent<N>>,
    /// Inertia in the strains; empty without shear.
    pub(super) slopes: Vec<SlopeTangent<N>>,
    /// Station loads inside the element, or pair, that starts with this element.
    pub(super) stations: Vec<Option<Box<Block<U>>>>,
    /// Factor of the element, or pair, that starts with this element.
    pub(super) factors: Vec<Option<Factor<U>>>,
}

impl<const N: usize, const U: usize> Links<N, U>
where
    Const<U>: DimMin<Const<U>, Output = Const<U>>,
{
    pub(super) fn new(elements: usize) -> Self {
        Self {
            links: vec![LinkTangent::ZERO; elements],
            slopes: vec![SlopeTangent::ZERO; if N == SHEARED { elements } else { 0 }],
            stations: vec![None; elements],
            factors: vec![None; elements],
        }
    }
}

/// The link of an element linearised about its pose; `place` contains the element and its inner node.
pub(super) fn link_tangent<const N: usize>(
    model: &Model,
    work: &Workspace,
    q: &[f64],
    place: (usize, usize),
) -> LinkTangent<N> {
    let (element, node) = (&model.elements[place.0], place.1);
    let outer = &work.nodes[node + 1];
    LinkTangent::new(
        &work.link(model, place.0, node),
        &work.nodes[node].rotation,
        (element.length_m, &element.strains(q)),
        &outer.force,
        &outer.moment,
    )
}

impl<const N: usize, const U: usize> Links<N, U>
where
    Const<U>: DimMin<Const<U>, Output = Const<U>>,
{
    pub(super) fn add_load(&mut self, model: &Model, work: &Workspace, q: &[f64], (place, load): (&Station, &Wrench)) {
        let block = station_block::<N, U>(model, work, q, place, load);
        match &mut self.stations[place.element] {
            Some(sum) => sum.add(&block),
            empty => *empty = Some(Box::new(block)),
        }
    }

    /// Computes the rows of the strains of a body, and the wrenches transmitted inward; twists of the nodes must be known.
    pub(super) fn apply(
        &self,
        model: &Model,
        body: &Body,
        x: &[f64],
        y: &mut [f64],
        (displaced, wrenches): (&[Pair], &mut [Pair]),
    ) where
        Element: Strained<N>,
    {
        let stride = stride(body);
        for i in (0..body.elements).rev() {
            let e = body.first_element + i;
            let a = body.first_node + i;
            let strain: Strain<N> = Strain::from(model.elements[e].strains(x));
            let inner = twist(&displaced[a]);
            let mut by_slope = Strain::<N>::zeros();
            if let Some(slope) = self.slopes.get(e) {
                add(&mut wrenches[a], &(slope.columns[0] * strain));
                add(&mut wrenches[a + 1], &(slope.columns[1] * strain));
                by_slope = slope.rows[0] * inner + slope.rows[1] * twist(&displaced[a + 1]) + slope.own * strain;
            }
            let outer = twist(&wrenches[a + 1]);
            let (mut forces, passed) = self.links[e].push(&strain, &inner, &outer);
            if N == SHEARED {
                forces += by_slope;
            }
            let elastic = elastic::<N>(model, body, i, x);
            accumulate(&mut y[model.elements[e].range()], &(forces + elastic));
            add(&mut wrenches[a], &passed);
            if i % stride == 0
                && let Some(block) = &self.stations[e]
            {
                let own = strains_of(model, e, stride);
                let mut strains = Unknowns::<U>::zeros();
                strains.as_mut_slice()[..own.len()].copy_from_slice(&x[own.clone()]);
                accumulate(&mut y[own], &(block.xx * strains + block.xa * inner));
                add(&mut wrenches[a], &(block.ax * strains + block.aa * inner));
            }
        }
    }
}

fn elastic<const N: usize>(model: &Model, body: &Body, i: usize, x: &[f64]) -> Strain<N>
where
    Element: Strained<N>,
{
    let element = &model.elements[body.first_element + i];
    let mut force = element.elastic().stiffness * Strain::from(element.strains(x));
    if body.kind == ElementKind::Linear {
        let sibling = &model.elements[body.first_element + (i ^ 1)];
        force += element.elastic().coupling * Strain::from(sibling.strains(x));
    }
    force
}

/// Block of a load inside an element or pair: a massless branch of one or two links whose strains are mixed from those of the element, eqs.
/// (K10) and (L6).
fn station_block<const N: usize, const U: usize>(
    model: &Model,
    work: &Workspace,
    q: &[f64],
    place: &Station,
    load: &Wrench,
) -> Block<U> {
    let first = station::first_coordinate(model, place);
    let (steps, count) = station::steps(model, place);
    let start = work.nodes[station::inner_node(model, place)].rotation;
    let mut rotations = [start; 3];
    let strains: [[f64; N]; 2] =
        std::array::from_fn(|i| if i < count { station::mix(q, first, steps[i].weights) } else { [0.0; N] });
    let mut links = [crate::math::se3::Link::<N>::ZERO; 2];
    for i in 0..count {
        (_, links[i]) = LinkGeometry::new(&rotations[i], steps[i].length_m, &strains[i]);
        rotations[i + 1] = links[i].rotation;
    }
    let (load_force, load_moment) = turned(load, place.frame, &rotations[count]);
    let outer = if place.frame == LoadFrame::Section { follower(&load_force, &load_moment) } else { Matrix6::zeros() };
    // loads have a negative sign in the residual
    let (force, mut moment) = (-load_force, -load_moment);
    let mut tangents = [LinkTangent::<N>::ZERO; 2];
    for i in (0..count).rev() {
        tangents[i] = LinkTangent::new(&links[i], &rotations[i], (steps[i].length_m, &strains[i]), &force, &moment);
        moment += links[i].arm_m.cross(&force);
    }
    let mut block = Block::<U>::of_links(&tangents[..count], (&[], &[]), &outer, &Matrix6::zeros());
    if count == 2 {
        let mut mixing = SMatrix::<f64, U, U>::zeros();
        for (i, step) in steps.iter().enumerate() {
            for k in 0..N {
                mixing[(N * i + k, k)] = step.weights[0];
                mixing[(N * i + k, N + k)] = step.weights[1];
            }
        }
        block.mix(&mixing);
    }
    block
}

/// Number of elements eliminated together: both halves of a pair.
pub(super) fn stride(body: &Body) -> usize {
    if body.kind == ElementKind::Linear { 2 } else { 1 }
}

/// Indices in `q` of the strains of an element, or of the pair that starts with it.
pub(super) fn strains_of(model: &Model, element: usize, stride: usize) -> Range<usize> {
    model.elements[element].coordinate..model.elements[element + stride - 1].range().end
}
