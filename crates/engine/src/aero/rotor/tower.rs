//! Influence of a tower on the wind around it: potential flow, and the shadow downwind.
//!
//! Sources: potential flow around a cylinder, with the wake of Bak, Madsen and Johansen, *Influence from blade-tower interaction on fatigue
//! loads and dynamics* (2001); the shadow of Powles, *The effects of tower shadow on the dynamics of a horizontal-axis wind turbine*, Wind
//! Engineering 7 (1983). AeroDyn offers the same options.

use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Downwind shift of the sources in Bak's model, in radii.
const BAK_SHIFT: f64 = 0.1;

/// Potential flow in front of the tower and at its sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Potential {
    /// Neglected.
    #[default]
    None,
    /// Cylinder in potential flow.
    Cylinder,
    /// Cylinder with a source that represents the wake due to its drag.
    Bak,
}

/// Flow downwind of the tower.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shadow {
    /// Neglected.
    #[default]
    None,
    /// Powles' cosine profile.
    Powles,
}

/// A straight tower, given by rows along its height.
#[derive(Debug, Clone, PartialEq)]
pub struct Tower {
    /// Position of the foot in m.
    pub base_m: Vector3<f64>,
    /// Unit vector from the foot to the top.
    pub up: Vector3<f64>,
    /// Rows from the foot up, heights ascending: height above the foot in m, diameter in m, drag coefficient.
    pub rows: Vec<[f64; 3]>,
    /// Model of the potential flow.
    pub potential: Potential,
    /// Model of the shadow.
    pub shadow: Shadow,
}

impl Tower {
    /// Change of the wind due to the tower at a point given in m, eqs. (B16) and (B17), in m/s. Zero above the top and below the foot;
    /// inside the tower it equals the value at the surface.
    pub fn added_m_s(&self, point_m: &Vector3<f64>, wind_m_s: &Vector3<f64>) -> Vector3<f64> {
        let from_foot_m = point_m - self.base_m;
        let height_m = from_foot_m.dot(&self.up);
        let Some([diameter_m, drag]) = self.row(height_m) else { return Vector3::zeros() };
        let across_m_s = wind_m_s - self.up * wind_m_s.dot(&self.up);
        let speed_m_s = across_m_s.norm();
        if speed_m_s == 0.0 || diameter_m <= 0.0 {
            return Vector3::zeros();
        }
        let along = across_m_s / speed_m_s;
        let side = self.up.cross(&along);
        let radius_m = 0.5 * diameter_m;
        let (mut x, mut y) = (from_foot_m.dot(&along) / radius_m, from_foot_m.dot(&side) / radius_m);
        let distance = x.hypot(y);
        if distance < 1.0 {
            // inside: the point of the surface in the same direction; on the axis, the foremost point
            (x, y) = if distance > 0.0 { (x / distance, y / distance) } else { (-1.0, 0.0) };
        }
        let (mut axial, mut lateral) = match self.potential {
            Potential::None => (0.0, 0.0),
            Potential::Cylinder => cylinder(x, y),
            Potential::Bak => {
                let shifted = x + BAK_SHIFT;
                let (axial, lateral) = cylinder(shifted, y);
                let source = drag / (TAU * (shifted * shifted + y * y));
                (axial + source * shifted, lateral + source * y)
            }
        };
        if self.shadow == Shadow::Powles && x > 0.0 {
            let width = x.hypot(y).sqrt();
            if y.abs() < width {
                axial -= drag / width * (FRAC_PI_2 * y / width).cos().powi(2);
            }
        }
        // the wind is not reversed: a shadow can at most stop it
        axial = axial.max(-1.0);
        if axial == -1.0 {
            lateral = 0.0;
        }
        (along * axial + side * lateral) * speed_m_s
    }

    /// Diameter in m and drag coefficient at a height in m.
    fn row(&self, height_m: f64) -> Option<[f64; 2]> {
        let after = self.rows.partition_point(|row| row[0] <= height_m);
        let lower = &self.rows[after.checked_sub(1)?];
        let Some(upper) = self.rows.get(after) else { return (lower[0] == height_m).then_some([lower[1], lower[2]]) };
        let share = (height_m - lower[0]) / (upper[0] - lower[0]);
        Some([1, 2].map(|i| lower[i] + (upper[i] - lower[i]) * share))
    }
}

