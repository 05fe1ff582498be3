//! Truncated polynomials of numbers that depend on a few directions at once, with the adjoint of their multiplication.
//!
//! A smooth function of the coordinates along a motion `q(t)` has a value, a rate and an acceleration; along a further direction each of them
//! has a derivative. All of these are the coefficients of one element of a commutative ring, a jet. The pose of a chain is a product of
//! matrices whose entries are jets: velocities, accelerations, virtual displacements and their derivatives follow from the product alone,
//! NOTATION eqs. (X1) and (X2).

use std::ops::{Add, Mul, Sub};

/// An element of a commutative ring of truncated polynomials.
pub trait Jet: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Zero.
    const ZERO: Self;

    /// A number that does not vary.
    fn constant(value: f64) -> Self;

    /// Its value.
    fn value(self) -> f64;

    /// Product with a number.
    fn times(self, factor: f64) -> Self;

    /// A function of it, from the function's value and first three derivatives at [`Jet::value`].
    fn composed(self, derivatives: [f64; 4]) -> Self;

    /// Derivatives by this factor's partner: the forces `on` on the product `self · x`, projected on `x`. For jets of virtual displacements
    /// the adjoint of the multiplication; for dual numbers, whose forces are dual numbers themselves, the product.
    fn pulled(self, on: Self) -> Self;
}

/// Value, rate, acceleration and virtual displacement `(x, ẋ, ẍ, x')`; forces on it are the derivatives by these four.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Virtual(pub [f64; 4]);

/// Value, rate and acceleration, then the change of each along a direction: `(x, ẋ, ẍ, δx, δẋ, δẍ)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Varied(pub [f64; 6]);

/// Value and its change along a direction: `(x, δx)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual(pub [f64; 2]);

/// Sums entry by entry, zero, constants and multiples.
macro_rules! linear {
    ($jet:ident) => {
        impl Add for $jet {
            type Output = Self;
            #[inline(always)]
            fn add(mut self, other: Self) -> Self {
                self.0.iter_mut().zip(other.0).for_each(|(own, other)| *own += other);
                self
            }
        }

        impl Sub for $jet {
            type Output = Self;
            #[inline(always)]
            fn sub(mut self, other: Self) -> Self {
                self.0.iter_mut().zip(other.0).for_each(|(own, other)| *own -= other);
                self
            }
        }
    };
}
linear!(Virtual);
linear!(Varied);
linear!(Dual);

/// The members of [`Jet`] that are the same for all.
macro_rules! common {
    ($size:literal) => {
        const ZERO: Self = Self([0.0; $size]);

        #[inline(always)]
        fn constant(value: f64) -> Self {
            let mut jet = Self::ZERO;
            jet.0[0] = value;
            jet
        }

        #[inline(always)]
        fn value(self) -> f64 {
            self.0[0]
        }

        #[inline(always)]
        fn times(self, factor: f64) -> Self {
            Self(self.0.map(|entry| entry * factor))
        }
    };
}

impl Mul for Virtual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let ([x, x1, x2, xs], [y, y1, y2, ys]) = (self.0, other.0);
        Self([x * y, x * y1 + x1 * y, x * y2 + 2.0 * (x1 * y1) + x2 * y, x * ys + xs * y])
    }
}

impl Jet for Virtual {
    common!(4);

    #[inline(always)]
    fn composed(self, [f, f1, f2, _]: [f64; 4]) -> Self {
        let [_, x1, x2, xs] = self.0;
        Self([f, f1 * x1, f2 * x1 * x1 + f1 * x2, f1 * xs])
    }

    #[inline(always)]
    fn pulled(self, on: Self) -> Self {
        let ([x, x1, x2, xs], [y, y1, y2, ys]) = (self.0, on.0);
        Self([x * y + x1 * y1 + x2 * y2 + xs * ys, x * y1 + 2.0 * (x1 * y2), x * y2, x * ys])
    }
}

impl Mul for Varied {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let ([x, x1, x2, dx, dx1, dx2], [y, y1, y2, dy, dy1, dy2]) = (self.0, other.0);
        Self([
            x * y,
            x * y1 + x1 * y,
            x * y2 + 2.0 * (x1 * y1) + x2 * y,
            x * dy + dx * y,
            x * dy1 + x1 * dy + dx * y1 + dx1 * y,
            x * dy2 + 2.0 * (x1 * dy1) + x2 * dy + dx * y2 + 2.0 * (dx1 * y1) + dx2 * y,
        ])
    }
}

