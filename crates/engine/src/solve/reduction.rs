//! Linear models in modal form: fewer states by modal and by balanced truncation, and samples in time, NOTATION eqs. (L18)–(L20).

use crate::solve::eigen::{Eigen, eigen};
use crate::solve::linearize::StateSpace;
use nalgebra::{Complex, DMatrix, DVector, SVD};

type ComplexMatrix = DMatrix<Complex<f64>>;

/// What a reduction keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// The slowest modes.
    Modes,
    /// What carries most from the inputs to the outputs.
    Balanced,
}

/// A model with fewer states.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduced {
    /// The model, with the gain at rest of the whole one.
    pub model: StateSpace,
    /// Bound on the largest singular value, over all frequencies, of what was left out. `None` if a motion that does not decay was
    /// left out.
    pub error_bound: Option<f64>,
    /// Hankel singular values, largest first; infinite for states of motions that do not decay. Empty for modal truncation.
    pub hankel: Vec<f64>,
}

/// Why a model cannot be reduced or sampled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoReduction {
    /// The eigenvalue iteration failed.
    #[error("the eigenvalues of A cannot be found")]
    Eigenvalues,
    /// Equal eigenvalues whose vectors coincide.
    #[error(
        "A has eigenvalues that coincide with their vectors (condition {condition:.1e}), as of a free body; hold its motion, or choose \
         another state"
    )]
    Defective {
        /// Condition of the eigenvectors.
        condition: f64,
    },
    /// Too few or too many states.
    #[error("{order} states cannot be kept: allowed are {least} to {most}{}", if *.least > 1 { ", as motions that do not decay stay whole" } else { "" })]
    Order {
        /// What was asked for.
        order: usize,
        /// Fewest that are possible.
        least: usize,
        /// All states.
        most: usize,
    },
    /// Balanced truncation in discrete time of a model with motions that do not decay.
    #[error(
        "the model has motions that do not decay, which balanced truncation in discrete time cannot reduce; choose a state below flutter, or hold the motion"
    )]
    Grows,
    /// Reduction to modes in discrete time: the modes of the wake have no order.
    #[error("models in discrete time are reduced by balanced truncation, not to modes")]
    SampledModes,
    /// A band for a model in continuous time.
    #[error("only models in discrete time are reduced for a band of frequencies; linearise with the air of a lattice")]
    Continuous,
    /// A band that ends nowhere in the frequencies of the samples.
    #[error("the band must end above 0 Hz and below half the sampling rate")]
    Band,
    /// A singular matrix on the way.
    #[error("the balanced form cannot be found; keep more states, or keep modes")]
    Singular,
}

/// Condition of the eigenvectors beyond which half of all digits are lost.
const MAXIMUM_CONDITION: f64 = 1e9;
/// Share of `|λ|` below which the real part of an eigenvalue is round-off: the motion does not decay.
const NO_DECAY: f64 = 1e-10;
/// Hankel singular values, relative to the largest, that are round-off of the Gramians.
const ROUND_OFF: f64 = 1e-9;

/// A model in real modal form: blocks of one or two states, slowest first.
struct Modal {
    blocks: Vec<Block>,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
}

/// One real eigenvalue, or a pair: that with positive imaginary part.
#[derive(Clone, Copy)]
struct Block {
    first: usize,
    eigenvalue: Complex<f64>,
}

impl Block {
    fn size(self) -> usize {
        if self.eigenvalue.im == 0.0 { 1 } else { 2 }
    }

    fn decays(self) -> bool {
        self.eigenvalue.re < -NO_DECAY * self.eigenvalue.norm()
    }
}

