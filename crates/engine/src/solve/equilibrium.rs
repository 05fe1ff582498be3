//! Static equilibrium: Newton's method with the exact tangent, under loads that are increased in steps.
//!
//! The whole load is tried first. The step is halved after a failure and doubled after a success; the next start is extrapolated from the
//! last two equilibria. NOTATION eqs. (L8)–(L9).

use crate::solve::Singular;

/// Static equations `residual(q, λ) = 0`, with their exact tangent.
///
/// All vectors have [`StaticEquations::coordinates`] entries.
pub trait StaticEquations {
    /// Number of coordinates.
    fn coordinates(&self) -> usize;

    /// Scales the loads: 0 is unloaded, 1 the requested case.
    fn load(&mut self, factor: f64);

    /// Computes the static residual; entries of held coordinates are zero.
    fn residual(&mut self, q: &[f64], residual: &mut [f64]);

    /// Linearises and factorises about the configuration of the last residual, with `shift_1_s2` times the mass matrix added to the
    /// stiffness. Returns the number of directions in which this matrix is negative.
    fn factorize(&mut self, q: &[f64], shift_1_s2: f64) -> Result<usize, Singular>;

    /// Solves in place with the last factorisation, for the change of the coordinates that corresponds to a residual.
    fn solve(&mut self, x: &mut [f64]);

    /// Kinematic norm of a change of coordinates at the configuration of the last residual: largest displacement divided by the model's
    /// length, or rotation in rad.
    fn norm(&mut self, change: &[f64]) -> f64;

    /// Inner product of two changes of the coordinates, which defines the arc length of paths: rotations in rad, and displacements divided
    /// by the model's length.
    fn product(&self, a: &[f64], b: &[f64]) -> f64;

    /// Projects coordinates onto their constraints.
    fn project(&mut self, q: &mut [f64]);
}

/// Settings of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Tolerance for the last correction in the kinematic norm. Newton's method converges quadratically: the remaining error is about the
    /// square of the correction.
    pub tolerance: f64,
    /// Largest correction in the kinematic norm; larger ones are shortened.
    pub longest_correction: f64,
    /// Maximum number of iterations per load step.
    pub iterations: usize,
    /// Smallest step of the load factor.
    pub smallest_step: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-8, longest_correction: 1.0, iterations: 30, smallest_step: 1e-4 }
    }
}

/// Effort spent on finding an equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effort {
    /// Number of converged load steps.
    pub load_steps: usize,
    /// Number of halved load steps.
    pub halvings: usize,
    /// Total number of iterations.
    pub iterations: usize,
}

/// Reason why Newton's method failed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Cause {
    /// The tangent is singular: a coordinate can move without resistance.
    #[error("no stiffness in coordinate {0}")]
    Singular(usize),
    /// The iteration did not converge in the allowed number of iterations.
    #[error("no convergence in {iterations} iterations, last correction {correction:.1e}")]
    NotConverged {
        /// Number of iterations.
        iterations: usize,
        /// Kinematic norm of the last correction.
        correction: f64,
    },
    /// The residual is NaN or infinite.
    #[error("the residual is not finite in iteration {0}")]
    NotFinite(usize),
    /// The descent did not reach a stable state.
    #[error("the search for a stable equilibrium did not converge in {0} iterations")]
    NoStableState(usize),
    /// The path of equilibria was followed without reaching the load.
    #[error("the equilibrium path does not reach the full load within {0} points")]
    PathTooLong(usize),
}

/// No equilibrium was found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("no equilibrium beyond the load factor {reached:.4}, last tried {tried:.4}: {cause}")]
pub struct NoEquilibrium {
    /// Largest load factor with an equilibrium.
    pub reached: f64,
    /// Load factor at which the search failed.
    pub tried: f64,
    /// Cause of the failure.
    pub cause: Cause,
}

