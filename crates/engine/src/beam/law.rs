//! Variation of section properties and natural strain along a body.

use crate::beam::modal::ModalLaw;
use crate::beam::profile::Profile;
use crate::beam::section::{Material, Section, Solid};
use crate::math::quadrature::gauss_pieces;
use crate::math::strain::{CURVATURES, STRAINS, Strain};

/// Cross-section as a function of the distance `s` from a body's inner end.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one per body")]
pub enum SectionLaw {
    /// Uniform section with given properties.
    Uniform(Section),
    /// Solid section whose outline is scaled by factors along the body (\[M\] 10–11), NOTATION eq. (S5).
    Tapered {
        /// Outline for factors of 1.
        solid: Solid,
        /// Factor `λ₂(s)` of the width.
        width: Profile,
        /// Factor `λ₃(s)` of the height.
        height: Profile,
    },
    /// Sections at stations, the first at the inner and the last at the outer end; stiffness, inertia and outline are linear in between,
    /// NOTATION eq. (S6). Every integral over an element is split at the stations.
    Table(Vec<SectionStation>),
    /// Modal body, without sections that have strains.
    Modal(Box<ModalLaw>),
}

/// A section and its position on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionStation {
    /// Distance from the body's inner end in m.
    pub position_m: f64,
    /// Section at that position.
    pub section: Section,
}

impl From<ModalLaw> for SectionLaw {
    fn from(law: ModalLaw) -> Self {
        Self::Modal(Box::new(law))
    }
}

impl From<Section> for SectionLaw {
    fn from(section: Section) -> Self {
        Self::Uniform(section)
    }
}

impl From<Solid> for SectionLaw {
    fn from(solid: Solid) -> Self {
        Self::Tapered { solid, width: Profile::constant(1.0), height: Profile::constant(1.0) }
    }
}

impl SectionLaw {
    /// Linear variation from a section at the inner end to one at the outer end of a body of `length_m`.
    pub fn between(inner: Section, outer: Section, length_m: f64) -> Self {
        let station = |position_m, section| SectionStation { position_m, section };
        Self::Table(vec![station(0.0, inner), station(length_m, outer)])
    }

    /// Section at `s_m` from the inner end.
    pub fn at(&self, s_m: f64) -> Section {
        match self {
            Self::Uniform(section) => section.clone(),
            Self::Tapered { solid, width, height } => solid.stretched(width.at(s_m), height.at(s_m)).section(),
            Self::Table(stations) => between_stations(stations, s_m),
            Self::Modal(law) => law.section(s_m),
        }
    }

    /// Outline and material at `s_m`; `None` for sections with given properties.
    pub fn solid_at(&self, s_m: f64) -> Option<Solid> {
        match self {
            Self::Tapered { solid, width, height } => Some(solid.stretched(width.at(s_m), height.at(s_m))),
            Self::Uniform(_) | Self::Table(_) | Self::Modal(_) => None,
        }
    }

    /// Positions in m at which the derivative of the section properties may jump.
    pub fn kinks_m(&self) -> Vec<f64> {
        match self {
            Self::Tapered { width, height, .. } => [width.kinks_m(), height.kinks_m()].concat(),
            Self::Table(stations) => stations.iter().map(|station| station.position_m).collect(),
            Self::Uniform(_) | Self::Modal(_) => Vec::new(),
        }
    }

    /// Positions on `[0, length_m]` that show how the section varies.
    pub fn samples_m(&self, length_m: f64) -> Vec<f64> {
        match self {
            Self::Uniform(_) => vec![0.0],
            Self::Tapered { width, height, .. } => [width.samples_m(length_m), height.samples_m(length_m)].concat(),
            Self::Table(_) => self.kinks_m(),
            Self::Modal(_) => vec![0.0, length_m],
        }
    }

    /// Whether the sections deform in shear: elements then have six strains. A table has shear if all its sections do.
    pub fn shears(&self) -> bool {
        match self {
            Self::Uniform(section) => section.shear.is_some(),
            Self::Tapered { solid, .. } => solid.shear_factor.is_some(),
            Self::Table(stations) => stations.iter().all(|station| station.section.shear.is_some()),
            Self::Modal(_) => false,
        }
    }

