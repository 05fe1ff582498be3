//! Dense linear system with its storage: Gaussian elimination with partial pivoting, in panels of columns.

use crate::math::wide::wide;
use pulp::{Arch, Simd, WithSimd};

/// Number of columns in a panel.
const PANEL: usize = 32;
/// Number of columns whose entries stay in registers while the contribution of a panel is subtracted.
const COLUMNS: usize = 4;
/// Number of rows of a panel that stay in the first-level cache.
const TILE_ROWS: usize = 64;

/// Change of a solution, relative to its largest value, at which round-off is reached.
const ROUND_OFF: f64 = 1e-14;
/// Number of refinement steps that cost as much as a new factorisation, for a hundred unknowns or more.
const MAX_IMPROVEMENTS: usize = 8;
/// Error reduction factor of a refinement step above which a new factorisation is cheaper.
const MAX_SHARE: f64 = 0.05;

/// The lattice has no unique circulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the vortex lattice is singular at panel {panel}: panels of zero size, coinciding panels, or values that are not finite"
)]
pub struct SingularLattice {
    /// Index of the panel at which elimination fails.
    pub panel: usize,
}

/// Column-major square matrix; every column has `rows` entries, of which the first `size` are used.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearSystem {
    size: usize,
    rows: usize,
    entries: Vec<f64>,
    /// Factors of the matrix, or of an earlier one.
    factors: Vec<f64>,
    pivots: Vec<usize>,
    change: Vec<f64>,
    /// Rows of a panel, packed contiguously.
    packed: Vec<f64>,
}

impl LinearSystem {
    /// Zero matrix.
    pub fn new(size: usize, rows: usize) -> Self {
        let packed = vec![0.0; TILE_ROWS * PANEL];
        Self {
            size,
            rows,
            entries: vec![0.0; size * rows],
            factors: vec![0.0; size * rows],
            pivots: vec![0; size],
            change: vec![0.0; rows],
            packed,
        }
    }

