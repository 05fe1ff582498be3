//! Sections by shape: dimensions and materials are converted to stiffness, inertia, shear stiffness and centres.

mod airfoil;
mod framed;
mod laminate;
mod law;
mod materials;
mod properties;
mod solid;
mod walls;

#[cfg(test)]
mod tests;

pub(crate) use airfoil::naca;
pub(crate) use laminate::Ply;
pub(crate) use law::{Dimension, FrameDimensions, ProfileShape, Refused, Shape};
pub use materials::{Across, MATERIALS, Material, NamedMaterial, named_material};
pub(crate) use materials::{names_of_materials, nearest_name};
pub use properties::SectionProperties;
