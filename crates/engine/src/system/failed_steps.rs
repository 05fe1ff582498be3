//! Advice if the convergence of Newton's method, and not the tolerance, limits the step size.

use crate::system::Statistics;

/// Number of failed steps below which no advice is given: releases and latches cause some.
const FEW: u64 = 100;
/// Fraction of failed steps above which advice is given. If Newton's method fails at all step sizes that meet the tolerance, a failure
/// divides the step by four and a success allows three times its length: about 0.8 of the steps fail. In a run with steps limited by the
/// tolerance one in a hundred fails.
const SHARE: f64 = 0.2;

impl Statistics {
    /// Whether Newton's method has failed so often that it limits the step size.
    pub fn newton_decides(&self) -> bool {
        self.failures >= FEW && self.failures as f64 >= SHARE * self.steps as f64
    }

    /// Returns the advice if [`Self::newton_decides`] is true.
    pub fn advice_on_failures(&self) -> Option<String> {
        let Self { failures, steps, .. } = self;
        self.newton_decides().then(|| {
            format!(
                "Newton's method did not converge in {failures} steps, in addition to {steps} accepted ones: \
                 convergence rather than the tolerance limits the step size. The result meets the tolerance, but at \
                 many times the usual cost. Thin, stiff bodies cause this; solver.method = \"generalized_alpha\" \
                 usually avoids it, and stiffness_damping_s on these bodies reduces it"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_told_where_they_decide() {
        let told =
            |failures, steps| Statistics { failures, steps, ..Statistics::default() }.advice_on_failures().is_some();
        assert_eq!([told(99, 100), told(100, 500), told(100, 501), told(5000, 9000)], [false, true, false, true]);
    }
}
