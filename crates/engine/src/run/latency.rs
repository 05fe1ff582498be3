//! Durations of communication steps, for real-time loops. The engine never reads a clock: the caller of the plant records the durations,
//! which are not part of its state.

/// Number of histogram classes per doubling of the duration: quantiles are accurate to 1/16 of a doubling, 4.5 %.
const PER_DOUBLING: f64 = 16.0;
/// Upper end of the first class in s.
const SHORTEST_S: f64 = 1e-7;
/// Number of classes: up to `1e-7 · 2^(400/16)` s, 3.4 s.
const CLASSES: usize = 401;

/// Number of the recorded durations, the last, the longest, and quantiles. Recording allocates nothing.
#[derive(Debug, Clone)]
pub struct Latency {
    counts: Vec<u64>,
    steps: u64,
    last_s: f64,
    slowest_s: f64,
}

impl Default for Latency {
    fn default() -> Self {
        Self { counts: vec![0; CLASSES], steps: 0, last_s: 0.0, slowest_s: 0.0 }
    }
}

impl Latency {
    /// Deletes all records.
    pub fn clear(&mut self) {
        self.counts.fill(0);
        (self.steps, self.last_s, self.slowest_s) = (0, 0.0, 0.0);
    }

    /// Records the duration of one step in s.
    pub fn record(&mut self, duration_s: f64) {
        self.last_s = duration_s;
        self.slowest_s = self.slowest_s.max(self.last_s);
        self.steps += 1;
        // a negative or infinite logarithm saturates in the conversion
        let class = ((self.last_s / SHORTEST_S).log2() * PER_DOUBLING).ceil() as usize;
        self.counts[class.min(CLASSES - 1)] += 1;
    }

    /// Number of recorded steps.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Duration of the last step in s; 0 before the first.
    pub fn last_s(&self) -> f64 {
        self.last_s
    }

    /// Largest duration in s; 0 before the first.
    pub fn slowest_s(&self) -> f64 {
        self.slowest_s
    }

    /// Duration in s not exceeded by the fraction `share` of the steps, overestimated by at most 4.5 %, and never above the longest; 0
    /// before the first.
    pub fn quantile_s(&self, share: f64) -> f64 {
        let wanted = (share * self.steps as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (class, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                return (SHORTEST_S * (class as f64 / PER_DOUBLING).exp2()).min(self.slowest_s);
            }
        }
        self.slowest_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of 1 to 1000 µs are at most one class, 4.5 %, above the exact ones; the slowest and the last are exact.
    #[test]
    fn quantiles_are_within_a_class() {
        let mut latency = Latency::default();
        assert_eq!(latency.quantile_s(0.5), 0.0);
        // in an irregular order
        (0..1000u64).for_each(|i| latency.record(1e-6 * (i * 389 % 1000 + 1) as f64));
        for share in [0.001, 0.1, 0.5, 0.99, 0.999] {
            let (exact_s, found_s) = (share * 1e-3, latency.quantile_s(share));
            assert!(found_s >= exact_s * (1.0 - 1e-12) && found_s < exact_s * 1.0443, "{share}: {found_s}");
        }
        assert_eq!((latency.steps(), latency.slowest_s()), (1000, 1e-6 * 1000.0));
        assert_eq!(latency.quantile_s(1.0), latency.slowest_s());
        assert_eq!(latency.last_s(), 1e-6 * (999 * 389 % 1000 + 1) as f64);
    }

    /// Durations beyond all classes are counted in the outermost ones.
    #[test]
    fn extremes_are_counted() {
        let mut latency = Latency::default();
        [0.0, 1e-9, 10.0].into_iter().for_each(|duration_s| latency.record(duration_s));
        assert_eq!((latency.steps(), latency.slowest_s()), (3, 10.0));
        assert!(latency.quantile_s(0.5) <= SHORTEST_S && latency.quantile_s(1.0) > 3.0);
        latency.clear();
        assert_eq!((latency.steps(), latency.slowest_s(), latency.last_s()), (0, 0.0, 0.0));
    }
}
