//! Degrees of freedom of joints that are chains, and names of their parts.

use crate::machine::Travel;

/// A degree of freedom of a chain, about or along the axis of its joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Freedom {
    /// Name of its table in the model file; the name of its joint in the machine is `<joint>_<name>`.
    pub name: &'static str,
    /// Rotation or translation.
    pub travel: Travel,
}

/// Degrees of freedom of a cylindrical joint, from the parent outward.
pub const CYLINDRICAL: &[Freedom] = &[
    Freedom { name: "translation", travel: Travel::Translation },
    Freedom { name: "rotation", travel: Travel::Rotation },
];

impl Freedom {
    /// Name of its joint in the machine.
    pub fn joint(&self, chain: &str) -> String {
        format!("{chain}_{}", self.name)
    }
}

/// Name of a body without mass between two joints of a chain or of a sliding joint, counted from 0 at the parent.
pub fn carriage(joint: &str, index: usize) -> String {
    match index {
        0 => format!("{joint}_carriage"),
        _ => format!("{joint}_carriage{}", index + 1),
    }
}
