//! Growth of lift after a step of the downwash: exponential fits to the functions of Wagner and Küssner, and their lag states.

use serde::{Deserialize, Serialize};

/// Number of terms of the longest fit.
const TERMS: usize = 5;

/// Indicial function `1 − Σ a_i exp(−b_i s)` of the distance `s` travelled in semi-chords: eq. (W5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Indicial {
    /// Weights `a_i`.
    pub weights: [f64; TERMS],
    /// Decay rates `b_i` per semi-chord.
    pub rates: [f64; TERMS],
    /// Number of terms in use.
    pub terms: usize,
}

/// Fits to the functions of Wagner and Küssner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fit {
    /// R. T. Jones: two and three terms.
    #[default]
    Jones,
    /// Five terms each, an order of magnitude closer.
    Fine,
}

impl Fit {
    /// Lift growth after a step of the downwash due to motion.
    pub const fn wagner(self) -> &'static Indicial {
        match self {
            Self::Jones => &Indicial::WAGNER,
            Self::Fine => &Indicial::WAGNER_FINE,
        }
    }

    /// Lift growth after the entry into a gust.
    pub const fn kuessner(self) -> &'static Indicial {
        match self {
            Self::Jones => &Indicial::KUESSNER,
            Self::Fine => &Indicial::KUESSNER_FINE,
        }
    }
}

impl Indicial {
    /// Wagner's function by R. T. Jones (NACA Report 681, 1940), two terms: within 0.0097 of the exact function, which tends to 1 more
    /// slowly than any exponential.
    pub const WAGNER: Self =
        Self { weights: [0.165, 0.335, 0.0, 0.0, 0.0], rates: [0.0455, 0.3, 1.0, 1.0, 1.0], terms: 2 };

    /// Küssner's function by R. T. Jones (same report, infinite aspect ratio): within 0.0125 of the exact function from a semi-chord on.
    /// The fit starts at 0.08, the exact function at 0 with infinite slope.
    pub const KUESSNER: Self =
        Self { weights: [0.236, 0.513, 0.171, 0.0, 0.0], rates: [0.058, 0.364, 2.42, 1.0, 1.0], terms: 3 };

    /// Wagner's function, five terms fitted to Theodorsen's function: within 0.0006 of `C(k)` at every frequency (Jones' fit: 0.0146).
    pub const WAGNER_FINE: Self = Self {
        weights: [0.006805, 0.039336, 0.155977, 0.233224, 0.064658],
        rates: [0.002342, 0.019585, 0.084266, 0.252716, 0.783242],
        terms: 5,
    };

    /// Küssner's function, five terms fitted to Sears' function with the phase at the leading edge: within 0.0062 of it up to a reduced
    /// frequency of 20 (Jones' fit: 0.038; its weights add up to 0.92), and 0 at the entry.
    pub const KUESSNER_FINE: Self = Self {
        weights: [0.058405, 0.338863, 0.370682, 0.151968, 0.080082],
        rates: [0.017491, 0.128321, 0.517404, 3.144492, 39.217024],
        terms: 5,
    };

    /// Pairs of weight and rate in use.
    fn pairs(&self) -> impl Iterator<Item = (f64, f64)> {
        self.weights.into_iter().zip(self.rates).take(self.terms)
    }

    /// Value at a distance in semi-chords.
    pub fn at(&self, distance: f64) -> f64 {
        1.0 - self.pairs().map(|(weight, rate)| weight * (-rate * distance).exp()).sum::<f64>()
    }

    /// Effective downwash for the lift, including the lag, in m/s: eq. (W6).
    pub fn effective_m_s(&self, downwash_m_s: f64, lag: &Lag) -> f64 {
        let missing: f64 = self.pairs().zip(lag.followers_m_s).map(|((a, _), x)| a * (downwash_m_s - x)).sum();
        downwash_m_s - missing
    }
}

/// First-order lag states `x_i` of a downwash, `dx_i/ds = b_i (w − x_i)`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Lag {
    /// Downwash at the last step in m/s.
    pub downwash_m_s: f64,
    /// Lag states in m/s.
    pub followers_m_s: [f64; TERMS],
}

impl Lag {
    /// Lag state just after the downwash has stepped from zero to this value.
    pub fn sudden(downwash_m_s: f64) -> Self {
        Self { downwash_m_s, followers_m_s: [0.0; TERMS] }
    }

    /// Lag state after a constant downwash of infinite duration.
    pub fn established(downwash_m_s: f64) -> Self {
        Self { downwash_m_s, followers_m_s: [downwash_m_s; TERMS] }
    }

    /// State after a distance in semi-chords over which the downwash changes linearly to `downwash_m_s`: exact, eq. (W6).
    pub fn advanced(&self, indicial: &Indicial, distance: f64, downwash_m_s: f64) -> Self {
        let growth_m_s = downwash_m_s - self.downwash_m_s;
        let mut followers_m_s = self.followers_m_s;
        for (follower_m_s, (_, rate)) in followers_m_s.iter_mut().zip(indicial.pairs()) {
            let exponent = rate * distance;
            let behind_m_s = (self.downwash_m_s - *follower_m_s) * (-exponent).exp();
            *follower_m_s = downwash_m_s - behind_m_s - growth_m_s * mean_decay(exponent);
        }
        Self { downwash_m_s, followers_m_s }
    }
}

