//! External torque on a joint, an input.

/// External torque, without limits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct External {
    /// Torque on the outer body about `+θ` in N·m.
    pub torque_n_m: f64,
}
