//! An element of the mesh: position, elasticity of its strains, mass blocks.

use crate::beam::element::{ElementElasticity, ElementKind};
use crate::beam::law::{NaturalStrain, SectionLaw};
use crate::beam::section::{Section, Stiff};
use crate::math::strain::{CURVATURES, SHEARED, STRAINS, Strain, StrainMatrix, strains_at};
use nalgebra::Matrix4;
use std::ops::Range;

/// A constant-strain element or half of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// Length in m.
    pub length_m: f64,
    /// Arc length from the body's inner end to the element's inner end in m.
    pub start_m: f64,
    /// Index of its first strain in `q`.
    pub coordinate: usize,
    /// Elasticity of an element without shear; NaN for an element with shear.
    pub elastic: Elastic,
    /// Elasticity of an element with shear.
    pub sheared: Option<Box<Elastic<SHEARED>>>,
    /// Mass block that couples the ends: rows outer, columns inner.
    pub cross_mass: Matrix4<f64>,
    /// Mass block of the outer end: for the section wrench, and for the inertia of an element with shear.
    pub outer_mass: Matrix4<f64>,
    /// Mass block of the inner end of an element with shear; for other elements it is only contained in the node mass.
    pub inner_mass: Option<Box<Matrix4<f64>>>,
}

/// Elasticity of an element's strains.
#[derive(Debug, Clone, PartialEq)]
pub struct Elastic<const N: usize = STRAINS> {
    /// Natural strain.
    pub natural_strain: Strain<N>,
    /// Stiffness of its strains, `∫ K_s ds` weighted by the element type, N·m, N·m², N·m³.
    pub stiffness: StrainMatrix<N>,
    /// Stiffness that couples it to the other half of a pair; zero for constant elements.
    pub coupling: StrainMatrix<N>,
    /// Section stiffness at the inner and outer ends, for strain recovery.
    pub section_stiffness: [StrainMatrix<N>; 2],
    /// Whether stiffness and coupling are diagonal matrices, of an element with shear; not used without shear.
    pub diagonal: bool,
}

impl<const N: usize> Elastic<N> {
    /// All entries NaN.
    pub(super) fn none() -> Self {
        let stiffness = StrainMatrix::repeat(f64::NAN);
        let natural_strain = Strain::repeat(f64::NAN);
        Self { natural_strain, stiffness, coupling: stiffness, section_stiffness: [stiffness; 2], diagonal: false }
    }

    /// The parts of an element on the interval `[start_m, start_m + length_m]` of a body.
    pub(super) fn parts(
        kind: ElementKind,
        (start_m, length_m): (f64, f64),
        section: &SectionLaw,
        natural_strain: &NaturalStrain,
    ) -> Vec<Self>
    where
        Section: Stiff<N>,
    {
        let elasticity = ElementElasticity::new(kind, (start_m, length_m), section, natural_strain);
        let piece_m = length_m / elasticity.own.len() as f64;
        let is_diagonal = |matrix: &StrainMatrix<N>| (0..N).all(|i| (0..N).all(|j| i == j || matrix[(i, j)] == 0.0));
        let diagonal = N == SHEARED && elasticity.own.iter().chain([&elasticity.coupling]).all(is_diagonal);
        let parts = elasticity.own.iter().zip(&elasticity.natural_strain).enumerate();
        parts
            .map(|(piece, (own, natural))| {
                let inner_m = start_m + piece as f64 * piece_m;
                Self {
                    natural_strain: *natural,
                    stiffness: *own,
                    coupling: elasticity.coupling,
                    section_stiffness: [inner_m, inner_m + piece_m].map(|s| section.at(s).stiffness()),
                    diagonal,
                }
            })
            .collect()
    }

    /// Sets the stiffness to zero.
    pub fn release(&mut self) {
        (self.stiffness, self.coupling) = (StrainMatrix::zeros(), StrainMatrix::zeros());
    }

    /// Multiplies the stiffness by a factor.
    pub fn scale(&mut self, factor: f64) {
        self.stiffness *= factor;
        self.coupling *= factor;
        self.section_stiffness.iter_mut().for_each(|stiffness| *stiffness *= factor);
    }
}

/// The elasticity of an element's `N` strains.
pub trait Strained<const N: usize> {
    /// Elasticity of the element's strains.
    fn elastic(&self) -> &Elastic<N>;
}

impl Strained<STRAINS> for Element {
    #[inline(always)]
    fn elastic(&self) -> &Elastic {
        &self.elastic
    }
}

impl Strained<SHEARED> for Element {
    #[inline(always)]
    fn elastic(&self) -> &Elastic<SHEARED> {
        match &self.sheared {
            Some(sheared) => sheared,
            None => unreachable!("an element without shear"),
        }
    }
}

impl Element {
    /// Number of its strains.
    #[inline]
    pub fn count(&self) -> usize {
        if self.sheared.is_some() { SHEARED } else { STRAINS }
    }

    /// Indices of its strains in `q`.
    #[inline]
    pub fn range(&self) -> Range<usize> {
        self.coordinate..self.coordinate + self.count()
    }

    /// Indices of its strains in `q` for an element of `N` strains.
    #[inline(always)]
    pub fn range_of<const N: usize>(&self) -> Range<usize> {
        self.coordinate..self.coordinate + N
    }

    /// Stiffness of one of its strains, `∫ K_s ds` weighted by the element type, N·m, N·m², N·m³.
    pub fn stiffness_of(&self, strain: usize) -> f64 {
        let plain = |elastic: &Elastic| elastic.stiffness[(strain, strain)];
        self.sheared.as_ref().map_or_else(|| plain(&self.elastic), |elastic| elastic.stiffness[(strain, strain)])
    }

    /// Natural value of one of its strains.
    pub fn natural_strain_of(&self, strain: usize) -> f64 {
        self.sheared
            .as_ref()
            .map_or_else(|| self.elastic.natural_strain[strain], |elastic| elastic.natural_strain[strain])
    }

    /// Indices of its twist and curvatures in `q`.
    #[inline]
    pub fn curvatures(&self) -> Range<usize> {
        self.coordinate + CURVATURES.start..self.coordinate + CURVATURES.end
    }

    /// Its entries in a vector of coordinates: strains, or their rates or accelerations.
    #[inline]
    pub fn strains<const N: usize>(&self, coordinates: &[f64]) -> [f64; N] {
        strains_at(coordinates, self.coordinate)
    }
}
