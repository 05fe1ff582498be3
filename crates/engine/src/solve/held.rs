//! Response of a structure over a step under constant loads: exact for modes that the step resolves.

use crate::solve::linearize::SecondOrder;
use nalgebra::DMatrix;

/// Phase advance in rad of an undamped mode in a step above which the mode responds quasi-statically: 20 periods.
const FAST_RAD: f64 = 125.0;

/// Coordinates and rates at the end of a step, as functions of those at its start and of the constant force.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldStructure {
    /// Derivatives with respect to the stacked coordinates and rates.
    pub free: DMatrix<f64>,
    /// Derivatives with respect to the forces.
    pub by_force: DMatrix<f64>,
}

/// Solves `M q̈ + C q̇ + K q = f` with constant `f` over `step_s`. Undamped modes with many periods in a step respond quasi-statically, as
/// in a simulation whose integrator does not resolve them. `None` if the mass matrix is not positive definite.
pub fn held_structure(system: &SecondOrder, step_s: f64) -> Option<HeldStructure> {
    let SecondOrder { mass, damping, stiffness } = system;
    let n = mass.nrows();
    let root = mass.clone().cholesky()?.l();
    let half = root.solve_lower_triangular(&((stiffness + stiffness.transpose()) * 0.5))?;
    let whole = root.solve_lower_triangular(&half.transpose())?;
    let eigen = ((&whole + whole.transpose()) * 0.5).symmetric_eigen();
    let fast = |i: usize| eigen.eigenvalues[i].max(0.0).sqrt() * step_s > FAST_RAD;
    let (fast, slow): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| fast(i));
    let shapes = |list: &[usize]| root.tr_solve_lower_triangular(&eigen.eigenvectors.select_columns(list));
    let (fast, slow) = (shapes(&fast)?, shapes(&slow)?);
    let (slow_count, fast_count) = (slow.ncols(), fast.ncols());
    // fast modes, quasi-static: K_ff f + K_fs s = force
    let within = |left: &DMatrix<f64>, matrix: &DMatrix<f64>, right: &DMatrix<f64>| left.transpose() * matrix * right;
    let stiff = within(&fast, stiffness, &fast).lu();
    let follow =
        if fast_count > 0 { -stiff.solve(&within(&fast, stiffness, &slow))? } else { DMatrix::zeros(0, slow_count) };
    let yielding = if fast_count > 0 { stiff.solve(&fast.transpose())? } else { DMatrix::zeros(0, n) };
    let across = within(&slow, stiffness, &fast);
    let kept_stiffness = within(&slow, stiffness, &slow) + &across * &follow;
    let kept_force = slow.transpose() - &across * &yielding;
    // x = (s, ṡ, force): exponential of the augmented matrix over the step
    let size = 2 * slow_count + n;
    let mut rates = DMatrix::zeros(size, size);
    rates.view_mut((0, slow_count), (slow_count, slow_count)).fill_with_identity();
    rates.view_mut((slow_count, 0), (slow_count, slow_count)).copy_from(&-kept_stiffness);
    rates.view_mut((slow_count, slow_count), (slow_count, slow_count)).copy_from(&-within(&slow, damping, &slow));
    rates.view_mut((slow_count, 2 * slow_count), (slow_count, n)).copy_from(&kept_force);
    let over_step = (rates * step_s).exp();
    let ends = over_step.rows(0, 2 * slow_count);
    // s = Sᵀ M q: the modes are mass-normalised
    let modal = slow.transpose() * mass;
    let mut begin = DMatrix::zeros(2 * slow_count, 2 * n);
    begin.view_mut((0, 0), (slow_count, n)).copy_from(&modal);
    begin.view_mut((slow_count, n), (slow_count, n)).copy_from(&modal);
    let mut out = DMatrix::zeros(2 * n, 2 * slow_count);
    out.view_mut((0, 0), (n, slow_count)).copy_from(&(&slow + &fast * &follow));
    out.view_mut((n, slow_count), (n, slow_count)).copy_from(&slow);
    let free = &out * ends.columns(0, 2 * slow_count) * begin;
    let mut by_force = &out * ends.columns(2 * slow_count, n);
    let mut at_once = by_force.rows_mut(0, n);
    at_once += &fast * yielding;
    Some(HeldStructure { free, by_force })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two uncoupled masses: one oscillates according to the closed form; the other, with a thousand times the frequency, responds
    /// quasi-statically.
    #[test]
    fn slow_masses_swing_and_fast_ones_yield() {
        let (step_s, slow_rad_s, fast_rad_s) = (0.1_f64, 5.0_f64, 5000.0_f64);
        let square = |value: f64| value * value;
        let system = SecondOrder {
            mass: DMatrix::identity(2, 2),
            damping: DMatrix::zeros(2, 2),
            stiffness: DMatrix::from_row_slice(2, 2, &[square(slow_rad_s), 0.0, 0.0, square(fast_rad_s)]),
        };
        let held = held_structure(&system, step_s).unwrap();
        let (sine, cosine) = (slow_rad_s * step_s).sin_cos();
        let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-13, "{value} {expected}");
        near(held.free[(0, 0)], cosine);
        near(held.free[(0, 2)], sine / slow_rad_s);
        near(held.free[(2, 0)], -slow_rad_s * sine);
        near(held.free[(2, 2)], cosine);
        near(held.by_force[(0, 0)], (1.0 - cosine) / square(slow_rad_s));
        near(held.by_force[(2, 0)], sine / slow_rad_s);
        near(held.by_force[(1, 1)], 1.0 / square(fast_rad_s));
        assert_eq!(held.free.row(3).amax() + held.free.row(1).amax(), 0.0);
    }
}
