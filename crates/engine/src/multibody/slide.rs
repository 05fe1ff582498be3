//! Sliding joints: bodies that ride on the axis of a beam, at an arc length that is a coordinate.
//!
//! The carriage is the frame of the beam's section at arc length `s`, NOTATION eqs. (J10)–(J13). Inside an element or pair it is at the end of
//! one link or two, eq. (K10), whose rotation vectors and arms depend on the strains and on `s`; they are written here as links of unit length
//! with the strains `Θ = λ (e_x + ε; κ)`, which are regular where the length `λ` is zero. Pose, rates and accelerations then follow from
//! eq. (K5) with `Θ`, its rate and its acceleration. The element is part of the discrete state, and constant within a step.

use crate::beam::element::ElementKind;
use crate::math::se3::LinkGeometry;
use crate::math::so3::hat;
use crate::math::strain::{SHEARED, STRAINS, STRETCH, StrainMatrix, strains_at};
use crate::multibody::carriage::SlideWork;
use crate::multibody::model::{Element, Model, Strained};
use crate::multibody::motion::Motion;
use crate::multibody::station::sibling;
use crate::multibody::workspace::{ArticulatedInertia, Node, Pair, Workspace};
use nalgebra::Vector3;
use std::array::from_fn;

pub use crate::multibody::carriage::Slide;

impl Slide {
    /// Arc lengths in m at which the beam's elements, or pairs, start, and its end.
    pub fn borders_m(&self, model: &Model) -> Vec<f64> {
        let beam = &model.bodies[self.beam];
        let elements = &model.elements[beam.first_element..beam.first_element + beam.elements];
        let starts = elements.iter().step_by(self.stride(model)).map(|element| element.start_m);
        starts.chain(elements.last().map(|last| last.start_m + last.length_m)).collect()
    }

    /// Index in [`Model::elements`] of an element, or inner half of a pair, counted from the beam's inner end.
    pub fn element(&self, model: &Model, number: usize) -> usize {
        model.bodies[self.beam].first_element + number * self.stride(model)
    }

    fn stride(&self, model: &Model) -> usize {
        if model.bodies[self.beam].kind == ElementKind::Linear { 2 } else { 1 }
    }
}

/// One link of the path to the carriage: its length, the weight of the strains of the first half, and their slopes over the arc length.
#[derive(Clone, Copy)]
struct Part {
    length_m: f64,
    length_slope: f64,
    weight: f64,
    weight_slope_1_m: f64,
}

impl SlideWork {
    /// Inner node of the element or pair.
    pub fn inner_node(&self, model: &Model, slide: &Slide) -> usize {
        let beam = &model.bodies[slide.beam];
        beam.first_node + self.element - beam.first_element
    }

    /// Pose of the carriage and, with `RATES`, its rates and accelerations, eqs. (J10)–(J12).
    pub fn carry<const RATES: bool>(&mut self, model: &Model, slide: &Slide, nodes: &[Node], motion: Motion) -> Node {
        match model.bodies[slide.beam].sheared {
            false => self.carry_on::<STRAINS, RATES>(model, slide, nodes, motion),
            true => self.carry_on::<SHEARED, RATES>(model, slide, nodes, motion),
        }
    }

