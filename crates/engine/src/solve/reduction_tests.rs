use super::*;
use crate::solve::complex_factors::ComplexFactors;

/// Independent damped oscillators with the given frequencies (1/s) and damping ratios, between two inputs and two outputs.
fn chain(modes: &[(f64, f64)]) -> StateSpace {
    let n = modes.len();
    let mut a = DMatrix::zeros(2 * n, 2 * n);
    for (i, (frequency, ratio)) in modes.iter().enumerate() {
        a[(i, n + i)] = 1.0;
        a[(n + i, i)] = -frequency * frequency;
        a[(n + i, n + i)] = -2.0 * ratio * frequency;
    }
    let b = DMatrix::from_fn(2 * n, 2, |i, j| if i < n { 0.0 } else { 1.0 + 0.3 * (i * (j + 2) % 5) as f64 });
    let c = DMatrix::from_fn(2, 2 * n, |i, j| if j < n { 1.0 - 0.2 * (j * (i + 1) % 4) as f64 } else { 0.0 });
    StateSpace { a, b, c, d: DMatrix::from_element(2, 2, 0.01) }
}

/// Frequency response `C (iω − A)⁻¹ B + D`.
fn gain(model: &StateSpace, frequency_1_s: f64) -> DMatrix<Complex<f64>> {
    let n = model.a.nrows();
    let factors =
        ComplexFactors::new(n, |i, j| Complex::new(-model.a[(i, j)], if i == j { frequency_1_s } else { 0.0 }));
    DMatrix::from_fn(model.d.nrows(), model.d.ncols(), |i, j| {
        let states = factors.solve(&model.b.column(j).map(Complex::from));
        let seen: Complex<f64> = (0..n).map(|k| states[k] * model.c[(i, k)]).sum();
        seen + model.d[(i, j)]
    })
}

/// Largest singular value of the difference over a grid that contains every resonance.
fn largest_error(whole: &StateSpace, part: &StateSpace, modes: &[(f64, f64)]) -> f64 {
    let grid = (0..400).map(|i| 10f64.powf(-2.0 + 8.0 * f64::from(i) / 399.0));
    let errors = grid
        .chain(modes.iter().map(|mode| mode.0))
        .map(|frequency| (gain(whole, frequency) - gain(part, frequency)).singular_values().max());
    errors.fold(0.0, f64::max)
}

const MODES: &[(f64, f64)] = &[(3.0, 0.02), (11.0, 0.05), (40.0, 0.01), (700.0, 0.3), (2e4, 1.5), (9e5, 0.01)];

/// The error is below the bound and within a small factor of it, the static gain is preserved, and with all states the model is unchanged.
#[test]
fn errors_stay_below_their_bounds() {
    let whole = chain(MODES);
    for keep in [Keep::Modes, Keep::Balanced] {
        for order in [2, 4, 6, 9, 12] {
            let Reduced { model, error_bound, .. } = reduce(&whole, order, keep, None).unwrap();
            let (error, bound) = (largest_error(&whole, &model, MODES), error_bound.unwrap());
            let scale = gain(&whole, 3.0).norm();
            // fewer than requested if the remaining states are round-off
            let states = model.a.nrows();
            assert!(
                states <= order && (states + 2 > order || bound < 1e-9 * scale),
                "{keep:?} {order}: {states}, {bound:e}"
            );
            assert!(error <= bound + 1e-9 * scale, "{keep:?} {order}: {error:e} above {bound:e}");
            assert!(bound <= 12.0 * error + 1e-7 * scale, "{keep:?} {order}: {error:e} far below {bound:e}");
            let at_rest = (gain(&whole, 0.0) - gain(&model, 0.0)).norm();
            assert!(at_rest < 1e-10 * scale, "{keep:?} {order}: {at_rest:e} of {scale:e} at rest");
        }
    }
}

/// `1/(s + a)` has the Hankel singular value `1/(2a)`, half of its largest gain, which is 1 on balanced scales.
#[test]
fn first_order_lag_has_its_hankel_singular_value() {
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let model = StateSpace { a: one(-4.0), b: one(1.0), c: one(1.0), d: one(0.0) };
    let reduced = reduce(&model, 1, Keep::Balanced, None).unwrap();
    assert!((reduced.hankel[0] - 0.5).abs() < 1e-12 && reduced.error_bound == Some(0.0), "{reduced:?}");
}

