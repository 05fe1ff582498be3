//! Factorisation and solution over the elements of a body with shear, NOTATION eqs. (D10)–(D14), (D19), (D20), (D23)
//! and (J14).
//!
//! The recursion is that of `tree_factor.rs`, whose code stays as it is without shear: the functions here are not inlined in it. Three of the six strains displace the outer end of an element without rotation, and the Jacobian of
//! the other three has the same columns: the products are written for these blocks.

#![expect(clippy::needless_range_loop, reason = "indices of rows and columns, as in the equations")]

use crate::beam::element::ElementKind;
use crate::math::strain::{LINEAR, SHEARED, StrainMatrix, TWIST};
use crate::multibody::elimination::BadPivot;
use crate::multibody::model::{Body, Element, Model, Strained};
use crate::multibody::node::{ArticulatedInertia, NormSquared, Pair};
use crate::multibody::norm::displaced;
use crate::multibody::sheared_panel::{ShearedFactor, Sibling, Six};
use crate::multibody::slide::{self, Riders};
use crate::multibody::slope_inertia::SlopeInertia;
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;

/// Coupling of an element's strains with the twist of its outer node, and additions to the matrix of the strains, lower triangle by columns:
/// from the outer half of a pair, and from bodies that slide along it.
#[derive(Clone, Copy)]
struct Carried {
    twist: [Six; SHEARED],
    block: [Six; SHEARED],
}

impl Carried {
    const NONE: Self = Self { twist: [[0.0; SHEARED]; SHEARED], block: [[0.0; SHEARED]; SHEARED] };

    /// Adds the coupling by bodies that slide along the element, eq. (J14).
    fn add(&mut self, riders: &slide::Coupling<SHEARED>) {
        for j in 0..SHEARED {
            for r in 0..3 {
                self.twist[j][r] += riders.velocity[j][r];
                self.twist[j][r + 3] += riders.spin[j][r];
            }
            for i in j..SHEARED {
                self.block[j][i] += riders.block[(i, j)];
            }
        }
    }
}

/// Eliminates the strains of one body with shear, from its last element to its first. `SLIM`: [`Body::slim_mass`].
#[inline(never)]
pub(super) fn factorize<const SLIM: bool>(
    model: &Model,
    work: &mut Workspace,
    index: usize,
    scale: f64,
    (elastic, viscous): (f64, f64),
) -> Result<(), BadPivot> {
    let body = &model.bodies[index];
    let weights = &body.damped_weights::<SHEARED>(elastic, viscous);
    let pairs = body.kind == ElementKind::Linear;
    let (mut carried, mut is_carried) = (Carried::NONE, false);
    for i in (0..body.elements).rev() {
        let (e, n) = (body.first_element + i, body.first_node + i);
        let element = &model.elements[e];
        let outer_half = pairs && i % 2 == 1;
        let riders =
            if body.ridden && (!pairs || outer_half) { Riders::<SHEARED>::on(model, work, index, e) } else { None };
        let mut outer = work.inertia[n + 1];
        if let Some(riders) = &riders {
            if !is_carried {
                carried = Carried::NONE;
            }
            is_carried = true;
            carried.add(&riders.own);
            outer.add(&riders.outer);
        }
        let jacobian = work.jacobian(e);
        let ends = (&work.nodes[n..n + 2], &work.slopes[e]);
        let slope = SlopeInertia::new::<SLIM>(element, ends, &jacobian.rotation, scale);
        slope.lumps[1].add_to(&mut outer);
        let inner = &work.nodes[n].rotation;
        let length_m = element.length_m;
        let link = Link {
            arm: work.arms[e],
            spin: inner * (jacobian.tangent * length_m),
            bend: inner * (jacobian.slope_m * length_m),
        };
        let factor = &mut work.sheared[e];
        link.assemble(factor, &outer, &slope, is_carried.then_some(&carried));
        is_carried = outer_half;
        let mut sibling = add_stiffness(factor, element, weights, outer_half);
        if let Some(riders) = &riders {
            add_coupling(factor, &riders.halves);
            sibling = if outer_half { Sibling::Full } else { Sibling::None };
        }
        if !factor.reduce(sibling) {
            return Err(BadPivot { coordinate: element.coordinate });
        }
        if outer_half {
            let Carried { twist, block } = &mut carried;
            match sibling {
                Sibling::Diagonal => factor.leave::<true>(twist, block),
                Sibling::None | Sibling::Full => factor.leave::<false>(twist, block),
            }
            if let Some(riders) = &riders {
                carried.add(&riders.sibling);
            }
        }
        let mut passed = link.passed(factor, &outer, &slope);
        slope.lumps[0].add_to(&mut passed);
        work.inertia[n].add(&passed);
    }
    Ok(())
}

