//! Balanced truncation of models in discrete time within a band of frequencies, NOTATION eq. (L37).
//!
//! After Gawronski and Juang, Model reduction in limited time and frequency intervals, Int. J. Systems Science 21 (1990), with the
//! frequency-limited Gramians as sums over frequencies (Gosea, Gugercin and Beattie, SIAM J. Sci. Comput. 44, 2022).

use crate::solve::complex_factors::ComplexFactors;
use crate::solve::eigen::eigen;
use crate::solve::linearize::StateSpace;
use crate::solve::reduction::{Keep, NoReduction, Reduced};
use crate::solve::reduction_accuracy::{Measure, even_scales};
use crate::solve::reduction_sampled::reduce_sampled;
use nalgebra::{Complex, DMatrix, DVector, SVD};
use std::f64::consts::{PI, TAU};

/// Number of states of a first reduction of the whole model over all frequencies, whose error is at the round-off of the whole model.
const FIRST: usize = 240;
/// Number of frequencies in the sums.
const FREQUENCIES: usize = 45;
/// End of the sums divided by the end of the band, so that responses are accurate up to the end of the band.
const BEYOND: f64 = 1.1;
/// Number of frequencies at which the error is evaluated.
const MEASURED: usize = 201;
/// Hankel singular values, relative to the largest, below which they are round-off.
const ROUND_OFF: f64 = 1e-12;

/// Reduces a model, sampled at intervals of `step_s`, to at most `order` states such that its responses agree up to a frequency. The result
/// is stable, for which it may have fewer states. Its error over all frequencies has no bound.
///
/// # Errors
/// As for [`reduce_sampled`], and [`NoReduction::Band`].
pub fn reduce_in_band(model: &StateSpace, order: usize, up_to_hz: f64, step_s: f64) -> Result<Reduced, NoReduction> {
    reduce_by(FIRST, model, order, [up_to_hz, step_s])
}

/// Like [`reduce_in_band`], through an intermediate model with `by` states.
fn reduce_by(
    by: usize,
    model: &StateSpace,
    order: usize,
    [up_to_hz, step_s]: [f64; 2],
) -> Result<Reduced, NoReduction> {
    let turn_rad = TAU * up_to_hz * step_s;
    let most = model.a.nrows();
    if order == 0 || order > most {
        return Err(NoReduction::Order { order, least: 1, most });
    }
    // written so that NaN is an error
    if !(turn_rad > 0.0 && turn_rad < PI) {
        return Err(NoReduction::Band);
    }
    let first = reduce_sampled(model, by.min(most), Keep::Balanced)?;
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
        let mut measure = Measure::new(small.c.nrows(), small.b.ncols());
        for turn in places {
            let gain = answer(&model, turn).0;
            let left = &gain - answer(&small, turn).0;
            measure.add(turn / (TAU * step_s), &gain, &left);
        }
        let accuracy = Some(measure.accuracy(up_to_hz, bound, Vec::new()));
        return Ok(Reduced { model: small, error_bound: None, accuracy, hankel });
    }
    Err(NoReduction::Singular)
}

type Answer = (DMatrix<Complex<f64>>, Vec<DVector<Complex<f64>>>, Vec<DVector<Complex<f64>>>);

