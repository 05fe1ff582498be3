//! Figures of a live simulation for its user.

/// Figures of a live simulation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Summary {
    /// Simulated time in s, over all rollbacks.
    pub simulated_s: f64,
    /// Wall time in s for which the clock ran.
    pub ran_s: f64,
    /// Lost wall time in s.
    pub lost_s: f64,
    /// Largest delay behind the clock in s of wall time.
    pub latest_s: f64,
    /// Longest communication step in s of wall time.
    pub slowest_s: f64,
    /// Communication steps.
    pub steps: u64,
    /// Pictures.
    pub pictures: u64,
}
