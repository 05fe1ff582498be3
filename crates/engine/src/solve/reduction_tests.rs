use super::*;
use crate::solve::complex_factors::ComplexFactors;

/// Damped oscillators side by side, frequency (1/s) and damping ratio each, between two inputs and two outputs.
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

/// `C (iω − A)⁻¹ B + D`.
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

/// Largest singular value of the difference over a grid that holds every resonance.
fn largest_error(whole: &StateSpace, part: &StateSpace, modes: &[(f64, f64)]) -> f64 {
    let grid = (0..400).map(|i| 10f64.powf(-2.0 + 8.0 * f64::from(i) / 399.0));
    let errors = grid
        .chain(modes.iter().map(|mode| mode.0))
        .map(|frequency| (gain(whole, frequency) - gain(part, frequency)).singular_values().max());
    errors.fold(0.0, f64::max)
}

const MODES: &[(f64, f64)] = &[(3.0, 0.02), (11.0, 0.05), (40.0, 0.01), (700.0, 0.3), (2e4, 1.5), (9e5, 0.01)];

/// The error stays below the bound and comes within a small factor of it, the gain at rest is kept, and all states are no reduction.
#[test]
fn errors_stay_below_their_bounds() {
    let whole = chain(MODES);
    for keep in [Keep::Modes, Keep::Balanced] {
        for order in [2, 4, 6, 9, 12] {
            let Reduced { model, error_bound, .. } = reduce(&whole, order, keep).unwrap();
            let (error, bound) = (largest_error(&whole, &model, MODES), error_bound.unwrap());
            let scale = gain(&whole, 3.0).norm();
            // fewer than asked for where the rest is round-off
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

/// `1/(s + a)` has the Hankel singular value `1/(2a)`.
#[test]
fn first_order_lag_has_its_hankel_singular_value() {
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let model = StateSpace { a: one(-4.0), b: one(1.0), c: one(1.0), d: one(0.0) };
    let reduced = reduce(&model, 1, Keep::Balanced).unwrap();
    assert!((reduced.hankel[0] - 0.125).abs() < 1e-15 && reduced.error_bound == Some(0.0), "{reduced:?}");
}

/// Motions that grow or stay are kept whole, and asking for fewer states is refused with their number.
#[test]
fn what_does_not_decay_stays() {
    let modes = [(0.5, -0.1), (7.0, 0.02), (30.0, 0.1), (80.0, 0.1)];
    let whole = chain(&modes);
    let reduced = reduce(&whole, 4, Keep::Balanced).unwrap();
    assert_eq!(reduced.hankel.iter().filter(|value| value.is_infinite()).count(), 2);
    let grows = eigen(&reduced.model.a).unwrap().values.into_iter().filter(|value| value.re > 0.0).count();
    assert_eq!(grows, 2);
    let refused = reduce(&whole, 1, Keep::Balanced).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "1 states cannot be kept: allowed are 2 to 8, as motions that do not decay stay whole"
    );
    assert!(matches!(reduce(&whole, 9, Keep::Modes), Err(NoReduction::Order { .. })));
    assert_eq!(reduce(&whole, 6, Keep::Modes).unwrap().model.a.nrows(), 6);
}

/// A free mass has one vector for two eigenvalues.
#[test]
fn free_body_is_refused_by_name() {
    let mut whole = chain(&[(5.0, 0.1)]);
    whole.a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
    assert!(matches!(reduce(&whole, 1, Keep::Modes), Err(NoReduction::Defective { .. })));
    assert!(matches!(sampled(&whole, 0.1), Err(NoReduction::Defective { .. })));
}

/// Samples of an undamped oscillator are those of sine and cosine, beside a mode 10⁵ times faster.
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
}