/// `(1 − exp(−x))/x`, with the limit 1 at zero: mean of the decay over a step.
fn mean_decay(x: f64) -> f64 {
    // below this, x/2 is lost to round-off next to 1
    if x < 1e-16 { 1.0 } else { -(-x).exp_m1() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// After a sustained step of the downwash the lag states reproduce the fit itself, for any intermediate steps.
    #[test]
    fn lag_after_a_sudden_start_is_the_indicial_function() {
        for indicial in [Fit::Jones, Fit::Fine].map(|fit| [*fit.wagner(), *fit.kuessner()]).concat() {
            let mut lag = Lag::sudden(2.0);
            for distance in [0.01, 0.5, 3.0, 0.0] {
                lag = lag.advanced(&indicial, distance, 2.0);
            }
            assert_relative_eq!(indicial.effective_m_s(2.0, &lag), 2.0 * indicial.at(3.51), max_relative = 1e-14);
        }
    }

    /// Duhamel's integral of a ramp in closed form, for one step and for many.
    #[test]
    fn lag_is_exact_for_a_ramp() {
        let indicial = Indicial::WAGNER;
        let exact = |s: f64| s - indicial.pairs().map(|(a, b)| a * (1.0 - (-b * s).exp()) / b).sum::<f64>();
        for steps in [1, 2, 7] {
            let mut lag = Lag::default();
            for i in 1..=steps {
                lag = lag.advanced(&indicial, 5.0 / f64::from(steps), 5.0 * f64::from(i) / f64::from(steps));
            }
            assert_relative_eq!(indicial.effective_m_s(5.0, &lag), exact(5.0), max_relative = 1e-14);
        }
    }

    /// `K_n(p) e^p` or `I_n(p) e^−p`, `n` = 0 or 1, from their integrals by the trapezoidal rule, which converges
    /// geometrically.
    fn bessel(kind: char, n: f64, p: f64) -> f64 {
        let steps = 4000;
        let sum = |end: f64, term: &dyn Fn(f64) -> f64| -> f64 {
            let h = end / f64::from(steps);
            (0..=steps).map(|i| term(f64::from(i) * h) * if i % steps == 0 { 0.5 } else { 1.0 }).sum::<f64>() * h
        };
        match kind {
            'K' => sum(20.0, &|t: f64| (p * (1.0 - t.cosh())).exp() * (n * t).cosh()),
            _ => {
                sum(std::f64::consts::PI, &|t: f64| (p * (t.cos() - 1.0)).exp() * (n * t).cos()) / std::f64::consts::PI
            }
        }
    }

    /// Compares the fits with the exact functions of Theodorsen, `C = K₁/(K₀ + K₁)`, and Sears, `[C(I₀ − I₁) + I₁]e^−p`, on the positive
    /// real axis of the Laplace variable, where `1 − Σ a p/(p + b)` corresponds to `1 − Σ a e^−bs`.
    #[test]
    fn fits_are_as_close_as_they_say() {
        let error = |fit: Fit| {
            let mut worst = [0.0f64; 2];
            for i in 0..200 {
                let p = 10f64.powf(-3.0 + 4.3 * f64::from(i) / 199.0);
                let (k0, k1) = (bessel('K', 0.0, p), bessel('K', 1.0, p));
                let theodorsen = k1 / (k0 + k1);
                let (i0, i1) = (bessel('I', 0.0, p), bessel('I', 1.0, p));
                let sears = theodorsen * (i0 - i1) + i1;
                for ((indicial, exact), worst) in
                    [(fit.wagner(), theodorsen), (fit.kuessner(), sears)].into_iter().zip(&mut worst)
                {
                    let fitted = 1.0 - indicial.pairs().map(|(a, b)| a * p / (p + b)).sum::<f64>();
                    *worst = worst.max((fitted - exact).abs());
                }
            }
            worst
        };
        let (jones, fine) = (error(Fit::Jones), error(Fit::Fine));
        assert!(fine[0] < 6e-4 && fine[1] < 6.2e-3, "{fine:?}");
        assert!(jones[0] > 5.0 * fine[0] && jones[1] > 5.0 * fine[1], "{jones:?} against {fine:?}");
        for fit in [Fit::Jones, Fit::Fine] {
            assert!((fit.wagner().at(0.0) - 0.5).abs() < 1e-15, "half of the lift at once");
        }
        assert!(Fit::Fine.kuessner().at(0.0).abs() < 1e-15, "no lift at the entry");
    }

    #[test]
    fn established_lag_stays() {
        let lag = Lag::established(3.0).advanced(&Indicial::WAGNER, 2.0, 3.0);
        assert_eq!(Indicial::WAGNER.effective_m_s(3.0, &lag), 3.0);
    }
}
