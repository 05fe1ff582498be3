//! Factors of `M + g C + g² K` with all terms of the tree, gyroscopic and geometric ones included, in O(n); NOTATION eqs. (X30)–(X33).
//!
//! The motion of a node varies by 15 numbers: the first and second derivatives of its displacement, its rotation and the two derivatives of
//! that. The wrench on the node and all outboard parts is a 6×15 matrix times these; in every link the strains, and in every joint its angle,
//! are eliminated by a small inverse, from the tips to the root. The factors leave out rotation of the root and loads at stations.

#![expect(
    clippy::needless_range_loop,
    reason = "several arrays have the index, and iterators are not inlined into code for vectors"
)]

use crate::beam::element::ElementKind;
use crate::math::strain::{STRAINS, StrainMatrix};
use crate::math::wide::{Fours, WithFours, with_fours};
use crate::multibody::derivative::coupling::{Coupling, Turning, add_inertia};
use crate::multibody::derivative::elimination::{Carried, Given, LinkFactor, columns_of, eliminate};
use crate::multibody::derivative::gains::{Gains, Quad, STATE, TURNS, UNDAMPED, add_undamped, combined};
use crate::multibody::derivative::lanes::{Linear, State, Triple};
use crate::multibody::derivative::spot::Spot;
use crate::multibody::dynamics::Damping;
use crate::multibody::joint::JointKind;
use crate::multibody::model::{Body, Model};

/// The factors and their workspace.
#[derive(Debug, Clone)]
pub(super) struct Exact {
    pub elements: Vec<LinkFactor<STRAINS>>,
    /// Per body; `None` while its joint is held.
    pub joints: Vec<Option<LinkFactor<1>>>,
    /// Per node: wrench per unit of the variation, outboard parts included.
    gains: Vec<Gains<8>>,
    turning: Vec<Turning>,
    coupling: Coupling,
    /// Of the arm of the present link.
    crossing: [Quad; 3],
    pub single: Sweep<1>,
    pub wrenches: Vec<[f64; 6]>,
    pub states: Vec<[f64; STATE]>,
}

/// Workspace of solutions with `L` right-hand sides: wrenches and variations of the nodes.
#[derive(Debug, Clone)]
pub struct Sweep<const L: usize> {
    pub(super) wrenches: Vec<[Triple<L>; 2]>,
    pub(super) states: Vec<State<L>>,
}

impl<const L: usize> Sweep<L> {
    /// Workspace for a model.
    pub fn new(model: &Model) -> Self {
        let nodes = model.nodes.len();
        Self { wrenches: vec![[[[0.0; L]; 3]; 2]; nodes], states: vec![[[[0.0; L]; 3]; 5]; nodes] }
    }
}

impl Exact {
    pub fn new(model: &Model) -> Self {
        let nodes = model.nodes.len();
        Self {
            elements: vec![LinkFactor::ZERO; model.elements.len()],
            joints: vec![None; model.bodies.len()],
            gains: vec![[[0.0; 8]; STATE]; nodes],
            turning: vec![Turning::ZERO; nodes],
            coupling: Coupling::ZERO,
            crossing: [[0.0; 4]; 3],
            single: Sweep::new(model),
            wrenches: vec![[0.0; 6]; nodes],
            states: vec![[0.0; STATE]; nodes],
        }
    }
}

/// See [`Derivative::has_factors`](super::Derivative::has_factors).
pub(super) fn covers(model: &Model) -> bool {
    let covered = |body: &Body| {
        let joint = match body.joint.kind {
            JointKind::Clamped | JointKind::Revolute { .. } | JointKind::Prismatic { .. } => true,
            JointKind::Sliding | JointKind::Universal { .. } | JointKind::Ball | JointKind::Free => false,
        };
        joint && body.modal.is_none() && !body.sheared && body.carrier.is_none() && body.joint.drive_carried == 0.0
    };
    model.closures.is_empty()
        && model.constraints() == 0
        && model.damped_modes.is_empty()
        && model.circuits.is_empty()
        && model.bodies.iter().all(covered)
}

impl Exact {
    /// Factorises `M + g C + g² K` at the linearised point, eqs. (X30)–(X32). `joint` gives for each body the coefficient of its joint's own
    /// acceleration (inertia, `g` times damping, `g²` times stiffness), `None` while the joint is held. Allocates nothing.
    ///
    /// `None` if a pivot is not positive.
    pub fn factorize(
        &mut self,
        linear: Linear,
        model: &Model,
        gain_s: f64,
        damping: &[Damping],
        joint: impl Fn(usize) -> Option<f64>,
    ) -> Option<()> {
        with_fours(Elimination { exact: self, linear, model, gain_s, damping, joint })
    }
}

/// The arguments of [`Exact::factorize`].
struct Elimination<'a, J> {
    exact: &'a mut Exact,
    linear: Linear<'a>,
    model: &'a Model,
    gain_s: f64,
    damping: &'a [Damping],
    joint: J,
}