impl Jet for Varied {
    common!(6);

    #[inline(always)]
    fn composed(self, [f, f1, f2, f3]: [f64; 4]) -> Self {
        let [_, x1, x2, dx, dx1, dx2] = self.0;
        Self([
            f,
            f1 * x1,
            f2 * x1 * x1 + f1 * x2,
            f1 * dx,
            f2 * dx * x1 + f1 * dx1,
            f3 * dx * x1 * x1 + 2.0 * f2 * x1 * dx1 + f2 * dx * x2 + f1 * dx2,
        ])
    }

    /// Forces on jets with accelerations are dual numbers; this is the product.
    #[inline(always)]
    fn pulled(self, on: Self) -> Self {
        self * on
    }
}

impl Mul for Dual {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let ([x, dx], [y, dy]) = (self.0, other.0);
        Self([x * y, x * dy + dx * y])
    }
}

impl Jet for Dual {
    common!(2);

    #[inline(always)]
    fn composed(self, [f, f1, _, _]: [f64; 4]) -> Self {
        Self([f, f1 * self.0[1]])
    }

    #[inline(always)]
    fn pulled(self, on: Self) -> Self {
        self * on
    }
}

/// A vector of jets.
pub type Vector<J> = [J; 3];

/// Three entries in place: `std::array::from_fn` of entries as large as these calls its function out of line and copies the results.
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

/// A vector in the frame of `columns`, turned to the outer one.
#[inline(always)]
pub fn turned<J: Jet>(columns: &[Vector<J>; 3], vector: &Vector<J>) -> Vector<J> {
    three(|i| columns[0][i] * vector[0] + columns[1][i] * vector[1] + columns[2][i] * vector[2])
}

/// The same for a vector of numbers.
#[inline(always)]
pub fn turned_constant<J: Jet>(columns: &[Vector<J>; 3], vector: &nalgebra::Vector3<f64>) -> Vector<J> {
    three(|i| columns[0][i].times(vector[0]) + columns[1][i].times(vector[1]) + columns[2][i].times(vector[2]))
}

/// Moment of forces `on` an arm: the cross product with [`Jet::pulled`].
#[inline(always)]
pub fn moment<J: Jet>(arm: &Vector<J>, on: &Vector<J>) -> Vector<J> {
    let term = |i: usize, j: usize| arm[i].pulled(on[j]);
    [term(1, 2) - term(2, 1), term(2, 0) - term(0, 2), term(0, 1) - term(1, 0)]
}

/// Forces `on` a vector along a direction: the scalar product with [`Jet::pulled`].
#[inline(always)]
pub fn along<J: Jet>(direction: &Vector<J>, on: &Vector<J>) -> J {
    direction[0].pulled(on[0]) + direction[1].pulled(on[1]) + direction[2].pulled(on[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The adjoint of the multiplication: `⟨y, c·x⟩ = ⟨pulled(c, y), x⟩` for all entries; round-off of ten products.
    #[test]
    fn forces_are_pulled_through_products() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut jet = || Virtual(std::array::from_fn(|_| 2.0 * random.f64() - 1.0));
        for _ in 0..20 {
            let (c, x, y) = (jet(), jet(), jet());
            let dot = |a: Virtual, b: Virtual| a.0.iter().zip(b.0).map(|(a, b)| a * b).sum::<f64>();
            assert!((dot(y, c * x) - dot(c.pulled(y), x)).abs() < 1e-15 * 40.0);
        }
    }

    /// A product of functions of jets has the derivatives of the product of the functions: `sin² + cos² = 1` in every coefficient.
    #[test]
    fn functions_obey_the_product_rule() {
        let squares = |sine: [f64; 4], cosine: [f64; 4]| {
            let x = Varied([0.7, -1.3, 2.1, 0.4, 0.9, -0.6]);
            x.composed(sine) * x.composed(sine) + x.composed(cosine) * x.composed(cosine)
        };
        let (s, c) = 0.7_f64.sin_cos();
        let sum = squares([s, c, -s, -c], [c, -s, -c, s]);
        for (found, known) in sum.0.iter().zip([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]) {
            assert!((found - known).abs() < 1e-15 * 10.0, "{sum:?}");
        }
    }
}
