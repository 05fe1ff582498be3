//! Joint angles prescribed as functions of time.

/// An angle as a function of absolute time, twice continuously differentiable except at the start and end of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Polynomial `θ(t) = Σ coefficients[i] tⁱ` in rad and s.
    Polynomial(Vec<f64>),
    /// Cubic spline through `(time_s, angle_rad)`, constant outside; at least two points with ascending times.
    ///
    /// The end slopes are zero (clamped spline), so that the rate is continuous where the constant parts start; the acceleration jumps
    /// there, and the time integration is restarted.
    Table(Vec<(f64, f64)>),
    /// Cubic spline through `(time_s, angle_rad)` with zero acceleration at its ends, continued outside at constant rate.
    Onward(Vec<(f64, f64)>),
    /// Linear interpolation of `(time_s, angle_rad)`, constant outside; rate and acceleration are taken as zero.
    ///
    /// OpenFAST's treatment of pitch, for comparison with it: blades that are bent miss the impulses at the start and the end of a pitch
    /// manoeuvre, and the energy balance does not close.
    QuasiStatic(Vec<(f64, f64)>),
}

/// A motion prepared for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Polynomial coefficients.
    Polynomial(Vec<f64>),
    /// Clamped cubic spline: `(time_s, angle_rad, curvature_rad_s2)` per knot.
    Spline(Vec<[f64; 3]>),
    /// Natural cubic spline that continues outside with its end rates.
    Onward(Vec<[f64; 3]>),
    /// Knots without curvature: linear interpolation with zero rate.
    QuasiStatic(Vec<[f64; 3]>),
}

impl Law {
    /// Prepares a motion; the spline's curvatures follow from a tridiagonal system.
    pub fn new(motion: &Motion) -> Self {
        match motion {
            Motion::Polynomial(coefficients) => Self::Polynomial(coefficients.clone()),
            Motion::Table(points) => Self::Spline(spline(points, Ends::Clamped)),
            Motion::Onward(points) => Self::Onward(spline(points, Ends::Natural)),
            Motion::QuasiStatic(points) => {
                Self::QuasiStatic(points.iter().map(|&(time, angle)| [time, angle, 0.0]).collect())
            }
        }
    }

    /// Angle (rad), rate (rad/s) and acceleration (rad/s²) at `time_s`; at a knot, those of the piece after it.
    pub fn at(&self, time_s: f64) -> [f64; 3] {
        self.at_on(time_s, time_s)
    }

    /// Angle, rate and acceleration at `time_s` on the piece selected by `branch_s`.
    ///
    /// The acceleration jumps at the first and the last knot: a step that ends there must use the piece before it, also at its last stage.
    pub fn at_on(&self, time_s: f64, branch_s: f64) -> [f64; 3] {
        match self {
            Self::Polynomial(coefficients) => {
                let (mut angle, mut rate, mut half) = (0.0, 0.0, 0.0);
                for coefficient in coefficients.iter().rev() {
                    half = half * time_s + rate;
                    rate = rate * time_s + angle;
                    angle = angle * time_s + coefficient;
                }
                [angle, rate, 2.0 * half]
            }
            Self::Spline(knots) => spline_at(knots, time_s, branch_s, Ends::Clamped),
            Self::Onward(knots) => spline_at(knots, time_s, branch_s, Ends::Natural),
            Self::QuasiStatic(knots) => [spline_at(knots, time_s, branch_s, Ends::Clamped)[0], 0.0, 0.0],
        }
    }

    /// Derivatives with respect to time of angle (rad/s), rate (rad/s²) and acceleration (rad/s³) at `time_s`, on the piece given by `branch_s`.
    pub fn by_time(&self, time_s: f64, branch_s: f64) -> [f64; 3] {
        let piece = |knots: &[[f64; 3]]| {
            let after = knots.partition_point(|knot| knot[0] <= branch_s);
            (after > 0 && after < knots.len()).then(|| {
                let ([t0, y0, m0], [t1, y1, m1]) = (knots[after - 1], knots[after]);
                [(y1 - y0) / (t1 - t0), (m1 - m0) / (t1 - t0)]
            })
        };
        let [_, rate, acceleration] = self.at_on(time_s, branch_s);
        match self {
            Self::Polynomial(coefficients) => {
                let third = |(i, c): (usize, &f64)| {
                    let i = i as i32;
                    if i < 3 { 0.0 } else { f64::from(i * (i - 1) * (i - 2)) * c * time_s.powi(i - 3) }
                };
                [rate, acceleration, coefficients.iter().enumerate().map(third).sum()]
            }
            Self::Spline(knots) | Self::Onward(knots) => {
                [rate, acceleration, piece(knots).map_or(0.0, |[_, curvature]| curvature)]
            }
            Self::QuasiStatic(knots) => [piece(knots).map_or(0.0, |[slope, _]| slope), 0.0, 0.0],
        }
    }

