//! Balanced truncation of models in discrete time, NOTATION eq. (L31).

use crate::solve::linearize::StateSpace;
use crate::solve::reduction::{Keep, NoReduction, Reduced};
use nalgebra::{DMatrix, SVD};

/// Maximum number of doublings of the terms of a Gramian: a motion that has not decayed after 2^30 samples is treated as undamped.
const DOUBLINGS: usize = 30;
/// Relative change of a Gramian at which it has converged.
const COMPLETE: f64 = 1e-15;
/// Fraction of a state's diagonal entry of the Gramian that is round-off.
const RANK: f64 = 1e-14;
/// Hankel singular values, relative to the largest, below which they are round-off of the Gramians.
const ROUND_OFF: f64 = 1e-9;

/// Reduces a model to at most `order` states: the balanced states with the largest Hankel singular values. At every frequency the error is
/// at most twice the sum of the other singular values.
///
/// # Errors
/// [`NoReduction`], also for models with motions that do not decay and for [`Keep::Modes`].
pub fn reduce_sampled(model: &StateSpace, order: usize, keep: Keep) -> Result<Reduced, NoReduction> {
    let most = model.a.nrows();
    if order == 0 || order > most {
        return Err(NoReduction::Order { order, least: 1, most });
    }
    if keep == Keep::Modes {
        return Err(NoReduction::SampledModes);
    }
    let right = root(&gramian(&model.a, &model.b)?);
    let left = root(&gramian(&model.a.transpose(), &model.c.transpose())?);
    let svd = SVD::try_new(left.transpose() * &right, true, true, f64::EPSILON, 0).ok_or(NoReduction::Singular)?;
    let (Some(u), Some(vt)) = (&svd.u, &svd.v_t) else { return Err(NoReduction::Singular) };
    let mut rank: Vec<usize> = (0..svd.singular_values.len()).collect();
    rank.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
    let hankel: Vec<f64> = rank.iter().map(|&i| svd.singular_values[i]).collect();
    let largest = hankel.first().copied().unwrap_or(0.0);
    let sound = hankel.iter().take_while(|&&value| value > ROUND_OFF * largest && value > 0.0).count();
    let kept = order.min(sound);
    let scaled =
        |matrix: DMatrix<f64>| DMatrix::from_fn(matrix.nrows(), kept, |i, j| matrix[(i, rank[j])] / hankel[j].sqrt());
    let (into, out) = (scaled(&left * u), scaled(&right * vt.transpose()));
    let model = StateSpace {
        a: into.transpose() * (&model.a * &out),
        b: into.transpose() * &model.b,
        c: &model.c * &out,
        d: model.d.clone(),
    };
    let error_bound = Some(2.0 * hankel[kept..].iter().sum::<f64>());
    Ok(Reduced { model, error_bound, accuracy: None, hankel })
}

