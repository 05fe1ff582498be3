//! Reduction of linear models by modal and by balanced truncation, and discretisation in time, NOTATION eqs. (L18)–(L20).

use crate::solve::complex_factors::ComplexFactors;
use crate::solve::eigen::{Eigen, eigen};
use crate::solve::linearize::StateSpace;
use crate::solve::reduction_accuracy::{Accuracy, Dropped, Measure, even_scales, responding};
use nalgebra::{Complex, DMatrix, DVector, SVD};
use std::f64::consts::TAU;

type ComplexMatrix = DMatrix<Complex<f64>>;

/// Kind of reduction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// Keeps the slowest modes.
    Modes,
    /// Keeps the states with the largest contribution from the inputs to the outputs.
    Balanced,
}

/// A model with fewer states.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduced {
    /// The reduced model, with the static gain of the whole model.
    pub model: StateSpace,
    /// Bound on the largest singular value of the error over all frequencies. `None` if a motion that does not decay was omitted, and for
    /// the reduction in a frequency band.
    pub error_bound: Option<f64>,
    /// Error in a range of frequencies: the band or, without a band, the range up to the fastest mode that was kept. `None` in discrete
    /// time without a band.
    pub accuracy: Option<Accuracy>,
    /// Hankel singular values for balanced scales of inputs and outputs, largest first; infinite for states of motions that do not decay.
    /// Empty for modal truncation.
    pub hankel: Vec<f64>,
}

/// Reason why a model cannot be reduced or sampled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoReduction {
    /// The eigenvalue iteration failed.
    #[error("the eigenvalues of A cannot be computed")]
    Eigenvalues,
    /// Equal eigenvalues with equal eigenvectors.
    #[error(
        "the eigenvectors of A are almost linearly dependent (condition number {condition:.1e}); choose another state"
    )]
    Defective {
        /// Condition number of the eigenvectors.
        condition: f64,
    },
    /// The requested number of states is too small or too large.
    #[error("{order} states cannot be kept: allowed are {least} to {most}{}", if *.least > 1 { ", because motions that \
         do not decay must be kept" } else { "" })]
    Order {
        /// Requested order.
        order: usize,
        /// Minimum number of states.
        least: usize,
        /// Number of all states.
        most: usize,
    },
    /// Balanced truncation in discrete time is not possible for a model with motions that do not decay.
    #[error(
        "the model has motions that do not decay, which balanced truncation in discrete time cannot reduce; choose a \
         state below the flutter speed, or lock the free joints"
    )]
    Grows,
    /// Modal truncation in discrete time: the modes of the wake cannot be ordered.
    #[error("discrete-time models can be reduced by balanced truncation only, not by modal truncation")]
    SampledModes,
    /// A band with an end outside the frequency range of the model.
    #[error(
        "the upper end of the frequency band must be above 0 Hz, and in discrete time below half the sampling rate"
    )]
    Band,
    /// Modal truncation in a frequency band.
    #[error("only balanced truncation can be limited to a frequency band; modal truncation keeps the slowest modes")]
    ModalBand,
    /// A matrix in an intermediate step is singular.
    #[error("the balanced realisation cannot be computed; keep more states, or use modal truncation")]
    Singular,
}

/// Condition number of the eigenvectors above which half of all digits are lost.
const MAXIMUM_CONDITION: f64 = 1e9;
/// Fraction of `|λ|` below which the real part of an eigenvalue is round-off: the motion does not decay.
const NO_DECAY: f64 = 1e-10;
/// Ratio to the largest Hankel singular value below which the others are round-off of the Gramians.
const ROUND_OFF: f64 = 1e-9;
/// Eigenvalue, relative to the largest, below which a motion may be a rigid-body mode: a double zero is accurate to half the digits.
const STILL: f64 = 1e-6;
/// Singular value, relative to the largest, below which it is round-off.
const NULL: f64 = 1e-13;
/// Number of frequencies at which the error is evaluated, in addition to all resonances: half of them on a linear scale, half on a
/// logarithmic scale.
const MEASURED: usize = 200;
/// Start of the logarithmic scale, relative to its end, if the range has no slowest mode.
const SLOWEST: f64 = 1e-4;
/// Relative distance within which an eigenvalue of the reduced model corresponds to one of the whole model.
const SAME: f64 = 0.03;

