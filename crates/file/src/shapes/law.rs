//! Section given by its shape, whose dimensions may vary along a body.

use super::airfoil::{self, LARGEST_GAP, Misfit, Spar};
use super::framed::{self, Frame};
use super::laminate::{self, Coupling, Ply};
use super::materials::Material;
use super::properties::SectionProperties;
use super::solid;
use foldwing_engine::beam::law::{SectionLaw, SectionStation};
use foldwing_engine::beam::profile::Profile;
use foldwing_engine::beam::section::{Outline, Solid};
use foldwing_engine::machine::units::shortest;

/// Maximum relative error of stiffness and mass halfway between two stations, due to linear interpolation.
const STATION_ERROR: f64 = 1e-4;
/// Maximum number of bisections of the interval between two kinks of the dimensions.
const MAXIMUM_HALVINGS: usize = 7;

/// Shape with its dimensions and materials.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// Round tube with `[diameter, wall]`.
    Tube([Dimension; 2], Material),
    /// Rectangular box.
    Box(FrameDimensions, Material),
    /// I-beam with equal flanges.
    I(FrameDimensions, Material),
    /// Channel, open towards `+y` if the number is 1, towards `−y` if −1.
    C(FrameDimensions, f64, Material),
    /// Angle with `[width, height, wall]`.
    Angle([Dimension; 3], Material),
    /// Thin-walled profile.
    Profile(Box<ProfileShape>),
    /// Strip of plies, with its width.
    Laminate(Dimension, Vec<Ply>),
}

/// `[width, height, wall]`, and the web thickness if it differs from that of the wall.
#[derive(Debug, Clone)]
pub(crate) struct FrameDimensions {
    pub outer: [Dimension; 3],
    pub web: Option<Dimension>,
}

/// Dimensions of a thin-walled profile.
#[derive(Debug, Clone)]
pub(crate) struct ProfileShape {
    pub chord: Dimension,
    pub skin: Dimension,
    /// Outline in fractions of the chord.
    pub outline: Vec<[f64; 2]>,
    /// Key that defines the outline.
    pub outline_key: &'static str,
    pub material: Material,
    /// Name, position, thickness and material of each spar.
    pub spars: Vec<(String, f64, Dimension, Material)>,
    /// 1 if the leading edge is towards `+y`, −1 if towards `−y`.
    pub side: f64,
}

/// Dimension with its key.
#[derive(Debug, Clone)]
pub(crate) struct Dimension {
    pub key: &'static str,
    pub profile: Profile,
}

/// Dimensions that do not give a section.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Refused {
    /// Path of the key in the section's table.
    pub key: Vec<String>,
    /// Position along the body in m.
    pub position_m: f64,
    /// Value of the dimension at this position, if the key has one.
    pub value: Option<f64>,
    /// Description of the state found, if it is not the value of a key.
    pub found: Option<String>,
    pub allowed: String,
}

impl Refused {
    fn value(key: &str, position_m: f64, value: f64, allowed: String) -> Self {
        Self { key: vec![key.to_owned()], position_m, value: Some(value), found: None, allowed }
    }

    fn state(key: &str, position_m: f64, found: impl Into<String>, allowed: impl Into<String>) -> Self {
        let (found, allowed) = (Some(found.into()), allowed.into());
        Self { key: vec![key.to_owned()], position_m, value: None, found, allowed }
    }
}

impl Dimension {
    fn at(&self, s_m: f64) -> Result<f64, Refused> {
        let value = self.profile.at(s_m);
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(Refused::value(self.key, s_m, value, "a finite length > 0 m".to_owned()))
    }

    /// Wall thickness, which must be less than half of each outer dimension; at half the section would be solid.
    fn wall(&self, s_m: f64, within: &[(&Self, f64)], solid: &str) -> Result<f64, Refused> {
        let wall = self.at(s_m)?;
        for (outer, size_m) in within {
            if wall >= 0.5 * size_m {
                let half = shortest(0.5 * size_m);
                let allowed = format!("a wall > 0 m and < {half} m, half of {}; {solid}", outer.key);
                return Err(Refused::value(self.key, s_m, wall, allowed));
            }
        }
        Ok(wall)
    }
}

