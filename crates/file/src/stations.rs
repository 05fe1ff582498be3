//! Functions along a body given at stations: section properties, points of the axis.

use crate::checker::Checker;
use foldwing_engine::beam::axis::Axis;
use foldwing_engine::beam::section::{Section, expanded};
use foldwing_engine::machine::units::shortest;
use foldwing_engine::machine::validate::section::{are_second_moments, is_positive_definite, is_sound};
use foldwing_engine::math::strain::{EDGE, FLAP, STRAINS, STRETCH, Strain, StrainMatrix, TWIST};
use nalgebra::SMatrix;
use schemars::JsonSchema;
use serde::Deserialize;

/// Maximum number of sections in a table, and of points of an axis.
pub(super) const MAXIMUM_STATIONS: usize = 1000;

/// Positions along a body.
pub(super) enum Places {
    /// As fractions of the length, from 0 to 1.
    Shares(Vec<f64>),
    /// As distances in m from the inner end.
    Lengths(Vec<f64>),
}

/// Sections along a body.
pub(super) struct Stations {
    /// Positions of the sections.
    pub places: Places,
    /// Sections at these positions.
    pub sections: Vec<Section>,
}

/// Maximum relative difference between the last position and the length of a body that is attributed to rounding, such as that of a
/// typed length compared with an arc length integrated from a file of points.
const ROUNDED: f64 = 1e-4;

impl Places {
    /// Positions in m from the inner end of a body of `length_m`. Distances that end within [`ROUNDED`] of it are scaled so that the
    /// last position is the end; otherwise the error is the last distance.
    pub fn on_body(&self, length_m: f64) -> Result<Vec<f64>, f64> {
        let (places, last) = match self {
            Self::Shares(shares) => (shares, 1.0),
            Self::Lengths(lengths_m) => (lengths_m, lengths_m.last().copied().unwrap_or_default()),
        };
        let ends = matches!(self, Self::Shares(_)) || (last - length_m).abs() <= ROUNDED * length_m;
        if !ends {
            return Err(last);
        }
        let mut places_m: Vec<f64> = places.iter().map(|place| place * (length_m / last)).collect();
        if let Some(end_m) = places_m.last_mut() {
            *end_m = length_m;
        }
        Ok(places_m)
    }

    fn count(&self) -> usize {
        match self {
            Self::Shares(places) | Self::Lengths(places) => places.len(),
        }
    }
}