    fn carry_on<const N: usize, const RATES: bool>(
        &mut self,
        model: &Model,
        slide: &Slide,
        nodes: &[Node],
        motion: Motion,
    ) -> Node {
        let mut node = nodes[self.inner_node(model, slide)];
        let inner = node.position;
        let s = model.bodies[slide.rider].joint.coordinate;
        let element = &model.elements[self.element];
        let (parts, count) = parts(model, slide, self.element, motion.q[s] - element.start_m);
        let of = |coordinates: &[f64]| halves::<N>(coordinates, element.coordinate, count);
        let strains = of(motion.q);
        let ([rates, second], [rate, acceleration]) = match RATES {
            true => ([of(motion.v), of(motion.a)], [motion.v[s], motion.a[s]]),
            false => ([[[0.0; N]; 2]; 2], [0.0; 2]),
        };
        self.by_strain = [[Pair::ZERO; SHEARED]; 2];
        self.column = Pair::ZERO;
        for Part { length_m, length_slope, weight, weight_slope_1_m } in parts.into_iter().take(count) {
            let share = length_m * weight_slope_1_m;
            let mixed = |of: &[[f64; N]; 2], [own, other]: [f64; 2]| -> [f64; N] {
                from_fn(|j| own * of[0][j] + other * of[1][j])
            };
            let weights = [length_m * weight, length_m * (1.0 - weight)];
            let mixed_slope = [length_slope * weight + share, length_slope * (1.0 - weight) - share];
            let axis = |j: usize, length: f64| if j == STRETCH { length } else { 0.0 };
            let difference = mixed(&strains, [1.0, -1.0]);
            let along: [f64; N] = {
                let by_strains = mixed(&strains, mixed_slope);
                from_fn(|j| axis(j, length_slope) + by_strains[j])
            };
            let turned = {
                let by_strains = mixed(&strains, weights);
                from_fn(|j| axis(j, length_m - 1.0) + by_strains[j])
            };
            let inner = node.rotation;
            let (geometry, link) = LinkGeometry::new::<N>(&inner, 1.0, &turned);
            let arm = link.arm_m;
            if RATES {
                let rate_of = {
                    let by_strains = mixed(&rates, weights);
                    from_fn(|j| by_strains[j] + along[j] * rate)
                };
                let second_of = {
                    let (by_strains, by_both) = (mixed(&second, weights), mixed(&rates, mixed_slope));
                    let bent = 2.0 * length_slope * weight_slope_1_m * rate * rate;
                    from_fn(|j| {
                        by_strains[j] + along[j] * acceleration + by_both[j] * (2.0 * rate) + difference[j] * bent
                    })
                };
                let (first, second) = (geometry.rates::<N>(&inner, &rate_of), geometry.rates::<N>(&inner, &second_of));
                let swing = node.spin.cross(&arm);
                node.acceleration += node.spin_rate.cross(&arm)
                    + node.spin.cross(&(swing + first.velocity * 2.0))
                    + second.velocity
                    + first.velocity_bias;
                node.spin_rate += node.spin.cross(&first.spin) + second.spin + first.spin_bias;
                node.velocity += swing + first.velocity;
                node.spin += first.spin;
            }
            let spins = link.spin_columns();
            let push = |twist: &mut Pair, amount: f64, j: usize| {
                twist.linear += link.velocity[j] * amount;
                twist.angular += spins[j] * amount;
            };
            for (by_strain, weight) in self.by_strain.iter_mut().zip(weights) {
                for (j, twist) in by_strain.iter_mut().take(N).enumerate() {
                    twist.linear += twist.angular.cross(&arm);
                    push(twist, weight, j);
                }
            }
            self.column.linear += self.column.angular.cross(&arm);
            along.iter().enumerate().for_each(|(j, amount)| push(&mut self.column, *amount, j));
            node.position += arm;
            node.rotation = link.rotation;
        }
        self.arm = node.position - inner;
        self.position = node.position;
        node
    }

    /// Adds a wrench on the carriage to the inner node of its element and, with `PROJECT`, its projection to the strains.
    pub fn pass_on<const PROJECT: bool>(
        &mut self,
        model: &Model,
        slide: &Slide,
        wrench: &Pair,
        nodes: &mut [Node],
        residual: &mut [f64],
    ) {
        self.wrench = *wrench;
        let node = &mut nodes[self.inner_node(model, slide)];
        node.force += wrench.linear;
        node.moment += wrench.angular + self.arm.cross(&wrench.linear);
        if PROJECT {
            self.project(model, slide, wrench, residual);
        }
    }

    /// Adds the projection of a wrench on the carriage to the rows of the strains of its element.
    fn project(&self, model: &Model, slide: &Slide, wrench: &Pair, rows: &mut [f64]) {
        for (own, range) in self.by_strain.iter().zip(self.strains(model, slide)) {
            for (twist, row) in own.iter().zip(&mut rows[range]) {
                *row += twist.linear.dot(&wrench.linear) + twist.angular.dot(&wrench.angular);
            }
        }
    }