impl FrameDimensions {
    fn at(&self, s_m: f64, solid: &str) -> Result<Frame, Refused> {
        let [width, height, wall] = &self.outer;
        let (width_m, height_m) = (width.at(s_m)?, height.at(s_m)?);
        let wall_m = wall.wall(s_m, &[(height, height_m)], solid)?;
        let web_m = self.web.as_ref().unwrap_or(wall).wall(s_m, &[(width, width_m)], solid)?;
        Ok(Frame { width_m, height_m, wall_m, web_m })
    }
}

/// Advice if the walls are so thick that the section is not hollow.
const RECTANGLE: &str = "a solid one has shape = \"rectangle\"";

impl Shape {
    /// Properties of a solid section; `None` if its shear modulus is unknown.
    pub fn solid(solid: &Solid) -> Option<SectionProperties> {
        let own = &solid.material;
        let material = Material {
            youngs_modulus_pa: own.youngs_modulus_pa,
            shear_modulus_pa: (own.shear_modulus_pa > 0.0).then_some(own.shear_modulus_pa)?,
            density_kg_m3: own.density_kg_m3,
            across: None,
        };
        let make = match solid.outline {
            Outline::Rectangle => solid::rectangle,
            Outline::Ellipse => solid::ellipse,
        };
        let mut properties = make(solid.width_m, solid.height_m, &material).about_shear_centre();
        properties.torsional_rigidity_n_m2 =
            solid.torsional_rigidity_n_m2.unwrap_or(properties.torsional_rigidity_n_m2);
        Some(properties)
    }

    /// Properties at the distance `s_m` from the inner end of a body.
    ///
    /// # Errors
    /// Dimensions at this position that do not give a section.
    pub fn at(&self, s_m: f64) -> Result<SectionProperties, Refused> {
        let degenerate =
            |key: &str| Refused::state(key, s_m, "a section of such dimensions", "walls that make a section");
        let raw = match self {
            Self::Tube([diameter, wall], material) => {
                let diameter_m = diameter.at(s_m)?;
                let wall_m = wall.wall(s_m, &[(diameter, diameter_m)], "a solid rod has shape = \"ellipse\"")?;
                solid::tube(diameter_m, wall_m, material)
            }
            Self::Box(frame, material) => {
                framed::hollow_box(frame.at(s_m, RECTANGLE)?, material).ok_or_else(|| degenerate("wall_m"))?
            }
            Self::I(frame, material) => {
                framed::i_beam(frame.at(s_m, RECTANGLE)?, material).ok_or_else(|| degenerate("wall_m"))?
            }
            Self::C(frame, side, material) => {
                let raw = framed::channel(frame.at(s_m, RECTANGLE)?, material).ok_or_else(|| degenerate("wall_m"))?;
                if *side < 0.0 { raw.mirrored() } else { raw }
            }
            Self::Angle([width, height, wall], material) => {
                let (width_m, height_m) = (width.at(s_m)?, height.at(s_m)?);
                let wall_m = wall.wall(s_m, &[(width, width_m), (height, height_m)], RECTANGLE)?;
                framed::angle(width_m, height_m, wall_m, material).ok_or_else(|| degenerate("wall_m"))?
            }
            Self::Profile(profile) => profile.at(s_m)?,
            Self::Laminate(width, plies) => {
                let width_m = width.at(s_m)?;
                return laminate::laminate(width_m, plies).map_err(|coupling| coupled(coupling, s_m));
            }
        };
        Ok(raw.about_shear_centre())
    }

    /// Distance of the beam axis from the leading edge of a profile as a fraction of its chord; `None` for other shapes.
    pub fn axis_fraction(&self, properties: &SectionProperties) -> Option<f64> {
        match self {
            Self::Profile(profile) => {
                let [[rear, front], _] = properties.outline_m?;
                let ahead = if profile.side > 0.0 { front } else { -rear };
                // the outline may extend ahead of x = 0
                let nose = profile.outline.iter().map(|point| point[0]).fold(f64::INFINITY, f64::min);
                Some(ahead / profile.chord.profile.at(0.0) + nose)
            }
            Self::Tube(..) | Self::Box(..) | Self::I(..) | Self::C(..) | Self::Angle(..) | Self::Laminate(..) => None,
        }
    }

