//! Elastic and damping forces of the strains of all bodies, NOTATION eqs. (D8) and (D21).

use crate::beam::element::ElementKind;
use crate::math::strain::{SHEARED, STRAINS, Strain, StrainMatrix};
use crate::multibody::model::{Body, Element, Model, Strained};
use crate::multibody::motion::Motion;
use crate::multibody::workspace::Workspace;

/// Damping of one body; acts on its beam, and optionally on attached masses, on the velocity relative to the carrier of the tree: the root
/// frame, or the rigid-body motion of the first node outboard of a free joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Damping {
    /// Mass-proportional, `α` in 1/s.
    pub mass_1_s: f64,
    /// Stiffness-proportional, `β` in s.
    pub stiffness_s: f64,
    /// Inertia of the strains over their stiffness, `1/ω_c²` in s², eq. (D21): no frequency of the beams exceeds `ω_c`. 0 without a limit.
    pub strain_inertia_s2: f64,
}

impl Model {
    /// Unstrained coordinates: natural strains, zero joint angles, other joints in their mounted attitude.
    pub fn natural_coordinates(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.coordinates];
        for body in &self.bodies {
            body.joint.rest(&body.mount, &mut q);
        }
        for element in &self.elements {
            for (strain, q) in q[element.range()].iter_mut().enumerate() {
                *q = element.natural_strain_of(strain);
            }
        }
        q
    }
}

/// Computes the elastic and damping forces of the strains, eq. (D8); joint entries are set to zero.
pub(super) fn elastic_forces(
    model: &Model,
    work: &Workspace,
    motion: Motion,
    damping: &[Damping],
    residual: &mut [f64],
) {
    for (index, (body, damping)) in model.bodies.iter().zip(damping).enumerate() {
        body.joint.own_forces(&work.joints[index], motion, residual);
        if let Some(modal) = &body.modal {
            modal.own_forces(motion, residual);
        }
        match body.sheared {
            false => body_elastic_forces::<STRAINS>(model, body, damping, motion, residual),
            true => body_elastic_forces::<SHEARED>(model, body, damping, motion, residual),
        }
    }
    for mode in &model.damped_modes {
        mode.add_forces(motion.v, residual);
    }
}

/// Elastic and damping forces of the strains of one body.
#[inline(always)]
fn body_elastic_forces<const N: usize>(
    model: &Model,
    body: &Body,
    damping: &Damping,
    motion: Motion,
    residual: &mut [f64],
) where
    Element: Strained<N>,
{
    if let (Some(roots), true) = (&body.damping_roots, damping.stiffness_s != 0.0) {
        let roots = &roots.fixed_rows::<N>(0).into_owned();
        shared_elastic_forces::<N>(model, body, (damping, roots), motion, residual);
        return;
    }
    let mut write = |element: &Element, force: Strain<N>| {
        residual[element.range_of::<N>()].copy_from_slice(force.as_slice());
    };
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    match body.kind {
        ElementKind::Constant => {
            for element in elements {
                write(element, element.elastic().stiffness * resisted_strain(element, motion, damping));
            }
        }
        ElementKind::Linear => {
            for pair in elements.chunks_exact(2) {
                let [inner, outer] = [&pair[0], &pair[1]].map(|half| resisted_strain(half, motion, damping));
                let [a, b] = [pair[0].elastic(), pair[1].elastic()];
                if N == SHEARED && a.diagonal && b.diagonal {
                    let along = |block: &StrainMatrix<N>, strain: &Strain<N>| block.diagonal().component_mul(strain);
                    write(&pair[0], along(&a.stiffness, &inner) + along(&a.coupling, &outer));
                    write(&pair[1], along(&b.stiffness, &outer) + along(&b.coupling, &inner));
                    continue;
                }
                write(&pair[0], a.stiffness * inner + a.coupling * outer);
                write(&pair[1], b.stiffness * outer + b.coupling * inner);
            }
        }
    }
}

/// Elastic and damping forces for strains with different damping factors: `K (ε − ε₀) + β S K S ε̇`, eq. (D8).
fn shared_elastic_forces<const N: usize>(
    model: &Model,
    body: &Body,
    (damping, roots): (&Damping, &Strain<N>),
    motion: Motion,
    residual: &mut [f64],
) where
    Element: Strained<N>,
{
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    let undamped = Damping { stiffness_s: 0.0, ..*damping };
    for (i, element) in elements.iter().enumerate() {
        let mut force = Strain::<N>::zeros();
        let mut damped = Strain::<N>::zeros();
        let mut add = |block: &StrainMatrix<N>, of: &Element| {
            force += block * resisted_strain(of, motion, &undamped);
            damped += block * roots.component_mul(&Strain::from(of.strains(motion.v)));
        };
        add(&element.elastic().stiffness, element);
        if body.kind == ElementKind::Linear {
            add(&element.elastic().coupling, &elements[i ^ 1]);
        }
        force += roots.component_mul(&damped) * damping.stiffness_s;
        residual[element.range_of::<N>()].copy_from_slice(force.as_slice());
    }
}

/// `ε − ε₀ + β ε̇ + ε̈/ω_c²`, which the stiffness multiplies, eqs. (D8) and (D21).
#[inline]
fn resisted_strain<const N: usize>(element: &Element, motion: Motion, damping: &Damping) -> Strain<N>
where
    Element: Strained<N>,
{
    let mut strain = excess_strain(element, motion, damping.stiffness_s);
    if damping.strain_inertia_s2 != 0.0 {
        strain += Strain::from(element.strains(motion.a)) * damping.strain_inertia_s2;
    }
    strain
}

/// Strain for the elastic and viscous forces, `ε − ε₀ + β ε̇`.
#[inline]
pub(crate) fn excess_strain<const N: usize>(element: &Element, motion: Motion, beta: f64) -> Strain<N>
where
    Element: Strained<N>,
{
    let (q, v): ([f64; N], [f64; N]) = (element.strains(motion.q), element.strains(motion.v));
    let natural_strain = &element.elastic().natural_strain;
    Strain::from_fn(|i, _| q[i] - natural_strain[i] + beta * v[i])
}
