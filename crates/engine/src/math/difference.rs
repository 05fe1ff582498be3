//! Weights of central differences.

/// Sixth-order central difference: weights of the steps ±1, ±2, ±3, to be divided by 60 steps.
pub const SIXTH_ORDER: [f64; 3] = [45.0, -9.0, 1.0];
