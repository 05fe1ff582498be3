//! Checks that several parts of a machine have in common: names, directions.

use crate::machine::fault::{Checker, array_text};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// Allowed form of names.
pub const IDENTIFIER_ALLOWED: &str = "an identifier: letters, digits and _, no digit first";
/// Maximum number of load stations of a body.
pub(in crate::machine) const MAXIMUM_STATIONS_OF_BODY: usize = 1_000;

/// Whether a name has only letters, digits and _, and does not start with a digit.
pub fn is_identifier(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// Checks that names are identifiers, and unique for each type.
pub(in crate::machine) fn names<'n>(kind: &str, names: impl Iterator<Item = &'n str>, checker: &mut Checker) {
    let mut seen = BTreeSet::new();
    for name in names {
        if !is_identifier(name) {
            checker.refuse_state(&[kind, name], format!("the name {name:?}"), IDENTIFIER_ALLOWED);
        }
        if !seen.insert(name) {
            let allowed = format!("a name that no other {kind} has");
            checker.refuse_state(&[kind, name], format!("the name {name:?}"), allowed);
        }
    }
}

/// Reports directions that are not unit vectors.
pub(in crate::machine) fn unit_vector(place: &[&str], direction: &Vector3<f64>, checker: &mut Checker) -> bool {
    let fits = (direction.norm() - 1.0).abs() <= 1e-9;
    if !fits {
        checker.refuse(
            place,
            array_text(direction.as_slice()),
            "a unit vector: 3 finite numbers, not all 0, scaled to length 1",
        );
    }
    fits
}
