//! Integrals over a run: means of outputs and of their squares, eq. (X20), and energy accounts, eq. (X22).

use crate::gradient::account::Account;
use crate::gradient::{RunResult, Tape};
use crate::solve::tableau::Tableau;
use crate::system::System;

/// Quantity that is integrated.
#[derive(Debug, Clone, Copy)]
pub(super) enum Integrand {
    /// An output.
    Output(usize),
    /// The square of an output.
    Square(usize),
    /// The power of an energy account.
    Power(Account),
}

/// A mean of an output or of its square, or an energy account, from the start of the run to a requested time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mean {
    pub integrand: Integrand,
    /// Index of the time among those requested, and the step in which it lies.
    pub time: usize,
    pub step: usize,
    /// Divisor of the integral: the length of the run up to that time in s for a mean, otherwise 1.
    pub divisor: f64,
}

impl Mean {
    /// The integral of a result; `None` for results that are not integrals.
    pub fn of(result: RunResult, tape: &Tape, system: &System) -> Option<Self> {
        let (integrand, time) = match result {
            RunResult::Mean { index, time, square: false } => (Integrand::Output(index), time),
            RunResult::Mean { index, time, square: true } => (Integrand::Square(index), time),
            RunResult::Output { index, time } => (Integrand::Power(Account::of(system, index)?), time),
            RunResult::LatchTime { .. } | RunResult::Impulse { .. } => return None,
        };
        let mark = tape.marks.get(time)?;
        let divisor = match integrand {
            Integrand::Output(_) | Integrand::Square(_) => tape.point(time).time_s - tape.steps.first()?.start.time_s,
            Integrand::Power(_) => 1.0,
        };
        Some(Self { integrand, time, step: mark.step, divisor })
    }

    /// The energy account, if it is one.
    pub fn account(&self) -> Option<Account> {
        match self.integrand {
            Integrand::Power(account) => Some(account),
            Integrand::Output(_) | Integrand::Square(_) => None,
        }
    }

    /// The output whose mean it is.
    pub fn output(&self) -> Option<usize> {
        match self.integrand {
            Integrand::Output(index) | Integrand::Square(index) => Some(index),
            Integrand::Power(_) => None,
        }
    }

    /// The integrated quantity, and its slope with respect to the output or power.
    pub fn integrand(&self, value: f64) -> [f64; 2] {
        match self.integrand {
            Integrand::Square(_) => [value * value, 2.0 * value],
            Integrand::Output(_) | Integrand::Power(_) => [value, 1.0],
        }
    }

    /// Weight of a stage per length of its step.
    pub fn share(&self, tableau: &Tableau, stage: usize) -> f64 {
        let last = tableau.rows[tableau.stages() - 2];
        last.get(stage).copied().unwrap_or(tableau.gamma) / self.divisor
    }
}
