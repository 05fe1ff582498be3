//! The strains of an element: number, order, names and units.
//!
//! Everything that sizes, indexes or names strains does so by this module: stretch and the three curvatures of every element, then
//! the two transverse shears of an element with shear. Functions for both kinds of element are generic over their number `N`,
//! [`STRAINS`] or [`SHEARED`]. A literal 4 elsewhere counts something else: the nodal vectors `(r, r_x, r_y, r_z)` of a mass matrix,
//! or the components of a quaternion.

use nalgebra::{SMatrix, SVector};
use std::array::from_fn;
use std::ops::Range;

/// Number of strains of a constant-strain element without shear, and of each half of such a pair.
pub const STRAINS: usize = 4;
/// The same with shear: the strains of an element without shear come first.
pub const SHEARED: usize = 6;

/// Index of the stretch `εx`.
pub const STRETCH: usize = 0;
/// Index of the twist `κx`.
pub const TWIST: usize = 1;
/// Index of the curvature about `y`, `κy`.
pub const FLAP: usize = 2;
/// Index of the curvature about `z`, `κz`.
pub const EDGE: usize = 3;
/// Index of the shear in `y`, `γy`, of an element with shear.
pub const SHEAR_Y: usize = 4;
/// Index of the shear in `z`, `γz`, of an element with shear.
pub const SHEAR_Z: usize = 5;
/// Indices of `ε = (εx, γy, γz)`, of an element with shear.
pub const LINEAR: [usize; 3] = [STRETCH, SHEAR_Y, SHEAR_Z];
/// Indices of `κ = (κx, κy, κz)`.
pub const CURVATURES: Range<usize> = TWIST..STRAINS;

/// One number per strain: strains, their rates, or the generalised forces that work on them.
pub type Strain<const N: usize = STRAINS> = SVector<f64, N>;

/// A matrix over the strains: stiffness, or a factor of one.
pub type StrainMatrix<const N: usize = STRAINS> = SMatrix<f64, N, N>;

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

/// Names of the strains in their order; an element without shear has the first [`STRAINS`] of them.
pub const NAMES: [StrainName; SHEARED] = [
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
    StrainName {
        symbol: "γy",
        name: "gamma_y",
        word: "shear y",
        meaning: "shear in `y`",
        key: "shear_y",
        units: ["1", "1/s"],
    },
    StrainName {
        symbol: "γz",
        name: "gamma_z",
        word: "shear z",
        meaning: "shear in `z`",
        key: "shear_z",
        units: ["1", "1/s"],
    },
];

/// The words for the strains of an element without shear, as a sentence lists them.
pub fn joined_words() -> String {
    let [others @ .., last]: [&str; STRAINS] = from_fn(|strain| NAMES[strain].word);
    format!("{} and {last}", others.join(", "))
}

/// The numbers of an element in a vector of coordinates, by the index of the first.
#[inline(always)]
pub fn strains_at<const N: usize>(coordinates: &[f64], first: usize) -> [f64; N] {
    let own = &coordinates[first..first + N];
    from_fn(|strain| own[strain])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The indices, the list of names and their units have one order; curvatures alone have a unit.
    #[test]
    fn names_stand_at_their_indices() {
        let words = [
            (STRETCH, "stretch"),
            (TWIST, "twist"),
            (FLAP, "flap"),
            (EDGE, "edge"),
            (SHEAR_Y, "shear y"),
            (SHEAR_Z, "shear z"),
        ];
        assert_eq!(words.map(|(strain, _)| NAMES[strain].word), words.map(|(_, word)| word));
        for (strain, name) in NAMES.iter().enumerate() {
            assert_eq!(name.units[0] == "1/m", CURVATURES.contains(&strain), "{name:?}");
            assert_eq!(name.key.ends_with("_1_m"), CURVATURES.contains(&strain), "{name:?}");
        }
    }
}