    /// Returns the law with or without shear of its sections. `None` if shear is requested but a section lacks a shear stiffness or a known
    /// shear modulus, or the body is modal.
    pub fn with_shear(self, shear: bool) -> Option<Self> {
        let without = |section: Section| Section { shear: None, ..section };
        match self {
            Self::Tapered { solid, width, height } if shear => {
                let solid = (solid.material.shear_modulus_pa > 0.0).then(|| solid.with_shear())?;
                Some(Self::Tapered { solid, width, height })
            }
            law if shear => law.shears().then_some(law),
            Self::Tapered { solid, width, height } => {
                Some(Self::Tapered { solid: Solid { shear_factor: None, ..solid }, width, height })
            }
            Self::Uniform(section) => Some(Self::Uniform(without(section))),
            Self::Table(stations) => {
                let stripped =
                    |station: SectionStation| SectionStation { section: without(station.section), ..station };
                Some(Self::Table(stations.into_iter().map(stripped).collect()))
            }
            Self::Modal(law) => Some(Self::Modal(law)),
        }
    }

    /// Whether the section is uniform along the body.
    pub fn is_uniform(&self) -> bool {
        match self {
            Self::Uniform(_) => true,
            Self::Tapered { width, height, .. } => width.is_constant() && height.is_constant(),
            Self::Table(stations) => stations.windows(2).all(|pair| pair[0].section == pair[1].section),
            Self::Modal(_) => false,
        }
    }

    /// Mass of a body of `length_m` in kg.
    pub fn mass_kg(&self, length_m: f64) -> f64 {
        if let Self::Modal(law) = self {
            return law.mass_in_all_kg();
        }
        if self.is_uniform() {
            return self.at(0.0).mass_kg_m * length_m;
        }
        gauss_pieces(0.0, length_m, &self.kinks_m()).iter().map(|(s, weight)| weight * self.at(*s).mass_kg_m).sum()
    }

    /// Returns the law with its inertia multiplied by `mass_factor` and its stiffness by `stiffness_factor`.
    pub fn scaled(&self, mass_factor: f64, stiffness_factor: f64) -> Self {
        match self {
            Self::Uniform(section) => Self::Uniform(section.scaled(mass_factor, stiffness_factor)),
            Self::Tapered { solid, width, height } => Self::Tapered {
                solid: solid.scaled(mass_factor, stiffness_factor),
                width: width.clone(),
                height: height.clone(),
            },
            Self::Table(stations) => {
                let scaled = |station: &SectionStation| SectionStation {
                    section: station.section.scaled(mass_factor, stiffness_factor),
                    ..*station
                };
                Self::Table(stations.iter().map(scaled).collect())
            }
            Self::Modal(law) => {
                let mut law = law.clone();
                law.mass_factor *= mass_factor;
                law.stiffness_factor *= stiffness_factor;
                Self::Modal(law)
            }
        }
    }

    /// Shapes in which a modal body bends; `None` for other bodies.
    pub fn modal(&self) -> Option<&ModalLaw> {
        match self {
            Self::Modal(law) => Some(law),
            Self::Uniform(_) | Self::Tapered { .. } | Self::Table(_) => None,
        }
    }
}

/// Section at a position by linear interpolation between stations; beyond them the nearest one.
fn between_stations(stations: &[SectionStation], s_m: f64) -> Section {
    let after = stations.partition_point(|station| station.position_m <= s_m).clamp(1, stations.len().max(2) - 1);
    match (stations.get(after - 1), stations.get(after)) {
        (Some(inner), Some(outer)) => {
            let share = (s_m - inner.position_m) / (outer.position_m - inner.position_m);
            inner.section.towards(&outer.section, share.clamp(0.0, 1.0))
        }
        (Some(only), None) | (None, Some(only)) => only.section.clone(),
        (None, None) => Solid::rectangle(1.0, 1.0, Material::isotropic(1.0, 0.0, 1.0)).section(),
    }
}

/// Natural strain `(εx, κx, κy, κz)`, the strain of the unloaded shape, as functions of the distance `s` from a body's inner end.
#[derive(Debug, Clone, PartialEq)]
pub struct NaturalStrain(pub [Profile; STRAINS]);

impl<A: Into<[f64; STRAINS]>> From<A> for NaturalStrain {
    /// Natural strain that is constant along the body.
    fn from(strain: A) -> Self {
        Self(strain.into().map(Profile::constant))
    }
}

impl NaturalStrain {
    /// Natural strain without stretch, with twist and curvatures along the body.
    pub fn curved(curvature_1_m: [Profile; 3]) -> Self {
        let mut strain = Self::from([0.0; STRAINS]);
        for (own, curvature) in strain.0[CURVATURES].iter_mut().zip(curvature_1_m) {
            *own = curvature;
        }
        strain
    }

    /// Strain at `s_m` from the inner end.
    pub fn at(&self, s_m: f64) -> Strain {
        Strain::from_fn(|i, _| self.0[i].at(s_m))
    }

    /// Positions in m at which a derivative may jump.
    pub fn kinks_m(&self) -> Vec<f64> {
        self.0.iter().flat_map(Profile::kinks_m).collect()
    }
}