/// Section properties at stations along a body: arrays of equal length. Stiffness is about the tension centre, moments
/// of mass are about the centre of mass.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SectionsAlong {
    /// Positions of the stations as fractions of the body's length, ascending from 0 to 1.
    #[schemars(extend("x-allowed" = "an array of 2 to 1000 finite numbers from 0 to 1"))]
    pub eta: Option<Vec<f64>>,
    /// Positions of the stations in m from the inner end, ascending from 0 to the body's length; instead of `eta`.
    #[schemars(extend("x-allowed" = "an array of 2 to 1000 finite lengths in m"))]
    pub s_m: Option<Vec<f64>>,
    /// Axial stiffness `EA`.
    #[serde(rename = "axial_stiffness_N")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub axial_stiffness_n: Vec<f64>,
    /// Torsional rigidity `GJ`.
    #[serde(rename = "torsional_rigidity_N_m2")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub torsional_rigidity_n_m2: Vec<f64>,
    /// Flapwise bending stiffness `EI_y`, about `y`.
    #[serde(rename = "flap_stiffness_N_m2")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub flap_stiffness_n_m2: Vec<f64>,
    /// Edgewise bending stiffness `EI_z`, about `z`.
    #[serde(rename = "edge_stiffness_N_m2")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub edge_stiffness_n_m2: Vec<f64>,
    /// Coupling of stretch and twist, default 0.
    #[serde(rename = "coupling_axial_twist_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_axial_twist_n_m: Option<Vec<f64>>,
    /// Coupling of stretch and curvature about `y`, default 0.
    #[serde(rename = "coupling_axial_flap_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_axial_flap_n_m: Option<Vec<f64>>,
    /// Coupling of stretch and curvature about `z`, default 0.
    #[serde(rename = "coupling_axial_edge_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_axial_edge_n_m: Option<Vec<f64>>,
    /// Coupling of twist and curvature about `y` (bend–twist), default 0.
    #[serde(rename = "coupling_twist_flap_N_m2")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_twist_flap_n_m2: Option<Vec<f64>>,
    /// Coupling of twist and curvature about `z`, default 0.
    #[serde(rename = "coupling_twist_edge_N_m2")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_twist_edge_n_m2: Option<Vec<f64>>,
    /// Coupling of the two curvatures, default 0.
    #[serde(rename = "coupling_flap_edge_N_m2")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_flap_edge_n_m2: Option<Vec<f64>>,
    /// Shear stiffness `GAy` along `y`; required by `shear = true`, with that along `z`. The stiffnesses above are those without shear
    /// forces.
    #[serde(rename = "shear_stiffness_y_N")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub shear_stiffness_y_n: Option<Vec<f64>>,
    /// Shear stiffness `GAz` along `z`.
    #[serde(rename = "shear_stiffness_z_N")]
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub shear_stiffness_z_n: Option<Vec<f64>>,
    /// Coupling of the two shears, default 0.
    #[serde(rename = "coupling_shear_y_shear_z_N")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_y_shear_z_n: Option<Vec<f64>>,
    /// Coupling of the shear along `y` and stretch, default 0.
    #[serde(rename = "coupling_shear_y_axial_N")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_y_axial_n: Option<Vec<f64>>,
    /// Coupling of the shear along `y` and twist, default 0.
    #[serde(rename = "coupling_shear_y_twist_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_y_twist_n_m: Option<Vec<f64>>,
    /// Coupling of the shear along `y` and curvature about `y`, default 0.
    #[serde(rename = "coupling_shear_y_flap_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_y_flap_n_m: Option<Vec<f64>>,
    /// Coupling of the shear along `y` and curvature about `z`, default 0.
    #[serde(rename = "coupling_shear_y_edge_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_y_edge_n_m: Option<Vec<f64>>,
    /// Coupling of the shear along `z` and stretch, default 0.
    #[serde(rename = "coupling_shear_z_axial_N")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_z_axial_n: Option<Vec<f64>>,
    /// Coupling of the shear along `z` and twist, default 0.
    #[serde(rename = "coupling_shear_z_twist_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_z_twist_n_m: Option<Vec<f64>>,
    /// Coupling of the shear along `z` and curvature about `y`, default 0.
    #[serde(rename = "coupling_shear_z_flap_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_z_flap_n_m: Option<Vec<f64>>,
    /// Coupling of the shear along `z` and curvature about `z`, default 0.
    #[serde(rename = "coupling_shear_z_edge_N_m")]
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub coupling_shear_z_edge_n_m: Option<Vec<f64>>,
    /// `y` of the tension centre from the beam axis, default 0.
    #[schemars(extend("x-allowed" = "an array of finite lengths in m, one per station"))]
    pub tension_centre_y_m: Option<Vec<f64>>,
    /// `z` of the tension centre from the beam axis, default 0.
    #[schemars(extend("x-allowed" = "an array of finite lengths in m, one per station"))]
    pub tension_centre_z_m: Option<Vec<f64>>,
    /// Mass per length.
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub mass_kg_m: Vec<f64>,
    /// `y` of the centre of mass from the beam axis, default 0.
    #[schemars(extend("x-allowed" = "an array of finite lengths in m, one per station"))]
    pub centre_of_mass_y_m: Option<Vec<f64>>,
    /// `z` of the centre of mass from the beam axis, default 0.
    #[schemars(extend("x-allowed" = "an array of finite lengths in m, one per station"))]
    pub centre_of_mass_z_m: Option<Vec<f64>>,
    /// Second moment of mass per length `∫ρy² dA` about the centre of mass.
    #[schemars(extend("x-allowed" = "an array of numbers >= 0, one per station"))]
    pub second_moment_yy_kg_m: Vec<f64>,
    /// Mixed moment of mass per length `∫ρyz dA` about the centre of mass, default 0.
    #[schemars(extend("x-allowed" = "an array of finite numbers, one per station"))]
    pub second_moment_yz_kg_m: Option<Vec<f64>>,
    /// Second moment of mass per length `∫ρz² dA` about the centre of mass.
    #[schemars(extend("x-allowed" = "an array of numbers >= 0, one per station"))]
    pub second_moment_zz_kg_m: Vec<f64>,
    /// Largest `|y|` of the outline; required by strain gauges.
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub half_width_m: Option<Vec<f64>>,
    /// Largest `|z|` of the outline; required by strain gauges.
    #[schemars(extend("x-allowed" = "an array of numbers > 0, one per station"))]
    pub half_height_m: Option<Vec<f64>>,
}