/// Motions that grow or are constant are kept completely, and a request for fewer states is an error with their number.
#[test]
fn what_does_not_decay_stays() {
    let modes = [(0.5, -0.1), (7.0, 0.02), (30.0, 0.1), (80.0, 0.1)];
    let whole = chain(&modes);
    let reduced = reduce(&whole, 4, Keep::Balanced, None).unwrap();
    assert_eq!(reduced.hankel.iter().filter(|value| value.is_infinite()).count(), 2);
    let grows = eigen(&reduced.model.a).unwrap().values.into_iter().filter(|value| value.re > 0.0).count();
    assert_eq!(grows, 2);
    let refused = reduce(&whole, 1, Keep::Balanced, None).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "1 states cannot be kept: allowed are 2 to 8, because motions that do not decay must be kept"
    );
    assert!(matches!(reduce(&whole, 9, Keep::Modes, None), Err(NoReduction::Order { .. })));
    assert_eq!(reduce(&whole, 6, Keep::Modes, None).unwrap().model.a.nrows(), 6);
}

/// A free mass has one eigenvector for two eigenvalues: it is kept completely, while modes are reduced, and its samples lie on the exact
/// parabola.
#[test]
fn free_body_is_kept_whole() {
    let modes = [(5.0, 0.1), (60.0, 0.02), (700.0, 0.3)];
    let bent = chain(&modes);
    let n = bent.a.nrows() + 2;
    let mut whole =
        StateSpace { a: DMatrix::zeros(n, n), b: DMatrix::zeros(n, 2), c: DMatrix::zeros(2, n), d: bent.d.clone() };
    whole.a.view_mut((0, 0), (n - 2, n - 2)).copy_from(&bent.a);
    whole.b.rows_mut(0, n - 2).copy_from(&bent.b);
    whole.c.columns_mut(0, n - 2).copy_from(&bent.c);
    whole.a[(n - 2, n - 1)] = 1.0;
    (whole.b[(n - 1, 0)], whole.b[(n - 1, 1)], whole.c[(0, n - 2)], whole.c[(1, n - 2)]) = (0.4, -0.1, 1.0, 0.3);
    for keep in [Keep::Modes, Keep::Balanced] {
        let reduced = reduce(&whole, 6, keep, None).unwrap();
        let scale = gain(&whole, 5.0).norm();
        for frequency_1_s in [1e-3, 0.1, 5.0, 20.0] {
            let off = (gain(&whole, frequency_1_s) - gain(&reduced.model, frequency_1_s)).norm();
            let allowed = reduced.error_bound.unwrap() + 1e-9 * (scale + gain(&whole, frequency_1_s).norm());
            assert!(off <= allowed, "{keep:?} {frequency_1_s}: {off:e} above {allowed:e}");
        }
        let refused = reduce(&whole, 1, keep, None).unwrap_err();
        assert_eq!(refused, NoReduction::Order { order: 1, least: 2, most: n });
    }
    let (a, b) = sampled(&whole, 0.1).unwrap();
    let near = |value: f64, exact: f64| assert!((value - exact).abs() < 1e-12, "{value} against {exact}");
    near(a[(n - 2, n - 1)], 0.1);
    near(b[(n - 2, 0)], 0.5 * 0.4 * 0.01);
    near(b[(n - 1, 1)], -0.1 * 0.1);
}