    /// Ranges in `q` of the strains of the element, or of both halves of the pair; the second one is empty for an element.
    fn strains(&self, model: &Model, slide: &Slide) -> [std::ops::Range<usize>; 2] {
        let own = model.elements[self.element].range();
        match model.bodies[slide.beam].kind {
            ElementKind::Constant => [own, 0..0],
            ElementKind::Linear => [own, model.elements[self.element + 1].range()],
        }
    }

    /// Twist of the carriage at constant arc length, for the twist of the inner node and a change of the coordinates, eq. (J13).
    pub fn displaced(&self, model: &Model, slide: &Slide, inner: &Pair, change: &[f64]) -> Pair {
        let mut moved = Pair { linear: inner.linear + inner.angular.cross(&self.arm), angular: inner.angular };
        for (own, range) in self.by_strain.iter().zip(self.strains(model, slide)) {
            for (twist, amount) in own.iter().zip(&change[range]) {
                moved.linear += twist.linear * *amount;
                moved.angular += twist.angular * *amount;
            }
        }
        moved
    }
}

/// Force and moment about a point of the bodies that slide along an element, or pair, at an offset from its inner end of at least `from_m`; not
/// contained in the wrenches of the nodes outboard.
pub(crate) fn outboard_wrench(
    model: &Model,
    work: &Workspace,
    q: &[f64],
    (element, from_m): (usize, f64),
    about_m: &Vector3<f64>,
) -> Pair {
    let mut sum = Pair::ZERO;
    for (slide, own) in model.slides.iter().zip(&work.slides) {
        let s_m = q[model.bodies[slide.rider].joint.coordinate];
        if own.element == element && s_m - model.elements[element].start_m >= from_m {
            sum.linear += own.wrench.linear;
            sum.angular += own.wrench.angular + (own.position - about_m).cross(&own.wrench.linear);
        }
    }
    sum
}

/// Links that lead to a carriage at `offset_m` from the inner end of its element or pair, and their number.
fn parts(model: &Model, slide: &Slide, element: usize, offset_m: f64) -> ([Part; 2], usize) {
    let whole = Part { length_m: offset_m, length_slope: 1.0, weight: 1.0, weight_slope_1_m: 0.0 };
    match model.bodies[slide.beam].kind {
        ElementKind::Constant => ([whole; 2], 1),
        ElementKind::Linear => {
            let (span_m, _) = model.span(element, slide.beam);
            let half = |slope: f64| Part {
                length_m: 0.5 * offset_m,
                length_slope: 0.5,
                weight: 1.25 - slope * offset_m / span_m,
                weight_slope_1_m: -slope / span_m,
            };
            ([half(0.25), half(1.25)], 2)
        }
    }
}

/// Strains of the element, or of both halves of a pair, from a vector of coordinates.
fn halves<const N: usize>(coordinates: &[f64], first: usize, count: usize) -> [[f64; N]; 2] {
    let own = strains_at(coordinates, first);
    [own, if count == 1 { own } else { strains_at(coordinates, sibling::<N>(first)) }]
}

/// Moves a right-hand side on a carriage to the strains of its element and to its inner node.
pub(crate) fn reduce(model: &Model, work: &mut Workspace, index: usize, p: &Pair, x: &mut [f64]) {
    let (slide, own) = (&model.slides[index], &work.slides[index]);
    own.project(model, slide, p, x);
    let bias = &mut work.bias[own.inner_node(model, slide)];
    bias.linear += p.linear;
    bias.angular += p.angular + own.arm.cross(&p.linear);
}

/// Twist of a carriage at constant arc length for the displacements of the nodes in `bias` and a change of the coordinates.
pub(crate) fn displaced(model: &Model, work: &Workspace, index: usize, change: &[f64]) -> Pair {
    let (slide, own) = (&model.slides[index], &work.slides[index]);
    own.displaced(model, slide, &work.bias[own.inner_node(model, slide)], change)
}

/// Contribution of the bodies that slide along an element, or along a pair, to its elimination, eq. (J14).
pub(crate) struct Riders<const N: usize> {
    /// Articulated inertia at the element's outer node, that of the outer half for a pair.
    pub outer: ArticulatedInertia,
    /// Coupling of that node with the strains of the element or outer half, velocity and spin rows, and block of these strains.
    pub own: Coupling<N>,
    /// Coupling of the middle node of a pair with the strains of the inner half, and block of these strains.
    pub sibling: Coupling<N>,
    /// Coupling of the strains of both halves: rows outer, columns inner.
    pub halves: StrainMatrix<N>,
}

