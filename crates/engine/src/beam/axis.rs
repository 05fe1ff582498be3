//! Unloaded axis of a curved and twisted body, given by points.

use crate::beam::law::NaturalStrain;
use crate::beam::profile::Profile;
use crate::math::quadrature::gauss_pieces;
use crate::math::spline::CubicSpline;
use crate::math::strain::STRAINS;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Points of a body's unloaded axis in the body's frame, and the twist of its sections there; NOTATION eqs. (S10), (S11).
///
/// | symbol | field        | shape | unit |
/// |--------|--------------|-------|------|
/// | `s_j`  | `stations_m` | n     | m, arc length from the inner end, ascending from 0 to the length |
/// | `y_j`, `z_j` | `y_m`, `z_m` | n | m, 0 at the inner end |
/// | `ϑ_j`  | `twist_rad`  | n     | rad, right-handed about the axis |
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Arc lengths of the points.
    pub stations_m: Vec<f64>,
    /// Lateral coordinates along the body's `y`.
    pub y_m: Vec<f64>,
    /// Lateral coordinates along the body's `z`.
    pub z_m: Vec<f64>,
    /// Angles of the sections about the axis.
    pub twist_rad: Vec<f64>,
}

/// Error for an axis whose slope is too large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TooSteep {
    /// Arc length in m at which the slope relative to `x` reaches 1: the points are further apart than the arc length between them.
    pub position_m: f64,
}

/// Natural strain of an axis, and the ends of the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct NaturalShape {
    /// Twist and curvatures along the axis.
    pub strain: NaturalStrain,
    /// Ends of the axis.
    pub ends: AxisEnds,
}

/// Ends of an unloaded axis in the body's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisEnds {
    /// Attitude of the first section: body ← section.
    pub first: Matrix3<f64>,
    /// Position of the outer end relative to the inner end in m.
    pub outer_m: Vector3<f64>,
}

impl Axis {
    /// Computes curvatures and ends from natural cubic splines through the points. In every interval between stations the curvatures are
    /// cubics through their exact values at four positions; those of a straight axis are exact.
    ///
    /// # Errors
    /// If the slope of the splines relative to `x` reaches 1, so that no length along `x` remains: the position.
    pub fn natural_shape(&self) -> Result<NaturalShape, TooSteep> {
        let splines = [&self.y_m, &self.z_m, &self.twist_rad].map(|values| CubicSpline::new(&self.stations_m, values));
        let [y, z, twist] = &splines;
        let straight = [&self.y_m, &self.z_m].iter().all(|values| values.iter().all(|value| *value == 0.0));
        let untwisted = self.twist_rad.iter().all(|angle| *angle == self.twist_rad[0]);
        let first = section_at(0.0, [y, z, twist])?;
        let length_m = self.stations_m[self.stations_m.len() - 1];
        let mut ends = AxisEnds { first: first.attitude, outer_m: Vector3::x() * length_m };
        if straight && untwisted {
            return Ok(NaturalShape { strain: NaturalStrain::from([0.0; STRAINS]), ends });
        }
        if !straight {
            ends.outer_m = Vector3::new(0.0, y.at(length_m), z.at(length_m));
            for (s_m, weight) in gauss_pieces(0.0, length_m, &self.stations_m) {
                ends.outer_m.x += section_at(s_m, [y, z, twist])?.attitude[(0, 0)] * weight;
            }
        }
        let mut pieces = [const { Vec::new() }; 3];
        for pair in self.stations_m.windows(2) {
            let length_m = pair[1] - pair[0];
            let mut values = [Vector3::zeros(); 4];
            for (i, value) in values.iter_mut().enumerate() {
                *value = section_at(pair[0] + length_m * i as f64 / 3.0, [y, z, twist])?.curvature_1_m;
            }
            for (component, pieces) in pieces.iter_mut().enumerate() {
                let [a, b, c, d] = values.map(|value| value[component]);
                pieces.push(cubic_through(pair[0], length_m, [a, b, c, d]));
            }
        }
        let curvature_1_m = pieces.map(|pieces| match pieces.iter().all(|piece| piece[1..] == [0.0; 4]) {
            true => Profile::constant(0.0),
            false => Profile::Pieces(pieces),
        });
        Ok(NaturalShape { strain: NaturalStrain::curved(curvature_1_m), ends })
    }
}

/// Position, attitude and curvature of a section of the axis.
struct AxisSection {
    attitude: Matrix3<f64>,
    curvature_1_m: Vector3<f64>,
}

