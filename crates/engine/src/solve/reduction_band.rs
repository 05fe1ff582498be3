//! Balanced truncation of models in discrete time within a band of frequencies, NOTATION eq. (L37).
//!
//! After Gawronski and Juang, Model reduction in limited time and frequency intervals, Int. J. Systems Science 21 (1990), with the
//! Gramians of the band as sums over frequencies (Gosea, Gugercin and Beattie, SIAM J. Sci. Comput. 44, 2022).

use crate::solve::complex_factors::ComplexFactors;
use crate::solve::eigen::eigen;
use crate::solve::linearize::StateSpace;
use crate::solve::reduction::{Keep, NoReduction, Reduced};
use crate::solve::reduction_sampled::reduce_sampled;
use nalgebra::{Complex, DMatrix, DVector, SVD};
use std::f64::consts::PI;

/// States of the model that the whole one is reduced to first, at all frequencies: its error is round-off of the whole model.
const FIRST: usize = 240;
/// Frequencies of the sums.
const FREQUENCIES: usize = 45;
/// Where they end, over the end of the band: the answers stay right up to its end.
const BEYOND: f64 = 1.1;
/// Frequencies at which the error is measured.
const MEASURED: usize = 201;
/// Hankel singular values, relative to the largest, that are round-off.
const ROUND_OFF: f64 = 1e-12;

/// A model for a band of frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct InBand {
    /// The model. It has no bound on its error.
    pub reduced: Reduced,
    /// Largest error in the band, over the largest answer in the band of the same output to the same input.
    pub error_in_band: f64,
}

/// A model with at most `order` states that answers like `model` to motions that turn by up to `turn_rad` in a sample; it is stable, for
/// which it may have fewer states.
///
/// # Errors
/// As [`reduce_sampled`], and [`NoReduction::Band`].
pub fn reduce_in_band(model: &StateSpace, order: usize, turn_rad: f64) -> Result<InBand, NoReduction> {
    let most = model.a.nrows();
    if order == 0 || order > most {
        return Err(NoReduction::Order { order, least: 1, most });
    }
    // written so that NaN is refused
    if !(turn_rad > 0.0 && turn_rad < PI) {
        return Err(NoReduction::Band);
    }
    let first = reduce_sampled(model, FIRST.min(most), Keep::Balanced)?;
    let (bound, model) = (first.error_bound.unwrap_or(0.0), first.model);
    let end_rad = (BEYOND * turn_rad).min(PI);
    let places = (0..FREQUENCIES).map(|i| end_rad * i as f64 / (FREQUENCIES - 1) as f64);
    let answers: Vec<_> = places.map(|turn| answer(&model, turn)).collect();
    let gains = largest(answers.iter().map(|(gain, ..)| gain));
    let [inputs, outputs] = even_scales(&gains);
    let (mut reach, mut observe) = (Vec::new(), Vec::new());
    for (_, by_input, by_output) in &answers {
        for (columns, scale, list) in [(by_input, &inputs, &mut reach), (by_output, &outputs, &mut observe)] {
            for (column, scale) in columns.iter().zip(scale) {
                list.push(column.map(|entry| entry.re * scale));
                list.push(column.map(|entry| entry.im * scale));
            }
        }
    }
    let (reach, observe) = (DMatrix::from_columns(&reach), DMatrix::from_columns(&observe));
    let parts = SVD::try_new(observe.transpose() * &reach, true, true, f64::EPSILON, 0).ok_or(NoReduction::Singular)?;
    let (Some(u), Some(vt)) = (&parts.u, &parts.v_t) else { return Err(NoReduction::Singular) };
    let mut rank: Vec<usize> = (0..parts.singular_values.len()).collect();
    rank.sort_by(|&i, &j| parts.singular_values[j].total_cmp(&parts.singular_values[i]));
    let hankel: Vec<f64> = rank.iter().map(|&i| parts.singular_values[i]).collect();
    let sound = hankel.iter().take_while(|&&value| value > ROUND_OFF * hankel[0] && value > 0.0).count();
    for kept in (1..=order.min(sound)).rev() {
        let scaled = |matrix: DMatrix<f64>| {
            DMatrix::from_fn(matrix.nrows(), kept, |i, j| matrix[(i, rank[j])] / hankel[j].sqrt())
        };
        let (into, out) = (scaled(&observe * u), scaled(&reach * vt.transpose()));
        let a = into.transpose() * &model.a * &out;
        let decays = eigen(&a).is_some_and(|found| found.values.iter().all(|value| value.norm() < 1.0));
        if !decays {
            continue;
        }
        let small = StateSpace { a, b: into.transpose() * &model.b, c: &model.c * &out, d: model.d.clone() };
        let places = (0..MEASURED).map(|i| turn_rad * i as f64 / (MEASURED - 1) as f64);
        let pairs: Vec<_> = places.map(|turn| (answer(&model, turn).0, answer(&small, turn).0)).collect();
        let gains = largest(pairs.iter().map(|(gain, _)| gain));
        let left: Vec<_> = pairs.iter().map(|(gain, own)| gain - own).collect();
        let off = largest(left.iter()).zip_map(&gains, |off, gain| if gain > 0.0 { (off + bound) / gain } else { 0.0 });
        let error_in_band = off.iter().copied().fold(0.0, f64::max);
        return Ok(InBand { reduced: Reduced { model: small, error_bound: None, hankel }, error_in_band });
    }
    Err(NoReduction::Singular)
}

