//! Truncated polynomials (jets) for derivatives in a few directions at once.
//!
//! Along a motion `q(t)` a smooth function of the coordinates has a value, a rate and an acceleration; along further directions it has one
//! derivative each. Such sets of coefficients are the elements of commutative rings, jets: a formula evaluated in such a ring gives the
//! derivatives together with the value, NOTATION eq. (X1).

use std::ops::{Add, Mul, Sub};

/// An element of a commutative ring of truncated polynomials.
pub trait Jet: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Zero.
    const ZERO: Self;

    /// A constant, whose derivatives are zero.
    fn constant(value: f64) -> Self;

    /// Value, without the derivatives.
    fn value(self) -> f64;

    /// Product with a constant.
    fn times(self, factor: f64) -> Self;

    /// Function of this jet, from the function's value and first two derivatives at [`Jet::value`].
    fn composed(self, derivatives: [f64; 3]) -> Self;
}

/// Value, rate and acceleration `(x, ẋ, ẍ)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving(pub [f64; 3]);

/// Value and derivatives along `N` directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partial<const N: usize> {
    /// Value.
    pub value: f64,
    /// Derivatives along the directions.
    pub by: [f64; N],
}

impl Jet for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self * factor
    }

    #[inline(always)]
    fn composed(self, [f, _, _]: [f64; 3]) -> Self {
        f
    }
}

impl Add for Moving {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([x, x1, x2], [y, y1, y2]) = (self.0, other.0);
        Self([x + y, x1 + y1, x2 + y2])
    }
}

impl Sub for Moving {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([x, x1, x2], [y, y1, y2]) = (self.0, other.0);
        Self([x - y, x1 - y1, x2 - y2])
    }
}

impl Mul for Moving {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let ([x, x1, x2], [y, y1, y2]) = (self.0, other.0);
        Self([x * y, x * y1 + x1 * y, x * y2 + 2.0 * (x1 * y1) + x2 * y])
    }
}

impl Jet for Moving {
    const ZERO: Self = Self([0.0; 3]);

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value, 0.0, 0.0])
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.0[0]
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        let [x, x1, x2] = self.0;
        Self([x * factor, x1 * factor, x2 * factor])
    }

    #[inline(always)]
    fn composed(self, [f, f1, f2]: [f64; 3]) -> Self {
        let [_, x1, x2] = self.0;
        Self([f, f1 * x1, f2 * x1 * x1 + f1 * x2])
    }
}

impl<const N: usize> Partial<N> {
    /// A variable with derivative 1 along one of the directions.
    pub fn along(value: f64, direction: usize) -> Self {
        let mut jet = Self::constant(value);
        jet.by[direction] = 1.0;
        jet
    }

    #[inline(always)]
    fn combined(self, other: Self, value: f64, [own, others]: [f64; 2]) -> Self {
        let mut by = [0.0; N];
        for (by, (x, y)) in by.iter_mut().zip(self.by.iter().zip(&other.by)) {
            *by = own * x + others * y;
        }
        Self { value, by }
    }
}

impl<const N: usize> Add for Partial<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.combined(other, self.value + other.value, [1.0, 1.0])
    }
}

impl<const N: usize> Sub for Partial<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.combined(other, self.value - other.value, [1.0, -1.0])
    }
}

impl<const N: usize> Mul for Partial<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.combined(other, self.value * other.value, [other.value, self.value])
    }
}

impl<const N: usize> Jet for Partial<N> {
    const ZERO: Self = Self { value: 0.0, by: [0.0; N] };

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self { value, by: [0.0; N] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, by: self.by.map(|by| by * factor) }
    }

    #[inline(always)]
    fn composed(self, [f, f1, _]: [f64; 3]) -> Self {
        Self { value: f, by: self.by.map(|by| f1 * by) }
    }
}

/// A vector of jets.
pub type Vector<J> = [J; 3];

/// Builds three entries in place: for entries as large as these, `std::array::from_fn` calls its function out of line and copies the
/// results.
#[inline(always)]
pub fn three<T>(mut entry: impl FnMut(usize) -> T) -> [T; 3] {
    [entry(0), entry(1), entry(2)]
}

/// Sum.
#[inline(always)]
pub fn plus<J: Jet>(a: Vector<J>, b: Vector<J>) -> Vector<J> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Cross product.
#[inline(always)]
pub fn cross<J: Jet>(a: Vector<J>, b: Vector<J>) -> Vector<J> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Scalar product.
#[inline(always)]
pub fn dot<J: Jet>(a: &Vector<J>, b: &Vector<J>) -> J {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Rotates a vector by the rotation matrix with these `columns`.
#[inline(always)]
pub fn turned<J: Jet>(columns: &[Vector<J>; 3], vector: &Vector<J>) -> Vector<J> {
    three(|i| columns[0][i] * vector[0] + columns[1][i] * vector[1] + columns[2][i] * vector[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Functions of jets satisfy the product rule: `sin² + cos² = 1` holds in every coefficient.
    #[test]
    fn functions_obey_the_product_rule() {
        let (s, c) = 0.7_f64.sin_cos();
        let x = Moving([0.7, -1.3, 2.1]);
        let (sine, cosine) = (x.composed([s, c, -s]), x.composed([c, -s, -c]));
        let sum = (sine * sine + cosine * cosine).0;
        let y = Partial { value: 0.7, by: [0.4, 0.9] };
        let (sine, cosine) = (y.composed([s, c, -s]), y.composed([c, -s, -c]));
        let other = sine * sine + cosine * cosine;
        for (found, known) in sum.into_iter().chain([other.value]).chain(other.by).zip([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]) {
            assert!((found - known).abs() < 1e-15 * 10.0, "{sum:?} {other:?}");
        }
    }
}
