//! The wind as a field in space and time: shear, a table over time, and turbulence convected by the mean wind.

use crate::aero::pieces::Pieces;
use crate::aero::rotor::turbulence_box::TurbulenceBox;
use nalgebra::Vector3;

/// Height in m below which a profile is constant: a power law is zero or infinite at the ground.
const MINIMUM_HEIGHT_M: f64 = 0.01;

/// Profile of the mean wind over height.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Shear {
    /// Uniform over height.
    #[default]
    None,
    /// Power law `(z/z_ref)^α`.
    Power {
        /// Exponent `α`.
        exponent: f64,
    },
    /// Logarithmic law `ln(z/z0)/ln(z_ref/z0)`.
    Logarithmic {
        /// Roughness length `z0` in m.
        roughness_m: f64,
    },
}

/// One row of a table over time, with the columns of AeroDyn's uniform wind files.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TableRow {
    /// Time in s.
    pub time_s: f64,
    /// Horizontal speed in m/s.
    pub speed_m_s: f64,
    /// Direction in rad; with increasing values the wind direction turns from downwind towards starboard (clockwise from above).
    pub direction_rad: f64,
    /// Vertical speed in m/s.
    pub vertical_m_s: f64,
    /// Linear horizontal shear across the reference length, relative to the speed.
    pub horizontal_shear: f64,
    /// Exponent of the vertical power law.
    pub power_exponent: f64,
    /// Linear vertical shear across the reference length, relative to the speed.
    pub vertical_shear: f64,
    /// Gust added to the horizontal speed everywhere, in m/s.
    pub gust_m_s: f64,
}

/// Wind over time at one height, with its shears, eq. (B19). Linear between rows; the first and the last row hold before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct WindTable {
    /// Length in m to which linear shears refer: the rotor diameter.
    pub reference_length_m: f64,
    /// At least one row, with strictly ascending times.
    pub rows: Vec<TableRow>,
}

impl WindTable {
    /// Row interpolated at a time.
    pub fn at(&self, time_s: f64) -> TableRow {
        let after = self.rows.partition_point(|row| row.time_s <= time_s);
        let (Some(b), Some(a)) = (self.rows.get(after), after.checked_sub(1).map(|i| &self.rows[i])) else {
            return self.rows[after.min(self.rows.len() - 1)];
        };
        let share = (time_s - a.time_s) / (b.time_s - a.time_s);
        let mix = |a: f64, b: f64| a + (b - a) * share;
        TableRow {
            time_s,
            speed_m_s: mix(a.speed_m_s, b.speed_m_s),
            direction_rad: mix(a.direction_rad, b.direction_rad),
            vertical_m_s: mix(a.vertical_m_s, b.vertical_m_s),
            horizontal_shear: mix(a.horizontal_shear, b.horizontal_shear),
            power_exponent: mix(a.power_exponent, b.power_exponent),
            vertical_shear: mix(a.vertical_shear, b.vertical_shear),
            gust_m_s: mix(a.gust_m_s, b.gust_m_s),
        }
    }
}

/// Source of a wind field.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Wind of the input, with a profile over height.
    Steady(Shear),
    /// Table over time, to which the wind of the input is added.
    Table(WindTable),
    /// Turbulence on a grid convected by the mean wind, to which the wind of the input is added.
    Box(Box<TurbulenceBox>),
}

/// Wind field around a rotor, in a frame fixed to the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct WindField {
    /// Source of the wind.
    pub source: Source,
    /// Point on the ground in m, below the reference point at which grid and table are centred.
    pub ground_m: Vector3<f64>,
    /// Unit vector upward.
    pub up: Vector3<f64>,
    /// Horizontal unit vector downwind.
    pub downwind: Vector3<f64>,
    /// Height in m above the ground at which the wind has its reference speed.
    pub reference_height_m: f64,
}

