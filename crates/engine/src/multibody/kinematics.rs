//! Outward sweep: poses, velocities and accelerations of all nodes relative to the root frame.

use crate::math::local_link::{self, LANES, Lanes, LocalLinks, LocalMotions, Strains, matrix, vector};
use crate::math::strain::STRAINS;
use crate::multibody::model::{Base, Element, Model};
use crate::multibody::slope;
use crate::multibody::workspace::Workspace;
use std::array::from_fn;

pub use crate::multibody::motion::Motion;

/// Computes only poses and Jacobians, for a kinematic norm or a tangent at a configuration.
pub fn sweep_poses(model: &Model, work: &mut Workspace, q: &[f64]) {
    sweep::<false>(model, work, Motion { q, v: &[], a: &[] });
}

/// Computes poses, velocities and accelerations, NOTATION eqs. (K8)–(K9). Allocates nothing.
pub fn sweep_motion(model: &Model, work: &mut Workspace, motion: Motion) {
    sweep::<true>(model, work, motion);
}

/// Computes poses and, with `RATES`, velocities and accelerations.
#[inline]
fn sweep<const RATES: bool>(model: &Model, work: &mut Workspace, motion: Motion) {
    sweep_links::<RATES>(model, &mut work.local_links, &mut work.local_motions, motion);
    for (index, (body, joint)) in model.bodies.iter().zip(&mut work.joints).enumerate() {
        let (offset_m, parent) = match &body.base {
            Base::Root(position_m) => (position_m, None),
            Base::Node(node) => (&body.offset_m, Some(work.nodes[*node])),
            Base::Axis(slide) => {
                let carriage = work.slides[*slide].carry::<RATES>(model, &model.slides[*slide], &work.nodes, motion);
                joint.ride(&work.slides[*slide].column, &(carriage.rotation * body.offset_m));
                (&body.offset_m, Some(carriage))
            }
        };
        let node = &mut work.nodes[body.first_node];
        body.joint.carry::<RATES>((offset_m, &body.mount), joint, parent.as_ref(), node, motion);

        if let (Some(modal), Some(scratch)) = (&body.modal, &mut work.modal[index]) {
            let [inner, outer] = &mut work.nodes[body.first_node..body.first_node + 2] else { unreachable!() };
            modal.carry::<RATES>(scratch, inner, outer, motion);
        }
        for i in 0..body.elements {
            let e = body.first_element + i;
            let (links, lane) = (&work.local_links[e / LANES], e % LANES);
            let [inner, outer] = &mut work.nodes[body.first_node + i..body.first_node + i + 2] else { unreachable!() };
            let turn = &inner.rotation;
            let arm = turn * vector(&links.arm_m, lane);
            work.arms[e] = arm;
            outer.rotation = turn * matrix(&links.rotation, lane);
            outer.position = inner.position + arm;
            if RATES {
                let motions = &work.local_motions[e / LANES];
                let swing = inner.spin.cross(&arm);
                let velocity = turn * vector(&motions.velocity, lane);
                let spin = turn * vector(&motions.spin, lane);
                outer.velocity = inner.velocity + swing + velocity;
                outer.spin = inner.spin + spin;
                outer.acceleration = inner.acceleration
                    + inner.spin_rate.cross(&arm)
                    + inner.spin.cross(&(swing + velocity * 2.0))
                    + turn * vector(&motions.acceleration, lane);
                outer.spin_rate = inner.spin_rate + inner.spin.cross(&spin) + turn * vector(&motions.spin_rate, lane);
            }
        }
    }
    if model.sheared {
        slope::sweep::<RATES>(model, work, motion);
    }
}

/// Evaluates all links in their own frames, several at a time.
#[inline]
fn sweep_links<const RATES: bool>(
    model: &Model,
    links: &mut [LocalLinks],
    motions: &mut [LocalMotions],
    motion: Motion,
) {
    let chunks = model.elements.chunks(LANES).zip(links.iter_mut().zip(motions));
    for (elements, (links, motions)) in chunks {
        let element = |lane: usize| &elements[lane.min(elements.len() - 1)];
        let first = from_fn(|lane| element(lane).coordinate);
        let length_m = Lanes(from_fn(|lane| element(lane).length_m));
        if model.sheared && elements.iter().any(|element| element.sheared.is_some()) {
            sheared_links::<RATES>(elements, (first, length_m), (links, motions), motion);
            continue;
        }
        let q = Strains::<STRAINS>::read(motion.q, &first);
        if RATES {
            let (v, a) = (Strains::read(motion.v, &first), Strains::read(motion.a, &first));
            (*links, *motions) = local_link::poses_and_motions(length_m, &q, &v, &a);
        } else {
            *links = local_link::poses(length_m, &q);
        }
    }
}

/// Evaluates links of which at least one has shear.
#[inline(never)]
fn sheared_links<const RATES: bool>(
    elements: &[Element],
    (first, length_m): ([usize; LANES], Lanes),
    (links, motions): (&mut LocalLinks, &mut LocalMotions),
    motion: Motion,
) {
    let element = |lane: usize| &elements[lane.min(elements.len() - 1)];
    let alike = elements.iter().all(|element| element.sheared.is_some());
    let read = |coordinates| match alike {
        true => Strains::read(coordinates, &first),
        false => Strains::read_mixed(coordinates, &first, from_fn(|lane| element(lane).count())),
    };
    let q = read(motion.q);
    if RATES {
        (*links, *motions) = local_link::poses_and_motions(length_m, &q, &read(motion.v), &read(motion.a));
    } else {
        *links = local_link::poses(length_m, &q);
    }
}
