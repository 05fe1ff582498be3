//! Bodies that are defined once in the file and copied in the machine: the blades of a rotor.

use crate::file::ModelFile;
use crate::joint_file::JointFile;
use foldwing_engine::math::so3::rotation_vector;
use indexmap::IndexMap;
use nalgebra::{Rotation3, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Copied bodies and their attached parts.
#[derive(Debug, Default)]
pub(super) struct Copies {
    /// Names of copies, with the names of their originals in the file; names of parts of joints, with their paths in the file.
    pub names: BTreeMap<String, String>,
    /// Table, original name and name of the copy for copies whose name is already in use.
    pub taken: Vec<(&'static str, String, String)>,
}

/// Replaces every body with a `count`, and everything attached to it, by its copies.
pub(super) fn expand(file: &mut ModelFile) -> Copies {
    let mut copies = Copies::default();
    let modal = file.modal_body.iter().filter_map(|(name, body)| Some((name.clone(), body.count?)));
    let beams = file.body.iter().filter_map(|(name, body)| Some((name.clone(), body.count?)));
    let counted: Vec<(String, usize)> = modal.chain(beams).collect();
    for (name, count) in counted {
        let family = family_of(&name, file);
        let has = |body: &String| family.contains(body);
        file.modal_body =
            repeated(("modal_body", &file.modal_body), count, |body, _| has(body), |_, _, _| {}, &mut copies);
        file.rigid_body =
            repeated(("rigid_body", &file.rigid_body), count, |body, _| has(body), |_, _, _| {}, &mut copies);
        file.body = repeated(("body", &file.body), count, |body, _| has(body), |_, _, _| {}, &mut copies);
        let joint_of_family = |_: &String, joint: &JointFile| has(&joint.child);
        let place = |joint: &mut JointFile, k: usize, suffix: &str| {
            if joint.child == name {
                turn(joint, TAU * k as f64 / count as f64);
            } else if has(&joint.parent) {
                joint.parent += suffix;
            }
            joint.child += suffix;
        };
        file.joint = repeated(("joint", &file.joint), count, joint_of_family, place, &mut copies);
        macro_rules! carried {
            ($($table:ident),*) => {$(
                file.$table = repeated(
                    (stringify!($table), &file.$table),
                    count,
                    |_, part| has(&part.body),
                    |part, _, suffix| part.body += suffix,
                    &mut copies,
                );
            )*};
        }
        carried!(mass, load, gauge, internal_load, skate, wheel, surface, control_surface);
    }
    // errors of the parts of a joint that consists of several are those of the joint
    for (name, joint) in &file.joint {
        let original = copies.names.get(name).unwrap_or(name).clone();
        let own = |part: &String| file.joint.contains_key(part) || file.rigid_body.contains_key(part);
        let parts = joint.parts(name, &original).into_iter();
        copies.names.extend(parts.filter(|(part, _)| !own(part)));
    }
    copies
}

/// Names of a body and of all bodies attached to it.
fn family_of(name: &str, file: &ModelFile) -> Vec<String> {
    let mut family = vec![name.to_owned()];
    let mut next = 0;
    while next < family.len() {
        let children =
            file.joint.values().filter(|joint| joint.parent == family[next]).map(|joint| joint.child.clone());
        let fresh: Vec<String> = children.filter(|child| !family.contains(child)).collect();
        family.extend(fresh);
        next += 1;
    }
    family
}

/// Returns the table with the entries selected by `belongs` repeated `count` times, each modified by `change` with its
/// index and suffix.
fn repeated<T: Clone>(
    (kind, table): (&'static str, &IndexMap<String, T>),
    count: usize,
    belongs: impl Fn(&String, &T) -> bool,
    change: impl Fn(&mut T, usize, &str),
    copies: &mut Copies,
) -> IndexMap<String, T> {
    let mut all = IndexMap::new();
    for (name, entry) in table {
        if !belongs(name, entry) {
            all.insert(name.clone(), entry.clone());
            continue;
        }
        for k in 0..count {
            let (suffix, mut copy) = ((k + 1).to_string(), entry.clone());
            change(&mut copy, k, &suffix);
            let copied = format!("{name}{suffix}");
            if table.contains_key(&copied) {
                copies.taken.push((kind, name.clone(), copied.clone()));
                continue;
            }
            copies.names.insert(copied.clone(), name.clone());
            all.insert(copied, copy);
        }
    }
    all
}

/// Rotates the mount of a joint's child about the parent's `x` axis, together with the axis of the joint.
fn turn(joint: &mut JointFile, angle_rad: f64) {
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), angle_rad);
    let turned = |vector: [f64; 3]| (turn * Vector3::from(vector)).into();
    joint.axis = joint.axis.map(turned);
    joint.parent_offset_m = joint.parent_offset_m.map(turned);
    let mount = Rotation3::new(Vector3::from(joint.mount_rotation_deg).map(f64::to_radians));
    joint.mount_rotation_deg = rotation_vector((turn * mount).matrix()).map(f64::to_degrees).into();
}