/// Velocity disturbance by a cylinder of radius 1 in a wind of speed 1 along x.
fn cylinder(x: f64, y: f64) -> (f64, f64) {
    let square = (x * x + y * y).powi(2);
    (-(x * x - y * y) / square, -2.0 * x * y / square)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tower(potential: Potential, shadow: Shadow) -> Tower {
        let rows = vec![[0.0, 6.0, 1.0], [80.0, 4.0, 0.5]];
        Tower { base_m: Vector3::new(1.0, 2.0, 3.0), up: Vector3::z(), rows, potential, shadow }
    }

    fn at(tower: &Tower, x: f64, y: f64, wind: Vector3<f64>) -> Vector3<f64> {
        tower.added_m_s(&(tower.base_m + Vector3::new(x, y, 40.0)), &wind)
    }

    #[test]
    fn wind_goes_around_a_cylinder() {
        let tower = tower(Potential::Cylinder, Shadow::None);
        let wind = Vector3::new(0.0, 10.0, 3.0);
        // stagnation in front, twice the speed at the sides, no flow through the surface (radius 2.5 m at 40 m)
        approx::assert_relative_eq!(at(&tower, 0.0, -2.5, wind).y, -10.0, max_relative = 1e-12);
        approx::assert_relative_eq!(at(&tower, 2.5, 0.0, wind).y, 10.0, max_relative = 1e-12);
        for degree in 0..360 {
            let normal = nalgebra::Rotation3::new(Vector3::z() * f64::from(degree).to_radians()) * Vector3::x();
            let through = (at(&tower, 2.5 * normal.x, 2.5 * normal.y, wind) + wind).dot(&normal);
            assert!(through.abs() < 1e-12, "{degree}: {through}");
        }
        // far from the tower the disturbance decreases with the square of the distance
        approx::assert_relative_eq!(at(&tower, 0.0, -50.0, wind).y, -10.0 * 0.05f64.powi(2), max_relative = 1e-12);
    }

    #[test]
    fn shadow_is_powles_and_ends_beside_and_above() {
        let tower = tower(Potential::None, Shadow::Powles);
        let wind = Vector3::new(10.0, 0.0, 0.0);
        let width = 8.0f64.sqrt(); // 20 m behind the tower: 8 radii
        approx::assert_relative_eq!(at(&tower, 20.0, 0.0, wind).x, -10.0 * 0.75 / width, max_relative = 1e-12);
        // off the centre line, 8 and 1.2 radii downwind: the shadow's width grows with the square root of the distance from the tower axis
        for (x, y) in [(20.0, 5.0), (20.0, -5.0), (3.0, 3.0)] {
            let (x_radii, y_radii) = (x / 2.5, f64::abs(y) / 2.5);
            let width = f64::hypot(x_radii, y_radii).sqrt();
            assert!(y_radii < width);
            let expected = -10.0 * 0.75 / width * (std::f64::consts::PI * y_radii / (2.0 * width)).cos().powi(2);
            approx::assert_relative_eq!(at(&tower, x, y, wind).x, expected, max_relative = 1e-12);
        }
        assert_eq!(at(&tower, -20.0, 0.0, wind), Vector3::zeros());
        assert_eq!(at(&tower, 20.0, 8.0, wind), Vector3::zeros());
        assert_eq!(tower.added_m_s(&Vector3::new(21.0, 2.0, 90.0), &wind), Vector3::zeros());
        assert_eq!(tower.added_m_s(&Vector3::new(21.0, 2.0, 0.0), &wind), Vector3::zeros());
    }

    #[test]
    fn influence_stays_finite_inside_and_without_wind() {
        for potential in [Potential::Cylinder, Potential::Bak] {
            let tower = tower(potential, Shadow::Powles);
            for (x, y) in [(0.0, 0.0), (1e-9, 0.0), (0.5, -0.5), (-2.4, 0.1)] {
                let added = at(&tower, x, y, Vector3::new(10.0, 0.0, 0.0));
                assert!(added.norm() < 25.0, "{added}");
            }
            assert_eq!(at(&tower, 3.0, 1.0, Vector3::zeros()), Vector3::zeros());
            assert_eq!(at(&tower, 3.0, 1.0, Vector3::z() * 4.0), Vector3::zeros());
        }
    }
}
