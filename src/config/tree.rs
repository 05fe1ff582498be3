//! The tree of bodies that the joints make: references, one joint per body, no cycle, stable order.

use crate::config::file::ModelFile;
use crate::config::validate::Checker;

/// Name of the parent that is no body.
pub(super) const ROOT: &str = "root";

/// A valid tree over the bodies of a file.
pub(super) struct Tree {
    /// Bodies as the file counts them, parent before child, else in the order of the file.
    pub order: Vec<usize>,
    /// Position in `order` of each body of the file.
    pub rank: Vec<usize>,
    /// Joint of each body of the file.
    pub joint_of: Vec<usize>,
}

/// Reads the tree; `None` if a problem was found.
pub(super) fn build(file: &ModelFile, checker: &mut Checker) -> Option<Tree> {
    let references_hold = check_references(file, checker);
    let joint_of = joint_of_bodies(file, references_hold, checker);
    let joint_of: Vec<usize> = joint_of.into_iter().collect::<Option<_>>()?;
    if !references_hold {
        return None;
    }
    let parent_of: Vec<Option<usize>> =
        joint_of.iter().map(|joint| file.body.get_index_of(&file.joint[*joint].parent)).collect();
    let order = sorted(&parent_of);
    if order.len() < parent_of.len() {
        refuse_cycles(file, &parent_of, &joint_of, &order, checker);
        return None;
    }
    let mut rank = vec![0; order.len()];
    order.iter().enumerate().for_each(|(position, body)| rank[*body] = position);
    Some(Tree { order, rank, joint_of })
}

/// Parents and children exist and differ, no two joints hold the same child.
fn check_references(file: &ModelFile, checker: &mut Checker) -> bool {
    let mut hold = true;
    let bodies = || file.body.keys().map(String::as_str);
    for (index, (name, joint)) in file.joint.iter().enumerate() {
        if joint.parent != ROOT && !file.body.contains_key(&joint.parent) {
            let known = std::iter::once(ROOT).chain(bodies());
            let what = match file.joint.get(&joint.parent) {
                Some(other) => format!("the root or a body, not a joint ({:?} holds {:?})", joint.parent, other.child),
                None => "the root or a body".to_owned(),
            };
            checker.unknown_name(&["joint", name, "parent"], &joint.parent, &what, known);
            hold = false;
        }
        let path = ["joint", name, "child"];
        let earlier = file.joint.values().take(index).position(|other| other.child == joint.child);
        if !file.body.contains_key(&joint.child) {
            checker.unknown_name(&path, &joint.child, "a body", bodies());
            hold = false;
        } else if joint.child == joint.parent {
            checker.refuse(&path, "a body other than the parent");
            hold = false;
        } else if let Some((other, _)) = earlier.and_then(|earlier| file.joint.get_index(earlier)) {
            checker.refuse(&path, format!("a body that no other joint holds; {other:?} holds this one"));
            hold = false;
        }
    }
    hold
}

/// The joint of each body. Bodies without one are refused where the joints' own references hold.
fn joint_of_bodies(file: &ModelFile, references_hold: bool, checker: &mut Checker) -> Vec<Option<usize>> {
    let mut joint_of = vec![None; file.body.len()];
    for (index, joint) in file.joint.values().enumerate() {
        if let Some(body) = file.body.get_index_of(&joint.child) {
            joint_of[body] = Some(index);
        }
    }
    if references_hold {
        for (name, _) in file.body.keys().zip(&joint_of).filter(|(_, joint)| joint.is_none()) {
            checker.refuse_as(
                &["body", name],
                "a body without a joint",
                format!("exactly one joint with child = {name:?}"),
            );
        }
    }
    joint_of
}

/// Bodies reachable from the root, parent before child: each time the first of the file whose parent is placed.
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

/// One problem per cycle, at the parent of its first body.
fn refuse_cycles(
    file: &ModelFile,
    parent_of: &[Option<usize>],
    joint_of: &[usize],
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
        let name = |body: usize| file.body.get_index(body).map_or("", |(name, _)| name.as_str());
        let chain: Vec<&str> = cycle.iter().chain(cycle.first()).map(|body| name(*body)).collect();
        let joint = file.joint.get_index(joint_of[cycle[0]]).map_or("", |(name, _)| name.as_str());
        let allowed = format!("a parent that ends at the root; here the parents go in a cycle: {}", chain.join(" -> "));
        checker.refuse(&["joint", joint, "parent"], allowed);
    }
}

#[cfg(test)]
mod tests {
    use super::sorted;

    #[test]
    fn order_is_that_of_the_file_with_parents_first() {
        // Children of body 3 stand before it in the file; 1 and 2 hang on the root.
        assert_eq!(sorted(&[Some(3), None, None, Some(1), Some(0)]), [1, 2, 3, 0, 4]);
        assert_eq!(sorted(&[None, Some(0), Some(1)]), [0, 1, 2]);
    }

    #[test]
    fn bodies_on_a_cycle_are_left_out() {
        assert_eq!(sorted(&[None, Some(2), Some(1), Some(2)]), [0]);
    }
}
