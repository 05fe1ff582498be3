//! Generator on the fast shaft of a gearbox: its torque is a function of the speed, eq. (A11).

use crate::force::{Here, Push};
use crate::solve::Powers;

/// Torque of a generator at speeds above the last row of its table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beyond {
    /// Constant torque, that of the last row.
    #[default]
    Torque,
    /// Constant power, that of the last row: the torque decreases as the speed increases.
    Power,
}

/// Torque of a generator as a function of its speed.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneratorLaw {
    /// Ratio of the generator speed to the joint rate.
    pub gear_ratio: f64,
    /// Rows of speed in rad/s and torque in N·m, linear in between.
    pub rows: Vec<[f64; 2]>,
    /// Gain in N·m·s²/rad² of a torque proportional to the square of the speed below the first row, and zero for reversed rotation. `None`:
    /// the torque of the first row is used there.
    pub square_gain_n_m_s2: Option<f64>,
    /// Torque above the last row.
    pub beyond: Beyond,
    /// Ratio of electrical to mechanical power.
    pub efficiency: f64,
    /// Start value of the input that connects the generator.
    pub connected: bool,
}

/// Smooth piece of the torque of a generator over its speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Segment {
    /// Proportional to the square of the speed, below the first row.
    Square,
    /// Reversed rotation below the first row: no torque.
    Reversed,
    /// The torque of the first row, below it.
    First,
    /// From this row of the table to the next.
    From(usize),
    /// The torque of the last row, above it.
    Last,
    /// The power of the last row, above it.
    Power,
}

impl GeneratorLaw {
    /// Piece at a generator speed in rad/s; `None` without rows.
    pub fn segment(&self, speed_rad_s: f64) -> Option<Segment> {
        let (first, last) = (self.rows.first()?, self.rows.last()?);
        Some(if speed_rad_s < first[0] {
            match self.square_gain_n_m_s2 {
                Some(_) if speed_rad_s < 0.0 => Segment::Reversed,
                Some(_) => Segment::Square,
                None => Segment::First,
            }
        } else if speed_rad_s >= last[0] {
            match self.beyond {
                Beyond::Torque => Segment::Last,
                Beyond::Power => Segment::Power,
            }
        } else {
            Segment::From(self.rows.partition_point(|row| row[0] <= speed_rad_s) - 1)
        })
    }

    /// Torque opposing the motion in N·m on a piece, continued beyond its ends, and its derivative with respect to the speed in N·m·s.
    pub fn torque_on_n_m(&self, segment: Segment, speed_rad_s: f64) -> (f64, f64) {
        let (Some(first), Some(last)) = (self.rows.first(), self.rows.last()) else { return (0.0, 0.0) };
        match segment {
            Segment::Square => {
                let gain = self.square_gain_n_m_s2.unwrap_or(0.0);
                (gain * speed_rad_s * speed_rad_s, 2.0 * gain * speed_rad_s)
            }
            Segment::Reversed => (0.0, 0.0),
            Segment::First => (first[1], 0.0),
            Segment::From(row) => {
                let [from, to] = [self.rows[row], self.rows[row + 1]];
                let slope = (to[1] - from[1]) / (to[0] - from[0]);
                (from[1] + slope * (speed_rad_s - from[0]), slope)
            }
            Segment::Last => (last[1], 0.0),
            Segment::Power => {
                let torque_n_m = last[1] * last[0] / speed_rad_s;
                (torque_n_m, -torque_n_m / speed_rad_s)
            }
        }
    }

    /// Jump of the torque at the first row, relative to the larger of both torques, for a torque proportional to the square of the speed
    /// below it.
    pub fn relative_jump(&self) -> f64 {
        let (Some(gain), Some(first)) = (self.square_gain_n_m_s2, self.rows.first()) else { return 0.0 };
        let below_n_m = gain * first[0].max(0.0) * first[0].max(0.0);
        let largest_n_m = below_n_m.abs().max(first[1].abs());
        if largest_n_m > 0.0 { (first[1] - below_n_m).abs() / largest_n_m } else { 0.0 }
    }

    /// Torque opposing the motion in N·m at a generator speed in rad/s, and its derivative with respect to the speed in N·m·s.
    pub fn torque_n_m(&self, speed_rad_s: f64) -> (f64, f64) {
        self.segment(speed_rad_s).map_or((0.0, 0.0), |segment| self.torque_on_n_m(segment, speed_rad_s))
    }
}

/// A generator with its current state of operation.
#[derive(Debug, Clone, PartialEq)]
pub struct Generator {
    /// Torque as a function of speed.
    pub law: GeneratorLaw,
    /// Whether it is connected; otherwise its torque is zero.
    pub connected: bool,
    /// Speed in rad/s about which linear models linearise the torque; `None` for the nonlinear torque.
    pub about_rad_s: Option<f64>,
    /// Smooth piece of the torque for derivatives with respect to parameters, eq. (X34); `None` if it follows from the speed.
    pub held: Option<Segment>,
}