    /// Entries, column by column.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.entries
    }

    /// Sets all entries to zero and returns them, column by column.
    pub fn cleared(&mut self) -> &mut [f64] {
        self.entries.fill(0.0);
        &mut self.entries
    }

    /// Adds a value to an entry.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.entries[column * self.rows + row] += value;
    }

    /// Value of an entry.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.entries[column * self.rows + row]
    }

    /// Factorises the matrix, which is preserved.
    ///
    /// # Errors
    /// If there is no nonzero pivot, or a pivot is not finite.
    pub fn factorize(&mut self, arch: Arch) -> Result<(), SingularLattice> {
        self.factors.copy_from_slice(&self.entries);
        arch.dispatch(Elimination(self))
    }

    /// Eliminates panel by panel, each followed by the subtraction of its contribution from the columns to its right. Every entry undergoes
    /// the same operations in the same order as without panels.
    #[inline(always)]
    fn eliminate<S: Simd>(&mut self, simd: S) -> Result<(), SingularLattice> {
        let (size, rows) = (self.size, self.rows);
        for first in (0..size).step_by(PANEL) {
            let end = (first + PANEL).min(size);
            self.eliminate_panel(first, end)?;
            for (k, &pivot) in self.pivots.iter().enumerate().take(end).skip(first) {
                let (left, right) = self.factors.split_at_mut(end * rows);
                // the row exchange includes the columns to the left, so that a solution can apply all exchanges first
                let others = left[..first * rows].chunks_exact_mut(rows).chain(right.chunks_exact_mut(rows));
                others.for_each(|column| column.swap(k, pivot));
            }
            let (done, rest) = self.factors.split_at_mut(end * rows);
            let panel = &done[first * rows..];
            for column in rest.chunks_exact_mut(rows) {
                for k in first..end {
                    let factor = column[k];
                    let multipliers = &panel[(k - first) * rows..][k + 1..end];
                    column[k + 1..end].iter_mut().zip(multipliers).for_each(|(entry, l)| *entry -= factor * l);
                }
            }
            self.take_panel(simd, first, end);
        }
        Ok(())
    }

    /// Eliminates columns `first` to `end` below row `first`, with the row exchanges within them.
    #[inline(always)]
    fn eliminate_panel(&mut self, first: usize, end: usize) -> Result<(), SingularLattice> {
        let (size, rows) = (self.size, self.rows);
        for k in first..end {
            let (done, rest) = self.factors[..end * rows].split_at_mut((k + 1) * rows);
            let column = &mut done[k * rows..][..size];
            let pivot = (k..size).fold(k, |best, i| if column[i].abs() > column[best].abs() { i } else { best });
            self.pivots[k] = pivot;
            let value = column[pivot];
            if value == 0.0 || !value.is_finite() {
                return Err(SingularLattice { panel: k });
            }
            column.swap(k, pivot);
            let below = &mut column[k + 1..];
            below.iter_mut().for_each(|entry| *entry /= value);
            for other in rest.chunks_exact_mut(rows) {
                other.swap(k, pivot);
                let factor = other[k];
                for (entry, multiplier) in other[k + 1..size].iter_mut().zip(below.iter()) {
                    *entry -= factor * multiplier;
                }
            }
            for earlier in done[first * rows..k * rows].chunks_exact_mut(rows) {
                earlier.swap(k, pivot);
            }
        }
        Ok(())
    }

    /// Subtracts the contribution of a panel from the rows below it and the columns to its right.
    #[inline(always)]
    fn take_panel<S: Simd>(&mut self, simd: S, first: usize, end: usize) {
        let rows = self.rows;
        let (done, rest) = self.factors.split_at_mut(end * rows);
        if rest.is_empty() {
            return;
        }
        let (panel, strip) = (&done[first * rows..], 2 * S::F64_LANES);
        for low in (end..rows).step_by(TILE_ROWS) {
            let high = (low + TILE_ROWS).min(rows);
            // the panel's rows of the tile, strip by strip
            let packed = &mut self.packed[..(high - low) * PANEL];
            for (at, strip_rows) in (low..high).step_by(strip).enumerate() {
                let count = strip.min(high - strip_rows);
                let packed = packed[at * strip * PANEL..].chunks_exact_mut(count);
                for (packed, column) in packed.zip(panel.chunks_exact(rows)) {
                    packed.copy_from_slice(&column[strip_rows..][..count]);
                }
            }
            for columns in rest.chunks_mut(COLUMNS * rows) {
                let mut upper = [[0.0; COLUMNS]; PANEL];
                for (j, column) in columns.chunks_exact(rows).enumerate() {
                    upper.iter_mut().zip(&column[first..end]).for_each(|(factors, value)| factors[j] = *value);
                }
                for (at, strip_rows) in (low..high).step_by(strip).enumerate() {
                    let count = strip.min(high - strip_rows);
                    let packed = &packed[at * strip * PANEL..][..count * PANEL];
                    if count == strip && columns.len() == COLUMNS * rows {
                        take_strip(simd, packed, &upper, columns, rows, strip_rows);
                    } else {
                        take_rest(packed, &upper, columns, rows, strip_rows, count);
                    }
                }
            }
        }
    }

    /// Overwrites the right-hand side with the solution, using the factors.
    pub fn solve(&self, arch: Arch, values: &mut [f64]) {
        wide(
            arch,
            #[inline(always)]
            || self.substitute(values),
        );
    }

    /// Solves with the factors of a nearby matrix by iterative refinement, `x ← x + F⁻¹(b − A x)`, to round-off. Returns false if that
    /// takes too many steps; the solution is then invalid.
    pub fn solve_with_factors_near_by(&mut self, arch: Arch, right: &[f64], solution: &mut [f64]) -> bool {
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        solution.copy_from_slice(right);
        self.solve(arch, solution);
        let mut before = largest(solution);
        for _ in 0..MAX_IMPROVEMENTS {
            let mut change = std::mem::take(&mut self.change);
            wide(
                arch,
                #[inline(always)]
                || {
                    self.remain(right, solution, &mut change);
                    self.substitute(&mut change[..self.size]);
                },
            );
            solution.iter_mut().zip(&change).for_each(|(value, change)| *value += change);
            let (step, size) = (largest(&change[..self.size]), largest(solution));
            self.change = change;
            let share = step / before;
            if step <= ROUND_OFF * size || share < MAX_SHARE && share * step <= ROUND_OFF * size {
                return true;
            }
            if share.is_nan() || share >= MAX_SHARE {
                return false;
            }
            before = step;
        }
        false
    }

    /// Residual `b − A x`, column by column.
    #[inline(always)]
    fn remain(&self, right: &[f64], solution: &[f64], residual: &mut [f64]) {
        residual[..self.size].copy_from_slice(right);
        residual[self.size..].fill(0.0);
        let columns = self.entries.chunks_exact(COLUMNS * self.rows);
        let (rest, values) = (columns.remainder(), solution.chunks_exact(COLUMNS));
        let left_over = values.remainder();
        for (columns, values) in columns.zip(values) {
            let (a, others) = columns.split_at(self.rows);
            let (b, others) = others.split_at(self.rows);
            let (c, d) = others.split_at(self.rows);
            for ((((sum, a), b), c), d) in residual.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *sum -= (a * values[0] + b * values[1]) + (c * values[2] + d * values[3]);
            }
        }
        for (column, value) in rest.chunks_exact(self.rows).zip(left_over) {
            residual.iter_mut().zip(column).for_each(|(sum, entry)| *sum -= entry * value);
        }
    }

    #[inline(always)]
    fn substitute(&self, values: &mut [f64]) {
        let (size, rows) = (self.size, self.rows);
        for (k, pivot) in self.pivots.iter().enumerate() {
            values.swap(k, *pivot);
        }
        for k in 0..size {
            let factor = values[k];
            for (value, multiplier) in values[k + 1..size].iter_mut().zip(&self.factors[k * rows + k + 1..]) {
                *value -= factor * multiplier;
            }
        }
        for k in (0..size).rev() {
            let column = &self.factors[k * rows..][..size];
            values[k] /= column[k];
            let factor = values[k];
            for (value, entry) in values[..k].iter_mut().zip(column) {
                *value -= factor * entry;
            }
        }
    }
}

