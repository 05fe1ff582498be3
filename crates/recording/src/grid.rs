//! Communication points of a run.

/// Communication points at equal distances; the last interval may be shorter.
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