/// Points of a body's unloaded axis, with the twist of its sections there: arrays of equal length. Interpolation by
/// natural cubic splines over the arc length.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AxisAlong {
    /// Positions of the points as fractions of the body's arc length, ascending from 0 to 1.
    #[schemars(extend("x-allowed" = "an array of 2 to 1000 finite numbers from 0 to 1"))]
    pub eta: Option<Vec<f64>>,
    /// Arc lengths of the points in m, ascending from 0 to the body's length; instead of `eta`.
    #[schemars(extend("x-allowed" = "an array of 2 to 1000 finite lengths in m"))]
    pub s_m: Option<Vec<f64>>,
    /// Coordinates along the body's `y`, 0 at the inner end. Default 0: a straight axis.
    #[schemars(extend("x-allowed" = "an array of finite lengths in m, one per point"))]
    pub y_m: Option<Vec<f64>>,
    /// Coordinates along the body's `z`, 0 at the inner end. Default 0: a straight axis.
    #[schemars(extend("x-allowed" = "an array of finite lengths in m, one per point"))]
    pub z_m: Option<Vec<f64>>,
    /// Rotations of the sections about the axis, right-handed, including the first. Default 0.
    #[schemars(extend("x-allowed" = "an array of finite numbers in deg, one per point"))]
    pub twist_deg: Option<Vec<f64>>,
}

/// Positions that ascend from 0; any others are an error at `path`.
fn places(path: &[&str], eta: Option<&Vec<f64>>, s_m: Option<&Vec<f64>>, checker: &mut Checker) -> Option<Places> {
    let at = |key| [path, &[key]].concat();
    let (key, values) = match (eta, s_m) {
        (Some(values), None) => ("eta", values),
        (None, Some(values)) => ("s_m", values),
        (Some(_), Some(_)) => {
            checker.refuse(&at("s_m"), "either eta or s_m, not both");
            return None;
        }
        (None, None) => {
            checker.refuse(&at("eta"), "eta, positions as fractions of the length from 0 to 1, or s_m, positions in m");
            return None;
        }
    };
    let fine = (2..=MAXIMUM_STATIONS).contains(&values.len())
        && values.windows(2).all(|pair| pair[0] < pair[1])
        && values.first() == Some(&0.0)
        && (key == "s_m" || values.last() == Some(&1.0));
    if !fine {
        let end = if key == "eta" { "from 0 to 1" } else { "from 0 to the length of the body" };
        let found = match values.windows(2).find(|pair| pair[0] >= pair[1]) {
            Some(pair) => format!("{} after {}", shortest(pair[1]), shortest(pair[0])),
            None => match (values.first(), values.last()) {
                (Some(first), Some(last)) => {
                    format!("{} positions from {} to {}", values.len(), shortest(*first), shortest(*last))
                }
                _ => "no positions".to_owned(),
            },
        };
        checker.refuse_as(&at(key), found, format!("2 to {MAXIMUM_STATIONS} positions that ascend {end}"));
        return None;
    }
    Some(if key == "eta" { Places::Shares(values.clone()) } else { Places::Lengths(values.clone()) })
}