impl Modal {
    /// Of a model whose states are scaled first: powers of two make rows and columns of `A` alike.
    fn new(model: &StateSpace) -> Result<(Self, DMatrix<f64>), NoReduction> {
        let n = model.a.nrows();
        let (scaled, scale) = balanced_rows(&model.a);
        let Eigen { values, vectors } = eigen(&scaled).ok_or(NoReduction::Eigenvalues)?;
        let mut starts: Vec<usize> = (0..n).filter(|&i| values[i].im >= 0.0).collect();
        starts.sort_by(|&i, &j| values[i].norm().total_cmp(&values[j].norm()));
        let columns = starts.iter().flat_map(|&i| if values[i].im == 0.0 { vec![i] } else { vec![i, i + 1] });
        let vectors = vectors.select_columns(&columns.collect::<Vec<_>>());
        let inverse = vectors.clone().try_inverse().ok_or(NoReduction::Defective { condition: f64::INFINITY })?;
        let condition = vectors.norm() * inverse.norm();
        if !condition.is_finite() || condition > MAXIMUM_CONDITION * n as f64 {
            return Err(NoReduction::Defective { condition });
        }
        let mut a = DMatrix::zeros(n, n);
        let (mut blocks, mut first) = (Vec::with_capacity(starts.len()), 0);
        for start in starts {
            let block = Block { first, eigenvalue: values[start] };
            let Complex { re, im } = block.eigenvalue;
            (first..first + block.size()).for_each(|i| a[(i, i)] = re);
            if block.size() == 2 {
                a[(first, first + 1)] = im;
                a[(first + 1, first)] = -im;
            }
            first += block.size();
            blocks.push(block);
        }
        // x = S V z
        let to_states = DMatrix::from_fn(n, n, |i, j| scale[i] * vectors[(i, j)]);
        let from_states = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / scale[j]);
        let (b, c) = (&from_states * &model.b, &model.c * &to_states);
        Ok((Self { blocks, a, b, c }, to_states))
    }

    /// Rows of `b` and columns of `c` in complex coordinates, one for each eigenvalue: `z = (ζ + ζ̄, i(ζ − ζ̄))`.
    fn complex(&self) -> (Vec<Complex<f64>>, ComplexMatrix, ComplexMatrix) {
        let n = self.a.nrows();
        let (mut values, mut b, mut c) =
            (Vec::with_capacity(n), DMatrix::zeros(n, self.b.ncols()), DMatrix::zeros(self.c.nrows(), n));
        let i = Complex::new(0.0, 1.0);
        for block in &self.blocks {
            let k = block.first;
            values.push(block.eigenvalue);
            if block.size() == 1 {
                (0..b.ncols()).for_each(|j| b[(k, j)] = self.b[(k, j)].into());
                (0..c.nrows()).for_each(|j| c[(j, k)] = self.c[(j, k)].into());
                continue;
            }
            values.push(block.eigenvalue.conj());
            for j in 0..b.ncols() {
                let value = (Complex::from(self.b[(k, j)]) - i * self.b[(k + 1, j)]) * 0.5;
                (b[(k, j)], b[(k + 1, j)]) = (value, value.conj());
            }
            for j in 0..c.nrows() {
                let value = Complex::from(self.c[(j, k)]) + i * self.c[(j, k + 1)];
                (c[(j, k)], c[(j, k + 1)]) = (value, value.conj());
            }
        }
        (values, b, c)
    }
}

/// `A` with rows and columns scaled alike by powers of two, and the scale of each state: `diag(1/s) A diag(s)`.
pub(super) fn balanced_rows(matrix: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let n = matrix.nrows();
    let (mut scaled, mut scale) = (matrix.clone(), DVector::from_element(n, 1.0));
    for _ in 0..100 {
        let mut settled = true;
        for i in 0..n {
            let beside = |j: &usize| *j != i;
            let column: f64 = (0..n).filter(beside).map(|j| scaled[(j, i)].abs()).sum();
            let row: f64 = (0..n).filter(beside).map(|j| scaled[(i, j)].abs()).sum();
            if column == 0.0 || row == 0.0 {
                continue;
            }
            let factor = (0.5 * (row / column).log2()).round().exp2();
            if factor != 1.0 && (column * factor + row / factor) < 0.95 * (column + row) {
                settled = false;
                scale[i] *= factor;
                scaled.column_mut(i).scale_mut(factor);
                scaled.row_mut(i).unscale_mut(factor);
            }
        }
        if settled {
            break;
        }
    }
    (scaled, scale)
}

/// A model with `order` states, eqs. (L18) and (L19). Modal truncation keeps one less where it would tear a pair.
///
/// # Errors
/// [`NoReduction`], with what is possible.
pub fn reduce(model: &StateSpace, order: usize, keep: Keep) -> Result<Reduced, NoReduction> {
    let most = model.a.nrows();
    if order == 0 || order > most {
        return Err(NoReduction::Order { order, least: 1, most });
    }
    let (modal, _) = Modal::new(model)?;
    match keep {
        Keep::Modes => Ok(slowest(&modal, &model.d, order)),
        Keep::Balanced => balanced(&modal, &model.d, order),
    }
}