/// For a band, the states that matter in it are kept: the slow modes, although the fast ones have larger gains. The stated error is the
/// actual one, and the modes in the band that the reduction for all frequencies omits are listed.
#[test]
fn states_go_where_the_band_is() {
    let modes = [(3.0, 0.02), (11.0, 0.05), (40.0, 0.01), (2e3, 1e-3), (7e3, 1e-3), (2e4, 1e-3)];
    let mut whole = chain(&modes);
    // as accelerations, fast modes have gains as large as slow ones, with less damping
    for (i, (frequency, _)) in modes.iter().enumerate() {
        whole.c.column_mut(i).scale_mut(frequency * frequency);
    }
    let (up_to_hz, end_1_s) = (50.0 / TAU, 50.0);
    let band = reduce(&whole, 8, Keep::Balanced, Some(up_to_hz)).unwrap();
    let all = reduce(&whole, 6, Keep::Balanced, None).unwrap();
    let off = |small: &StateSpace| {
        let grid = (0..=800).map(|i| end_1_s * f64::from(i) / 800.0).chain([3.0, 11.0, 40.0]);
        let pairs: Vec<_> = grid.map(|at| (gain(&whole, at), gain(small, at))).collect();
        let mut worst = 0.0f64;
        for k in 0..4 {
            let most = pairs.iter().map(|(own, _)| own[k].norm()).fold(0.0, f64::max);
            worst = pairs.iter().map(|(own, small)| (own[k] - small[k]).norm() / most).fold(worst, f64::max);
        }
        worst
    };
    let stated = band.accuracy.as_ref().unwrap();
    assert_eq!(stated.up_to_hz, up_to_hz);
    assert!(off(&band.model) < 1e-2 && off(&all.model) > 0.5, "{:e} {:e}", off(&band.model), off(&all.model));
    assert!((stated.worst().0 / off(&band.model) - 1.0).abs() < 0.05, "{:e} {:e}", stated.worst().0, off(&band.model));
    assert!(stated.dropped.is_empty() && band.error_bound.is_none());
    let dropped: Vec<f64> = all.accuracy.unwrap().dropped.iter().map(|mode| mode.eigenvalue_1_s.norm()).collect();
    assert!(dropped.iter().any(|at| (at - 40.0).abs() < 1e-9), "{dropped:?}");
    for hertz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(reduce(&whole, 4, Keep::Balanced, Some(hertz)), Err(NoReduction::Band));
    }
    assert_eq!(reduce(&whole, 4, Keep::Modes, Some(3.0)), Err(NoReduction::ModalBand));
}

/// The Gramians of a band equal their frequency integral, evaluated at 20 000 points.
#[test]
fn gramians_of_a_band_are_its_integral() {
    let (modal, _) = Modal::new(&chain(&[(3.0, 0.2), (11.0, 0.3)])).unwrap();
    let stable: Vec<usize> = (0..4).collect();
    let (end_1_s, count) = (7.0, 20_000);
    let [reach, observe] = gramians(&modal, &stable, Some(end_1_s));
    let (mut sum, mut seen) = (DMatrix::zeros(4, 4), DMatrix::zeros(4, 4));
    for i in 0..count {
        let at = -end_1_s + 2.0 * end_1_s * (f64::from(i) + 0.5) / f64::from(count);
        let inverse =
            (DMatrix::identity(4, 4) * Complex::new(0.0, at) - modal.a.map(Complex::from)).try_inverse().unwrap();
        let states = &inverse * modal.b.map(Complex::from);
        let shown = inverse.adjoint() * modal.c.transpose().map(Complex::from);
        let share = 2.0 * end_1_s / f64::from(count) / TAU;
        sum += (&states * states.adjoint()).map(|entry| entry.re * share);
        seen += (&shown * shown.adjoint()).map(|entry| entry.re * share);
    }
    // the midpoint rule has an error of 1e-7 with steps of 7e-4
    assert!((&reach - &sum).amax() < 1e-6 * sum.amax(), "{reach} {sum}");
    assert!((&observe - &seen).amax() < 1e-6 * seen.amax(), "{observe} {seen}");
}

/// Samples of an undamped oscillator equal the sine and cosine, in a model with another mode 10⁵ times faster.
#[test]
fn samples_are_those_of_the_exact_motion() {
    let (slow, step_s) = (3.0f64, 0.1);
    let whole = chain(&[(slow, 0.0), (3e5, 0.02)]);
    let (a, b) = sampled(&whole, step_s).unwrap();
    let (sine, cosine) = (slow * step_s).sin_cos();
    let near = |value: f64, exact: f64| assert!((value - exact).abs() < 1e-12, "{value} against {exact}");
    near(a[(0, 0)], cosine);
    near(a[(0, 2)], sine / slow);
    near(a[(2, 0)], -slow * sine);
    near(b[(0, 0)], whole.b[(2, 0)] * (1.0 - cosine) / (slow * slow));
    near(b[(2, 1)], whole.b[(2, 1)] * sine / slow);
    // a motion of which a sample covers 5e-5 of its time constant: the difference from 1 would cancel
    let creep = StateSpace {
        a: DMatrix::from_element(1, 1, -1e-3),
        b: DMatrix::from_element(1, 1, 2.0),
        c: DMatrix::from_element(1, 1, 1.0),
        d: DMatrix::zeros(1, 1),
    };
    let (a, b) = sampled(&creep, 0.05).unwrap();
    near(a[(0, 0)], (-5e-5f64).exp());
    near(b[(0, 0)], -2.0 * (-5e-5f64).exp_m1() / 1e-3);
}
