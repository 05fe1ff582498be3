//! Searches compared with certified values, exact minima and the conditions at a bound.

use crate::fit::{Ended, Found, Loss, Problem, Search, search, uncertainty};
use nalgebra::{DMatrix, DVector};
use std::convert::Infallible;

type Residuals = fn(&DVector<f64>) -> Option<DVector<f64>>;

macro_rules! dvector {
    ($($x:expr),*) => { DVector::from_vec(vec![$($x),*]) };
}

macro_rules! dmatrix {
    ($($($x:expr),*);*) => {{
        let rows: Vec<Vec<f64>> = vec![$(vec![$($x),*]),*];
        DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    }};
}

/// A problem defined by two functions.
struct Given {
    residuals: Residuals,
    jacobian: fn(&DVector<f64>) -> DMatrix<f64>,
    points: Vec<DVector<f64>>,
}

impl Problem for Given {
    type Error = Infallible;

    fn residuals(&mut self, x: &DVector<f64>) -> Result<Option<DVector<f64>>, Infallible> {
        self.points.push(x.clone());
        Ok((self.residuals)(x))
    }

    fn jacobian(&mut self, x: &DVector<f64>) -> Result<DMatrix<f64>, Infallible> {
        Ok((self.jacobian)(x))
    }
}

fn found(problem: &mut Given, first: DVector<f64>, bounds: &[[f64; 2]], loss: Loss) -> Found {
    let search_from = Search { first, bounds: bounds.to_vec(), loss, max_runs: 100 };
    let Ok(found) = search(problem, &search_from);
    let found = found.expect("residuals at the start");
    assert_eq!(found.runs, problem.points.len());
    for x in &problem.points {
        assert!(x.iter().zip(bounds).all(|(x, [lower, upper])| (lower..=upper).contains(&x)), "{x}");
    }
    found
}

const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
const X: [f64; 14] = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0];
const Y: [f64; 14] = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78];

fn misra() -> Given {
    Given {
        residuals: |b| Some(DVector::from_fn(14, |i, _| b[0] * (1.0 - (-b[1] * X[i]).exp()) - Y[i])),
        jacobian: |b| {
            DMatrix::from_fn(14, 2, |i, j| match j {
                0 => 1.0 - (-b[1] * X[i]).exp(),
                _ => b[0] * X[i] * (-b[1] * X[i]).exp(),
            })
        },
        points: Vec::new(),
    }
}

/// FT-01: Misra1a of NIST's Statistical Reference Datasets, from its far and its near start: certified values and standard deviations.
#[test]
fn certified_values_and_standard_deviations_are_found() {
    for first in [dvector![500.0, 1e-4], dvector![250.0, 5e-4]] {
        let found = found(&mut misra(), first, &[FREE; 2], Loss::Linear);
        assert!(found.ended.converged() && found.runs < 40, "{found:?}");
        let own = uncertainty(&found.x, &found.residuals, &found.jacobian, false);
        let certified = [(2.3894212918e2, 2.7070075241), (5.5015643181e-4, 7.2668688436e-6)];
        for (i, (value, deviation)) in certified.into_iter().enumerate() {
            assert!((found.x[i] / value - 1.0).abs() < 1e-7, "{i}: {}", found.x[i]);
            assert!((own.standard_errors()[i] / deviation - 1.0).abs() < 1e-6, "{i}: {}", own.standard_errors()[i]);
        }
        assert!((found.residuals.norm_squared() / 1.2455138894e-1 - 1.0).abs() < 1e-9);
        assert!((own.noise / 1.0187876330e-1 - 1.0).abs() < 1e-9 && own.undetermined.is_empty());
    }
}

/// Rosenbrock's residuals: without a bound the minimum is at (1, 1), with `x ≤ 0.5` at (0.5, 0.25), where `x` is exactly at its bound;
/// also from a start at the bound.
#[test]
fn bounds_hold_and_the_other_number_is_solved() {
    let valley = || Given {
        residuals: |x| Some(dvector![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]),
        jacobian: |x| dmatrix![-20.0 * x[0], 10.0; -1.0, 0.0],
        points: Vec::new(),
    };
    let free = found(&mut valley(), dvector![-1.2, 1.0], &[FREE; 2], Loss::Linear);
    assert!(free.ended.converged() && (&free.x - dvector![1.0, 1.0]).norm() < 1e-8, "{free:?}");
    for first in [dvector![-1.2, 1.0], dvector![0.5, 3.0]] {
        let bounded = found(&mut valley(), first, &[[-2.0, 0.5], FREE], Loss::Linear);
        assert!(bounded.ended.converged() && bounded.x[0] == 0.5, "{bounded:?}");
        assert!((bounded.x[1] - 0.25).abs() < 1e-9 && bounded.runs < 60, "{bounded:?}");
    }
}

