//! The tree of bodies formed by the joints: references, absence of cycles, stable order.

use crate::machine::Parent;
use crate::machine::builder::body::BodyBuilder;
use crate::machine::builder::joint::{Holder, JointBuilder, Type};
use crate::machine::fault::Checker;
use std::collections::BTreeMap;

/// Name of the root as a parent.
const ROOT: &str = "root";

/// The order of bodies and the parents of their joints.
pub(super) struct Tree {
    /// Bodies by the order in which they were added, but parent before child.
    pub order: Vec<usize>,
    /// Parent of the joint of each body in the order in which the bodies were added, as an index into `order`; the root for joints with
    /// errors.
    pub parents: Vec<Parent>,
    /// Whether there are no errors.
    pub holds: bool,
}

/// Looks up the parents of bodies with their joints.
pub(super) fn resolve(bodies: &[(BodyBuilder, JointBuilder)], checker: &mut Checker) -> Tree {
    let mut index_of = BTreeMap::new();
    for (index, (body, _)) in bodies.iter().enumerate() {
        index_of.entry(body.name.as_str()).or_insert(index);
    }
    let mut holds = true;
    let mut parent_of = vec![None; bodies.len()];
    for (own, (_, joint)) in bodies.iter().enumerate() {
        let Holder::Body(parent, _) = &joint.holder else { continue };
        parent_of[own] = index_of.get(parent.as_str()).copied();
        if parent_of[own].is_none() {
            let what = match bodies.iter().find(|(_, other)| other.name == *parent) {
                Some((child, other)) => {
                    format!("the root or a body, not a joint (joint {:?} has the child {:?})", other.name, child.name)
                }
                None => "the root or a body".to_owned(),
            };
            let known = std::iter::once(ROOT).chain(bodies.iter().map(|(body, _)| body.name.as_str()));
            checker.unknown_name(&["joint", &joint.name, "parent"], parent, &what, known);
            holds = false;
        }
    }
    let mut order = sorted(&parent_of);
    if order.len() < bodies.len() {
        if holds {
            refuse_cycles(bodies, &parent_of, &order, checker);
        }
        holds = false;
        let missing: Vec<usize> = (0..bodies.len()).filter(|body| !order.contains(body)).collect();
        missing.iter().for_each(|body| parent_of[*body] = None);
        order.extend(missing);
    }
    let mut rank = vec![0; order.len()];
    order.iter().enumerate().for_each(|(position, body)| rank[*body] = position);
    let parents = bodies.iter().zip(&parent_of).map(|((_, joint), parent)| match (&joint.holder, parent) {
        (Holder::Body(_, position_m), Some(parent)) => {
            let end_m = if joint.kind == Type::Sliding { 0.0 } else { bodies[*parent].0.length_m };
            let position_m = position_m.unwrap_or(end_m);
            Parent::Body { index: rank[*parent], position_m }
        }
        (Holder::Root(position_m), _) => Parent::Root { position_m: *position_m },
        (Holder::Body(..), None) => Parent::Root { position_m: Default::default() },
    });
    Tree { parents: parents.collect(), order, holds }
}

/// Bodies reachable from the root, parent before child: in each round, the first body whose parent is already placed.
fn sorted(parent_of: &[Option<usize>]) -> Vec<usize> {
    let mut placed = vec![false; parent_of.len()];
    let mut order = Vec::with_capacity(parent_of.len());
    while let Some(next) =
        (0..parent_of.len()).find(|body| !placed[*body] && parent_of[*body].is_none_or(|parent| placed[parent]))
    {
        placed[next] = true;
        order.push(next);
    }
    order
}

/// Reports one fault per cycle, at the parent of its first body.
fn refuse_cycles(
    bodies: &[(BodyBuilder, JointBuilder)],
    parent_of: &[Option<usize>],
    placed: &[usize],
    checker: &mut Checker,
) {
    let mut seen = vec![false; parent_of.len()];
    placed.iter().for_each(|body| seen[*body] = true);
    for start in 0..parent_of.len() {
        let mut walk: Vec<usize> = Vec::new();
        let mut body = start;
        while !seen[body] {
            seen[body] = true;
            walk.push(body);
            body = parent_of[body].unwrap_or(body);
        }
        let Some(closes) = walk.iter().position(|member| *member == body) else { continue };
        let mut cycle = walk[closes..].to_vec();
        let first = (0..cycle.len()).min_by_key(|position| cycle[*position]).unwrap_or(0);
        cycle.rotate_left(first);
        let name = |body: usize| bodies[body].0.name.as_str();
        let chain: Vec<&str> = cycle.iter().chain(cycle.first()).map(|body| name(*body)).collect();
        let joint = bodies[cycle[0]].1.name.as_str();
        let allowed =
            format!("a chain of parents that ends at the root; here the parents form a cycle: {}", chain.join(" -> "));
        checker.refuse(&["joint", joint, "parent"], format!("{:?}", chain[1]), allowed);
    }
}

#[cfg(test)]
mod tests {
    use super::sorted;

    #[test]
    fn order_is_that_of_the_file_with_parents_first() {
        // Children of body 3 come before it in the file; 1 and 2 are attached to the root.
        assert_eq!(sorted(&[Some(3), None, None, Some(1), Some(0)]), [1, 2, 3, 0, 4]);
        assert_eq!(sorted(&[None, Some(0), Some(1)]), [0, 1, 2]);
    }

    #[test]
    fn bodies_on_a_cycle_are_left_out() {
        assert_eq!(sorted(&[None, Some(2), Some(1), Some(2)]), [0]);
    }
}
