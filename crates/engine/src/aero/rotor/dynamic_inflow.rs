//! Dynamic inflow: the induced velocity lags behind the momentum balance because the wake takes time to develop.
//!
//! Source: Øye's model as in Snel and Schepers, *Joint investigation of dynamic inflow effects and implementation of an engineering
//! method*, ECN-C-94-107 (1995). The time constants and their limits are those of AeroDyn's `DBEMT_Mod` 2.

use crate::aero::pieces::Pieces;
use serde::{Deserialize, Serialize};

/// Fraction `k` of changes of the quasi-steady velocity that bypasses the first lag.
const DIRECT: f64 = 0.6;
/// Largest mean axial induction factor used in the time constant, which would be infinite at 0.77.
const MAXIMUM_INDUCTION: f64 = 0.5;
/// Smallest mean wind through the disc used in the time constant, in m/s.
const MINIMUM_WIND_M_S: f64 = 0.1;
/// Largest time constant in s.
const MAXIMUM_TIME_S: f64 = 100.0;

/// Induced velocity at a node: from the momentum balance, after the first lag, and after both lags.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct InflowState {
    /// Quasi-steady velocity from the momentum balance in m/s, axial and tangential.
    pub balanced_m_s: [f64; 2],
    /// Velocity after the first lag in m/s.
    pub middle_m_s: [f64; 2],
    /// Velocity after both lags in m/s, which acts at the section.
    pub acting_m_s: [f64; 2],
    /// Current time constants of the two lags in s; 0 without lags.
    pub lags_s: [f64; 2],
}

/// First time constant in s, from the rotor radius, the mean axial induction factor and the mean wind along the shaft, eq. (B9).
pub fn time_constant_s(radius_m: f64, mean_induction: f64, wind_m_s: f64) -> f64 {
    time_constant_on_s(radius_m, mean_induction, wind_m_s, &mut Pieces::Free)
}

/// The same on pieces of its limits.
pub fn time_constant_on_s(radius_m: f64, mean_induction: f64, wind_m_s: f64, pieces: &mut Pieces) -> f64 {
    let induction = pieces.least(mean_induction, MAXIMUM_INDUCTION);
    let slowed_m_s = (1.0 - 1.3 * induction) * pieces.most(wind_m_s.abs(), MINIMUM_WIND_M_S);
    pieces.least(1.1 * radius_m / slowed_m_s, MAXIMUM_TIME_S)
}

/// Both time constants in s from the first one, at a radius relative to the rotor radius, eq. (B10).
pub fn lags_s(first_s: f64, span: f64) -> [f64; 2] {
    lags_on_s(first_s, span, &mut Pieces::Free)
}

/// The same on pieces of its limit.
pub fn lags_on_s(first_s: f64, span: f64, pieces: &mut Pieces) -> [f64; 2] {
    let span = pieces.least(span, 1.0);
    [first_s, (0.39 - 0.26 * span * span) * first_s]
}

impl InflowState {
    /// State of a fully developed flow.
    pub fn established(balanced_m_s: [f64; 2]) -> Self {
        Self { balanced_m_s, middle_m_s: balanced_m_s, acting_m_s: balanced_m_s, lags_s: [0.0; 2] }
    }

    /// Direct fraction of the balance in m/s, axial (0) or tangential (1).
    pub(super) fn direct_m_s(&self, axis: usize) -> f64 {
        DIRECT * self.balanced_m_s[axis]
    }

    /// Replaces the velocity after the first lag by the state of eq. (B31): the direct fraction of the balance is subtracted.
    pub fn reduced(&self) -> Self {
        let middle_m_s = std::array::from_fn(|axis| self.middle_m_s[axis] - self.direct_m_s(axis));
        Self { middle_m_s, ..*self }
    }

    /// The inverse of [`InflowState::reduced`] for the balance `balanced_m_s`.
    pub fn balanced(&self, balanced_m_s: [f64; 2]) -> Self {
        let middle_m_s = std::array::from_fn(|axis| self.middle_m_s[axis] + DIRECT * balanced_m_s[axis]);
        Self { balanced_m_s, middle_m_s, ..*self }
    }

    /// Rates in m/s² of the states of eq. (B31), reduced and acting, axial and tangential each.
    pub fn rates_m_s2(&self, first_s: f64, span: f64) -> [[f64; 2]; 2] {
        let [first_s, second_s] = lags_s(first_s, span);
        [
            std::array::from_fn(|axis| (self.balanced_m_s[axis] - self.middle_m_s[axis]) / first_s),
            std::array::from_fn(|axis| (self.middle_m_s[axis] - self.acting_m_s[axis]) / second_s),
        ]
    }

