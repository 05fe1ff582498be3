//! All eigenvalues of a matrix function inside a circle, by moments of its inverse along the circle.
//!
//! After Beyn, An integral method for solving nonlinear eigenvalue problems, Linear Algebra and its Applications 436 (2012), with moments
//! of higher order, which allow more eigenvalues than rows.

use crate::solve::complex_factors::ComplexFactors;
use crate::solve::eigen::eigen;
use nalgebra::{Complex, DMatrix, DVector};

type ComplexVector = DVector<Complex<f64>>;

/// Maximum order of the moments: higher orders lose digits, so more eigenvalues need more probe columns instead.
const ORDERS: usize = 5;
/// Minimum number of points on the whole circle. An eigenvalue `λ` is weighted by `1/(1 + (λ/R)^N)`: eigenvalues outside contribute little,
/// but exactly, so that the moments remain sums over eigenvalues.
const PLACES: usize = 64;
/// Singular value of the moments, relative to the largest, below which it is round-off.
const ROUND_OFF: f64 = 1e-11;
/// Largest singular value of the moments, relative to the sum of their cancelling terms, below which there is no eigenvalue inside: the
/// remainder is round-off and the effect of distant eigenvalues outside.
const EMPTY: f64 = 1e-9;
/// Distance from the centre, divided by the radius, up to which eigenvalues are returned.
const BEYOND: f64 = 1.05;

/// Estimates of the eigenvalues and vectors, and whether there may be more than the moments can resolve.
pub struct Inside {
    /// Eigenvalues, with positive imaginary part for a complex pair, and their vectors.
    pub found: Vec<(Complex<f64>, ComplexVector)>,
    /// Whether the moments have reached their capacity.
    pub full: bool,
}