/// The elimination, compiled for one type of SIMD vectors.
struct Elimination<'a>(&'a mut LinearSystem);

impl WithSimd for Elimination<'_> {
    type Output = Result<(), SingularLattice>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.0.eliminate(simd)
    }
}

/// Two vectors of rows times [`COLUMNS`] columns: eight sums that stay in registers.
#[inline(always)]
fn take_strip<S: Simd>(
    simd: S,
    packed: &[f64],
    upper: &[[f64; COLUMNS]; PANEL],
    columns: &mut [f64],
    rows: usize,
    first_row: usize,
) {
    let strip = 2 * S::F64_LANES;
    let (packed, _) = S::as_simd_f64s(packed);
    let load = |column: usize| {
        let (values, _) = S::as_simd_f64s(&columns[column * rows + first_row..][..strip]);
        (values[0], values[1])
    };
    let (mut a0, mut a1) = load(0);
    let (mut b0, mut b1) = load(1);
    let (mut c0, mut c1) = load(2);
    let (mut d0, mut d1) = load(3);
    for (multipliers, factors) in packed.chunks_exact(2).zip(upper) {
        let (low, high) = (multipliers[0], multipliers[1]);
        let [a, b, c, d] = factors.map(|factor| simd.splat_f64s(factor));
        a0 = simd.sub_f64s(a0, simd.mul_f64s(a, low));
        a1 = simd.sub_f64s(a1, simd.mul_f64s(a, high));
        b0 = simd.sub_f64s(b0, simd.mul_f64s(b, low));
        b1 = simd.sub_f64s(b1, simd.mul_f64s(b, high));
        c0 = simd.sub_f64s(c0, simd.mul_f64s(c, low));
        c1 = simd.sub_f64s(c1, simd.mul_f64s(c, high));
        d0 = simd.sub_f64s(d0, simd.mul_f64s(d, low));
        d1 = simd.sub_f64s(d1, simd.mul_f64s(d, high));
    }
    for (column, sums) in [(a0, a1), (b0, b1), (c0, c1), (d0, d1)].into_iter().enumerate() {
        let (values, _) = S::as_mut_simd_f64s(&mut columns[column * rows + first_row..][..strip]);
        (values[0], values[1]) = sums;
    }
}

