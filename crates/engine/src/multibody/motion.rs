//! Argument of the sweeps.

/// Coordinates, rates and accelerations, each of [`Model::coordinates`](crate::multibody::Model::coordinates).
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Joint angles (rad) and strains (–, 1/m).
    pub q: &'a [f64],
    /// Their rates per second.
    pub v: &'a [f64],
    /// Their accelerations per second squared.
    pub a: &'a [f64],
}
