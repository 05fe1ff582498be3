//! Pace of the simulation relative to the wall clock: never ahead of it, and long delays are counted as lost time.

use std::collections::VecDeque;
use std::time::Duration;

/// Maximum delay in s of wall time that the simulation catches up; a longer delay is counted as lost time.
const LARGEST_DELAY_S: f64 = 0.25;

/// Span in s of wall time over which the real-time factor is measured.
const SPAN_S: f64 = 1.0;

/// Clock of a simulation. All wall times are measured from the same start.
#[derive(Debug, Clone)]
pub(super) struct Pace {
    /// Simulated seconds per second of wall time.
    speed: f64,
    /// Wall time and simulated time when the clock was started; `None` while it is stopped.
    began: Option<(Duration, f64)>,
    /// Wall and simulated times of the last [`SPAN_S`], for the real-time factor.
    seen: VecDeque<(Duration, f64)>,
    /// Lost wall time in s.
    lost_s: f64,
    /// Largest delay in s of wall time so far.
    latest_s: f64,
    /// Wall time in s for which the clock has run.
    ran_s: f64,
}

impl Pace {
    /// Creates a stopped clock.
    pub fn new(speed: f64) -> Self {
        Self { speed, began: None, seen: VecDeque::new(), lost_s: 0.0, latest_s: 0.0, ran_s: 0.0 }
    }

    /// Returns whether the clock runs.
    pub fn runs(&self) -> bool {
        self.began.is_some()
    }

    /// Requested simulated seconds per second of wall time.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Lost wall time in s since the start.
    pub fn lost_s(&self) -> f64 {
        self.lost_s
    }

    /// Largest delay since the start in s of wall time.
    pub fn latest_s(&self) -> f64 {
        self.latest_s
    }

    /// Wall time in s for which the clock has run, up to the last [`Self::catch_up`].
    pub fn ran_s(&self) -> f64 {
        self.ran_s
    }

    /// Starts the clock at the simulated time `time_s`.
    pub fn start(&mut self, wall: Duration, time_s: f64) {
        self.began = Some((wall, time_s));
        self.seen.clear();
        self.seen.push_back((wall, time_s));
    }

    /// Stops the clock.
    pub fn stop(&mut self) {
        self.began = None;
    }

    /// Changes the speed from now on.
    pub fn set_speed(&mut self, speed: f64, wall: Duration, time_s: f64) {
        self.speed = speed;
        if self.runs() {
            self.start(wall, time_s);
        }
    }

    /// Simulated time in s that should have been reached; minus infinity while the clock is stopped.
    pub fn due_s(&self, wall: Duration) -> f64 {
        self.began
            .map_or(f64::NEG_INFINITY, |(begin, from_s)| from_s + self.speed * wall.saturating_sub(begin).as_secs_f64())
    }

    /// Remaining wall time until a simulated time is due; `None` while the clock is stopped.
    pub fn until(&self, time_s: f64, wall: Duration) -> Option<Duration> {
        self.began?;
        Duration::try_from_secs_f64(((time_s - self.due_s(wall)) / self.speed).max(0.0)).ok()
    }

    /// Records the simulated time reached; the next step ends `step_s` later. A delay above [`LARGEST_DELAY_S`] is
    /// counted as lost.
    pub fn catch_up(&mut self, wall: Duration, reached_s: f64, step_s: f64) {
        if !self.runs() {
            return;
        }
        if let Some((last, _)) = self.seen.back() {
            self.ran_s += wall.saturating_sub(*last).as_secs_f64();
        }
        self.seen.push_back((wall, reached_s));
        while self.seen.len() > 2 && wall.saturating_sub(self.seen[1].0).as_secs_f64() >= SPAN_S {
            self.seen.pop_front();
        }
        let delay_s = (self.due_s(wall) - reached_s - step_s) / self.speed;
        self.latest_s = self.latest_s.max(delay_s);
        if delay_s > LARGEST_DELAY_S {
            self.lost_s += delay_s;
            self.began = Some((wall, reached_s));
        }
    }

    /// Ratio of simulated to wall time over the last second; `None` while the clock is stopped or has just started.
    pub fn factor(&self) -> Option<f64> {
        let (first, last) = (self.seen.front()?, self.seen.back()?);
        let wall_s = last.0.saturating_sub(first.0).as_secs_f64();
        (self.runs() && wall_s > 0.2 * SPAN_S).then(|| (last.1 - first.1) / wall_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(time_s: f64) -> Duration {
        Duration::from_secs_f64(time_s)
    }

    /// The due time grows with the speed from the start of the clock, and does not grow while the clock is stopped.
    #[test]
    fn time_is_due_by_the_clock() {
        let mut pace = Pace::new(2.0);
        assert_eq!((pace.due_s(wall(5.0)), pace.until(1.0, wall(5.0))), (f64::NEG_INFINITY, None));
        pace.start(wall(1.0), 10.0);
        assert_eq!((pace.due_s(wall(1.0)), pace.due_s(wall(1.5))), (10.0, 11.0));
        assert_eq!(pace.until(12.0, wall(1.5)), Some(wall(0.5)));
        pace.set_speed(0.5, wall(1.5), 11.0);
        assert_eq!(pace.due_s(wall(2.5)), 11.5);
        pace.stop();
        assert_eq!(pace.due_s(wall(9.0)), f64::NEG_INFINITY);
    }

    /// A short delay is caught up; a long one is counted as lost time and reduces the factor.
    #[test]
    fn long_delays_are_given_up() {
        let mut pace = Pace::new(1.0);
        pace.start(wall(0.0), 0.0);
        pace.catch_up(wall(0.1), 0.0, 0.01);
        assert_eq!((pace.lost_s(), pace.due_s(wall(0.1))), (0.0, 0.1));
        assert!((pace.latest_s() - 0.09).abs() < 1e-12);
        pace.catch_up(wall(1.0), 0.5, 0.0);
        assert_eq!((pace.lost_s(), pace.due_s(wall(1.0)), pace.factor()), (0.5, 0.5, Some(0.5)));
        // run at half speed for three more seconds: the factor is that of the last second
        (1..=30).for_each(|i| pace.catch_up(wall(1.0 + 0.1 * f64::from(i)), 0.5 + 0.08 * f64::from(i), 0.0));
        assert!((pace.factor().unwrap() - 0.8).abs() < 0.01, "{:?}", pace.factor());
        assert!((pace.ran_s() - 4.0).abs() < 1e-9);
    }
}
