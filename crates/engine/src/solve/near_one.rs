//! The slowest motions of a model in discrete time: eigenvalues of `A` nearest 1, by Arnoldi's method on `(A − σ)⁻¹`.
//!
//! Saad, Numerical Methods for Large Eigenvalue Problems (2011), chapters 6 and 8. States that are copies of another one, as the rows of a
//! wake, are eliminated before the factorisation: `x_i = (a_ij x_j − b_i)/σ`.

use crate::solve::eigen::eigen;
use crate::solve::reduction::balanced_rows;
use nalgebra::{Complex, DMatrix, DVector, Dyn, LU};

/// Dimension of the Krylov space.
const KRYLOV: usize = 160;
/// Distance of the shift from 1. Free motions have the eigenvalue 1, for which no factorisation exists.
const SHIFT: f64 = 1e-3;
/// Residual of an eigenvalue of `(A − σ)⁻¹`, relative to it, below which it has converged. The error of the eigenvalue is larger by its
/// condition, which a long ladder of delays increases.
const FOUND: f64 = 1e-9;
/// Part of a new direction that must be orthogonal to the space; less is round-off, and the space holds all that the start contains.
const NEW: f64 = 1e-12;

/// An eigenvalue per step, and its shape over the states; of a pair the one with positive imaginary part.
pub type SlowMotion = (Complex<f64>, DVector<Complex<f64>>);

/// A state in terms of another one: `x_i = gain · x_root + …`; core states refer to themselves.
#[derive(Clone, Copy)]
struct Place {
    root: Option<usize>,
    gain: f64,
}

/// `(A − σ)⁻¹` with delays eliminated.
struct Inverse<'a> {
    a: &'a DMatrix<f64>,
    sigma: f64,
    /// The state copied by each delay with its factor, in the order in which they follow from the core.
    delays: Vec<(usize, Option<(usize, f64)>)>,
    core: Vec<usize>,
    factors: LU<f64, Dyn, Dyn>,
}

impl<'a> Inverse<'a> {
    fn new(a: &'a DMatrix<f64>, sigma: f64) -> Self {
        let n = a.nrows();
        // column by column, in the order of the storage
        let (mut entries, mut source) = (vec![0usize; n], vec![None; n]);
        for (j, column) in a.column_iter().enumerate() {
            for (i, &entry) in column.iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
                entries[i] += 1;
                source[i] = Some((j, entry));
            }
        }
        // at most one entry beside the diagonal
        let is_delay = |i: usize| entries[i] == 0 || entries[i] == 1 && source[i].is_some_and(|(j, _)| j != i);
        let mut known: Vec<bool> = (0..n).map(|i| !is_delay(i)).collect();
        let mut places: Vec<Place> = (0..n).map(|i| Place { root: Some(i), gain: 1.0 }).collect();
        let mut delays = Vec::new();
        for first in 0..n {
            // back to a state that is known; a ring of delays becomes part of the core
            let mut chain = Vec::new();
            let mut i = first;
            while !known[i] && !chain.contains(&i) {
                chain.push(i);
                match source[i] {
                    Some((j, _)) => i = j,
                    None => break,
                }
            }
            if !known[i] && source[i].is_some() {
                known[i] = true;
            }
            for &i in chain.iter().rev().filter(|&&i| !known[i]).collect::<Vec<_>>() {
                places[i] = match source[i] {
                    Some((j, factor)) => Place { root: places[j].root, gain: places[j].gain * factor / sigma },
                    None => Place { root: None, gain: 0.0 },
                };
                delays.push((i, source[i]));
            }
            chain.iter().for_each(|&i| known[i] = true);
        }
        let mut is_core = vec![true; n];
        delays.iter().for_each(|&(i, _)| is_core[i] = false);
        let core: Vec<usize> = (0..n).filter(|&i| is_core[i]).collect();
        let mut order = vec![0; n];
        core.iter().enumerate().for_each(|(place, &i)| order[i] = place);
        let mut small = DMatrix::zeros(core.len(), core.len());
        for (j, column) in a.column_iter().enumerate() {
            let Place { root: Some(root), gain } = places[j] else { continue };
            let mut own = small.column_mut(order[root]);
            for (row, &i) in core.iter().enumerate() {
                own[row] += column[i] * gain;
            }
        }
        (0..core.len()).for_each(|i| small[(i, i)] -= sigma);
        Self { a, sigma, delays, core, factors: small.lu() }
    }

    /// `(A − σ) x = b`.
    fn solve(&self, b: &DVector<f64>) -> Option<DVector<f64>> {
        // the delays with a core at rest
        let mut x = DVector::zeros(b.len());
        for &(i, source) in &self.delays {
            x[i] = (source.map_or(0.0, |(j, factor)| factor * x[j]) - b[i]) / self.sigma;
        }
        let pushed = self.a * &x;
        let right = DVector::from_iterator(self.core.len(), self.core.iter().map(|&i| b[i] - pushed[i]));
        let solved = self.factors.solve(&right)?;
        self.core.iter().zip(solved.iter()).for_each(|(&i, value)| x[i] = *value);
        for &(i, source) in &self.delays {
            x[i] = (source.map_or(0.0, |(j, factor)| factor * x[j]) - b[i]) / self.sigma;
        }
        Some(x)
    }
}