type Answer = (DMatrix<Complex<f64>>, Vec<DVector<Complex<f64>>>, Vec<DVector<Complex<f64>>>);

/// Gains at a frequency, states by each input, and states that each output shows.
fn answer(model: &StateSpace, turn_rad: f64) -> Answer {
    let z = Complex::from_polar(1.0, turn_rad);
    let entry = |i: usize, j: usize| Complex::from(-model.a[(i, j)]) + if i == j { z } else { Complex::from(0.0) };
    let factors = ComplexFactors::new(model.a.nrows(), entry);
    let complex = |column: DVector<f64>| column.map(Complex::from);
    let by_input: Vec<_> = model.b.column_iter().map(|b| factors.solve(&complex(b.into_owned()))).collect();
    let by_output: Vec<_> = model.c.row_iter().map(|c| factors.solve_adjoint(&complex(c.transpose()))).collect();
    let c = model.c.map(Complex::from);
    let mut gain = model.d.map(Complex::from);
    for (j, states) in by_input.iter().enumerate() {
        let mut column = gain.column_mut(j);
        column += &c * states;
    }
    (gain, by_input, by_output)
}

/// Largest magnitude of each entry.
fn largest<'a>(mut list: impl Iterator<Item = &'a DMatrix<Complex<f64>>>) -> DMatrix<f64> {
    let first = list.next().map(|gain| gain.map(|entry| entry.norm())).unwrap_or_else(|| DMatrix::zeros(0, 0));
    list.fold(first, |most, gain| most.zip_map(gain, |most, entry| most.max(entry.norm())))
}

/// Factors of inputs and outputs with which the largest gain of each is about 1, whatever the units.
fn even_scales(gains: &DMatrix<f64>) -> [Vec<f64>; 2] {
    let (mut inputs, mut outputs) = (vec![1.0; gains.ncols()], vec![1.0; gains.nrows()]);
    for _ in 0..10 {
        for (i, own) in outputs.iter_mut().enumerate() {
            let most = (0..gains.ncols()).map(|j| gains[(i, j)] * inputs[j]).fold(0.0, f64::max);
            *own = if most > 0.0 { most.recip() } else { 1.0 };
        }
        for (j, own) in inputs.iter_mut().enumerate() {
            let most = (0..gains.nrows()).map(|i| gains[(i, j)] * outputs[i]).fold(0.0, f64::max);
            *own = if most > 0.0 { most.recip() } else { 1.0 };
        }
    }
    [inputs, outputs]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve swinging states, six of them above the band: six states for the band answer in it as the whole model, while six of all
    /// frequencies do not. Inputs and outputs have units a million apart.
    #[test]
    fn states_go_where_the_band_is() {
        let turns: [f64; 6] = [0.02, 0.05, 0.09, 0.7, 1.3, 2.2];
        let n = 2 * turns.len();
        let (mut a, mut b, mut c) = (DMatrix::zeros(n, n), DMatrix::zeros(n, 2), DMatrix::zeros(2, n));
        for (k, turn) in turns.iter().enumerate() {
            let (sine, cosine) = turn.sin_cos();
            let decay = if k < 3 { 0.999 } else { 0.9999 };
            a.view_mut((2 * k, 2 * k), (2, 2))
                .copy_from(&(DMatrix::from_row_slice(2, 2, &[cosine, sine, -sine, cosine]) * decay));
            let size = if k < 3 { 1.0 } else { 3.0 };
            (b[(2 * k, 0)], b[(2 * k + 1, 1)]) = (size, 1e-6 * size);
            (c[(0, 2 * k)], c[(1, 2 * k + 1)]) = (1.0, 1e6 / (1.0 + k as f64));
        }
        let model = StateSpace { a, b, c, d: DMatrix::zeros(2, 2) };
        let band = reduce_in_band(&model, 8, 0.12).unwrap();
        let own = |small: &StateSpace| {
            let places = (0..=300).map(|i| 0.12 * f64::from(i) / 300.0);
            let pairs: Vec<_> = places.map(|turn| (answer(&model, turn).0, answer(small, turn).0)).collect();
            let gains = largest(pairs.iter().map(|(gain, _)| gain));
            let left: Vec<_> = pairs.iter().map(|(gain, own)| gain - own).collect();
            largest(left.iter()).zip_map(&gains, |off, gain| off / gain).max()
        };
        let plain = reduce_sampled(&model, 8, Keep::Balanced).unwrap();
        let (in_band, everywhere) = (own(&band.reduced.model), own(&plain.model));
        // two states are left for what the six fast ones do in the band: a percent
        assert!(in_band < 2e-2 && everywhere > 0.1, "{in_band:e} {everywhere:e}");
        // measured at other frequencies
        assert!((in_band / band.error_in_band - 1.0).abs() < 0.05, "{in_band:e} {:e}", band.error_in_band);
        for turn_rad in [0.0, -1.0, f64::NAN, 3.2] {
            assert_eq!(reduce_in_band(&model, 8, turn_rad), Err(NoReduction::Band));
        }
    }
}