/// Adds the weighted stiffness to the panel, and the coupling with the inner half for an outer half.
#[inline(always)]
fn add_stiffness(
    factor: &mut ShearedFactor,
    element: &Element,
    weights: &StrainMatrix<SHEARED>,
    outer_half: bool,
) -> Sibling {
    let own = Strained::<SHEARED>::elastic(element);
    factor.columns.iter_mut().for_each(|column| column.sibling = [0.0; SHEARED]);
    if own.diagonal {
        for (j, column) in factor.columns.iter_mut().enumerate() {
            column.own[j] += own.stiffness[(j, j)] * weights[(j, j)];
            if outer_half {
                column.sibling[j] = own.coupling[(j, j)] * weights[(j, j)];
            }
        }
        return if outer_half { Sibling::Diagonal } else { Sibling::None };
    }
    for (j, column) in factor.columns.iter_mut().enumerate() {
        for i in j..SHEARED {
            column.own[i] += own.stiffness[(i, j)] * weights[(i, j)];
        }
    }
    if !outer_half {
        return Sibling::None;
    }
    add_coupling(factor, &own.coupling.component_mul(weights));
    Sibling::Full
}

/// Adds a coupling of an outer half, rows outer and columns inner.
#[inline(always)]
fn add_coupling(factor: &mut ShearedFactor, coupling: &StrainMatrix<SHEARED>) {
    for (j, column) in factor.columns.iter_mut().enumerate() {
        for i in 0..SHEARED {
            column.sibling[i] += coupling[(j, i)];
        }
    }
}

/// Jacobian of an element's outer end in the root frame. The columns of the linear strains are `(spin, 0)`, those of the curvatures `(bend,
/// spin)`.
struct Link {
    /// From the inner to the outer end in m.
    arm: Vector3<f64>,
    spin: Matrix3<f64>,
    bend: Matrix3<f64>,
}

#[inline(always)]
fn column(matrix: &Matrix3<f64>, j: usize) -> Vector3<f64> {
    matrix.fixed_view::<3, 1>(0, j).into_owned()
}