impl SectionsAlong {
    /// Builds the sections; `None` after an error.
    pub fn stations(&self, name: &str, checker: &mut Checker) -> Option<Stations> {
        let path = ["section", name, "along"];
        let places = places(&path, self.eta.as_ref(), self.s_m.as_ref(), checker)?;
        let count = places.count();
        let at = |key: &'static str| ["section", name, "along", key];
        let mut sound = true;
        let mut column = |key: &'static str, values: Option<&Vec<f64>>, positive: bool| -> Vec<f64> {
            let Some(values) = values else { return vec![0.0; count] };
            if values.len() != count {
                let found = format!("an array of {}", values.len());
                checker.refuse_as(&at(key), found, format!("an array of {count} numbers, one per station"));
            } else if let Some(bad) = values.iter().find(|value| !value.is_finite() || positive && **value <= 0.0) {
                let allowed = if positive { "numbers > 0" } else { "finite numbers" };
                checker.refuse_as(&at(key), shortest(*bad), allowed);
            } else {
                return values.clone();
            }
            sound = false;
            vec![0.0; count]
        };
        // in the order of the strains
        let own: [Vec<f64>; STRAINS] = [
            column("axial_stiffness_N", Some(&self.axial_stiffness_n), true),
            column("torsional_rigidity_N_m2", Some(&self.torsional_rigidity_n_m2), true),
            column("flap_stiffness_N_m2", Some(&self.flap_stiffness_n_m2), true),
            column("edge_stiffness_N_m2", Some(&self.edge_stiffness_n_m2), true),
        ];
        let couplings = [
            ((STRETCH, TWIST), column("coupling_axial_twist_N_m", self.coupling_axial_twist_n_m.as_ref(), false)),
            ((STRETCH, FLAP), column("coupling_axial_flap_N_m", self.coupling_axial_flap_n_m.as_ref(), false)),
            ((STRETCH, EDGE), column("coupling_axial_edge_N_m", self.coupling_axial_edge_n_m.as_ref(), false)),
            ((TWIST, FLAP), column("coupling_twist_flap_N_m2", self.coupling_twist_flap_n_m2.as_ref(), false)),
            ((TWIST, EDGE), column("coupling_twist_edge_N_m2", self.coupling_twist_edge_n_m2.as_ref(), false)),
            ((FLAP, EDGE), column("coupling_flap_edge_N_m2", self.coupling_flap_edge_n_m2.as_ref(), false)),
        ];
        let shears = [
            column("shear_stiffness_y_N", self.shear_stiffness_y_n.as_ref(), true),
            column("shear_stiffness_z_N", self.shear_stiffness_z_n.as_ref(), true),
            column("coupling_shear_y_shear_z_N", self.coupling_shear_y_shear_z_n.as_ref(), false),
        ];
        // in the order of the strains
        let mixed = [
            [
                column("coupling_shear_y_axial_N", self.coupling_shear_y_axial_n.as_ref(), false),
                column("coupling_shear_y_twist_N_m", self.coupling_shear_y_twist_n_m.as_ref(), false),
                column("coupling_shear_y_flap_N_m", self.coupling_shear_y_flap_n_m.as_ref(), false),
                column("coupling_shear_y_edge_N_m", self.coupling_shear_y_edge_n_m.as_ref(), false),
            ],
            [
                column("coupling_shear_z_axial_N", self.coupling_shear_z_axial_n.as_ref(), false),
                column("coupling_shear_z_twist_N_m", self.coupling_shear_z_twist_n_m.as_ref(), false),
                column("coupling_shear_z_flap_N_m", self.coupling_shear_z_flap_n_m.as_ref(), false),
                column("coupling_shear_z_edge_N_m", self.coupling_shear_z_edge_n_m.as_ref(), false),
            ],
        ];
        let tension_y_m = column("tension_centre_y_m", self.tension_centre_y_m.as_ref(), false);
        let tension_z_m = column("tension_centre_z_m", self.tension_centre_z_m.as_ref(), false);
        let mass_kg_m = column("mass_kg_m", Some(&self.mass_kg_m), true);
        let centre_y_m = column("centre_of_mass_y_m", self.centre_of_mass_y_m.as_ref(), false);
        let centre_z_m = column("centre_of_mass_z_m", self.centre_of_mass_z_m.as_ref(), false);
        let yy = column("second_moment_yy_kg_m", Some(&self.second_moment_yy_kg_m), false);
        let yz = column("second_moment_yz_kg_m", self.second_moment_yz_kg_m.as_ref(), false);
        let zz = column("second_moment_zz_kg_m", Some(&self.second_moment_zz_kg_m), false);
        let half_width_m = column("half_width_m", self.half_width_m.as_ref(), true);
        let half_height_m = column("half_height_m", self.half_height_m.as_ref(), true);
        if self.half_width_m.is_some() != self.half_height_m.is_some() {
            let missing = if self.half_width_m.is_none() { "half_width_m" } else { "half_height_m" };
            checker.refuse(&at(missing), "half_width_m and half_height_m together, or neither");
            return None;
        }
        if !sound {
            return None;
        }
        let mut sections = Vec::with_capacity(count);
        for i in 0..count {
            let mut centred = StrainMatrix::<STRAINS>::from_diagonal(&Strain::from_fn(|strain, _| own[strain][i]));
            for ((row, column), values) in &couplings {
                centred[(*row, *column)] = values[i];
                centred[(*column, *row)] = values[i];
            }
            let stiffness = about_axis(&centred, [tension_y_m[i], tension_z_m[i]]);
            let (mass, y, z) = (mass_kg_m[i], centre_y_m[i], centre_z_m[i]);
            let shear = (self.shear_stiffness_y_n.is_some() && self.shear_stiffness_z_n.is_some()).then(|| {
                let [y, z, yz] = [shears[0][i], shears[1][i], shears[2][i]];
                expanded(
                    &stiffness,
                    &[[y, yz], [yz, z]].into(),
                    &SMatrix::from_fn(|shear, strain| mixed[shear][strain][i]),
                )
            });
            let section = Section {
                stiffness,
                shear: shear.flatten(),
                mass_kg_m: mass,
                first_moment_kg: [mass * y, mass * z],
                second_moment_kg_m: [yy[i] + mass * y * y, yz[i] + mass * y * z, zz[i] + mass * z * z],
                half_width_m: half_width_m[i],
                half_height_m: half_height_m[i],
            };
            let (key, found, allowed) = if section.shear.is_some_and(|whole| !is_positive_definite(&whole)) {
                let found = "a stiffness with shear that is not positive definite".to_owned();
                (
                    "shear_stiffness_y_N",
                    found,
                    "shear stiffnesses and couplings that leave the stiffness matrix \
                                                positive definite",
                )
            } else if !are_second_moments([yy[i], yz[i], zz[i]]) {
                let found = format!("[{}, {}, {}]", shortest(yy[i]), shortest(yz[i]), shortest(zz[i]));
                ("second_moment_yy_kg_m", found, "moments yy >= 0, zz >= 0, yy + zz > 0 and yz² <= yy zz")
            } else if !is_positive_definite(&stiffness) {
                (
                    "axial_stiffness_N",
                    "a stiffness that is not positive definite".to_owned(),
                    "couplings that leave the stiffness matrix positive definite",
                )
            } else if !is_sound(&section) {
                (
                    "mass_kg_m",
                    "a section".to_owned(),
                    "mass, inertia and stiffness that are positive, finite numbers in SI",
                )
            } else {
                sections.push(section);
                continue;
            };
            checker.refuse_as(&at(key), format!("{found} at station {}", i + 1), allowed);
            return None;
        }
        Some(Stations { places, sections })
    }
}