/// The slowest modes; the others follow at once, eq. (L18).
fn slowest(modal: &Modal, d: &DMatrix<f64>, order: usize) -> Reduced {
    let kept = modal.blocks.iter().take_while(|block| block.first + block.size() <= order).count();
    let states = modal.blocks.get(kept).map_or(modal.a.nrows(), |block| block.first);
    let (values, b, c) = modal.complex();
    let mut bound = Some(0.0);
    let mut d = d.clone();
    for (k, value) in values.iter().enumerate().skip(states) {
        let (row, column) = (b.row(k), c.column(k));
        if value.norm() > 0.0 {
            d -= DMatrix::from_fn(d.nrows(), d.ncols(), |i, j| (column[i] * row[j] / value).re);
        }
        let decays = value.re < -NO_DECAY * value.norm();
        bound = bound.filter(|_| decays).map(|bound: f64| bound + row.norm() * column.norm() / -value.re);
    }
    let model = StateSpace {
        a: modal.a.view((0, 0), (states, states)).into_owned(),
        b: modal.b.rows(0, states).into_owned(),
        c: modal.c.columns(0, states).into_owned(),
        d,
    };
    Reduced { model, error_bound: bound, hankel: Vec::new() }
}

/// What carries most from inputs to outputs, eq. (L19): motions that do not decay stay whole, of the others the states with the largest
/// Hankel singular values; the rest follows at once (singular perturbation), which keeps the gain at rest and the bound.
fn balanced(modal: &Modal, d: &DMatrix<f64>, order: usize) -> Result<Reduced, NoReduction> {
    let places = |decays: bool| -> Vec<usize> {
        let blocks = modal.blocks.iter().filter(|block| block.decays() == decays);
        blocks.flat_map(|block| block.first..block.first + block.size()).collect()
    };
    let (whole, stable) = (places(false), places(true));
    if order < whole.len() {
        return Err(NoReduction::Order { order, least: whole.len(), most: modal.a.nrows() });
    }
    let [reach, observe] = gramians(modal, &stable);
    let [left, right] = [root(&observe), root(&reach)];
    let svd = SVD::try_new(left.transpose() * &right, true, true, f64::EPSILON, 0).ok_or(NoReduction::Singular)?;
    let (Some(u), Some(vt)) = (&svd.u, &svd.v_t) else { return Err(NoReduction::Singular) };
    let mut rank: Vec<usize> = (0..svd.singular_values.len()).collect();
    rank.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
    let hankel: Vec<f64> = rank.iter().map(|&i| svd.singular_values[i]).collect();
    let largest = hankel.first().copied().unwrap_or(0.0);
    let sound = hankel.iter().take_while(|&&value| value > ROUND_OFF * largest && value > 0.0).count();
    let kept = (order - whole.len()).min(sound);
    let scaled =
        |matrix: DMatrix<f64>| DMatrix::from_fn(matrix.nrows(), sound, |i, j| matrix[(i, rank[j])] / hankel[j].sqrt());
    let (into, out) = (scaled(&left * u), scaled(&right * vt.transpose()));
    let block = |rows: &[usize], columns: &[usize]| modal.a.select_rows(rows).select_columns(columns);
    let a = into.transpose() * block(&stable, &stable) * &out;
    let b = into.transpose() * modal.b.select_rows(&stable);
    let c = modal.c.select_columns(&stable) * &out;
    let (slow, fast): (Vec<usize>, Vec<usize>) = (0..sound).partition(|&i| i < kept);
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| a[(rows[i], columns[j])])
    };
    let mut a_slow = part(&slow, &slow);
    let (mut b_slow, mut c_slow) = (b.select_rows(&slow), c.select_columns(&slow));
    if !fast.is_empty() {
        let lu = part(&fast, &fast).lu();
        let solved = |matrix: DMatrix<f64>| lu.solve(&matrix).ok_or(NoReduction::Singular);
        let by_input = solved(b.select_rows(&fast))?;
        let (across, seen) = (part(&slow, &fast), c.select_columns(&fast));
        b_slow -= &across * &by_input;
        if !slow.is_empty() {
            let by_state = solved(part(&fast, &slow))?;
            a_slow -= &across * &by_state;
            c_slow -= &seen * &by_state;
        }
    }
    // from the gain at rest, which the states with small values know to few digits only
    let (values, by_input, seen) = modal.complex();
    let mut d = DMatrix::from_fn(d.nrows(), d.ncols(), |i, j| {
        d[(i, j)] - stable.iter().map(|&k| (seen[(i, k)] * by_input[(k, j)] / values[k]).re).sum::<f64>()
    });
    if !slow.is_empty() {
        d += &c_slow * a_slow.clone().lu().solve(&b_slow).ok_or(NoReduction::Singular)?;
    }
    let (first, n) = (whole.len(), whole.len() + kept);
    let (a_whole, b_whole, c_whole) =
        (block(&whole, &whole), modal.b.select_rows(&whole), modal.c.select_columns(&whole));
    let model = StateSpace {
        a: DMatrix::from_fn(n, n, |i, j| match (i < first, j < first) {
            (true, true) => a_whole[(i, j)],
            (false, false) => a_slow[(i - first, j - first)],
            _ => 0.0,
        }),
        b: DMatrix::from_fn(n, b.ncols(), |i, j| if i < first { b_whole[(i, j)] } else { b_slow[(i - first, j)] }),
        c: DMatrix::from_fn(c.nrows(), n, |i, j| if j < first { c_whole[(i, j)] } else { c_slow[(i, j - first)] }),
        d,
    };
    let bound = 2.0 * hankel[kept..].iter().sum::<f64>();
    let hankel = std::iter::repeat_n(f64::INFINITY, whole.len()).chain(hankel).collect();
    Ok(Reduced { model, error_bound: Some(bound), hankel })
}

