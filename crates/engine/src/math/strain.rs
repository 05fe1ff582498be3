//! The strains of an element: number, order, names and units.
//!
//! All code that sizes, indexes or names strains uses this module: stretch and the three curvatures of every element, then the two
//! transverse shears of an element with shear. Functions for both kinds of element are generic over the number `N` of strains, [`STRAINS`]
//! or [`SHEARED`]. A literal 4 elsewhere counts something else: the nodal vectors `(r, r_x, r_y, r_z)` of a mass matrix, or the components
//! of a quaternion.

use nalgebra::{SMatrix, SVector};
use std::array::from_fn;
use std::ops::Range;

/// Number of strains of a constant-strain element without shear, and of each half of a pair.
pub const STRAINS: usize = 4;
/// Number of strains of an element with shear; those of an element without shear come first.
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
/// Indices of the linear strains `(εx, γy, γz)` of an element with shear.
pub const LINEAR: [usize; 3] = [STRETCH, SHEAR_Y, SHEAR_Z];
/// Indices of the curvatures `κ = (κx, κy, κz)`.
pub const CURVATURES: Range<usize> = TWIST..STRAINS;

/// One number per strain: strains, their rates, or the generalised forces conjugate to them.
pub type Strain<const N: usize = STRAINS> = SVector<f64, N>;

/// Matrix over the strains: a stiffness matrix or a factor of one.
pub type StrainMatrix<const N: usize = STRAINS> = SMatrix<f64, N, N>;

/// Symbol, names and units of a strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StrainName {
    /// Symbol in NOTATION.
    pub symbol: &'static str,
    /// Last part of coordinate names, as in `inner.element[2].kappa_y`.
    pub name: &'static str,
    /// Word for the strain in tables and messages.
    pub word: &'static str,
    /// Quantity measured.
    pub meaning: &'static str,
    /// Key of the natural strain of a body in a model file.
    pub key: &'static str,
    /// Units of the strain and of its rate, in the notation of the variable table.
    pub units: [&'static str; 2],
}

/// Names of the strains in their order; an element without shear uses the first [`STRAINS`].
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

/// Words for the strains of an element without shear, joined as a list in a sentence.
pub fn joined_words() -> String {
    let [others @ .., last]: [&str; STRAINS] = from_fn(|strain| NAMES[strain].word);
    format!("{} and {last}", others.join(", "))
}

/// Strains of an element from a vector of coordinates, by the index of the first.
#[inline(always)]
pub fn strains_at<const N: usize>(coordinates: &[f64], first: usize) -> [f64; N] {
    let own = &coordinates[first..first + N];
    from_fn(|strain| own[strain])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Indices, names and units are in the same order; only curvatures have a unit.
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
