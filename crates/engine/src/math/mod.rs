//! Rotations, rigid motions, strains, differences and quadrature.

pub mod corners;
pub mod difference;
pub mod jet;
pub mod jet_link;
mod lanes;
pub mod local_jacobian;
pub mod local_link;
pub mod quadrature;
pub mod se3;
mod sheared_link;
pub mod so3;
pub mod spline;
pub mod strain;
pub(crate) mod wide;

#[cfg(test)]
mod shear_tests;