    /// Outline of a profile as fractions of its chord; empty for other shapes.
    pub fn aerofoil(&self) -> &[[f64; 2]] {
        match self {
            Self::Profile(profile) => &profile.outline,
            Self::Tube(..) | Self::Box(..) | Self::I(..) | Self::C(..) | Self::Angle(..) | Self::Laminate(..) => &[],
        }
    }

    /// All dimensions.
    fn dimensions(&self) -> Vec<&Dimension> {
        match self {
            Self::Tube(pair, _) => pair.iter().collect(),
            Self::Box(frame, _) | Self::I(frame, _) | Self::C(frame, _, _) => {
                frame.outer.iter().chain(&frame.web).collect()
            }
            Self::Angle(three, _) => three.iter().collect(),
            Self::Profile(profile) => {
                [&profile.chord, &profile.skin].into_iter().chain(profile.spars.iter().map(|spar| &spar.2)).collect()
            }
            Self::Laminate(width, _) => vec![width],
        }
    }

    /// Returns whether the section is uniform along the body.
    pub fn is_constant(&self) -> bool {
        self.dimensions().iter().all(|dimension| dimension.profile.is_constant())
    }

    /// Positions in m at which the derivative of a dimension may be discontinuous.
    pub fn kinks_m(&self) -> Vec<f64> {
        self.dimensions().iter().flat_map(|dimension| dimension.profile.kinks_m()).collect()
    }

    /// Sections along a body of `length_m` with their positions, the first at its inner end and the last at its outer end, such
    /// that the error of linear interpolation between them is within [`STATION_ERROR`].
    ///
    /// # Errors
    /// As for [`Shape::at`].
    pub fn stations(&self, length_m: f64) -> Result<Vec<(f64, SectionProperties)>, Refused> {
        if self.is_constant() {
            return Ok(vec![(0.0, self.at(0.0)?)]);
        }
        let mut places: Vec<f64> = self.kinks_m().into_iter().filter(|s| *s > 0.0 && *s < length_m).collect();
        places.extend([0.0, length_m]);
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| *a - *b < 1e-9 * length_m);
        let mut stations = vec![(0.0, self.at(0.0)?)];
        for pair in places.windows(2) {
            let inner = stations.last().map_or_else(|| self.at(pair[0]), |(_, last)| Ok(last.clone()))?;
            let outer = self.at(pair[1])?;
            self.refine((pair[0], &inner), (pair[1], &outer), MAXIMUM_HALVINGS, &mut stations)?;
            stations.push((pair[1], outer));
        }
        Ok(stations)
    }

    /// Adds stations between two others until linear interpolation is accurate.
    fn refine(
        &self,
        inner: (f64, &SectionProperties),
        outer: (f64, &SectionProperties),
        halvings: usize,
        stations: &mut Vec<(f64, SectionProperties)>,
    ) -> Result<(), Refused> {
        let half_m = 0.5 * (inner.0 + outer.0);
        let half = self.at(half_m)?;
        if halvings == 0 || is_between(inner.1, &half, outer.1) {
            return Ok(());
        }
        self.refine(inner, (half_m, &half), halvings - 1, stations)?;
        stations.push((half_m, half.clone()));
        self.refine((half_m, &half), outer, halvings - 1, stations)
    }

    /// Section law along a body of `length_m`.
    ///
    /// # Errors
    /// As for [`Shape::at`].
    pub fn law(&self, length_m: f64) -> Result<SectionLaw, Refused> {
        let stations = self.stations(length_m)?;
        if let [(_, only)] = stations.as_slice() {
            return Ok(only.section().into());
        }
        let station = |(position_m, properties): (f64, SectionProperties)| SectionStation {
            position_m,
            section: properties.section(),
        };
        Ok(SectionLaw::Table(stations.into_iter().map(station).collect()))
    }
}

