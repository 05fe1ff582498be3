//! Sums and products of lists of numbers.

/// Number of partial sums of a product and of partial maxima: each waits only for the one eight entries before it.
const LANES: usize = 8;

/// Sum of products.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
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

/// The largest magnitude among the products of two lists; NaN does not count.
pub(super) fn largest_product(a: &[f64], b: &[f64]) -> f64 {
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

/// `sum += factor · values`.
pub(super) fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}