impl<J: Fn(usize) -> Option<f64>> WithFours for Elimination<'_, J> {
    type Output = Option<()>;

    #[inline(always)]
    fn run<V: Fours>(self, fours: V) -> Option<()> {
        let Self { exact, linear: Linear { links, spots, columns, alphas }, model, gain_s, damping, joint } = self;
        for (index, body) in model.bodies.iter().enumerate() {
            match body.slim_mass {
                true => exact.start_body::<true, V>(fours, model, body, spots, alphas[index]),
                false => exact.start_body::<false, V>(fours, model, body, spots, alphas[index]),
            }
        }
        for (index, body) in model.bodies.iter().enumerate().rev() {
            let weights: StrainMatrix = body.damped_weights(gain_s * gain_s, gain_s * damping[index].stiffness_s);
            let mut sibling: Option<Carried<STRAINS>> = None;
            for i in (0..body.elements).rev() {
                let (e, n) = (body.first_element + i, body.first_node + i + 1);
                let (element, link) = (&model.elements[e], &links[n]);
                let ends = [&exact.turning[n], &exact.turning[n - 1]];
                match body.slim_mass {
                    true => exact.coupling.write::<true, V>(fours, &element.cross_mass, ends, alphas[index]),
                    false => exact.coupling.write::<false, V>(fours, &element.cross_mass, ends, alphas[index]),
                }
                let (inner, outer) = exact.gains.split_at_mut(n);
                let own = element.elastic.stiffness.component_mul(&weights) + link.slopes * (gain_s * gain_s);
                let given = Given {
                    link,
                    columns: &columns[link.range()],
                    gain_s,
                    own: columns_of(&own),
                    outer: &outer[0],
                    cross: Some(&exact.coupling),
                };
                let factor = &mut exact.elements[e];
                eliminate(fours, &given, sibling.take().as_ref(), factor, (&mut inner[n - 1], &mut exact.crossing))?;
                if body.kind == ElementKind::Linear {
                    let coupling = columns_of(&element.elastic.coupling.component_mul(&weights));
                    if i % 2 == 1 {
                        let inner = &model.elements[e - 1].elastic.coupling;
                        let inner = columns_of(&inner.component_mul(&-weights));
                        let mut carried = Carried::ZERO;
                        for j in 0..STRAINS {
                            factor.sibling[j] = combined(fours, &factor.inverse, &coupling[j]);
                            carried.block[j] = combined(fours, &inner, &factor.sibling[j]);
                            for k in 0..STRAINS {
                                for i in 0..6 {
                                    carried.wrench[i][j] -= factor.sibling[j][k] * factor.passed[k][i];
                                }
                            }
                        }
                        for k in 0..STATE {
                            carried.by_middle[k] = combined(fours, &inner, &factor.by_carrier[k]);
                        }
                        sibling = Some(carried);
                    } else {
                        factor.sibling = coupling;
                    }
                }
            }
            let n = body.first_node;
            let link = &links[n];
            let pivot = if link.count == 1 { joint(index) } else { None };
            let mut on_root = [[0.0; 8]; STATE];
            let (inner, outer) = exact.gains.split_at_mut(n);
            let outer = &outer[0];
            let on_inner = link.carrier.map_or(&mut on_root, |carrier| &mut inner[carrier]);
            exact.joints[index] = match pivot {
                Some(pivot) => {
                    let columns = &columns[link.range()];
                    let given = Given { link, columns, gain_s, own: [[pivot]], outer, cross: None };
                    let mut factor = LinkFactor::<1>::ZERO;
                    eliminate(fours, &given, None, &mut factor, (on_inner, &mut exact.crossing))?;
                    Some(factor)
                }
                None => {
                    let given = Given::<0> { link, columns: &[], gain_s, own: [], outer, cross: None };
                    let mut factor = LinkFactor::<0>::ZERO;
                    eliminate(fours, &given, None, &mut factor, (on_inner, &mut exact.crossing))?;
                    None
                }
            };
        }
        Some(())
    }
}

impl Exact {
    /// Change of the wrenches on the nodes of a body with their own motion.
    #[inline(always)]
    fn start_body<const SLIM: bool, V: Fours>(
        &mut self,
        fours: V,
        model: &Model,
        body: &Body,
        spots: &[Spot],
        alpha_1_s: f64,
    ) {
        for n in body.first_node..=body.last_node() {
            let (spot, sum) = (&spots[n], &mut self.gains[n]);
            self.turning[n].write(spot, true);
            *sum = [[0.0; 8]; STATE];
            let mut own = [[0.0; 8]; UNDAMPED];
            let beam = &model.nodes[n].beam;
            add_inertia::<SLIM, V>(fours, &mut own, |i, j| beam[(i, j)], [&self.turning[n]; 2]);
            add_undamped(fours, sum, &own, alpha_1_s);
            if let Some(attached) = &model.nodes[n].attached {
                let damps = body.damps_attached || alpha_1_s == 0.0;
                let mut turning = Turning::ZERO;
                turning.write(spot, damps);
                own = [[0.0; 8]; UNDAMPED];
                add_inertia::<false, V>(fours, &mut own, |i, j| attached[(i, j)], [&turning; 2]);
                add_undamped(fours, sum, &own, if damps { alpha_1_s } else { 0.0 });
            }
            for k in 0..3 {
                for i in 0..3 {
                    sum[TURNS[0] + k][4 + i] += spot.by_turn[(i, k)];
                }
            }
        }
    }
}
