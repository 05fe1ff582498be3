//! Factorisation and solution for the tree of bodies by the articulated-body recursion.
//!
//! In each element the strains are eliminated by a small Cholesky factor, in each hinge its angle by a scalar pivot, and a 6×6 inertia is
//! passed inward; the tree may branch anywhere. The halves of a pair are eliminated in sequence, the outer one first, with their coupled
//! stiffness carried along; NOTATION eqs. (D10)–(D14). Elements with shear have their own functions in `sheared_factor.rs`.

use crate::beam::element::ElementKind;
use crate::math::so3::hat;
use crate::math::strain::{STRAINS, Strain, StrainMatrix};
use crate::multibody::carried::Carried;
use crate::multibody::cholesky::{back, cholesky, forward};
use crate::multibody::dynamics::Damping;
use crate::multibody::elimination::{BadPivot, FreedomTangent, Weights};
use crate::multibody::model::{Base, Body, Element, Model};
use crate::multibody::nodal::lump;
use crate::multibody::node::NormSquared;
use crate::multibody::node::{ArticulatedInertia, ElementFactor, Pair};
use crate::multibody::norm::displaced;
use crate::multibody::sheared_factor;
use crate::multibody::slide::{self, Riders};
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix3, Vector3};

/// Factorises the tree without closed loops and damped modes; see [`super::factor::factorize`].
pub(super) fn factorize_tree(
    model: &Model,
    work: &mut Workspace,
    weights: Weights,
    damping: &[Damping],
    tangents: &[FreedomTangent],
) -> Result<(), BadPivot> {
    for (body, damping) in model.bodies.iter().zip(damping) {
        let beam = weights.mass + weights.damping * damping.mass_1_s;
        let attachment = if body.damps_attached { beam } else { weights.mass };
        for n in body.first_node..=body.last_node() {
            if body.sheared && model.nodes[n].attached.is_none() {
                work.inertia[n] = ArticulatedInertia::ZERO;
                continue;
            }
            let node = &work.nodes[n];
            let mut mass = model.nodes[n].beam * beam;
            if let Some(attached) = &model.nodes[n].attached {
                mass += attached * attachment;
            }
            work.inertia[n] = lump(&mass, &node.rotation);
        }
    }
    for (index, body) in model.bodies.iter().enumerate().rev() {
        let scale = weights.mass + weights.damping * damping[index].mass_1_s;
        let viscous = weights.damping * damping[index].stiffness_s;
        let elastic = weights.stiffness + weights.mass * damping[index].strain_inertia_s2;
        if let (Some(modal), Some(scratch)) = (&body.modal, &mut work.modal[index]) {
            let outer = &work.inertia[body.last_node()];
            let inertia = modal.eliminate(scratch, &work.nodes[body.first_node], outer, weights)?;
            work.inertia[body.first_node].add(&inertia);
        }
        let own = (elastic, viscous);
        match (body.sheared, body.slim_mass) {
            (false, true | false) => factorize_body(model, work, index, scale, own)?,
            (true, true) => sheared_factor::factorize::<true>(model, work, index, scale, own)?,
            (true, false) => sheared_factor::factorize::<false>(model, work, index, scale, own)?,
        }
        let inertia = work.inertia[body.first_node];
        let passed = body.joint.eliminate(&mut work.joints[index], &inertia, weights, &tangents[index])?;
        match body.base {
            Base::Root(_) => {}
            Base::Node(node) => work.inertia[node].add(&passed),
            Base::Axis(slide) => work.slides[slide].inertia = passed,
        }
    }
    Ok(())
}

/// Eliminates the strains of one body without shear, from its last element to its first.
#[inline(always)]
fn factorize_body(
    model: &Model,
    work: &mut Workspace,
    index: usize,
    scale: f64,
    (elastic, viscous): (f64, f64),
) -> Result<(), BadPivot> {
    let body = &model.bodies[index];
    let stiffness = &body.damped_weights(elastic, viscous);
    // contributions of the outer half of a pair to the inner one: coupling to the middle node, and stiffness
    let mut carried: Option<Carried<STRAINS>> = None;
    for i in (0..body.elements).rev() {
        let e = body.first_element + i;
        let element = &model.elements[e];
        let coupling = &element.elastic.coupling;
        let ends_pair = body.kind == ElementKind::Constant || i % 2 == 1;
        let riders = if body.ridden && ends_pair { Riders::<STRAINS>::on(model, work, index, e) } else { None };
        let outer_half = i % 2 == 1
            && (*coupling != StrainMatrix::<STRAINS>::zeros() || riders.is_some() && body.kind == ElementKind::Linear);
        let n = body.first_node + i;
        let mut from_sibling = carried.take();
        let mut outer = &work.inertia[n + 1];
        let axes = [&work.nodes[n].rotation, &work.nodes[n + 1].rotation];
        let with_riders;
        if let Some(riders) = &riders {
            from_sibling.get_or_insert(Carried::NONE).add(&riders.own);
            with_riders = outer.plus(&riders.outer);
            outer = &with_riders;
        }
        let elimination =
            eliminate(element, &work.link(model, e, n), axes, outer, (scale, stiffness), from_sibling.as_ref())?;
        let mut factor = elimination.factor;
        factor.coupling = coupling.component_mul(stiffness);
        if let Some(riders) = &riders {
            factor.coupling += riders.halves;
        }
        if outer_half {
            let mut passed = Carried::new(&factor);
            if let Some(riders) = &riders {
                passed.add(&riders.sibling);
            }
            carried = Some(passed);
        }
        work.plain.factors[e] = factor;
        work.inertia[n].add(&elimination.inertia);
    }
    Ok(())
}

