//! External torque, an input.

/// An external torque; no limit acts on it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct External {
    /// On the outer body about `+θ` in N·m.
    pub torque_n_m: f64,
}
