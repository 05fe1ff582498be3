//! Derivatives by central differences of functions with kinks, such as polars, which are linear between their rows: NOTATION eq. (W14).

/// Golden ratio between consecutive steps: they have no common divisor, so equally spaced kinks (rows of a polar) cannot escape detection
/// by falling between all of them.
const RATIO: f64 = 1.618_033_988_749_895;
/// The three difference steps, relative to the first.
pub const STEPS: [f64; 3] = [1.0, RATIO, RATIO * RATIO];
/// Weights of the central differences over these steps for a derivative of sixth order; `LOWER` uses the first two steps and has fourth
/// order: `w_i = Π_{j ≠ i} x_j² / (x_j² - x_i²)`.
const WEIGHTS: [f64; 3] = [1.894_427_190_999_916, -1.0, 0.105_572_809_000_084];
const LOWER: [f64; 3] = [RATIO, 1.0 - RATIO, 0.0];
/// Weights of the sixth difference: they multiply the sum of the changes on both sides. For smooth functions it is of the sixth power of
/// the step; a kink at `d` steps with the jump `J` of the derivative gives `(5.24 - 9.47 d) J` steps, for `d` from 1 `(8.47 d - 12.71)
/// J`, from 1.62 `(2.62 - d) J`.
const BEND: [f64; 3] = [17.944_271_909_999_16, -9.472_135_954_999_58, 1.0];
/// Number of steps by which the sixth difference is divided to estimate the error of a derivative: a kink at the instant gives `J / 2`.
const BEND_OVER: f64 = 10.472_135_954_999_58;
/// Largest error of a derivative, relative to the derivative, for which the steps are taken to contain no kink.
const CROOKED: f64 = 1e-7;
/// Smallest derivative to which this error is referred, relative to the largest of the same kind: smaller ones are round-off of the
/// largest.
const SMALL: f64 = 1e-2;
/// Round-off of a value relative to its magnitude, including the digits lost in the solution that gives it.
const LOST: f64 = 32.0 * f64::EPSILON;
/// Number of attempts to find steps without a kink, and the factor of the step from one attempt to the next.
const ROUNDS: usize = 4;
const SHORTER: f64 = 0.05;