    /// State one step later for the momentum balance `balanced_m_s`, eq. (B10): exact if the balance changes linearly over the step.
    /// `lags_s` are the time constants during the step.
    pub fn after(&self, balanced_m_s: [f64; 2], step_s: f64, lags_s: [f64; 2]) -> Self {
        let [first_s, second_s] = lags_s;
        let share = second_s / first_s;
        let mut next = Self { balanced_m_s, lags_s, ..*self };
        if step_s <= 0.0 {
            return next;
        }
        let (first, second) = ((-step_s / first_s).exp(), (-step_s / second_s).exp());
        for (axis, balanced_m_s) in balanced_m_s.iter().enumerate() {
            let rate = (balanced_m_s - self.balanced_m_s[axis]) / step_s;
            // after the first lag: level + rate (t − τ1) + decay e^(−t/τ1)
            let level = self.balanced_m_s[axis] + DIRECT * first_s * rate;
            let decay = self.middle_m_s[axis] - level + rate * first_s;
            next.middle_m_s[axis] = level + rate * (step_s - first_s) + decay * first;
            let passed = decay / (1.0 - share);
            let rest = self.acting_m_s[axis] - passed - level + rate * (first_s + second_s);
            next.acting_m_s[axis] = level + rate * (step_s - first_s - second_s) + passed * first + rest * second;
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with a Runge-Kutta solution of both equations of Øye's model with 2000 steps, for a curved input: second order in the step.
    #[test]
    fn inflow_follows_oyes_equations() {
        let (first_s, span) = (7.0, 0.6f64);
        let second_s = (0.39 - 0.26 * span * span) * first_s;
        let input = |t: f64| 3.0 + (0.8 * t).sin();
        let rate = |t: f64| 0.8 * (0.8 * t).cos();
        let derivative = |t: f64, [middle, acting]: [f64; 2]| {
            [(input(t) + 0.6 * first_s * rate(t) - middle) / first_s, (middle - acting) / second_s]
        };
        let (mut x, mut t, h) = ([1.0, 2.0], 0.0, 0.005);
        for _ in 0..2000 {
            let at = |x: [f64; 2], k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
            let k1 = derivative(t, x);
            let k2 = derivative(t + h / 2.0, at(x, k1, h / 2.0));
            let k3 = derivative(t + h / 2.0, at(x, k2, h / 2.0));
            let k4 = derivative(t + h, at(x, k3, h));
            for i in 0..2 {
                x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
            t += h;
        }
        let error = |steps: usize| {
            let step_s = 10.0 / steps as f64;
            let start = InflowState {
                balanced_m_s: [input(0.0), 0.0],
                middle_m_s: [1.0, 0.0],
                acting_m_s: [2.0, 0.0],
                lags_s: lags_s(first_s, span),
            };
            let end = (1..=steps).fold(start, |state, step| {
                state.after([input(step as f64 * step_s), 0.0], step_s, lags_s(first_s, span))
            });
            assert_eq!((end.middle_m_s[1], end.acting_m_s[1]), (0.0, 0.0));
            (end.middle_m_s[0] - x[0]).abs().max((end.acting_m_s[0] - x[1]).abs())
        };
        let (coarse, fine) = (error(100), error(200));
        assert!(coarse < 2e-3 && (3.5..4.5).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }

    #[test]
    fn constant_balance_is_reached_and_kept() {
        let still = InflowState { lags_s: lags_s(6.0, 0.5), ..InflowState::established([4.0, 0.5]) };
        assert_eq!(still.after([4.0, 0.5], 0.02, lags_s(6.0, 0.5)), still);
        let late = (0..4000).fold(InflowState::default(), |state, _| state.after([4.0, 0.5], 0.02, lags_s(6.0, 1.0)));
        approx::assert_relative_eq!(late.acting_m_s[0], 4.0, max_relative = 1e-4);
    }

    #[test]
    fn time_constant_has_its_limits() {
        approx::assert_relative_eq!(time_constant_s(63.0, 0.3, 8.0), 1.1 * 63.0 / (0.61 * 8.0), max_relative = 1e-14);
        assert_eq!(time_constant_s(63.0, 2.0, 8.0), time_constant_s(63.0, 0.5, 8.0));
        // wind from the other side: the mirror image
        assert_eq!(time_constant_s(63.0, 0.3, -8.0), time_constant_s(63.0, 0.3, 8.0));
    }
}
