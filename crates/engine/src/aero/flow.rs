//! The undisturbed air: wind, gusts and density in a root frame that may rotate.

use crate::aero::continuous_turbulence::Series;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::sync::Arc;

/// The undisturbed air at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow<'a> {
    /// Absolute time in s, on which gusts depend.
    pub time_s: f64,
    /// Density in kg/m³.
    pub density_kg_m3: f64,
    /// Velocity of the air relative to the origin of the root frame, root frame, m/s.
    pub wind_m_s: Vector3<f64>,
    /// Angular velocity of the root frame, root frame, rad/s.
    pub spin_rad_s: Vector3<f64>,
    /// Gusts.
    pub gusts: &'a [Gust],
}

impl Flow<'_> {
    /// Velocity of the air at a point relative to the root frame, in m/s: wind and gusts minus `ω × r`.
    pub fn velocity_m_s(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        let gusts: Vector3<f64> = self.gusts.iter().map(|gust| gust.velocity_m_s(self.time_s, point_m)).sum();
        self.convection_m_s(point_m) + gusts
    }

    /// Velocity of the air at a point without gusts, in m/s: the convection velocity of the wake.
    pub fn convection_m_s(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.wind_m_s - self.spin_rad_s.cross(point_m)
    }

    /// Velocity of the gusts at a point, in m/s.
    pub fn gust_m_s(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.velocity_m_s(point_m) - self.convection_m_s(point_m)
    }
}

/// Path of undisturbed air over a step in the root frame: `ẋ = w − ω × x` with constant `w` and `ω`, eq. (U5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirPath {
    rotation: Matrix3<f64>,
    shift_m: Vector3<f64>,
}

impl AirPath {
    /// Path over a step of `step_s` in s, with the wind and the rotation of `flow` held constant.
    pub fn new(flow: &Flow, step_s: f64) -> Self {
        let turn = -flow.spin_rad_s * step_s;
        let (angle, hat) = (turn.norm(), turn.cross_matrix());
        // (1 − cos φ)/φ² and (φ − sin φ)/φ³; below the limit the next terms of the series are below 1e-16
        let (a, b) = if angle < 1e-3 {
            let square = angle * angle;
            (0.5 - square * (1.0 / 24.0 - square / 720.0), 1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0))
        } else {
            let half_sine = (0.5 * angle).sin();
            (2.0 * half_sine * half_sine / (angle * angle), (angle - angle.sin()) / (angle * angle * angle))
        };
        let mean = Matrix3::identity() + a * hat + b * hat * hat;
        Self { rotation: Rotation3::new(turn).into_inner(), shift_m: mean * flow.wind_m_s * step_s }
    }

    /// Position at the end of the step, root frame, m, of the air that was at `begin_m` at its start.
    pub fn end_m(&self, begin_m: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * begin_m + self.shift_m
    }

    /// Rotates a vector, root frame, whose direction is fixed in the air, from the start of the step to its end.
    pub fn turned(&self, begin: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * begin
    }
}

/// A frozen gust that travels at constant speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Gust {
    /// Identifier.
    pub name: String,
    /// Shape along its path.
    pub shape: GustShape,
    /// Largest added velocity, root frame, m/s; for turbulence its standard deviation, for a table the velocity for a value of 1.
    pub velocity_m_s: Vector3<f64>,
    /// Unit vector of the direction of travel, root frame.
    pub direction: Vector3<f64>,
    /// Speed of travel in m/s.
    pub speed_m_s: f64,
    /// Point that the front passes at `start_s`, root frame, m.
    pub origin_m: Vector3<f64>,
    /// Time at which the front passes `origin_m`, in s.
    pub start_s: f64,
}

/// Shape of a gust as a function of the distance `ξ` behind its front.
#[derive(Debug, Clone, PartialEq)]
pub enum GustShape {
    /// Full velocity behind the front.
    SharpEdge,
    /// `(1 − cos(2πξ/H))/2` over the length `H` in m, zero elsewhere.
    OneMinusCosine {
        /// Length `H` in m.
        length_m: f64,
    },
    /// Table of fractions of the velocity, by ascending distance in m: linear between rows, 0 before the first, the last value beyond the
    /// last.
    Table(Arc<[[f64; 2]]>),
    /// Turbulence behind the front.
    Turbulence(Series),
}