/// Eliminates the remainders at the ends of rows and columns.
#[inline(always)]
fn take_rest(
    packed: &[f64],
    upper: &[[f64; COLUMNS]; PANEL],
    columns: &mut [f64],
    rows: usize,
    first_row: usize,
    count: usize,
) {
    for (j, column) in columns.chunks_exact_mut(rows).enumerate() {
        for (multipliers, factors) in packed.chunks_exact(count).zip(upper) {
            for (value, multiplier) in column[first_row..][..count].iter_mut().zip(multipliers) {
                *value -= factors[j] * multiplier;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The residual of a solution is round-off; the matrix needs row exchanges (the first diagonal entry is zero).
    #[test]
    fn solution_satisfies_the_equations() {
        const SIZE: usize = 37;
        const ROWS: usize = 40;
        let entry = |i: usize, j: usize| if i == j && i < 3 { 0.0 } else { entry(i, j, 0.0) };
        let mut system = LinearSystem::new(SIZE, ROWS);
        let entries = system.cleared();
        (0..SIZE).for_each(|j| (0..SIZE).for_each(|i| entries[j * ROWS + i] = entry(i, j)));
        system.factorize(Arch::new()).expect("regular");
        let right: Vec<f64> = (0..SIZE).map(|i| (0.7 * i as f64).cos()).collect();
        let mut x = right.clone();
        system.solve(Arch::new(), &mut x);
        let scale: f64 = x.iter().map(|x| x.abs()).sum();
        for (i, right) in right.iter().enumerate() {
            let sum: f64 = (0..SIZE).map(|j| entry(i, j) * x[j]).sum();
            // growth of the factors stays below ten for this matrix
            assert!((sum - right).abs() < 1e-14 * scale, "row {i}: {:e}", sum - right);
        }
    }

    /// Irregular entries; `change` is the factor of a second matrix that is added to the first.
    fn entry(i: usize, j: usize, change: f64) -> f64 {
        (1.3 + 0.37 * (3 * i * i + 5 * i * j + 7 * j * j) as f64).sin()
            + change * (0.9 * (i * i + 2 * j * j * i) as f64).cos()
    }

    fn system(size: usize, change: f64) -> LinearSystem {
        let mut system = LinearSystem::new(size, size.next_multiple_of(4));
        (0..size).for_each(|j| (0..size).for_each(|i| system.add(i, j, entry(i, j, change))));
        system
    }

    /// Panels change the order in which entries are treated, but not the operations on any of them.
    #[test]
    fn factors_are_those_of_plain_elimination_to_the_bit() {
        for size in [1, 5, 31, 32, 33, 64, 95, 128, 203] {
            let mut panels = system(size, 0.0);
            panels.factorize(Arch::new()).expect("regular");
            let mut plain: Vec<Vec<f64>> = (0..size).map(|j| (0..size).map(|i| entry(i, j, 0.0)).collect()).collect();
            for k in 0..size {
                let best = (k..size).fold(k, |best, i| if plain[k][i].abs() > plain[k][best].abs() { i } else { best });
                assert_eq!(panels.pivots[k], best, "{size}: pivot {k}");
                plain.iter_mut().for_each(|column| column.swap(k, best));
                let value = plain[k][k];
                plain[k][k + 1..].iter_mut().for_each(|entry| *entry /= value);
                let multipliers = plain[k].clone();
                for column in &mut plain[k + 1..] {
                    let factor = column[k];
                    (k + 1..size).for_each(|i| column[i] -= factor * multipliers[i]);
                }
            }
            for (j, column) in plain.iter().enumerate() {
                assert_eq!(&panels.factors[j * panels.rows..][..size], column, "{size}: column {j}");
            }
        }
    }

    /// Factors of a nearby matrix give the exact solution to round-off; factors of an unrelated matrix report failure.
    #[test]
    fn factors_of_a_matrix_near_by_find_the_solution() {
        for size in [3, 66, 130] {
            let right: Vec<f64> = (0..size).map(|i| (0.7 * i as f64).cos()).collect();
            let mut direct = right.clone();
            let mut own = system(size, 1e-5);
            own.factorize(Arch::new()).expect("regular");
            own.solve(Arch::new(), &mut direct);
            let scale = direct.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let mut near = system(size, 0.0);
            near.factorize(Arch::new()).expect("regular");
            near.entries.copy_from_slice(&own.entries);
            let mut improved = vec![0.0; size];
            assert!(near.solve_with_factors_near_by(Arch::new(), &right, &mut improved));
            // the error of both is the condition number, some hundreds, times round-off
            let off = direct.iter().zip(&improved).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12 * scale, "{size}: {off:e} of {scale:e}");
            near.entries.copy_from_slice(&system(size, 1.0).entries);
            assert!(!near.solve_with_factors_near_by(Arch::new(), &right, &mut improved));
        }
    }

    #[test]
    fn equal_columns_are_refused() {
        let mut system = LinearSystem::new(2, 2);
        system.cleared().copy_from_slice(&[1.0, 2.0, 1.0, 2.0]);
        assert_eq!(system.factorize(Arch::new()), Err(SingularLattice { panel: 1 }));
    }
}
