//! One step by the chosen method.

use crate::solve::EquationsOfMotion;
use crate::solve::continuation::Continuation;
use crate::solve::explicit::Rk4;
use crate::solve::generalized_alpha::{GeneralizedAlpha, Parameters};
use crate::solve::newton::{Accuracy, Effort, NewtonError};
use crate::solve::point::Point;
use crate::solve::runge_kutta::Esdirk;
use crate::solve::tableau::{ESDIRK3, ESDIRK4, SDIRK2, TR_BDF2, Tableau};

/// Time integration method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Generalised-α, second order, with its spectral radius at infinity.
    GeneralizedAlpha {
        /// Spectral radius at infinity, in `[0, 1]`.
        rho_infinity: f64,
    },
    /// TR-BDF2, second order.
    TrBdf2,
    /// `ESDIRK3(2)4L[2]SA`, third order.
    Esdirk3,
    /// Two-stage SDIRK, second order: does not propagate a jump of the accelerations.
    Sdirk2,
    /// `ESDIRK4(3)6L[2]SA`, fourth order.
    Esdirk4,
    /// Classical explicit Runge–Kutta, fourth order, without error estimate.
    Rk4,
}

/// A method with its workspace.
#[derive(Debug, Clone)]
pub struct Stepper {
    method: Method,
    esdirk: Esdirk,
    generalized_alpha: GeneralizedAlpha,
    rk4: Rk4,
}

impl Method {
    /// Interpolation of states between the ends of a step from its stages.
    pub fn continuation(self) -> Continuation {
        self.tableau().map_or_else(Continuation::default, Continuation::of)
    }

    pub(crate) fn tableau(self) -> Option<&'static Tableau<'static>> {
        match self {
            Method::GeneralizedAlpha { .. } | Method::Rk4 => None,
            Method::TrBdf2 => Some(&TR_BDF2),
            Method::Esdirk3 => Some(&ESDIRK3),
            Method::Sdirk2 => Some(&SDIRK2),
            Method::Esdirk4 => Some(&ESDIRK4),
        }
    }
}

impl Stepper {
    /// Creates a method for `coordinates` unknowns.
    pub fn new(method: Method, coordinates: usize) -> Self {
        Self {
            method,
            esdirk: Esdirk::new(coordinates),
            generalized_alpha: GeneralizedAlpha::new(coordinates),
            rk4: Rk4::new(coordinates),
        }
    }

    /// Tableau of the method, if it is a diagonally implicit Runge–Kutta method.
    pub(crate) fn tableau(&self) -> Option<&'static Tableau<'static>> {
        self.method.tableau()
    }

    /// Whether states within a step require a separate step: implicit methods without stages.
    pub fn lands(&self) -> bool {
        matches!(self.method, Method::GeneralizedAlpha { .. })
    }

    /// Power of the step size to which the error estimate is proportional.
    pub fn error_order(&self) -> u32 {
        self.method.tableau().map_or(3, |tableau| tableau.error_order)
    }

    /// Remainder of the last attempt: the error estimate of a step, or the last correction of a failed iteration.
    pub fn remainder(&self) -> &[f64] {
        match self.method {
            Method::GeneralizedAlpha { .. } => self.generalized_alpha.remainder(),
            Method::Rk4 => self.rk4.remainder(),
            Method::TrBdf2 | Method::Esdirk3 | Method::Sdirk2 | Method::Esdirk4 => self.esdirk.remainder(),
        }
    }

    /// Performs one step of `h_s` from `start` to `end`, with its stages in between. Returns the error estimate in the kinematic norm.
    ///
    /// `accuracy` bounds the remaining displacement error of the iteration, in the same norm. Allocates nothing. After an error `end` and
    /// the stages are undefined and `start` is unchanged.
    pub fn step(
        &mut self,
        equations: &mut impl EquationsOfMotion,
        start: &Point,
        h_s: f64,
        (end, stages): (&mut Point, &mut [Point]),
        accuracy: Accuracy,
        effort: &mut Effort,
    ) -> Result<f64, NewtonError> {
        if self.method == Method::Rk4 {
            return self.rk4.step(equations, start, h_s, end, effort).map(|()| 0.0);
        }
        equations.take_pieces(start.time_s, &start.q, &start.v);
        let outcome = match (self.method.tableau(), self.method) {
            (None, Method::GeneralizedAlpha { rho_infinity }) => {
                let parameters = Parameters::new(rho_infinity);
                self.generalized_alpha.step(&parameters, equations, start, h_s, end, accuracy, effort)
            }
            (tableau, _) => {
                let tableau = tableau.unwrap_or(&ESDIRK4);
                self.esdirk.step(tableau, equations, start, h_s, (end, stages), accuracy, effort)
            }
        };
        equations.drop_pieces();
        outcome
    }
}