/// Frequency response at an angle per sample: gains, states due to each input, and outputs due to each state.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Step in s for which the angle per sample in rad equals the frequency in Hz.
    const STEP_S: f64 = 1.0 / TAU;

    fn error_in(reduced: &Reduced) -> f64 {
        reduced.accuracy.as_ref().unwrap().worst().0
    }

    /// Twelve oscillating states, six of them above the band: six states reduced for the band reproduce the whole model in it, while six
    /// states reduced for all frequencies do not. The units of inputs and outputs differ by a factor of a million.
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
        let band = reduce_in_band(&model, 8, 0.12, STEP_S).unwrap();
        let own = |small: &StateSpace| {
            let places = (0..=300).map(|i| 0.12 * f64::from(i) / 300.0);
            let pairs: Vec<_> = places.map(|turn| (answer(&model, turn).0, answer(small, turn).0)).collect();
            let gains = largest(pairs.iter().map(|(gain, _)| gain));
            let left: Vec<_> = pairs.iter().map(|(gain, own)| gain - own).collect();
            largest(left.iter()).zip_map(&gains, |off, gain| off / gain).max()
        };
        let plain = reduce_sampled(&model, 8, Keep::Balanced).unwrap();
        let (in_band, everywhere) = (own(&band.model), own(&plain.model));
        // two states remain to represent the effect of the six fast ones in the band: about one per cent
        assert!(in_band < 2e-2 && everywhere > 0.1, "{in_band:e} {everywhere:e}");
        // evaluated at other frequencies
        assert!((in_band / error_in(&band) - 1.0).abs() < 0.05, "{in_band:e} {:e}", error_in(&band));
        for turn_rad in [0.0, -1.0, f64::NAN, 3.2] {
            assert_eq!(reduce_in_band(&model, 8, turn_rad, STEP_S), Err(NoReduction::Band));
        }
    }

    /// Eight coupled oscillating and decaying states, two inputs, three outputs, direct feedthrough.
    fn coupled() -> StateSpace {
        let mut a =
            DMatrix::from_fn(8, 8, |i, j| if j > i { 0.07 * (1.0 + (3 * i + 5 * j) as f64).sin() } else { 0.0 });
        for (k, (size, turn)) in [(0.98, 0.05_f64), (0.95, 0.3), (0.9, 0.9), (0.7, 2.0)].into_iter().enumerate() {
            let (sine, cosine) = turn.sin_cos();
            a.view_mut((2 * k, 2 * k), (2, 2))
                .copy_from(&(DMatrix::from_row_slice(2, 2, &[cosine, 2.0 * sine, -0.5 * sine, cosine]) * size));
        }
        let wave = |rows, columns, phase: f64| {
            DMatrix::from_fn(rows, columns, |i, j| (phase + 1.3 * i as f64 + 2.1 * j as f64).sin())
        };
        StateSpace { a, b: wave(8, 2, 0.4), c: wave(3, 8, 1.0), d: wave(3, 2, 2.0) }
    }

    /// Largest difference between two models' responses divided by the largest response, at angles inside and outside a band.
    fn apart(one: &StateSpace, other: &StateSpace) -> f64 {
        let turns = [0.0, 0.02, 0.1, 0.33, 0.7, 1.5, 3.0];
        let pairs = turns.map(|turn| (answer(one, turn).0, answer(other, turn).0));
        let largest = pairs.iter().map(|(gain, _)| gain.camax()).fold(0.0, f64::max);
        pairs.iter().map(|(one, other)| (one - other).camax()).fold(0.0, f64::max) / largest
    }

    /// Compares with (L37) evaluated with dense Gramians: sums over 45 frequencies up to 1.1 times the end of the band, and the leading
    /// invariant subspace of their product by Cholesky factors and eigenvectors. Squaring in Gramians halves the number of accurate digits;
    /// the tolerance is a hundred times that.
    #[test]
    fn answers_are_those_of_the_gramians_of_the_band() {
        let (model, turn_rad) = (coupled(), 0.35);
        let n = model.a.nrows();
        let at = |i: usize| Complex::from_polar(1.0, 1.1 * turn_rad * i as f64 / 44.0);
        let complex = |matrix: &DMatrix<f64>| matrix.map(Complex::from);
        let inverse = |z: Complex<f64>| (DMatrix::identity(n, n) * z - complex(&model.a)).try_inverse().unwrap();
        let gains: Vec<_> =
            (0..45).map(|i| complex(&model.c) * inverse(at(i)) * complex(&model.b) + complex(&model.d)).collect();
        let [inputs, outputs] = even_scales(&largest(gains.iter()));
        let inputs = complex(&DMatrix::from_diagonal(&DVector::from_vec(inputs)));
        let outputs = complex(&DMatrix::from_diagonal(&DVector::from_vec(outputs)));
        let (mut reach, mut observe) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        for i in 0..45 {
            let states = inverse(at(i)) * complex(&model.b) * &inputs;
            let shown = inverse(at(i)).adjoint() * complex(&model.c).transpose() * &outputs;
            reach += (&states * states.adjoint()).map(|entry| entry.re);
            observe += (&shown * shown.adjoint()).map(|entry| entry.re);
        }
        let root = reach.cholesky().unwrap().l();
        let parts = (root.transpose() * &observe * &root).symmetric_eigen();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| parts.eigenvalues[j].total_cmp(&parts.eigenvalues[i]));
        for kept in [2, 4, 5] {
            let (leading, values) = (parts.eigenvectors.select_columns(&order[..kept]), &parts.eigenvalues);
            let power =
                |exponent: f64| DMatrix::from_diagonal(&DVector::from_fn(kept, |i, _| values[order[i]].powf(exponent)));
            let out = &root * &leading * power(-0.25);
            let into = &observe * &root * &leading * power(-0.75);
            let known = StateSpace {
                a: into.transpose() * &model.a * &out,
                b: into.transpose() * &model.b,
                c: &model.c * &out,
                d: model.d.clone(),
            };
            let found = reduce_in_band(&model, kept, turn_rad, STEP_S).unwrap().model;
            let (off, left) = (apart(&found, &known), apart(&found, &model));
            assert!(found.a.nrows() == kept && off < 1e-6 && left > 1e3 * off, "{kept}: {off:e} {left:e}");
        }
    }

    /// Units of inputs and outputs have no effect; without scaling they would change the responses by 8e-2. The remaining difference is
    /// round-off of the first reduction, which uses the given units.
    #[test]
    fn units_do_not_matter() {
        let model = coupled();
        let (inputs, outputs) = ([2f64.powi(20), 1.0], [1.0, 2f64.powi(-30), 2f64.powi(8)]);
        let scaled = |model: &StateSpace, sign: i32| {
            let mut scaled = model.clone();
            for (j, input) in inputs.iter().enumerate() {
                scaled.b.column_mut(j).scale_mut(input.powi(sign));
                scaled.d.column_mut(j).scale_mut(input.powi(sign));
            }
            for (i, output) in outputs.iter().enumerate() {
                scaled.c.row_mut(i).scale_mut(output.powi(sign));
                scaled.d.row_mut(i).scale_mut(output.powi(sign));
            }
            scaled
        };
        let own = reduce_in_band(&model, 4, 0.35, STEP_S).unwrap();
        let other = reduce_in_band(&scaled(&model, 1), 4, 0.35, STEP_S).unwrap();
        let off = apart(&own.model, &scaled(&other.model, -1));
        assert!(off < 1e-8, "{off:e}");
    }

    /// A model of three states for this band would grow twelvefold per sample: two states are kept.
    #[test]
    fn states_are_left_out_until_the_rest_decays() {
        let a = [-0.1, 0.6, 0.7, 0.0, 0.7, 0.6, -0.5, 1.3, -0.5, 0.9, 0.4, 0.8, -0.2, -0.4, 0.8, -1.2];
        let model = StateSpace {
            a: DMatrix::from_row_slice(4, 4, &a),
            b: DMatrix::from_column_slice(4, 1, &[0.7, -0.4, 0.3, 1.7]),
            c: DMatrix::from_row_slice(1, 4, &[-0.6, -0.1, -0.2, -0.6]),
            d: DMatrix::zeros(1, 1),
        };
        let found = reduce_in_band(&model, 3, 0.3, STEP_S).unwrap().model;
        let largest = eigen(&found.a).unwrap().values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        assert_eq!(found.a.nrows(), 2);
        assert!(largest < 1.0, "{largest}");
    }

    /// The error of the first reduction is included: if no further states are omitted for the band, its bound is the whole error.
    #[test]
    fn the_error_has_that_of_the_first_reduction_in_it() {
        let model = coupled();
        let bound = reduce_sampled(&model, 5, Keep::Balanced).unwrap().error_bound.unwrap();
        let found = reduce_by(5, &model, 5, [0.35, STEP_S]).unwrap();
        let places = (0..=300).map(|i| 0.35 * f64::from(i) / 300.0);
        let pairs: Vec<_> = places.map(|turn| (answer(&model, turn).0, answer(&found.model, turn).0)).collect();
        let gains = largest(pairs.iter().map(|(gain, _)| gain));
        let left: Vec<_> = pairs.iter().map(|(gain, own)| gain - own).collect();
        let off = largest(left.iter()).zip_map(&gains, |off, gain| off / gain).max();
        assert!(off > 1e-6 && error_in(&found) >= off, "{off:e} {:e}", error_in(&found));
        // gains of the model of five states, whose error is at most the bound
        let whole = bound / gains.min();
        assert!((error_in(&found) / whole - 1.0).abs() < 0.1, "{whole:e} {:e}", error_in(&found));
    }
}
