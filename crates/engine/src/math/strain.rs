//! The strains of an element: number, order, names and units.
//!
//! Everything that sizes, indexes or names strains does so by this module. Linear strains come first, then the three
//! curvatures. A literal 4 elsewhere counts something else: the nodal vectors `(r, r_x, r_y, r_z)` of a mass matrix, or the
//! components of a quaternion.

use nalgebra::{SMatrix, SVector};
use std::array::from_fn;
use std::ops::Range;

/// Number of strains of a constant-strain element, and of each half of a pair.
pub const STRAINS: usize = 4;

/// Index of the stretch `εx`.
pub const STRETCH: usize = 0;
/// Index of the twist `κx`.
pub const TWIST: usize = 1;
/// Index of the curvature about `y`, `κy`.
pub const FLAP: usize = 2;
/// Index of the curvature about `z`, `κz`.
pub const EDGE: usize = 3;
/// Indices of `κ = (κx, κy, κz)`; the linear strains come before it.
pub const CURVATURES: Range<usize> = TWIST..STRAINS;

/// One number per strain: strains, their rates, or the generalised forces that work on them.
pub type Strain = SVector<f64, STRAINS>;

/// A matrix over the strains: stiffness, or a factor of one.
pub type StrainMatrix = SMatrix<f64, STRAINS, STRAINS>;

/// Names of a strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StrainName {
    /// Symbol of NOTATION.
    pub symbol: &'static str,
    /// Last part of the names of coordinates, as in `inner.element[2].kappa_y`.
    pub name: &'static str,
    /// Word for it in tables and messages.
    pub word: &'static str,
    /// Quantity measured.
    pub meaning: &'static str,
    /// Key of its natural value on a body of a model file.
    pub key: &'static str,
    /// Unit of the strain and of its rate, as the variable table writes units.
    pub units: [&'static str; 2],
}

/// Names of the strains in their order.
pub const NAMES: [StrainName; STRAINS] = [
    StrainName {
        symbol: "εx",
        name: "epsilon_x",
        word: "stretch",
        meaning: "stretch",
        key: "stretch",
        units: ["1", "1/s"],
    },
    StrainName {
        symbol: "κx",
        name: "kappa_x",
        word: "twist",
        meaning: "twist",
        key: "twist_1_m",
        units: ["1/m", "1/(m.s)"],
    },
    StrainName {
        symbol: "κy",
        name: "kappa_y",
        word: "flap",
        meaning: "flapwise curvature (about `y`)",
        key: "curvature_y_1_m",
        units: ["1/m", "1/(m.s)"],
    },
    StrainName {
        symbol: "κz",
        name: "kappa_z",
        word: "edge",
        meaning: "edgewise curvature (about `z`)",
        key: "curvature_z_1_m",
        units: ["1/m", "1/(m.s)"],
    },
];

/// The words for all strains, as a sentence lists them.
pub fn joined_words() -> String {
    let [others @ .., last] = NAMES.map(|name| name.word);
    format!("{} and {last}", others.join(", "))
}

/// The numbers of an element in a vector of coordinates, by the index of the first.
#[inline(always)]
pub fn strains_at(coordinates: &[f64], first: usize) -> [f64; STRAINS] {
    let own = &coordinates[first..first + STRAINS];
    from_fn(|strain| own[strain])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The indices, the list of names and their units have one order: linear strains without a unit, then curvatures.
    #[test]
    fn names_stand_at_their_indices() {
        let words = [(STRETCH, "stretch"), (TWIST, "twist"), (FLAP, "flap"), (EDGE, "edge")];
        assert_eq!(words.map(|(strain, _)| NAMES[strain].word), words.map(|(_, word)| word));
        for (strain, name) in NAMES.iter().enumerate() {
            assert_eq!(name.units[0] == "1/m", CURVATURES.contains(&strain), "{name:?}");
            assert_eq!(name.key.ends_with("_1_m"), CURVATURES.contains(&strain), "{name:?}");
        }
    }
}
