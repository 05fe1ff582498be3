//! Recorded variables of a run for the page with the animation: single precision, thinned at equal intervals.

use crate::recording::Thinning;

/// Maximum number of values of all signals of a run, including the times.
const MAXIMUM_NUMBERS: u64 = 450_000;

/// Variables over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Signals {
    /// Names and units, in the order of the values.
    pub columns: Vec<(String, String)>,
    /// Rows: time in s, then the values.
    pub rows: Vec<f32>,
    /// Communication points so far.
    pub points: u64,
    thinning: Thinning,
}

impl Signals {
    /// Signals of a run of `steps` steps.
    pub fn new(columns: impl IntoIterator<Item = (String, String)>, steps: u64) -> Self {
        let columns: Vec<_> = columns.into_iter().collect();
        let most = (MAXIMUM_NUMBERS / (columns.len() as u64 + 1)).max(2);
        Self { columns, rows: Vec::new(), points: 0, thinning: Thinning::new(steps, most) }
    }

    /// Adds the values at a communication point.
    pub fn include(&mut self, time_s: f64, values: impl Iterator<Item = f64>) {
        self.points += 1;
        if self.thinning.keeps() {
            self.rows.push(time_s as f32);
            self.rows.extend(values.map(|value| value as f32));
        }
    }

    /// Number of rows kept.
    pub fn kept(&self) -> usize {
        self.rows.len() / (self.columns.len() + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Many signals over a long run stay within the bound and keep both ends; short runs are complete.
    #[test]
    fn long_runs_are_thinned_and_short_ones_are_not() {
        let columns = |count: usize| (0..count).map(|i| (format!("s{i}"), "m".to_owned()));
        for (count, steps, whole) in [(3, 1000, true), (300, 10_000, false), (6000, 10_000, false)] {
            let mut signals = Signals::new(columns(count), steps);
            for point in 0..=steps {
                signals.include(point as f64, (0..count).map(|_| 1.0));
            }
            assert_eq!((signals.points, signals.kept() as u64 == steps + 1), (steps + 1, whole));
            assert!(signals.rows.len() as u64 <= MAXIMUM_NUMBERS + 2 * (count as u64 + 1), "{}", signals.rows.len());
            let last = signals.rows[signals.rows.len() - count - 1];
            assert_eq!((signals.rows[0], last), (0.0, steps as f32));
        }
    }
}
