//! Descent from an unstable equilibrium, or from a state that is not in equilibrium, to a stable equilibrium.
//!
//! Newton's method with `K + σM`, with about the smallest `σ` that makes it positive definite: a step of the flow `M q̇ = −r`, which is
//! attracted by stable states and repelled by unstable ones. If `K` is already positive definite, this is Newton's method. NOTATION eq.
//! (L15).

use crate::solve::equilibrium::{Cause, Effort, Settings, StaticEquations};

/// Maximum number of iterations.
const MAXIMUM_STEPS: usize = 600;

/// Largest step in the kinematic norm.
const LONGEST_STEP: f64 = 0.2;

/// Kinematic norm of the perturbation of an unstable equilibrium.
const PUSH: f64 = 0.02;

/// Factor between successive shifts that are tried.
const SHIFT_FACTOR: f64 = 4.0;

/// Leaves the unstable equilibrium `q` along the most unstable direction, to the side with the larger descent. The equations must be at the
/// whole load.
pub fn leave(equations: &mut impl StaticEquations, q: &mut [f64]) -> Result<(), Cause> {
    let mut residual = vec![0.0; q.len()];
    equations.residual(q, &mut residual);
    let mut high = positive_shift(equations, q, 1.0)?;
    let mut low = high / SHIFT_FACTOR;
    // bisects for the largest −eigenvalue of K with respect to M
    for _ in 0..8 {
        let middle = (low * high).sqrt();
        if negative(equations, q, middle)? > 0 { low = middle } else { high = middle }
    }
    negative(equations, q, high)?;
    // near that eigenvalue, the response to any force is almost entirely in that direction
    let mut direction: Vec<f64> = (0..q.len()).map(|i| (1.0 + (i * i % 97) as f64).sin()).collect();
    equations.solve(&mut direction);
    let size = equations.norm(&direction);
    if !(size > 0.0 && size.is_finite()) {
        return Err(Cause::NotFinite(0));
    }
    let mut best: Option<(f64, Vec<f64>)> = None;
    for sign in [1.0, -1.0] {
        let step = sign * PUSH / size;
        let mut beside: Vec<f64> = q.iter().zip(&direction).map(|(q, d)| q + step * d).collect();
        equations.project(&mut beside);
        equations.residual(&beside, &mut residual);
        let uphill: f64 = residual.iter().zip(&direction).map(|(r, d)| r * step * d).sum();
        if best.as_ref().is_none_or(|(least, _)| uphill < *least) {
            best = Some((uphill, beside));
        }
    }
    if let Some((_, beside)) = best {
        q.copy_from_slice(&beside);
    }
    Ok(())
}

/// Descends from `q`, which need not be an equilibrium, to a stable one. The equations must be at the whole load.
pub fn descend(
    equations: &mut impl StaticEquations,
    q: &mut [f64],
    settings: Settings,
    effort: &mut Effort,
) -> Result<(), Cause> {
    let mut change = vec![0.0; q.len()];
    let mut before = change.clone();
    let (mut shift, mut longest) = (1.0, LONGEST_STEP);
    for iteration in 1..=MAXIMUM_STEPS {
        effort.iterations += 1;
        equations.residual(q, &mut change);
        if change.iter().any(|force| !force.is_finite()) {
            return Err(Cause::NotFinite(iteration));
        }
        let steep = equations.factorize(q, 0.0).is_ok_and(|negative| negative == 0);
        if !steep {
            shift = positive_shift(equations, q, shift)?;
        }
        equations.solve(&mut change);
        let correction = equations.norm(&change);
        if !correction.is_finite() {
            return Err(Cause::NotFinite(iteration));
        }
        // steps that alternate across a valley are shortened
        let turned = equations.product(&before, &change) < 0.0;
        longest = if turned { 0.5 * longest } else { (1.5 * longest).min(LONGEST_STEP) };
        let share = (longest / correction).min(1.0);
        q.iter_mut().zip(&change).for_each(|(q, change)| *q -= share * change);
        equations.project(q);
        if steep && correction <= settings.tolerance {
            equations.residual(q, &mut change);
            return Ok(());
        }
        before.copy_from_slice(&change);
    }
    Err(Cause::NoStableState(MAXIMUM_STEPS))
}

/// Approximately the smallest shift that makes the matrix positive definite, searched from `from`; the matrix is factorised with it
/// afterwards.
fn positive_shift(equations: &mut impl StaticEquations, q: &[f64], from: f64) -> Result<f64, Cause> {
    let mut shift = from;
    while negative(equations, q, shift)? == 0 && shift > 1e-30 {
        shift /= SHIFT_FACTOR;
    }
    while negative(equations, q, shift)? > 0 {
        shift *= SHIFT_FACTOR;
        if shift > 1e30 {
            return Err(Cause::NotFinite(0));
        }
    }
    Ok(shift)
}

/// Number of negative directions at a shift; a singular matrix is treated as negative.
fn negative(equations: &mut impl StaticEquations, q: &[f64], shift: f64) -> Result<usize, Cause> {
    Ok(equations.factorize(q, shift).unwrap_or(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::Singular;

    /// A pendulum of unit weight and length, with `q` measured from the lowest position: `r = sin q`.
    struct Pendulum(f64);

    impl StaticEquations for Pendulum {
        fn coordinates(&self) -> usize {
            1
        }
        fn load(&mut self, _: f64) {}
        fn residual(&mut self, q: &[f64], residual: &mut [f64]) {
            residual[0] = q[0].sin();
        }
        fn factorize(&mut self, q: &[f64], shift_1_s2: f64) -> Result<usize, Singular> {
            self.0 = q[0].cos() + shift_1_s2;
            if self.0 == 0.0 { Err(Singular { coordinate: 0 }) } else { Ok(usize::from(self.0 < 0.0)) }
        }
        fn solve(&mut self, x: &mut [f64]) {
            x[0] /= self.0;
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
    fn an_upright_pendulum_falls_and_hangs() {
        let (mut pendulum, mut q, mut effort) = (Pendulum(0.0), [std::f64::consts::PI], Effort::default());
        leave(&mut pendulum, &mut q).unwrap();
        assert!((q[0] - std::f64::consts::PI).abs() > 0.01);
        descend(&mut pendulum, &mut q, Settings::default(), &mut effort).unwrap();
        assert!(q[0].sin().abs() < 1e-12 && q[0].cos() > 0.0, "rests at {} rad", q[0]);
    }
}