/// A model in real modal form: blocks of one or two states, slowest first.
#[derive(Clone)]
struct Modal {
    blocks: Vec<Block>,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    /// Number of states of rigid-body modes, which come first; their block of `A` is full.
    still: usize,
}

/// One real eigenvalue, or a complex pair, represented by the eigenvalue with positive imaginary part.
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
    /// Modal form of a model whose states are first scaled by powers of two that balance rows and columns of `A`. Rigid-body modes, whose
    /// eigenvectors coincide, come first and are not transformed: blocks of one state each with the eigenvalue 0.
    fn new(model: &StateSpace) -> Result<(Self, DMatrix<f64>), NoReduction> {
        let n = model.a.nrows();
        let (scaled, scale) = balanced_rows(&model.a);
        let (split, still) = still_first(&scaled)?;
        let back = split.clone().try_inverse().ok_or(NoReduction::Singular)?;
        let within = &back * &scaled * &split;
        let rest = n - still;
        let moving = within.view((still, still), (rest, rest)).into_owned();
        let Eigen { values, vectors } = eigen(&moving).ok_or(NoReduction::Eigenvalues)?;
        let mut starts: Vec<usize> = (0..rest).filter(|&i| values[i].im >= 0.0).collect();
        starts.sort_by(|&i, &j| values[i].norm().total_cmp(&values[j].norm()));
        let columns = starts.iter().flat_map(|&i| if values[i].im == 0.0 { vec![i] } else { vec![i, i + 1] });
        let vectors = vectors.select_columns(&columns.collect::<Vec<_>>());
        let inverse = vectors.clone().try_inverse().ok_or(NoReduction::Defective { condition: f64::INFINITY })?;
        let condition = vectors.norm() * inverse.norm();
        if !condition.is_finite() || condition > MAXIMUM_CONDITION * n as f64 {
            return Err(NoReduction::Defective { condition });
        }
        let mut a = DMatrix::zeros(n, n);
        a.view_mut((0, 0), (still, still)).copy_from(&within.view((0, 0), (still, still)));
        let at_rest = |first: usize| Block { first, eigenvalue: Complex::new(0.0, 0.0) };
        let mut blocks: Vec<Block> = (0..still).map(at_rest).collect();
        let mut first = still;
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
        // x = S (N, Y V) z
        let mut out = split;
        let moved = out.columns(still, rest) * vectors;
        out.columns_mut(still, rest).copy_from(&moved);
        let mut into = back;
        let moved = inverse * into.rows(still, rest);
        into.rows_mut(still, rest).copy_from(&moved);
        let to_states = DMatrix::from_fn(n, n, |i, j| scale[i] * out[(i, j)]);
        let from_states = DMatrix::from_fn(n, n, |i, j| into[(i, j)] / scale[j]);
        let (b, c) = (&from_states * &model.b, &model.c * &to_states);
        Ok((Self { blocks, a, b, c, still }, to_states))
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

/// A basis whose first columns span the rigid-body modes, `Aᵏ x = 0` for some `k`, and whose other columns span the rest, both invariant,
/// and the number of the first columns.
fn still_first(a: &DMatrix<f64>) -> Result<(DMatrix<f64>, usize), NoReduction> {
    let n = a.nrows();
    let whole = DMatrix::identity(n, n);
    let sizes: Vec<f64> = eigen(a).ok_or(NoReduction::Eigenvalues)?.values.iter().map(|value| value.norm()).collect();
    let fastest = sizes.iter().copied().fold(0.0, f64::max);
    if sizes.iter().all(|size| *size > STILL * fastest) && fastest > 0.0 {
        return Ok((whole, 0));
    }
    let right = null_space(a)?;
    let left = null_space(&a.transpose())?;
    let still = right.ncols();
    if still == 0 || left.ncols() != still {
        return Ok((whole, 0));
    }
    // components orthogonal to the left null vectors
    let mut rest = whole;
    for column in left.column_iter() {
        let along = column.transpose() * &rest;
        rest -= column * along;
    }
    let svd = SVD::try_new(rest, true, false, f64::EPSILON, 0).ok_or(NoReduction::Singular)?;
    let u = svd.u.ok_or(NoReduction::Singular)?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
    let mut basis = DMatrix::zeros(n, n);
    basis.columns_mut(0, still).copy_from(&right);
    basis.columns_mut(still, n - still).copy_from(&u.select_columns(&order[..n - still]));
    Ok((basis, still))
}

/// Orthonormal vectors that span `Aᵏ x = 0` for some `k`: repeatedly adds those that `A` maps into the span of the previous ones.
fn null_space(a: &DMatrix<f64>) -> Result<DMatrix<f64>, NoReduction> {
    let mut found = DMatrix::zeros(a.nrows(), 0);
    loop {
        let mut beside = a.clone();
        for column in found.column_iter() {
            let column: DVector<f64> = column.into_owned();
            let along = column.transpose() * &beside;
            beside -= column * along;
        }
        let svd = SVD::try_new(beside, false, true, f64::EPSILON, 0).ok_or(NoReduction::Singular)?;
        let rows = svd.v_t.ok_or(NoReduction::Singular)?;
        let limit = NULL * a.nrows() as f64 * a.norm();
        let null: Vec<usize> = (0..rows.nrows()).filter(|&i| svd.singular_values[i] <= limit).collect();
        if null.len() <= found.ncols() {
            return Ok(found);
        }
        found = rows.select_rows(&null).transpose();
    }
}

/// `A` with rows and columns balanced by powers of two, and the scale of each state: `diag(1/s) A diag(s)`.
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

/// Reduces a model to `order` states, eqs. (L18) and (L19). Modal truncation keeps one less instead of splitting a pair. Balanced
/// truncation, with balanced scales of inputs and outputs, covers all frequencies or a band from 0 to `up_to_hz`, eq. (L37); in a band it
/// may keep fewer states, so that the reduced model is as stable as the whole model.
///
/// # Errors
/// [`NoReduction`], with the allowed orders.
pub fn reduce(model: &StateSpace, order: usize, keep: Keep, up_to_hz: Option<f64>) -> Result<Reduced, NoReduction> {
    let most = model.a.nrows();
    if order == 0 || order > most {
        return Err(NoReduction::Order { order, least: 1, most });
    }
    // written so that NaN is an error
    if up_to_hz.is_some_and(|up_to_hz| !(up_to_hz > 0.0 && up_to_hz.is_finite())) {
        return Err(NoReduction::Band);
    }
    let (modal, _) = Modal::new(model)?;
    if keep == Keep::Modes {
        if up_to_hz.is_some() {
            return Err(NoReduction::ModalBand);
        }
        return slowest(&modal, &model.d, order);
    }
    let end_1_s = up_to_hz.map(|up_to_hz| up_to_hz * TAU);
    let gains = modal.gains(&model.d, end_1_s);
    let [inputs, outputs] = even_scales(&gains);
    let mut even = modal.clone();
    even.b.column_iter_mut().zip(&inputs).for_each(|(mut column, scale)| column *= *scale);
    even.c.row_iter_mut().zip(&outputs).for_each(|(mut row, scale)| row *= *scale);
    let d = DMatrix::from_fn(model.d.nrows(), model.d.ncols(), |i, j| model.d[(i, j)] * outputs[i] * inputs[j]);
    let mut reduced = balanced(&even, &d, order, end_1_s)?;
    let small = &mut reduced.model;
    small.b.column_iter_mut().zip(&inputs).for_each(|(mut column, scale)| column /= *scale);
    small.c.row_iter_mut().zip(&outputs).for_each(|(mut row, scale)| row /= *scale);
    for (i, output) in outputs.iter().enumerate() {
        for (j, input) in inputs.iter().enumerate() {
            small.d[(i, j)] /= output * input;
        }
    }
    // the bound applies to balanced scales: convert it to output units per input unit
    let least = |scales: &[f64]| scales.iter().copied().fold(f64::INFINITY, f64::min);
    let unit = least(&inputs) * least(&outputs);
    reduced.error_bound = reduced.error_bound.map(|bound| if bound > 0.0 { bound / unit } else { 0.0 });
    let whole = modal.blocks.iter().filter(|block| !block.decays()).map(|block| block.size()).sum();
    reduced.accuracy = Some(modal.accuracy(&model.d, &reduced.model, whole, up_to_hz));
    Ok(reduced)
}

/// Keeps the slowest modes; the others are residualised, eq. (L18).
fn slowest(modal: &Modal, d: &DMatrix<f64>, order: usize) -> Result<Reduced, NoReduction> {
    if order < modal.still {
        return Err(NoReduction::Order { order, least: modal.still, most: modal.a.nrows() });
    }
    let whole_d = d;
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
    let accuracy = modal.accuracy_without(whole_d, &model.d, states);
    Ok(Reduced { model, error_bound: bound, accuracy: Some(accuracy), hankel: Vec::new() })
}

/// Balanced truncation, eq. (L19): motions that do not decay are kept completely, and of the others the states with the largest Hankel
/// singular values; the rest is residualised (singular perturbation), which preserves the static gain and the bound.
///
/// For a band that ends at `end_1_s` the Gramians are frequency-limited; states are omitted until all remaining ones decay.
fn balanced(modal: &Modal, d: &DMatrix<f64>, order: usize, end_1_s: Option<f64>) -> Result<Reduced, NoReduction> {
    let places = |decays: bool| -> Vec<usize> {
        let blocks = modal.blocks.iter().filter(|block| block.decays() == decays);
        blocks.flat_map(|block| block.first..block.first + block.size()).collect()
    };
    let (whole, stable) = (places(false), places(true));
    if order < whole.len() {
        return Err(NoReduction::Order { order, least: whole.len(), most: modal.a.nrows() });
    }
    let [reach, observe] = gramians(modal, &stable, end_1_s);
    let [left, right] = [root(&observe), root(&reach)];
    let svd = SVD::try_new(left.transpose() * &right, true, true, f64::EPSILON, 0).ok_or(NoReduction::Singular)?;
    let (Some(u), Some(vt)) = (&svd.u, &svd.v_t) else { return Err(NoReduction::Singular) };
    let mut rank: Vec<usize> = (0..svd.singular_values.len()).collect();
    rank.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
    let hankel: Vec<f64> = rank.iter().map(|&i| svd.singular_values[i]).collect();
    let largest = hankel.first().copied().unwrap_or(0.0);
    let sound = hankel.iter().take_while(|&&value| value > ROUND_OFF * largest && value > 0.0).count();
    let scaled =
        |matrix: DMatrix<f64>| DMatrix::from_fn(matrix.nrows(), sound, |i, j| matrix[(i, rank[j])] / hankel[j].sqrt());
    let (into, out) = (scaled(&left * u), scaled(&right * vt.transpose()));
    let block = |rows: &[usize], columns: &[usize]| modal.a.select_rows(rows).select_columns(columns);
    let a = into.transpose() * block(&stable, &stable) * &out;
    let b = into.transpose() * modal.b.select_rows(&stable);
    let c = modal.c.select_columns(&stable) * &out;
    let most = (order - whole.len()).min(sound);
    let (kept, a_slow, b_slow, c_slow) = (0..=most)
        .rev()
        .map(|kept| follow_at_once([&a, &b, &c], kept, sound).map(|[a, b, c]| (kept, a, b, c)))
        .find(|found| match found {
            Ok((kept, a, ..)) => *kept == 0 || end_1_s.is_none() || decays(a),
            Err(_) => end_1_s.is_none(),
        })
        .unwrap_or(Err(NoReduction::Singular))?;
    // computed from the static gain, because the states with small singular values have few accurate digits
    let (values, by_input, seen) = modal.complex();
    let mut d = DMatrix::from_fn(d.nrows(), d.ncols(), |i, j| {
        d[(i, j)] - stable.iter().map(|&k| (seen[(i, k)] * by_input[(k, j)] / values[k]).re).sum::<f64>()
    });
    if kept > 0 {
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
    let error_bound = end_1_s.is_none().then(|| 2.0 * hankel[kept..].iter().sum::<f64>());
    let hankel = std::iter::repeat_n(f64::INFINITY, whole.len()).chain(hankel).collect();
    Ok(Reduced { model, error_bound, accuracy: None, hankel })
}

/// Keeps the first `kept` of `sound` states; the others are residualised.
fn follow_at_once([a, b, c]: [&DMatrix<f64>; 3], kept: usize, sound: usize) -> Result<[DMatrix<f64>; 3], NoReduction> {
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
    Ok([a_slow, b_slow, c_slow])
}

/// Whether all motions decay.
fn decays(a: &DMatrix<f64>) -> bool {
    eigen(a).is_some_and(|found| found.values.iter().all(|value| value.re < 0.0))
}

/// Gramians of the stable part in real modal coordinates, in closed form from those in complex coordinates: `P_ij = −b_i b̄_j/(λ_i +
/// λ̄_j)`; for a band that ends at `Ω` multiplied by `s_i + s̄_j`, `s = ln((iΩ − λ)/(−iΩ − λ))/2πi`.
fn gramians(modal: &Modal, stable: &[usize], end_1_s: Option<f64>) -> [DMatrix<f64>; 2] {
    let share = |value: Complex<f64>| match end_1_s {
        None => Complex::from(0.5),
        Some(end_1_s) => {
            let end = Complex::new(0.0, end_1_s);
            // separate logarithms: their difference may exceed the principal range of a single one
            ((end - value).ln() - (-end - value).ln()) / Complex::new(0.0, TAU)
        }
    };
    let (values, b, c) = modal.complex();
    let n = stable.len();
    let gramian = |rows: &dyn Fn(usize, usize) -> Complex<f64>, conjugate: bool| {
        DMatrix::from_fn(n, n, |i, j| {
            let (i, j) = (stable[i], stable[j]);
            let sum = values[i] + values[j].conj();
            let shares = share(values[i]) + share(values[j]).conj();
            let [sum, shares] = if conjugate { [sum.conj(), shares.conj()] } else { [sum, shares] };
            -rows(i, j) * shares / sum
        })
    };
    let reach = gramian(&|i, j| (0..b.ncols()).map(|k| b[(i, k)] * b[(j, k)].conj()).sum(), false);
    let observe = gramian(&|i, j| (0..c.nrows()).map(|k| c[(k, i)].conj() * c[(k, j)]).sum(), true);
    let pairs: Vec<bool> = stable.iter().map(|&place| values[place].im != 0.0).collect();
    [to_real(&reach, &pairs, false), to_real(&observe, &pairs, true)]
}

/// `S G S*` with `S = [[1, 1], [i, −i]]` for each pair, or with the adjoint of its inverse, which is half of it.
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

impl Modal {
    /// Frequencies in 1/s at which errors are evaluated, from 0 to `end_1_s`, including resonances.
    fn grid(&self, end_1_s: f64) -> Vec<f64> {
        let resonances = self.blocks.iter().map(|block| block.eigenvalue).filter(|value| value.norm() > 0.0);
        let resonances: Vec<f64> = resonances.flat_map(|value| [value.norm(), value.im]).collect();
        let slowest = resonances.iter().copied().filter(|at| *at > 0.0).fold(end_1_s, f64::min).max(SLOWEST * end_1_s);
        let half = MEASURED / 2;
        let even = (0..=half).map(|i| end_1_s * i as f64 / half as f64);
        let logarithmic = (0..half).map(|i| slowest * (end_1_s / slowest).powf(i as f64 / half as f64));
        even.chain(logarithmic).chain(resonances.iter().copied().filter(|at| *at > 0.0 && *at <= end_1_s)).collect()
    }

    /// Sum of the frequency responses of some states at a frequency in 1/s.
    fn answer(
        parts: &(Vec<Complex<f64>>, ComplexMatrix, ComplexMatrix),
        states: &[usize],
        at_1_s: f64,
    ) -> ComplexMatrix {
        let (values, b, c) = parts;
        let mut behind = DMatrix::zeros(states.len(), b.ncols());
        for (row, &k) in states.iter().enumerate() {
            let factor = (Complex::new(0.0, at_1_s) - values[k]).inv();
            (0..b.ncols()).for_each(|j| behind[(row, j)] = b[(k, j)] * factor);
        }
        c.select_columns(states) * behind
    }

    /// States of motions that decay.
    fn decaying(&self) -> Vec<usize> {
        let blocks = self.blocks.iter().filter(|block| block.decays());
        blocks.flat_map(|block| block.first..block.first + block.size()).collect()
    }

    /// Largest gains in a band or over all frequencies, without the contribution of motions that do not decay.
    fn gains(&self, d: &DMatrix<f64>, end_1_s: Option<f64>) -> DMatrix<f64> {
        let (parts, states) = (self.complex(), self.decaying());
        let fastest = self.blocks.iter().map(|block| block.eigenvalue.norm()).fold(0.0, f64::max);
        let mut measure = Measure::new(d.nrows(), d.ncols());
        let (direct, none) = (d.map(Complex::from), DMatrix::zeros(d.nrows(), d.ncols()));
        for at_1_s in self.grid(end_1_s.unwrap_or(fastest)) {
            measure.add(at_1_s / TAU, &(Self::answer(&parts, &states, at_1_s) + &direct), &none);
        }
        measure.gains().clone()
    }

    /// Error of a reduced model whose first `whole` states are the unchanged states of motions that do not decay.
    fn accuracy(&self, d: &DMatrix<f64>, small: &StateSpace, whole: usize, up_to_hz: Option<f64>) -> Accuracy {
        let n = small.a.nrows() - whole;
        let a = small.a.view((whole, whole), (n, n)).into_owned();
        let (b, c) = (small.b.rows(whole, n).map(Complex::from), small.c.columns(whole, n).map(Complex::from));
        let own = eigen(&a).map_or(Vec::new(), |found| found.values);
        let fastest = own.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let end_1_s = up_to_hz.map_or(fastest, |up_to_hz| up_to_hz * TAU);
        let (parts, states) = (self.complex(), self.decaying());
        let mut measure = Measure::new(d.nrows(), d.ncols());
        let direct = d.map(Complex::from);
        let mut places = self.grid(end_1_s);
        places.extend(own.iter().flat_map(|value| [value.norm(), value.im]).filter(|at| *at > 0.0 && *at <= end_1_s));
        for at_1_s in places {
            let gain = Self::answer(&parts, &states, at_1_s) + &direct;
            let entry = |i: usize, j: usize| Complex::new(-a[(i, j)], if i == j { at_1_s } else { 0.0 });
            let factors = ComplexFactors::new(n, entry);
            let mut found = small.d.map(Complex::from);
            for (j, column) in b.column_iter().enumerate() {
                let mut target = found.column_mut(j);
                target += &c * factors.solve(&column.into_owned());
            }
            measure.add(at_1_s / TAU, &gain, &(&gain - found));
        }
        let kept = |value: Complex<f64>| own.iter().any(|own| (own - value).norm() <= SAME * value.norm());
        let dropped = self.dropped(end_1_s, measure.gains(), &parts, |block| !kept(block.eigenvalue));
        measure.accuracy(end_1_s / TAU, 0.0, dropped)
    }

    /// Error of the model truncated to its first `kept` states, which are modes, with another `d`.
    fn accuracy_without(&self, d: &DMatrix<f64>, other_d: &DMatrix<f64>, kept: usize) -> Accuracy {
        let parts = self.complex();
        let (decaying, rest) = (self.decaying(), (kept..self.a.nrows()).collect::<Vec<_>>());
        let ends = self.blocks.iter().filter(|block| block.first < kept).map(|block| block.eigenvalue.norm());
        let end_1_s = ends.fold(0.0, f64::max);
        let mut measure = Measure::new(d.nrows(), d.ncols());
        let (direct, moved) = (d.map(Complex::from), (d - other_d).map(Complex::from));
        for at_1_s in self.grid(end_1_s) {
            let gain = Self::answer(&parts, &decaying, at_1_s) + &direct;
            measure.add(at_1_s / TAU, &gain, &(Self::answer(&parts, &rest, at_1_s) + &moved));
        }
        let dropped = self.dropped(end_1_s, measure.gains(), &parts, |block| block.first >= kept);
        measure.accuracy(end_1_s / TAU, 0.0, dropped)
    }

    /// Omitted modes up to a frequency that contribute to the response of some output to some input.
    fn dropped(
        &self,
        end_1_s: f64,
        gains: &DMatrix<f64>,
        (_, b, c): &(Vec<Complex<f64>>, ComplexMatrix, ComplexMatrix),
        left_out: impl Fn(&Block) -> bool,
    ) -> Vec<Dropped> {
        let responds = responding(gains);
        let within = self.blocks.iter().filter(|block| block.decays() && block.eigenvalue.norm() <= end_1_s);
        let share = |block: &Block| {
            let k = block.first;
            let mut most = 0.0f64;
            for i in 0..gains.nrows() {
                for j in (0..gains.ncols()).filter(|&j| responds[(i, j)]) {
                    let peak = (c[(i, k)] * b[(k, j)]).norm() / -block.eigenvalue.re;
                    most = most.max(peak / gains[(i, j)]);
                }
            }
            Dropped { eigenvalue_1_s: block.eigenvalue, share: most }
        };
        within.filter(|block| left_out(block)).map(share).filter(|dropped| dropped.share > Accuracy::SEEN).collect()
    }
}

/// Discretises `A` and `B` with a sampling time of `step_s` and inputs held in between, eq. (L20).
///
/// # Errors
/// [`NoReduction::Eigenvalues`] and [`NoReduction::Defective`], if the eigenvalues or eigenvectors cannot be used.
pub fn sampled(model: &StateSpace, step_s: f64) -> Result<(DMatrix<f64>, DMatrix<f64>), NoReduction> {
    let n = model.a.nrows();
    let (modal, to_states) = Modal::new(model)?;
    let from_states = to_states.clone().try_inverse().ok_or(NoReduction::Singular)?;
    let (mut whole, mut held) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let still = modal.still;
    // exp of [[A, 1], [0, 0]] h: the series is finite for rigid-body modes
    let mut series = DMatrix::zeros(2 * still, 2 * still);
    series.view_mut((0, 0), (still, still)).copy_from(&(modal.a.view((0, 0), (still, still)) * step_s));
    series.view_mut((0, still), (still, still)).copy_from(&(DMatrix::identity(still, still) * step_s));
    let series = series.exp();
    whole.view_mut((0, 0), (still, still)).copy_from(&series.view((0, 0), (still, still)));
    held.view_mut((0, 0), (still, still)).copy_from(&series.view((0, still), (still, still)));
    for block in &modal.blocks[still..] {
        let power = block.eigenvalue * step_s;
        let growth = power.exp();
        // (eᶻ − 1)/z, by its series if the difference would cancel
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