impl Gust {
    /// Velocity added by the gust at a time and point, in m/s.
    pub fn velocity_m_s(&self, time_s: f64, point_m: &Vector3<f64>) -> Vector3<f64> {
        let behind_m = self.behind_m(time_s, point_m);
        let share = match &self.shape {
            GustShape::SharpEdge => f64::from(u8::from(behind_m > 0.0)),
            GustShape::OneMinusCosine { length_m } if behind_m > 0.0 && behind_m < *length_m => {
                0.5 * (1.0 - (std::f64::consts::TAU * behind_m / length_m).cos())
            }
            GustShape::OneMinusCosine { .. } => 0.0,
            GustShape::Table(rows) => in_table(rows, behind_m),
            GustShape::Turbulence(series) if behind_m > 0.0 => series.at(behind_m),
            GustShape::Turbulence(_) => 0.0,
        };
        self.velocity_m_s * share
    }

    /// Gradient of that velocity with respect to the point, for a shape without jumps and kinks; `None` for others.
    pub fn slope_1_s(&self, time_s: f64, point_m: &Vector3<f64>) -> Option<Matrix3<f64>> {
        let behind_m = self.behind_m(time_s, point_m);
        let slope_1_m = match &self.shape {
            GustShape::OneMinusCosine { length_m } if behind_m > 0.0 && behind_m < *length_m => {
                let wave_1_m = std::f64::consts::TAU / length_m;
                0.5 * wave_1_m * (wave_1_m * behind_m).sin()
            }
            GustShape::OneMinusCosine { .. } => 0.0,
            GustShape::SharpEdge | GustShape::Table(_) | GustShape::Turbulence(_) => return None,
        };
        Some(self.velocity_m_s * self.direction.transpose() * -slope_1_m)
    }

    /// Distance of a point behind the front in m.
    fn behind_m(&self, time_s: f64, point_m: &Vector3<f64>) -> f64 {
        self.speed_m_s * (time_s - self.start_s) - self.direction.dot(&(point_m - self.origin_m))
    }

    /// Whether the gust acts anywhere between some points at a time, however short it is.
    pub fn is_between(&self, time_s: f64, points_m: &[Vector3<f64>]) -> bool {
        let behind_m = points_m.iter().map(|point_m| self.behind_m(time_s, point_m));
        let [from_m, to_m] =
            behind_m.fold([f64::INFINITY, f64::NEG_INFINITY], |[from, to], own| [from.min(own), to.max(own)]);
        let blows = match &self.shape {
            GustShape::SharpEdge | GustShape::Turbulence(_) => to_m > 0.0,
            GustShape::OneMinusCosine { length_m } => to_m > 0.0 && from_m < *length_m,
            GustShape::Table(rows) => {
                let inside = rows.iter().any(|[place_m, share]| (from_m..=to_m).contains(place_m) && *share != 0.0);
                inside || [from_m, to_m].iter().any(|place_m| in_table(rows, *place_m) != 0.0)
            }
        };
        blows && !points_m.is_empty() && self.velocity_m_s != Vector3::zeros()
    }
}

