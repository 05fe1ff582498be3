//! Small matrices of the elimination: changes of wrenches and of forces with the variation of a node.

use crate::math::wide::Fours;
pub(super) use crate::math::wide::Quad;
use crate::multibody::derivative::chain::Timed;
use nalgebra::Vector3;

/// Number of the entries of a node's variation.
pub(super) const STATE: usize = 15;
/// Place of the first derivative of the displacement.
pub(super) const RATE: usize = 0;
/// Place of the second derivative of the displacement.
pub(super) const ACCELERATION: usize = 3;
/// Places of the rotation and its derivatives.
pub(super) const TURNS: [usize; 3] = [6, 9, 12];

/// Force and moment, each filled up with a zero: two vectors of the processor.
pub(super) type Padded = [f64; 8];

/// Places of the entries of a wrench.
pub(super) const PLACES: [usize; 6] = [0, 1, 2, 4, 5, 6];

/// Number of the entries without the first derivative of the displacement.
pub(super) const UNDAMPED: usize = STATE - ACCELERATION;

/// A matrix of the columns without those of the first derivative of the displacement.
pub(super) type Undamped = [Padded; UNDAMPED];

/// A matrix of 15 columns: change of `R` numbers with a node's variation.
pub(super) type Gains<const R: usize> = [[f64; R]; STATE];

/// `sum += factor · values`.
#[inline(always)]
pub(super) fn add<const R: usize>(sum: &mut [f64; R], factor: f64, values: &[f64; R]) {
    for i in 0..R {
        sum[i] += factor * values[i];
    }
}

#[inline(always)]
pub(super) fn dot<const R: usize>(a: &[f64; R], b: &[f64; R]) -> f64 {
    (0..R).fold(0.0, |sum, i| sum + a[i] * b[i])
}

/// Sum of columns with factors.
#[inline(always)]
pub(super) fn combined<V: Fours, const R: usize, const C: usize>(
    fours: V,
    columns: &[[f64; R]; C],
    factors: &[f64; C],
) -> [f64; R] {
    let mut sum = [0.0; R];
    for k in 0..C {
        fours.add(&mut sum, factors[k], &columns[k]);
    }
    sum
}

#[inline(always)]
pub(super) fn set(values: &mut [f64], at: usize, vector: &Vector3<f64>) {
    values[at..at + 3].copy_from_slice(vector.as_slice());
}

#[inline(always)]
pub(super) fn at(values: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(values[at], values[at + 1], values[at + 2])
}

/// Adds `matrix · [arm]ᵀ×`, three columns from three columns: change with a rotation that moves the end of an arm.
#[inline(always)]
pub(super) fn add_turned<V: Fours, const R: usize, const C: usize>(
    fours: V,
    sum: &mut Gains<R>,
    to: usize,
    matrix: &[[f64; R]; C],
    from: usize,
    arm: &Vector3<f64>,
) {
    for (k, [i, j]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        fours.add(&mut sum[to + k], arm[i], &matrix[from + j]);
        fours.add(&mut sum[to + k], -arm[j], &matrix[from + i]);
    }
}

/// Change with the carrier's variation, from the change with that of the outer node.
#[inline(always)]
pub(super) fn carried<V: Fours, const R: usize>(fours: V, matrix: &Gains<R>, [r, r1, r2]: &Timed) -> Gains<R> {
    let mut sum = *matrix;
    let [turn, turn1, turn2] = TURNS;
    add_turned(fours, &mut sum, turn, matrix, RATE, r1);
    add_turned(fours, &mut sum, turn, matrix, ACCELERATION, r2);
    add_turned(fours, &mut sum, turn1, matrix, RATE, r);
    add_turned(fours, &mut sum, turn1, matrix, ACCELERATION, &(r1 * 2.0));
    add_turned(fours, &mut sum, turn2, matrix, ACCELERATION, r);
    sum
}

/// Adds a matrix without the columns of the first derivative of the displacement, which are `alpha_1_s` times those of the second.
#[inline(always)]
pub(super) fn add_undamped<V: Fours>(fours: V, sum: &mut Gains<8>, own: &Undamped, alpha_1_s: f64) {
    for k in 0..3 {
        fours.add(&mut sum[RATE + k], alpha_1_s, &own[k]);
    }
    for k in 0..UNDAMPED {
        fours.add(&mut sum[ACCELERATION + k], 1.0, &own[k]);
    }
}
