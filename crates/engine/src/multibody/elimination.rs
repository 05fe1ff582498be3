//! Arguments and result of the elimination of degrees of freedom: weights of the matrix, tangent of the forces on a joint, failed pivot.

/// Weights `a`, `b`, `c` of mass, damping and stiffness in the matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Weight `a` of the mass.
    pub mass: f64,
    /// Weight `b` of the damping, in s.
    pub damping: f64,
    /// Weight `c` of the stiffness, in s².
    pub stiffness: f64,
}

/// Pivot of a joint's degree of freedom, relative to the largest inertia of its type, below which it is indistinguishable from round-off:
/// earlier eliminations leave a few round-off errors of 1e-16 of the subtracted numbers, which are up to a thousand times the inertia. The
/// threshold corresponds to the inertia about its axis of a wire a kilometre long and 1 mm thick.
pub(crate) const ROUND_OFF: f64 = 1e-12;

/// Tangent of the forces on the degrees of freedom of a joint, the same for all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreedomTangent {
    /// Whether the degrees of freedom are unknowns; otherwise they are held or prescribed.
    pub free: bool,
    /// `−∂τ/∂θ` in N·m/rad, for translations in N/m.
    pub stiffness: f64,
    /// `−∂τ/∂θ̇` in N·m·s/rad, for translations in N·s/m.
    pub damping: f64,
}

impl FreedomTangent {
    /// Tangent of a held or prescribed joint.
    pub const HELD: Self = Self { free: false, stiffness: 0.0, damping: 0.0 };
}

/// The matrix has no Cholesky factor: an iterate has diverged. A shorter step may help.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the pivot of coordinate {coordinate} is not positive")]
pub struct BadPivot {
    /// Index of the pivot in `q`.
    pub coordinate: usize,
}