/// Torque and power of a generator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneratorState {
    /// Speed of the generator shaft in rad/s.
    pub speed_rad_s: f64,
    /// Torque opposing the motion, on the generator shaft, in N·m.
    pub torque_n_m: f64,
    /// Derivative of that torque with respect to the speed in N·m·s.
    pub slope_n_m_s: f64,
    /// Electrical power in W.
    pub power_w: f64,
}

impl Generator {
    /// Torque and power at a rate of the joint.
    pub fn at(&self, rate_rad_s: f64) -> GeneratorState {
        let speed_rad_s = self.law.gear_ratio * rate_rad_s;
        let (torque_n_m, slope_n_m_s) = if self.connected {
            let about_rad_s = self.about_rad_s.unwrap_or(speed_rad_s);
            let (torque_n_m, slope_n_m_s) = match self.held {
                Some(segment) => self.law.torque_on_n_m(segment, about_rad_s),
                None => self.law.torque_n_m(about_rad_s),
            };
            (torque_n_m + slope_n_m_s * (speed_rad_s - about_rad_s), slope_n_m_s)
        } else {
            (0.0, 0.0)
        };
        let power_w = self.law.efficiency * torque_n_m * speed_rad_s;
        GeneratorState { speed_rad_s, torque_n_m, slope_n_m_s, power_w }
    }

    /// Keeps the piece of the torque at a rate of the joint.
    pub fn hold(&mut self, rate_rad_s: f64) {
        self.held = self.law.segment(self.law.gear_ratio * rate_rad_s);
    }

    /// Whether the speed is at a row of the table, where the torque has a kink, to within a share of the largest speed of the table.
    pub fn is_at_row(&self, rate_rad_s: f64, share: f64) -> bool {
        let speed_rad_s = self.law.gear_ratio * rate_rad_s;
        let largest_rad_s = self.law.rows.iter().fold(0.0f64, |largest, row| largest.max(row[0].abs()));
        self.connected && self.law.rows.iter().any(|row| (speed_rad_s - row[0]).abs() <= share * largest_rad_s)
    }

    /// Linearises the torque about a rate of the joint; at a row of the table with the slope towards higher speeds.
    pub fn linearize(&mut self, rate_rad_s: f64) {
        self.about_rad_s = Some(self.law.gear_ratio * rate_rad_s);
    }

    /// Adds the torque and its tangent, eq. (A11).
    pub fn push(&self, here: &Here, sum: &mut Push) {
        let (state, ratio) = (self.at(here.rate_rad_s), self.law.gear_ratio);
        sum.torque_n_m -= ratio * state.torque_n_m;
        sum.tangent.damping += ratio * ratio * state.slope_n_m_s;
    }

    /// Adds the power extracted from the model as (negative) work of the environment.
    pub fn add_powers(&self, here: &Here, powers: &mut Powers) {
        let state = self.at(here.rate_rad_s);
        powers.work -= state.torque_n_m * state.speed_rad_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> GeneratorLaw {
        GeneratorLaw {
            gear_ratio: 97.0,
            rows: vec![[120.0, 30_000.0], [123.0, 43_000.0], [130.0, 43_100.0]],
            square_gain_n_m_s2: Some(30_000.0 / 120.0 / 120.0),
            beyond: Beyond::Power,
            efficiency: 0.944,
            connected: true,
        }
    }

    #[test]
    fn torque_goes_on_without_jumps_and_has_its_slope() {
        let law = law();
        for knot in [120.0, 123.0, 130.0] {
            let [below, above] = [-1e-9, 1e-9].map(|shift| law.torque_n_m(knot + shift).0);
            approx::assert_relative_eq!(below, above, max_relative = 1e-8);
        }
        for speed in [-5.0, 0.0, 60.0, 121.0, 125.0, 150.0] {
            let difference = (law.torque_n_m(speed + 1e-4).0 - law.torque_n_m(speed - 1e-4).0) / 2e-4;
            approx::assert_relative_eq!(difference, law.torque_n_m(speed).1, epsilon = 1e-3, max_relative = 1e-6);
        }
        assert_eq!(law.torque_n_m(-5.0), (0.0, 0.0));
        approx::assert_relative_eq!(law.torque_n_m(260.0).0 * 260.0, 43_100.0 * 130.0, max_relative = 1e-14);
        let held = GeneratorLaw { square_gain_n_m_s2: None, beyond: Beyond::Torque, ..law };
        assert_eq!([held.torque_n_m(0.0), held.torque_n_m(500.0)], [(30_000.0, 0.0), (43_100.0, 0.0)]);
    }

    #[test]
    fn disconnected_generator_gives_nothing() {
        let generator = Generator { law: law(), connected: false, about_rad_s: None, held: None };
        let state = generator.at(1.3);
        assert_eq!([state.torque_n_m, state.power_w], [0.0, 0.0]);
        approx::assert_relative_eq!(state.speed_rad_s, 126.1, max_relative = 1e-12);
    }
}