#[inline(always)]
fn six(linear: Vector3<f64>, angular: Vector3<f64>) -> Six {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

#[inline(always)]
fn halves(six: &Six) -> [Vector3<f64>; 2] {
    [Vector3::new(six[0], six[1], six[2]), Vector3::new(six[3], six[4], six[5])]
}

/// Repeats a block for each of three axes, with the axis as a number: compilers keep loops over blocks of this length.
macro_rules! each_axis {
    ($axis:ident => $body:block) => {{
        let $axis = 0;
        $body
    }
    {
        let $axis = 1;
        $body
    }
    {
        let $axis = 2;
        $body
    }};
}

impl Link {
    /// Fills the panel with the inertia of the strains, eqs. (D11), (D12) and (D20): `p` is the articulated inertia of the outer node.
    #[inline(always)]
    fn assemble(
        &self,
        factor: &mut ShearedFactor,
        p: &ArticulatedInertia,
        slope: &SlopeInertia,
        carried: Option<&Carried>,
    ) {
        let cross = &slope.cross;
        let [of_inner, of_outer] = &cross.first;
        let turning = Matrix3::from_diagonal_element(cross.spread.trace()) - cross.spread.transpose();
        let vwt = p.vw.transpose();
        // T = P J, with the coupling by the slope and by the outer half
        let (mut linear, mut bending) = ([Pair::ZERO; 3], [Pair::ZERO; 3]);
        each_axis!(k => {
            let (spin, bend) = (column(&self.spin, k), column(&self.bend, k));
            let coupling = &slope.couplings[1];
            linear[k] = Pair { linear: p.vv * spin + coupling.velocity[k], angular: vwt * spin + coupling.spin[k] };
            bending[k] = Pair { linear: p.vv * bend + p.vw * spin, angular: vwt * bend + p.ww * spin };
            if let Some(carried) = carried {
                for (sum, strain) in [(&mut linear[k], LINEAR[k]), (&mut bending[k], TWIST + k)] {
                    let [velocity, spin] = halves(&carried.twist[strain]);
                    sum.linear += velocity;
                    sum.angular += spin;
                }
            }
        });
        // U = Φᵀ T + H_baᵀ J
        each_axis!(k => {
            let (spin, bend) = (column(&self.spin, k), column(&self.bend, k));
            let (coupling, t) = (&slope.couplings[0], &linear[k]);
            factor.columns[LINEAR[k]].twist = six(
                t.linear + spin * cross.mass + coupling.velocity[k],
                t.angular + self.arm.cross(&t.linear) + of_inner.cross(&spin) + coupling.spin[k],
            );
            let t = &bending[k];
            factor.columns[TWIST + k].twist = six(
                t.linear + bend * cross.mass - of_outer.cross(&spin),
                t.angular + self.arm.cross(&t.linear) + of_inner.cross(&bend) + turning * spin,
            );
        });
        // X = Jᵀ T + (coupling)ᵀ J
        let lower = |i: usize, j: usize| (i.max(j), i.min(j));
        each_axis!(k => {
            let (spin, bend) = (column(&self.spin, k), column(&self.bend, k));
            each_axis!(l => {
                let (row, strain) = lower(TWIST + k, LINEAR[l]);
                factor.columns[strain].own[row] = bend.dot(&linear[l].linear) + spin.dot(&linear[l].angular);
            });
            each_axis!(l => {
                if l <= k {
                    let other = column(&self.spin, l);
                    factor.columns[LINEAR[l]].own[LINEAR[k]] =
                        spin.dot(&linear[l].linear) + slope.couplings[1].velocity[k].dot(&other) + slope.own[(k, l)];
                    factor.columns[TWIST + l].own[TWIST + k] =
                        bend.dot(&bending[l].linear) + spin.dot(&bending[l].angular);
                }
            });
        });
        let Some(carried) = carried else { return };
        each_axis!(k => {
            let [on_bend, on_spin] = halves(&carried.twist[TWIST + k]);
            let [on_linear, _] = halves(&carried.twist[LINEAR[k]]);
            each_axis!(l => {
                let (row, strain) = lower(TWIST + k, LINEAR[l]);
                factor.columns[strain].own[row] += on_bend.dot(&column(&self.spin, l));
            });
            each_axis!(l => {
                if l <= k {
                    let (spin, bend) = (column(&self.spin, l), column(&self.bend, l));
                    factor.columns[LINEAR[l]].own[LINEAR[k]] += on_linear.dot(&spin);
                    factor.columns[TWIST + l].own[TWIST + k] += on_bend.dot(&bend) + on_spin.dot(&spin);
                }
            });
        });
        for (column, block) in factor.columns.iter_mut().zip(&carried.block) {
            for r in 0..SHEARED {
                column.own[r] += block[r];
            }
        }
    }

    /// Inertia that the element passes to its inner node without its lump there: `Φᵀ (P Φ + H_ba) + H_baᵀ Φ − Z Zᵀ`, eqs. (D12), (D13).
    #[inline(always)]
    fn passed(&self, factor: &ShearedFactor, p: &ArticulatedInertia, slope: &SlopeInertia) -> ArticulatedInertia {
        let cross = &slope.cross;
        let [of_inner, of_outer] = &cross.first;
        let d = &self.arm;
        // rows of P_vv [d]× and of P_vwᵀ [d]×
        let moved: [Vector3<f64>; 3] = from_fn(|i| column(&p.vv, i).cross(d));
        let swept: [Vector3<f64>; 3] = from_fn(|i| column(&p.vw, i).cross(d));
        let moment = of_inner + of_outer + d * cross.mass;
        let skew = [[0.0, -moment.z, moment.y], [moment.z, 0.0, -moment.x], [-moment.y, moment.x, 0.0]];
        let mixed = |i: usize, j: usize| {
            // of P_vwᵀ [d]×, of H_ba, and of s_a dᵀ
            swept[i][j] + cross.spread[(i, j)] + of_inner[i] * d[j]
        };
        // − [d]× P_vv [d]×: entries (i, j) of [d]× times the rows of P_vv [d]×
        let lifted = |i: usize, j: usize| {
            let (next, last) = ((i + 1) % 3, (i + 2) % 3);
            d[last] * moved[next][j] - d[next] * moved[last][j]
        };
        let turn = 2.0 * (d.dot(of_inner) + cross.spread.trace());
        let mut lower = [[0.0; SHEARED]; SHEARED];
        for j in 0..3 {
            for i in j..3 {
                let unit = if i == j { 1.0 } else { 0.0 };
                lower[j][i] = p.vv[(i, j)] + 2.0 * cross.mass * unit;
                lower[j + 3][i + 3] = p.ww[(i, j)] - mixed(i, j) - mixed(j, i) + lifted(i, j) + turn * unit;
            }
            // the velocity row j and the spin column i
            for i in 0..3 {
                lower[j][i + 3] = p.vw[(j, i)] - moved[j][i] - skew[j][i];
            }
        }
        factor.subtract_twist_square(&mut lower);
        let symmetric = |first: usize| Matrix3::from_fn(|i, j| lower[first + i.min(j)][first + i.max(j)]);
        ArticulatedInertia { vv: symmetric(0), vw: Matrix3::from_fn(|i, j| lower[i][j + 3]), ww: symmetric(3) }
    }
}

/// Inward half of the solution over the elements of one body: from the wrench at its last node to that at its first node.
#[inline(never)]
pub(super) fn reduce(model: &Model, work: &mut Workspace, body: &Body, x: &[f64], mut p: Pair) -> Pair {
    let pairs = body.kind == ElementKind::Linear;
    let mut from_outer = [0.0; SHEARED];
    for i in (0..body.elements).rev() {
        let (e, n) = (body.first_element + i, body.first_node + i);
        let (element, rotation) = (&model.elements[e], &work.nodes[n].rotation);
        let pulled: Six =
            work.jacobian(e).project(element.length_m, &rotation.tr_mul(&p.linear), &rotation.tr_mul(&p.angular));
        let own = &x[element.range_of::<SHEARED>()];
        let factor = &mut work.sheared[e];
        let y = factor.forward(from_fn(|j| own[j] + pulled[j] - from_outer[j]));
        factor.right_hand = y;
        from_outer = if pairs && i % 2 == 1 { factor.on_sibling(&y) } else { [0.0; SHEARED] };
        let [force, moment] = halves(&factor.on_twist(&y));
        let own = &work.bias[n];
        p = Pair {
            linear: own.linear + p.linear - force,
            angular: own.angular + p.angular + work.arms[e].cross(&p.linear) - moment,
        };
    }
    p
}

/// Outward half over the elements of one body, from the displacement of its first node.
#[inline(never)]
pub(super) fn expand(
    model: &Model,
    work: &mut Workspace,
    body: &Body,
    x: &mut [f64],
    mut moved: Pair,
    norm: &mut NormSquared,
) {
    let pairs = body.kind == ElementKind::Linear;
    let mut sibling = [0.0; SHEARED];
    let dot = |a: &Six, b: &Six| (0..SHEARED).map(|r| a[r] * b[r]).sum::<f64>();
    for i in 0..body.elements {
        let (e, n) = (body.first_element + i, body.first_node + i);
        let factor = &work.sheared[e];
        let twist = six(moved.linear, moved.angular);
        let mut y: Six = from_fn(|j| factor.right_hand[j] - dot(&factor.columns[j].twist, &twist));
        if pairs && i % 2 == 1 {
            y = from_fn(|j| y[j] - dot(&factor.columns[j].sibling, &sibling));
        }
        let strain = factor.back(y);
        sibling = strain;
        x[model.elements[e].range_of::<SHEARED>()].copy_from_slice(&strain);
        moved = displaced::<SHEARED>(model, work, (e, n), &moved, strain);
        work.bias[n + 1] = moved;
        norm.include(&moved);
    }
}

#[cfg(test)]
#[path = "sheared_factor_tests.rs"]
mod tests;