/// Finds the equilibrium under the whole load on the path from the unloaded state `q`. After success `q` holds it and the equations are
/// evaluated there; after failure `q` holds the last equilibrium.
pub fn find(equations: &mut impl StaticEquations, q: &mut [f64], settings: Settings) -> Result<Effort, NoEquilibrium> {
    let mut effort = Effort::default();
    let (mut reached, mut step) = (0.0f64, 1.0f64);
    let mut before: Option<(f64, Vec<f64>)> = None;
    loop {
        let tried = if reached + step > 1.0 - 1e-12 { 1.0 } else { reached + step };
        let mut trial = q.to_vec();
        if let Some((factor, earlier)) = &before {
            let ahead = (tried - reached) / (reached - factor);
            trial.iter_mut().zip(earlier).for_each(|(trial, earlier)| *trial += ahead * (*trial - earlier));
            equations.project(&mut trial);
        }
        equations.load(tried);
        match iterate(equations, &mut trial, settings, &mut effort) {
            Ok(()) => {
                effort.load_steps += 1;
                before = Some((reached, q.to_vec()));
                q.copy_from_slice(&trial);
                reached = tried;
                if reached == 1.0 {
                    return Ok(effort);
                }
                step *= 2.0;
            }
            Err(cause) => {
                effort.halvings += 1;
                step = 0.5 * (tried - reached);
                if step < settings.smallest_step {
                    return Err(NoEquilibrium { reached, tried, cause });
                }
            }
        }
    }
}

/// Newton's method at one load factor. After success the equations are evaluated at `q`.
pub(super) fn iterate(
    equations: &mut impl StaticEquations,
    q: &mut [f64],
    settings: Settings,
    effort: &mut Effort,
) -> Result<(), Cause> {
    let mut change = vec![0.0; q.len()];
    let mut correction = f64::INFINITY;
    for iteration in 1..=settings.iterations {
        effort.iterations += 1;
        equations.residual(q, &mut change);
        if change.iter().any(|force| !force.is_finite()) {
            return Err(Cause::NotFinite(iteration));
        }
        equations.factorize(q, 0.0).map_err(|singular| Cause::Singular(singular.coordinate))?;
        equations.solve(&mut change);
        correction = equations.norm(&change);
        if !correction.is_finite() {
            return Err(Cause::NotFinite(iteration));
        }
        let share = (settings.longest_correction / correction).min(1.0);
        q.iter_mut().zip(&change).for_each(|(q, change)| *q -= share * change);
        equations.project(q);
        if correction <= settings.tolerance {
            equations.residual(q, &mut change);
            return Ok(());
        }
    }
    Err(Cause::NotConverged { iterations: settings.iterations, correction })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hinged bar of length 1 with a spring: `k q = λ P cos q`. With a spring the path from `q = 0` reaches one equilibrium; without one
    /// the tangent is singular there.
    struct Bar {
        stiffness: f64,
        load: f64,
        factor: f64,
        tangent: f64,
    }

    impl StaticEquations for Bar {
        fn coordinates(&self) -> usize {
            1
        }
        fn load(&mut self, factor: f64) {
            self.factor = factor;
        }
        fn residual(&mut self, q: &[f64], residual: &mut [f64]) {
            residual[0] = self.stiffness * q[0] - self.factor * self.load * q[0].cos();
            self.tangent = self.stiffness + self.factor * self.load * q[0].sin();
        }
        fn factorize(&mut self, _: &[f64], shift_1_s2: f64) -> Result<usize, Singular> {
            self.tangent += shift_1_s2;
            if self.tangent == 0.0 { Err(Singular { coordinate: 0 }) } else { Ok(usize::from(self.tangent < 0.0)) }
        }
        fn solve(&mut self, x: &mut [f64]) {
            x[0] /= self.tangent;
        }
        fn norm(&mut self, change: &[f64]) -> f64 {
            change[0].abs()
        }
        fn product(&self, a: &[f64], b: &[f64]) -> f64 {
            a[0] * b[0]
        }
        fn project(&mut self, _: &mut [f64]) {}
    }

    #[test]
    fn a_large_load_is_reached_and_nothing_is_said_plainly() {
        let mut bar = Bar { stiffness: 0.1, load: 50.0, factor: 0.0, tangent: 0.0 };
        let mut q = [0.0];
        find(&mut bar, &mut q, Settings::default()).unwrap();
        assert!((0.1 * q[0] - 50.0 * q[0].cos()).abs() < 1e-12);
        let mut free = Bar { stiffness: 0.0, load: 1.0, factor: 0.0, tangent: 0.0 };
        let error = find(&mut free, &mut [0.0], Settings::default()).unwrap_err();
        assert_eq!((error.reached, error.cause), (0.0, Cause::Singular(0)));
    }
}