/// Estimate of a location from data with an outlier: the sum of the influence functions `r ρ'(r²)` vanishes; for squares the estimate is
/// the mean. The derivatives of each loss agree with differences of its values.
#[test]
fn robust_losses_limit_an_outlier() {
    const DATA: [f64; 6] = [-0.6, -0.2, 0.1, 0.3, 0.4, 30.0];
    let location = || Given {
        residuals: |x| Some(DVector::from_fn(6, |i, _| x[0] - DATA[i])),
        jacobian: |_| DMatrix::from_element(6, 1, 1.0),
        points: Vec::new(),
    };
    for (loss, name) in Loss::ALL {
        assert_eq!(Loss::named(name), Some(loss));
        let found = found(&mut location(), dvector![0.5], &[FREE], loss);
        let influence: f64 = found.residuals.iter().map(|r| r * loss.at(r * r)[1]).sum();
        // round-off of a cost of 30 limits the accuracy to 5 √(2 ε 30 / 5)
        assert!(found.ended.converged() && influence.abs() < 3e-7, "{name}: {found:?}");
        let limit = if loss == Loss::Linear { 4.9..5.1 } else { -0.1..0.3 };
        assert!(limit.contains(&found.x[0]), "{name}: {}", found.x[0]);
        for z in [0.3, 2.0, 7.0] {
            let [before, after] = [z - 1e-5, z + 1e-5].map(|z| loss.at(z));
            for order in [0, 1] {
                let slope = (after[order] - before[order]) / 2e-5;
                assert!((slope - loss.at(z)[order + 1]).abs() < 1e-9, "{name} at {z}");
            }
        }
    }
    assert_eq!(Loss::named("l2"), None);
}

/// At points without residuals, or with residuals that are NaN, the search takes a shorter step: `ln x = 0` from 5 leads to negative
/// numbers.
#[test]
fn the_search_returns_from_points_without_residuals() {
    for residuals in
        [|x: &DVector<f64>| (x[0] > 0.0).then(|| dvector![x[0].ln()]), |x: &DVector<f64>| Some(dvector![x[0].ln()])]
            as [Residuals; 2]
    {
        let mut problem = Given { residuals, jacobian: |x| dmatrix![1.0 / x[0]], points: Vec::new() };
        let found = found(&mut problem, dvector![5.0], &[FREE], Loss::Linear);
        assert!(found.ended.converged() && (found.x[0] - 1.0).abs() < 1e-9, "{found:?}");
        assert!(problem.points.iter().any(|x| x[0] <= 0.0), "no trial went too far");
    }
    let none = Search { first: dvector![-1.0], bounds: vec![FREE], loss: Loss::Linear, max_runs: 9 };
    let mut problem = Given { residuals: |_| None, jacobian: |_| dmatrix![1.0], points: Vec::new() };
    assert_eq!(search(&mut problem, &none), Ok(None));
}

/// With two numbers that enter as their product, the direction that raises one and lowers the other is not determined, and the search
/// still ends. The same holds for one direction of three numbers that are fitted to two measurements.
#[test]
fn directions_that_are_not_determined_are_found() {
    let mut product = Given {
        residuals: |x| Some(dvector![x[0] * x[1] - 6.0, 2.0 * x[0] * x[1] - 12.0, x[0] * x[1] - 6.1]),
        jacobian: |x| dmatrix![x[1], x[0]; 2.0 * x[1], 2.0 * x[0]; x[1], x[0]],
        points: Vec::new(),
    };
    let found = found(&mut product, dvector![1.0, 2.0], &[FREE; 2], Loss::Linear);
    assert!(found.ended.converged() && found.runs < 30, "{found:?}");
    let own = uncertainty(&found.x, &found.residuals, &found.jacobian, true);
    let [direction] = &own.undetermined[..] else { panic!("{own:?}") };
    assert!((direction[0] + direction[1]).abs() < 1e-9 && (direction.norm() - 1.0).abs() < 1e-12, "{direction}");
    assert!(own.covariance.iter().all(|entry| entry.is_nan()) && own.noise == 1.0);
    let few =
        uncertainty(&dvector![1.0, 1.0, 1.0], &dvector![0.0, 0.0], &dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0], false);
    assert!(few.undetermined.len() == 1 && few.undetermined[0][2].abs() == 1.0 && few.noise.is_nan(), "{few:?}");
}

/// The covariance of a linear problem is the inverse of its normal equations, in the units of the numbers.
#[test]
fn the_covariance_is_that_of_the_normal_equations() {
    let jacobian = dmatrix![1.0, 2e6; 3.0, -1e6; 0.5, 4e6];
    let own = uncertainty(&dvector![5.0, 0.0], &dvector![0.1, -0.2, 0.3], &jacobian, true);
    let due = (jacobian.transpose() * &jacobian).try_inverse().unwrap();
    for (own, due) in own.covariance.iter().zip(due.iter()) {
        assert!((own / due - 1.0).abs() < 1e-9, "{own} {due}");
    }
}

/// A search with too few runs has not converged, and returns the best point.
#[test]
fn the_number_of_runs_is_a_limit() {
    let first = Search { first: dvector![250.0, 5e-4], bounds: vec![FREE; 2], loss: Loss::Linear, max_runs: 3 };
    let Ok(found) = search(&mut misra(), &first);
    let found = found.unwrap();
    assert!(found.runs == 3 && found.ended == Ended::Runs && !found.ended.converged());
    let start = (misra().residuals)(&first.first).unwrap();
    assert!(found.residuals.norm() < start.norm());
}