/// Interpolated fraction of a table at a distance.
fn in_table(rows: &[[f64; 2]], distance_m: f64) -> f64 {
    let after = rows.partition_point(|row| row[0] <= distance_m);
    match (after.checked_sub(1).map(|before| rows[before]), rows.get(after)) {
        (None, _) => 0.0,
        (Some([_, share]), None) => share,
        (Some([begin_m, begin]), Some([end_m, end])) => {
            begin + (end - begin) * (distance_m - begin_m) / (end_m - begin_m)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::continuous_turbulence::{Component, ContinuousTurbulence, Spectrum};

    fn gust(shape: GustShape) -> Gust {
        Gust {
            name: "gust".into(),
            shape,
            velocity_m_s: Vector3::new(0.0, 0.0, 3.0),
            direction: -Vector3::y(),
            speed_m_s: 10.0,
            origin_m: Vector3::new(0.0, 1.0, 0.0),
            start_s: 0.5,
        }
    }

    #[test]
    fn gust_reaches_a_point_when_its_front_has_travelled_there() {
        let gust = gust(GustShape::SharpEdge);
        let point = Vector3::new(7.0, -1.0, 2.0); // 2 m behind the origin: 0.2 s later
        assert_eq!(gust.velocity_m_s(0.6999, &point), Vector3::zeros());
        assert_eq!(gust.velocity_m_s(0.7001, &point).z, 3.0);
    }

    #[test]
    fn a_gust_between_points_is_found_however_short_it_is() {
        let points = [Vector3::new(6.0, 0.0, 0.0), Vector3::new(8.0, -2.0, 0.0)];
        let peak = GustShape::Table([[0.0, 0.0], [0.01, 1.0], [0.02, 0.0]].into());
        for shape in [GustShape::OneMinusCosine { length_m: 0.02 }, peak] {
            let gust = gust(shape);
            // the front is between the points from 0.6 s to 0.8 s
            let between = [0.55, 0.7, 0.9].map(|time_s| gust.is_between(time_s, &points));
            assert_eq!(between, [false, true, false], "{:?}", gust.shape);
        }
        let edge = gust(GustShape::SharpEdge);
        assert_eq!([0.55, 0.7, 0.9].map(|time_s| edge.is_between(time_s, &points)), [false, true, true]);
        let none = Gust { velocity_m_s: Vector3::zeros(), ..edge };
        assert!(!none.is_between(0.7, &points));
    }

    #[test]
    fn one_minus_cosine_has_its_peak_in_the_middle_and_vanishes_outside() {
        let gust = gust(GustShape::OneMinusCosine { length_m: 4.0 });
        let at = |time_s: f64| gust.velocity_m_s(time_s, &Vector3::new(0.0, 1.0, 0.0)).z;
        assert_eq!((at(0.5), at(0.91)), (0.0, 0.0));
        approx::assert_relative_eq!(at(0.7), 3.0, max_relative = 1e-12);
        approx::assert_relative_eq!(at(0.6), 1.5, max_relative = 1e-12);
    }

    #[test]
    fn tables_are_linear_between_their_rows() {
        let gust = gust(GustShape::Table([[0.5, 0.0], [1.0, 2.0], [2.0, -1.0]].into()));
        let at = |behind_m: f64| gust.velocity_m_s(0.5 + behind_m / 10.0, &Vector3::new(0.0, 1.0, 0.0)).z;
        for (behind_m, share) in
            [(-1.0, 0.0), (0.2, 0.0), (0.75, 1.0), (1.0, 2.0), (1.5, 0.5), (2.0, -1.0), (9.0, -1.0)]
        {
            approx::assert_relative_eq!(at(behind_m), 3.0 * share, epsilon = 1e-12);
        }
    }

    #[test]
    fn turbulence_begins_at_its_front_and_travels() {
        let asked = ContinuousTurbulence {
            spectrum: Spectrum::Dryden,
            component: Component::Transverse,
            scale_m: 2.0,
            seed: 3,
            length_m: None,
            resolution_m: None,
        };
        let series = asked.series().unwrap();
        let gust = gust(GustShape::Turbulence(series.clone()));
        assert_eq!(gust.velocity_m_s(0.4, &Vector3::new(0.0, 1.0, 0.0)).z, 0.0);
        let here = gust.velocity_m_s(1.0, &Vector3::new(0.0, 1.0, 0.0)).z;
        approx::assert_relative_eq!(here, 3.0 * series.at(5.0), max_relative = 1e-9);
        approx::assert_relative_eq!(gust.velocity_m_s(1.3, &Vector3::new(0.0, -2.0, 0.0)).z, here, max_relative = 1e-9);
    }

    #[test]
    fn air_turns_backward_when_the_frame_turns_forward() {
        let flow = Flow {
            time_s: 0.0,
            density_kg_m3: 1.2,
            wind_m_s: Vector3::new(0.0, -10.0, 0.0),
            spin_rad_s: Vector3::z() * 2.0,
            gusts: &[],
        };
        assert_eq!(flow.velocity_m_s(&Vector3::x()), Vector3::new(0.0, -12.0, 0.0));
    }
}