/// Coupling of a node with strains, and block of the strains.
pub(crate) struct Coupling<const N: usize> {
    pub velocity: [Vector3<f64>; N],
    pub spin: [Vector3<f64>; N],
    pub block: StrainMatrix<N>,
}

impl<const N: usize> Coupling<N> {
    fn none() -> Self {
        Self { velocity: [Vector3::zeros(); N], spin: [Vector3::zeros(); N], block: StrainMatrix::zeros() }
    }

    /// Adds `Φᵀ P K` and `Kᵀ P K` for an arm from the node to the carriage.
    fn add(&mut self, arm: &Vector3<f64>, pushed: &[Pair; N], twists: &[Pair; N]) {
        for (j, pushed) in pushed.iter().enumerate() {
            self.velocity[j] += pushed.linear;
            self.spin[j] += pushed.angular + arm.cross(&pushed.linear);
            for (i, twist) in twists.iter().enumerate() {
                self.block[(i, j)] += dot(twist, pushed);
            }
        }
    }
}

impl<const N: usize> Riders<N>
where
    Element: Strained<N>,
{
    /// Sums the bodies on the element `last`, or on the pair with this outer half, of a beam; `None` if there are none.
    pub fn on(model: &Model, work: &Workspace, beam: usize, last: usize) -> Option<Self> {
        let body = &model.bodies[beam];
        let first = if body.kind == ElementKind::Linear { last - 1 } else { last };
        let mut sum: Option<Self> = None;
        for (slide, own) in model.slides.iter().zip(&work.slides) {
            if slide.beam != beam || own.element != first {
                continue;
            }
            let sum = sum.get_or_insert_with(|| Self {
                outer: ArticulatedInertia::ZERO,
                own: Coupling::none(),
                sibling: Coupling::none(),
                halves: StrainMatrix::zeros(),
            });
            sum.add(model, work, own, (body.first_node + last - body.first_element, last));
        }
        sum
    }

    fn add(&mut self, model: &Model, work: &Workspace, own: &SlideWork, (node, last): (usize, usize)) {
        let p = &own.inertia;
        let push = |twists: &[Pair; N]| -> [Pair; N] {
            from_fn(|j| Pair {
                linear: p.vv * twists[j].linear + p.vw * twists[j].angular,
                angular: p.vw.tr_mul(&twists[j].linear) + p.ww * twists[j].angular,
            })
        };
        // twist of the carriage per strain, at a fixed outer end of the link that the strain deforms
        let beyond = |columns: &[Pair; SHEARED], element: usize, node: usize| -> (Vector3<f64>, [Pair; N]) {
            let link = work.link::<N>(model, element, node);
            let spins = link.spin_columns();
            let arm = own.position - work.nodes[node + 1].position;
            let twists = from_fn(|j| Pair {
                linear: columns[j].linear - link.velocity[j] - spins[j].cross(&arm),
                angular: columns[j].angular - spins[j],
            });
            (arm, twists)
        };
        let outer_half = usize::from(own.element != last);
        let (arm, twists) = beyond(&own.by_strain[outer_half], last, node);
        let turn = hat(&arm);
        let vw = p.vw - p.vv * turn;
        self.outer.add(&ArticulatedInertia { vv: p.vv, vw, ww: p.ww - p.vw.transpose() * turn + turn * vw });
        self.own.add(&arm, &push(&twists), &twists);
        if outer_half == 0 {
            return;
        }
        let (arm, twists) = beyond(&own.by_strain[0], last - 1, node - 1);
        let pushed = push(&twists);
        self.sibling.add(&arm, &pushed, &twists);
        for (i, row) in own.by_strain[1].iter().take(N).enumerate() {
            for (j, pushed) in pushed.iter().enumerate() {
                self.halves[(i, j)] += dot(row, pushed);
            }
        }
    }
}

fn dot(twist: &Pair, wrench: &Pair) -> f64 {
    twist.linear.dot(&wrench.linear) + twist.angular.dot(&wrench.angular)
}

#[cfg(test)]
#[path = "slide_tests.rs"]
mod tests;
