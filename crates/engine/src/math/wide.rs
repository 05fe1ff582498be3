//! Runs code with the widest SIMD vectors of the processor.

use pulp::{Arch, Simd, WithSimd};

/// A closure that is compiled for one type of vectors.
struct Work<F>(F);

impl<R, F: FnMut() -> R> WithSimd for Work<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> R {
        (self.0)()
    }
}

/// Runs a closure, and the functions inlined into it, with the widest SIMD vectors of the processor.
///
/// The closure needs `#[inline(always)]`. If it were passed directly to [`Arch::dispatch`], it would be called through the shim of
/// `FnOnce`, which is not inlined for long closures and is then compiled for the baseline instruction set.
#[inline(always)]
pub(crate) fn wide<R>(arch: Arch, work: impl FnMut() -> R) -> R {
    arch.dispatch(Work(work))
}

/// A vector filled up with a zero.
pub(crate) type Quad = [f64; 4];

/// Vectors of four numbers: those of the processor, where it has them. Compilers do not find them in small matrices by themselves. No operation is
/// fused, so that results are the same on all processors.
pub(crate) trait Fours: Copy {
    /// `sum += factor · values`.
    fn add_four(self, sum: &mut [f64; 4], factor: f64, values: &[f64; 4]);

    /// `sum += factor · values`, in fours.
    #[inline(always)]
    fn add<const R: usize>(self, sum: &mut [f64; R], factor: f64, values: &[f64; R]) {
        let ((sums, rest), (fours, left)) = (sum.as_chunks_mut::<4>(), values.as_chunks::<4>());
        for i in 0..sums.len() {
            self.add_four(&mut sums[i], factor, &fours[i]);
        }
        for i in 0..rest.len() {
            rest[i] += factor * left[i];
        }
    }
}

/// Four numbers one after the other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OneByOne;

impl Fours for OneByOne {
    #[inline(always)]
    fn add_four(self, sum: &mut [f64; 4], factor: f64, values: &[f64; 4]) {
        for i in 0..4 {
            sum[i] += factor * values[i];
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl Fours for pulp::x86::V3 {
    #[inline(always)]
    fn add_four(self, sum: &mut [f64; 4], factor: f64, values: &[f64; 4]) {
        let product = self.mul_f64s(self.splat_f64s(factor), pulp::cast(*values));
        *sum = pulp::cast(self.add_f64s(pulp::cast(*sum), product));
    }
}

/// Work with vectors of four numbers.
pub(crate) trait WithFours {
    type Output;

    /// Needs `#[inline(always)]`, as all functions that it calls.
    fn run<V: Fours>(self, fours: V) -> Self::Output;
}

/// Runs work with vectors of four numbers.
#[inline(always)]
pub(crate) fn with_fours<W: WithFours>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        struct OnVectors<W>(pulp::x86::V3, W);
        impl<W: WithFours> WithSimd for OnVectors<W> {
            type Output = W::Output;

            #[inline(always)]
            fn with_simd<S: Simd>(self, _: S) -> W::Output {
                self.1.run(self.0)
            }
        }
        if let Some(vectors) = pulp::x86::V3::try_new() {
            return Simd::vectorize(vectors, OnVectors(vectors, work));
        }
    }
    work.run(OneByOne)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum with a rest behind the fours.
    struct Sum([[f64; 11]; 3]);

    impl WithFours for Sum {
        type Output = [u64; 11];

        #[inline(always)]
        fn run<V: Fours>(self, fours: V) -> [u64; 11] {
            let Self([mut sum, first, second]) = self;
            fours.add(&mut sum, 1.0 / 3.0, &first);
            fours.add(&mut sum, -1.0 / 7.0, &second);
            sum.map(f64::to_bits)
        }
    }

    /// Sums with the vectors of the processor have the bits of those one by one, which a fused operation would change.
    #[test]
    fn fours_have_the_bits_of_numbers_one_by_one() {
        let mut random = fastrand::Rng::with_seed(9);
        for _ in 0..100 {
            let rows: [[f64; 11]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.f64() - 0.5));
            let [sum, first, second] = rows;
            let exact: [u64; 11] =
                std::array::from_fn(|i| ((sum[i] + 1.0 / 3.0 * first[i]) + -1.0 / 7.0 * second[i]).to_bits());
            assert_eq!(with_fours(Sum(rows)), exact);
            assert_eq!(Sum(rows).run(OneByOne), exact);
        }
    }
}