/// Section whose `x` is the tangent: rotated from the body's frame by the smallest rotation and then by the twist; with its curvature in
/// its own frame, NOTATION eq. (S11).
fn section_at(s_m: f64, [y, z, twist]: [&CubicSpline; 3]) -> Result<AxisSection, TooSteep> {
    let ([y1, y2], [z1, z2]) = (y.slopes(s_m), z.slopes(s_m));
    let x1 = (1.0 - y1 * y1 - z1 * z1).max(0.0).sqrt();
    if x1 < 1e-3 {
        return Err(TooSteep { position_m: s_m });
    }
    let tangent = Vector3::new(x1, y1, z1);
    let bend = Vector3::new(-(y1 * y2 + z1 * z2) / x1, y2, z2);
    let across = tangent.cross(&bend);
    let spin = across - tangent * (across.x / (1.0 + x1)) + tangent * twist.slopes(s_m)[0];
    let tilt = Rotation3::rotation_between(&Vector3::x(), &tangent).unwrap_or_default();
    let attitude = (tilt * Rotation3::from_axis_angle(&Vector3::x_axis(), twist.at(s_m))).into_inner();
    Ok(AxisSection { attitude, curvature_1_m: attitude.transpose() * spin })
}

/// Coefficients `[start, c0, c1, c2, c3]` of the cubic through values at 0, ⅓, ⅔ and 1 of an interval.
fn cubic_through(start_m: f64, length_m: f64, [a, b, c, d]: [f64; 4]) -> [f64; 5] {
    let first = -5.5 * a + 9.0 * b - 4.5 * c + d;
    let second = 9.0 * a - 22.5 * b + 18.0 * c - 4.5 * d;
    let third = -4.5 * a + 13.5 * b - 13.5 * c + 4.5 * d;
    [start_m, a, first / length_m, second / length_m.powi(2), third / length_m.powi(3)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::strain::CURVATURES;

    fn bent() -> Axis {
        let stations_m: Vec<f64> = (0..=20).map(|i| 0.5 * f64::from(i)).collect();
        let along = |f: &dyn Fn(f64) -> f64| stations_m.iter().map(|s| f(*s)).collect();
        Axis {
            y_m: along(&|s| 0.02 * s * s),
            z_m: along(&|s| 0.3 * (0.4 * s).sin() + 0.1 * s),
            twist_rad: along(&|s| 0.3 - 0.05 * s),
            stations_m: stations_m.clone(),
        }
    }

    /// Integrating the strain from the first section reproduces the points and the twist.
    #[test]
    fn strain_leads_back_to_the_points() {
        let axis = bent();
        let shape = axis.natural_shape().unwrap();
        let (mut attitude, mut position_m) = (shape.ends.first, Vector3::zeros());
        let steps = 20_000;
        let step_m = 10.0 / f64::from(steps);
        for i in 0..steps {
            let strain = shape.strain.at(step_m * (f64::from(i) + 0.5));
            let half = Rotation3::new(Vector3::from_column_slice(&strain.as_slice()[CURVATURES]) * (0.5 * step_m))
                .into_inner();
            let middle = attitude * half;
            position_m += middle.column(0) * step_m;
            attitude = middle * half;
        }
        let splines = [&axis.y_m, &axis.z_m, &axis.twist_rad].map(|values| CubicSpline::new(&axis.stations_m, values));
        let end = section_at(10.0, [&splines[0], &splines[1], &splines[2]]).unwrap();
        // the error of the cubics for the curvature is of fourth order in the intervals
        assert!((attitude - end.attitude).amax() < 1e-6, "{}", attitude - end.attitude);
        let tip = Vector3::new(position_m.x, axis.y_m[20], axis.z_m[20]);
        assert!((position_m - tip).amax() < 2e-6, "{position_m} {tip}");
        assert!((position_m - shape.ends.outer_m).amax() < 2e-6);
        assert!(position_m.x < 9.99, "an arc is longer than what it spans");
    }

    #[test]
    fn straight_axes_have_no_curvature_and_steep_ones_are_refused() {
        let mut axis = bent();
        axis.y_m.fill(0.0);
        axis.z_m.fill(0.0);
        axis.twist_rad.fill(0.25);
        let shape = axis.natural_shape().unwrap();
        assert_eq!(shape.strain, NaturalStrain::from([0.0; STRAINS]));
        assert_eq!(shape.ends.first, Rotation3::from_axis_angle(&Vector3::x_axis(), 0.25).into_inner());
        axis.y_m = axis.stations_m.iter().map(|s| 1.2 * s).collect();
        assert_eq!(axis.natural_shape(), Err(TooSteep { position_m: 0.0 }));
    }
}