/// Entry of a probe: an irregular sequence in rows and columns, between -1 and 1.
fn probe(row: usize, column: usize, side: usize) -> f64 {
    let seed = (row as f64 + 1.0) * 12.989_8 + (column as f64 + 1.0) * 78.233 + (side as f64 + 1.0) * 37.719;
    2.0 * (seed.sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
}

/// Eigenvalues within `radius` of `center` of the real-analytic function with the factors `factors_at`; `scale` holds the magnitudes of the
/// unknowns, `capacity` is the minimum number of eigenvalues that the moments must be able to resolve, including those outside within an
/// additional half radius. `None` if the eigenvalue iteration for the moments fails.
///
/// For a complex centre the moments are also summed over its conjugate, so that they are real. For an eigenvalue `μ` of the moments and its
/// conjugate, either one of them is `center + radius·μ` with the returned shape, or the other is its mirror image at the height of the
/// centre with the conjugate shape: the function must be evaluated to distinguish the two.
pub fn inside(
    center: Complex<f64>,
    radius: f64,
    capacity: usize,
    scale: &DVector<f64>,
    factors_at: &mut dyn FnMut(Complex<f64>) -> Option<ComplexFactors>,
) -> Option<Inside> {
    let size = scale.len();
    let probes = capacity.div_ceil(ORDERS).min(size);
    let blocks = capacity.div_ceil(probes.max(1));
    if size == 0 || capacity == 0 {
        return Some(Inside { found: Vec::new(), full: false });
    }
    // a function that is smooth inside contributes its term of order N - k - 1 to the moment of order k
    let places = PLACES.max(4 * blocks + 16).next_multiple_of(2);
    let right = DMatrix::from_fn(size, probes, |i, j| scale[i] * probe(i, j, 0));
    let left = DMatrix::from_fn(probes, size, |i, j| probe(j, i, 1) / scale[j]);
    let mut moments = vec![DMatrix::<f64>::zeros(size, probes); blocks];
    let mut seen = vec![DMatrix::<f64>::zeros(probes, probes); 2 * blocks];
    let mut cancels = vec![0.0_f64; probes];
    let left_sizes = left.abs();
    // values at conjugate points are conjugate
    for place in 0..if center.im == 0.0 { places / 2 } else { places } {
        let angle = std::f64::consts::TAU * (place as f64 + 0.5) / places as f64;
        let unit = Complex::from_polar(1.0, angle);
        // a pole of the function contributes nothing, because the inverse is zero there
        let Some(factors) = factors_at(unit * radius + center) else { continue };
        for (column, cancels) in cancels.iter_mut().enumerate() {
            let answer = factors.solve(&right.column(column).map(Complex::from));
            if !answer.iter().all(|entry| entry.is_finite()) {
                continue;
            }
            let mut weight = unit * (2.0 / places as f64);
            *cancels += (&left_sizes * answer.map(|entry| entry.norm())).norm() * weight.norm();
            for (order, own) in seen.iter_mut().enumerate() {
                let part = answer.map(|entry| (weight * entry).re);
                let mut own = own.column_mut(column);
                own += &left * &part;
                if let Some(moment) = moments.get_mut(order) {
                    let mut own = moment.column_mut(column);
                    own += part;
                }
                weight *= unit;
            }
        }
    }
    let hankel = |shift: usize| {
        DMatrix::from_fn(blocks * probes, blocks * probes, |i, j| {
            seen[i / probes + j / probes + shift][(i % probes, j % probes)]
        })
    };
    let parts = hankel(0).svd(true, true);
    let (u, v) = (parts.u?, parts.v_t?.transpose());
    let largest = parts.singular_values.iter().copied().fold(0.0, f64::max);
    if largest <= EMPTY * cancels.iter().copied().fold(0.0, f64::max) {
        return Some(Inside { found: Vec::new(), full: false });
    }
    let mut order: Vec<usize> = (0..blocks * probes).collect();
    order.retain(|&i| parts.singular_values[i] > ROUND_OFF * largest);
    let full = order.len() == blocks * probes;
    let mut turned = v.select_columns(&order);
    for (mut column, &i) in turned.column_iter_mut().zip(&order) {
        column.unscale_mut(parts.singular_values[i]);
    }
    let small = u.select_columns(&order).transpose() * hankel(1) * &turned;
    let own = eigen(&small)?;
    let mut shapes = DMatrix::<f64>::zeros(size, order.len());
    for (block, moment) in moments.iter().enumerate() {
        shapes += moment * turned.rows(block * probes, probes);
    }
    let shapes = shapes * &own.vectors;
    let list = own.values.iter().enumerate().filter(|(_, value)| value.im >= 0.0 && value.norm() <= BEYOND);
    let found = list.map(|(i, value)| {
        let pair = value.im > 0.0;
        let shape = DVector::from_fn(size, |row, _| {
            Complex::new(shapes[(row, i)], if pair { shapes[(row, i + 1)] } else { 0.0 })
        });
        (value * radius + center, shape)
    });
    Some(Inside { found: found.collect(), full })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quadratic matrix function with a delay.
    fn matrix(at: Complex<f64>) -> DMatrix<Complex<f64>> {
        let late = (-at).exp();
        let own = at * at + at * 0.3;
        let entry = |k: f64, b: f64| Complex::from(k) + late * b;
        let entries = [own + entry(4.0, 1.0), entry(0.3, -0.8), entry(-0.5, 0.2), own * 2.0 + entry(9.0, 3.0)];
        DMatrix::from_row_slice(2, 2, &entries)
    }

    fn factors_at(place: Complex<f64>) -> Option<ComplexFactors> {
        let matrix = matrix(place);
        Some(ComplexFactors::new(2, |i, j| matrix[(i, j)]))
    }

    /// Circles without roots give none: round-off of their moments used to be returned as up to 120 estimates.
    #[test]
    fn circles_without_roots_are_empty() {
        for radius in [1e-4, 1e-2, 0.3] {
            let inside = inside(Complex::from(0.0), radius, 120, &DVector::from_element(2, 1.0), &mut factors_at)
                .expect("moments");
            assert!(inside.found.is_empty() && !inside.full, "{radius}: {:?}", inside.found);
        }
    }

    /// Moments with a capacity below the number of roots in a circle are reported as full, because roots may be missing; those with a
    /// larger capacity are not.
    #[test]
    fn full_moments_say_so() {
        let of = |capacity: usize| {
            let scale = DVector::from_element(2, 1.0);
            inside(Complex::from(0.0), 11.0, capacity, &scale, &mut factors_at).expect("moments")
        };
        let roots = of(120).found.iter().map(|(value, _)| if value.im > 0.0 { 2 } else { 1 }).sum::<usize>();
        assert!(roots >= 8, "{roots}");
        for capacity in [2, 4, roots / 2, roots - 1] {
            assert!(of(capacity).full, "{capacity} of {roots}");
        }
        assert!(!of(120).full);
    }

    /// For a centre off the real axis, a root in each disc, or its mirror image at the height of the centre, is one of those found about 0.
    #[test]
    fn roots_around_a_centre_that_is_not_real() {
        let all = inside(Complex::from(0.0), 11.0, 120, &DVector::from_element(2, 1.0), &mut factors_at);
        let above = all.expect("moments").found.into_iter().map(|(value, _)| value).filter(|value| value.im > 1.5);
        let above: Vec<Complex<f64>> = above.collect();
        assert!(above.len() > 3, "{above:?}");
        for root in &above {
            let (center, radius) = (root + Complex::new(0.2, 0.4), 1.0);
            let height = center.im;
            let own =
                inside(center, radius, 60, &DVector::from_element(2, 1.0), &mut factors_at).expect("moments").found;
            let expected: Vec<_> = above.iter().filter(|value| (*value - center).norm() < radius).collect();
            let fits =
                |value: &Complex<f64>, shape: &ComplexVector| (matrix(*value) * shape).norm() / shape.norm() < 1e-6;
            let found: Vec<_> = own
                .iter()
                .map(|(value, shape)| {
                    let mirrored = Complex::new(value.re, 2.0 * height - value.im);
                    if fits(value, shape) {
                        *value
                    } else {
                        assert!(fits(&mirrored, &shape.map(|x| x.conj())));
                        mirrored
                    }
                })
                .collect();
            for value in expected {
                assert!(found.iter().any(|other| (other - value).norm() < 1e-7), "{value}: {found:?}");
            }
        }
    }

    /// Roots of a quadratic function with a delay, `λ² + c λ + k + b e^(−λ)` in two coupled unknowns: the function vanishes at all roots
    /// found, and their number follows from the argument principle, by the winding number of the determinant.
    #[test]
    fn all_roots_of_equations_with_delays_are_found() {
        for radius in [1.0, 2.5, 6.0, 11.0] {
            let inside = inside(Complex::from(0.0), radius, 120, &DVector::from_element(2, 1.0), &mut factors_at)
                .expect("moments");
            assert!(!inside.full);
            let list: Vec<_> = inside.found.iter().filter(|(value, _)| value.norm() < radius).collect();
            let count: usize = list.iter().map(|(value, _)| if value.im > 0.0 { 2 } else { 1 }).sum();
            // the determinant has no poles: its winding number on the circle is the number of roots inside
            let places = 4000;
            let on = |i: usize| {
                matrix(Complex::from_polar(radius, std::f64::consts::TAU * i as f64 / f64::from(places))).determinant()
            };
            let turns: f64 =
                (0..places as usize).map(|i| (on(i + 1) / on(i)).arg()).sum::<f64>() / std::f64::consts::TAU;
            assert_eq!(count as f64, turns.round(), "{radius}: {list:?}");
            for (value, shape) in list {
                let left = (matrix(*value) * shape).norm() / (matrix(*value).norm() * shape.norm());
                // these are estimates: the moments lose as many digits as the weights at the rim
                assert!(left < 1e-6, "{radius}: {value} {left:e}");
            }
        }
    }
}