/// Returns whether a section is close to the mean of two others.
fn is_between(inner: &SectionProperties, half: &SectionProperties, outer: &SectionProperties) -> bool {
    let mean = inner.section().towards(&outer.section(), 0.5);
    let own = half.section();
    let near = |a: f64, b: f64, scale: f64| (a - b).abs() <= STATION_ERROR * scale;
    let stiffness = (0..own.stiffness.nrows()).all(|i| {
        (0..own.stiffness.ncols()).all(|j| {
            let scale = (own.stiffness[(i, i)] * own.stiffness[(j, j)]).sqrt();
            near(own.stiffness[(i, j)], mean.stiffness[(i, j)], scale)
        })
    });
    let second = own.second_moment_kg_m[0] + own.second_moment_kg_m[2];
    stiffness
        && near(own.mass_kg_m, mean.mass_kg_m, own.mass_kg_m)
        && (0..3).all(|i| near(own.second_moment_kg_m[i], mean.second_moment_kg_m[i], second))
}

impl ProfileShape {
    fn at(&self, s_m: f64) -> Result<super::properties::Raw, Refused> {
        let (chord_m, skin_m) = (self.chord.at(s_m)?, self.skin.at(s_m)?);
        let spar = |(name, position, wall, material): &(String, f64, Dimension, Material)| {
            wall.at(s_m)
                .map(|wall_m| Spar { name: name.clone(), position: *position, wall_m, material: *material })
                .map_err(|refused| Refused {
                    key: vec!["spar".to_owned(), name.clone(), wall.key.to_owned()],
                    ..refused
                })
        };
        let spars = self.spars.iter().map(spar).collect::<Result<Vec<_>, _>>()?;
        airfoil::profile(&self.outline, chord_m, skin_m, &self.material, &spars, self.side).map_err(|misfit| {
            let of_spar = |index: usize, allowed: String| Refused {
                key: vec!["spar".to_owned(), spars[index].name.clone(), "position".to_owned()],
                position_m: s_m,
                value: Some(spars[index].position),
                found: None,
                allowed,
            };
            match misfit {
                Misfit::Open(gap) => Refused::state(
                    self.outline_key,
                    s_m,
                    format!("an outline that is not closed: its ends are {} of the chord apart", short(gap)),
                    format!("first and last point at the trailing edge, at most {LARGEST_GAP} of the chord apart"),
                ),
                Misfit::Tangled => Refused::state(
                    self.outline_key,
                    s_m,
                    "an outline that crosses itself or has no area",
                    "points [x, z] in order from the trailing edge over one side to the leading edge and back along the other",
                ),
                Misfit::ThickSkin(thickness_m) => Refused::value(
                    self.skin.key,
                    s_m,
                    skin_m,
                    format!(
                        "a skin < {} m, the largest that fits into this outline at chord_m = {}; a solid section has \
                         shape = \"explicit\"",
                        short(thickness_m.min(skin_m)),
                        shortest(chord_m)
                    ),
                ),
                Misfit::Outside(index, [nose, tail]) => of_spar(
                    index,
                    format!("a fraction of the chord between {} and {}, so that the spar lies inside the skin", short(nose), short(tail)),
                ),
                Misfit::Coincident(index) => of_spar(index, "a position that no other spar occupies".to_owned()),
            }
        })
    }
}

/// Formats four digits.
fn short(value: f64) -> String {
    format!("{value:.3e}").parse().map_or_else(|_| shortest(value), shortest)
}

/// Error for a laminate whose couplings involve strains that a beam does not have.
fn coupled(coupling: Coupling, s_m: f64) -> Refused {
    let (found, allowed) = match coupling {
        Coupling::Stretch => (
            "an unbalanced laminate, which shears in its plane when it is stretched",
            "for each ply at an angle a ply of the same material and thickness at the opposite angle, because coupling \
             with in-plane shear is not modelled",
        ),
        Coupling::OutOfPlane => (
            "a laminate whose bending or twist is coupled with shear in its plane",
            "plies at angles other than 0 and 90 deg symmetric about the mid-plane (symmetric = true), because \
             coupling with in-plane shear is not modelled",
        ),
    };
    Refused::state("layup_deg", s_m, found, allowed)
}