struct Elimination {
    factor: ElementFactor<STRAINS>,
    inertia: ArticulatedInertia,
}

/// Eliminates the strains of one element with the axes `[r_x r_y r_z]` of its ends, eqs. (D11)–(D13).
#[inline]
fn eliminate(
    element: &Element,
    link: &crate::math::se3::Link<STRAINS>,
    [inner, outer]: [&Matrix3<f64>; 2],
    p: &ArticulatedInertia,
    (scale, stiffness): (f64, &StrainMatrix<STRAINS>),
    carried: Option<&Carried<STRAINS>>,
) -> Result<Elimination, BadPivot> {
    let zero = Vector3::zeros();
    let jv = &link.velocity;
    let jw = link.spin_columns();
    let d = &link.arm_m;

    // cross inertia of the element in twist form
    let cross = element.cross_mass * scale;
    let mass = cross[(0, 0)];
    let along = |m: [f64; 3], rotation: &Matrix3<f64>| rotation * Vector3::from(m);
    let s_inner = along([cross[(0, 1)], cross[(0, 2)], cross[(0, 3)]], inner);
    let s_outer = along([cross[(1, 0)], cross[(2, 0)], cross[(3, 0)]], outer);
    let gradients: Matrix3<f64> = cross.fixed_view::<3, 3>(1, 1).into_owned();
    let w = inner * gradients.transpose() * outer.transpose();
    let trace = w.trace();

    // T = P J, U = Φᵀ T + H_baᵀ J
    let vwt = p.vw.transpose();
    let wt = w.transpose();
    let mut tv = [zero; STRAINS];
    let mut tw = [zero; STRAINS];
    let mut uv = [zero; STRAINS];
    let mut uw = [zero; STRAINS];
    for j in 0..STRAINS {
        tv[j] = p.vv * jv[j] + p.vw * jw[j];
        tw[j] = vwt * jv[j] + p.ww * jw[j];
        if let Some(carried) = carried {
            tv[j] += carried.velocity[j];
            tw[j] += carried.spin[j];
        }
        uv[j] = tv[j] + jv[j] * mass - s_outer.cross(&jw[j]);
        uw[j] = tw[j] + d.cross(&tv[j]) + s_inner.cross(&jv[j]) + jw[j] * trace - wt * jw[j];
    }
    let mut x = element.elastic.stiffness.component_mul(stiffness);
    for i in 0..STRAINS {
        for j in 0..=i {
            let mut entry = jv[i].dot(&tv[j]);
            entry += jw[i].dot(&tw[j]);
            if let Some(carried) = carried {
                entry += carried.velocity[i].dot(&jv[j]) + carried.spin[i].dot(&jw[j]) + carried.block[(i, j)];
            }
            x[(i, j)] += entry;
        }
    }
    let cholesky = cholesky(&x).ok_or(BadPivot { coordinate: element.coordinate })?;

    // P_a += Φᵀ(PΦ + H_ba) + H_baᵀΦ − U X⁻¹ Uᵀ
    let dh = hat(d);
    let sh = hat(&s_inner);
    let shift = p.vw - p.vv * dh - sh;
    let mut vv = p.vv + Matrix3::from_diagonal_element(2.0 * mass);
    let mut vw = shift - dh * mass - hat(&s_outer);
    let mut ww = p.ww - vwt * dh + dh * shift - sh * dh + Matrix3::from_diagonal_element(2.0 * trace) - w - wt;
    let mut zv = uv;
    let mut zw = uw;
    for j in 0..STRAINS {
        for k in 0..j {
            let l = cholesky[(j, k)];
            zv[j] -= zv[k] * l;
            zw[j] -= zw[k] * l;
        }
        zv[j] *= cholesky[(j, j)];
        zw[j] *= cholesky[(j, j)];
        vv -= zv[j] * zv[j].transpose();
        vw -= zv[j] * zw[j].transpose();
        ww -= zw[j] * zw[j].transpose();
    }
    Ok(Elimination {
        factor: ElementFactor { cholesky, velocity: uv, spin: uw, coupling: StrainMatrix::zeros() },
        inertia: ArticulatedInertia { vv, vw, ww },
    })
}

