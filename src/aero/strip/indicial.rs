//! Growth of lift after a step of the downwash: exponential fits to the functions of Wagner and Küssner, and the states
//! that carry them through time.

use serde::{Deserialize, Serialize};

/// Terms of the fits.
const TERMS: usize = 3;

/// `1 − Σ a_i exp(−b_i s)`, `s` the way in semi-chords: eq. (W5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Indicial {
    /// Weights `a_i`.
    pub weights: [f64; TERMS],
    /// Rates `b_i` per semi-chord.
    pub rates: [f64; TERMS],
}

impl Indicial {
    /// Wagner's function by R. T. Jones (NACA Report 681, 1940), two terms: within 0.0097 of the exact one, which tends to
    /// 1 more slowly than any exponential.
    pub const WAGNER: Self = Self { weights: [0.165, 0.335, 0.0], rates: [0.0455, 0.3, 1.0] };

    /// Küssner's function by R. T. Jones (the same report, infinite aspect ratio): within 0.0125 of the exact one from a
    /// semi-chord on. It starts at 0.08, the exact one at 0 with an infinite slope.
    pub const KUESSNER: Self = Self { weights: [0.236, 0.513, 0.171], rates: [0.058, 0.364, 2.42] };

    /// Value after a way in semi-chords.
    pub fn at(&self, way: f64) -> f64 {
        1.0 - self.weights.iter().zip(self.rates).map(|(weight, rate)| weight * (-rate * way).exp()).sum::<f64>()
    }

    /// Downwash that the lift has answered to by now, in m/s: eq. (W6).
    pub fn effective_m_s(&self, downwash_m_s: f64, lag: &Lag) -> f64 {
        let missing: f64 = self.weights.iter().zip(lag.followers_m_s).map(|(a, x)| a * (downwash_m_s - x)).sum();
        downwash_m_s - missing
    }
}

/// First-order followers `x_i` of a downwash, `dx_i/ds = b_i (w − x_i)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Lag {
    /// Downwash at the last step in m/s.
    pub downwash_m_s: f64,
    /// Followers in m/s.
    pub followers_m_s: [f64; TERMS],
}

impl Lag {
    /// Nothing has answered yet: the step from zero to this downwash happens now.
    pub fn sudden(downwash_m_s: f64) -> Self {
        Self { downwash_m_s, followers_m_s: [0.0; TERMS] }
    }

    /// This downwash has lasted for ever.
    pub fn established(downwash_m_s: f64) -> Self {
        Self { downwash_m_s, followers_m_s: [downwash_m_s; TERMS] }
    }

    /// After a way in semi-chords on which the downwash grows linearly to `downwash_m_s`: exact, eq. (W6).
    pub fn advanced(&self, indicial: &Indicial, way: f64, downwash_m_s: f64) -> Self {
        let growth_m_s = downwash_m_s - self.downwash_m_s;
        let mut followers_m_s = self.followers_m_s;
        for (follower_m_s, rate) in followers_m_s.iter_mut().zip(indicial.rates) {
            let exponent = rate * way;
            let behind_m_s = (self.downwash_m_s - *follower_m_s) * (-exponent).exp();
            *follower_m_s = downwash_m_s - behind_m_s - growth_m_s * mean_decay(exponent);
        }
        Self { downwash_m_s, followers_m_s }
    }
}

/// `(1 − exp(−x))/x`, 1 at zero: mean of the decay over a step.
fn mean_decay(x: f64) -> f64 {
    // below this x/2 is lost beside 1
    if x < 1e-16 { 1.0 } else { -(-x).exp_m1() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// A step that lasts: followers give the fit itself, whatever the steps in between.
    #[test]
    fn lag_after_a_sudden_start_is_the_indicial_function() {
        for indicial in [Indicial::WAGNER, Indicial::KUESSNER] {
            let mut lag = Lag::sudden(2.0);
            for way in [0.01, 0.5, 3.0, 0.0] {
                lag = lag.advanced(&indicial, way, 2.0);
            }
            assert_relative_eq!(indicial.effective_m_s(2.0, &lag), 2.0 * indicial.at(3.51), max_relative = 1e-14);
        }
    }

    /// Duhamel's integral of a ramp in closed form; one step and many give the same.
    #[test]
    fn lag_is_exact_for_a_ramp() {
        let indicial = Indicial::WAGNER;
        let exact = |s: f64| {
            s - indicial.weights.iter().zip(indicial.rates).map(|(a, b)| a * (1.0 - (-b * s).exp()) / b).sum::<f64>()
        };
        for steps in [1, 2, 7] {
            let mut lag = Lag::default();
            for i in 1..=steps {
                lag = lag.advanced(&indicial, 5.0 / f64::from(steps), 5.0 * f64::from(i) / f64::from(steps));
            }
            assert_relative_eq!(indicial.effective_m_s(5.0, &lag), exact(5.0), max_relative = 1e-14);
        }
    }

    #[test]
    fn established_lag_stays() {
        let lag = Lag::established(3.0).advanced(&Indicial::WAGNER, 2.0, 3.0);
        assert_eq!(Indicial::WAGNER.effective_m_s(3.0, &lag), 3.0);
    }
}
