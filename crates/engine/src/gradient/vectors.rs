//! Sums and products of lists of numbers, with the vectors of the processor. No operation is fused, and partial sums do not depend on the
//! vectors.

use crate::math::wide::wide;
use pulp::Arch;

/// Number of partial sums of a product and of partial maxima: each waits only for the one eight entries before it.
const LANES: usize = 8;

/// Sum of products.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    wide(
        Arch::new(),
        #[inline(always)]
        || sum_of_products(a, b),
    )
}

/// The largest magnitudes among the products of each of several lists with another; NaN does not count.
pub(super) fn largest_products<const N: usize>(lists: [&[f64]; N], b: &[f64]) -> [f64; N] {
    wide(
        Arch::new(),
        #[inline(always)]
        || lists.map(|a| largest(a, b)),
    )
}

/// `values *= factors`.
pub(super) fn scale(values: &mut [f64], factors: &[f64]) {
    wide(
        Arch::new(),
        #[inline(always)]
        || values.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor),
    );
}

/// `sum += factor · values`.
pub(super) fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    wide(
        Arch::new(),
        #[inline(always)]
        || add_list(sum, factor, values),
    );
}

/// `sum += Σ factor · values`, one after the other.
pub(super) fn add_all<'a>(sum: &mut [f64], mut terms: impl Iterator<Item = (f64, &'a [f64])>) {
    wide(
        Arch::new(),
        #[inline(always)]
        || {
            for (factor, values) in terms.by_ref() {
                add_list(sum, factor, values);
            }
        },
    );
}

#[inline(always)]
fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    rest + sums.iter().sum::<f64>()
}

#[inline(always)]
fn largest(a: &[f64], b: &[f64]) -> f64 {
    let larger = |largest: f64, product: f64| if product > largest { product } else { largest };
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder()).fold(0.0, |rest, (a, b)| larger(rest, (a * b).abs()));
    let mut largest = [0.0f64; LANES];
    for (a, b) in a.zip(b) {
        for lane in 0..LANES {
            largest[lane] = larger(largest[lane], (a[lane] * b[lane]).abs());
        }
    }
    largest.into_iter().fold(rest, f64::max)
}

#[inline(always)]
fn add_list(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}