impl WindField {
    /// Velocity of the air in m/s at a time and position, eqs. (B18)–(B20); `input_m_s` is the wind of the input.
    pub fn velocity_m_s(
        &self,
        time_s: f64,
        point_m: &Vector3<f64>,
        input_m_s: &Vector3<f64>,
        pieces: &mut Pieces,
    ) -> Vector3<f64> {
        let from_m = point_m - self.ground_m;
        let height_m = from_m.dot(&self.up);
        match &self.source {
            Source::Steady(shear) => {
                let vertical_m_s = self.up * input_m_s.dot(&self.up);
                vertical_m_s + (input_m_s - vertical_m_s) * self.profile(shear, height_m)
            }
            Source::Table(table) => {
                let row = table.at(time_s);
                let (sine, cosine) = row.direction_rad.sin_cos();
                let port = self.up.cross(&self.downwind);
                let (x, y) = (from_m.dot(&self.downwind), from_m.dot(&port));
                let profile = self.profile(&Shear::Power { exponent: row.power_exponent }, height_m);
                let linear = row.horizontal_shear * (y * cosine + x * sine)
                    + row.vertical_shear * (height_m - self.reference_height_m);
                let speed_m_s = row.speed_m_s * (profile + linear / table.reference_length_m) + row.gust_m_s;
                input_m_s + (self.downwind * cosine - port * sine) * speed_m_s + self.up * row.vertical_m_s
            }
            Source::Box(grid) => {
                let port = self.up.cross(&self.downwind);
                let [u, v, w] = grid.at(time_s, [from_m.dot(&self.downwind), from_m.dot(&port), height_m], pieces);
                input_m_s + self.downwind * u + port * v + self.up * w
            }
        }
    }

    /// Ratio of the wind speed at a height to that at the reference height, eq. (B18).
    fn profile(&self, shear: &Shear, height_m: f64) -> f64 {
        let height_m = height_m.max(MINIMUM_HEIGHT_M);
        match *shear {
            Shear::None => 1.0,
            Shear::Power { exponent } => (height_m / self.reference_height_m).powf(exponent),
            Shear::Logarithmic { roughness_m } => {
                (height_m / roughness_m).ln().max(0.0) / (self.reference_height_m / roughness_m).ln()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(source: Source) -> WindField {
        WindField {
            source,
            ground_m: Vector3::new(0.0, 0.0, -90.0),
            up: Vector3::z(),
            downwind: Vector3::x(),
            reference_height_m: 90.0,
        }
    }

    #[test]
    fn profiles_are_one_at_the_reference_height_and_finite_at_the_ground() {
        let input = Vector3::new(8.0, 1.0, 0.5);
        let power = field(Source::Steady(Shear::Power { exponent: 0.2 }));
        assert_eq!(power.velocity_m_s(3.0, &Vector3::zeros(), &input, &mut Pieces::Free), input);
        let high = power.velocity_m_s(0.0, &Vector3::new(5.0, 7.0, 60.0), &input, &mut Pieces::Free);
        let factor = (150.0f64 / 90.0).powf(0.2);
        approx::assert_relative_eq!(high, Vector3::new(8.0 * factor, factor, 0.5), max_relative = 1e-14);
        let low = power.velocity_m_s(0.0, &Vector3::new(0.0, 0.0, -200.0), &input, &mut Pieces::Free);
        assert!(low.x > 0.0 && low.x < 2.0 && low.z == 0.5);
        let log = field(Source::Steady(Shear::Logarithmic { roughness_m: 0.03 }));
        approx::assert_relative_eq!(
            log.velocity_m_s(0.0, &Vector3::zeros(), &input, &mut Pieces::Free),
            input,
            max_relative = 1e-14
        );
        assert_eq!(log.velocity_m_s(0.0, &(Vector3::z() * -90.0), &input, &mut Pieces::Free).x, 0.0);
    }

    /// Writes out the formula of the uniform wind files.
    #[test]
    fn table_has_direction_shears_and_gust() {
        let row = |time_s, speed_m_s| TableRow {
            time_s,
            speed_m_s,
            direction_rad: 0.3,
            vertical_m_s: 0.2,
            horizontal_shear: 0.1,
            power_exponent: 0.14,
            vertical_shear: 0.05,
            gust_m_s: 1.5,
        };
        let table = WindTable { reference_length_m: 126.0, rows: vec![row(0.0, 8.0), row(10.0, 12.0)] };
        let field = field(Source::Table(table));
        let (x, y, z) = (4.0, -30.0, 20.0);
        let got = field.velocity_m_s(5.0, &Vector3::new(x, y, z), &Vector3::zeros(), &mut Pieces::Free);
        let (s, c) = 0.3f64.sin_cos();
        let speed = 10.0 * ((110.0f64 / 90.0).powf(0.14) + (0.1 * (y * c + x * s) + 0.05 * z) / 126.0) + 1.5;
        approx::assert_relative_eq!(got, Vector3::new(speed * c, -speed * s, 0.2), max_relative = 1e-13);
        let late = field.velocity_m_s(99.0, &Vector3::zeros(), &Vector3::zeros(), &mut Pieces::Free);
        approx::assert_relative_eq!(late.norm(), (13.5f64.powi(2) + 0.04).sqrt(), max_relative = 1e-13);
    }
}
