//! Tables of section coefficients by angle of attack.

/// Coefficients of a section at one angle of attack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarRow {
    /// Angle of attack of the chord line in rad.
    pub angle_rad: f64,
    /// Lift coefficient, for the force normal to the relative velocity.
    pub lift: f64,
    /// Drag coefficient, for the force along the relative velocity.
    pub drag: f64,
    /// Moment coefficient about the quarter chord, nose up positive.
    pub moment: f64,
}

/// Static polar of a section, linear between its rows.
///
/// A strip with inflow from any direction needs rows from −π to π; outside the rows the nearest row is used.
#[derive(Debug, Clone, PartialEq)]
pub struct Polar {
    /// At least one row, with strictly ascending angles.
    pub rows: Vec<PolarRow>,
}

impl Polar {
    /// Coefficients at an angle of attack in rad, eq. (W9).
    pub fn at(&self, angle_rad: f64) -> PolarRow {
        self.at_with_lift_slope(angle_rad).0
    }

    /// Coefficients and the slope of the lift coefficient in 1/rad, which is that of the next higher interval at a row and 0 outside the
    /// rows.
    pub fn at_with_lift_slope(&self, angle_rad: f64) -> (PolarRow, f64) {
        let interval = self.interval(angle_rad);
        let slope_1_rad = match self.ends(interval) {
            Some([lower, upper]) => (upper.lift - lower.lift) / (upper.angle_rad - lower.angle_rad),
            None => 0.0,
        };
        (self.in_interval(interval, angle_rad), slope_1_rad)
    }

    /// Rows at the ends of an interval; `None` outside the rows.
    fn ends(&self, interval: usize) -> Option<[&PolarRow; 2]> {
        Some([self.rows.get(interval.checked_sub(1)?)?, self.rows.get(interval)?])
    }

    /// Number of rows at or below an angle of attack in rad: the interval of [`Self::at`].
    pub fn interval(&self, angle_rad: f64) -> usize {
        self.rows.partition_point(|row| row.angle_rad <= angle_rad)
    }

    /// Coefficients on the line of a given interval, continued beyond its ends; outside the rows those of the nearest row.
    pub fn in_interval(&self, interval: usize, angle_rad: f64) -> PolarRow {
        let Some([lower, upper]) = self.ends(interval) else {
            return self.rows[interval.min(self.rows.len() - 1)];
        };
        let share = (angle_rad - lower.angle_rad) / (upper.angle_rad - lower.angle_rad);
        let between = |a: f64, b: f64| a + (b - a) * share;
        PolarRow {
            angle_rad,
            lift: between(lower.lift, upper.lift),
            drag: between(lower.drag, upper.drag),
            moment: between(lower.moment, upper.moment),
        }
    }

    /// Whether an angle of attack in rad is that of a row, but for a distance that is round-off, at which the slopes of both sides differ.
    pub fn is_at_kink(&self, angle_rad: f64, round_off_rad: f64) -> bool {
        let row = self.rows.partition_point(|row| row.angle_rad < angle_rad - round_off_rad);
        let near = |row: &PolarRow| (row.angle_rad - angle_rad).abs() <= round_off_rad;
        if !self.rows.get(row).is_some_and(near) {
            return false;
        }
        let [below, above] = [row, row + 1].map(|interval| {
            let ends = [-1.0, 1.0].map(|side| self.in_interval(interval, angle_rad + side));
            [ends[1].lift - ends[0].lift, ends[1].drag - ends[0].drag, ends[1].moment - ends[0].moment]
        });
        // a straight line with an additional row has the same slopes but for round-off
        below.iter().zip(&above).any(|(below, above)| (below - above).abs() > 1e-9 * below.abs().max(above.abs()))
    }

    /// Whether the lift at an angle of attack in rad is lower than at some angle between it and zero lift: beyond stall.
    pub fn is_beyond_stall(&self, angle_rad: f64) -> bool {
        let Some(zero_rad) = self.zero_lift_angle_rad() else { return false };
        let side = (angle_rad - zero_rad).signum();
        let between =
            |row: &&PolarRow| (row.angle_rad - zero_rad) * side > 0.0 && (angle_rad - row.angle_rad) * side > 0.0;
        let largest = self.rows.iter().filter(between).map(|row| side * row.lift).fold(0.0, f64::max);
        side * self.at(angle_rad).lift < largest
    }

    /// Angle of attack in rad, nearest to zero, at which the lift rises through zero; `None` if it never does.
    pub fn zero_lift_angle_rad(&self) -> Option<f64> {
        let rises = self.rows.windows(2).filter(|pair| pair[0].lift <= 0.0 && pair[1].lift > 0.0);
        let angles = rises.map(|pair| {
            let share = -pair[0].lift / (pair[1].lift - pair[0].lift);
            pair[0].angle_rad + (pair[1].angle_rad - pair[0].angle_rad) * share
        });
        angles.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polar_is_linear_between_rows_and_constant_outside() {
        let row = |angle_rad, lift| PolarRow { angle_rad, lift, drag: 0.1 * lift, moment: -lift };
        let polar = Polar { rows: vec![row(-0.1, -0.5), row(0.1, 0.7), row(0.3, 0.9)] };
        let lift = |angle_rad| polar.at(angle_rad).lift;
        assert_eq!((lift(-0.1), lift(0.1), lift(0.3)), (-0.5, 0.7, 0.9));
        approx::assert_relative_eq!(lift(0.0), 0.1, max_relative = 1e-14);
        approx::assert_relative_eq!(polar.at(0.2).drag, 0.08, max_relative = 1e-14);
        approx::assert_relative_eq!(polar.at(0.2).moment, -0.8, max_relative = 1e-14);
        assert_eq!((lift(-3.0), lift(3.0)), (-0.5, 0.9));
    }

    #[test]
    fn lift_beyond_stall_is_less_than_before() {
        let row = |angle_rad, lift| PolarRow { angle_rad, lift, drag: 0.0, moment: 0.0 };
        let falling = Polar {
            rows: [(-0.3, -0.5), (-0.2, -1.0), (0.2, 1.4), (0.3, 0.9), (0.5, 1.0)].map(|(a, l)| row(a, l)).to_vec(),
        };
        for (angle_rad, beyond) in
            [(-0.25, true), (-0.19, false), (0.0, false), (0.2, false), (0.21, true), (0.4, true)]
        {
            assert_eq!(falling.is_beyond_stall(angle_rad), beyond, "{angle_rad}");
        }
        let level = Polar { rows: [(-0.2, -1.0), (0.2, 1.0), (0.3, 1.0), (0.5, 1.1)].map(|(a, l)| row(a, l)).to_vec() };
        assert!(![-0.3, 0.25, 0.3, 0.4, 0.6].into_iter().any(|angle_rad| level.is_beyond_stall(angle_rad)));
    }

    #[test]
    fn zero_lift_angle_is_the_rise_nearest_to_zero() {
        let row = |angle_rad, lift| PolarRow { angle_rad, lift, drag: 0.0, moment: 0.0 };
        let circle = [(-3.0, 0.4), (-2.0, -0.5), (-1.5, 0.5), (-0.3, -0.3), (0.1, 0.5), (1.5, 0.0), (3.0, -0.1)];
        let polar = Polar { rows: circle.map(|(angle_rad, lift)| row(angle_rad, lift)).to_vec() };
        approx::assert_relative_eq!(polar.zero_lift_angle_rad().unwrap(), -0.15, max_relative = 1e-14);
        assert_eq!(Polar { rows: vec![row(0.0, 0.5)] }.zero_lift_angle_rad(), None);
    }
}