/// Stiffness about the beam axis of a section whose stiffness is given about its tension centre `[y, z]`: the stretch there is `εx + z
/// κy − y κz`, NOTATION eqs. (K7), (S9).
fn about_axis(centred: &StrainMatrix, [y_m, z_m]: [f64; 2]) -> StrainMatrix {
    if y_m == 0.0 && z_m == 0.0 {
        return *centred;
    }
    let mut shift = StrainMatrix::<STRAINS>::identity();
    (shift[(STRETCH, FLAP)], shift[(STRETCH, EDGE)]) = (z_m, -y_m);
    shift.transpose() * centred * shift
}

impl AxisAlong {
    /// Builds the axis of a body of `length_m`; `None` after an error.
    pub fn on_body(&self, name: &str, length_m: f64, checker: &mut Checker) -> Option<Axis> {
        let path = ["body", name, "axis"];
        let places = places(&path, self.eta.as_ref(), self.s_m.as_ref(), checker)?;
        let stations_m = match places.on_body(length_m) {
            Ok(stations_m) => stations_m,
            Err(last_m) => {
                let allowed = format!("{} m, the arc length of the axis", shortest(last_m));
                checker.refuse(&["body", name, "length_m"], allowed);
                return None;
            }
        };
        let mut sound = true;
        let mut column = |key: &'static str, values: Option<&Vec<f64>>, factor: f64| -> Vec<f64> {
            let Some(values) = values else { return vec![0.0; stations_m.len()] };
            let (found, allowed) = if values.len() != stations_m.len() {
                let allowed = format!("an array of {} numbers, one per point", stations_m.len());
                (format!("an array of {}", values.len()), allowed)
            } else if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
                (shortest(*bad), "finite numbers".to_owned())
            } else if key != "twist_deg" && values[0] != 0.0 {
                (shortest(values[0]), "0 at the inner end, where the body is attached to its joint".to_owned())
            } else {
                return values.iter().map(|value| value * factor).collect();
            };
            checker.refuse_as(&["body", name, "axis", key], found, allowed);
            sound = false;
            vec![0.0; stations_m.len()]
        };
        let y_m = column("y_m", self.y_m.as_ref(), 1.0);
        let z_m = column("z_m", self.z_m.as_ref(), 1.0);
        let twist_rad = column("twist_deg", self.twist_deg.as_ref(), 1f64.to_radians());
        sound.then_some(Axis { stations_m: stations_m.clone(), y_m, z_m, twist_rad })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An axis of 20.0019 m on a body of 20 m formerly ended at 20.0019 m, beyond the end of the body.
    #[test]
    fn rounded_lengths_end_at_the_end_of_the_body() {
        let places = |last_m: f64| Places::Lengths(vec![0.0, 10.0, last_m]).on_body(20.0);
        assert_eq!(places(20.0), Ok(vec![0.0, 10.0, 20.0]));
        let scaled = places(20.0019).expect("as many digits as somebody types");
        assert_eq!(scaled[2], 20.0);
        assert!((scaled[1] - 10.0 * 20.0 / 20.0019).abs() < 1e-14, "{scaled:?}");
        assert_eq!(places(20.0021), Err(20.0021));
        assert_eq!(Places::Shares(vec![0.0, 0.5, 1.0]).on_body(20.0), Ok(vec![0.0, 10.0, 20.0]));
    }
}
