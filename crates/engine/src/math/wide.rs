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
