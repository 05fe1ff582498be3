//! Statistics of a live simulation.

/// Statistics of a live simulation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Summary {
    /// Simulated time in s, including parts that were rolled back.
    pub simulated_s: f64,
    /// Wall time in s for which the clock ran.
    pub ran_s: f64,
    /// Lost wall time in s.
    pub lost_s: f64,
    /// Largest delay relative to the clock in s of wall time.
    pub latest_s: f64,
    /// Longest computing time of a communication step in s of wall time.
    pub slowest_s: f64,
    /// Number of communication steps.
    pub steps: u64,
    /// Number of frames.
    pub frames: u64,
}