/// Solution without closed loops and damped modes; the displacements of the nodes stay in `bias`.
pub(crate) fn solve_tree(model: &Model, work: &mut Workspace, x: &mut [f64]) -> f64 {
    work.bias.fill(Pair::ZERO);
    for (index, body) in model.bodies.iter().enumerate().rev() {
        let mut p = work.bias[body.last_node()];
        if let (Some(modal), Some(scratch)) = (&body.modal, &mut work.modal[index]) {
            let passed = modal.reduce(scratch, x, &p);
            let own = &work.bias[body.first_node];
            p = Pair { linear: own.linear + passed.linear, angular: own.angular + passed.angular };
        }
        p = match body.sheared {
            false => reduce_body(model, work, body, x, p),
            true => sheared_factor::reduce(model, work, body, x, p),
        };
        body.joint.reduce(&mut work.joints[index], x, &mut p);
        match body.base {
            Base::Root(_) => {}
            Base::Node(node) => {
                work.bias[node].linear += p.linear;
                work.bias[node].angular += p.angular;
            }
            Base::Axis(slide) => slide::reduce(model, work, slide, &p, x),
        }
    }
    back_substitute(model, work, x)
}

/// Outward half of [`solve_tree`]; node displacements overwrite `bias`.
fn back_substitute(model: &Model, work: &mut Workspace, x: &mut [f64]) -> f64 {
    let mut norm = NormSquared::default();
    for (index, body) in model.bodies.iter().enumerate() {
        let mut moved = match body.base {
            Base::Root(_) => Pair::ZERO,
            Base::Node(node) => work.bias[node],
            Base::Axis(slide) => slide::displaced(model, work, slide, x),
        };
        body.joint.expand(&work.joints[index], x, &mut moved, &mut norm);
        work.bias[body.first_node] = moved;
        if let (Some(modal), Some(scratch)) = (&body.modal, &work.modal[index]) {
            moved = modal.expand(scratch, x, &moved);
            work.bias[body.last_node()] = moved;
            norm.include(&moved);
        }
        match body.sheared {
            false => expand_body(model, work, body, x, moved, &mut norm),
            true => sheared_factor::expand(model, work, body, x, moved, &mut norm),
        }
    }
    norm.value(model.reference_length_m)
}

/// Inward half of [`solve_tree`] over the elements of one body: from the wrench at its last node to that at its first node.
#[inline(always)]
fn reduce_body(model: &Model, work: &mut Workspace, body: &Body, x: &[f64], mut p: Pair) -> Pair {
    let pairs = body.kind == ElementKind::Linear;
    let mut from_sibling = Strain::<STRAINS>::zeros();
    for i in (0..body.elements).rev() {
        let e = body.first_element + i;
        let jacobian = work.jacobian(e);
        let (element, rotation) = (&model.elements[e], &work.nodes[body.first_node + i].rotation);
        let pulled: [f64; STRAINS] =
            jacobian.project(element.length_m, &rotation.tr_mul(&p.linear), &rotation.tr_mul(&p.angular));
        let g = Strain::from_column_slice(&x[element.range_of::<STRAINS>()]) + Strain::from(pulled) - from_sibling;
        work.plain.right_hand[e] = g;
        let factor = &work.plain.factors[e];
        let y = back(&factor.cholesky, forward(&factor.cholesky, g));
        from_sibling = match (pairs && i % 2 == 1, body.ridden) {
            (false, _) => Strain::zeros(),
            (true, false) => factor.coupling * y,
            (true, true) => factor.coupling.tr_mul(&y), // not symmetric with bodies that slide along the pair
        };
        let own = &work.bias[body.first_node + i];
        let mut linear = own.linear + p.linear;
        let mut angular = own.angular + p.angular + work.arms[e].cross(&p.linear);
        for j in 0..STRAINS {
            linear -= factor.velocity[j] * y[j];
            angular -= factor.spin[j] * y[j];
        }
        p = Pair { linear, angular };
    }
    p
}

/// Outward half over the elements of one body, from the displacement of its first node.
#[inline(always)]
fn expand_body(
    model: &Model,
    work: &mut Workspace,
    body: &Body,
    x: &mut [f64],
    mut moved: Pair,
    norm: &mut NormSquared,
) {
    let pairs = body.kind == ElementKind::Linear;
    let mut sibling = Strain::<STRAINS>::zeros();
    for i in 0..body.elements {
        let e = body.first_element + i;
        let factor = &work.plain.factors[e];
        let mut g = work.plain.right_hand[e];
        for j in 0..STRAINS {
            g[j] -= factor.velocity[j].dot(&moved.linear) + factor.spin[j].dot(&moved.angular);
        }
        if pairs && i % 2 == 1 {
            g -= factor.coupling * sibling;
        }
        let strain = back(&factor.cholesky, forward(&factor.cholesky, g));
        sibling = strain;
        x[model.elements[e].range_of::<STRAINS>()].copy_from_slice(strain.as_slice());
        moved = displaced::<STRAINS>(model, work, (e, body.first_node + i), &moved, strain.into());
        work.bias[body.first_node + i + 1] = moved;
        norm.include(&moved);
    }
}