/// Scales states that act on others but depend on none of them, and those that depend on others but act on none: balancing does not treat
/// them, as it has no product to keep, and their units would make eigenvalues ill-conditioned.
fn shrink_one_sided(matrix: &mut DMatrix<f64>, scale: &mut DVector<f64>) {
    for i in 0..matrix.nrows() {
        let own = matrix[(i, i)].abs();
        let (column, row) = (matrix.column(i).lp_norm(1) - own, matrix.row(i).lp_norm(1) - own);
        let factor = match (column > 0.0, row > 0.0) {
            (true, false) => 1.0 / column,
            (false, true) => row,
            _ => continue,
        };
        let factor = factor.log2().round().exp2();
        scale[i] *= factor;
        matrix.column_mut(i).scale_mut(factor);
        matrix.row_mut(i).unscale_mut(factor);
    }
}

/// The converged eigenvalues of `a` nearest 1, nearest first; `None` without a factorisation or without convergence.
pub fn nearest_one(a: &DMatrix<f64>) -> Option<Vec<SlowMotion>> {
    let n = a.nrows();
    if n == 0 {
        return Some(Vec::new());
    }
    if !a.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let (mut scaled, mut scale) = balanced_rows(a);
    shrink_one_sided(&mut scaled, &mut scale);
    let sigma = 1.0 + SHIFT;
    let inverse = Inverse::new(&scaled, sigma);
    // a start with a part of every motion: no entry is a multiple of another
    let start = DVector::from_fn(n, |i, _| 1.0 + (i as f64 * 0.618_033_988_749_895).fract());
    let mut space = vec![start.normalize()];
    let most = KRYLOV.min(n);
    let mut h = DMatrix::zeros(most + 1, most);
    let mut size = most;
    for step in 0..most {
        let mut next = inverse.solve(&space[step])?;
        let before = next.norm();
        if !before.is_finite() {
            return None;
        }
        for _ in 0..2 {
            for (row, known) in space.iter().enumerate() {
                let part = known.dot(&next);
                next.axpy(-part, known, 1.0);
                h[(row, step)] += part;
            }
        }
        let left = next.norm();
        if left <= NEW * before || step + 1 == n {
            size = step + 1;
            break;
        }
        h[(step + 1, step)] = left;
        space.push(next.unscale(left));
    }
    let beyond = h[(size, size - 1)];
    let found = eigen(&h.view((0, 0), (size, size)).into_owned())?;
    let mut list: Vec<SlowMotion> = Vec::new();
    for (i, &theta) in found.values.iter().enumerate().filter(|(_, theta)| theta.im >= 0.0) {
        let entry = |row: usize| {
            let im = if theta.im > 0.0 { found.vectors[(row, i + 1)] } else { 0.0 };
            Complex::new(found.vectors[(row, i)], im)
        };
        if theta.norm() == 0.0 || beyond * entry(size - 1).norm() > FOUND * theta.norm() {
            continue;
        }
        let mut shape: DVector<Complex<f64>> = DVector::zeros(n);
        for (row, direction) in space.iter().take(size).enumerate() {
            shape.zip_apply(direction, |sum, part| *sum += entry(row) * part);
        }
        shape.zip_apply(&scale, |entry, scale| *entry *= scale);
        // 1/θ of a value with positive imaginary part has a negative one
        list.push((theta.inv().conj() + sigma, shape.map(|entry| entry.conj())));
    }
    list.sort_by(|(a, _), (b, _)| (a - 1.0).norm().total_cmp(&(b - 1.0).norm()));
    if list.is_empty() { None } else { Some(list) }
}