    /// Times of its knots in s; none of a polynomial.
    pub fn knots_s(&self) -> impl Iterator<Item = f64> + '_ {
        let knots: &[[f64; 3]] = match self {
            Self::Polynomial(_) => &[],
            Self::Spline(knots) | Self::Onward(knots) | Self::QuasiStatic(knots) => knots,
        };
        knots.iter().map(|knot| knot[0])
    }

    /// Whether a knot is exactly at `time_s`.
    pub fn has_knot_at(&self, time_s: f64) -> bool {
        matches!(self, Self::Spline(knots) | Self::Onward(knots) | Self::QuasiStatic(knots) if knots.iter().any(|knot| knot[0] == time_s))
    }

    /// Time of the first knot after `time_s`, where the third derivative jumps and a step should end; infinite without one.
    pub fn next_knot_s(&self, time_s: f64) -> f64 {
        match self {
            Self::Polynomial(_) => f64::INFINITY,
            Self::Spline(knots) | Self::Onward(knots) | Self::QuasiStatic(knots) => {
                knots.iter().map(|knot| knot[0]).find(|&knot| knot > time_s).unwrap_or(f64::INFINITY)
            }
        }
    }
}

/// End conditions of a spline.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ends {
    /// Zero slope.
    Clamped,
    /// Zero curvature.
    Natural,
}

/// Knots with the curvatures of the cubic spline, by the Thomas algorithm.
fn spline(points: &[(f64, f64)], ends: Ends) -> Vec<[f64; 3]> {
    let n = points.len();
    let slope = |i: usize| (points[i + 1].1 - points[i].1) / (points[i + 1].0 - points[i].0);
    let width = |i: usize| points[i + 1].0 - points[i].0;
    let (mut upper, mut right) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        if ends == Ends::Natural && (i == 0 || i + 1 == n) {
            // zero curvature: the row is 1·m = 0
            continue;
        }
        // row: lower·m[i−1] + diagonal·m[i] + after·m[i+1] = load
        let (lower, after) = (if i > 0 { width(i - 1) } else { 0.0 }, if i + 1 < n { width(i) } else { 0.0 });
        let before_slope = if i > 0 { slope(i - 1) } else { 0.0 };
        let after_slope = if i + 1 < n { slope(i) } else { 0.0 };
        let (previous_upper, previous_right) = if i > 0 { (upper[i - 1], right[i - 1]) } else { (0.0, 0.0) };
        let pivot = 2.0 * (lower + after) - lower * previous_upper;
        upper[i] = after / pivot;
        right[i] = (6.0 * (after_slope - before_slope) - lower * previous_right) / pivot;
    }
    let mut knots: Vec<[f64; 3]> = points.iter().map(|&(time, angle)| [time, angle, 0.0]).collect();
    for i in (0..n).rev() {
        let after = if i + 1 < n { knots[i + 1][2] } else { 0.0 };
        knots[i][2] = right[i] - upper[i] * after;
    }
    knots
}

fn spline_at(knots: &[[f64; 3]], time_s: f64, branch_s: f64, ends: Ends) -> [f64; 3] {
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    let pieces_before = knots.partition_point(|knot| knot[0] <= branch_s);
    // beyond an end: continues with the slope there, which is zero for a clamped spline
    let beyond = |end: [f64; 3], slope: f64| match ends {
        Ends::Clamped => [end[1], 0.0, 0.0],
        Ends::Natural => [end[1] + slope * (time_s - end[0]), slope, 0.0],
    };
    if pieces_before == 0 {
        return beyond(first, piece_at(&knots[..2], first[0])[1]);
    }
    if pieces_before == knots.len() {
        return beyond(last, piece_at(&knots[knots.len() - 2..], last[0])[1]);
    }
    piece_at(&knots[pieces_before - 1..], time_s)
}