/// Gramians of the stable part in real modal coordinates, in closed form from those in complex ones:
/// `P_ij = −b_i b̄_j/(λ_i + λ̄_j)`.
fn gramians(modal: &Modal, stable: &[usize]) -> [DMatrix<f64>; 2] {
    let (values, b, c) = modal.complex();
    let n = stable.len();
    let gramian = |rows: &dyn Fn(usize, usize) -> Complex<f64>, conjugate: bool| {
        DMatrix::from_fn(n, n, |i, j| {
            let (i, j) = (stable[i], stable[j]);
            let sum = values[i] + values[j].conj();
            -rows(i, j) / if conjugate { sum.conj() } else { sum }
        })
    };
    let reach = gramian(&|i, j| (0..b.ncols()).map(|k| b[(i, k)] * b[(j, k)].conj()).sum(), false);
    let observe = gramian(&|i, j| (0..c.nrows()).map(|k| c[(k, i)].conj() * c[(k, j)]).sum(), true);
    let pairs: Vec<bool> = stable.iter().map(|&place| values[place].im != 0.0).collect();
    [to_real(&reach, &pairs, false), to_real(&observe, &pairs, true)]
}

/// `S G S*` with `S = [[1, 1], [i, −i]]` for each pair, or with its inverse's adjoint, which is half of it.
fn to_real(complex: &DMatrix<Complex<f64>>, pairs: &[bool], observe: bool) -> DMatrix<f64> {
    let n = pairs.len();
    let mut change = DMatrix::<Complex<f64>>::zeros(n, n);
    let (one, i) = (Complex::new(1.0, 0.0), Complex::new(0.0, 1.0));
    let factor = if observe { 0.5 } else { 1.0 };
    let mut k = 0;
    while k < n {
        if pairs[k] {
            (change[(k, k)], change[(k, k + 1)]) = (one * factor, one * factor);
            (change[(k + 1, k)], change[(k + 1, k + 1)]) = (i * factor, -i * factor);
            k += 2;
        } else {
            change[(k, k)] = one;
            k += 1;
        }
    }
    (&change * complex * change.adjoint()).map(|value| value.re)
}

/// `L` with `L Lᵀ = G` for a symmetric `G` whose negative eigenvalues are round-off.
fn root(gramian: &DMatrix<f64>) -> DMatrix<f64> {
    let symmetric = (gramian + gramian.transpose()) * 0.5;
    let eigen = symmetric.symmetric_eigen();
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    DMatrix::from_fn(gramian.nrows(), roots.len(), |i, j| eigen.eigenvectors[(i, j)] * roots[j])
}

/// `A` and `B` for samples of `step_s` with inputs held in between, eq. (L20).
///
/// # Errors
/// [`NoReduction::Eigenvalues`] and [`NoReduction::Defective`].
pub fn sampled(model: &StateSpace, step_s: f64) -> Result<(DMatrix<f64>, DMatrix<f64>), NoReduction> {
    let n = model.a.nrows();
    let (modal, to_states) = Modal::new(model)?;
    let from_states = to_states.clone().try_inverse().ok_or(NoReduction::Singular)?;
    let (mut whole, mut held) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for block in &modal.blocks {
        let power = block.eigenvalue * step_s;
        let growth = power.exp();
        // (eᶻ − 1)/z, by its series where the difference would cancel
        let mean = if power.norm() < 1e-4 {
            Complex::from(1.0) + power * (Complex::from(0.5) + power * (Complex::from(1.0 / 6.0) + power / 24.0))
        } else {
            (growth - 1.0) / power
        } * step_s;
        for (matrix, value) in [(&mut whole, growth), (&mut held, mean)] {
            let k = block.first;
            (k..k + block.size()).for_each(|i| matrix[(i, i)] = value.re);
            if block.size() == 2 {
                (matrix[(k, k + 1)], matrix[(k + 1, k)]) = (value.im, -value.im);
            }
        }
    }
    Ok((&to_states * whole * from_states, to_states * held * modal.b))
}

#[cfg(test)]
#[path = "reduction_tests.rs"]
mod tests;
