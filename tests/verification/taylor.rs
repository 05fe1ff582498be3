//! Exact derivatives with respect to one parameter `t`: matrices with value, first and second derivative, and the exponential of such a
//! matrix by scaling and squaring. No rotation formula is used here.

use nalgebra::SMatrix;
use std::ops::{Add, Mul};

/// A matrix that depends on `t`, with its first two derivatives in `t` at 0.
#[derive(Debug, Clone, Copy)]
pub struct Taylor<const R: usize, const C: usize> {
    /// Value.
    pub value: SMatrix<f64, R, C>,
    /// First derivative.
    pub first: SMatrix<f64, R, C>,
    /// Second derivative.
    pub second: SMatrix<f64, R, C>,
}

/// A scalar that depends on `t`: value, first and second derivative.
pub type Scalar = [f64; 3];

impl<const R: usize, const C: usize> Taylor<R, C> {
    /// Independent of `t`.
    pub fn constant(value: SMatrix<f64, R, C>) -> Self {
        Self { value, first: SMatrix::zeros(), second: SMatrix::zeros() }
    }

    /// `self + x · direction` with a scalar that depends on `t`.
    pub fn plus(self, x: Scalar, direction: SMatrix<f64, R, C>) -> Self {
        self + Self { value: direction * x[0], first: direction * x[1], second: direction * x[2] }
    }

    /// Multiplied by a number.
    pub fn scale(self, factor: f64) -> Self {
        Self { value: self.value * factor, first: self.first * factor, second: self.second * factor }
    }

    /// Transposed.
    pub fn transpose(self) -> Taylor<C, R> {
        Taylor { value: self.value.transpose(), first: self.first.transpose(), second: self.second.transpose() }
    }
}

impl<const R: usize, const C: usize> Add for Taylor<R, C> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, first: self.first + other.first, second: self.second + other.second }
    }
}

impl<const R: usize, const K: usize, const C: usize> Mul<Taylor<K, C>> for Taylor<R, K> {
    type Output = Taylor<R, C>;
    /// Leibniz' rule.
    fn mul(self, other: Taylor<K, C>) -> Taylor<R, C> {
        Taylor {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value + self.first * other.first * 2.0 + self.value * other.second,
        }
    }
}

/// `exp(A)` with both derivatives: the power series of `exp(A/2ᵏ) − 1`, squared `k` times without its identity part, so that small matrices
/// keep their digits.
pub fn exponential<const N: usize>(matrix: Taylor<N, N>) -> Taylor<N, N> {
    let one = Taylor::constant(SMatrix::<f64, N, N>::identity());
    let size = matrix.value.abs().sum();
    let squarings = (size / 0.5).log2().ceil().max(0.0) as i32;
    let small = matrix.scale(0.5f64.powi(squarings));
    let mut excess = small.scale(1.0 / 22.0);
    for term in (1..22).rev() {
        excess = small.scale(1.0 / f64::from(term)) * (one + excess);
    }
    for _ in 0..squarings {
        excess = excess.scale(2.0) + excess * excess;
    }
    one + excess
}

/// V-01. The exponential of a rotation by 90°, and its first and second derivatives with respect to `t`, are known in closed form.
///
/// `exp(θ(t) J)` with `θ = π/2 + 3t + t²` and `J² = −1`: tolerance is round-off of values up to 9.
#[test]
fn v01_exponential_of_a_plane_rotation() {
    let j = nalgebra::Matrix2::new(0.0, -1.0, 1.0, 0.0);
    let x = [std::f64::consts::FRAC_PI_2, 3.0, 2.0];
    let turned = exponential(Taylor::constant(nalgebra::Matrix2::zeros()).plus(x, j));
    // J at 90°; θ̇ J·J = −3; θ̈ J·J + θ̇² J·J·J = −2 − 9 J
    assert!((turned.value - j).norm() < 1e-14);
    assert!((turned.first + nalgebra::Matrix2::identity() * 3.0).norm() < 1e-13);
    assert!((turned.second + nalgebra::Matrix2::identity() * 2.0 + j * 9.0).norm() < 1e-12);
}
