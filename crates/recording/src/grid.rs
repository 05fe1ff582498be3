//! Communication points of a run.

/// Equidistant communication points; the last interval may be shorter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Start in s.
    pub start_s: f64,
    /// Stop in s.
    pub stop_s: f64,
    /// Communication step in s.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u64,
}

impl Grid {
    /// Points from a start to a later stop at a positive step, all in s and finite.
    pub fn new(start_s: f64, stop_s: f64, step_s: f64) -> Self {
        let steps = ((stop_s - start_s) / step_s - 1e-9).ceil().max(1.0);
        Self { start_s, stop_s, step_s, steps: steps as u64 }
    }

    /// Time of a communication point in s; the last one is exactly the stop time.
    pub fn time_s(&self, point: u64) -> f64 {
        if point == self.steps { self.stop_s } else { self.start_s + point as f64 * self.step_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shorter last interval ends at the stop time; an interval that is longer by round-off alone is not split.
    #[test]
    fn the_last_point_is_the_stop_time() {
        let grid = Grid::new(0.1, 1.05, 0.3);
        assert_eq!((grid.steps, grid.time_s(3), grid.time_s(4)), (4, 0.1 + 3.0 * 0.3, 1.05));
        let even = Grid::new(0.0, 0.3, 0.1);
        assert_eq!((even.steps, even.time_s(3)), (3, 0.3));
        assert_eq!(Grid::new(0.0, 0.1, 5.0).steps, 1);
    }
}