/// Angle, rate and acceleration on the piece between the first two knots.
fn piece_at(knots: &[[f64; 3]], time_s: f64) -> [f64; 3] {
    let ([t0, y0, m0], [t1, y1, m1]) = (knots[0], knots[1]);
    let h = t1 - t0;
    let (a, b) = ((t1 - time_s) / h, (time_s - t0) / h);
    let angle = a * y0 + b * y1 + ((a.powi(3) - a) * m0 + (b.powi(3) - b) * m1) * h * h / 6.0;
    let rate = (y1 - y0) / h + ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * h / 6.0;
    [angle, rate, a * m0 + b * m1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares rates and accelerations with central differences, and tests continuity across a knot.
    #[test]
    fn derivatives_match_differences() {
        let laws = [
            Law::new(&Motion::Polynomial(vec![0.3, -1.0, 2.0, 0.5])),
            Law::new(&Motion::Table(vec![(0.0, 0.0), (0.5, 1.0), (0.7, 0.8), (2.0, -1.0)])),
        ];
        let step = 1e-5;
        for law in &laws {
            for time in [0.1, 0.49, 0.6, 1.3] {
                let [_, rate, acceleration] = law.at(time);
                let ([below, rate_below, _], [above, rate_above, _]) = (law.at(time - step), law.at(time + step));
                assert!(((above - below) / (2.0 * step) - rate).abs() < 1e-8);
                assert!(((rate_above - rate_below) / (2.0 * step) - acceleration).abs() < 1e-7);
                let ends = [law.at(time - step), law.at(time + step)];
                for (part, slope) in law.by_time(time, time).iter().enumerate() {
                    assert!(((ends[1][part] - ends[0][part]) / (2.0 * step) - slope).abs() < 1e-6, "{time}: {part}");
                }
            }
            let (left, right) = (law.at(0.5 - 1e-9), law.at(0.5 + 1e-9));
            assert!((left[2] - right[2]).abs() < 1e-6, "acceleration jumps by {}", left[2] - right[2]);
        }
    }

    /// A table of constant rate keeps its rate up to and beyond the last instant; a curved one passes through its rows with a continuous
    /// rate and with zero acceleration at its ends. (Formerly it decelerated in its last interval.)
    #[test]
    fn an_onward_table_does_not_brake() {
        let steady = Law::new(&Motion::Onward(vec![(0.0, 0.1), (0.3, 0.7), (1.0, 2.1)]));
        for time in [-1.0, 0.0, 0.2, 0.9, 1.0, 3.0] {
            let [angle, rate, acceleration] = steady.at(time);
            assert!(
                (angle - 0.1 - 2.0 * time).abs() < 1e-14 && (rate - 2.0).abs() < 1e-13 && acceleration.abs() < 1e-12
            );
        }
        let curved = Law::new(&Motion::Onward(vec![(1.0, 0.2), (2.0, 1.0), (4.0, 0.5)]));
        for (time, angle) in [(1.0, 0.2), (2.0, 1.0), (4.0, 0.5)] {
            assert!((curved.at(time)[0] - angle).abs() < 1e-15);
            let (left, right) = (curved.at(time - 1e-9), curved.at(time + 1e-9));
            assert!((left[1] - right[1]).abs() < 1e-8 && (left[2] - right[2]).abs() < 1e-7);
        }
        assert_eq!((curved.at(1.0)[2], curved.at(4.0)[2]), (0.0, 0.0));
    }

    /// Linear between its rows, constant outside, with zero rate everywhere.
    #[test]
    fn a_quasi_static_table_has_no_rate() {
        let law = Law::new(&Motion::QuasiStatic(vec![(1.0, 0.2), (2.0, 1.0), (4.0, 0.5)]));
        for (time, angle) in [(0.0, 0.2), (1.0, 0.2), (1.25, 0.4), (2.0, 1.0), (3.0, 0.75), (4.0, 0.5), (9.0, 0.5)] {
            let [found, rate, acceleration] = law.at(time);
            assert!((found - angle).abs() < 1e-15 && rate == 0.0 && acceleration == 0.0, "{time}: {found}");
            let slope = if (1.0..2.0).contains(&time) {
                0.8
            } else if (2.0..4.0).contains(&time) {
                -0.25
            } else {
                0.0
            };
            let by_time = law.by_time(time, time);
            assert!((by_time[0] - slope).abs() < 1e-15 && by_time[1..] == [0.0; 2], "{time}: {by_time:?}");
        }
        assert!(law.has_knot_at(2.0));
        assert_eq!((law.next_knot_s(1.0), law.next_knot_s(4.0)), (2.0, f64::INFINITY));
    }

    #[test]
    fn table_is_met_and_held_outside() {
        let law = Law::new(&Motion::Table(vec![(1.0, 0.2), (2.0, 1.0), (4.0, 0.5)]));
        for (time, angle) in [(0.0, 0.2), (1.0, 0.2), (2.0, 1.0), (4.0, 0.5), (9.0, 0.5)] {
            assert!((law.at(time)[0] - angle).abs() < 1e-15);
        }
        assert!(law.at(1.0 + 1e-9)[1].abs() < 1e-8, "starts from rest");
        assert_eq!((law.next_knot_s(1.0), law.next_knot_s(4.0)), (2.0, f64::INFINITY));
    }
}
