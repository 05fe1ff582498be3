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
    let mut largest = [0.0f64; LANES];
    let (a, b) = (a.chunks(LANES), b.chunks(LANES));
    for (a, b) in a.zip(b) {
        for ((largest, a), b) in largest.iter_mut().zip(a).zip(b) {
            let product = (a * b).abs();
            *largest = if product > *largest { product } else { *largest };
        }
    }
    largest.into_iter().fold(0.0, f64::max)
}

/// `sum += factor · values`.
pub(super) fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}