/// Computes derivatives by sixth-order central differences. Polars have kinks: if the steps cross one, they are shortened until they do
/// not; for a kink at the instant itself the result is the mean of the derivatives on both sides.
///
/// `answer(shift, side)` fills in the response at a shifted argument, `present` is the response without a shift. `kinds` gives the kind of
/// each row: rows of one kind have the same unit and similar magnitudes. Each row uses the attempt with its smallest error, because a
/// kink may affect the load of one section only, and small rows would not show next to large ones. The error estimate adds the difference
/// of the sixth- and fourth-order results, which does not detect a kink next to the instant or at 1.41 steps, and the sixth difference,
/// which does not detect one at 0.55 or 1.5 steps.
pub fn slope_off_corners(
    first_step: f64,
    kinds: &[usize],
    present: &[f64],
    mut answer: impl FnMut(f64, &mut [f64]),
) -> Vec<f64> {
    let rows = kinds.len();
    let mut sides = [(); 2].map(|()| vec![0.0; rows]);
    let (mut best, mut least) = (vec![0.0; rows], vec![f64::NAN; rows]);
    let mut step = first_step;
    for _ in 0..ROUNDS {
        let (mut slope, mut lower, mut lost) = (vec![0.0; rows], vec![0.0; rows], vec![0.0f64; rows]);
        let mut bend = vec![0.0; rows];
        for (i, place) in STEPS.iter().enumerate() {
            for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                answer(sign * place * step, side);
            }
            let [share, lower_share] = [WEIGHTS[i], LOWER[i]].map(|weight| weight / (2.0 * place * step));
            let bend_share = BEND[i] / (BEND_OVER * step);
            for (row, (above, below)) in sides[0].iter().zip(&sides[1]).enumerate() {
                slope[row] += share * (above - below);
                lower[row] += lower_share * (above - below);
                bend[row] += bend_share * ((above - present[row]) + (below - present[row]));
                // also if the values are equal, because the steps may be too short for this row
                lost[row] = lost[row].max(LOST * above.abs().max(below.abs()) / step);
            }
        }
        let mut largest = vec![0.0f64; kinds.iter().max().map_or(0, |last| last + 1)];
        for (kind, slope) in kinds.iter().zip(&slope) {
            largest[*kind] = largest[*kind].max(slope.abs());
        }
        let mut is_smooth = true;
        for row in 0..rows {
            let apart = (slope[row] - lower[row]).abs() + bend[row].abs();
            let allowed = CROOKED * slope[row].abs().max(SMALL * largest[kinds[row]]);
            is_smooth &= apart <= allowed.max(lost[row]);
            // the round-off error grows as the steps shrink
            let error = apart + lost[row];
            if least[row].is_nan() || error < least[row] {
                (best[row], least[row]) = (slope[row], error);
            }
        }
        if is_smooth {
            break;
        }
        step *= SHORTER;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1e-4;

    fn behind(x: f64, corner: f64) -> f64 {
        (x - corner).max(0.0)
    }

    fn near(slope: &[f64], expected: &[f64], allowed: &[f64]) {
        for (row, ((slope, expected), allowed)) in slope.iter().zip(expected).zip(allowed).enumerate() {
            assert!((slope - expected).abs() < *allowed, "row {row}: {slope} for {expected}");
        }
    }

    /// The weights give the exact derivative of odd powers up to the fifth, and no sixth difference for even powers up to the fourth.
    #[test]
    fn differences_are_of_sixth_order() {
        for power in 1..=6 {
            let of = |weights: &[f64; 3], over: i32| -> f64 {
                weights.iter().zip(STEPS).map(|(weight, x)| weight * x.powi(power - over)).sum()
            };
            let [sixth, fourth, bend] = [of(&WEIGHTS, 1), of(&LOWER, 1), of(&BEND, 0)];
            match power {
                1 => assert!((sixth - 1.0).abs() < 1e-14 && (fourth - 1.0).abs() < 1e-14),
                3 => assert!(sixth.abs() < 1e-14 && fourth.abs() < 1e-14),
                5 => assert!(sixth.abs() < 1e-14 && fourth.abs() > 1.0),
                2 | 4 => assert!(bend.abs() < 1e-13, "{power}: {bend}"),
                _ => assert!(bend > 100.0, "{bend}"),
            }
        }
        let corner: f64 = BEND.iter().zip(STEPS).map(|(weight, x)| weight * x).sum();
        assert!((corner - 0.5 * BEND_OVER).abs() < 1e-13, "{corner}");
    }

    /// The error falls with the sixth power of the step.
    #[test]
    fn the_error_has_the_sixth_order() {
        let error = |step: f64| {
            let slope = slope_off_corners(step, &[0], &[0.0], |shift, side| side[0] = shift.sin());
            (slope[0] - 1.0).abs()
        };
        // large enough to exceed round-off, and too small for the steps to be shortened
        let order = (error(0.042) / error(0.028)).log(1.5);
        assert!((5.8..6.2).contains(&order), "{order}");
    }

    /// LR-14. A small row next to a large one of its kind avoids its own kink, although the largest row does not show it; a small row
    /// that is alone in its kind is judged by its own size; a row at a kink, which is smooth for no step, does not affect steps and
    /// accuracy of the others.
    #[test]
    fn each_row_has_steps_without_its_corners() {
        // the kink between the second and the third step would change the derivative by a hundredth of 1e-3: 1e-8 of the largest
        // derivative
        let slope = slope_off_corners(STEP, &[0, 0], &[0.0, 1.0], |shift, side| {
            side[0] = 1e3 * shift.sin();
            side[1] = 1.0 + 0.3 * shift + 1e-3 * behind(shift, 2.1 * STEP);
        });
        // tolerance: ten times the round-off at a twentieth of the step
        near(&slope, &[1e3, 0.3], &[1e-7, 1e-9]);
        let slope = slope_off_corners(STEP, &[0, 1], &[0.0, 1.5e-6 * STEP], |shift, side| {
            side[0] = 1e3 * shift.sin();
            side[1] = 1e-6 * (shift + behind(shift, -1.5 * STEP));
        });
        near(&slope, &[1e3, 2e-6], &[1e-7, 1e-15]);
        let slope = slope_off_corners(STEP, &[0, 0], &[0.0, 1.0], |shift, side| {
            side[0] = behind(shift, 0.0) * (1.0 + shift);
            side[1] = 1.0 + shift.sin();
        });
        near(&slope, &[0.5, 1.0], &[1e-6, 1e-11]);
        // a row whose values are equal over the shortest steps, which the other row needs, must not be treated as constant
        let slope = slope_off_corners(STEP, &[0, 1], &[0.0, 1.0], |shift, side| {
            side[0] = behind(shift, 0.0);
            side[1] = 1.0 + 1e-9 * shift;
        });
        // round-off at the first step: 1e-11
        near(&slope, &[0.5, 1e-9], &[1e-6, 5e-11]);
        assert!(slope_off_corners(STEP, &[0], &[0.0], |_, side| side[0] = f64::NAN)[0].is_nan());
    }

    /// LR-14. Small kinks that only one of the two error estimates detects: next to the instant, at 0.55, 1.41 and 1.5 steps.
    #[test]
    fn slight_corners_are_avoided() {
        for steps in [0.01, 0.1, 0.3, 0.5528, 0.6, 1.0, 1.4116, 1.5, 1.8, 2.5] {
            let corner = |shift: f64| 0.3 * shift + 1e-5 * behind(shift, steps * STEP);
            let slope = slope_off_corners(STEP, &[0], &[corner(0.0)], |shift, side| side[0] = corner(shift));
            assert!((slope[0] - 0.3).abs() < 3e-8, "corner at {steps} steps: {} for 0.3", slope[0]);
        }
    }

    /// LR-15. Equally spaced kinks, as in a polar with closely spaced rows, all of which steps in the ratio 1 : 2 : 3 would cross at the
    /// same relative position.
    #[test]
    fn corners_at_equal_distances_are_avoided() {
        for distance in [0.25, 0.5, 1.0, 1.03, 2.0, 3.0] {
            // `place` is 0.3 at the instant; parabolas between the kinks, whose chords all have the slope 0.3
            let ripple = |shift: f64| {
                let place = (shift / (distance * STEP) + 0.3).rem_euclid(1.0);
                0.3 * shift + 1e-3 * distance * STEP * place * (1.0 - place)
            };
            let known = 0.3 + 1e-3 * (1.0 - 2.0 * 0.3);
            let slope = slope_off_corners(STEP, &[0], &[ripple(0.0)], |shift, side| side[0] = ripple(shift));
            assert!((slope[0] - known).abs() < 3e-8, "corners each {distance} steps: {} for {known}", slope[0]);
        }
    }
}
