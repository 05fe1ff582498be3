//! Rotations, rigid motions and quadrature.

pub mod quadrature;
pub mod se3;
pub mod so3;