/// Gramian `Σ Aᵏ B Bᵀ Aᵏᵀ`, by doubling the number of terms.
fn gramian(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<DMatrix<f64>, NoReduction> {
    let mut sum = b * b.transpose();
    let mut power = a.clone();
    for _ in 0..DOUBLINGS {
        let more = &power * &sum * power.transpose();
        let (change, size) = (more.diagonal().amax(), sum.diagonal().amax());
        if !change.is_finite() {
            return Err(NoReduction::Grows);
        }
        // each state relative to its scale
        let complete = (0..sum.nrows())
            .all(|i| more[(i, i)] <= COMPLETE * sum[(i, i)] || more[(i, i)] <= f64::MIN_POSITIVE * size);
        sum += more;
        if complete {
            return Ok(sum);
        }
        power = &power * &power;
    }
    Err(NoReduction::Grows)
}

/// `L` with `L Lᵀ = G`, with as many columns as the rank of `G`: Cholesky factor with pivoting, on the scale of each state.
fn root(gramian: &DMatrix<f64>) -> DMatrix<f64> {
    let n = gramian.nrows();
    let scale: Vec<f64> = (0..n).map(|i| gramian[(i, i)].max(0.0).sqrt()).collect();
    let entry = |i: usize, j: usize| {
        let size = scale[i] * scale[j];
        if size > 0.0 { gramian[(i, j)] / size } else { 0.0 }
    };
    let mut rest: Vec<f64> = (0..n).map(|i| entry(i, i)).collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    while columns.len() < n {
        let Some(pivot) = (0..n).max_by(|&i, &j| rest[i].total_cmp(&rest[j])) else { break };
        if rest[pivot] <= RANK * n as f64 {
            break;
        }
        let size = rest[pivot].sqrt();
        let mut column: Vec<f64> = (0..n).map(|i| entry(i, pivot)).collect();
        for before in &columns {
            let factor = before[pivot];
            column.iter_mut().zip(before).for_each(|(entry, before)| *entry -= factor * before);
        }
        for (rest, entry) in rest.iter_mut().zip(&mut column) {
            *entry /= size;
            *rest -= *entry * *entry;
        }
        rest[pivot] = 0.0;
        columns.push(column);
    }
    DMatrix::from_fn(n, columns.len(), |i, j| columns[j][i] * scale[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    /// An oscillating state, a fast one and a delay of five samples: with three states the error is within the bound, with all of them the
    /// model is exact.
    #[test]
    fn error_stays_below_the_bound() {
        let n = 8;
        let mut a = DMatrix::zeros(n, n);
        let (sine, cosine) = 0.3f64.sin_cos();
        a.view_mut((0, 0), (2, 2)).copy_from(&(DMatrix::from_row_slice(2, 2, &[cosine, sine, -sine, cosine]) * 0.98));
        a[(2, 2)] = 0.2;
        (4..n).for_each(|i| a[(i, i - 1)] = 1.0);
        a[(0, n - 1)] = 0.05;
        let b = DMatrix::from_fn(n, 1, |i, _| [0.1, 1.0, 1.0, 1.0].get(i).copied().unwrap_or(0.0));
        let c = DMatrix::from_fn(1, n, |_, i| [1.0, 0.0, 0.1].get(i).copied().unwrap_or(0.0));
        let model = StateSpace { a, b, c, d: DMatrix::from_element(1, 1, 0.5) };
        let answer = |model: &StateSpace, turn: f64| {
            let z = Complex::new(0.0, turn).exp();
            let m = model.a.nrows();
            let matrix = DMatrix::<Complex<f64>>::identity(m, m) * z - model.a.map(Complex::from);
            let x = matrix.lu().solve(&model.b.map(Complex::from)).unwrap();
            (model.c.map(Complex::from) * x)[0] + model.d[(0, 0)]
        };
        for order in [1, 3, 5, 8] {
            let reduced = reduce_sampled(&model, order, Keep::Balanced).unwrap();
            let off = (0..=100)
                .map(|i| 0.0314159 * f64::from(i))
                .map(|turn| (answer(&model, turn) - answer(&reduced.model, turn)).norm());
            let (off, bound) = (off.fold(0.0, f64::max), reduced.error_bound.unwrap());
            // with all states, the error is the square root of round-off
            assert!(off <= bound + 1e-8 && (order < 8 || off < 1e-7), "{order}: {off} {bound}");
        }
        // the number of states does not depend on the units of inputs and outputs
        let small = StateSpace { b: &model.b * 1e-6, c: &model.c * 1e-6, ..model.clone() };
        let [states, of_small] =
            [&model, &small].map(|model| reduce_sampled(model, 8, Keep::Balanced).unwrap().model.a.nrows());
        assert_eq!(states, of_small);
        let growing = StateSpace { a: &model.a * 1.05, ..model.clone() };
        assert_eq!(reduce_sampled(&growing, 3, Keep::Balanced), Err(NoReduction::Grows));
        assert_eq!(reduce_sampled(&model, 3, Keep::Modes), Err(NoReduction::SampledModes));
        assert!(matches!(reduce_sampled(&model, 9, Keep::Balanced), Err(NoReduction::Order { .. })));
    }
}
