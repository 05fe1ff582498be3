//! Dense linear system in storage of its own: Gaussian elimination with partial pivoting, by columns.

use pulp::Arch;

/// The lattice has no unique circulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the vortex lattice is singular at panel {panel}: panels of zero size, coinciding panels, or values that are not finite"
)]
pub struct SingularLattice {
    /// Panel at which elimination fails.
    pub panel: usize,
}

/// Square matrix by columns; every column has `rows` entries, of which the first `size` count.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearSystem {
    size: usize,
    rows: usize,
    entries: Vec<f64>,
    pivots: Vec<usize>,
}

impl LinearSystem {
    /// Zero matrix.
    pub fn new(size: usize, rows: usize) -> Self {
        Self { size, rows, entries: vec![0.0; size * rows], pivots: vec![0; size] }
    }

    /// Entries by columns.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        &mut self.entries
    }

    /// Entries by columns, set to zero.
    pub fn cleared(&mut self) -> &mut [f64] {
        self.entries.fill(0.0);
        &mut self.entries
    }

    /// Adds to an entry.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.entries[column * self.rows + row] += value;
    }

    /// An entry.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.entries[column * self.rows + row]
    }

    /// Replaces the matrix by its factors.
    ///
    /// # Errors
    /// Where no pivot differs from zero or one is not finite.
    pub fn factorize(&mut self, arch: Arch) -> Result<(), SingularLattice> {
        arch.dispatch(
            #[inline(always)]
            || self.eliminate(),
        )
    }

    #[inline(always)]
    fn eliminate(&mut self) -> Result<(), SingularLattice> {
        let (size, rows) = (self.size, self.rows);
        for k in 0..size {
            let (done, rest) = self.entries.split_at_mut((k + 1) * rows);
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
            // rows left of the diagonal follow the exchange, so that a solve may exchange first
            for earlier in done[..k * rows].chunks_exact_mut(rows) {
                earlier.swap(k, pivot);
            }
        }
        Ok(())
    }

    /// Replaces the right-hand side by the solution, with the factors.
    pub fn solve(&self, values: &mut [f64]) {
        let (size, rows) = (self.size, self.rows);
        for (k, pivot) in self.pivots.iter().enumerate() {
            values.swap(k, *pivot);
        }
        for k in 0..size {
            let factor = values[k];
            for (value, multiplier) in values[k + 1..size].iter_mut().zip(&self.entries[k * rows + k + 1..]) {
                *value -= factor * multiplier;
            }
        }
        for k in (0..size).rev() {
            let column = &self.entries[k * rows..][..size];
            values[k] /= column[k];
            let factor = values[k];
            for (value, entry) in values[..k].iter_mut().zip(column) {
                *value -= factor * entry;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The residual of a solution is round-off; the matrix needs exchanges of rows (its diagonal starts with zero).
    #[test]
    fn solution_satisfies_the_equations() {
        const SIZE: usize = 37;
        const ROWS: usize = 40;
        let entry = |i: usize, j: usize| if i == j && i < 3 { 0.0 } else { (1.3 * (i * SIZE + j) as f64).sin() };
        let mut system = LinearSystem::new(SIZE, ROWS);
        let entries = system.cleared();
        (0..SIZE).for_each(|j| (0..SIZE).for_each(|i| entries[j * ROWS + i] = entry(i, j)));
        system.factorize(Arch::new()).expect("regular");
        let right: Vec<f64> = (0..SIZE).map(|i| (0.7 * i as f64).cos()).collect();
        let mut x = right.clone();
        system.solve(&mut x);
        let scale: f64 = x.iter().map(|x| x.abs()).sum();
        for (i, right) in right.iter().enumerate() {
            let sum: f64 = (0..SIZE).map(|j| entry(i, j) * x[j]).sum();
            // growth of the factors stays below ten for this matrix
            assert!((sum - right).abs() < 1e-14 * scale, "row {i}: {:e}", sum - right);
        }
    }

    #[test]
    fn equal_columns_are_refused() {
        let mut system = LinearSystem::new(2, 2);
        system.cleared().copy_from_slice(&[1.0, 2.0, 1.0, 2.0]);
        assert_eq!(system.factorize(Arch::new()), Err(SingularLattice { panel: 1 }));
    }
}
